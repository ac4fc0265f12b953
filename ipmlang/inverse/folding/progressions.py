"""Rows that go on by equal steps, as repeats: `repeat(i < 3) { [at(70, 400 - 120 * i) A] }`.

Takes rows; gives elements, with a repeat, or a repeat in a repeat, wherever that is shorter. Any
number of a row may change by an equal step, its arguments too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, field
from itertools import groupby
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ast
from ipmlang.inverse.folding.fits import FINE, PLACES, Rounding
from ipmlang.inverse.folding.known_rows import KnownRows
from ipmlang.inverse.folding.rows import Row, element, element_tokens, plain
from ipmlang.inverse.folding.templates import TURNED, labels_of
from ipmlang.inverse.numbers import linear

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
VARIABLES = ("i", "j")
LEAST = 2  # tokens that a repeat must save
FEWEST = 3  # rows that can be told to go on by equal steps


@dataclass(frozen=True, slots=True, eq=False)
class _Grid:
    """lines × length rows that begin at a row: row i, j is first + i * across + j * along."""

    lines: int
    length: int
    across: Floats
    along: Floats

    @property
    def rows(self) -> int:
        """How many there are."""
        return self.lines * self.length


def with_repeats(
    rows: Sequence[Row], given: Rounding, leaving: Set[str]
) -> tuple[ast.Element, ...]:
    """The rows as elements, what goes on by equal steps as repeats."""
    return tuple(_elements(rows, given, leaving))


@dataclass(frozen=True, slots=True, eq=False)
class RepeatTokens:
    """Tokens that rows take with repeats, counted once for the same rows; each with those rows, so
    that no others get their number.
    """

    known: KnownRows
    leaving: Set[str]
    _runs: dict[tuple[int, ...], tuple[tuple[Row, ...], int]] = field(default_factory=dict)

    def of(self, rows: tuple[Row, ...]) -> int:
        """Of rows that stand one after the other."""
        runs = [list(own) for _, own in groupby(rows, self.known.kind)]
        return sum(self._of_run(tuple(run)) for run in runs)

    def _of_run(self, rows: tuple[Row, ...]) -> int:
        """Of rows of one kind."""
        if not (rows[0].placed and len(rows) >= FEWEST):
            return sum(map(self._of_one, rows))
        key = tuple(map(id, rows))
        found = self._runs.get(key)
        if found is None:
            made = _run(rows, self.known.given, self.leaving)
            found = self._runs[key] = rows, sum(map(element_tokens, made))
        return found[1]

    def _of_one(self, row: Row) -> int:
        """Of a row by itself."""
        if not row.inner and row.name not in self.leaving:
            return row.tokens
        if row.inner and not row.turning:
            return row.tokens - sum(each.tokens for each in row.inner) + self.of(row.inner)
        found = self._runs.get((id(row),))
        if found is None:
            made = _one(row, self.known.given, self.leaving)
            found = self._runs[id(row),] = (row,), element_tokens(made)
        return found[1]


def _elements(rows: Sequence[Row], given: Rounding, leaving: Set[str]) -> Iterator[ast.Element]:
    for _, own in groupby(rows, attrgetter("kind")):
        yield from _of_one_kind(list(own), given, leaving)


def _of_one_kind(rows: Sequence[Row], given: Rounding, leaving: Set[str]) -> Iterator[ast.Element]:
    if rows[0].placed and len(rows) >= FEWEST:
        return _run(rows, given, leaving)
    return (_one(row, given, leaving) for row in rows)


def _one(row: Row, given: Rounding, leaving: Set[str]) -> ast.Element:
    """A row by itself, what is in it with repeats."""
    made = plain(row, leaving)
    if not row.inner or not isinstance(made, ast.Bracket):
        return made
    inner = with_repeats(row.inner, given, leaving)
    return ast.Bracket((*made.body[: len(made.body) - len(row.inner)], *inner))


def _run(rows: Sequence[Row], given: Rounding, leaving: Set[str]) -> Iterator[ast.Element]:
    """Rows of one kind."""
    table = np.array([row.numbers for row in rows])
    turned = np.array([word in TURNED for word in labels_of(rows[0])], np.bool_)
    errors = np.where(turned, FINE, given.error)
    places = np.where(turned, PLACES, given.places)
    start = 0
    while start < len(rows):
        best: tuple[int, int, ast.Element] | None = None
        for grid in _grids(table[start:], errors, places):
            made = _repeat(rows[start], table[start], grid, leaving)
            alone = sum(row.tokens for row in rows[start : start + grid.rows])
            saved = alone - element_tokens(made)
            if saved >= LEAST and (best is None or saved > best[0]):
                best = saved, grid.rows, made
        if best is None:
            yield _one(rows[start], given, leaving)
            start += 1
        else:
            yield best[2]
            start += best[1]


def _grids(table: Floats, errors: Floats, places: Integers) -> Iterator[_Grid]:
    """What the first rows (n, h) could be: a row, or lines of equal length, by steps as they are
    printed; errors, places: (h,) what a number may be off, and the decimals of its step.
    """
    if len(table) < FEWEST:
        return
    along = _step(table[0], table[1], places)
    index = np.arange(len(table))[:, None]
    off = (np.abs(table - table[0] - along * index) > errors).any(axis=1)
    length = int(np.argmax(off)) if off.any() else len(table)
    if length >= FEWEST:
        yield _Grid(1, length, along, along)
    if 2 <= length <= len(table) // 2:
        across = _step(table[0], table[length], places)
        wanted = table[0] + along * (index % length) + across * (index // length)
        wrong = (np.abs(table - wanted) > errors).any(axis=1)
        lines = (int(np.argmax(wrong)) if wrong.any() else len(table)) // length
        if lines >= 2:
            yield _Grid(lines, length, across, along)


def _step(one: Floats, other: Floats, places: Integers) -> Floats:
    """(h,) from one row to another, without what differences of decimals are off."""
    steps = zip((other - one).tolist(), places.tolist(), strict=True)
    return np.array([round(step, own) + 0.0 for step, own in steps])


def _repeat(first: Row, numbers: Floats, grid: _Grid, leaving: Set[str]) -> ast.Element:
    """The repeat of a grid whose first row has these numbers."""
    outer, inner = VARIABLES
    values: list[ast.Expr] = []
    steps = zip(numbers.tolist(), grid.across.tolist(), grid.along.tolist(), strict=True)
    for start, across, along in steps:
        if grid.lines == 1:
            values.append(linear(start, along, outer, (0.0, 0.0)))
        else:
            values.append(_sum(start, ((across, outer), (along, inner))))
    body = element(first, values, leaving)
    if not isinstance(body, ast.Bracket):
        body = ast.Bracket((body,))
    if grid.lines == 1:
        return _counted(outer, grid.length, body)
    return _counted(outer, grid.lines, _counted(inner, grid.length, body))


def _counted(variable: str, count: int, body: ast.Element) -> ast.Repeat:
    return ast.Repeat(ast.Count(variable, ast.Number(float(count))), (body,))


def _sum(start: float, terms: Sequence[tuple[float, str]]) -> ast.Expr:
    """`start + a * i - b * j`, what is nothing left out."""
    made: ast.Expr | None = ast.Number(start) if start else None
    for slope, name in sorted(terms, key=lambda each: each[0] < 0 and not start):
        if not slope:
            continue
        if made is None:
            made = linear(0.0, slope, name, (0.0, 0.0))
            continue
        size = abs(slope)
        term: ast.Expr = ast.Name(name)
        if size != 1:
            term = ast.Binary("*", ast.Number(size), term)
        made = ast.Binary("+" if slope > 0 else "-", made, term)
    return ast.Number(0.0) if made is None else made
