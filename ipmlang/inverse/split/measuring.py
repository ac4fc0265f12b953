"""Sizes that printing asks for: how far symbols reach, and which need a scope of their own size.

Takes a scheme; gives columns over its symbols. Nothing is rounded or printed here.
"""

from __future__ import annotations

import numpy as np

from ipmlang.inverse.frames import Floats, around
from ipmlang.inverse.split.expansion import placements
from ipmlang.inverse.split.scheme import Item, Octant, Place, Rule, Scheme, Split, Terminal


def reaches(scheme: Scheme) -> Floats:
    """(n,) how far what each symbol draws gets from its origin, at most."""
    boxes = extents(scheme)
    return np.asarray(np.linalg.norm(np.maximum(-boxes[:, 0], boxes[:, 1]), axis=1))


def extents(scheme: Scheme) -> Floats:
    """(n, 2, 3) a box around what each symbol draws, in its own coordinates."""
    boxes = np.zeros((len(scheme.symbols), 2, 3))
    for number, symbol in enumerate(scheme.symbols):
        boxes[number, 1] = symbol.size
        if isinstance(symbol, Rule):
            boxes[number] = _extent(symbol, boxes)
        else:
            boxes[number] += symbol.low
    return boxes


def _extent(rule: Rule, boxes: Floats) -> Floats:
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for item in rule.items:
        for symbol, frames in placements(item):
            if len(frames):
                begin, end = around(frames, *boxes[symbol])
                low = np.minimum(low, begin.min(axis=0))
                high = np.maximum(high, end.max(axis=0))
    if not np.isfinite(low).all():
        low, high = np.zeros(3), np.asarray(rule.size, np.float64)
    return np.stack([low, high])


def needing_size(scheme: Scheme, small: float) -> dict[int, Floats]:
    """Symbols whose scope has to be as large as they say wherever they are placed freely: what is
    split, cut by octants, or followed. The axiom stands in a box of its size.
    """
    found: dict[int, Floats] = {}
    for number, symbol in enumerate(scheme.symbols):
        if isinstance(symbol, Terminal) or number == scheme.axiom:
            continue
        if any(_asks(item) for item in symbol.items):
            found[number] = symbol.size
    return found if small >= 0 else {}


def in_cells(scheme: Scheme) -> set[int]:
    """Symbols that stand in a cell somewhere, which gives them their scope."""
    return {
        cell.symbol
        for symbol in scheme.symbols
        for item in (symbol.items if isinstance(symbol, Rule) else ())
        if isinstance(item, Split)
        for cell in item.cells
        if cell.symbol is not None
    }


def _asks(item: Item) -> bool:
    """Whether what an item draws hangs on the scope."""
    return isinstance(item, Split | Octant) or (
        isinstance(item, Place) and (item.margins is not None or bool(item.anchors))
    )


def is_stretched(scheme: Scheme) -> bool:
    """Whether some symbol is stretched where it is placed."""
    rules = (symbol for symbol in scheme.symbols if isinstance(symbol, Rule))
    return any(
        isinstance(item, Place) and item.stretch is not None
        for rule in rules
        for item in rule.items
    )
