"""The rules that can be folded, as rows, and those that are taken as they are.

Reads printed rules; replaces stretches of rows, wherever they stand, by calls; writes rules into
those that name them. Nothing here decides what is shorter.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from ipmlang.compiler import ast
from ipmlang.inverse.folding.fits import HEAD, Rounding
from ipmlang.inverse.folding.known_rows import KnownRows, Path, Rows
from ipmlang.inverse.folding.rows import Row, element_tokens, modules, rows_of
from ipmlang.inverse.folding.templates import Template

Place: TypeAlias = "tuple[str, Path, int]"  # of a row: its rule, the path there, its number


@dataclass(frozen=True, slots=True)
class Stretch:
    """Neighbouring rows: of a rule, at a path in it, from `begin` on, `count` of them."""

    rule: str
    path: Path
    begin: int
    count: int

    @property
    def rows(self) -> list[Place]:
        """Where its rows are."""
        return [(self.rule, self.path, self.begin + k) for k in range(self.count)]

    @property
    def brackets(self) -> list[Place]:
        """Where the brackets are that it stands in."""
        return [(self.rule, self.path[:k], inner) for k, inner in enumerate(self.path)]


@dataclass(slots=True, eq=False)
class Covered:
    """Rows that are in some stretches, and the brackets that these stand in."""

    rows: set[Place] = field(default_factory=set)
    brackets: set[Place] = field(default_factory=set)

    def add(self, stretches: Sequence[Stretch]) -> None:
        """Cover these, too."""
        for each in stretches:
            self.rows.update(each.rows)
            self.brackets.update(each.brackets)

    def meets(self, stretches: Sequence[Stretch]) -> bool:
        """Whether a row of some stretches is covered, or stands in or around one that is."""
        return any(
            not self.rows.isdisjoint(each.rows)
            or not self.rows.isdisjoint(each.brackets)
            or not self.brackets.isdisjoint(each.rows)
            for each in stretches
        )


@dataclass(frozen=True, slots=True)
class Calls:
    """found: the rows that name each rule; bound: rules that something else than plain rules names,
    too.
    """

    found: Mapping[str, Sequence[Row]]
    bound: Set[str]

    def of(self, name: str) -> Sequence[Row] | None:
        """The rows that name a rule; None where something else does."""
        return None if name in self.bound else self.found.get(name, ())


@dataclass(slots=True)
class Book:
    """known: the rows of all copies of the book; plain: the rows of every rule that is rows and
    nothing else, the first one drawn first; fixed: rules that stay as they are, by name; templates:
    rules with parameters; wishes: what new rules would be called after; leaving: names of what
    moves the turtle.
    """

    axiom: str
    known: KnownRows
    plain: dict[str, Rows]
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
        self.wishes.pop(name, None)  # it may have been written out before
        self.wishes[name] = wish
        if template.labels or template.given.count:
            self.templates[name] = template
        else:
            self.plain[name] = self.known.rule(tuple(map(self.known.same, template.rows)))

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
        for name in (*self.plain, *self.templates, *self.fixed):
            found.update(self.parts_of(name))
        return found

    def parts_of(self, name: str) -> Mapping[str, int]:
        """How often each name stands in a rule."""
        if name in self.plain:
            return self.known.named(self.plain[name])
        if name in self.templates:
            return self.known.named(self.templates[name].rows)
        return Counter(part for rule in self.fixed[name] for part in modules(rule.body))

    def length(self) -> int:
        """How many rows there are, those in brackets too."""
        return sum(len(rows) for _, _, rows in self.stretches())

    def loose(self) -> int:
        """How many terminals stand in the axiom itself."""
        rules = self.plain.keys() | self.fixed.keys() | self.templates.keys()
        return sum(
            bool(each.name) and each.name not in rules
            for row in self.plain.get(self.axiom, ())
            for each in row.every
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

    def stretches(self) -> Iterator[tuple[str, Path, Rows]]:
        """Every sequence of rows, those in brackets too."""
        for name, rows in self.plain.items():
            for path, inner in self.known.inside(rows):
                yield name, path, inner

    def rows_at(self, stretch: Stretch) -> Rows:
        """The rows of a stretch."""
        rows = self.plain[stretch.rule]
        for index in stretch.path:
            rows = rows[index].inner
        return rows[stretch.begin : stretch.begin + stretch.count]

    def stays(self, name: str) -> bool:
        """Whether a plain rule is never written out: the axiom, and what gives a repeat a name."""
        repeats = (isinstance(row.other, ast.Repeat) for row in self.plain[name])
        return name == self.axiom or any(repeats)

    def calls(self) -> Calls:
        """The rows that name each rule."""
        rows = [each for own in self.plain.values() for row in own for each in row.every]
        named = [each for own in self.templates.values() for row in own.rows for each in row.every]
        bound = {part for own in self.fixed.values() for rule in own for part in modules(rule.body)}
        bound |= {row.name for row in named}
        bound.update(*(row.symbols for row in (*rows, *named)))
        bound.update(*(row.named for row in rows if row.other is not None))
        found: dict[str, list[Row]] = {}
        for row in rows:
            found.setdefault(row.name, []).append(row)
        return Calls(found, bound)

    def put(self, found: Mapping[Stretch, Row]) -> None:
        """Write one row in place of each stretch."""
        found = {stretch: self.known.same(row) for stretch, row in found.items()}
        for name in dict.fromkeys(stretch.rule for stretch in found):
            own = {
                (stretch.path, stretch.begin): (stretch.count, row)
                for stretch, row in found.items()
                if stretch.rule == name
            }
            rows = _rewritten(self.plain[name], (), own, self.known)
            self.plain[name] = self.known.rule(rows)

    def write_out(self, names: Collection[str]) -> None:
        """Write the rows of some rules in place of calls of them, inmost rules first."""
        order = dict.fromkeys(self.inmost_first())
        inner: dict[str, Rows] = {}
        for name in [*order, *(name for name in self.plain if name not in order)]:
            if not inner.keys().isdisjoint(self.parts_of(name)):
                self.plain[name] = self.known.rule(_spread(self.plain[name], inner, self.known))
            if name in names and name in order:
                inner[name] = self.plain[name]
        self.drop_unused()

    def inmost_first(self) -> list[str]:
        """Plain rules behind those that they name."""
        order: dict[str, None] = {}

        def visit(name: str) -> None:
            if name in order or name not in self.plain:
                return
            for part in self.parts_of(name):
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


def read_book(rules: Sequence[ast.Rule], given: Rounding) -> Book:
    """The book of printed rules, the first one being the axiom."""
    by_name: dict[str, list[ast.Rule]] = {}
    for rule in rules:
        by_name.setdefault(rule.head.name, []).append(rule)
    plain: dict[str, Rows] = {}
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
    known = KnownRows(given)
    plain = {name: known.rule(known.read(rows)) for name, rows in plain.items()}
    return Book(rules[0].head.name, known, plain, fixed, leaving=frozenset(leaving))


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


def _renamed(rows: Rows, names: Mapping[str, str]) -> Rows:
    return tuple(
        replace(
            row,
            name=names.get(row.name, row.name),
            inner=_renamed(row.inner, names),
            symbols=tuple(names.get(each, each) for each in row.symbols),
        )
        for row in rows
    )


def _rewritten(
    rows: Rows, path: Path, found: Mapping[tuple[Path, int], tuple[int, Row]], known: KnownRows
) -> Rows:
    made: list[Row] = []
    index = 0
    while index < len(rows):
        count, row = found.get((path, index), (1, rows[index]))
        if row is rows[index] and row.inner:
            row = known.holding(row, _rewritten(row.inner, (*path, index), found, known))
        made.append(row)
        index += count
    return tuple(made)


def _spread(rows: Rows, inner: Mapping[str, Rows], known: KnownRows) -> Rows:
    """The rows with those of some rules in place of calls of these."""
    called: dict[str, list[Row]] = {}
    for row in rows:
        if not row.inner and row.name in inner and row.other is None:
            called.setdefault(row.name, []).append(row)
    written = {name: iter(known.written_out(own, inner[name])) for name, own in called.items()}
    made: list[Row] = []
    for row in rows:
        if row.inner:
            own = (
                row.inner
                if inner.keys().isdisjoint(row.named)
                else _spread(row.inner, inner, known)
            )
            made.append(row if own is row.inner else known.holding(row, own))
        elif row.name in written and row.other is None:
            made += next(written[row.name])
        else:
            made.append(row)
    return tuple(made)
