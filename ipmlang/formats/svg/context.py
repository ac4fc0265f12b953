"""What the steps of reading share: the source with its styles, and where in the drawing one stands.

`Source` is one parsed file. `Context` is what an element inherits from whatever draws it: map to
the world, style, viewport, enclosing effects. Frozen; a child's context is a changed copy.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from ipmlang.formats.drawing import Effect, Fragment, Outline, Paint, Style
from ipmlang.formats.svg.cascade import Cascade, Computed
from ipmlang.formats.svg.limits import Limits, Notes
from ipmlang.formats.svg.transforms import (
    IDENTITY,
    Box,
    Matrix,
    about,
    multiply,
    parse_origin,
    parse_transform,
)
from ipmlang.formats.svg.xml import Document, Node

Colored: TypeAlias = tuple[Paint, float]
"""A paint and its alpha."""


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """One parsed file, its styles, its bounds, and the notes that reading it collects.

    left_out: elements whose conditions do not hold; blends: some element has a blend mode.
    """

    document: Document
    cascade: Cascade
    limits: Limits
    notes: Notes
    left_out: frozenset[Node]
    blends: bool


@dataclass(slots=True, eq=False)
class Wrap:
    """One instance of a group effect.

    `mergeable`: two runs next to each other may be wrapped as one without a change. `viewport`: the
    box of a viewport that only clips what sticks out of it.
    """

    effect: Effect
    mergeable: bool
    viewport: Box | None = None


@dataclass(slots=True, eq=False)
class Placed:
    """An outline (in its own space) or fragment, its map to the world, and what goes with it.

    `reach`: a box in its own space that surely holds a fragment, None where nobody knows.
    """

    outline: Outline | None
    fragment: Fragment | None
    matrix: Matrix
    style: Style
    wraps: tuple[Wrap, ...]
    source: tuple[str, ...]
    line: int | None = None
    reach: Box | None = None


class Context(NamedTuple):
    """What surrounds an element.

    `request`: the size that a `use` asks of the viewport it refers to, None when no `use` refers to
    the element itself. `active`: nodes that may not be used again below this one.
    `paints`: what context-fill and context-stroke mean inside a marker.
    """

    style: Computed
    viewport: tuple[float, float]
    matrix: Matrix = IDENTITY
    wraps: tuple[Wrap, ...] = ()
    names: tuple[str, ...] = ()
    active: frozenset[Node] = frozenset()
    request: tuple[float | None, float | None] | None = None
    paints: tuple[Colored, Colored] | None = None


def own_transform(
    style: Computed,
    viewport: tuple[float, float],
    box: Callable[[], Box | None],
    notes: Notes,
    line: int | None,
) -> Matrix:
    """The map that an element's own `transform`, `transform-origin` and `transform-box` make.

    `box` gives the element's bounding box, or None for what has none (groups).
    """
    text = style.own.get("transform")
    if not text:
        return IDENTITY
    reference: Box = (0.0, 0.0, viewport[0], viewport[1])
    origin = style.own.get("transform-origin")
    if style.own.get("transform-box") in ("fill-box", "content-box", "stroke-box", "border-box"):
        own_box = box()
        if own_box is None:
            notes.add("transform-box", "transform-box of a group is read as view-box", line)
        reference = own_box or reference
        origin = origin or "0 0"
    matrix = parse_transform(text, reference)
    if matrix is None:
        notes.add("transform", f"`{text[:40]}` is no transform and is left out", line)
        return IDENTITY
    point = parse_origin(origin, reference) if origin else None
    return matrix if point is None else about(matrix, *point)


def placed_by(matrix: Matrix, step: Matrix) -> Matrix:
    """`matrix` after `step`, quick where `step` is nothing."""
    return matrix if step is IDENTITY else multiply(matrix, step)
