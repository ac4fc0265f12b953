"""What a draft takes, and what a motif would save: the judge of the search.

Takes drafts and motifs; gives tokens. Only the lists of copies that a motif touches are looked at
again; patterns that it takes apart count as lost. Nothing is changed here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import Floats, Frames, Integers
from ipmlang.inverse.split.cost import FEWEST, HEAD, placement_tokens
from ipmlang.inverse.split.listing import every_token
from ipmlang.inverse.split.search.drafts import Draft, Limits, Motif
from ipmlang.inverse.split.search.figures import Figure
from ipmlang.inverse.split.search.patterns import Arranged, Memory, arranged, arranged_lists
from ipmlang.inverse.split.snapping import Flags, label_rows, members

LOOSE = 3.0  # tokens that a part is worth which a rule explains, beyond those that it saves


@dataclass(frozen=True, slots=True, eq=False)
class Priced:
    """lists: rows of one symbol in one body each, with their patterns; of (n,): the list of each
    row; place (n,): where in its list it is; share (n,): tokens that each row takes on average;
    loose (n,): what each row is worth under a rule, for those that stand singly in the axiom.
    """

    draft: Draft
    lists: tuple[Integers, ...]
    found: tuple[Arranged, ...]
    of: Integers
    place: Integers
    share: Floats
    loose: Floats

    @property
    def tokens(self) -> float:
        """Of all bodies."""
        bodies = len(np.unique(np.append(self.draft.body, 0)))
        return float(sum(each.tokens for each in self.found)) + HEAD * bodies


def may_be_loose(draft: Draft, lists: Sequence[Integers]) -> Flags:
    """(l,) which lists are of parts in the axiom: nothing explains those that stand singly."""
    first = np.array([rows[0] for rows in lists], np.int64)
    return np.asarray((draft.body[first] == 0) & (draft.symbol[first] < draft.classes))


def priced(draft: Draft, limits: Limits, memory: Memory) -> Priced:
    """A draft with the patterns of all its lists."""
    label, count = label_rows(np.stack([draft.body, draft.symbol], axis=1))
    lists = members(label, len(count)) if len(draft) else []
    found = tuple(arranged_lists(draft, lists, limits, memory))
    rows = np.concatenate([np.zeros(0, np.int64), *lists])
    ends = np.cumsum(count)
    place, loose = np.zeros(len(draft), np.int64), np.zeros(len(draft))
    place[rows] = np.arange(len(rows)) - np.repeat(ends - count, count)
    patterns = np.concatenate([np.zeros(0, np.int64), *(each.patterns for each in found)])
    loose[rows] = LOOSE * ((patterns < 0) & np.repeat(may_be_loose(draft, lists), count))
    share = (np.array([each.tokens for each in found], np.float64) / count)[label]
    return Priced(draft, tuple(lists), found, label, place, share, loose)


def gain_of(
    base: Priced,
    motif: Motif,
    shape: Callable[[], Figure],
    limits: Limits,
    memory: Memory,
    least: float,
) -> float:
    """Tokens that a motif saves whose figure is `shape`, which is asked for last; where they are
    fewer than `least`, some number below that.
    """
    rows = motif.rows.ravel()
    saved = float(base.loose[rows].sum()) - HEAD
    of = base.of[rows]
    for index in sorted(set(of.tolist())):
        gone = base.place[rows[of == index]]
        saved += base.found[index].tokens - _without(base, index, gone, limits)
    inside, uses = _inside(base.draft, motif), _uses(base.draft, motif)
    saved -= sum(at_least(len(frames)) for frames in [*inside.values(), *uses])
    for symbol, frames in inside.items():
        if saved < least:
            return saved
        figure = base.draft.figures[symbol]
        tokens = arranged(figure, frames, symbol, limits, memory).tokens
        saved -= tokens - at_least(len(frames))
    for frames in uses:
        if saved < least:
            return saved
        tokens = arranged(shape(), frames, len(base.draft.figures), limits, memory).tokens
        saved -= tokens - at_least(len(frames))
    return saved


def at_least(copies: int) -> int:
    """Tokens below which no list of so many copies stays, no two of them in one place."""
    return (0, 1, 5, 12)[copies] if copies < 4 else FEWEST


def _inside(draft: Draft, motif: Motif) -> dict[int, Frames]:
    """The copies of each symbol in the body of a motif, the fewest first: those are soon known."""
    symbols = draft.symbol[motif.rows[0]]
    label, count = label_rows(symbols[:, None])
    lists = sorted(members(label, len(count)), key=len)
    return {int(symbols[own[0]]): motif.inside[own] for own in lists}


def _uses(draft: Draft, motif: Motif) -> list[Frames]:
    """The places of a motif in each body that uses it."""
    label, count = label_rows(draft.body[motif.rows[:, :1]])
    return [motif.places[own] for own in members(label, len(count))]


def _without(base: Priced, index: int, gone: Integers, limits: Limits) -> int:
    """Tokens of a list without some of its members, at most: a pattern that lacks one is undone."""
    rows, found = base.lists[index], base.found[index]
    left = np.ones(len(rows), np.bool_)
    left[gone] = False
    if not left.any():
        return 0
    whole = np.ones(len(found.each) + 1, np.bool_)
    whole[-1] = whole[found.patterns[gone]] = False  # the last is for those in no pattern
    singly = base.draft.frames[rows[left & ~whole[found.patterns]]]
    alone = placement_tokens(singly, limits.small)
    return int(found.each[whole[:-1]].sum() + every_token(singly, alone, limits.small)[0])
