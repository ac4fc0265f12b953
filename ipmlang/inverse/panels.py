"""Panels: unlike groups under effects that stand on a grid, each a rule, all placed by one loop.

A deck of cards, the panels of a figure, the icons of a sheet: each is clipped to its own frame, is
drawn once and would be written out where it stands. Where their places are the nodes of a grid,
takes the axiom as it is printed and gives a table that names them and
`repeat(k < 52) with r in T { [at(…) effect(…) r.shape] }`. What is drawn, and in which order, stays
the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipmlang.compiler import ast
from ipmlang.compiler.places import SHAPE
from ipmlang.inverse.gridded_tables import Grid, grid_of, gridded_loop
from ipmlang.inverse.lsystem.frames import Complexes
from ipmlang.inverse.naming import Names
from ipmlang.inverse.simplify import AXIOM, Book

ROW = "r"
ASIDE = 3  # groups before and behind a grid that do not belong to it, a title or a legend


@dataclass(frozen=True, slots=True, eq=False)
class Panels:
    """The groups of the axiom that stand on a grid, one after the other, and where (n,)."""

    groups: tuple[int, ...]
    places: Complexes
    grid: Grid | None


NO_PANELS = Panels((), np.zeros(0, np.complex128), None)


def panels_of(book: Book, error: float) -> Panels:
    """The longest run of groups under effects whose places are a grid; error: units, what a place
    may be off.
    """
    body, inlined = book.bodies[AXIOM], book.inlined()
    if not inlined:
        return NO_PANELS
    places = body.places
    plain = (places.handedness > 0) & (abs(places.scale - 1) < 1e-9) & (abs(places.angle) < 1e-9)
    parts = body.parts.tolist()
    held = [part in inlined and own for part, own in zip(parts, plain.tolist(), strict=True)]
    ends = np.flatnonzero(np.diff(np.array([False, *held, False]).astype(np.int8)))
    runs = sorted(zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True), key=_length)
    for start, stop in runs:
        points = places.x[start:stop] + 1j * places.y[start:stop]
        found = _longest(points, error)
        if found is not None:
            first, grid, count = found
            at = start + first
            return Panels(tuple(parts[at : at + count]), points[first : first + count], grid)
    return NO_PANELS


def _length(run: tuple[int, int]) -> int:
    return run[0] - run[1]


def _longest(points: Complexes, error: float) -> tuple[int, Grid, int] | None:
    """The first of the points on a grid, the grid and how many they are."""
    aside = [(first, last) for first in range(ASIDE + 1) for last in range(ASIDE + 1)]
    for first, last in sorted(aside, key=sum):
        own = points[first : len(points) - last]
        grid = grid_of(own, error)
        if grid is not None:
            return first, grid, len(own)
    return None


def with_panels(
    rules: Sequence[ast.Rule], panels: Panels, given: Sequence[str], names: Names, error: float
) -> tuple[list[ast.Rule], list[ast.Table]]:
    """The rules with one for each panel, and the table that names them, if the axiom says them one
    after the other. rules: the axiom first; given: the names of the panels; error: units, what a
    printed place may be off.
    """
    axiom, *others = rules
    start = _begin(axiom.body, panels, error)
    if panels.grid is None or start is None:
        return list(rules), []
    stop = start + len(panels.groups)
    inside = [_inside(each) for each in axiom.body[start:stop]]
    alike = all(each[0] == inside[0][0] and len(each) > 1 for each in inside)
    shared = inside[0][:1] if alike else ()
    made: dict[tuple[ast.Element, ...], ast.Rule] = {}
    cells: list[tuple[ast.Expr, ...]] = []
    for name, body in zip(given, inside, strict=True):
        own: tuple[ast.Element, ...] = body[1:] if alike else (ast.Bracket(body),)
        rule = made.setdefault(own, ast.Rule(ast.Head(name), own))
        cells.append((ast.Name(rule.head.name),))
    table = ast.Table(names.give("Panels"), None, (SHAPE,), tuple(cells))
    loop = gridded_loop(panels.grid, table, ROW, (), (*shared, ast.Module(f"{ROW}.{SHAPE}")))
    body = (*axiom.body[:start], loop, *axiom.body[stop:])
    return [replace(axiom, body=body), *made.values(), *others], [table]


def _begin(body: tuple[ast.Element, ...], panels: Panels, error: float) -> int | None:
    """Which element of the axiom is the first panel."""
    where = [_place(each) for each in body]
    for start in range(len(body) - len(panels.places) + 1):
        own = where[start : start + len(panels.places)]
        if all(
            place is not None and abs(place - point) <= error
            for place, point in zip(own, panels.places.tolist(), strict=True)
        ):
            return start
    return None


def _place(element: ast.Element) -> complex | None:
    """Where a bracket stands that says an effect, None if it is none such."""
    match element:
        case ast.Bracket((ast.Module("effect"), *_)):
            return 0j
        case ast.Bracket((ast.Module("at", (x, y)), ast.Module("effect"), *_)):
            if isinstance(x.value, ast.Number) and isinstance(y.value, ast.Number):
                return complex(x.value.value, y.value.value)
    return None


def _inside(element: ast.Element) -> tuple[ast.Element, ...]:
    """What a panel says, from its effect on."""
    assert isinstance(element, ast.Bracket)
    first = element.body[0]
    moved = isinstance(first, ast.Module) and first.name == "at"
    return element.body[moved:]
