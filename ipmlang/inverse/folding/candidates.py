"""Stretches of rows of the same kinds or forms, the most promising first.

Takes a book; gives groups of stretches that could be calls of one rule, each with a bound on the
tokens that it could save. Nothing here looks at numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from operator import attrgetter
from typing import TypeAlias

import numpy as np

from ipmlang.inverse.folding.book import Book, Path, Stretch
from ipmlang.inverse.folding.rows import Kind, Row
from ipmlang.inverse.folding.symbols import given_symbols
from ipmlang.inverse.folding.templates import HEAD, READ
from ipmlang.inverse.lsystem.repeats import apart, find_repeats

Alike: TypeAlias = Callable[[Row], Kind]

KIND: Alike = attrgetter("kind")  # numbers may differ
FORM: Alike = attrgetter("form")  # symbols, too

OFTEN = 12  # repeats of one order of magnitude in length
LONG = 12  # tokens of a bracket that may be a rule of its own


def candidates(book: Book, most: int, alike: Alike) -> list[tuple[int, list[Stretch]]]:
    """The `most` best groups of stretches, each with the tokens that it saves at most; alike: what
    rows of one group have in common.
    """
    sequences = list(book.stretches())
    rows = [row for _, _, own in sequences for row in own]
    homes = [(name, path, k) for name, path, own in sequences for k in range(len(own))]
    found = _stretches(sequences, rows, homes, alike) + _brackets(rows, homes, alike)
    same = alike is KIND
    found += [] if same else _bodies(sequences, homes)
    made = []
    for first, stretches in found:
        size = sum(row.tokens for row in rows[first : first + stretches[0].count])
        bound = size * (len(stretches) - 1) - len(stretches) - HEAD
        if bound > 0 and not same:
            symbols = given_symbols([book.rows_at(each) for each in stretches], book.leaving)
            count = -1 if symbols is None else symbols.count
            bound = bound - count * (len(stretches) + 1 + READ) if count > 0 else 0
        if bound > 0:
            made.append((bound, stretches))
    made.sort(key=lambda each: -each[0])
    return made[:most]


def _stretches(
    sequences: list[tuple[str, Path, tuple[Row, ...]]],
    rows: list[Row],
    homes: list[tuple[str, Path, int]],
    alike: Alike,
) -> list[tuple[int, list[Stretch]]]:
    """Two rows or more that occur twice or more, with where they occur first."""
    known: dict[object, int] = {}
    kinds = [known.setdefault(alike(row), len(known)) for row in rows]
    ends = set(np.cumsum([len(own) for _, _, own in sequences]).tolist())
    steps: dict[object, int] = {}
    labels = [
        steps.setdefault(("end", k) if k + 1 in ends else pair, len(steps))
        for k, pair in enumerate(pairwise(kinds))
    ]
    weight = np.array([row.tokens for row in rows[: len(labels)]], np.float64)
    found = []
    for repeat in find_repeats(np.array(labels, np.int64), weight, OFTEN):
        count = repeat.length + 1
        places = apart(repeat.places, count).tolist()
        if len(places) > 1 and count > 1:
            found.append((places[0], [_stretch(homes[place], count) for place in places]))
    return found


def _stretch(home: tuple[str, Path, int], count: int) -> Stretch:
    name, path, begin = home
    return Stretch(name, path, begin, count)


def _brackets(
    rows: list[Row], homes: list[tuple[str, Path, int]], alike: Alike
) -> list[tuple[int, list[Stretch]]]:
    """Brackets of the same kinds."""
    found: dict[Kind, list[int]] = {}
    for place, row in enumerate(rows):
        if row.inner and row.tokens >= LONG:
            found.setdefault(alike(row), []).append(place)
    return [
        (places[0], [_stretch(homes[place], 1) for place in places])
        for places in found.values()
        if len(places) > 1
    ]


def _bodies(
    sequences: list[tuple[str, Path, tuple[Row, ...]]], homes: list[tuple[str, Path, int]]
) -> list[tuple[int, list[Stretch]]]:
    """Whole rules of the same forms: where symbols may be any, few repeats end as they do."""
    places = {home: place for place, home in enumerate(homes)}
    found: dict[tuple[Kind, ...], list[Stretch]] = {}
    for name, path, rows in sequences:
        if not path and len(rows) > 1:
            form = tuple(row.form for row in rows)
            found.setdefault(form, []).append(Stretch(name, path, 0, len(rows)))
    return [(places[own[0].rule, (), 0], own) for own in found.values() if len(own) > 1]
