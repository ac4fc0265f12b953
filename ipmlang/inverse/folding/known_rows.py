"""Rows that say the same are one object: what is known of a row is known wherever it stands.

Takes rows; gives the one row that says what each says, at another place or with other rows in it
too, numbers for kinds and forms, and the rows of a rule in place of calls of it. What was made once
is made once for all books of one folding. Nothing here decides what is shorter.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import TypeAlias

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.folding.fits import Rounding
from ipmlang.inverse.folding.rows import Frame, Row, frames_of
from ipmlang.inverse.lsystem.frames import Frames, compose, wrap

Rows: TypeAlias = "tuple[Row, ...]"
Path: TypeAlias = "tuple[int, ...]"  # from a rule's rows down to those of an inner row


@dataclass(frozen=True, slots=True, eq=False)
class Listed:
    """The rows of a rule, those in brackets after the sequence that the bracket stands in.

    paths, first: of each sequence, from the rule down, and where it begins; rows: of all, with what
    each takes, and the numbers of its kind and form.
    """

    paths: list[Path]
    first: list[int]
    rows: list[Row]
    tokens: list[int]
    kinds: list[int]
    forms: list[int]


@dataclass(slots=True, eq=False)
class KnownRows:
    """given: how numbers are rounded. What is kept by the identity of an object is kept with it, so
    that no other object gets its number.
    """

    given: Rounding
    _rows: dict[object, Row] = field(default_factory=dict)
    _pens: dict[tuple[ast.Module, ...], tuple[ast.Module, ...]] = field(default_factory=dict)
    _others: dict[ast.Element, ast.Element] = field(default_factory=dict)
    _kinds: dict[object, int] = field(default_factory=dict)
    _forms: dict[object, int] = field(default_factory=dict)
    _kind_of: dict[int, tuple[Row, int]] = field(default_factory=dict)
    _form_of: dict[int, tuple[Row, int]] = field(default_factory=dict)
    _rules: dict[tuple[int, ...], Rows] = field(default_factory=dict)
    _listed: dict[int, tuple[Rows, Listed]] = field(default_factory=dict)
    _inside: dict[int, tuple[Rows, list[tuple[Path, Rows]]]] = field(default_factory=dict)
    _written: dict[tuple[int, int], tuple[Row, Rows, Rows]] = field(default_factory=dict)
    _named: dict[int, tuple[Rows, Mapping[str, int]]] = field(default_factory=dict)

    # -------------------------------------------------------------------- the one row

    def read(self, rows: Sequence[Row]) -> Rows:
        """The rows as these are known, rows read from a file."""
        return tuple(
            self._row(
                row.frame,
                row.hand,
                self._pens.setdefault(row.pens, row.pens),
                row.name,
                row.args,
                self.read(row.inner),
                None if row.other is None else self._others.setdefault(row.other, row.other),
                row.origin,
                row.symbols,
            )
            for row in rows
        )

    def same(self, row: Row) -> Row:
        """The row that says this."""
        return self.holding(row, row.inner)

    def rule(self, rows: Rows) -> Rows:
        """The rows, as the one object that is all of these."""
        return self._rules.setdefault(tuple(map(id, rows)), rows)

    def holding(self, row: Row, inner: Rows) -> Row:
        """A row with other rows in it."""
        return self._row(
            row.frame, row.hand, row.pens, row.name, row.args, inner, row.other, row.origin,
            row.symbols,
        )  # fmt: skip

    def _placed(self, row: Row, frame: Frame, hand: int, origin: str) -> Row:
        return self._row(
            frame, hand, row.pens, row.name, row.args, row.inner, row.other, row.origin or origin,
            row.symbols,
        )  # fmt: skip

    def _row(
        self,
        frame: Frame,
        hand: int,
        pens: tuple[ast.Module, ...],
        name: str,
        args: tuple[float, ...],
        inner: Rows,
        other: ast.Element | None,
        origin: str,
        symbols: tuple[str, ...],
    ) -> Row:
        inside = tuple(map(id, inner)) if inner else ()
        key = frame, hand, id(pens), name, args, inside, id(other), origin, symbols
        known = self._rows.get(key)
        if known is None:
            known = Row(frame, hand, pens, name, args, inner, other, origin, symbols)
            self._rows[key] = known
        return known

    # -------------------------------------------------------------------- numbers of rows

    def kind(self, row: Row) -> int:
        """A number for each `Row.kind`."""
        found = self._kind_of.get(id(row))
        if found is None:
            inner = tuple(map(self.kind, row.inner))
            args = row.symbols, len(row.args)
            key = row.hand, id(row.pens), row.name, args, inner, id(row.other)
            found = self._kind_of[id(row)] = row, self._kinds.setdefault(key, len(self._kinds))
        return found[1]

    def form(self, row: Row) -> int:
        """A number for each `Row.form`."""
        found = self._form_of.get(id(row))
        if found is None:
            inner = tuple(map(self.form, row.inner))
            name = "" if row.names and not row.symbols else row.name
            args = len(row.symbols), len(row.args)
            key = row.hand, id(row.pens), name, args, inner, id(row.other)
            found = self._form_of[id(row)] = row, self._forms.setdefault(key, len(self._forms))
        return found[1]

    def listed(self, rows: Rows) -> Listed:
        """The rows of a rule, those in brackets too."""
        found = self._listed.get(id(rows))
        if found is None:
            found = self._listed[id(rows)] = rows, self._list(rows)
        return found[1]

    def _list(self, rows: Rows) -> Listed:
        sequences = [(path, own) for path, own in self.inside(rows) if own]
        every = [row for _, own in sequences for row in own]
        return Listed(
            [path for path, _ in sequences],
            list(accumulate((len(own) for _, own in sequences[:-1]), initial=0)),
            every,
            [row.tokens for row in every],
            [self.kind(row) for row in every],
            [self.form(row) for row in every],
        )

    def inside(self, rows: Rows) -> Sequence[tuple[Path, Rows]]:
        """The rows of a rule, and those in brackets, each with the path to them."""
        found = self._inside.get(id(rows))
        if found is None:
            found = self._inside[id(rows)] = rows, list(_inside(rows, ()))
        return found[1]

    def named(self, rows: Rows) -> Mapping[str, int]:
        """How often each name stands in the rows of a rule."""
        found = self._named.get(id(rows))
        if found is None:
            found = rows, Counter(name for row in rows for name in row.named)
            self._named[id(rows)] = found
        return found[1]

    # -------------------------------------------------------------------- rules written out

    def written_out(self, calls: Sequence[Row], inner: Rows) -> list[Rows]:
        """For each call of a rule the rows of the rule in its place."""
        new = {id(call): call for call in calls if (id(call), id(inner)) not in self._written}
        if all(row.placed for row in inner):
            plain = [call for call in new.values() if not call.pens]
            for call, rows in zip(plain, self._moved(plain, inner), strict=True):
                self._written[id(call), id(inner)] = call, inner, rows
        for call in new.values():
            if (id(call), id(inner)) not in self._written:
                self._written[id(call), id(inner)] = call, inner, (self._bracket(call, inner),)
        return [self._written[id(call), id(inner)][2] for call in calls]

    def _moved(self, calls: Sequence[Row], inner: Rows) -> list[Rows]:
        """The rows as they stand in each call."""
        if not calls:
            return []
        places = _rounded(compose(frames_of(calls)[:, None], frames_of(inner)), self.given)
        stands = iter(places.flat().rows())
        made: list[Rows] = []
        for call in calls:
            origin = call.origin or call.name
            own = []
            for row in inner:
                x, y, angle, scale, hand = next(stands)
                own.append(self._placed(row, (x, y, angle, scale), hand, origin))
            made.append(tuple(own))
        return made

    def _bracket(self, call: Row, inner: Rows) -> Row:
        """The rows in a bracket that stands where the call does."""
        origin = call.origin or call.name
        inside = tuple(self._placed(row, row.frame, row.hand, origin) for row in inner)
        return self._row(
            call.frame, call.hand, call.pens, "", call.args, inside, call.other, call.origin,
            call.symbols,
        )  # fmt: skip


def _inside(rows: Rows, path: Path) -> Iterator[tuple[Path, Rows]]:
    yield path, rows
    for index, row in enumerate(rows):
        if row.inner:
            yield from _inside(row.inner, (*path, index))


def _rounded(places: Frames, given: Rounding) -> Frames:
    """Without what sums of decimals are off."""
    return Frames(
        np.round(places.x, given.places) + 0.0,
        np.round(places.y, given.places) + 0.0,
        wrap(np.round(places.angle, 9) + 0.0),
        np.round(places.scale, 9),
        places.handedness,
    )
