"""Stretches of rows of the same kinds or forms, the most promising first.

Takes a book; gives groups of stretches that could be calls of one rule, each with a bound on the
tokens that it could save. Nothing here looks at numbers.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import accumulate, pairwise
from operator import attrgetter
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.folding.book import Book, Stretch
from ipmlang.inverse.folding.fits import HEAD, READ
from ipmlang.inverse.folding.known_rows import Listed, Path
from ipmlang.inverse.folding.rows import Row
from ipmlang.inverse.folding.symbols import given_symbols
from ipmlang.inverse.lsystem.repeats import apart, find_repeats

Integers = NDArray[np.int64]
Alike: TypeAlias = Callable[[Listed], Sequence[int]]

KIND: Alike = attrgetter("kinds")  # numbers may differ
FORM: Alike = attrgetter("forms")  # symbols, too

OFTEN = 12  # repeats of one order of magnitude in length
LONG = 12  # tokens of a bracket that may be a rule of its own


@dataclass(frozen=True, slots=True, eq=False)
class _Lines:
    """All sequences of rows of a book, one after the other.

    homes: the rule of each sequence and its path there; first: where it begins; rows: of all;
    kinds: a number for each, equal for rows that are alike; total: (n + 1,) tokens of the rows
    before each.
    """

    book: Book
    homes: list[tuple[str, Path]]
    first: list[int]
    rows: list[Row]
    kinds: list[int]
    total: list[int]

    def stretch(self, place: int, count: int) -> Stretch:
        """The stretch of rows from a place on."""
        home = bisect(self.first, place) - 1
        return Stretch(*self.homes[home], place - self.first[home], count)

    def bound(self, first: int, count: int, often: int) -> int:
        """Tokens that so many stretches of so many rows save at most."""
        size = self.total[first + count] - self.total[first]
        return size * (often - 1) - often - HEAD

    def symbols(self, places: Sequence[int], count: int) -> int:
        """How many symbols would be parameters, -1 for too many."""
        stretches = [self.rows[place : place + count] for place in places]
        symbols = given_symbols(stretches, self.book.leaving)
        return -1 if symbols is None else symbols.count


def _lines(book: Book, alike: Alike) -> _Lines:
    known, lines = book.known, _Lines(book, [], [], [], [], [])
    tokens: list[int] = []
    for name, rows in book.plain.items():
        own, before = known.listed(rows), len(lines.rows)
        lines.homes.extend([(name, path) for path in own.paths])
        lines.first.extend([before + each for each in own.first])
        lines.rows.extend(own.rows)
        lines.kinds.extend(alike(own))
        tokens.extend(own.tokens)
    lines.total.extend(accumulate(tokens, initial=0))
    return lines


def candidates(book: Book, most: int, alike: Alike) -> list[tuple[int, list[Stretch]]]:
    """The `most` best groups of stretches, each with the tokens that it saves at most; alike: what
    rows of one group have in common.
    """
    lines = _lines(book, alike)
    found = [*_repeated(lines), *_brackets(lines)]
    found += [] if alike is KIND else _bodies(lines)
    # What overlaps, and symbols that are parameters, only make bounds less.
    loose = [lines.bound(int(places[0]), count, len(places)) for places, count in found]
    made: list[tuple[int, int, list[int], int]] = []
    best: list[int] = []
    for bound, which in sorted((-each, which) for which, each in enumerate(loose)):
        if bound >= 0 or (len(best) == most and -bound < best[0]):
            break
        all_places, count = found[which]
        places = apart(all_places, count).tolist()
        bound = lines.bound(places[0], count, len(places))
        if bound > 0 and alike is not KIND:
            symbols = lines.symbols(places, count)
            bound = bound - symbols * (len(places) + 1 + READ) if symbols > 0 else 0
        if bound > 0:
            made.append((-bound, which, places, count))
            heappush(best, bound)
            if len(best) > most:
                heappop(best)
    made.sort(key=lambda each: each[:2])
    return [
        (-bound, [lines.stretch(place, count) for place in places])
        for bound, _, places, count in made[:most]
    ]


def _repeated(lines: _Lines) -> Iterator[tuple[Integers, int]]:
    """Where two rows or more begin that occur twice or more, and how many they are."""
    last = {each - 1 for each in lines.first[1:]}
    steps: dict[object, int] = {}
    labels = [
        steps.setdefault(("end", k) if k in last else pair, len(steps))
        for k, pair in enumerate(pairwise(lines.kinds))
    ]
    weight = np.diff(np.array(lines.total[: len(labels) + 1], np.float64))
    for repeat in find_repeats(np.array(labels, np.int64), weight, OFTEN):
        if repeat.length:
            yield repeat.places, repeat.length + 1


def _brackets(lines: _Lines) -> Iterator[tuple[Integers, int]]:
    """Brackets of the same kinds."""
    found: dict[int, list[int]] = {}
    for place, row in enumerate(lines.rows):
        if row.inner and row.tokens >= LONG:
            found.setdefault(lines.kinds[place], []).append(place)
    for places in found.values():
        if len(places) > 1:
            yield np.array(places, np.int64), 1


def _bodies(lines: _Lines) -> Iterator[tuple[Integers, int]]:
    """Whole rules of the same forms: where symbols may be any, few repeats end as they do."""
    found: dict[tuple[int, ...], list[int]] = {}
    ends = pairwise([*lines.first, len(lines.rows)])
    for (_, path), (first, end) in zip(lines.homes, ends, strict=True):
        if end - first > 1 and not path:
            found.setdefault(tuple(lines.kinds[first:end]), []).append(first)
    for form, places in found.items():
        if len(places) > 1:
            yield np.array(places, np.int64), len(form)
