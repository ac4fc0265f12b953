"""A lattice rule as syntax: loops over its nodes, with a table of what is left over for each copy.

Takes a rule with rounded numbers; gives the loop and its table. Whole lattices are nested loops;
what has holes or rows of a table is one loop over all nodes. Nothing here decides anything.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ipmlang.compiler import ast
from ipmlang.inverse.lattices.formula import COLUMNS, Formula, LatticeRule
from ipmlang.inverse.lsystem.frames import Floats, Frames
from ipmlang.inverse.moves import call, turns
from ipmlang.inverse.numbers import is_whole_turn, number, shortest

ROW = "r"
Errors = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Handles:
    """What stands in place of numbers: the members of a line, the lines, and the steps from one
    member and from one line to the next; None where the number itself does.
    """

    members: ast.Expr | None = None
    lines: ast.Expr | None = None
    step: ast.Expr | None = None
    line_step: ast.Expr | None = None


PLAIN = Handles()


def closed(formula: Formula) -> bool:
    """Whether a ring's members are one full turn, but for the last digit of its step."""
    whole = is_whole_turn(formula.turned_by, formula.length, 1e-5)
    return formula.polar is not None and not formula.nested and whole


def whole(rule: LatticeRule) -> bool:
    """Whether every node has a member, all lines as many, and no table says more about one."""
    even = rule.formula.count % rule.formula.length == 0
    return even and not rule.columns and not rule.holes


def printed(
    rule: LatticeRule,
    copy: tuple[ast.Element, ...],
    errors: Errors,
    table: str,
    handles: Handles = PLAIN,
) -> tuple[ast.Repeat, ast.Table | None]:
    """The loop, and the table that it reads, named `table`.

    copy: what stands at a node; errors: of places, angles (degrees) and factors; handles: for a
    lattice that is `whole`.
    """
    formula = rule.formula
    columns, cells = _cells(rule, errors)
    nested = bool(formula.across) and whole(rule)
    i, j = indices(formula, nested)
    inside = _inside(rule, columns)
    body = (
        *predicted(formula, i, j, handles),
        *_constant(formula.inside, errors),
        *inside,
        *copy,
    )
    bracket: tuple[ast.Element, ...] = (ast.Bracket(body),)
    if nested:
        lines = formula.count // formula.across
        row = ast.Repeat(ast.Count("i", handles.members or _count(formula.across)), bracket)
        return ast.Repeat(ast.Count("j", handles.lines or _count(lines)), (row,)), None
    holes = tuple(_count(each) for each in rule.holes)
    variable = "k" if formula.across else "i"
    if not columns:
        members = handles.members or _count(formula.count)
        return ast.Repeat(ast.Count(variable, members), bracket, holes=holes), None
    rows = tuple(zip(*cells, strict=True))
    loop = ast.Repeat(
        ast.Count(variable, _count(formula.count)),
        bracket,
        holes=holes,
        rows=ast.Rows(ROW, table),
    )
    return loop, ast.Table(table, None, tuple(columns), rows)


def _count(value: int) -> ast.Expr:
    return ast.Number(float(value))


def indices(
    formula: Formula, nested: bool, node: ast.Expr | None = None
) -> tuple[ast.Expr, ast.Expr]:
    """Expressions of i and j. node: what the node's number is where it is not k."""
    if not formula.across or nested:
        return ast.Name("i"), ast.Name("j")
    across = _count(formula.across)
    k = ast.Name("k") if node is None else node
    quotient = ast.Binary("/", k, across)
    return _function("mod", k, across), _function("floor", quotient)


def _function(name: str, *args: ast.Expr) -> ast.Call:
    return ast.Call(name, tuple(ast.Argument(each) for each in args))


def _sum(terms: Sequence[tuple[float | ast.Expr, ast.Expr | None]]) -> ast.Expr:
    """`a + b * i - c * j`, terms that are nothing left out."""
    made: ast.Expr | None = None
    for value, factor in terms:
        if not isinstance(value, float | int):
            assert factor is not None
            term: ast.Expr = ast.Binary("*", value, factor)
            made = term if made is None else ast.Binary("+", made, term)
            continue
        if value == 0:
            continue
        size = abs(value)
        if made is None:
            made = number(value) if factor is None else _times(value, factor)
        else:
            term = ast.Number(size) if factor is None else _times(size, factor)
            made = ast.Binary("+" if value > 0 else "-", made, term)
    return ast.Number(0.0) if made is None else made


