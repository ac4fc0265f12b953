"""Copies without a rule: written out one by one, or as rows of a table, whichever is shorter.

Takes spots and what stands at each; gives elements and the tables they read. Counted in tokens, as
everything that competes.
"""

from __future__ import annotations

from collections.abc import Sequence

from ipmlang.compiler import ast
from ipmlang.inverse.naming import Names
from ipmlang.inverse.split.placing import Spot, placed
from ipmlang.inverse.split.wording import NOTHING, Vector
from ipmlang.inverse.wording import several, stem

COLUMNS = ("x", "y", "z", "rx", "ry", "rz", "scale")
ROW = "r"
FEWEST = 3  # rows that are worth a table's name
HEAD = 24  # tokens of `table T(x, y) =` and of `repeat(r in T) { [translate(r.x, r.y, 0) a] }`


def cheapest(
    found: Sequence[Spot], inner: Sequence[ast.Element], name: str, names: Names
) -> tuple[list[ast.Element], list[ast.Table]]:
    """The elements for copies at these spots: those that a table says shorter in repeats over it,
    the others one by one.
    """
    elements: list[ast.Element] = []
    tables: list[ast.Table] = []
    for group in _groups(found):
        if _row_tokens(group) < sum(map(spot_tokens, group)):
            table, element = _tabled(group, inner, names.give(_title(name)))
            tables.append(table)
            elements.append(element)
        else:
            elements += [placed(spot, inner) for spot in group]
    return elements, tables


def _title(name: str) -> str:
    """`windows` for `window`."""
    things = several(name).replace(" ", "_")
    plain = name.replace("_", "").isalpha() and things.isidentifier() and things != name
    return things if plain else f"{stem(name)}_places"


def _groups(found: Sequence[Spot]) -> list[list[Spot]]:
    """Spots that one table could hold: of each hand all together, or those of a turn each alone,
    whichever is shorter.
    """
    groups: list[list[Spot]] = []
    for mirrored in (False, True):
        own = [spot for spot in found if spot.mirrored == mirrored]
        turns: dict[tuple[object, object], list[Spot]] = {}
        for spot in own:
            turns.setdefault((spot.turn, spot.scale), []).append(spot)
        apart = list(turns.values())
        together = min(_row_tokens(own), sum(map(spot_tokens, own))) if own else 0
        alone = sum(min(_row_tokens(each), sum(map(spot_tokens, each))) for each in apart)
        groups += [own] if own and together <= alone else apart
    return groups


def spot_tokens(spot: Spot) -> int:
    """Tokens of a copy that is written out."""
    moved = any(not _same(each, NOTHING) for each in spot.place)
    turned = any(not _same(each, NOTHING) for each in spot.turn)
    inside = (6 + _signs(spot.place)) * moved + (6 + _signs(spot.turn)) * turned
    inside += spot.mirrored + 4 * (spot.scale is not None)
    return inside + 3 if inside else 1


def _signs(values: Sequence[ast.Expr]) -> int:
    return sum(isinstance(each, ast.Number) and each.value < 0 for each in values)


def _row_tokens(group: Sequence[Spot]) -> int:
    """Tokens of copies that are rows of a table."""
    if len(group) < FEWEST:
        return 1_000_000
    columns = _columns(group)
    cells = sum(1 + _signs(values) for values in columns.values()) if len(group) == 1 else 0
    cells = sum(len(values) + _signs(values) for values in columns.values())
    turned = any(name in columns for name in ("rx", "ry", "rz")) or not group[0].plain
    return HEAD + len(columns) + cells + 2 * len(group) + 6 * turned


def _columns(group: Sequence[Spot]) -> dict[str, list[ast.Expr]]:
    """What differs from copy to copy."""
    rows = [_values(spot) for spot in group]
    columns = {name: [row[k] for row in rows] for k, name in enumerate(COLUMNS)}
    return {
        name: values
        for name, values in columns.items()
        if any(not _same(each, values[0]) for each in values)
    }


def _values(spot: Spot) -> tuple[ast.Expr, ...]:
    return (*spot.place, *spot.turn, ast.Number(1.0) if spot.scale is None else spot.scale)


def _same(left: ast.Expr, right: ast.Expr) -> bool:
    return left == right


def _tabled(
    group: Sequence[Spot], inner: Sequence[ast.Element], title: str
) -> tuple[ast.Table, ast.Element]:
    """The table of a group, and the repeat that places its rows."""
    columns = _columns(group)
    rows = tuple(zip(*columns.values(), strict=True))
    table = ast.Table(title, columns=tuple(columns), rows=rows)
    first = group[0]
    scale = ast.Name(f"{ROW}.scale") if "scale" in columns else first.scale
    place = _read(columns, ("x", "y", "z"), first.place)
    turn = _read(columns, ("rx", "ry", "rz"), first.turn)
    body = placed(Spot(place, turn, first.mirrored, scale), inner)
    return table, ast.Repeat(ast.Rows(ROW, title), (body,))


def _read(columns: dict[str, list[ast.Expr]], names: Sequence[str], usual: Vector) -> Vector:
    x, y, z = (
        ast.Name(f"{ROW}.{name}") if name in columns else value
        for name, value in zip(names, usual, strict=True)
    )
    return (x, y, z)
