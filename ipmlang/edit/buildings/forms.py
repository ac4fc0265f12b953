"""Shapes and terminals as elements of a body: as they are, or in a scope of any size.

In goes a derivation tree, out come elements that draw a part of it again in a frame given by
whoever asks. Shapes that fill their scope are given another one; what has fixed places inside gets
a rule of its own whose places are shares of the scope, as nodes are in the paper. Nothing is
decided here about where anything goes.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from ipmlang.compiler import ast, ir
from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.compiler.nodes import nodes
from ipmlang.edit.arithmetic import literal
from ipmlang.edit.buildings.baking import Asset, Baking
from ipmlang.edit.buildings.measuring import BOX, Measured, Unit, measured
from ipmlang.edit.buildings.regularity import Part
from ipmlang.edit.buildings.rows import Room, laid_out
from ipmlang.edit.buildings.stretched_assets import NONE, Stretched
from ipmlang.edit.buildings.tree import BOUND, Tree
from ipmlang.edit.symbols import Asked, Elements
from ipmlang.inverse.frames import Floats, Frames
from ipmlang.inverse.numbers import shortest
from ipmlang.inverse.split.placing import Precision, spots, steps_to
from ipmlang.inverse.split.wording import all_nothing, bracket, call, times
from ipmlang.runtime.scene import SCOPE

Vector: TypeAlias = tuple[ast.Expr, ast.Expr, ast.Expr]
NOTHING = 0  # the geometry of what draws none
EXTENTS: Vector = (ast.Name("scope.sx"), ast.Name("scope.sy"), ast.Name("scope.sz"))
EXACT = Precision(0.0)
SHARE = 1e-9  # of an extent, that a share of it may be off
FEW = 1e-9  # of a size that is nothing


@dataclass(slots=True, eq=False)
class Forms:
    """The forms of one tree; rules, tables: those that were made for them, rules by name; variants:
    of these, those that draw what another rule draws, at another size; brief: those that may stand
    where they are used, if that is in one place.
    """

    tree: Tree
    rules: dict[str, tuple[str, Elements]] = field(default_factory=dict)
    tables: list[ast.Table] = field(default_factory=list)
    variants: set[str] = field(default_factory=set)
    brief: set[str] = field(default_factory=set)
    _taken: set[str] = field(default_factory=set)
    _fitted: dict[object, str] = field(default_factory=dict)
    _labels: dict[str, str] = field(default_factory=dict)
    baking: Baking | None = None
    asked: Asked = field(init=False)
    _modules: dict[int, dict[int, ast.Module]] = field(default_factory=dict)
    measured: Measured = field(init=False)
    stretched: Stretched = field(init=False)

    def __post_init__(self) -> None:
        self.measured, self.asked = measured(self.tree), Asked(self.tree.asked)
        self.stretched = Stretched.of(self.tree.draft.grammar, self.new_name)

    # --------------------------------------------------------------------------- as it is

    def plain(self, unit: Unit, around: int) -> Elements:
        """A unit as it is, where a body of the shape `around` draws it in the unit's frame."""
        size = (
            tuple(literal(float(each)) for each in self.measured.box(unit)[1])
            if self.measured.fills(unit)
            else ()
        )
        return self._said(unit, around, size)

    def fitted(self, unit: Unit, around: int, size: Vector, base: Frames | None = None) -> Elements:
        """A unit in a scope of a size, whose origin is the low corner of its box, in the axes of
        `base`, or in its own.
        """
        kind, row = unit
        turned = base is not None and not self.measured.is_square(unit, base)
        if self.measured.fills(unit) and not turned:
            return self._said(unit, around, size)
        pens = self.pens(unit, around)
        own = base if turned and base is not None else self.measured.frame(unit)
        if kind == "shape":
            return (*pens, call("size", *size), ast.Module(self._fit_rule(row, own)))
        name, scope = self.measured.name(unit), [call("size", *size)]
        if turned or self.measured.is_solid(row):
            asset = self.bake(row, own)
            name, scope = asset.name, self._scope_of(asset, unit, own, size)
        return (*pens, *scope, call("insert", ast.Name(name)), ast.Module(self._label(name)))

    def _scope_of(self, asset: Asset, unit: Unit, base: Frames, size: Vector) -> list[ast.Module]:
        """The scope of a baked terminal where its box in the axes of a frame gets a size: what is
        turned need not fill that.
        """
        around = self.measured.maps(base)
        at = around.into @ self.measured.frame(unit).position[0] + around.origin
        low, high = (each - at for each in self.measured.box_in(unit, base))
        first, extent = asset.low - low, asset.high - asset.low
        place = [_share(*each) for each in zip(first, high - low, size, strict=True)]
        scope = [_share(*each) for each in zip(extent, high - low, size, strict=True)]
        move = [] if all_nothing(place) else [call("translate", *place)]
        return [*move, call("size", *scope)]

    def _label(self, name: str) -> str:
        if name not in self._labels:
            self._labels[name] = self.new_name(f"{name}_fitted")
        return self._labels[name]

    def bake(self, row: int, base: Frames) -> Asset:
        """A terminal as an asset in the axes of a frame."""
        if self.baking is None:
            self.baking = Baking(self.tree, self.new_name)
        self.pens(("terminal", row), int(self.tree.owner[row]))
        asset = self.baking.bake(row, base)
        self.stretched.own[asset.name] = asset.name, NONE
        return asset

    def _said(self, unit: Unit, around: int, size: tuple[ast.Expr, ...]) -> Elements:
        kind, row = unit
        pens = self.pens(unit, around)
        scope: list[ast.Element] = [call("size", *size)] if size else []
        if kind == "shape":
            if size:
                scope += self._geometry(self.tree.lineage.state["geo"][row], row, around)
            return (*pens, *scope, self.call(row))
        table = self.tree.scene.instances
        number = int(table.asset[row])
        if number >= 0:
            if size:
                scope.append(call("insert", ast.Name(self.tree.scene.assets[number].name)))
            return (*pens, *scope, ast.Module(self.measured.name(unit)))
        if number != SCOPE:
            return (*pens, ast.Module(self.bake(row, self.measured.frame(unit)).name))
        geometry = self.tree.lineage.pens.get("geo")
        own = BOX if geometry is None else int(geometry[row])
        scope += self._geometry(own, row, around, self.tree.terminals.high[row])
        return (*pens, *scope, ast.Module(self.measured.name(unit)))

    def _geometry(
        self, own: float, row: int, around: int, size: Floats | None = None
    ) -> list[ast.Element]:
        """What makes the scope around a rectangle or a box, unless it is one."""
        outer = self.tree.lineage.state["geo"][around]
        high = self.tree.size[row] if size is None else size
        same = (high[2] > 0) == (self.tree.size[around][2] > 0)
        if own == NOTHING or (own == outer == BOX and same):
            return []
        return [ast.Module("cube" if high[2] > 0 else "quad")]

    def call(self, row: int) -> ast.Module:
        """The symbol of a shape with its arguments."""
        symbol = self.tree.program.symbols[int(self.tree.lineage.symbol[row])]
        values = self.tree.lineage.arguments[row][: symbol.arity - symbol.carried]
        written = self._written(row)
        if written is not None and all(_closed(each.value) for each in written.args):
            return ast.Module(self.tree.names[row], written.args)
        said = iter([literal(value) for value in values])
        given = symbol.given or (None,) * len(values)
        args = [next(said) if each is None else ast.Name(each) for each in given]
        return ast.Module(self.tree.names[row], tuple(map(ast.Argument, args)))

    def _written(self, row: int) -> ast.Module | None:
        """The module in the main file that made a shape."""
        lineage, program = self.tree.lineage, self.tree.program
        taken = int(lineage.production[lineage.parent[row]]) if lineage.parent[row] >= 0 else -2
        if taken == -2:
            return None
        production = program.axiom if taken < 0 else program.productions[taken]
        if production.path != program.path or production.item < 0:
            return None
        if taken not in self._modules:
            item = self.tree.draft.grammar.items[production.item]
            self._modules[taken] = _by_site(production, item)
        return self._modules[taken].get(int(lineage.site[row]))

    def pens(self, unit: Unit, around: int) -> Elements:
        """What the pen must be told, as the shape `around` has it, to draw a unit."""
        kind, row = unit
        lineage = self.tree.lineage
        own = lineage.state if kind == "shape" else lineage.pens
        said: list[ast.Element] = []
        for name in self.tree.told:
            here, there = float(own[name][row]), float(lineage.state[name][around])
            if here == there or (here != here and there != there):
                continue
            if name in BOUND:
                raise _unsaid(self, unit, "its texture, effect or boolean spans several parts")
            if name == "width":
                said.append(call("width", literal(here)))
            elif name == "layer":
                said.append(call("layer", literal(here - there)))
            elif here >= 0:
                text = ast.Text(self.tree.program.strings[int(here)])
                said.append(call(name, text))
        return tuple(said)

    # ---------------------------------------------------------------------- relative rules

    def _fit_rule(self, row: int, base: Frames) -> str:
        """The rule that draws a shape in shares of its scope, whose axes are those of a frame."""
        symbol = self.tree.names[row]
        body = self.shares(row, base)
        key = (symbol, body)
        if key not in self._fitted:
            name = self.new_name(f"{symbol.rpartition('.')[2]}_fitted")
            self._fitted[key] = name
            self.rules[name] = (symbol, body)
        return self._fitted[key]

    def shares(self, row: int, base: Frames) -> Elements:
        """A body that draws a shape in shares of a scope whose axes are those of a frame."""
        low, high = self.measured.box_in(("shape", row), base)
        extent = high - low
        body: list[ast.Element] = []
        for each in self.measured.inside(row, base):
            corner, size, axis = each.corner, each.size, each.turned.argmax(axis=0)
            x, y, z = (_share(corner[k] - low[k], extent[k], EXTENTS[k]) for k in range(3))
            place = (x, y, z)
            scope = [_share(size[k], extent[axis[k]], EXTENTS[axis[k]]) for k in range(3)]
            bare = Frames(np.zeros((1, 3)), each.frame.rotation, each.frame.hand, np.ones(1))
            turn = steps_to(spots(bare, EXACT, 1.0)[0])
            inner = self.fitted(each.unit, row, (scope[0], scope[1], scope[2]), base)
            move = [] if all_nothing(place) else [call("translate", *place)]
            body.append(bracket([*move, *turn, *inner]))
        return tuple(body)

    def row_rule(self, unit: Unit, size: Floats, axes: tuple[int, ...], base: Frames) -> str:
        """The rule for a unit that stands as often as it fits along some axes of its scope, about
        as large as `size` (3,).
        """
        owner = self.measured.owner(unit)
        body = self.fitted(unit, owner, EXTENTS, base)
        inner = body[len(self.pens(unit, owner)) + 1 :]  # the scope is that of a cell
        symbol = self.measured.name(unit)
        key = (symbol, axes, inner)
        if key not in self._fitted:
            for axis in reversed(axes):
                floating = ast.Size("floating", literal(float(size[axis])))
                part = ast.SplitPart(floating, tuple(inner))
                inner = (ast.Split("xyz"[axis], (ast.SplitGroup((part,), "*"),)),)
            bare = symbol.rpartition(".")[2]
            name = self.new_name(f"{bare[0].upper()}{bare[1:]}_row")
            self._fitted[key] = name
            self.rules[name] = (symbol, tuple(inner))
        return self._fitted[key]

    def laid(self, symbol: str, parts: Sequence[Part], near: float) -> Elements:
        """The body of a symbol that draws parts at their frames; near: what numbers may be off.
        Tables that it needs stand among the others.
        """
        body, tables = laid_out(parts, Room(near), self.new_name, symbol, self.tables)
        self.tables += tables
        return body

    @property
    def taken(self) -> Set[str]:
        """The names that were given."""
        return self._taken

    def new_name(self, wish: str) -> str:
        """A name that nothing bears yet, taken from here on."""
        number, name = 2, wish
        while name in self._taken or name in self.tree.taken or name in self.rules:
            name, number = f"{wish}_{number}", number + 1
        self._taken.add(name)
        return name


