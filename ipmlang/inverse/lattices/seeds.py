"""Chains in a cloud, whatever the order of the points: seeds from neighbours, grown and chosen.

Rows begin with a point, a neighbour and the point as far beyond; what bends begins with three
neighbours, carried on both as a constant similarity and as a parabola. Seeds that more points agree
with are grown first. Everything is deterministic, and how much is tried is bounded.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice, pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lattices.chains import LATE, LEAST_LOOSE, Chain, Mask, believable, grow
from ipmlang.inverse.lattices.cloud import EVERY, Cloud, Integers
from ipmlang.inverse.lattices.hopeless import hopeless
from ipmlang.inverse.lattices.models import TERMS, TURN, Kind, Model, at, centre, spacing, start
from ipmlang.inverse.lsystem.frames import Complexes

ATTEMPTS = 120  # seeds grown in one search
AHEAD = 60  # seeds that are looked at together
BARREN = 15  # of them in a row that give nothing: seeds come best first, so the rest is hopeless
STEPS = 6  # from two points to others of their row, with holes between
WIDER = 1.5  # times as much more noise with each of these
SLACK = 4.0  # times the noise that a prediction from a seed may be off
TRIPLES = 80_000  # seeds of what bends
SMOOTH, SHARP = 75.0, 125.0  # degrees between steps of noisy and of exact chains
GROWTH = 1.8  # most that one step is longer than the last
SEVERAL = 150  # points beyond which noisy bends begin with five members in a row
BENT: tuple[Kind, ...] = ("ring", "log", "archimedes", "parabola")
FINER = (2, 3)  # parts of a step in which there may be more members
BETTER = 1.3  # times as many members make a noisier or more bent chain the better one
TAU = 2 * np.pi

Pairs: TypeAlias = "set[tuple[int, int]]"


@dataclass(slots=True, eq=False)
class Seeds:
    """rows: (s, k) members of consecutive indices, −1 where there is none, best first; tests: how
    many were looked at; used: (n,) points that others have; tried: neighbours in chains grown;
    members: index and rows of those looked at, a point of a small ring once, and their pairs.
    """

    rows: Integers
    tests: float
    used: Mask
    tried: set[tuple[int, int]] = field(default_factory=set)
    members: dict[int, tuple[Integers, Integers, Pairs]] = field(default_factory=dict)
    patience: int = BARREN

    def fresh(self) -> Iterator[tuple[int, Integers, Integers]]:
        """Number, index and rows of the members of each seed not yet part of what was grown."""
        left = ATTEMPTS
        for number in range(len(self.rows)):
            if left == 0 or self.patience == 0:
                break
            if not self._is_fresh(number):
                continue
            left, self.patience = left - 1, self.patience - 1
            index, rows, pairs = self.members[number]
            yield number, index, rows
            self.tried |= pairs | {(b, a) for a, b in pairs}

    def next(self, number: int) -> tuple[list[int], Integers]:
        """The seeds from one on that will be looked at if no chain takes their members: numbers
        (s,) and rows (s, k), not too few, since many together take hardly longer than a few.
        """
        later = (each for each in range(number, len(self.rows)) if self._is_fresh(each))
        numbers = list(islice(later, AHEAD))
        made = np.full((len(numbers), self.rows.shape[1]), -1, np.int64)
        for row, each in zip(made, numbers, strict=True):
            index, rows, _ = self.members[each]
            row[index] = rows
        return numbers, made

    def _is_fresh(self, number: int) -> bool:
        if number not in self.members:
            place: dict[int, int] = {}
            for index, row in enumerate(self.rows[number].tolist()):
                if row >= 0:
                    place.setdefault(row, index)  # a small ring is gone around more than once
            columns = np.array([list(place.values()), list(place)], np.int64)
            self.members[number] = columns[0], columns[1], set(pairwise(place))
        _, rows, pairs = self.members[number]
        return not pairs <= self.tried and int(np.count_nonzero(self.used[rows])) <= 1

    def note(self, chain: Chain) -> None:
        """Seeds inside this chain need not be grown again."""
        rows = chain.rows.tolist()
        pairs = set(pairwise(rows))
        self.tried |= pairs | {(b, a) for a, b in pairs}


def find_rows(known: Cloud, used: Mask, share: float) -> list[Chain]:
    """Rows of points not `used` (n,), which mark what they take; share: as for `grow`."""
    found = _rows(known, _row_seeds(known, used, share), used, share)
    if share > 0 and len(known) <= EVERY and np.count_nonzero(~used) >= LEAST_LOOSE["line"]:
        found += _rows(known, _gapped_seeds(known, used, share), used, share)
    return found


def _rows(known: Cloud, seeds: Seeds, used: Mask, share: float) -> list[Chain]:
    """Rows that begin with these seeds."""
    found: list[Chain] = []
    for _, index, rows in seeds.fresh():
        first = start("line", known.at[rows], index)
        chain = None if first is None else grow(known, first, index, rows, used, share, True)
        if chain is None:
            continue
        seeds.note(chain)
        if believable(known, chain, seeds.tests):
            chain = _denser(known, bolder(known, chain, used, seeds.tests), used, seeds.tests)
            used[chain.rows] = True
            found.append(chain)
            seeds.patience = BARREN
    return found


def _gapped_seeds(known: Cloud, used: Mask, share: float) -> Seeds:
    """Two points and what lies as far on or back several times, five or more in all: rows whose
    holes leave no three members side by side.
    """
    here, there = _pairs(known, used)
    step = known.at[there] - known.at[here]
    many = np.delete(np.arange(-STEPS, STEPS + 1), [STEPS, STEPS + 1])
    reach = WIDER * share * np.abs(step)[:, None] * (1 + np.abs(many))
    more = _find(known, used, known.at[here][:, None] + step[:, None] * many, reach)
    ends = np.stack([here, there], axis=1)
    rows = np.concatenate([more[:, :STEPS], ends, more[:, STEPS:]], axis=1)
    count = (rows >= 0).sum(axis=1)
    order = np.lexsort((here, np.abs(step).round(9), -count))
    order = order[(count[order] >= LEAST_LOOSE["line"]) & (here[order] < there[order])]
    return Seeds(rows[order], float(len(here)) / 2, used)


def _row_seeds(known: Cloud, used: Mask, share: float) -> Seeds:
    """Five points or more out of seven at even steps; of exact ones three."""
    here, there = _pairs(known, used)
    step = known.at[there] - known.at[here]
    reach = np.maximum(2 * known.exact, SLACK * share * np.abs(step))
    third = _find(known, used, known.at[there] + step, reach)
    good = (third >= 0) & (here < third)
    here, there, third, reach = here[good], there[good], third[good], reach[good]
    step = (known.at[third] - known.at[here]) / 2
    beyond = known.at[there][:, None] + step[:, None] * np.array([-3, -2, 2, 3])
    more = _find(known, used, beyond, np.repeat(reach[:, None], 4, axis=1))
    rows = np.stack([more[:, 0], more[:, 1], here, there, third, more[:, 2], more[:, 3]], axis=1)
    count = (rows >= 0).sum(axis=1)
    order = np.lexsort((here, np.abs(step).round(9), -count))
    order = order[count[order] >= (3 if share == 0 else 5)]
    return Seeds(rows[order], float(len(good)) / 2, used)


def _pairs(known: Cloud, used: Mask) -> tuple[Integers, Integers]:
    """Every point not used with each of its neighbours not used."""
    here = np.repeat(np.arange(len(known)), known.near.shape[1])
    there = known.near.ravel()
    keep = ~used[here] & ~used[there]
    return here[keep], there[keep]


def _find(known: Cloud, used: Mask, places: Complexes, reach: NDArray[np.float64]) -> Integers:
    """The points not used near places, −1 for none."""
    hit = known.find(places, reach)
    hit[(hit >= 0) & used[hit]] = -1
    return hit


def bolder(known: Cloud, chain: Chain, used: Mask, tests: float) -> Chain:
    """The same chain with noise allowed, or bent, where that makes it much longer."""
    best, free = chain, np.count_nonzero(~used)
    kinds: tuple[Kind, ...] = (chain.model.kind,)
    if chain.model.kind == "line" and chain.reach > known.exact:
        kinds = ("parabola", "ring", "log", "archimedes")
    for kind in kinds:
        least = max(BETTER * len(best), len(best) + 2)
        if free + 1 < least:  # one member may be another chain's
            break
        smooth = at(best.model, np.arange(best.index[0], best.index[-1] + 1))
        first = start(kind, smooth, np.arange(len(smooth)))
        if first is None or len(chain) < 3:
            continue
        index = best.index - best.index[0]
        tried = grow(known, first, index, best.rows, used, known.loose)
        longer = tried is not None and len(tried) >= least
        if tried is not None and longer and believable(known, tried, tests):
            best = tried
    return best


def _denser(known: Cloud, chain: Chain, used: Mask, tests: float) -> Chain:
    """The same chain with a half or a third of the step, where the seed had left out members."""
    best = chain
    for parts in () if chain.model.kind == "vogel" else FINER:
        if np.count_nonzero(~used) + 1 < BETTER * len(best):
            break
        index = parts * (chain.index - chain.index[0])
        between = at(chain.model, chain.index[0] + np.arange(index[-1] + 1) / parts)
        first = start(chain.model.kind, between, np.arange(len(between)))
        if first is None:
            continue
        share = 0.0 if chain.reach <= known.exact else known.loose
        tried = grow(known, first, index, chain.rows, used, share)
        longer = tried is not None and len(tried) >= BETTER * len(best)
        if tried is not None and longer and believable(known, tried, tests):
            best = tried
    return best


# ------------------------------------------------------------------------ what bends


def find_bends(known: Cloud, used: Mask, share: float, line: Integers) -> list[Chain]:
    """Parabolas, rings and spirals of points not `used` (n,), which mark what they take; line: (n,)
    the row that each is in, -1 for none: no bend begins within one row.
    """
    seeds = _bend_seeds(known, used, share, line)
    found: list[Chain] = []
    none: dict[int, list[bool]] = {}
    for number, index, rows in seeds.fresh():
        if number not in none:
            ahead, members = seeds.next(number)
            without = hopeless(known, used, share, members, BENT)
            none |= zip(ahead, without.tolist(), strict=True)
        kinds = [kind for kind, lost in zip(BENT, none[number], strict=True) if not lost]
        grown = [_bent(known, kind, index, rows, used, share) for kind in kinds]
        chains = [each for each in grown if each is not None]
        for chain in chains:
            seeds.note(chain)
        sure = [each for each in chains if believable(known, each, seeds.tests)]
        if sure:
            best = max(sure, key=lambda each: len(each) - TERMS[each.model.kind] / 2)
            best = _as_ring(known, best, used, share)
            best = _denser(known, best, used, seeds.tests)
            used[best.rows] = True
            found.append(best)
            seeds.patience = BARREN
    return found


def _as_ring(known: Cloud, chain: Chain, used: Mask, share: float) -> Chain:
    """The ring that a spiral is which winds more than once and does not grow: a seed that had left
    out every second member goes around twice.
    """
    model = chain.model
    if model.kind not in ("log", "archimedes") or abs(model.numbers[TURN]) * chain.nodes < TAU:
        return chain
    arms = known.at[chain.rows] - centre(model)
    radius, around = float(np.median(np.abs(arms))), np.sort(np.angle(arms) % TAU)
    gap = float(np.median(np.diff(around)))
    step = TAU / max(round(TAU / max(gap, 1e-6)), 3)
    if float(np.ptp(np.abs(arms))) > SLACK * share * radius * step:
        return chain
    index = np.round((np.angle(arms) % TAU - around[0]) / step).astype(np.int64)
    if len(np.unique(index)) < len(index):
        return chain
    place = centre(model)
    first = Model("ring", np.array([place.real, place.imag, around[0], step, radius]))
    tried = grow(known, first, index, chain.rows, used, share)
    return chain if tried is None or len(tried) < len(chain) else tried


def _bent(
    known: Cloud, kind: Kind, index: Integers, rows: Integers, used: Mask, share: float
) -> Chain | None:
    first = start(kind, known.at[rows], index)
    if first is None:
        return None
    off = np.abs(known.at[rows] - at(first, index))
    if (off > LATE * np.maximum(known.exact, known.loose * spacing(first, index))).any():
        return None
    return grow(known, first, index, rows, used, share, fitted=True)


def _bend_seeds(known: Cloud, used: Mask, share: float, line: Integers) -> Seeds:
    """Triples of neighbours with what carries them on, both ways and by both predictions."""
    a, p, b = _triples(known, used)
    tests = float(len(p))
    ahead, behind = known.at[b] - known.at[p], known.at[p] - known.at[a]
    ratio = ahead / behind
    size = np.abs(ratio)
    turn = np.abs(np.angle(ratio, deg=True))
    good = (size < GROWTH) & (size > 1 / GROWTH) & (turn <= (SHARP if share == 0 else SMOOTH))
    good &= (line[p] < 0) | (line[a] != line[p]) | (line[b] != line[p])
    a, p, b = (each[good] for each in (a, p, b))
    ratio, ahead, behind = (each[good] for each in (ratio, ahead, behind))
    places = known.at[a], known.at[p], known.at[b]
    made = [
        _carried(known, used, share, places, np.stack([a, p, b], axis=1), outer)
        for outer in (_similar(ratio, ahead, behind), _curved(ahead, behind))
    ]
    rows, length = np.concatenate(made), np.tile(np.minimum(np.abs(ahead), np.abs(behind)), 2)
    count = (rows >= 0).sum(axis=1)
    if len(known) > SEVERAL:
        count = np.where((rows[:, [1, 5]] >= 0).all(axis=1) | (share == 0), count, 0)
    order = np.lexsort((rows[:, 3], length.round(9), -count))
    order = order[count[order] >= (4 if share == 0 else 5)]
    return Seeds(rows[order], 2 * tests, used)


Outer: TypeAlias = tuple[Complexes, Complexes, Complexes, Complexes]


def _similar(ratio: Complexes, ahead: Complexes, behind: Complexes) -> Outer:
    """Steps beyond three points if each is the one before times a ratio: two back, two on."""
    back, on = behind / ratio, ahead * ratio
    return -back - back / ratio, -back, on, on + on * ratio


def _curved(ahead: Complexes, behind: Complexes) -> Outer:
    """The same if each is the one before plus a constant."""
    bend = ahead - behind
    back, on = behind - bend, ahead + bend
    return -2 * back + bend, -back, on, 2 * on + bend


def _carried(
    known: Cloud,
    used: Mask,
    share: float,
    places: tuple[Complexes, Complexes, Complexes],
    middle: Integers,
    outer: Outer,
) -> Integers:
    """(s, 7) triples (s, 3) with what lies two before and two after."""
    first, second, last = places
    short = np.minimum(np.abs(second - first), np.abs(last - second))
    reach = np.maximum(4 * known.exact, SLACK * share * short)[:, None] * np.array([2, 1, 1, 2])
    beyond = np.stack(outer, axis=1) + np.stack([first, first, last, last], axis=1)
    ends = _find(known, used, beyond, reach)
    return np.concatenate([ends[:, :2], middle, ends[:, 2:]], axis=1)


def _triples(known: Cloud, used: Mask) -> tuple[Integers, Integers, Integers]:
    """Points not used between two of their neighbours, within `TRIPLES` in all."""
    free = np.flatnonzero(~used)
    often = known.near.shape[1]
    while often > 3 and len(free) * often * (often - 1) / 2 > TRIPLES:
        often -= 1
    one, two = np.triu_indices(often, 1)
    p = np.repeat(free, len(one))
    a, b = known.near[free][:, one].ravel(), known.near[free][:, two].ravel()
    keep = ~used[a] & ~used[b]
    return a[keep], p[keep], b[keep]
