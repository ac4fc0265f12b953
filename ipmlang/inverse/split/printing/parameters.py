"""Rules that are equal but for symbols or numbers, as one rule that is told these.

Takes the printed rules and tables of a grammar; gives fewer: `House(roof) --> wall door roof` and
calls of it in place of a rule for each roof, wherever that is shorter. Rows of tables say what
theirs is told in their columns. What is drawn does not change.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from itertools import groupby, takewhile
from typing import TypeAlias

from ipmlang.compiler import ast
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.nodes import mapped, nodes
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.inverse.folding.printing import parameters
from ipmlang.inverse.folding.symbols import LABEL
from ipmlang.inverse.naming import Names
from ipmlang.inverse.split.printing.schedules import SHAPE

MOST = 3  # parameters that a person can tell apart in a call
LEAST = 3  # tokens that a rule has to save
PLACED = f"at.{SHAPE}"
LETTERS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
WORDS = {
    "translate": ("dx", "dy", "dz"),
    "size": ("width", "depth", "height"),
    "rotate": ("angle", "angle", "angle"),
    "*": ("factor",),
}  # what the arguments of operations are called
VALUE, COUNT, LENGTH = "value", "count", "length"  # and what other numbers are

Leaf: TypeAlias = ast.Name | ast.Number
Body: TypeAlias = tuple[ast.Element, ...]


@dataclass(frozen=True, slots=True)
class Told:
    """rules, tables: of a grammar; families: the names of the rules that became one, each."""

    rules: tuple[ast.Rule, ...]
    tables: tuple[ast.Table, ...]
    families: tuple[tuple[str, ...], ...] = ()


def told(
    rules: Sequence[ast.Rule], tables: Sequence[ast.Table], assets: Mapping[str, str], names: Names
) -> Told:
    """The rules, the axiom first, with parameters where that is shorter; assets: names of what is
    placed besides rules, with a word for what it is there.
    """
    made = Told(tuple(rules), tuple(tables))
    passed: set[tuple[str, ...]] = set()
    while True:
        family = next(
            (each for each in _families(made, assets) if each.members not in passed), None
        )
        if family is None:
            return made
        passed.add(family.members)
        other = _with_one(made, family, names)
        if other is not None and _tokens(made) - _tokens(other) >= LEAST:
            made = replace(other, families=(*made.families, family.members))


def _tokens(made: Told) -> int:
    return count_text_tokens(format_grammar(ast.Grammar((*made.tables, *made.rules))))


# ------------------------------------------------------------------------ families


@dataclass(frozen=True, slots=True)
class _Family:
    """Rules of one form. members: their names; words: of the parameters; args: for each member what
    it is told; body: with the parameters in the place of that.
    """

    members: tuple[str, ...]
    words: tuple[str, ...]
    args: tuple[tuple[Leaf, ...], ...]
    body: Body

    def said(self, name: str) -> tuple[Leaf, ...]:
        """What a member is told."""
        return self.args[self.members.index(name)]


def _families(made: Told, assets: Mapping[str, str]) -> Iterator[_Family]:
    """Rules that could be one, those that others place first."""
    symbols = {rule.head.name: "" for rule in made.rules} | dict(assets)
    taken = {*symbols, *(table.name for table in made.tables)}
    groups: dict[object, list[ast.Rule]] = {}
    for rule in reversed(made.rules[1:]):
        if not rule.head.parameters and rule.doc is None:
            groups.setdefault(_spelt(rule.body, symbols).form, []).append(rule)
    for group in groups.values():
        own = group[::-1]
        for some in _alike(own, symbols):
            family = _family(some, symbols, taken)
            if family is not None:
                yield family


def _alike(rules: list[ast.Rule], symbols: Mapping[str, str]) -> Iterator[list[ast.Rule]]:
    """All rules of a form, then those that differ in symbols alone, and in numbers alone."""
    if len(rules) < 2:
        return
    yield rules
    for kind in (ast.Number, ast.Name):

        def same(rule: ast.Rule, kind: type = kind) -> tuple[Leaf, ...]:
            leaves = _spelt(rule.body, symbols).leaves
            return tuple(each for each in leaves if isinstance(each, kind))

        keys = {rule.head.name: repr(same(rule)) for rule in rules}
        ordered = sorted(rules, key=lambda rule: keys[rule.head.name])
        for _, some in groupby(ordered, key=lambda rule: keys[rule.head.name]):
            own = list(some)
            if 1 < len(own) < len(rules):
                yield own


def _family(
    rules: Sequence[ast.Rule], symbols: Mapping[str, str], taken: Set[str]
) -> _Family | None:
    """The family of rules of one form, None where it would be told too much."""
    columns = list(zip(*(_spelt(rule.body, symbols).leaves for rule in rules), strict=True))
    words = _spelt(rules[0].body, symbols).words
    varied = {column: words[k] for k, column in reversed(list(enumerate(columns)))
              if len(set(column)) > 1}  # fmt: skip
    order = [column for column in dict.fromkeys(columns) if column in varied]
    named = [column for column in order if isinstance(column[0], ast.Name)]
    if len(order) > MOST or len(order) >= len(columns):
        return None
    order = [*named, *(column for column in order if column not in named)]
    wishes = [
        _shared_word(column, symbols) if column in named else varied[column] for column in order
    ]
    own = parameters(wishes, taken)
    marks = [ast.Name(own[order.index(column)]) if column in varied else None for column in columns]
    waiting = iter(marks)

    def marked(leaf: Leaf, word: str) -> ast.Expr:
        return next(waiting) or leaf

    body = _with_leaves(rules[0].body, symbols, marked)
    args = tuple(zip(*order, strict=True)) if order else ((),) * len(rules)
    return _Family(tuple(rule.head.name for rule in rules), tuple(own), args, body)


def _shared_word(column: Sequence[Leaf], words: Mapping[str, str]) -> str:
    """What symbols are called that a parameter stands for: what all of them are there."""
    found = {words[each.id] for each in column if isinstance(each, ast.Name)}
    return (found.pop() or LABEL) if len(found) == 1 else LABEL


# --------------------------------------------------------------------------- bodies


@dataclass(frozen=True, slots=True)
class _Spelt:
    """A body without its symbols and numbers, these in order, and a word for each."""

    form: object
    leaves: tuple[Leaf, ...]
    words: tuple[str, ...]


def _spelt(body: Body, symbols: Mapping[str, str]) -> _Spelt:
    leaves: list[Leaf] = []
    words: list[str] = []

    def noted(leaf: Leaf, word: str) -> ast.Expr:
        leaves.append(leaf)
        words.append(word)
        return ast.Name("@" if isinstance(leaf, ast.Name) else "#")

    form = _with_leaves(body, symbols, noted)
    return _Spelt(form, tuple(leaves), tuple(words))


def _with_leaves(
    body: Body, symbols: Mapping[str, str], made: Callable[[Leaf, str], ast.Expr]
) -> Body:
    """A body with something else in the place of each symbol and number that a rule may be told."""
    words = _argument_words(body)

    def changed(node: object) -> object:
        match node:
            case ast.Number() if id(node) in words:
                return made(node, words[id(node)])
            case ast.Module(name, ()) if name in symbols:
                return replace(node, name=_id(made(ast.Name(name), "")))
            case ast.Module(name, args) if name in symbols:
                return replace(node, args=tuple(
                    ast.Argument(made(each.value, ""))
                    if isinstance(each.value, ast.Name) and each.value.id in symbols
                    else each
                    for each in args
                ))  # fmt: skip
        return node

    return mapped(body, changed)


def _id(name: ast.Expr) -> str:
    assert isinstance(name, ast.Name)
    return name.id


def _argument_words(body: Body) -> dict[int, str]:
    """A word for each number of a body, by its identity, but for those that lists are made of."""
    words: dict[int, str] = {}
    for node in nodes(body):
        match node:
            case ast.Module(name, args):
                known = WORDS.get(name, ())
                for k, each in enumerate(args):
                    own = known[k] if k < len(known) else VALUE
                    words |= {id(x): own for x in nodes(each) if isinstance(x, ast.Number)}
            case ast.Count(_, limit):
                words |= {id(x): COUNT for x in nodes(limit) if isinstance(x, ast.Number)}
            case ast.Size(_, value):
                words |= {id(x): LENGTH for x in nodes(value) if isinstance(x, ast.Number)}
    return words


# ----------------------------------------------------------------------------- calls


def _with_one(made: Told, family: _Family, names: Names) -> Told | None:
    """The grammar with one rule for a family; None where a member stands where no call can."""
    rules = list(made.rules)
    first = next(k for k, rule in enumerate(rules) if rule.head.name in family.members)
    kept = [rule for rule in rules if rule.head.name not in family.members]
    if any(name in _given(rule.body) for rule in kept for name in family.members):
        return None
    title = _title(family, {rule.head.name for rule in kept})
    calls = _Calls(family, title, names, {table.name: table for table in made.tables})
    head = ast.Head(title, tuple(map(ast.Parameter, family.words)))
    kept.insert(first, ast.Rule(head, family.body))
    own = [mapped(rule, calls.changed) for rule in kept]
    return Told(tuple(own), tuple(calls.tables.values()), made.families)


def _given(body: Body) -> set[str]:
    """The names that stand as arguments somewhere in a body."""
    return {node.value.id for node in nodes(body)
            if isinstance(node, ast.Argument) and isinstance(node.value, ast.Name)}  # fmt: skip


def _title(family: _Family, taken: Set[str]) -> str:
    """What the rule of a family is called: as the first, without what tells it from the others."""
    first = family.members[0]
    words = [LETTERS.findall(name) for name in family.members]
    ahead = _shared(words)
    behind = _shared([own[len(ahead) :][::-1] for own in words])[::-1]
    title = "".join([*ahead, *behind])
    return title if len(ahead) + len(behind) > 1 and title not in taken else first


def _shared(words: Sequence[Sequence[str]]) -> list[str]:
    """The words that all of some names begin with."""
    alike = takewhile(lambda column: len(set(column)) == 1, zip(*words, strict=False))
    return [column[0] for column in alike]


@dataclass(slots=True, eq=False)
class _Calls:
    """What writes calls of one rule in place of the members of a family."""

    family: _Family
    title: str
    names: Names
    tables: dict[str, ast.Table]

    def changed(self, node: object) -> object:
        """A node with calls in it, those inside it being there already."""
        match node:
            case ast.Module(name, ()) if name in self.family.members:
                return self._told(self.family.said(name))
            case ast.Rule() | ast.Bracket() | ast.Repeat() | ast.SplitPart() | ast.Part():
                every = [self._repeats(each) for each in node.body]
                return replace(node, body=tuple(one for each in every for one in each))
        return node

    def _told(self, args: Sequence[ast.Expr]) -> ast.Module:
        return ast.Module(self.title, tuple(map(ast.Argument, args)))

    def _repeats(self, given: ast.Element) -> list[ast.Element]:
        """A repeat over a table that has members in a column, as repeats that hand on what each
        row tells; what is something else, as it is.
        """
        if not isinstance(given, ast.Repeat) or not isinstance(given.head, ast.Rows):
            return [given]
        table = self.tables.get(given.head.table)
        if table is None or SHAPE not in table.columns:
            return [given]
        column = table.columns.index(SHAPE)
        kinds = [cell.id if isinstance(cell := row[column], ast.Name) else "" for row in table.rows]
        own = [k for k, kind in enumerate(kinds) if kind in self.family.members]
        if not own:
            return [given]
        made: list[ast.Element] = []
        rest = tuple(row for k, row in enumerate(table.rows) if k not in own)
        del self.tables[table.name]
        if rest:
            self.tables[table.name] = replace(table, rows=rest)
            made.append(given)
        listed = self._varying([kinds[k] for k in own])
        groups: dict[tuple[Leaf, ...], list[int]] = {}
        for k in own:
            args = self.family.said(kinds[k])
            key = tuple(
                arg for place, arg in enumerate(args)
                if isinstance(arg, ast.Name) and place != listed
            )  # fmt: skip
            groups.setdefault(key, []).append(k)
        every = ([(k, kinds[k]) for k in rows] for rows in groups.values())
        return [*made, *(self._repeat(given, table, rows, listed) for rows in every)]

    def _varying(self, kinds: Sequence[str]) -> int:
        """Which parameter the column of symbols tells: the one that differs most."""
        columns = list(zip(*(self.family.said(kind) for kind in kinds), strict=True))
        named = [k for k, each in enumerate(columns) if isinstance(each[0], ast.Name)]
        return max(named, key=lambda k: len(set(columns[k])), default=-1)

    def _repeat(
        self, given: ast.Repeat, table: ast.Table, rows: Sequence[tuple[int, str]], listed: int
    ) -> ast.Repeat:
        """A repeat over rows (their places in the table, and the members they name) alone."""
        column = table.columns.index(SHAPE)
        args = [self.family.said(kind) for _, kind in rows]
        varied = [len({each[k] for each in args}) > 1 for k in range(len(self.family.words))]
        cells = [[*table.rows[k]] for k, _ in rows]
        columns = [*table.columns]
        said: list[ast.Expr] = list(args[0])
        for k in [k for k, differs in enumerate(varied) if differs and k != listed]:
            columns.append(self.family.words[k])
            said[k] = ast.Name(f"at.{columns[-1]}")
            cells = [[*row, own[k]] for row, own in zip(cells, args, strict=True)]
        if listed >= 0 and varied[listed]:
            said[listed] = ast.Name(PLACED)
            cells = [[*row[:column], own[listed], *row[column + 1 :]]
                     for row, own in zip(cells, args, strict=True)]  # fmt: skip
        else:
            del columns[column]
            cells = [row[:column] + row[column + 1 :] for row in cells]
        name = self.names.give(table.name) if table.name in self.tables else table.name
        lines = tuple(map(tuple, cells))
        self.tables[name] = replace(table, name=name, columns=tuple(columns), rows=lines)
        call = self._told(said)

        def placed(each: object) -> object:
            return call if isinstance(each, ast.Module) and each.name == PLACED else each

        body = mapped(given.body, placed)
        assert isinstance(given.head, ast.Rows)
        return replace(given, head=replace(given.head, table=name), body=body)
