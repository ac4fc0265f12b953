"""Rules that do not earn their keep are put back where they are used, in whole or in part.

Takes a draft, gives one that is no longer: a rule used once, or one that what was found later made
needless, is replaced by what it draws, and patterns that a rule has a piece of are made whole where
it is used. Nothing here finds rules.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipmlang.inverse.frames import Integers, compose, join
from ipmlang.inverse.split.cost import HEAD
from ipmlang.inverse.split.search.drafts import Draft, Limits
from ipmlang.inverse.split.search.patterns import FEWEST, Memory, arranged_lists
from ipmlang.inverse.split.search.pricing import LOOSE, at_least, may_be_loose
from ipmlang.inverse.split.snapping import label_rows, members


def tokens_of(draft: Draft, limits: Limits, memory: Memory, most: float = np.inf) -> float:
    """Tokens of all bodies, each symbol's copies in its patterns; where they are more than `most`,
    some number above that.
    """
    label, count = label_rows(np.stack([draft.body, draft.symbol], axis=1))
    lists = sorted(members(label, len(count)), key=len)  # short ones are soon known
    total = float(HEAD * len(np.unique(np.append(draft.body, 0))))
    total += sum(at_least(len(rows)) for rows in lists)
    loose = may_be_loose(draft, lists).tolist()
    found = arranged_lists(draft, lists, limits, memory)
    for rows, each, may_be in zip(lists, found, loose, strict=True):
        total += each.tokens - at_least(len(rows)) + LOOSE * each.single * may_be
        if total > most:
            break
    return total


def pruned(draft: Draft, limits: Limits, memory: Memory) -> Draft:
    """The draft without the rules that do not pay; their bodies stay empty."""
    now = tokens_of(draft, limits, memory)
    while True:
        for body in range(draft.bodies - 1, 0, -1):
            if not (draft.body == body).any():
                continue
            other = unfolded(draft, body)
            tokens = tokens_of(other, limits, memory, now)
            if tokens <= now:
                draft, now = other, tokens
                break
        else:
            return draft


def with_whole_patterns(draft: Draft, limits: Limits, memory: Memory) -> Draft:
    """The draft with patterns that stand where a rule is used in place of pieces of them in the
    rule, if that is no longer: a ring of twenty for two halves of ten. Patterns of a rule that have
    as many members go together.
    """
    now = tokens_of(draft, limits, memory)
    label, count = label_rows(np.stack([draft.body, draft.symbol], axis=1))
    pieces: dict[tuple[int, int], list[int]] = {}
    for rows in members(label, len(count)):
        body = int(draft.body[rows[0]])
        if body > 0 and len(rows) >= FEWEST and _is_pattern(draft, rows, limits, memory):
            pieces.setdefault((body, len(rows)), []).append(int(draft.symbol[rows[0]]))
    for (body, _), symbols in pieces.items():
        other = unfolded(draft, body, symbols)
        if not (other.body == body).any() or not _are_whole(other, symbols, limits, memory):
            continue
        if tokens_of(other, limits, memory, now) <= now:
            return with_whole_patterns(other, limits, memory)
    return draft


def _are_whole(draft: Draft, symbols: Sequence[int], limits: Limits, memory: Memory) -> bool:
    """Whether all copies of each of some symbols stand in one pattern."""
    every = (np.flatnonzero(draft.symbol == symbol) for symbol in symbols)
    return all(
        len(np.unique(draft.body[rows])) == 1 and _is_pattern(draft, rows, limits, memory)
        for rows in every
    )


def _is_pattern(draft: Draft, rows: Integers, limits: Limits, memory: Memory) -> bool:
    """Whether rows of one symbol in one body are one row, grid or ring."""
    found = next(iter(arranged_lists(draft, [rows], limits, memory)))
    return len(found.each) == 1 and not found.single


def unfolded(draft: Draft, body: int, parts: Sequence[int] | None = None) -> Draft:
    """The draft with what a body draws in place of each use of it, or beside that its copies of
    some symbols alone, which it then has no more.
    """
    symbol = draft.classes + body - 1
    inside = draft.body == body
    inside &= True if parts is None else np.isin(draft.symbol, parts)
    uses, own = np.nonzero(draft.symbol == symbol)[0], np.nonzero(inside)[0]
    kept = ~inside & ((draft.symbol != symbol) | (parts is not None))
    outer, inner = np.repeat(uses, len(own)), np.tile(own, len(uses))
    return Draft(
        draft.figures,
        draft.classes,
        np.concatenate([draft.body[kept], draft.body[outer]]),
        np.concatenate([draft.symbol[kept], draft.symbol[inner]]),
        join([draft.frames[kept], compose(draft.frames[outer], draft.frames[inner])]),
    )
