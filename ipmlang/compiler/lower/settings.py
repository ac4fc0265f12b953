"""The settings of a program: attributes, turtle, limits, canvas, tropism.

In go the items of its files, out come the fields of a program. Numbers that are known are computed
here; those of a tropism or a limit that attributes decide become code, any other is an error.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

from ipmlang.compiler import ast, ir
from ipmlang.compiler.lower.expr import Code, Known, Operand, Pool
from ipmlang.compiler.lower.meaning import Settings
from ipmlang.compiler.lower.names import Place, Unit

ATTR_SITE = 0x30000000
LATE_SITE = 0x28000000
DEEPEST = 5_000  # generations of a program with scopes, if nothing else is said


def attributes(pool: Pool, units: Sequence[Unit]) -> tuple[ir.Attribute, ...]:
    """The attributes of all files, in an order in which each default reads only earlier ones."""
    made: list[ir.Attribute] = []
    places = _places(units)
    while places:
        before = len(made)
        waiting = []
        for place, item, original in places:
            if _reads_unknown(pool, place.unit, item.default):
                waiting.append((place, item, original))
                continue
            made.append(_attribute(pool, place, item, original))
            pool.attrs[made[-1].name] = len(made) - 1
        if len(made) == before:
            place, item, _ = waiting[0]
            message = f"the default of `{item.name}` depends on itself"
            raise place.unit.error(place.item, item.span, "endless-definition", message)
        places = waiting
    return tuple(made)


def _places(units: Sequence[Unit]) -> list[tuple[Place, ast.Attr, Place]]:
    """All attributes, each once, with where it stands as its file has it."""
    found: dict[tuple[int, int], tuple[Place, ast.Attr, Place]] = {}
    for unit in units:
        written = {item.name: Place(unit, number) for number, item in unit.items(ast.Attr)}
        for name, place in unit.defined.items():
            item = place.unit.grammar.items[place.item]
            if isinstance(item, ast.Attr):
                known = (place, item, written.get(name, place))
                found.setdefault((id(place.unit), place.item), known)
    return list(found.values())


def _reads_unknown(pool: Pool, unit: Unit, expr: ast.Expr) -> bool:
    """Whether an expression reads an attribute that has no number yet."""
    match expr:
        case ast.Name():
            place = unit.find(expr.id)
            if place is None:
                return False
            item = place.unit.grammar.items[place.item]
            if isinstance(item, ast.Const):
                return _reads_unknown(pool, place.unit, item.value)
            return isinstance(item, ast.Attr) and place.unit.attribute(item.name) not in pool.attrs
        case ast.Call():
            return any(_reads_unknown(pool, unit, each.value) for each in expr.args)
        case ast.Unary():
            return _reads_unknown(pool, unit, expr.value)
        case ast.Binary():
            return any(_reads_unknown(pool, unit, each) for each in (expr.left, expr.right))
        case ast.If():
            parts = (expr.condition, expr.value, expr.other)
            return any(_reads_unknown(pool, unit, each) for each in parts)
        case _:
            return False


def _attribute(pool: Pool, place: Place, item: ast.Attr, original: Place) -> ir.Attribute:
    """One attribute; what a redefinition does not say is as in the original."""
    unit, number = place.unit, place.item
    name = unit.attribute(item.name)
    code = Code(pool, unit, number)
    code.counter.site = ATTR_SITE | (zlib.crc32(name.encode()) & 0xFFFFFF0)
    register = code.register(code.value(item.default, {}))
    first = original.unit.grammar.items[original.item]
    assert isinstance(first, ast.Attr)
    if item.allowed is None:
        unit, number = original.unit, original.item
    allowed = item.allowed or first.allowed
    low = high = None
    choices: tuple[str | float, ...] = ()
    if isinstance(allowed, ast.Range):
        low, high = (_bound(pool, unit, number, end) for end in (allowed.low, allowed.high))
    elif isinstance(allowed, ast.Choices):
        choices = tuple(
            value.value if isinstance(value, ast.Text) else _number(pool, unit, number, value)
            for value in allowed.values
        )
    return ir.Attribute(
        name,
        _type(item if item.type is not None else first),
        (tuple(code.instructions), register),
        code.counter.register,
        low,
        high,
        choices,
        item.doc or first.doc,
    )


def _type(item: ast.Attr) -> Literal["int", "float", "bool", "string"]:
    match item.type, item.default:
        case ("int" | "float" | "bool" | "string") as given, _:
            return given
        case _, ast.Truth():
            return "bool"
        case _, ast.Text():
            return "string"
        case _:
            return "float"


def _bound(pool: Pool, unit: Unit, item: int, expr: ast.Expr | None) -> float | None:
    return None if expr is None else _number(pool, unit, item, expr)


def _number(pool: Pool, unit: Unit, item: int, expr: ast.Expr) -> float:
    code = Code(pool, unit, item)
    operand = code.value(expr, {})
    if isinstance(operand, Known):
        return operand.value
    raise code.error(
        expr.span, "not-constant", "this number must be known before a derivation starts"
    )


INDICES = {"split.index": 0.0, "split.count": 1.0}  # and what they are outside all splits


def indices(pool: Pool, units: Sequence[Unit]) -> tuple[int, int] | None:
    """The numbers of the attributes that hold `split.index` and `split.count`, which each split
    sets for its parts; None where no file names them.
    """
    if not any(name in unit.source.text for unit in units for name in INDICES):
        return None
    first, second = (pool.attrs.setdefault(name, len(pool.attrs)) for name in INDICES)
    return first, second


def hidden(numbers: tuple[int, int] | None) -> tuple[ir.Attribute, ...]:
    """The attributes that nobody wrote."""
    if numbers is None:
        return ()
    return tuple(
        ir.Attribute(name, "int", ((ir.Instruction("const", 0, const=value),), 0), 1, hidden=True)
        for name, value in INDICES.items()
    )


def varied(attrs: Sequence[ir.Attribute]) -> tuple[int, ...]:
    """The attributes whose defaults draw random numbers, or read one that does."""
    found: set[int] = set()
    for number, attr in enumerate(attrs):
        code, _ = attr.default
        if any(each.op == "uniform" or (each.op == "attr" and each.const in found)
               for each in code):  # fmt: skip
            found.add(number)
    return tuple(sorted(found))


def ground(pool: Pool, unit: Unit, number: int, place: ast.Place | None) -> ir.Ground | None:
    """What the start stands on; None for a turtle, a unit square or a surface."""
    if place is None or place.kind == "surface":
        return None
    if place.kind == "file":
        assert place.reference is not None
        file, _, node = place.reference.partition("#")
        return ir.Ground("file", path=(unit.folder / file).absolute(), node=node or None)
    code = Code(pool, unit, number)
    code.shaped = False
    width = 3
    exprs: list[ast.Expr] = list(place.args)
    if place.kind == "polygon":
        corners = [each.items if isinstance(each, ast.Tuple) else () for each in place.args]
        widths = {len(each) for each in corners}
        if len(widths) != 1 or not widths <= {2, 3}:
            message = "the corners of a polygon are all (x, y), or all (x, y, z)"
            raise unit.error(number, place.span, "wrong-arguments", message)
        width = widths.pop()
        exprs = [each for corner in corners for each in corner]
    outputs = tuple(code.register(code.value(each, {})) for each in exprs)
    made = tuple(code.instructions)
    return ir.Ground(place.kind, made, code.counter.register, outputs, width)


def turtle(unit: Unit) -> Settings:
    """The words of the `turtle` items, the last one of each."""
    return {
        setting.key: (number, setting.value)
        for number, item in unit.items(ast.Turtle)
        for setting in item.settings
    }


def is_abop(settings: Settings) -> bool:
    """Whether the turtle starts as in the book."""
    frame = settings.get("frame", (0, ast.Name("")))[1]
    return isinstance(frame, ast.Name | ast.Text) and "abop" in (
        frame.id if isinstance(frame, ast.Name) else frame.value
    )


def prelude(settings: Settings) -> tuple[ast.Module, ...]:
    """What stands before the axiom: a pen width that is known only when a run starts."""
    width = settings.get("width")
    return () if width is None or isinstance(width[1], ast.Number) else (ast.Module("!"),)


def pen_width(pool: Pool, unit: Unit, settings: Settings) -> float | None:
    """The width that the pen starts with, None where nothing sets it."""
    item, width = settings.get("width", (0, ast.Name("")))
    return _number(pool, unit, item, width) if isinstance(width, ast.Number) else None


Four = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Fixed:
    """The limits and the tropism of a program as far as they are known; what only attributes decide
    is `late`, and a tropism of that kind NaN where it is not known.
    """

    limits: ir.Limits
    tropism: Four | None
    late: ir.Late | None


def fixed(pool: Pool, unit: Unit, *, scoped: bool) -> Fixed:
    """Where a derivation stops, and what bends its segments. A generation of shapes with scopes
    takes much longer than one of modules alone, and no building is so deep.
    """
    code = Code(pool, unit, -1)
    code.counter.site = LATE_SITE
    known, registers = _limits(code, unit)
    tropism = _tropism(code, unit)
    bent = None
    if tropism is not None and not all(isinstance(each, Known) for each in tropism):
        x, y, z, elasticity = (code.register(each) for each in tropism)
        bent = (x, y, z, elasticity)
    late = ir.Late(tuple(code.instructions), code.counter.register, bent, tuple(registers.items()))
    return Fixed(
        replace(ir.Limits(steps=DEEPEST) if scoped else ir.Limits(), **known),
        None if tropism is None else _values(tropism),
        late if bent or registers else None,
    )


def _values(operands: tuple[Operand, Operand, Operand, Operand]) -> Four:
    x, y, z, elasticity = (each.value if isinstance(each, Known) else math.nan for each in operands)
    return x, y, z, elasticity


def _limits(code: Code, unit: Unit) -> tuple[dict[str, int], dict[str, int]]:
    """The limits that are known, and the registers of the others."""
    known: dict[str, int] = {}
    registers: dict[str, int] = {}
    for number, item in unit.items(ast.Limit):
        for setting in item.settings:
            code.item = number
            operand = code.value(setting.value, {})
            if isinstance(operand, Known):
                known[setting.key] = int(operand.value)
            else:
                registers[setting.key] = code.register(operand)
    return known, registers


def _tropism(code: Code, unit: Unit) -> tuple[Operand, Operand, Operand, Operand] | None:
    """The vector and the elasticity of the last `tropism` item."""
    for number, item in reversed(list(unit.items(ast.Tropism))):
        code.item = number
        parts = item.vector.items if isinstance(item.vector, ast.Tuple) else (item.vector,)
        vector = [code.value(part, {}) for part in parts]
        x, y, z = (*vector, *[code.number(0)] * 3)[:3]
        return x, y, z, code.value(item.elasticity, {})
    return None


def canvas(
    pool: Pool, unit: Unit
) -> tuple[tuple[float, float, float, float] | None, tuple[str | None, str | None], int | None]:
    """The box of a drawing, its width and height as they were written, and its decimals."""
    for number, item in reversed(list(unit.items(ast.Canvas))):
        x, y, width, height = (_number(pool, unit, number, each) for each in item.box)
        return (x, y, width, height), (item.width, item.height), item.decimals
    return None, (None, None), None
