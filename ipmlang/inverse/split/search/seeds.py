"""Seeds of motifs: pairs of neighbours that stand to each other as other pairs do.

Takes a field; gives for each kind of pair the occurrences and the motions from the first of them
to each, as votes of neighbours only: never all pairs. What grows from a seed is for `growth`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import Floats, Integers, compose, inverse, join, matrices
from ipmlang.inverse.split.search.fields import Field, agree
from ipmlang.inverse.split.snapping import label_rows, members, snap

KINDS = 3  # relations that pairs at one distance are told apart into
SCALED = 1e-5  # share by which copies are larger than others
MOST = 400  # occurrences of a pair that are followed


@dataclass(frozen=True, slots=True, eq=False)
class Seed:
    """pairs: (k, 2) rows, the first the one that the others are compared with; of (a,), motion
    (a, 3, 4): ways to lay the first pair over pair `of`, several where symmetry allows, the one
    that needs no mirror first.
    """

    pairs: Integers
    of: Integers
    motion: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """pairs: (e, 2) neighbours, each once; label (e,): of equal symbols at equal distances;
    count (e,): how many have that label; rich (n,): how much of a row's surroundings is elsewhere
    too.
    """

    pairs: Integers
    label: Integers
    count: Integers
    rich: Floats


def edges_of(field: Field, error: float) -> Edges:
    """All pairs of neighbours with labels that do not hang on how anything is turned."""
    first = np.repeat(np.arange(len(field.draft)), np.diff(field.begin))
    pairs = np.stack([first, field.near], axis=1)
    symbol = field.draft.symbol[pairs]
    once = (symbol[:, 0] < symbol[:, 1]) | ((symbol[:, 0] == symbol[:, 1]) & (first < field.near))
    pairs, symbol = pairs[once], symbol[once]
    pairs = _larger_first(field, pairs, symbol)
    told = np.concatenate([symbol, _apart(field, pairs, error)], axis=1)
    label, counts = label_rows(told)
    count = counts[label]
    rich = np.zeros(len(field.draft))
    for side in (0, 1):
        np.add.at(rich, pairs[:, side], np.log(count))
    return Edges(pairs, label, count, rich)


def _larger_first(field: Field, pairs: Integers, symbol: Integers) -> Integers:
    """Pairs of one symbol the larger copy first, others as they are."""
    scale = field.draft.frames.scale[pairs]
    other = (symbol[:, 0] == symbol[:, 1]) & (scale[:, 1] > scale[:, 0] * (1 + SCALED))
    return np.where(other[:, None], pairs[:, ::-1], pairs)


def _apart(field: Field, pairs: Integers, error: float) -> Integers:
    """Labels (e, 1 or 2) of how far apart pairs are, in units of the first, and, where any copy is
    scaled, of how much larger the second is.
    """
    away = field.points[pairs[:, 0], 0] - field.points[pairs[:, 1], 0]
    distance = np.linalg.norm(away, axis=1)
    scale = field.draft.frames.scale
    if np.abs(scale - 1).max(initial=0.0) <= SCALED:
        return snap(distance, 2 * error)[:, None]
    first, second = scale[pairs].T
    distance = snap(distance / first, 2 * error / float(scale.min()))
    return np.stack([distance, snap(second / first, SCALED)], axis=1)


def seeds(field: Field, edges: Edges, labels: Sequence[Integers], error: float) -> list[list[Seed]]:
    """The seeds among edges of some labels, given by their rows, for each label."""
    left = [_ordered(field, edges, chosen) for chosen in labels]
    found: list[list[Seed]] = [[] for _ in labels]
    open_ = list(range(len(labels)))
    for _ in range(KINDS):
        open_ = [number for number in open_ if len(left[number]) > 1]
        if not open_:
            break
        related = _related(field, [left[number] for number in open_], error)
        for number, seed in zip(open_, related, strict=True):
            same = _once(seed.of)
            taken = _disjoint(seed.pairs[same])
            if len(taken) > 1:
                found[number].append(_kept(seed, same[taken]))
            other = np.ones(len(seed.pairs), np.bool_)
            other[same] = False
            left[number] = seed.pairs[other]
    return found


def _ordered(field: Field, edges: Edges, chosen: Integers) -> Integers:
    """(k, 2) the pairs that are followed of edges of one label, those with much around first; of
    two symbols the one with fewer symmetries comes first.
    """
    pairs = edges.pairs[chosen]
    one, two = field.draft.symbol[pairs[0]].tolist()
    if one == two:
        pairs = np.concatenate([pairs, pairs[:, ::-1]])
    figures = field.draft.figures
    if len(figures[two].symmetry) < len(figures[one].symmetry):
        pairs = pairs[:, ::-1]
    order = np.lexsort((pairs[:, 0], -np.round(edges.rich[pairs].sum(axis=1), 6)))
    return pairs[order[:MOST]]


def _related(field: Field, groups: list[Integers], error: float) -> list[Seed]:
    """Of each group of pairs (k, 2) those that stand as the first one does, with all motions that
    show it.
    """
    draft = field.draft
    pairs = np.concatenate(groups)
    begin = np.cumsum([0, *(len(group) for group in groups)])
    group = np.repeat(np.arange(len(groups)), np.diff(begin))
    anchor = draft.symbol[pairs[begin[:-1], 0]]
    many = np.array([len(draft.figures[each].symmetry) for each in anchor.tolist()], np.int64)
    of = np.repeat(np.arange(len(pairs)), many[group])
    own = group[of]
    turned = join([
        draft.figures[symbol].symmetry[_again(int(ways), len(rows))]
        for symbol, ways, rows in zip(anchor.tolist(), many, groups, strict=True)
    ])  # fmt: skip
    back = inverse(draft.frames[pairs[begin[:-1], 0]])
    motions = compose(compose(draft.frames[pairs[of, 0]], turned), back[own])
    motion = matrices(motions)
    led = field.points[pairs[begin[:-1], 1]][own]
    wanted = led @ motion[:, :, :3].transpose(0, 2, 1) + motion[:, None, :, 3]
    off = np.linalg.norm(wanted[:, 0] - field.points[pairs[of, 1], 0], axis=1)
    kept = np.nonzero(off <= error)[0]
    kept = kept[agree(field, pairs[of[kept], 1], wanted[kept], error)]
    kept = kept[np.lexsort((motions.hand[kept] < 0, of[kept]))]
    ends = np.searchsorted(own[kept], np.arange(len(groups) + 1))
    return [
        Seed(rows, of[kept[ends[k] : ends[k + 1]]] - begin[k], motion[kept[ends[k] : ends[k + 1]]])
        for k, rows in enumerate(groups)
    ]


def _again(count: int, times: int) -> Integers:
    return np.arange(count * times) % count


def _once(numbers: Integers) -> Integers:
    """Numbers in order, without those that are there already."""
    new = np.ones(len(numbers), np.bool_)
    new[1:] = numbers[1:] != numbers[:-1]
    return numbers[new]


def _disjoint(pairs: Integers) -> Integers:
    """Rows of pairs that share nothing with one taken before."""
    used: set[int] = set()
    taken = []
    for index, (one, two) in enumerate(pairs.tolist()):
        if one not in used and two not in used:
            used.update((one, two))
            taken.append(index)
    return np.array(taken, np.int64)


def _kept(seed: Seed, rows: Integers) -> Seed:
    """The seed with only these occurrences, renumbered."""
    number = np.full(len(seed.pairs), -1, np.int64)
    number[rows] = np.arange(len(rows))
    own = number[seed.of] >= 0
    return Seed(seed.pairs[rows], number[seed.of[own]], seed.motion[own])


def labels_by_promise(edges: Edges) -> list[Integers]:
    """Edges of each label that occurs again, those of the most frequent labels first."""
    if len(edges.pairs) == 0:
        return []
    groups = members(edges.label, int(edges.label.max()) + 1)
    again = [group for group in groups if len(group) > 1]
    return sorted(again, key=lambda group: (-len(group), int(group[0])))
