"""The shortest way to say where copies of one symbol stand: rows, grids, rings, the rest singly.

Takes the frames of one symbol in one body; gives items whose placements are those, in some order
and modulo the symbol's symmetry, with what they cost. Greedy: the pattern that saves most is taken
first. What only hand placed stays a list.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ipmlang.inverse.frames import Floats, Frames, Integers, linear
from ipmlang.inverse.split.cost import item_tokens, placement_tokens
from ipmlang.inverse.split.expansion import placements
from ipmlang.inverse.split.listing import Listing, list_tokens, listing
from ipmlang.inverse.split.scheme import Array, Place, Ring
from ipmlang.inverse.split.search.arrays import Lattice, lattices
from ipmlang.inverse.split.search.circles import apart, circles
from ipmlang.inverse.split.search.drafts import Draft, Limits
from ipmlang.inverse.split.search.figures import Figure, alternatives, misses, probed, simplest
from ipmlang.inverse.split.search.rings import rings
from ipmlang.inverse.split.search.swelling import swelling
from ipmlang.inverse.split.snapping import Flags, label_rows, members, snap_columns

LEAST = 2.0  # tokens that a pattern has to save
MOST = 40  # patterns of one symbol in one body
CLOSELY = 12  # patterns whose gain is worked out exactly
FEWEST = 3  # copies that may be a pattern
SCALED = 1e-6  # by which scales differ
MOST_TURNED = 400  # copies among which rings are looked for


@dataclass(frozen=True, slots=True, eq=False)
class Arranged:
    """Items that place a symbol, and their tokens; patterns: for each row the item it stands in,
    -1 for those that stand singly, which are so many; each (p,): tokens of every pattern.
    """

    items: tuple[Place | Array | Ring, ...]
    tokens: int
    patterns: Integers
    single: int
    each: Integers


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """gain: tokens that an item saves at most; tokens: it takes; rows: placements it stands for, in
    its order.
    """

    gain: float
    tokens: int
    rows: Integers
    item: Array | Ring


@dataclass(frozen=True, slots=True, eq=False)
class _Copies:
    """Copies of a symbol: frames of n; alone (n,): tokens of each; left (n,): those that stand in
    no pattern yet.
    """

    shape: Figure
    symbol: int
    frames: Frames
    alone: Integers
    left: Flags
    limits: Limits


@dataclass(slots=True, eq=False)
class Memory:
    """What was arranged before, by figures and frames, so that it is not looked for again; work:
    placements looked at.
    """

    known: dict[tuple[int, bytes], Arranged] = field(default_factory=dict)
    work: int = 0
    _images: dict[bytes, int] = field(default_factory=dict)
    _figures: dict[int, tuple[Figure, int]] = field(default_factory=dict)

    def number(self, shape: Figure) -> int:
        """The same for figures that look the same."""
        met = self._figures.get(id(shape))
        if met is None:
            number = self._images.setdefault(shape.images.tobytes(), len(self._images))
            met = self._figures[id(shape)] = shape, number  # kept, so that no other has its id
        return met[1]


def arranged(
    shape: Figure, frames: Frames, symbol: int, limits: Limits, memory: Memory
) -> Arranged:
    """Items for all frames (n,) of a symbol."""
    key = memory.number(shape), _told(frames).tobytes()
    known = memory.known.get(key)
    if known is None:
        known = memory.known[key] = _met(shape, frames, symbol, limits, memory)
    if all(item.symbol == symbol for item in known.items):
        return known
    return replace(known, items=tuple(replace(item, symbol=symbol) for item in known.items))


def arranged_lists(
    draft: Draft, lists: Sequence[Integers], limits: Limits, memory: Memory
) -> Iterator[Arranged]:
    """What `arranged` gives for lists of rows of one symbol each, one list after the other; which
    symbol the items place is not told.
    """
    told = _told(draft.frames[np.concatenate([np.zeros(0, np.int64), *lists])])
    symbols = draft.symbol[[rows[0] for rows in lists]].tolist() if lists else []
    end = 0
    for rows, symbol in zip(lists, symbols, strict=True):
        begin, end = end, end + len(rows)
        shape = draft.figures[symbol]
        key = memory.number(shape), told[begin:end].tobytes()
        known = memory.known.get(key)
        if known is None:
            known = _met(shape, draft.frames[rows], symbol, limits, memory)
            memory.known[key] = known
        yield known


def _told(frames: Frames) -> Floats:
    """(n, 9) all that tells frames apart."""
    rest = (frames.hand[:, None], frames.scale[:, None])
    return np.concatenate([frames.position, frames.rotation, *rest], axis=1)


def _met(shape: Figure, frames: Frames, symbol: int, limits: Limits, memory: Memory) -> Arranged:
    memory.work += len(frames)
    return _arranged(shape, frames, symbol, limits)


def _arranged(shape: Figure, frames: Frames, symbol: int, limits: Limits) -> Arranged:
    plainest = simplest(shape, frames, limits.small)
    alone = placement_tokens(plainest, limits.small)
    every = np.arange(len(frames))
    if len(frames) < FEWEST:
        single = (Place(symbol, plainest),)
        return Arranged(single, int(alone.sum()), every * 0 - 1, len(frames), every[:0])
    listed = listing(plainest, alone, limits.small)
    left = np.ones(len(frames), np.bool_)
    copies = _Copies(shape, symbol, plainest, alone, left, limits)
    groups = _turned_alike(shape, plainest, limits)
    group = np.full(len(frames), -1, np.int64)
    for number, (rows, _) in enumerate(groups):
        group[rows] = number
    items: list[Place | Array | Ring] = []
    patterns, each = every * 0 - 1, []
    circular = [*_rings(copies), *_swelling(copies), *_circles(copies, groups)]
    pool, stale = _arrays(copies, groups) + circular, set[int]()
    while pool and len(items) < MOST:
        best = _best(pool, listed, every[left])
        if best is None:
            break
        if isinstance(best.item, Array) and not _exact(copies, best.rows, best.item):
            pool = [found for found in pool if found is not best]
            continue
        patterns[best.rows] = len(items)
        items.append(best.item)
        each.append(best.tokens)
        left[best.rows] = False
        stale.update(group[best.rows].tolist())
        pool = [found for found in pool if left[found.rows].all()]
        if not pool:
            pool = _arrays(copies, [groups[number] for number in sorted(stale) if number >= 0])
            stale = set()
            if circular:  # what had no rings has none in a part of it
                pool += [*_rings(copies), *_swelling(copies), *_circles(copies, groups)]
    singly = list_tokens(listed, every[left])
    if left.any():
        items.append(Place(symbol, plainest[every[left]]))
    rest, tokens = int(np.count_nonzero(left)), sum(each) + singly
    return Arranged(tuple(items), tokens, patterns, rest, np.array(each, np.int64))


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


def _turned_alike(
    shape: Figure, frames: Frames, limits: Limits, of_one_size: bool = True
) -> list[tuple[Integers, Frames]]:
    """Rows whose turns are the same modulo the symmetry, with their frames turned the same; also
    as large as each other, if asked.
    """
    many = len(shape.symmetry)
    every = alternatives(shape, frames)
    near = max(1e-7, 4 * limits.error / max(shape.reach, limits.error))
    turns = linear(every) if of_one_size else linear(every) / every.scale[:, None, None]
    label = snap_columns(turns.reshape(-1, 9), near)
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


def _rings(copies: _Copies) -> Iterator[Found]:
    """Rings that pay among the rows that are left."""
    rest = np.nonzero(copies.left)[0]
    if len(rest) > MOST_TURNED:
        return
    error = copies.limits.error
    for rows, ring in rings(copies.shape, copies.frames[rest], copies.symbol, error):
        tokens = item_tokens(ring, copies.limits.small)
        gain = float(copies.alone[rest[rows]].sum()) - tokens
        if gain >= LEAST:
            yield Found(gain, tokens, rest[rows], ring)


def _swelling(copies: _Copies) -> Iterator[Found]:
    """Rows of growing members that pay among the rows that are left."""
    rest = np.nonzero(copies.left)[0]
    scale = copies.frames.scale[rest]
    if len(scale) < FEWEST or np.ptp(scale) <= SCALED:
        return
    error = copies.limits.error
    for own, turned in _turned_alike(copies.shape, copies.frames[rest], copies.limits, False):
        for rows, row in swelling(copies.shape, turned, copies.symbol, error):
            tokens = item_tokens(row, copies.limits.small)
            gain = float(copies.alone[rest[own[rows]]].sum()) - tokens
            if gain >= LEAST:
                yield Found(gain, tokens, rest[own[rows]], row)


def _arrays(copies: _Copies, groups: list[tuple[Integers, Frames]]) -> list[Found]:
    """Rows, grids and blocks that seem to pay among the rows of groups that are left."""
    pool = []
    for every, turned in groups:
        kept = copies.left[every]
        rows, frames = every[kept], turned[kept]
        if len(rows) < FEWEST:
            continue
        alone = copies.alone[rows]
        for lattice in lattices(frames.position, copies.limits.error / 2, alone, LEAST):
            item = _array(frames, lattice, copies.symbol)
            tokens = item_tokens(item, copies.limits.small)
            gain = float(alone[lattice.rows].sum()) - tokens
            if gain >= LEAST:
                order = np.lexsort(lattice.digits.T[::-1])
                pool.append(Found(gain, tokens, rows[lattice.rows[order]], item))
    return pool


def _circles(copies: _Copies, groups: list[tuple[Integers, Frames]]) -> Iterator[Found]:
    """Circles of what is turned alike that pay among the rows that are left."""
    for every, turned in groups:
        kept = copies.left[every]
        rows, frames = every[kept], turned[kept]
        for found in circles(frames.position, copies.limits.error / 2):
            if apart(frames.position, found) <= copies.limits.error:
                lead = frames[found.rows[:1]]
                first = Frames(found.first[None], lead.rotation, lead.hand, lead.scale)
                item = Array(copies.symbol, first, (found.direction,), found.holes)
                tokens = item_tokens(item, copies.limits.small)
                own = rows[found.rows]
                gain = float(copies.alone[own].sum()) - tokens
                if gain >= LEAST:
                    yield Found(gain, tokens, own, item)


def _array(frames: Frames, lattice: Lattice, symbol: int) -> Array:
    lead = frames[lattice.rows[:1]]
    first = Frames(lattice.first[None], lead.rotation, lead.hand, lead.scale)
    return Array(symbol, first, lattice.directions, lattice.holes)


def _exact(copies: _Copies, rows: Integers, item: Array) -> bool:
    """Whether an array puts every member where it is; rows: its members in its order."""
    made = placements(item)[0][1]
    if len(made) != len(rows):
        return False
    off = misses(copies.shape, probed(copies.shape, made), copies.frames[rows])[0]
    return bool(off.max() <= copies.limits.error)