def _share(value: float, whole: float, extent: ast.Expr) -> ast.Expr:
    """A share of an extent of the scope."""
    if whole <= 0 or abs(value) <= FEW * whole:
        return ast.Number(0.0)
    return times(ast.Number(shortest(float(value / whole), SHARE)), extent)


def _closed(expr: ast.Expr) -> bool:
    return isinstance(expr, ast.Number | ast.Text | ast.Truth)


def _all(body: tuple[ir.Instruction, ...]) -> list[ir.Instruction]:
    found = []
    for each in body:
        found.append(each)
        found += _all(each.body)
    return found


def _by_site(production: ir.Production, item: ast.Item) -> dict[int, ast.Module]:
    """The modules of an item by the sites of what was lowered of them."""
    written: dict[tuple[int, int], ast.Module] = {}
    for node in nodes(item):
        if isinstance(node, ast.Module):
            written.setdefault((node.span.start, node.span.end), node)
    found: dict[int, ast.Module] = {}
    for each in _all(production.body):
        if each.site >= 0 and each.span in written:
            found.setdefault(each.site, written[each.span])
    return found


def _unsaid(forms: Forms, unit: Unit, why: str) -> IpmError:
    owner = forms.measured.owner(unit)
    rule = forms.tree.names[owner] if owner >= 0 else "start"
    return fail(
        "cannot-edit-there",
        f"`{forms.measured.name(unit)}` in `{rule}` cannot be written down by itself: {why}",
        hint=f"select `{rule}` or what is around it, or change its parameters: ipmlang edit set",
    )


__all__ = ["EXACT", "EXTENTS", "Forms", "Vector"]
