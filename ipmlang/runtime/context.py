"""What stands to the left and to the right of a module in a bracketed string.

In go the modules of a string with their places; out come, for a production with contexts, the
modules that match and the arguments their contexts bring. The left neighbour is the nearest module
on the way back to the start of the string, branches passed over; the right one is the next in the
same branch, where a pattern's branches look into those of the string (*The Algorithmic Beauty of
Plants*, pp. 30-32). Ignored symbols are looked through. Nothing here rewrites.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.compiler import ir
from ipmlang.runtime.branches import Branches
from ipmlang.runtime.choose import Match
from ipmlang.runtime.rewrite import CLOSE, OPEN, Modules
from ipmlang.runtime.scan import Whole
from ipmlang.runtime.values import Flags, Value, spread

ANY = -1


@dataclass(slots=True, eq=False)
class _Found:
    """Rows that match so far, and the places (m,) of the modules that each pattern matched."""

    alive: Flags
    modules: list[tuple[ir.Pattern, Whole]]


class Neighbours:
    """The neighbours of every module of a string of `length` modules and brackets.

    A branch is read as a sequence of items: its modules and the opening brackets of its branches.
    `_next` leads from an item to the next of its branch, `_head` from an opening bracket to the
    first item inside, `_from` from an item to the first module at or behind it, `_left` from a
    module to its left neighbour; -1 where there is none.
    """

    def __init__(self, program: ir.Program, length: int, tables: dict[int, Modules]) -> None:
        self._tables = tables
        self._arity = np.array([symbol.arity for symbol in program.symbols] + [0, 0], np.int64)
        self._symbol = np.full(length, OPEN, np.int64)
        self._row = np.zeros(length, np.int64)
        for symbol, table in tables.items():
            self._symbol[table.place] = symbol
            self._row[table.place] = np.arange(table.count)
        opens = np.flatnonzero(self._symbol == OPEN)
        branches = Branches(length, opens, np.flatnonzero(self._symbol == CLOSE))
        seen = self._symbol >= 0
        for symbol in program.ignore:
            seen &= self._symbol != symbol
        self._link(branches, np.flatnonzero(seen), opens)

    def _link(self, branches: Branches, seen: Whole, opens: Whole) -> None:
        inner: Whole = branches.order[branches.opens[1:]].astype(np.int64) - 1
        items = np.concatenate((seen, inner))
        place = np.concatenate((branches.place[seen + 1] * 2, branches.parent[1:] * 2 + 1))
        order: Whole = np.lexsort((items, place))
        items = items[order]
        branch = branches.branch()[place[order] // 2]
        heads = np.ones(len(items), np.bool_)
        heads[1:] = branch[1:] != branch[:-1]
        tails = np.roll(heads, -1)
        length = len(self._symbol)
        self._next = np.full(length, -1, np.int64)
        self._next[items[~tails]] = np.append(items[1:], -1)[~tails]
        self._head = np.full(length + 1, -1, np.int64)
        owner = branches.order[branches.opens] - 1  # -1 for the whole string: the spare last cell
        self._head[owner[branch[heads]]] = items[heads]
        self._from = np.full(length, -1, np.int64)
        self._from[items] = self._reached(items, tails)
        self._left = np.full(length, -1, np.int64)
        self._left[items] = self._before(items, heads, owner[branch])

    def _reached(self, items: Whole, tails: Flags) -> Whole:
        """For each item the first module at or behind it in its branch."""
        count = len(items)
        index = np.where(self._symbol[items] >= 0, np.arange(count), count)
        nearest = np.minimum.accumulate(index[::-1])[::-1]
        ends = np.where(tails, np.arange(count), count)
        last = np.minimum.accumulate(ends[::-1])[::-1]
        return np.where(nearest <= last, items[np.minimum(nearest, count - 1)], -1)

    def _before(self, items: Whole, heads: Flags, owner: Whole) -> Whole:
        """For each item the module before it: in its branch, or before the branch it stands in."""
        count = len(items)
        modules = np.where(self._symbol[items] >= 0, np.arange(count), -1)
        nearest = np.append(-1, np.maximum.accumulate(modules))[:-1]
        first = np.maximum.accumulate(np.where(heads, np.arange(count), 0))
        inside = nearest >= first
        left = np.where(inside, items[nearest], -1)
        number = np.zeros(len(self._symbol), np.int64)
        number[items] = np.arange(count)
        around = np.where(inside, -1, owner)
        while (around >= 0).any():
            rows = np.flatnonzero(around >= 0)
            above = number[around[rows]]
            found, further = left[above], around[above]
            left[rows] = found
            around[rows] = np.where(found >= 0, -1, further)
        return left

    def of(self, table: Modules) -> Match:
        """What matches among the modules of a table."""

        def match(
            production: ir.Production, rows: Whole
        ) -> tuple[Flags, tuple[Value, ...], tuple[Value, ...]]:
            places = table.place[rows]
            left = self._behind(production.left, places)
            right = self._ahead(production.right, self._next[places], left.alive)
            return right.alive, self._captured(left), self._captured(right)

        return match

    def _behind(self, patterns: Sequence[ir.Pattern], places: Whole) -> _Found:
        found = _Found(np.ones(len(places), np.bool_), [])
        at = places
        for pattern in reversed(patterns):
            at = np.where(at >= 0, self._left[at], -1)
            self._matched(pattern, at, found)
        found.modules.reverse()
        return found

    def _ahead(self, patterns: Sequence[ir.Pattern], item: Whole, alive: Flags) -> _Found:
        found = _Found(alive.copy(), [])
        for pattern in patterns:
            if pattern.branch:
                item = self._into(pattern, item, found)
                continue
            at = np.where(item >= 0, self._from[item], -1)
            self._matched(pattern, at, found)
            item = np.where(at >= 0, self._next[at], -1)
        return found

    def _into(self, pattern: ir.Pattern, item: Whole, found: _Found) -> Whole:
        """Look into the branches that come next, one after the other, until one matches."""
        item = item.copy()
        matched = np.zeros(len(item), np.bool_)
        places = [np.zeros(len(item), np.int64) for _ in range(_size(pattern.branch))]
        inner: list[tuple[ir.Pattern, Whole]] = []
        trying = np.flatnonzero(found.alive & (item >= 0))
        while True:
            trying = trying[item[trying] >= 0]
            trying = trying[self._symbol[item[trying]] == OPEN]
            if not len(trying):
                break
            head = self._head[item[trying]]
            inside = self._ahead(pattern.branch, head, np.ones(len(trying), np.bool_))
            item[trying] = self._next[item[trying]]
            hit = trying[inside.alive]
            matched[hit] = True
            for column, (_, at) in zip(places, inside.modules, strict=True):
                column[hit] = at[inside.alive]
            inner = inside.modules
            trying = trying[~inside.alive]
        found.alive &= matched
        patterns = [each for each, _ in inner] or _flat(pattern.branch)
        found.modules += list(zip(patterns, places, strict=True))
        return item

    def _matched(self, pattern: ir.Pattern, at: Whole, found: _Found) -> None:
        found.alive &= at >= 0
        if pattern.symbol != ANY:
            found.alive &= self._symbol[at] == pattern.symbol
        elif pattern.arity:
            found.alive &= self._arity[self._symbol[at]] == pattern.arity
        found.modules.append((pattern, at))

    def _captured(self, found: _Found) -> tuple[Value, ...]:
        return tuple(
            self._argument(pattern.symbol, number, np.where(found.alive, at, -1))
            for pattern, at in found.modules
            for number in range(pattern.arity)
        )

    def _argument(self, wanted: int, number: int, at: Whole) -> Value:
        """Argument `number` of the modules at some places, 0 where the place is -1."""
        symbols = self._symbol[at]
        values = np.zeros(len(at))
        for symbol in np.unique(symbols[at >= 0]).tolist() if wanted == ANY else [wanted]:
            table = self._tables.get(symbol) if symbol >= 0 else None
            if table is not None:
                rows = np.flatnonzero((at >= 0) & (symbols == symbol))
                values[rows] = spread(table.params[number], self._row[at[rows]])
        return values


def _flat(patterns: Sequence[ir.Pattern]) -> list[ir.Pattern]:
    """The modules of a context in written order, those in its branches too."""
    found: list[ir.Pattern] = []
    for each in patterns:
        found += _flat(each.branch) if each.branch else [each]
    return found


def _size(patterns: Sequence[ir.Pattern]) -> int:
    return len(_flat(patterns))
