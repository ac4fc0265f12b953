"""What stands beyond the floors or bays that repeat keeps its distance from the far end.

In go schemes with splits, out come the same with cornices, roofs and chimneys placed from the end
of the scope where the scope is what a person changes to get more floors or bays. At the first size
nothing is drawn otherwise.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.frames import Floats, around, identity
from ipmlang.inverse.split.changing import on_symbols
from ipmlang.inverse.split.expansion import placements
from ipmlang.inverse.split.growing import follows, growing, in_other_scopes
from ipmlang.inverse.split.measuring import extents
from ipmlang.inverse.split.scheme import Item, Octant, Place, Rule, Scheme, Split, Symbol


def anchored(scheme: Scheme, small: float) -> Scheme:
    """The scheme with what stands beyond cells that repeat anchored to the end; small: units by
    which it may reach back.
    """
    grows, boxes = growing(scheme), extents(scheme)
    elsewhere = in_other_scopes(scheme)
    made: list[Symbol] = []
    numbers: dict[int, int] = {}
    for number, symbol in enumerate(scheme.symbols):
        if isinstance(symbol, Rule):
            items = [on_symbols(item, numbers) for item in symbol.items]
            axes = grows.axes[number] & (~grows.counted[number] | _followed(symbol))
            if axes.any() and number not in elsewhere:
                end = grows.ranges[number][1]
                known = axes & np.isfinite(end)
                limit = np.where(known, end - small, np.inf)
                beyond = [_beyond(item, boxes, limit) for item in symbol.items]
                items = list(_anchored(made, symbol, items, beyond))
            symbol = replace(symbol, items=tuple(items))
        numbers[number] = len(made)
        made.append(symbol)
    return replace(scheme, symbols=tuple(made))


def _followed(rule: Rule) -> NDArray[np.bool_]:
    """(3,) the axes along which something in a rule follows its scope already."""
    return np.array([any(follows(item, axis) for item in rule.items) for axis in range(3)])


def _beyond(item: Item, boxes: Floats, limit: Floats) -> frozenset[int]:
    """The axes along which all that an item draws lies beyond a limit (3,)."""
    if isinstance(item, Split | Octant):
        return frozenset()
    low = np.full(3, np.inf)
    for symbol, frames in placements(item):
        begin, _ = around(frames, *boxes[symbol])
        low = np.minimum(low, begin.min(axis=0, initial=np.inf))
    return frozenset(np.flatnonzero(low >= limit).tolist())


def _anchored(
    made: list[Symbol], rule: Rule, items: list[Item], beyond: list[frozenset[int]]
) -> Iterator[Item]:
    """The items of a rule; what is anchored alike and follows no scope is a rule of its own."""
    groups: dict[frozenset[int], list[Item]] = {}
    for item, axes in zip(items, beyond, strict=True):
        if not axes:
            yield item
        elif isinstance(item, Place) and item.stretch is not None:
            yield replace(item, anchors=axes)
        else:
            groups.setdefault(axes, []).append(item)
    for axes, alike in groups.items():
        made.append(Rule("Top" if axes == {2} else "End", rule.size, tuple(alike)))
        yield Place(len(made) - 1, identity(), anchors=axes)
