"""The rules that can be folded, as rows, and those that are taken as they are.

Reads printed rules; replaces stretches of rows, wherever they stand, by calls; writes rules into
those that name them. Nothing here decides what is shorter.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from operator import is_
from typing import TypeAlias

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.folding.rows import Row, element_tokens, frames_of, moved, rows_of
from ipmlang.inverse.folding.templates import HEAD, Rounding, Template
from ipmlang.inverse.lsystem.frames import Frames, compose, frames

Path: TypeAlias = "tuple[int, ...]"  # from a rule's rows down to those of an inner row


@dataclass(frozen=True, slots=True)
class Stretch:
    """Neighbouring rows: of a rule, at a path in it, from `begin` on, `count` of them."""

    rule: str
    path: Path
    begin: int
    count: int

    def meets(self, other: Stretch) -> bool:
        """Whether a row is in both, or in a row of the other."""
        if self.rule != other.rule:
            return False
        one, two = sorted((self, other), key=lambda each: len(each.path))
        depth = len(one.path)
        if one.path != two.path[:depth]:
            return False
        inner = two.path[depth:]
        begin, end = (inner[0], inner[0] + 1) if inner else (two.begin, two.begin + two.count)
        return begin < one.begin + one.count and one.begin < end


@dataclass(slots=True)
class Book:
    """plain: the rows of every rule that is rows and nothing else, the first one drawn first;
    fixed: rules that stay as they are, by name; templates: rules with parameters; wishes: what
    new rules would be called after; leaving: names of what moves the turtle.
    """

    axiom: str
    plain: dict[str, tuple[Row, ...]]
    fixed: dict[str, tuple[ast.Rule, ...]]
    templates: dict[str, Template] = field(default_factory=dict)
    wishes: dict[str, str] = field(default_factory=dict)
    leaving: frozenset[str] = frozenset()

    def copy(self) -> Book:
        """Another one with the same rules."""
        return replace(
            self,
            plain=dict(self.plain),
            fixed=dict(self.fixed),
            templates=dict(self.templates),
            wishes=dict(self.wishes),
        )

    def add(self, name: str, template: Template, wish: str) -> None:
        """A new rule; without parameters it is a plain one."""
        self.wishes[name] = wish
        if template.labels or template.given.count:
            self.templates[name] = template
        else:
            self.plain[name] = template.rows

    def renamed(self, names: Mapping[str, str]) -> Book:
        """The book with other names for some rules."""
        return replace(
            self,
            plain={names.get(k, k): _renamed(rows, names) for k, rows in self.plain.items()},
            templates={
                names.get(k, k): replace(each, rows=_renamed(each.rows, names))
                for k, each in self.templates.items()
            },
        )

    def uses(self) -> Counter[str]:
        """How often each name stands in a body."""
        found: Counter[str] = Counter()
        for rows in self.plain.values():
            _count(rows, found)
        for template in self.templates.values():
            _count(template.rows, found)
        for rules in self.fixed.values():
            for rule in rules:
                found.update(modules(rule.body))
        return found

    def length(self) -> int:
        """How many rows there are, those in brackets too."""
        return sum(len(rows) for _, _, rows in self.stretches())

    def loose(self) -> int:
        """How many terminals stand in the axiom itself."""
        rules = self.plain.keys() | self.fixed.keys() | self.templates.keys()
        return sum(
            bool(row.name) and row.name not in rules for row in _all(self.plain.get(self.axiom, ()))
        )

    def drop_unused(self) -> None:
        """Forget rules that nothing names any more."""
        while True:
            used = self.uses()
            for rules in (self.plain, self.templates, self.fixed):
                for name in [name for name in rules if name != self.axiom and not used[name]]:
                    del rules[name]
            if used.keys() == self.uses().keys():
                return

    def stretches(self) -> Iterator[tuple[str, Path, tuple[Row, ...]]]:
        """Every sequence of rows, those in brackets too."""
        for name, rows in self.plain.items():
            for path, inner in _inside(rows, ()):
                yield name, path, inner

    def rows_at(self, stretch: Stretch) -> tuple[Row, ...]:
        """The rows of a stretch."""
        rows = self.plain[stretch.rule]
        for index in stretch.path:
            rows = rows[index].inner
        return rows[stretch.begin : stretch.begin + stretch.count]

    def stays(self, name: str) -> bool:
        """Whether a plain rule is never written out: the axiom, and what gives a repeat a name."""
        repeats = (isinstance(row.other, ast.Repeat) for row in self.plain[name])
        return name == self.axiom or any(repeats)

    def calls(self, name: str) -> list[Row] | None:
        """The rows that name a rule; None where something else than plain rules does."""
        fixed = (rule.body for rules in self.fixed.values() for rule in rules)
        if any(name in modules(body) for body in fixed):
            return None
        if any(row.name == name for each in self.templates.values() for row in _all(each.rows)):
            return None
        rows = [row for own in self.plain.values() for row in _all(own)]
        named = (row for each in self.templates.values() for row in _all(each.rows))
        if any(name in row.symbols for row in (*rows, *named)):
            return None
        if any(row.other is not None and name in modules((row.other,)) for row in rows):
            return None
        return [row for row in rows if row.name == name]

    def put(self, found: Mapping[Stretch, Row]) -> None:
        """Write one row in place of each stretch."""
        for name in dict.fromkeys(stretch.rule for stretch in found):
            own = {
                (stretch.path, stretch.begin): (stretch.count, row)
                for stretch, row in found.items()
                if stretch.rule == name
            }
            self.plain[name] = _rewritten(self.plain[name], (), own)

    def write_out(self, names: Sequence[str], given: Rounding) -> None:
        """Write the rows of some rules in place of calls of them, inmost rules first."""
        order = [name for name in self.inmost_first() if name in names]
        for name in order:
            inner = self.plain[name]
            for rule, rows in self.plain.items():
                if rule != name:
                    self.plain[rule] = _spread(rows, name, inner, given)
        self.drop_unused()

    def named_in(self, name: str) -> Counter[str]:
        """How often each name stands in a plain rule."""
        found: Counter[str] = Counter()
        _count(self.plain[name], found)
        return found

    def inmost_first(self) -> list[str]:
        """Plain rules behind those that they name."""
        order: dict[str, None] = {}

        def visit(name: str) -> None:
            if name in order or name not in self.plain:
                return
            for part in self.named_in(name):
                visit(part)
            order[name] = None

        visit(self.axiom)
        return list(order)

    def tokens(self) -> int:
        """Of all rules, as they stand."""
        total = sum(template.tokens for template in self.templates.values())
        total += sum(HEAD + sum(row.tokens for row in rows) for rows in self.plain.values())
        fixed = (rule for rules in self.fixed.values() for rule in rules)
        return total + sum(HEAD + sum(map(element_tokens, rule.body)) for rule in fixed)


def read_book(rules: Sequence[ast.Rule]) -> Book:
    """The book of printed rules, the first one being the axiom."""
    by_name: dict[str, list[ast.Rule]] = {}
    for rule in rules:
        by_name.setdefault(rule.head.name, []).append(rule)
    plain: dict[str, tuple[Row, ...]] = {}
    fixed: dict[str, tuple[ast.Rule, ...]] = {}
    for name, own in by_name.items():
        if len(own) == 1 and not own[0].head.parameters and own[0].guard is None:
            plain[name] = rows_of(own[0].body)
        else:
            fixed[name] = tuple(own)
    leaving = {name for name, rows in plain.items() if not all(map(_stays, rows))} | fixed.keys()
    while True:
        more = {
            name
            for name, rows in plain.items()
            if any(row.name in leaving and _bare(row) for row in rows)
        }
        if more <= leaving:
            break
        leaving |= more
    for name in leaving & plain.keys() - {rules[0].head.name}:
        fixed[name] = tuple(by_name[name])
        del plain[name]
    return Book(rules[0].head.name, plain, fixed, leaving=frozenset(leaving))


def _bare(row: Row) -> bool:
    """Whether it is printed without a bracket, so that what it does to the turtle goes on."""
    return row.placed and row.frame == Row().frame and row.hand > 0 and not row.pens


def _stays(row: Row) -> bool:
    """Whether an element leaves the turtle where it was."""
    match row.other:
        case None | ast.Bracket() | ast.Module("nil"):
            return True
        case ast.Repeat(_, body):
            return not row.other.steps and all(isinstance(each, ast.Bracket) for each in body)
    return False


def modules(body: Sequence[ast.Element]) -> Iterator[str]:
    """The names that stand in a body."""
    for each in body:
        match each:
            case ast.Module(name, args):
                yield name
                yield from (arg.value.id for arg in args if isinstance(arg.value, ast.Name))
            case ast.Bracket(inner) | ast.Repeat(_, inner):
                yield from modules(inner)


def _count(rows: Sequence[Row], found: Counter[str]) -> None:
    for row in rows:
        if row.other is not None:
            found.update(modules((row.other,)))
        elif row.inner:
            _count(row.inner, found)
        else:
            found.update((row.name, *row.symbols))


def _all(rows: Sequence[Row]) -> Iterator[Row]:
    """The rows and those in them."""
    for row in rows:
        yield row
        yield from _all(row.inner)


def _renamed(rows: tuple[Row, ...], names: Mapping[str, str]) -> tuple[Row, ...]:
    return tuple(
        replace(
            row,
            name=names.get(row.name, row.name),
            inner=_renamed(row.inner, names),
            symbols=tuple(names.get(each, each) for each in row.symbols),
        )
        for row in rows
    )


def _inside(rows: tuple[Row, ...], path: Path) -> Iterator[tuple[Path, tuple[Row, ...]]]:
    yield path, rows
    for index, row in enumerate(rows):
        if row.inner:
            yield from _inside(row.inner, (*path, index))


def _rewritten(
    rows: tuple[Row, ...], path: Path, found: Mapping[tuple[Path, int], tuple[int, Row]]
) -> tuple[Row, ...]:
    made: list[Row] = []
    index = 0
    while index < len(rows):
        count, row = found.get((path, index), (1, rows[index]))
        if row is rows[index] and row.inner:
            row = replace(row, inner=_rewritten(row.inner, (*path, index), found))
        made.append(row)
        index += count
    return tuple(made)


def _spread(
    rows: tuple[Row, ...], name: str, inner: tuple[Row, ...], given: Rounding
) -> tuple[Row, ...]:
    """The rows with those of a rule in place of its calls."""
    made: list[Row] = []
    for row in rows:
        if row.inner:
            own = _spread(row.inner, name, inner, given)
            same = len(own) == len(row.inner) and all(map(is_, own, row.inner))
            made.append(row if same else replace(row, inner=own))
        elif row.name != name or row.other is not None:
            made.append(row)
        else:
            made += written_out(row, inner, given)
    return tuple(made)


def written_out(call: Row, inner: tuple[Row, ...], given: Rounding) -> tuple[Row, ...]:
    """The rows of a rule in place of a call of it."""
    origin = call.origin or call.name
    inner = tuple(each if each.origin else replace(each, origin=origin) for each in inner)
    if call.pens or not all(each.placed for each in inner):
        return (replace(call, name="", inner=inner),)
    return moved(inner, _rounded(compose(frames_of([call]), frames_of(inner)), given))


def _rounded(places: Frames, given: Rounding) -> Frames:
    """Without what sums of decimals are off."""
    x, y = (np.round(each, given.places) + 0.0 for each in (places.x, places.y))
    return frames(
        x + 1j * y, np.round(places.angle, 9) + 0.0, np.round(places.scale, 9),
        places.handedness,
    )  # fmt: skip
