"""Every parameter of every rule: where it stands, what it means, and how to change some of them.

In goes a syntax tree; `places` lists its parameters in the order of the text, `with_changes` gives
the tree with some of them replaced. Comments and everything else stay as they were. What to change
is decided elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, TypeVar, assert_never

from ipmlang.compiler import ast
from ipmlang.compiler.ops import OPERATIONS
from ipmlang.compiler.ops.record import Operation, Param

Kind: TypeAlias = Literal["length", "angle", "scale", "count", "number", "text"]

_KINDS: dict[str, Kind] = {
    "distance": "length", "x": "length", "y": "length", "z": "length", "width": "length",
    "angle": "angle", "scale": "scale", "factor": "scale",
}  # fmt: skip
_WORDS: dict[str, Kind] = {"string": "text", "color": "text", "int": "count"}


@dataclass(frozen=True, slots=True)
class Place:
    """One parameter. rule: the rule it stands in, `start` for the axiom, else a table's name;
    operation: the operation, symbol or word whose parameter it is; loops: the counters of the
    repeats around it, innermost last; above: what it must be greater than; motion: it moves or
    turns the turtle.
    """

    rule: str
    operation: str
    parameter: str
    kind: Kind
    loops: tuple[str, ...] = ()
    above: float | None = None
    motion: bool = False


Found: TypeAlias = tuple[Place, ast.Expr]
Visit: TypeAlias = Callable[[Place, ast.Expr], ast.Expr]
_Item = TypeVar("_Item", bound=ast.Item)


def places(grammar: ast.Grammar) -> list[Found]:
    """All parameters in the order of the text.

    >>> from ipmlang.compiler.diagnostics import Source
    >>> from ipmlang.compiler.parse import parse
    >>> row = parse(Source("row.ipm", "Row --> repeat(i < 6) { [A] f(13) }"))[0]
    >>> [(each.operation, each.parameter) for each, _ in places(row)]
    [('repeat', 'count'), ('f', 'distance')]
    """
    found: list[Found] = []

    def note(place: Place, expr: ast.Expr) -> ast.Expr:
        found.append((place, expr))
        return expr

    _rewritten(grammar, note)
    return found


def places_in(grammar: ast.Grammar, rule: str) -> list[Found]:
    """Those of the productions of one rule, or of the start."""
    found: list[Found] = []

    def note(place: Place, expr: ast.Expr) -> ast.Expr:
        found.append((place, expr))
        return expr

    heads = _heads(grammar)
    own = {name for name, _ in heads}
    for item in grammar.items:
        name = item.head.name if isinstance(item, ast.Rule) else "start"
        if isinstance(item, ast.Rule | ast.Start) and name == rule:
            _item(item, heads, own, note)
    return found


def with_changes(grammar: ast.Grammar, changes: Mapping[int, ast.Expr]) -> ast.Grammar:
    """The tree with the parameters of these numbers, counted as in `places`, replaced."""
    counter = iter(range(1 << 62))
    return _rewritten(grammar, lambda place, expr: changes.get(next(counter), expr))


def _rewritten(grammar: ast.Grammar, visit: Visit) -> ast.Grammar:
    heads = _heads(grammar)
    own = {name for name, _ in heads}
    items = tuple(_item(item, heads, own, visit) for item in grammar.items)
    return replace(grammar, items=items)


def _heads(grammar: ast.Grammar) -> dict[tuple[str, int], tuple[str, ...]]:
    """The parameters of rules by their names and how many they are."""
    return {
        (item.head.name, len(item.head.parameters)): tuple(p.name for p in item.head.parameters)
        for item in reversed(grammar.items)
        if isinstance(item, ast.Rule)
    }


def _item(
    item: ast.Item,
    heads: Mapping[tuple[str, int], tuple[str, ...]],
    own: set[str],
    visit: Visit,
) -> ast.Item:
    match item:
        case ast.Rule():
            walk = _Walk(item.head.name, heads, own, visit)
            chance = item.chance
            if chance is not None:
                value = walk.visit(chance.kind, chance.kind, "number", chance.value)
                chance = replace(chance, value=value)
            return replace(item, chance=chance, body=walk.body(item.body, ()))
        case ast.Start():
            walk = _Walk("start", heads, own, visit)
            axiom = walk.body(item.axiom, ())
            steps = item.steps
            if steps is not None:
                steps = walk.visit("steps", "steps", "count", steps)
            return replace(item, axiom=axiom, steps=steps)
        case ast.Table():
            walk = _Walk(item.name, heads, own, visit)
            rows = tuple(_row(walk, item.columns, row) for row in item.rows)
            return replace(item, rows=rows)
        case _:
            return item


def _row(walk: _Walk, columns: tuple[str, ...], row: tuple[ast.Expr, ...]) -> tuple[ast.Expr, ...]:
    return tuple(
        walk.visit("row", column, "text" if isinstance(cell, ast.Text) else "number", cell)
        for column, cell in zip(columns, row, strict=False)
    )


@dataclass(frozen=True, slots=True)
class _Walk:
    """One walk over the body of a rule."""

    rule: str
    heads: Mapping[tuple[str, int], tuple[str, ...]]
    own: set[str]
    visitor: Visit

    def visit(
        self,
        operation: str,
        parameter: str,
        kind: Kind,
        expr: ast.Expr,
        loops: tuple[str, ...] = (),
        above: float | None = None,
        motion: bool = False,
    ) -> ast.Expr:
        """One parameter; a vector's numbers are parameters each."""
        if isinstance(expr, ast.Tuple):
            items = tuple(
                self.visit(operation, parameter, kind, each, loops, above, motion)
                for each in expr.items
            )
            return replace(expr, items=items)
        if isinstance(expr, ast.Text):
            kind = "text"
        return self.visitor(
            Place(self.rule, operation, parameter, kind, loops, above, motion), expr
        )

    def body(
        self, elements: tuple[ast.Element, ...], loops: tuple[str, ...]
    ) -> tuple[ast.Element, ...]:
        """The elements of a successor or of braces."""
        return tuple(self.element(each, loops) for each in elements)

    def element(self, element: ast.Element, loops: tuple[str, ...]) -> ast.Element:
        match element:
            case ast.Module():
                return self.module(element, loops)
            case ast.Bracket():
                return replace(element, body=self.body(element.body, loops))
            case ast.Repeat():
                return self.repeat(element, loops)
            case ast.Split():
                args = self.arguments("split", element.args, loops)
                parts = tuple(self.split_part(each, loops) for each in element.parts)
                return replace(element, args=args, parts=parts)
            case ast.Block():
                args = self.arguments(element.name, element.args, loops)
                return replace(element, args=args, parts=self.parts(element.parts, loops))
            case ast.Each():
                target = self.module(element.target, loops)
                return replace(element, target=target, parts=self.parts(element.parts, loops))
            case ast.Assign():
                value = self.visit("set", element.name, "number", element.value, loops)
                return replace(element, value=value)
            case ast.Local():
                value = self.visit("with", element.name, "number", element.value, loops)
                return replace(element, value=value)
            case _:
                assert_never(element)

    def module(self, module: ast.Module, loops: tuple[str, ...]) -> ast.Module:
        return replace(module, args=self.arguments(module.name, module.args, loops))

    def parts(self, parts: tuple[ast.Part, ...], loops: tuple[str, ...]) -> tuple[ast.Part, ...]:
        return tuple(replace(each, body=self.body(each.body, loops)) for each in parts)

    def split_part(
        self, part: ast.SplitPart | ast.SplitGroup, loops: tuple[str, ...]
    ) -> ast.SplitPart | ast.SplitGroup:
        if isinstance(part, ast.SplitGroup):
            return replace(part, parts=tuple(self.split_part(each, loops) for each in part.parts))
        value = self.visit("split", "size", "length", part.size.value, loops, 0.0)
        size = replace(part.size, value=value)
        return replace(part, size=size, body=self.body(part.body, loops))

    def repeat(self, repeat: ast.Repeat, loops: tuple[str, ...]) -> ast.Repeat:
        head = repeat.head
        inner = (*loops, head.variable)
        if isinstance(head, ast.Count):
            limit = self.visit("repeat", "count", "count", head.limit, loops)
            head = replace(head, limit=limit)
        steps = tuple(
            self.visit("repeat", "steps", "length", each, loops, motion=True)
            for each in repeat.steps
        )
        return replace(repeat, head=head, steps=steps, body=self.body(repeat.body, inner))

    def arguments(
        self, name: str, args: tuple[ast.Argument, ...], loops: tuple[str, ...]
    ) -> tuple[ast.Argument, ...]:
        record = None if name in self.own else OPERATIONS.get(name)
        known = self.parameters(name, record, args)
        turtle = record is not None and record.family == "turtle" and record.effect == "motion"
        draws = record is not None and record.name == "F"
        made = []
        for argument, param in zip(args, known, strict=True):
            kind = _KINDS.get(param.name, _WORDS.get(param.type, "number"))
            kind = kind if record is not None else "number"
            motion = (turtle or draws) and kind in ("length", "angle", "scale")
            value = self.visit(name, param.name, kind, argument.value, loops, param.above, motion)
            made.append(replace(argument, value=value))
        return tuple(made)

    def parameters(
        self, name: str, record: Operation | None, args: tuple[ast.Argument, ...]
    ) -> list[Param]:
        """What is known of each argument's parameter."""
        if record is None:
            names = self.heads.get((name, len(args)), ())
            return [
                Param(arg.name or (names[k] if k < len(names) else f"argument {k + 1}"))
                for k, arg in enumerate(args)
            ]
        form = _form(record, args)
        by_name = {param.name: param for param in form}
        made = []
        for k, arg in enumerate(args):
            given = by_name.get(arg.name) if arg.name is not None else None
            at = form[min(k, len(form) - 1)] if form else Param(f"argument {k + 1}")
            made.append(given or (at if arg.name is None else Param(arg.name)))
        return made


def _form(record: Operation, args: tuple[ast.Argument, ...]) -> tuple[Param, ...]:
    """The first form of an operation that takes so many arguments."""
    for form in record.forms:
        required = sum(not each.optional for each in form)
        if required <= len(args) and (len(args) <= len(form) or any(each.many for each in form)):
            return form
    return record.forms[-1]
