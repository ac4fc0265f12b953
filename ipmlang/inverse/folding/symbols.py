"""Which symbols differ between stretches of rows that are alike in all else, and as what.

Takes stretches of rows of one form; gives the symbols that vary as parameters, those that always
vary together as one, and the rows with a mark in the place of each. Nothing here knows numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace

from ipmlang.inverse.folding.rows import Row

MARK = "?"  # before the number of a parameter, where a symbol stands; no name begins so
LABEL = "shape"  # what such a parameter is called, as the column of a table is
MOST_SYMBOLS = 2  # that a person can tell apart in a call


@dataclass(frozen=True, slots=True)
class Given:
    """rows: of the first stretch, marked; names: (k, p) the symbols that each stretch gives."""

    rows: tuple[Row, ...]
    names: tuple[tuple[str, ...], ...]

    @property
    def count(self) -> int:
        """How many parameters there are."""
        return len(self.names[0])

    @property
    def things(self) -> int:
        """How many symbols the rows place."""
        return sum(map(_things, self.rows))


def given_symbols(stretches: Sequence[Sequence[Row]], bound: Set[str]) -> Given | None:
    """The parameters that are symbols; bound: names that no parameter can be. None where there
    would be too many.
    """
    table = [tuple([name for row in rows for name in row.names]) for rows in stretches]
    if len(set(table)) == 1:
        return Given(tuple(stretches[0]), ((),) * len(stretches))
    marks: dict[tuple[str, ...], str] = {}
    shown: list[str] = []
    for column in zip(*table, strict=True):
        if len(set(column)) == 1:
            shown.append(column[0])
        elif not bound.isdisjoint(column) or any(name.startswith(MARK) for name in column):
            return None
        else:
            shown.append(marks.setdefault(column, f"{MARK}{len(marks)}"))
            if len(marks) > MOST_SYMBOLS:
                return None
    rows = _shown(stretches[0], shown) if marks else tuple(stretches[0])
    names = tuple(zip(*marks, strict=True)) if marks else ((),) * len(stretches)
    return Given(rows, names)


def with_marks(rows: Sequence[Row], names: Mapping[str, str]) -> tuple[Row, ...]:
    """The rows with names in the place of marks."""
    if not names:
        return tuple(rows)
    every = [name for row in rows for name in row.names]
    return _shown(rows, [names.get(each, each) for each in every])


def _things(row: Row) -> int:
    return sum(map(_things, row.inner)) if row.inner else 1


def _shown(rows: Sequence[Row], names: list[str]) -> tuple[Row, ...]:
    """The rows with other symbols, those of all rows one after the other."""
    waiting = iter(names)

    def shown(row: Row) -> Row:
        if not row.names:
            return row
        if row.symbols:
            return replace(row, symbols=tuple(next(waiting) for _ in row.symbols))
        if row.inner:
            return replace(row, inner=tuple(map(shown, row.inner)))
        return replace(row, name=next(waiting))

    return tuple(map(shown, rows))
