"""The shortest way to say where copies of one symbol stand: rows, grids, rings, the rest singly.

Takes the frames of one symbol in one body; gives items whose placements are those, in some order
and modulo the symbol's symmetry, with what they cost. Greedy: the pattern that saves most is taken
first. What only hand placed stays a list.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ipmlang.inverse.frames import Frames, Integers, linear
from ipmlang.inverse.split.cost import item_tokens, placement_tokens
from ipmlang.inverse.split.expansion import placements
from ipmlang.inverse.split.listing import Listing, list_tokens, listing
from ipmlang.inverse.split.scheme import Array, Place, Ring
from ipmlang.inverse.split.search.arrays import Lattice, lattices
from ipmlang.inverse.split.search.drafts import Limits
from ipmlang.inverse.split.search.figures import Figure, alternatives, misses, probed, simplest
from ipmlang.inverse.split.search.rings import rings
from ipmlang.inverse.split.snapping import Flags, label_rows, members, snap_columns

LEAST = 2.0  # tokens that a pattern has to save
MOST = 40  # patterns of one symbol in one body
CLOSELY = 12  # patterns whose gain is worked out exactly
FEWEST = 3  # copies that may be a pattern
MOST_TURNED = 400  # copies among which rings are looked for


@dataclass(frozen=True, slots=True, eq=False)
class Arranged:
    """Items that place a symbol, and their tokens; patterns: for each row the item it stands in,
    -1 for those that stand singly; each (p,): tokens of every pattern.
    """

    items: tuple[Place | Array | Ring, ...]
    tokens: int
    patterns: Integers
    each: Integers


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """gain: tokens that an item saves at most; tokens: it takes; rows: placements it stands for."""

    gain: float
    tokens: int
    rows: Integers
    item: Array | Ring


@dataclass(slots=True, eq=False)
class Memory:
    """What was arranged before, by figures and frames, so that it is not looked for again; work:
    placements looked at.
    """

    known: dict[bytes, Arranged] = field(default_factory=dict)
    work: int = 0


def arranged(
    shape: Figure, frames: Frames, symbol: int, limits: Limits, memory: Memory
) -> Arranged:
    """Items for all frames (n,) of a symbol."""
    key = b"".join(
        column.tobytes()
        for column in (
            shape.images, frames.position, frames.rotation, frames.hand, frames.scale
        )
    )  # fmt: skip
    known = memory.known.get(key)
    if known is None:
        memory.work += len(frames)
        known = _arranged(shape, frames, symbol, limits)
        memory.known[key] = known
    if all(item.symbol == symbol for item in known.items):
        return known
    return replace(known, items=tuple(replace(item, symbol=symbol) for item in known.items))


def _arranged(shape: Figure, frames: Frames, symbol: int, limits: Limits) -> Arranged:
    plainest = simplest(shape, frames, limits.small)
    alone = placement_tokens(plainest, limits.small)
    every = np.arange(len(frames))
    if len(frames) < FEWEST:
        return Arranged((Place(symbol, plainest),), int(alone.sum()), every * 0 - 1, every[:0])
    listed = listing(plainest, alone, limits.small)
    groups = _turned_alike(shape, plainest, limits)
    left = np.ones(len(frames), np.bool_)
    items: list[Place | Array | Ring] = []
    patterns, each = every * 0 - 1, []
    pool = _found(shape, plainest, groups, alone, left, symbol, limits)
    while pool and len(items) < MOST:
        best = _best(pool, listed, every[left])
        if best is None:
            break
        patterns[best.rows] = len(items)
        items.append(best.item)
        each.append(best.tokens)
        left[best.rows] = False
        touched = [(rows, own) for rows, own in groups if np.intersect1d(rows, best.rows).size]
        pool = [found for found in pool if left[found.rows].all()]
        if not pool:
            pool = _found(shape, plainest, touched, alone, left, symbol, limits)
    singly = list_tokens(listed, every[left])
    if left.any():
        items.append(Place(symbol, plainest[every[left]]))
    return Arranged(tuple(items), sum(each) + singly, patterns, np.array(each, np.int64))


def _best(pool: list[Found], listed: Listing, rows: Integers) -> Found | None:
    """The pattern that saves most of what a list of these rows takes."""
    now = list_tokens(listed, rows)
    best, most = None, LEAST
    for found in sorted(pool, key=lambda each: -each.gain)[:CLOSELY]:
        rest = np.setdiff1d(rows, found.rows, assume_unique=True)
        gain = now - list_tokens(listed, rest) - found.tokens
        if gain >= most:
            best, most = found, gain + 1e-6
    return best


def _turned_alike(shape: Figure, frames: Frames, limits: Limits) -> list[tuple[Integers, Frames]]:
    """Rows whose turns are the same modulo the symmetry, with their frames turned the same."""
    many = len(shape.symmetry)
    every = alternatives(shape, frames)
    near = max(1e-7, 4 * limits.error / max(shape.reach, limits.error))
    label = snap_columns(linear(every).reshape(-1, 9), near)
    kind = label_rows(label)[0].reshape(-1, many)
    coset, count = label_rows(kind.min(axis=1)[:, None])
    groups = []
    for rows in members(coset, len(count)):
        plain = kind[rows, 0]
        wanted = np.bincount(plain).argmax()
        which = np.argmax(kind[rows] == wanted, axis=1)
        good = kind[rows, which] == wanted
        groups.append((rows[good], every[rows[good] * many + which[good]]))
    return groups


def _found(
    shape: Figure,
    frames: Frames,
    groups: list[tuple[Integers, Frames]],
    alone: Integers,
    left: Flags,
    symbol: int,
    limits: Limits,
) -> list[Found]:
    """Patterns that pay among the rows that are left."""
    pool = []
    for rows, own in groups:
        kept = left[rows]
        pool += _arrays(shape, own[kept], rows[kept], alone, symbol, limits)
    rest = np.nonzero(left)[0]
    if len(rest) > MOST_TURNED:
        return pool
    for rows, ring in rings(shape, frames[rest], symbol, limits.error):
        tokens = item_tokens(ring, limits.small)
        gain = float(alone[rest[rows]].sum()) - tokens
        if gain >= LEAST:
            pool.append(Found(gain, tokens, rest[rows], ring))
    return pool


def _arrays(
    shape: Figure, frames: Frames, rows: Integers, alone: Integers, symbol: int, limits: Limits
) -> list[Found]:
    if len(rows) < 3:
        return []
    each = float(alone[rows].mean())
    pool = []
    for lattice in lattices(frames.position, limits.error / 2, each):
        item = _array(frames, lattice, symbol)
        tokens = item_tokens(item, limits.small)
        gain = float(alone[rows[lattice.rows]].sum()) - tokens
        if gain >= LEAST and _exact(shape, frames, lattice, item, limits):
            pool.append(Found(gain, tokens, rows[lattice.rows], item))
    return pool


def _array(frames: Frames, lattice: Lattice, symbol: int) -> Array:
    lead = frames[lattice.rows[:1]]
    first = Frames(lattice.first[None], lead.rotation, lead.hand, lead.scale)
    return Array(symbol, first, lattice.directions, lattice.holes)


def _exact(shape: Figure, frames: Frames, lattice: Lattice, item: Array, limits: Limits) -> bool:
    """Whether an array puts every member where it is."""
    order = np.lexsort(lattice.digits.T[::-1])
    made = placements(item)[0][1]
    if len(made) != len(order):
        return False
    off = misses(shape, probed(shape, made), frames[lattice.rows[order]])[0]
    return bool(off.max() <= limits.error)
