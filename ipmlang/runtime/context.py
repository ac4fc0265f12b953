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


class _Items:
    """What stands directly in each branch, branch by branch: modules and opening brackets.

    `place` (n,) their places in the string, `heads` those that are first in their branch.
    """

    def __init__(self, branches: Branches, modules: Whole) -> None:
        inner: Whole = branches.order[branches.opens[1:]].astype(np.int64) - 1
        items = np.concatenate((modules, inner))
        # a bracket stands behind the row before it, and so does the next one there
        rows = np.concatenate((branches.place[modules + 1] * 2, branches.parent[1:] * 2 + 1))
        order: Whole = np.lexsort((items, rows))
        branch = branches.branch()[rows[order] // 2]
        opening = branches.order[branches.opens].astype(np.int64) - 1
        self.place: Whole = items[order]
        self.heads = np.ones(len(items), np.bool_)
        self.heads[1:] = branch[1:] != branch[:-1]
        self.owner: Whole = opening[branch]  # the bracket around each, -1 around the whole string

    def behind(self, wanted: Flags) -> Whole:
        """For each item the number of the nearest wanted one before it in its branch, or -1."""
        numbers = np.arange(len(self.place))
        nearest = np.maximum.accumulate(np.where(wanted, numbers, -1))
        before = np.append(-1, nearest)[:-1]
        first = np.maximum.accumulate(np.where(self.heads, numbers, 0))
        return np.where(before >= first, before, -1)

    def ahead(self, wanted: Flags) -> Whole:
        """For each item the number of the nearest wanted one from it on in its branch, or -1."""
        count = len(self.place)
        numbers = np.arange(count)
        nearest = np.minimum.accumulate(np.where(wanted, numbers, count)[::-1])[::-1]
        ends = np.where(np.append(self.heads[1:], True), numbers, count)
        last = np.minimum.accumulate(ends[::-1])[::-1]
        return np.where(nearest <= last, nearest, -1)


class Neighbours:
    """The neighbours of every module of a string of `length` modules and brackets.

    A branch is read as a sequence of items. `_next` leads from an item to the next of its branch
    that is not ignored, `_head` from an opening bracket to the first such inside, `_from` from an
    item to the first module at or behind it, `_left` from a module to its left neighbour; -1 where
    there is none.
    """

    def __init__(self, program: ir.Program, length: int, tables: dict[int, Modules]) -> None:
        self._tables = tables
        written = [symbol.arity - symbol.carried for symbol in program.symbols]
        self._arity = np.array([*written, 0, 0], np.int64)
        self._symbol = np.full(length, OPEN, np.int64)
        self._row = np.zeros(length, np.int64)
        for symbol, table in tables.items():
            self._symbol[table.place] = symbol
            self._row[table.place] = np.arange(table.count)
        opens = np.flatnonzero(self._symbol == OPEN)
        branches = Branches(length, opens, np.flatnonzero(self._symbol == CLOSE))
        self._link(_Items(branches, np.flatnonzero(self._symbol >= 0)), program.ignore)

    def _link(self, items: _Items, ignored: frozenset[int]) -> None:
        length, place = len(self._symbol), items.place
        symbol = self._symbol[place]
        seen = symbol >= 0
        for number in ignored:
            seen &= symbol != number
        self._head, self._next, self._from, self._left = (
            np.full(length, -1, np.int64) for _ in range(4)
        )
        target = items.ahead(seen | (symbol == OPEN))
        inner = items.heads & (items.owner >= 0)
        self._head[items.owner[inner]] = _at(place, target[inner])
        following = np.append(target[1:], -1)
        following[np.append(items.heads[1:], True)] = -1
        self._next[place] = _at(place, following)
        self._from[place] = _at(place, items.ahead(seen))
        self._left[place] = self._before(items, seen)

    def _before(self, items: _Items, seen: Flags) -> Whole:
        """For each item the module before it: in its branch, or before the branch it stands in."""
        nearest = items.behind(seen)
        left = _at(items.place, nearest)
        number = np.zeros(len(self._symbol), np.int64)
        number[items.place] = np.arange(len(items.place))
        around = np.where(nearest >= 0, -1, items.owner)
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


def _at(places: Whole, numbers: Whole) -> Whole:
    """The places of items by their numbers, -1 for -1."""
    return np.where(numbers >= 0, places[numbers], -1) if len(places) else numbers


def _flat(patterns: Sequence[ir.Pattern]) -> list[ir.Pattern]:
    """The modules of a context in written order, those in its branches too."""
    found: list[ir.Pattern] = []
    for each in patterns:
        found += _flat(each.branch) if each.branch else [each]
    return found


def _size(patterns: Sequence[ir.Pattern]) -> int:
    return len(_flat(patterns))
