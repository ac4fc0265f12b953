"""Rings in the coordinates of their axis, where a person would draw what stands around it.

In goes a ring, out comes the frame of its axis; in goes a scheme, out come ways to say it with a
rule that stands in one ring alone drawn in that frame, so that a member is turned and no more.
Nothing is drawn elsewhere than before.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ipmlang.inverse.frames import Frames, canonical, compose, inverse
from ipmlang.inverse.split.scheme import Place, Ring, Rule, Scheme, Split, Symbol

NEAR = 1e-12  # of what is left over of numbers that cancel
DOWN = 1e-9  # from straight down: any turn by 180° will do


def axis_frame(ring: Ring) -> Frames:
    """One frame at the center of a ring, its z along the axis by the shortest turn; upright where
    members do not turn.

    >>> from ipmlang.inverse.frames import identity
    >>> ring = Ring(0, identity(), 4, np.zeros(3), np.array([1.0, 0.0, 0.0]), 90.0)
    >>> axis_frame(ring).rotation.round(3).tolist()
    [[0.707, 0.0, 0.707, 0.0]]
    """
    x, y, z = ring.axis.tolist() if ring.angle else (0.0, 0.0, 1.0)
    turn = np.array([[0.0, 1.0, 0.0, 0.0]] if z < DOWN - 1 else [[1.0 + z, -y, x, 0.0]])
    turn = canonical(turn / np.linalg.norm(turn))
    return Frames(ring.center[None], turn, np.ones(1), np.ones(1))


def first_around(ring: Ring) -> Frames:
    """Where the first member of a ring stands, seen from the axis."""
    return around_axis(ring, ring.first)


def around_axis(ring: Ring, frames: Frames) -> Frames:
    """Frames as seen from the axis of a ring."""
    return tidy(compose(inverse(axis_frame(ring)), frames))


def tidy(frames: Frames) -> Frames:
    """Frames without what is left over of numbers that cancel."""
    rotation = np.where(np.abs(frames.rotation) < NEAR, 0.0, frames.rotation)
    position = np.where(np.abs(frames.position) < NEAR, 0.0, frames.position)
    return replace(frames, rotation=rotation, position=position)


def in_axes(scheme: Scheme) -> Iterator[Scheme]:
    """For each rule that stands in one ring and nowhere else, the scheme with the rule in the frame
    of the ring's axis.
    """
    used = Counter(each for symbol in scheme.symbols for each in _placed(symbol))
    for number, symbol in enumerate(scheme.symbols):
        for place, item in enumerate(symbol.items if isinstance(symbol, Rule) else ()):
            if isinstance(item, Ring) and used[item.symbol] == 1 and _is_rigid(item.first):
                inner = scheme.symbols[item.symbol]
                if isinstance(inner, Rule) and _is_free(inner):
                    yield _in_axis(scheme, number, place, item, inner)


def _is_rigid(frame: Frames) -> bool:
    return abs(float(frame.scale[0]) - 1) <= NEAR


def _placed(symbol: Symbol) -> list[int]:
    """The symbols that the items of a symbol place, once for each item or cell."""
    found: list[int] = []
    for item in symbol.items if isinstance(symbol, Rule) else ():
        if isinstance(item, Split):
            found += [cell.symbol for cell in item.cells if cell.symbol is not None]
        else:
            found.append(item.symbol)
    return found


def _is_free(rule: Rule) -> bool:
    """Whether a rule places copies alone, none of which hang on its scope."""
    return all(
        isinstance(item, Place) and item.stretch is None and not item.anchors for item in rule.items
    )


def _in_axis(scheme: Scheme, number: int, place: int, ring: Ring, inner: Rule) -> Scheme:
    home = first_around(ring)
    moved = tuple(
        replace(item, frames=tidy(compose(home, item.frames)))
        for item in inner.items
        if isinstance(item, Place)
    )
    symbols = list(scheme.symbols)
    outer = symbols[number]
    assert isinstance(outer, Rule)
    again = replace(ring, first=axis_frame(ring))
    items = (*outer.items[:place], again, *outer.items[place + 1 :])
    symbols[ring.symbol] = replace(inner, items=moved)
    symbols[number] = replace(outer, items=items)
    return replace(scheme, symbols=tuple(symbols))
