"""Nearly equal parameters made equal: steps, angles and scales snap to common, rounder values.

Takes drafts and gives drafts. Values of one kind that lie within a tolerance of each other become
one value, angles near a multiple of 15 degrees that multiple, and what is nearly nothing nothing.
Offsets that a `repeat` takes row by row from a table beside its count are left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import fail
from ipmlang.compiler.format import format_expression
from ipmlang.compiler.nodes import nodes
from ipmlang.edit.arithmetic import literal, number_of
from ipmlang.edit.draft import Change, Draft, with_parameters
from ipmlang.edit.places import Kind, Place, places
from ipmlang.edit.regular import with_even_steps, without_offsets

SHARE = 0.002  # of the largest length: what lengths may differ by, unless told
ROUND_ANGLE = 15.0
PLACES: dict[str, Kind] = {
    **dict.fromkeys(("x", "y", "z"), "length"),
    **dict.fromkeys(("rx", "ry", "rz"), "angle"),
    "scale": "scale",
}


@dataclass(frozen=True, slots=True)
class Tolerances:
    """What may be made equal: lengths in units (None: 0.2 % of the largest), angles in degrees,
    scales as a share.
    """

    length: float | None = None
    angle: float = 0.5
    scale: float = 0.005


@dataclass(frozen=True, slots=True)
class _Value:
    """A literal of some kind: a place by its number, or the default of an item. Only values of one
    `family` become equal: coordinates in the frame of one rule, steps anywhere.
    """

    kind: Kind
    family: str
    value: float
    place: int | None
    item: int | None


def symmetrise(draft: Draft, tolerances: Tolerances | None = None) -> Draft:
    r"""The draft with nearly equal parameters equal, and without offsets from tables.

    >>> from ipmlang.edit.draft import read_text
    >>> text = 'ipm 1\nRow --> [+(89.8) A] f(12.9) [+(90.1) A] f(13.2) A\nstart Row'
    >>> print(symmetrise(read_text(text), Tolerances(length=0.5)).text.splitlines()[1])
    Row --> [+(90) A] f(13) [+(90) A] f(13) A
    """
    draft = without_offsets(draft)
    found = places(draft.grammar)
    values = _values(draft.grammar)
    limits = _limits(values, tolerances or Tolerances())
    after: dict[int, float] = {}
    for kind, family in dict.fromkeys((each.kind, each.family) for each in values):
        own = [k for k, each in enumerate(values) if (each.kind, each.family) == (kind, family)]
        common = _common([abs(values[number].value) for number in own], kind, limits[kind])
        after |= dict(zip(own, common, strict=True))
    made: dict[int, ast.Expr] = {}
    items: dict[int, float] = {}
    for number, size in after.items():
        each = values[number]
        value = -size if each.value < 0 else size
        if value == each.value:
            continue
        if each.place is not None:
            made[each.place] = literal(value)
        elif each.item is not None:
            items[each.item] = value
    draft = with_parameters(draft, {k: found[k] for k in made}, made)
    return with_even_steps(_with_defaults(draft, items))


def _limits(values: Sequence[_Value], tolerances: Tolerances) -> dict[Kind, float]:
    lengths = [abs(each.value) for each in values if each.kind == "length"]
    length = tolerances.length
    if length is None:
        length = SHARE * max(lengths, default=0.0)
    found: dict[Kind, float] = {
        "length": length, "angle": tolerances.angle, "scale": tolerances.scale,
    }  # fmt: skip
    if any(not 0 <= each < float("inf") for each in found.values()):
        raise fail("bad-command", "a tolerance is 0 or more")
    return found


# ------------------------------------------------------------------ what there is to snap


def _values(grammar: ast.Grammar) -> list[_Value]:
    """Literals of motions; cells of tables and defaults of items that motions take as they are."""
    kinds: dict[str, Kind] = {}
    every = places(grammar)
    for place, expr in every:
        if place.motion and isinstance(expr, ast.Name):
            kinds[expr.id] = place.kind
    cells = _cells(grammar, kinds)
    found = [
        _Value(kind, _family(place), expr.value, number, None)
        for number, (place, expr) in enumerate(every)
        if isinstance(expr, ast.Number) and (kind := _kind(place, cells)) is not None
    ]
    for number, item in enumerate(grammar.items):
        value = _default(item)
        if value is not None and isinstance(item, ast.Attr | ast.Const) and item.name in kinds:
            found.append(_Value(kinds[item.name], "", value, None, number))
    return found


def _family(place: Place) -> str:
    is_coordinate = place.parameter in ("x", "y", "z") or place.operation == "row"
    return place.rule if is_coordinate else ""


def _kind(place: Place, cells: Mapping[tuple[str, str], Kind]) -> Kind | None:
    if place.operation == "row":
        return cells.get((place.rule, place.parameter))
    return place.kind if place.motion else None


def _cells(grammar: ast.Grammar, kinds: Mapping[str, Kind]) -> dict[tuple[str, str], Kind]:
    """The kinds of the columns of tables: `r.x` of `repeat(r in T)` for the column x of T."""
    found: dict[tuple[str, str], Kind] = {}
    for node in nodes(grammar):
        if not isinstance(node, ast.Rows):
            continue
        if node.places:
            found.update(((node.table, column), kind) for column, kind in PLACES.items())
        for name, kind in kinds.items():
            variable, dot, column = name.partition(".")
            if dot and variable == node.variable:
                found[node.table, column] = kind
    return found


def _default(item: ast.Item) -> float | None:
    match item:
        case ast.Attr(type="float" | None, default=expr) | ast.Const(value=expr):
            return number_of(expr)
        case _:
            return None


def _with_defaults(draft: Draft, values: Mapping[int, float]) -> Draft:
    """Attributes and constants with other numbers."""
    items = list(draft.grammar.items)
    changes = []
    for number, value in values.items():
        item, after = items[number], literal(value)
        if isinstance(item, ast.Attr):
            changes.append(_change(item.name, item.default, after))
            items[number] = replace(item, default=after)
        elif isinstance(item, ast.Const):
            changes.append(_change(item.name, item.value, after))
            items[number] = replace(item, value=after)
    grammar = replace(draft.grammar, items=tuple(items))
    return replace(draft, grammar=grammar, changes=(*draft.changes, *changes))


def _change(name: str, before: ast.Expr, after: ast.Expr) -> Change:
    return Change(name, format_expression(before), format_expression(after))


# ------------------------------------------------------------------------ common values


def _common(sizes: Sequence[float], kind: Kind, limit: float) -> list[float]:
    """A value for each size: that of its neighbourhood.

    >>> _common([12.9, 40.0, 13.2], "length", 0.5)
    [13.0, 40.0, 13.0]
    """
    order = sorted(range(len(sizes)), key=lambda k: sizes[k])
    made = [0.0] * len(sizes)
    for group in _groups(order, sizes, kind, limit):
        value = _round(sorted(sizes[k] for k in group), kind, limit)
        for k in group:
            made[k] = value
    return made


def _groups(
    order: Sequence[int], sizes: Sequence[float], kind: Kind, limit: float
) -> Iterable[list[int]]:
    """Neighbours that differ by no more than the tolerance."""
    group: list[int] = []
    for k in order:
        if group and sizes[k] - sizes[group[0]] > _reach(limit, kind, sizes[k]):
            yield group
            group = []
        group.append(k)
    if group:
        yield group


def _reach(limit: float, kind: Kind, size: float) -> float:
    """A tolerance in units: that of scales is a share."""
    return limit * size if kind == "scale" else limit


def _round(sizes: Sequence[float], kind: Kind, limit: float) -> float:
    """The roundest number between equal ones; what is nearly neutral is neutral."""
    mean = sum(sizes) / len(sizes)
    special = [1.0 if kind == "scale" else 0.0]
    if kind == "angle":
        special.append(ROUND_ANGLE * round(mean / ROUND_ANGLE))
    for value in special:
        if value - limit <= sizes[0] and sizes[-1] <= value + limit:
            return value
    error = max(mean - sizes[0], sizes[-1] - mean)
    if error == 0:
        return sizes[0]
    return next(v for v in (round(mean, n) + 0.0 for n in range(17)) if abs(v - mean) <= error)
