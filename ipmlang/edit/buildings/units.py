"""What an edit moves and stretches as one: the boxes between which attachments are sought.

In go a tree and what was selected, out come units: terminals, shapes that fill whatever scope they
get, and repeated things (a window with its frame) that are small beside what is edited. Shapes
around a selection are opened, so are those whose parts meet others inside. Nothing is solved here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.compiler.diagnostics import fail
from ipmlang.edit.buildings.forms import Forms
from ipmlang.edit.buildings.measuring import Unit
from ipmlang.edit.buildings.tree import Tree, unknown
from ipmlang.inverse.frames import Floats, Integers

SMALL = 0.6  # of the whole along the edited axes: a repeated part that is no larger is one thing
NEAR = 1e-6  # of the diagonal: what is this near touches


def tolerance(tree: Tree) -> float:
    """How near touches, in units of the file."""
    low, high = tree.boxes(np.eye(3))
    return NEAR * max(float(np.linalg.norm(high.max(axis=0) - low.min(axis=0))), 1e-12)


def selected(tree: Tree, name: str, number: int | None = None) -> list[Unit]:
    """The shapes of a symbol, or the terminals of a label, or of an asset whatever their label is,
    that draw anything; only the n-th, from 1. Raises IpmError where there is none.
    """
    count = len(tree.owner)
    shapes: list[Unit] = [
        ("shape", row)
        for row, own in enumerate(tree.names)
        if own == name and tree.first[row] < count
    ]
    found = shapes or [("terminal", row) for row in tree.terminals_of(name)]
    found.sort(key=lambda each: int(tree.first[each[1]]) if each[0] == "shape" else each[1])
    if not found:
        known = set(tree.names) | set(tree.terminals.labels) | set(tree.drawn_assets)
        if name in known:
            raise unknown(f"`{name}` draws nothing here, so it has no size", name, set())
        raise unknown(f"nothing called `{name}` is derived here", name, known - {"start"})
    if number is None:
        return found
    if not 1 <= number <= len(found):
        what = f"there is no `{name}` number {number}: there are {len(found)}"
        hint = "they are counted from 1 in the order of the derivation"
        raise fail("nothing-selected", what, hint=hint)
    return [found[number - 1]]


def is_whole(tree: Tree, unit: Unit) -> bool:
    """Whether a unit is a shape that draws all there is."""
    return unit[0] == "shape" and len(tree.below(unit[1])) == len(tree.owner)


def whole(tree: Tree) -> str:
    """The symbol that the start is made of. Raises IpmError where it is several."""
    found = {tree.names[row] for row in np.flatnonzero(tree.parent == -1).tolist()}
    if found == {"start"}:
        first = np.isin(tree.parent, np.flatnonzero(tree.parent == -1))
        found = {tree.names[row] for row in np.flatnonzero(first).tolist()}
    if len(found) == 1:
        return found.pop()
    many = ", ".join(f"`{name}`" for name in sorted(found)[:5]) or "no shape with rules"
    what = f"the start is no single part but {many}"
    raise fail("nothing-selected", what, hint="choose a part with `--select`")


@dataclass(frozen=True, slots=True, eq=False)
class Units:
    """u units with their boxes (u, 3) along axes (3, 3), rows; opened: shapes that are taken apart;
    rows: the terminals of each.
    """

    units: tuple[Unit, ...]
    low: Floats
    high: Floats
    axes: Floats
    opened: frozenset[int]
    rows: tuple[Integers, ...]


def divided(
    forms: Forms,
    picked: Sequence[Unit],
    axes: Floats,
    along: Sequence[int],
    near: float,
    *,
    fine: bool = False,
) -> Units:
    """The units of a tree for an edit of `picked` that changes sizes along some of the axes; if
    `fine`, they are terminals, and shapes that draw but one.
    """
    tree = forms.tree
    low, high = tree.boxes(axes)
    lows, highs = tree.unions(low, high)
    whole = (high.max(axis=0) - low.min(axis=0))[list(along)]
    often = Counter(tree.names)
    around = {row for unit in picked for row in tree.above(_shape(forms, unit))}
    around -= {unit[1] for unit in picked if _takes_sizes(forms, unit, along)}

    def is_one(row: int) -> bool:
        if row in around or tree.parent[row] < 0:
            return False
        if fine:
            return forms.measured.fills(("shape", row)) and len(tree.below(row)) == 1
        small = bool(((highs[row] - lows[row])[list(along)] <= SMALL * whole).all())
        return forms.measured.fills(("shape", row)) or (often[tree.names[row]] > 1 and small)

    opened: set[int] = set()
    while True:
        units = _gathered(forms, is_one, opened)
        made = _measured(forms, units, low, high, axes, frozenset(opened))
        more = _meeting_inside(forms, made, low, high, list(along), near) - opened
        if not more:
            return made
        opened |= more


def _takes_sizes(forms: Forms, unit: Unit, along: Sequence[int]) -> bool:
    """Whether a shape is resized by giving it another scope."""
    if unit[0] == "terminal" or not forms.measured.fills(unit):
        return False
    low, high = forms.measured.box(unit)
    return bool(((high - low)[list(along)] > 0).all())


def _shape(forms: Forms, unit: Unit) -> int:
    return unit[1] if unit[0] == "shape" else forms.measured.owner(unit)


def _gathered(forms: Forms, is_one: Callable[[int], bool], opened: set[int]) -> list[Unit]:
    """The units that a tree falls into, in the order of the derivation."""
    units: list[Unit] = []
    waiting: list[Unit] = [("shape", 0)]
    while waiting:
        unit = waiting.pop()
        if unit[0] == "terminal" or (unit[1] not in opened and is_one(unit[1])):
            units.append(unit)
        else:
            waiting += reversed(forms.measured.parts(unit[1]))
    return units


def _measured(
    forms: Forms, units: list[Unit], low: Floats, high: Floats, axes: Floats, opened: frozenset[int]
) -> Units:
    rows = tuple(
        np.array([unit[1]] if unit[0] == "terminal" else forms.tree.below(unit[1]), np.int64)
        for unit in units
    )
    lows = np.array([low[each].min(axis=0) for each in rows]).reshape(-1, 3)
    highs = np.array([high[each].max(axis=0) for each in rows]).reshape(-1, 3)
    inside = {row for unit in units for row in forms.tree.above(forms.measured.owner(unit))}
    return Units(tuple(units), lows, highs, axes, opened | inside, rows)


def _meeting_inside(
    forms: Forms, made: Units, low: Floats, high: Floats, along: list[int], near: float
) -> set[int]:
    """The shapes among units whose parts abut those of others, along axes that change, away from
    the faces of their boxes, and that do not say themselves where these go.
    """
    of = np.full(len(low), -1, np.int64)
    for number, rows in enumerate(made.rows):
        of[rows] = number
    pairs = forms.tree.neighbours(near, made.axes)
    pairs = pairs[of[pairs[:, 0]] != of[pairs[:, 1]]]
    low, high, own_low, own_high = (each[:, along] for each in (low, high, made.low, made.high))
    found: set[int] = set()
    for i, j in (pairs.T, pairs[:, ::-1].T):
        abut = np.abs(high[i] - low[j]) <= near
        own, other = of[i], of[j]
        inside = abut & (
            (np.abs(own_high[own] - high[i]) > near) | (np.abs(own_low[other] - low[j]) > near)
        )
        for row in np.flatnonzero(inside.any(axis=1)).tolist():
            at = inside[row]
            if (at & (np.abs(own_high[own[row]] - high[i[row]]) > near)).any():
                found |= _free_shape(forms, made.units[own[row]])
            if (at & (np.abs(own_low[other[row]] - low[j[row]]) > near)).any():
                found |= _free_shape(forms, made.units[other[row]])
    return found


def _free_shape(forms: Forms, unit: Unit) -> set[int]:
    return {unit[1]} if unit[0] == "shape" and not forms.measured.fills(unit) else set()
