"""Groups of different things that occur again while their parts are painted in any order and stand
where noise has moved them: a drawing's left half that is the mirror image of its right one.

Takes a string of symbols; wherever a similarity maps several symbols onto as many others that are
equal, one group's symbol stands for both. Says in which ranks the elements of such a symbol are
painted and how far each is from its place. What is painted in one order everywhere is for the
search for motifs; nothing here prints.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import lgamma, log

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.clusters import cluster, members
from ipmlang.inverse.lsystem.frames import (
    Complexes,
    Floats,
    Frames,
    apply,
    compose,
    frames,
    identity,
    inverse,
    join,
    replaced,
    unit,
    wrap,
)
from ipmlang.inverse.lsystem.spaces import stabilisers
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers, joined
from ipmlang.inverse.score import AROUND, HEAD

NOISE = 0.03  # of the way to the nearest symbol: how far two parts may be off, both with noise
LEAST = 3  # elements in a group
FEW = 2  # symbols, of several elements one
ROUNDS = 12  # groups that are looked for, one after the other
PAIRS = 40_000  # pairs of equal symbols, and turns that keep them, that vote for a similarity
TRIED = 12  # similarities with the most votes that are looked at closely
SELDOM = -3.0  # log10 of the accidental groups that one may expect where one is found
NUMBER = 4.5  # tokens that a number weighs, usually
RESIDUAL = 5.0  # tokens of how far one symbol is off, where it is
LAYER = 2.0  # of the rank of each symbol that is painted among others
SNAP = 1e-4  # degrees, and a share: how near a similarity is to a plain one


@dataclass(slots=True, eq=False)
class Scattered:
    """ranks: by the first rank of an occurrence, the ranks of all its elements in the order of its
    group; shift: by rank, how far an element is from where its group has it, x + iy;
    spared: tokens that groups save, without what another paint order takes; layered: whether there
    is one.
    """

    ranks: dict[int, Integers] = field(default_factory=dict)
    shift: dict[int, complex] = field(default_factory=dict)
    spared: float = 0.0
    layered: bool = False

    def __bool__(self) -> bool:
        return bool(self.ranks)


@dataclass(frozen=True, slots=True, eq=False)
class _Votes:
    """What maps one symbol of a string onto another: rows of both (v,), the frames (v,) in which
    the second one would be the first one's image, and the similarities (v,).
    """

    one: Integers
    other: Integers
    there: Frames
    move: Frames

    def __len__(self) -> int:
        return len(self.one)

    def __getitem__(self, rows: Integers | NDArray[np.bool_]) -> _Votes:
        return _Votes(self.one[rows], self.other[rows], self.there[rows], self.move[rows])


@dataclass(frozen=True, slots=True, eq=False)
class _Copy:
    """Rows (m,) of a string that a group's are mapped onto, and by which similarity (1,); off: (m,)
    how far they are from there.
    """

    rows: Integers
    move: Frames
    off: Complexes


@dataclass(frozen=True, slots=True, eq=False)
class _Group:
    """Rows (m,) of a string, and where they occur again."""

    one: Integers
    copies: tuple[_Copy, ...]

    @property
    def occurrences(self) -> list[Integers]:
        """Rows (m,) of each."""
        return [self.one, *(each.rows for each in self.copies)]


def with_scattered(alphabet: Alphabet, string: Arrangement) -> tuple[Arrangement, Scattered]:
    """The string with a symbol in place of all occurrences of each group that pays, where its
    first element is painted, and how these are painted.
    """
    found = Scattered()
    for _ in range(ROUNDS):
        group = _best(alphabet, string, found)
        if group is None:
            break
        layers = _layers(alphabet, string, group)
        found.spared += _gain(alphabet, string, group) + layers
        found.layered |= layers > 0
        string = _replaced(alphabet, string, group, found)
    return string, found


def _best(alphabet: Alphabet, string: Arrangement, known: Scattered) -> _Group | None:
    """The group that saves most."""
    rows = _candidates(alphabet, string, known)
    votes, round_ones = _votes(alphabet, string, rows)
    if len(votes) < FEW:
        return None
    room = NOISE * _spacing(string.placed.position[rows])
    best, most = None, 0.0
    for near in _likely(alphabet, string, votes, room):
        group = _matched(alphabet, string, votes[near], round_ones, room)
        if group is None or not _believable(alphabet, string, rows, group, len(votes), room):
            continue
        gain = _gain(alphabet, string, group)
        if gain > most:
            best, most = group, gain
    if best is None:
        return None
    return _everywhere(alphabet, string, rows, best, (votes, round_ones), room)


def _candidates(alphabet: Alphabet, string: Arrangement, known: Scattered) -> Integers:
    """Rows of the main stretch with symbols that have no structure whose frame is bound."""
    bound = [
        each.lattice is not None or each.branching is not None or each.pattern is not None
        for each in alphabet.definitions
    ]
    free = ~np.array(bound, np.bool_)[string.symbol] & (string.wrap == string.wrap.min(initial=0))
    free &= ~np.isin(string.start, list(known.ranks))
    return np.flatnonzero(free)


def _votes(alphabet: Alphabet, string: Arrangement, rows: Integers) -> tuple[_Votes, _Votes]:
    """Similarities between equal symbols, rare symbols first, since those tell more; beside them
    pairs of symbols that any turn keeps, which tell of no similarity but may follow one.
    """
    symbols, often = np.unique(string.symbol[rows], return_counts=True)
    order = np.argsort(often, kind="stable")
    nobody = np.zeros((2, 0), np.int64)
    plain, round_ones = [nobody], [nobody]
    left = PAIRS
    for symbol, count in zip(symbols[order].tolist(), often[order].tolist(), strict=True):
        left -= count * (count - 1) * len(alphabet[symbol].stabiliser)
        if left < 0:
            break
        if count < 2:
            continue
        own = rows[string.symbol[rows] == symbol]
        both = np.stack([np.repeat(own, count), np.tile(own, count)])
        voting = round_ones if alphabet[symbol].free else plain
        voting.append(both[:, both[0] != both[1]])
    one, other = (_moves(alphabet, string, *np.hstack(each)) for each in (plain, round_ones))
    return one, other


def _moves(alphabet: Alphabet, string: Arrangement, one: Integers, other: Integers) -> _Votes:
    """Every similarity that maps some rows (p,) onto others of the same symbols."""
    symbol = string.symbol[one]
    keeps = alphabet.keeping[symbol]
    first, pair = np.cumsum(keeps) - keeps, np.repeat(np.arange(len(one)), keeps)
    there, move = identity(len(pair)), identity(len(pair))
    for count in np.unique(keeps).tolist():
        own = np.flatnonzero(keeps == count)
        every = compose(string.placed[other[own]][:, None], stabilisers(alphabet, symbol[own]))
        moved = compose(every, inverse(string.placed[one[own]])[:, None])
        at = first[own][:, None] + np.arange(count)
        there, move = replaced(there, at, every), replaced(move, at, moved)
    return _Votes(one[pair], other[pair], there, move)


def _together(votes: list[_Votes]) -> _Votes:
    return _Votes(
        np.concatenate([each.one for each in votes]),
        np.concatenate([each.other for each in votes]),
        join([each.there for each in votes]),
        join([each.move for each in votes]),
    )


def _spacing(at: Complexes) -> float:
    """How far it is to the nearest other place, usually."""
    from scipy.spatial import cKDTree

    places = np.unique(at)
    if len(places) < 2:
        return 0.0
    points = np.stack([places.real, places.imag], axis=1)
    apart = np.asarray(cKDTree(points).query(points, 2)[0], np.float64)
    return float(np.median(apart[:, 1]))


def _likely(
    alphabet: Alphabet, string: Arrangement, votes: _Votes, room: float
) -> Iterator[Integers]:
    """Votes for about the same similarity, those with most of them first: those that map the
    middle of everything to about one place.
    """
    from scipy.spatial import cKDTree

    middle = complex(string.placed.position.mean())
    image = apply(votes.move, middle)
    points = np.stack([image.real, image.imag], axis=1)
    angle = np.where(votes.move.angle < SNAP - 180, votes.move.angle + 360, votes.move.angle)
    values = np.stack([angle, np.log(votes.move.scale)], axis=1)
    size = _sizes(alphabet, string, votes)
    slack = np.stack([np.rad2deg(alphabet.tolerance / size), alphabet.tolerance / size], axis=1)
    hands = votes.move.handedness.astype(np.int64)
    best: list[tuple[int, int, Integers]] = []
    for alike in members(cluster(hands, values, slack), FEW):
        tree = cKDTree(points[alike], balanced_tree=False, compact_nodes=False)
        # Most are near to none, so that pairs are few.
        both = tree.query_pairs(room, output_type="ndarray")
        often = np.bincount(both.ravel(), minlength=len(alike)) + 1
        for _ in range(TRIED):
            most = int(np.argmax(often))
            if often[most] < FEW:
                break
            near = np.sort(np.array(tree.query_ball_point(points[alike[most]], room), np.int64))
            best.append((-int(often[most]), int(alike[most]), alike[near]))
            often[near] = 0
    yield from (near for _, _, near in sorted(best, key=lambda each: each[:2])[:TRIED])


def _sizes(alphabet: Alphabet, string: Arrangement, votes: _Votes) -> Floats:
    """(v,) extents of what is mapped, units."""
    radius = np.array([each.radius for each in alphabet.definitions])
    there = radius[string.symbol[votes.other]] * string.placed.scale[votes.other]
    return np.asarray(np.maximum(there, alphabet.tolerance))


def _matched(
    alphabet: Alphabet, string: Arrangement, votes: _Votes, round_ones: _Votes, room: float
) -> _Group | None:
    """The pairs that one similarity maps onto each other, each symbol in one pair only."""
    move = _middle(votes.move, apply(votes.move, complex(string.placed.position.mean())), string)
    votes, off = _followed(alphabet, string, _together([votes, round_ones]), move, room)
    side = _sides(string, votes, move, room)
    used: set[int] = set()
    pairs: list[int] = []
    for row in np.lexsort((votes.one, np.abs(off))).tolist():
        ends = {int(votes.one[row]), int(votes.other[row])}
        if side[row] and not ends & used:
            used |= ends
            pairs.append(row)
    elements = sum(alphabet[each].size for each in string.symbol[votes.one[pairs]].tolist())
    if len(pairs) < FEW or elements < LEAST:
        return None
    chosen = np.array(pairs)[np.argsort(string.start[votes.one[pairs]], kind="stable")]
    return _Group(votes.one[chosen], (_copy(votes.other[chosen], move, off[chosen]),))


def _followed(
    alphabet: Alphabet, string: Arrangement, votes: _Votes, move: Frames, room: float
) -> tuple[_Votes, Complexes]:
    """The votes that agree with a similarity, and how far they are off in position."""
    aim = compose(move, string.placed[votes.one])
    off = votes.there.position - aim.position
    free = np.array([each.free for each in alphabet.definitions], np.bool_)
    told = ~free[string.symbol[votes.one]]
    turned = np.where(told, votes.there.factor - aim.factor, votes.there.scale - aim.scale)
    turned = np.abs(turned) / votes.there.scale
    good = (np.abs(off) <= room) & (~told | (votes.there.handedness == aim.handedness))
    good &= turned * _sizes(alphabet, string, votes) <= alphabet.tolerance
    return votes[good], off[good]


def _copy(rows: Integers, move: Frames, off: Complexes) -> _Copy:
    """The copy whose parts are off as little as can be."""
    middle = off.mean()
    move = frames(move.position + middle, move.angle, move.scale, move.handedness)
    return _Copy(rows, move, off - middle)


def _everywhere(
    alphabet: Alphabet,
    string: Arrangement,
    rows: Integers,
    group: _Group,
    votes: tuple[_Votes, _Votes],
    room: float,
) -> _Group:
    """The group with all further copies of it that pay, none of a part twice."""
    while True:
        used = np.concatenate(group.occurrences)
        left, round_ones = (
            each[np.isin(each.one, group.one) & ~np.isin(each.other, used)] for each in votes
        )
        if len(left) < FEW:
            return group
        gain, found = _gain(alphabet, string, group), None
        for near in _likely(alphabet, string, left, room):
            copy = _again(
                alphabet, string, group.one, _together([left[near], round_ones]), len(near), room
            )
            more = None if copy is None else _Group(group.one, (*group.copies, copy))
            if more is None or _gain(alphabet, string, more) <= gain:
                continue
            if _believable(
                alphabet, string, rows, _Group(group.one, more.copies[-1:]), len(left), room
            ):
                gain, found = _gain(alphabet, string, more), more
        if found is None:
            return group
        group = found


def _again(
    alphabet: Alphabet, string: Arrangement, one: Integers, votes: _Votes, sure: int, room: float
) -> _Copy | None:
    """Where all rows of a group are mapped by what the first `sure` votes say."""
    moves = votes.move[np.arange(sure)]
    move = _middle(moves, apply(moves, complex(string.placed.position.mean())), string)
    votes, off = _followed(alphabet, string, votes, move, room)
    place = {row: k for k, row in enumerate(one.tolist())}
    found = np.full(len(one), -1, np.int64)
    for k in np.lexsort((votes.one, np.abs(off))).tolist():
        part = place[int(votes.one[k])]
        if found[part] < 0 and votes.other[k] not in votes.other[found[found >= 0]]:
            found[part] = k
    return None if (found < 0).any() else _copy(votes.other[found], move, off[found])


def _middle(moves: Frames, image: Complexes, string: Arrangement) -> Frames:
    """One similarity for several that are about the same; a plain one where it is nearly plain."""
    first = float(moves.angle[0])
    angle = first + float(np.median(wrap(moves.angle - first)))
    scale = float(np.median(moves.scale))
    angle = round(angle) if abs(round(angle) - angle) <= SNAP else angle
    scale = 1.0 if abs(scale - 1) <= SNAP / 100 else scale
    turned = frames(np.zeros(1, np.complex128), angle, scale, moves.handedness[:1])
    middle = complex(string.placed.position.mean())
    to = complex(np.median(image.real), np.median(image.imag))
    return frames(to - apply(turned, middle), angle, scale, moves.handedness[:1])


def _sides(string: Arrangement, votes: _Votes, move: Frames, room: float) -> NDArray[np.bool_]:
    """(v,) whether a pair leads away from the first occurrence: what undoes itself has each pair
    twice. Of a mirror the first occurrence is on the side where the first element is painted.
    """
    middle = complex(string.placed.position.mean())
    again = compose(move, move)
    back = abs(again.angle[0]) <= SNAP and abs(again.scale[0] - 1) <= SNAP
    if not back or abs(complex(apply(again, middle).item()) - middle) > 2 * room:
        return np.ones(len(votes), np.bool_)
    if move.handedness[0] > 0:
        return np.asarray(string.start[votes.one] < string.start[votes.other])
    # A point p is mirrored to c + u conj(p): across the line it moves along its normal.
    normal = complex(unit((move.angle[:1]) / 2)[0])
    place = string.placed.position
    across = ((place[votes.other] - place[votes.one]) * np.conj(normal)).real
    first = int(np.argmin(string.start[votes.one]))
    return np.asarray(across * across[first] > 0)


def _believable(
    alphabet: Alphabet,
    string: Arrangement,
    rows: Integers,
    group: _Group,
    tests: int,
    room: float,
) -> bool:
    """Whether chance would hardly map so many symbols onto equal ones: these are thought to stand
    anywhere, and how they are turned is not counted.
    """
    if all(float(np.abs(each.off).max()) <= alphabet.tolerance for each in group.copies):
        room = alphabet.tolerance
    at = string.placed.position[rows]
    area = max(float(np.ptp(at.real) * np.ptp(at.imag)), room * room, 1e-300)
    _, which, often = np.unique(string.symbol[rows], return_inverse=True, return_counts=True)
    expected = float((np.pi * room**2 / area * (often[which] - 1)).sum())
    count = len(group.one) - 1
    odds = log(max(tests, 1)) + count * log(max(expected, 1e-30)) - lgamma(count + 1)
    return odds / log(10) <= SELDOM


def _gain(alphabet: Alphabet, string: Arrangement, group: _Group) -> float:
    """Tokens saved: the placements of all copies, less the rule, what noise and another paint
    order take. The place of the first part is that of the first occurrence; a part that occurs
    nowhere else needs none in the rule.
    """
    saved = -HEAD - AROUND - _layers(alphabet, string, group)
    for copy in group.copies:
        saved += float(_placed_tokens(string, copy.rows).sum()) - AROUND - 3 * NUMBER
        saved -= RESIDUAL * int((np.abs(copy.off) > alphabet.tolerance).sum())
    often = np.bincount(string.symbol, minlength=len(alphabet))[string.symbol[group.one[1:]]]
    alone = often == len(group.occurrences)
    return saved + float(_placed_tokens(string, group.one[1:])[alone].sum())


def _placed_tokens(string: Arrangement, rows: Integers) -> Floats:
    """(m,) tokens of placements."""
    placed = string.placed[rows]
    turned, scaled = np.abs(placed.angle) > SNAP, np.abs(placed.scale - 1) > SNAP
    return np.asarray(AROUND + NUMBER * (2 + np.where(scaled, 2, turned)))


def _layers(alphabet: Alphabet, string: Arrangement, group: _Group) -> float:
    """Tokens of the paint order, where parts are not painted one after the other."""
    ranks = [np.diff(string.start[each]) for each in group.occurrences]
    size = np.array([alphabet[each].size for each in string.symbol[group.one[:-1]].tolist()])
    apart = any((each != size).any() for each in ranks)
    return LAYER * len(ranks) * len(group.one) if apart else 0.0


def _replaced(
    alphabet: Alphabet, string: Arrangement, group: _Group, found: Scattered
) -> Arrangement:
    """The string with a new symbol for all occurrences of a group; `found` is added to."""
    lead = frames(string.placed.position[group.one[:1]])
    places = compose(inverse(lead), string.placed[group.one])
    symbol = alphabet.add_group(string.symbol[group.one], places)
    sizes = [alphabet[each].size for each in string.symbol[group.one].tolist()]
    shifts = [np.zeros(len(group.one), np.complex128), *(each.off for each in group.copies)]
    first = []
    for rows, shift in zip(group.occurrences, shifts, strict=True):
        ranks = [start + np.arange(size) for start, size in _zipped(string.start[rows], sizes)]
        every = np.concatenate(ranks)
        first.append(int(every.min()))
        found.ranks[first[-1]] = every
        moved = np.repeat(shift, sizes)
        far = np.abs(moved) > alphabet.tolerance / 4
        found.shift |= dict(zip(every[far].tolist(), moved[far].tolist(), strict=True))
    left = np.ones(len(string), np.bool_)
    left[np.concatenate(group.occurrences)] = False
    drawn = Arrangement(
        np.full(len(first), symbol, np.int64),
        join([lead, *(compose(each.move, lead) for each in group.copies)]),
        np.array(first, np.int64),
        string.wrap[group.one[:1]].repeat(len(first)),
    )
    made = joined([string[left], drawn])
    return made[np.argsort(made.start, kind="stable")]


def _zipped(start: Integers, sizes: list[int]) -> Iterator[tuple[int, int]]:
    yield from zip(start.tolist(), sizes, strict=True)