def _times(value: float, factor: ast.Expr) -> ast.Expr:
    return factor if value == 1 else ast.Binary("*", number(value), factor)


def predicted(
    formula: Formula, i: ast.Expr, j: ast.Expr, handles: Handles = PLAIN
) -> tuple[ast.Element, ...]:
    """What leads to a node."""
    angle = [(float(formula.turn[0]), i), (float(formula.turn[1]), j)]
    grown = _grown(formula, i, j)
    turned, scaled = bool(formula.turn.any()), bool(formula.growth.any())
    if formula.polar is None:
        assert formula.moves is not None
        square = ast.Binary("*", i, i)
        odd = _function("mod", j, ast.Number(2.0))
        at = []
        for first, second, bend in formula.moves.tolist():
            step = handles.step if first and handles.step is not None else first
            line_step = handles.line_step if second and handles.line_step is not None else second
            terms = [(step, i), (first * formula.stagger, odd), (line_step, j), (bend, square)]
            at.append(_sum([(value, each) for value, each in terms]))
        more = [_sum([(v, e) for v, e in angle])] if turned or scaled else []
        more += [grown] if scaled else []
        return (call("at", *at, *more),)
    turn, twist, first, second = formula.polar.tolist()
    each: float | ast.Expr = turn
    if handles.members is not None and closed(formula):
        each = ast.Binary("/", number(360.0 if turn > 0 else -360.0), handles.members)
    around = _sum([(each, i), (twist, j)])
    made: list[ast.Element] = [call("+", around), call("f", _radius(formula, first, second, i, j))]
    if formula.upright:
        made.append(call("-", around))
    if turned:
        made.append(call("+", _sum([(v, e) for v, e in angle])))
    if scaled:
        made.append(call("*", grown))
    return tuple(made)


def _grown(formula: Formula, i: ast.Expr, j: ast.Expr) -> ast.Expr:
    """How large a member is beside the first."""
    grown: list[tuple[float | ast.Expr, ast.Expr | None]] = [
        (float(formula.growth[0]), i),
        (float(formula.growth[1]), j),
    ]
    if formula.geometric:
        return _function("exp", _sum(grown))
    return _sum([(1.0, None), *grown])


def _radius(formula: Formula, first: float, second: float, i: ast.Expr, j: ast.Expr) -> ast.Expr:
    index = j if formula.nested else i
    if formula.radial == "root":
        return _times(first, _function("sqrt", _sum([(1.0, index), (second, None)])))
    if formula.radial == "power":
        return _times(first, _function("exp", _times(second, index)))
    return _sum([(first, None), (second, index)])


def _constant(inside: Frames, errors: Errors) -> tuple[ast.Element, ...]:
    """What all members are turned, sized and moved by."""
    x, y = (shortest(float(each[0]), errors[0] / 8) for each in (inside.x, inside.y))
    angle, scale = float(inside.angle[0]), float(inside.scale[0])
    if x or y:
        more = [number(angle), number(scale)] if scale != 1 else [number(angle)] if angle else []
        return (call("at", number(x), number(y), *more),)
    return turns(angle, scale)


def _inside(rule: LatticeRule, columns: Sequence[str]) -> tuple[ast.Element, ...]:
    """`at(r.x, r.y, r.angle, r.scale)`, what no column says left out."""
    has = [name in columns for name in COLUMNS]
    rest = (0.0, 0.0, 0.0, 1.0)
    cells: list[ast.Expr] = [
        ast.Name(f"{ROW}.{name}") if known else ast.Number(value)
        for name, known, value in zip(COLUMNS, has, rest, strict=True)
    ]
    if has[0] or has[1]:
        last = 4 if has[3] else 3 if has[2] else 2
        return (call("at", *cells[:last]),)
    made: list[ast.Element] = []
    if has[2]:
        made.append(call("+", cells[2]))
    if has[3]:
        made.append(call("*", cells[3]))
    return tuple(made)


def _cells(rule: LatticeRule, errors: Errors) -> tuple[list[str], list[list[ast.Expr]]]:
    """The residual columns as short numbers."""
    rooms = dict(zip(COLUMNS, (errors[0], errors[0], errors[1], errors[2]), strict=True))
    columns: list[str] = []
    cells: list[list[ast.Expr]] = []
    for name in rule.columns:
        values: Floats = getattr(rule.residual, name)
        columns.append(name)
        cells.append([number(value, rooms[name]) for value in values.tolist()])
    return columns, cells
