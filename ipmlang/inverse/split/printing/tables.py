"""Copies without a rule: written out one by one, or as rows of a table, whichever is shorter.

Takes spots and what stands at each; gives elements and the tables they read. Which spots share a
table, and what of them is said once for all, is counted in tokens, as everything that competes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ipmlang.compiler import ast
from ipmlang.inverse.naming import Names
from ipmlang.inverse.split.placing import Spot, placed, steps_to
from ipmlang.inverse.split.wording import NOTHING, Vector, all_nothing, is_nothing
from ipmlang.inverse.wording import several, stem

AXES = (0, 1, 2)
SHIFTS = ("x", "y", "z")
TURNS = ("rx", "ry", "rz")
SCALE = "scale"
FEWEST = 3  # rows that are worth a table's name
HEAD = 13  # tokens of `table T() =` and of `repeat(at T) { A }`
STEP = 6  # `translate(x, y, z)` or `rotate(a, b, c)` without signs
APART = 4  # turns that may have a table each while the rest share one


@dataclass(frozen=True, slots=True)
class Layout:
    """How spots become rows. columns: by axis, what each row says of its place and of its turn;
    scaled: whether rows say a scale; common: what all have besides, behind the row's place.
    """

    shifts: tuple[int, ...]
    turns: tuple[int, ...]
    scaled: bool
    common: Spot

    def cells(self, spot: Spot) -> tuple[ast.Expr, ...]:
        """A row."""
        own = [spot.place[axis] for axis in self.shifts] + [spot.turn[axis] for axis in self.turns]
        return (*own, _scale(spot)) if self.scaled else tuple(own)

    @property
    def columns(self) -> tuple[str, ...]:
        """Their names."""
        names = [SHIFTS[axis] for axis in self.shifts] + [TURNS[axis] for axis in self.turns]
        return (*names, SCALE) if self.scaled else tuple(names)


def cheapest(
    found: Sequence[Spot], inner: Sequence[ast.Element], name: str, names: Names
) -> tuple[list[ast.Element], list[ast.Table]]:
    """The elements for copies at these spots: those that a table says shorter in repeats over it,
    the others one by one.
    """
    elements: list[ast.Element] = []
    tables: list[ast.Table] = []
    for group in grouped(found):
        if pays(group):
            element, table = tabled(group, inner, name, names)
            tables.append(table)
            elements.append(element)
        else:
            elements += [placed(spot, inner) for spot in group]
    return elements, tables


def pays(group: Sequence[Spot]) -> bool:
    """Whether a table of these spots is shorter than they are one by one."""
    return len(group) >= FEWEST and tokens_of(group) < sum(map(spot_tokens, group))


def tabled(
    group: Sequence[Spot], inner: Sequence[ast.Element], name: str, names: Names
) -> tuple[ast.Element, ast.Table]:
    """A repeat over the table of a group, and the table."""
    layout = layout_of(group)
    rows = tuple(layout.cells(spot) for spot in group)
    table = ast.Table(names.give(_title(name)), columns=layout.columns, rows=rows)
    head = ast.Rows("at", table.name, places=True)
    return ast.Repeat(head, behind(layout.common, inner)), table


def behind(common: Spot, inner: Sequence[ast.Element]) -> tuple[ast.Element, ...]:
    """What stands at a row's place; a factor is the turtle's, and has a bracket of its own."""
    return (placed(common, inner),) if common.scale is not None else (*steps_to(common), *inner)


def _title(name: str) -> str:
    """`windows` for `window`."""
    things = several(name).replace(" ", "_")
    plain = name.replace("_", "").isalpha() and things.isidentifier() and things != name
    return things if plain else f"{stem(name)}_places"


def grouped(found: Sequence[Spot]) -> list[list[Spot]]:
    """Spots that one table could hold, those of each hand in the shortest of some ways."""
    groups: list[list[Spot]] = []
    for mirrored in (False, True):
        own = [spot for spot in found if spot.mirrored == mirrored]
        if own:
            groups += min(_ways(own), key=lambda way: sum(map(tokens_of, way)))
    return groups


def _ways(own: list[Spot]) -> Iterator[list[list[Spot]]]:
    """Ways to tell spots apart: the most frequent turns each alone, the rest together, or those
    about each axis together.
    """
    turns: dict[tuple[object, object], list[Spot]] = {}
    for spot in own:
        turns.setdefault((spot.turn, spot.scale), []).append(spot)
    ranked = sorted(turns.values(), key=len, reverse=True)
    for count in [*range(min(APART, len(ranked))), len(ranked)]:
        rest = [spot for group in ranked[count:] for spot in group]
        yield [*ranked[:count], *([rest] if rest else [])]
        about: dict[tuple[bool, ...], list[Spot]] = {}
        for spot in rest:
            about.setdefault(tuple(map(is_nothing, spot.turn)), []).append(spot)
        yield [*ranked[:count], *about.values()]


def tokens_of(group: Sequence[Spot]) -> int:
    """Of a group, in rows or one by one."""
    alone = sum(map(spot_tokens, group))
    return alone if len(group) < FEWEST else min(alone, row_tokens(group, layout_of(group)))


def spot_tokens(spot: Spot) -> int:
    """Tokens of a copy that is written out."""
    inside = _step_tokens(spot)
    return inside + 3 if inside else 1


def _step_tokens(spot: Spot) -> int:
    """Of the operations that lead to a spot."""
    steps = sum(STEP + _signs(each) for each in (spot.place, spot.turn) if not all_nothing(each))
    return steps + spot.mirrored + 4 * (spot.scale is not None)


def _signs(values: Sequence[ast.Expr]) -> int:
    return sum(isinstance(each, ast.Number) and each.value < 0 for each in values)


def row_tokens(group: Sequence[Spot], layout: Layout) -> int:
    """Tokens of copies that are rows of a table."""
    cells = [cell for spot in group for cell in layout.cells(spot)]
    common = _step_tokens(layout.common) + 2 * (layout.common.scale is not None)
    return HEAD + len(layout.columns) + len(cells) + _signs(cells) + common


def layout_of(group: Sequence[Spot]) -> Layout:
    """The shorter way to say what all have in common: behind the table, or in it."""
    varying = tuple(axis for axis in AXES if _differ([spot.place[axis] for spot in group]))
    common = [axis for axis in AXES if axis not in varying and not is_nothing(group[0].place[axis])]
    turned = _differ([spot.turn for spot in group])
    scaled = _differ([spot.scale for spot in group])
    every = [axis for axis in AXES if any(not is_nothing(spot.turn[axis]) for spot in group)]
    turns = tuple(every) if turned or scaled else ()
    within = _laid(group, tuple(sorted({*varying, *common})), turns, scaled)
    behind = _laid(group, varying, turns, scaled)
    if not common or scaled or (turns and common != list(turns)):
        return within
    return min(behind, within, key=lambda each: row_tokens(group, each))


def _laid(
    group: Sequence[Spot], shifts: tuple[int, ...], turns: tuple[int, ...], scaled: bool
) -> Layout:
    """The layout with these columns."""
    first = group[0]
    x, y, z = (NOTHING if axis in shifts else first.place[axis] for axis in AXES)
    turn: Vector = (NOTHING, NOTHING, NOTHING) if turns else first.turn
    scale = None if scaled else first.scale
    return Layout(shifts, turns, scaled, Spot((x, y, z), turn, first.mirrored, scale))


def _differ(values: Sequence[object]) -> bool:
    return any(each != values[0] for each in values)


def _scale(spot: Spot) -> ast.Expr:
    return ast.Number(1.0) if spot.scale is None else spot.scale
