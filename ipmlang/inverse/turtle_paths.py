"""Paths of many parts that a turtle drew among other things, lifting its pen: each is one thing.

Takes a drawing as it was read, before its compound paths are taken apart; says which of these a
recursion draws as a whole. Bounds come before work. A path that is all there is stays out of this:
what one turtle drew of a whole drawing is found by looking at its lines.
"""

from __future__ import annotations

import numpy as np

from ipmlang.formats.drawing import Drawing, DrawnElement
from ipmlang.inverse.pages import Page, folded
from ipmlang.inverse.stretches import is_regular, is_turtles

FEWEST = 24  # lines of a path that is worth a rule
PARTS = 4  # of it at least
MOST = 8  # paths that are looked at, the longest


def turtle_paths(drawing: Drawing) -> frozenset[int]:
    """The numbers of the elements that stay whole."""
    found: frozenset[int] = frozenset()
    if len(drawing.elements) < 2:
        return found
    likely = [number for number, each in enumerate(drawing.elements) if _may_be(each)]
    if not likely:
        return found
    page = _page(drawing)
    likely.sort(key=lambda number: -_lines(drawing.elements[number]))
    return frozenset(number for number in likely[:MOST] if _is_drawn(drawing, number, page))


def _lines(element: DrawnElement) -> int:
    return 0 if element.outline is None else len(element.outline.kind)


def _may_be(element: DrawnElement) -> bool:
    outline = element.outline
    if outline is None or len(outline.closed) < PARTS or len(outline.kind) < FEWEST:
        return False
    return element.style.fill == "none" and is_turtles(outline, element.style)


def _page(drawing: Drawing) -> Page:
    if drawing.box is not None and 0 < np.hypot(*drawing.box[2:]) < np.inf:
        _, top, _, height = drawing.box
        return Page(float(np.hypot(*drawing.box[2:])), 2 * top + height, True)
    every = [each.outline.coords[:, 0] for each in drawing.elements if each.outline is not None]
    points = np.concatenate(every)
    return Page(float(np.hypot(*np.ptp(points, axis=0))) or 1.0, 0.0, False)


def _is_drawn(drawing: Drawing, number: int, page: Page) -> bool:
    """Whether a recursion draws a path."""
    outline = drawing.elements[number].outline
    assert outline is not None
    points = outline.coords[:, :2, 0] + 1j * (page.flip - outline.coords[:, :2, 1])
    start, end = points[:, 0].copy(), points[:, 1].copy()
    if not is_regular(start, end):
        return False
    recursion, _ = folded(page, start, end)
    return recursion is not None and not recursion.alternatives
