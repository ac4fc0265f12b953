"""Shapes put elsewhere, written back into the grammar with the least change.

In go a tree and what stands in place of some of its parts, out comes a draft. Only rules on the way
to something that changed get new bodies: where all applications of a rule changed in the same way
the rule itself, else a variant beside it (`Facade_2`); all other text stays. Whether the result is
sound is judged elsewhere.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import fail
from ipmlang.compiler.nodes import mapped
from ipmlang.edit.buildings.forms import Forms
from ipmlang.edit.buildings.kept_tables import with_kept_tables
from ipmlang.edit.buildings.measuring import Unit
from ipmlang.edit.buildings.sizing import inlined
from ipmlang.edit.buildings.units import tolerance
from ipmlang.edit.draft import Change, Draft
from ipmlang.edit.symbols import Asked, Elements, needed_names, without_names
from ipmlang.inverse.frames import Floats, Frames, compose, inverse, join, moved_to

Drawn: TypeAlias = list[tuple[Elements, Elements]]
SAME = 0.1  # of how near touches, that places may be off and are the same


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """Elements that draw something in a frame (one row, in the world); shift (3,): how far the low
    corner of what stood there went.
    """

    frame: Frames
    elements: Elements
    shift: Floats | None = None


@dataclass(slots=True, eq=False)
class Rewriting:
    """What is written while a tree is gone through; `at`: what stands in place of units, nothing
    for those that go; `more`: what a shape draws besides.
    """

    forms: Forms
    at: Mapping[Unit, Sequence[Placed]]
    more: Mapping[int, Sequence[Placed]]
    opened: set[int]
    near: float
    variants: dict[object, str] = field(default_factory=dict)
    made: dict[str, tuple[str, Elements]] = field(default_factory=dict)
    _shapes: dict[int, Placed] = field(default_factory=dict)
    _still: dict[int, Drawn | None] = field(default_factory=dict)
    _rows: dict[str, list[int]] = field(default_factory=dict)

    def shape(self, row: int) -> Placed:
        """A shape whose parts may have changed: its frame and what calls it."""
        own = self.forms.measured.frame(("shape", row))
        units = self.forms.measured.parts(row)
        stays = [self._stands(unit) for unit in units]
        shift = _shared(stays, self.near)
        shift = self._followed(units) if shift is None else shift
        frame = own if shift is None else _moved(own, shift)
        if row not in self.more and all(
            each is not None and shift is not None and _same(each, shift, self.near)
            for each in stays
        ):
            return Placed(frame, self.forms.plain(("shape", row), self._around(row)))
        body = self._body(row, frame)
        return Placed(frame, (*self._begin(row), ast.Module(self._variant(row, body))))

    def _followed(self, units: Sequence[Unit]) -> Floats | None:
        """How far most of the parts went; where no two went alike, the least way along each axis.
        None where none says.
        """
        found: list[Floats] = []
        for unit in units:
            if unit in self.at:
                found += [each.shift for each in self.at[unit] if each.shift is not None]
            elif unit[0] == "shape" and unit[1] in self.opened:
                before, after = self.forms.measured.frame(unit), self._once(unit[1]).frame
                found.append(after.position[0] - before.position[0])
            else:
                found.append(np.zeros(3))
        if not found:
            return None
        shifts = np.array(found)
        alike = np.abs(shifts[:, None] - shifts).max(axis=2) <= SAME * self.near
        often = alike.sum(axis=1)
        if often.max() > 1:
            most = np.flatnonzero(often == often.max())
            return np.asarray(shifts[most[np.linalg.norm(shifts[most], axis=1).argmin()]])
        return np.asarray(shifts[np.abs(shifts).argmin(axis=0), np.arange(3)])

    def _around(self, row: int) -> int:
        return max(int(self.forms.tree.parent[row]), 0)

    def _begin(self, row: int) -> Elements:
        """What a variant is told before it is called: the pen, and the scope where it has one."""
        unit: Unit = ("shape", row)
        around = self._around(row)
        if self.forms.measured.fills(unit):
            return self.forms.plain(unit, around)[:-1]
        return self.forms.pens(unit, around)

    def _stands(self, unit: Unit) -> Floats | None:
        """How far a unit moved that else stayed as it was, None for any other."""
        kind, row = unit
        if unit in self.at:
            placed = self.at[unit]
            if len(placed) != 1:
                return None
            own = self.forms.plain(unit, self.forms.measured.owner(unit))
        elif kind == "shape" and row in self.opened:
            placed = [self._once(row)]
            own = self.forms.plain(unit, self.forms.measured.owner(unit))
        else:
            return np.zeros(3)
        if placed[0].elements != own:
            return None
        return _shift(self.forms.measured.frame(unit), placed[0].frame)

    def _once(self, row: int) -> Placed:
        if row not in self._shapes:
            self._shapes[row] = self.shape(row)
        return self._shapes[row]

    def _body(self, row: int, frame: Frames) -> Elements:
        """The parts of a shape, in its new frame."""
        placed: list[Placed] = []
        for unit in self.forms.measured.parts(row):
            if unit in self.at:
                placed += self.at[unit]
            elif unit[0] == "shape" and unit[1] in self.opened:
                placed.append(self._once(unit[1]))
            else:
                placed.append(Placed(self.forms.measured.frame(unit), self.forms.plain(unit, row)))
        self._still[row] = None if row in self.more else self._unmoved(row, frame, placed)
        placed += self.more.get(row, ())
        inside = compose(inverse(frame), join([each.frame for each in placed]))
        parts = [(inside[k : k + 1], each.elements) for k, each in enumerate(placed)]
        return self.forms.laid(self.forms.tree.names[row], parts, self.near)

    def _unmoved(self, row: int, frame: Frames, placed: Sequence[Placed]) -> Drawn | None:
        """What the parts of a shape are drawn by and were, where all stand in it as they did."""
        measured = self.forms.measured
        units = measured.parts(row)
        if len(units) != len(placed):
            return None
        moved = frame.position[0] - measured.frame(("shape", row)).position[0]
        for unit, each in zip(units, placed, strict=True):
            shift = _shift(measured.frame(unit), each.frame)
            if shift is None or not _same(shift, moved, self.near):
                return None
        before = [self.forms.plain(unit, row) for unit in units]
        return list(zip((each.elements for each in placed), before, strict=True))

    def stays(self, name: str, renamed: Mapping[str, str]) -> bool:
        """Whether the rule of a variant, or the axiom, says what it is to say as it stands, when
        variants bear other names.
        """
        asked = self.forms.asked
        rows = [0] if name == "start" else self._rows[name]
        every = [self._still[row] for row in rows]
        return all(
            own is not None and all(_renamed(new, renamed, asked) == old for new, old in own)
            for own in every
        )

    def _variant(self, row: int, body: Elements) -> str:
        name = self._named(row, body)
        self._rows.setdefault(name, []).append(row)
        return name

    def _named(self, row: int, body: Elements) -> str:
        symbol = self.forms.tree.names[row]
        key = (symbol, body)
        if key not in self.variants:
            name = self.forms.new_name(symbol.rpartition(".")[2])
            self.variants[key] = name
            self.made[name] = (symbol, body)
        return self.variants[key]


def _shift(before: Frames, after: Frames) -> Floats | None:
    """How far a frame moved, None if it also turned."""
    same = before.rotation is after.rotation
    same = same or np.allclose(before.rotation, after.rotation, atol=1e-9)
    if not same or before.hand[0] != after.hand[0] or abs(before.scale - after.scale)[0] > 1e-9:
        return None
    return np.asarray(after.position[0] - before.position[0])


def _moved(frame: Frames, shift: Floats) -> Frames:
    return Frames(frame.position + shift, frame.rotation, frame.hand, frame.scale)


def _shared(shifts: Sequence[Floats | None], near: float) -> Floats | None:
    """The way that all parts went, or nowhere if some stayed; None where neither is so."""
    known = [each for each in shifts if each is not None]
    if any(_same(each, np.zeros(3), near) for each in known):
        return np.zeros(3)
    if not known or len(known) < len(shifts):
        return None
    return known[0] if all(_same(each, known[0], near) for each in known) else None


def _same(one: Floats, other: Floats, near: float) -> bool:
    """Whether two ways are one, to what touches."""
    return bool(np.abs(one - other).max() <= SAME * near)


def rewritten(
    forms: Forms,
    at: Mapping[Unit, Sequence[Placed]],
    more: Mapping[int, Sequence[Placed]] | None = None,
    *,
    what: str = "",
) -> Draft:
    """The draft with units replaced and shapes added. Raises IpmError for parts on the way that
    cannot be written down by themselves.
    """
    tree = forms.tree
    more = more or {}
    if len(tree.levels[0]) > 1:
        hint = "edit the grammar of one lot: start … on polygon […]"
        raise fail("cannot-edit-there", "this grammar starts on several shapes at once", hint=hint)
    changed = {forms.measured.owner(unit) for unit in at} | set(more)
    opened = {row for each in changed for row in tree.above(each)}
    writing = Rewriting(forms, at, more, opened, tolerance(tree))
    axiom = writing._body(0, tree.frames[:1])
    return _with_rules(writing, axiom, what)


def _with_rules(writing: Rewriting, axiom: Elements, what: str) -> Draft:
    """The draft with the new axiom and the new rules, each behind the rule that it comes of."""
    forms = writing.forms
    draft = forms.tree.draft
    every = {**forms.rules, **writing.made}
    said = {name: body for name, (_, body) in every.items()}
    said = inlined({"start": axiom, **said}, forms.brief, forms.tables, forms.asked)
    axiom = said.pop("start")
    every = {name: (every[name][0], body) for name, body in said.items()}
    renamed = _kept_names(writing, every, axiom)
    new: dict[str, list[ast.Rule]] = {}
    bodies: dict[str, Elements] = {}
    for name, (symbol, body) in every.items():
        body = _renamed(body, renamed, forms.asked)
        if renamed.get(name) == symbol:
            if name not in writing.made or not writing.stays(name, renamed):
                bodies[symbol] = body
        else:
            new.setdefault(symbol, []).append(ast.Rule(ast.Head(name), body))
    start = None if writing.stays("start", renamed) else _renamed(axiom, renamed, forms.asked)
    grammar = _placed_rules(draft.grammar, new, bodies, start)
    tables = [_renamed_rows(each, renamed) for each in forms.tables]
    grammar = _with_tables(grammar, tables, forms.asked)
    if forms.baking is not None:
        draft = forms.baking.with_assets(replace(draft, grammar=grammar))
        grammar = draft.grammar
    grammar = forms.stretched.with_items(grammar, renamed)
    before = needed_names(forms.tree.draft.grammar, forms.asked) | set(every) | forms.taken
    grammar = without_names(grammar, before - needed_names(grammar, forms.asked))
    grammar = with_kept_tables(forms.tree.draft.grammar, grammar, forms.asked)
    changes = [
        Change(symbol, "its parts", symbol if name in renamed else name)
        for name, (symbol, _) in writing.made.items()
    ]
    changes = changes or [Change("start", "its parts", what or "others")]
    return replace(draft, grammar=grammar, changes=(*draft.changes, *changes))


def _with_tables(grammar: ast.Grammar, tables: Sequence[ast.Table], asked: Asked) -> ast.Grammar:
    """The grammar with the tables that it reads before its rules."""
    used: set[str] = set().union(*map(asked.names, grammar.items))
    read = [each for each in tables if each.name in used]
    heads = (k for k, item in enumerate(grammar.items) if isinstance(item, ast.Rule | ast.Start))
    place = next(heads, len(grammar.items))
    return replace(grammar, items=(*grammar.items[:place], *read, *grammar.items[place:]))


def _renamed_rows(table: ast.Table, names: Mapping[str, str]) -> ast.Table:
    rows = tuple(
        tuple(
            ast.Name(names[cell.id]) if isinstance(cell, ast.Name) and cell.id in names else cell
            for cell in row
        )
        for row in table.rows
    )
    return replace(table, rows=rows)


def _kept_names(
    writing: Rewriting, every: Mapping[str, tuple[str, Elements]], axiom: Elements
) -> dict[str, str]:
    """The variants that take the place and the name of their rule or asset: nothing else of it is
    drawn any more.
    """
    forms, grammar = writing.forms, writing.forms.tree.draft.grammar
    heads = Counter(item.head.name for item in grammar.items if isinstance(item, ast.Rule))
    plain = {
        item.head.name
        for item in grammar.items
        if isinstance(item, ast.Rule) and not item.head.parameters and item.guard is None
    }
    drawn = (axiom, *(body for _, body in every.values()), *forms.tables)
    called: set[str] = set().union(*map(forms.asked.names, drawn))
    by_symbol: dict[str, list[str]] = {}
    for name, (symbol, _) in every.items():
        if name in writing.made or name in forms.variants:
            by_symbol.setdefault(symbol, []).append(name)
    rules: dict[str, set[str]] = {}
    for item in grammar.items:
        if isinstance(item, ast.Rule):
            rules[item.head.name] = rules.get(item.head.name, set()) | forms.asked.names(item)
    waiting = list(called)
    while waiting:  # what rules that stay still ask for
        more = rules.get(waiting.pop(), set()) - called
        called |= more
        waiting += more
    kept = {
        names[0]: symbol
        for symbol, names in by_symbol.items()
        if len(names) == 1 and heads[symbol] == 1 and symbol in plain and symbol not in called
    }
    return kept | forms.stretched.taking_over(called, drawn, forms.asked)


def _renamed(body: Elements, names: Mapping[str, str], asked: Asked) -> Elements:
    """A body with other names for symbols."""

    def change(node: object) -> object:
        if isinstance(node, ast.Module) and node.name in names:
            return replace(node, name=names[node.name])
        return node

    return body if names.keys().isdisjoint(asked.every(body)) else mapped(body, change)


def _placed_rules(
    grammar: ast.Grammar,
    new: Mapping[str, Sequence[ast.Rule]],
    bodies: Mapping[str, Elements],
    axiom: Elements | None,
) -> ast.Grammar:
    """The grammar with new rules behind those that they come of, other bodies, and another axiom if
    there is one.
    """
    items: list[ast.Item] = []
    heads = [item.head.name if isinstance(item, ast.Rule) else "" for item in grammar.items]
    waiting = dict(new)
    for number, item in enumerate(grammar.items):
        if isinstance(item, ast.Start) and axiom is not None:
            item = replace(item, axiom=axiom or (ast.Module("nil"),), choices=None)
        elif isinstance(item, ast.Rule) and item.head.name in bodies:
            item = replace(item, body=bodies[item.head.name] or (ast.Module("nil"),))
        items.append(item)
        if heads[number] and heads[number] not in heads[number + 1 :]:
            items += waiting.pop(heads[number], ())
    rest = [rule for rules in waiting.values() for rule in rules]
    place = max((k for k, item in enumerate(items) if isinstance(item, ast.Rule)), default=-1)
    place = len(items) if place < 0 else place + 1
    return replace(grammar, items=(*items[:place], *rest, *items[place:]))


__all__ = ["Placed", "Rewriting", "moved_to", "rewritten"]
