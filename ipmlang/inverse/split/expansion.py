"""A scheme spelt out: where every terminal stands in the end.

In goes a scheme, out come rows of terminals with frames in the world. The definition of what a
scheme means; proofs, costs and tests compare with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.frames import (
    Floats,
    Frames,
    Integers,
    about,
    apply,
    canonical,
    compose,
    identity,
    inverse,
    join,
    moved_to,
    turns,
)
from ipmlang.inverse.split.scheme import (
    Array,
    Direction,
    Item,
    Octant,
    Place,
    Ring,
    Rule,
    Scheme,
    Split,
    Terminal,
)


def expand(scheme: Scheme) -> tuple[Integers, Frames]:
    """(n,) the class of every terminal that a scheme draws, and its frame in the world.

    Sizes that a terminal is stretched to are not told; `Place.stretch` belongs to edits.
    """
    known: list[tuple[Integers, Frames]] = []
    for symbol in scheme.symbols:
        if isinstance(symbol, Terminal):
            known.append((np.array([symbol.part]), inverse(symbol.pose)))
        else:
            known.append(_drawn(symbol, known))
    parts, placed = known[-1]
    return parts, compose(scheme.frame, placed)


def _drawn(rule: Rule, known: list[tuple[Integers, Frames]]) -> tuple[Integers, Frames]:
    parts, placed = [np.zeros(0, np.int64)], [identity(0)]
    for item in rule.items:
        for symbol, frames in placements(item):
            own_parts, own = known[symbol]
            outer = np.repeat(np.arange(len(frames)), len(own))
            inner = np.tile(np.arange(len(own)), len(frames))
            parts.append(own_parts[inner])
            placed.append(compose(frames[outer], own[inner]))
    return np.concatenate(parts), join(placed)


def placements(item: Item) -> list[tuple[int, Frames]]:
    """The symbols that an item places, each with its frames in the rule's coordinates."""
    match item:
        case Place():
            return [(item.symbol, item.frames)]
        case Array():
            return [(item.symbol, _array(item))]
        case Ring():
            return [(item.symbol, ring_frames([item]))]
        case Split():
            return _split(item)
        case Octant():
            return [(item.symbol, _cells(item))]
        case _:
            assert_never(item)


def _array(array: Array) -> Frames:
    counts = [direction.count for direction in array.directions]
    digits = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1)
    digits = digits.reshape(-1, len(counts))
    if array.holes:
        kept = [tuple(row) not in array.holes for row in digits.tolist()]
        digits = digits[np.array(kept, np.bool_)]
    offset = np.zeros((len(digits), 3))
    for axis, direction in enumerate(array.directions):
        offset += offsets(direction)[digits[:, axis]]
    return compose(moved_to(offset), array.first)


def offsets(direction: Direction) -> Floats:
    """(n, 3) how far the members along a direction are from the first."""
    along = np.arange(direction.count, dtype=np.float64)
    if direction.angle:
        axis = np.tile(direction.axis, (direction.count, 1))
        arms = turns(about(axis, direction.angle * along)) @ direction.step
        return np.asarray(arms - direction.step)
    if direction.steps:
        along = np.concatenate([[0.0], np.cumsum(direction.steps)])
    return np.asarray(along[:, None] * direction.step)


def ring_frames(rings: Sequence[Ring]) -> Frames:
    """The frames of the members of rings, one ring after the other."""
    members = [[i for i in range(ring.count) if i not in ring.holes] for ring in rings]
    of = np.repeat(np.arange(len(rings)), [len(each) for each in members])
    index = np.array([i for each in members for i in each], np.float64)
    axis, center = np.stack([[ring.axis, ring.center] for ring in rings], axis=1)[:, of]
    numbers = [(ring.angle, ring.rise, ring.growth, ring.gain) for ring in rings]
    angle, rise, factor, gain = np.array(numbers)[of].T
    growth = factor**index + gain * index
    turned = canonical(about(axis, angle * index))
    still = Frames(np.zeros((len(index), 3)), turned, np.ones(len(index)), growth)
    moved = center - apply(still, center) + (rise * index)[:, None] * axis
    return compose(Frames(moved, turned, still.hand, growth), join([r.first for r in rings])[of])


def _split(split: Split) -> list[tuple[int, Frames]]:
    found, at = [], 0.0
    for cell in split.cells:
        along = at + cell.length * np.arange(cell.count)
        at += cell.length * cell.count
        if cell.symbol is not None:
            offset: Floats = np.zeros((cell.count, 3))
            offset[:, split.axis] = along
            found.append((cell.symbol, moved_to(offset)))
    return found


def _cells(octant: Octant) -> Frames:
    low = np.zeros(3)
    for cut in octant.cuts:
        low = low + np.where(_beyond(cut.octant), cut.point, 0.0)
    counts = np.array(octant.counts)
    digits = np.indices(octant.counts).reshape(3, -1).T
    return compose(moved_to(low + digits * (octant.size / counts)), octant.inner)


def _beyond(octant: int) -> NDArray[np.bool_]:
    """(3,) whether an octant lies beyond the point along x, y and z."""
    return (octant - 1 >> np.arange(3) & 1).astype(np.bool_)
