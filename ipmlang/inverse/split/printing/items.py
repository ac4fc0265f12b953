"""The items of a rule as elements of its body: copies, rows, grids, rings, splits, octants.

Takes items of a scheme with names for what they place; gives syntax trees. Each item is printed in
its shortest clear form; the text of tables that are needed goes to a list. Nothing here decides
what a rule is made of.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import assert_never

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.frames import (
    Floats,
)
from ipmlang.inverse.naming import Names
from ipmlang.inverse.numbers import shortest
from ipmlang.inverse.split.placing import Precision, Spot, placed, spots, steps_to
from ipmlang.inverse.split.printing.schedules import Copies
from ipmlang.inverse.split.printing.tables import cheapest
from ipmlang.inverse.split.scheme import (
    Array,
    Direction,
    Item,
    Octant,
    Place,
    Ring,
    Scheme,
    Split,
    Terminal,
)
from ipmlang.inverse.split.turning import axis_frame, first_around
from ipmlang.inverse.split.wording import (
    NOTHING,
    Vector,
    added,
    all_nothing,
    bracket,
    call,
    is_nothing,
    plus,
    times,
)

INDICES = ("i", "j", "k")
EXTENTS = ("scope.sx", "scope.sy", "scope.sz")


@dataclass(slots=True, eq=False)
class Wording:
    """What all items are printed with. names: of the symbols; reach: how far each gets from its own
    origin; sized: symbols that need a scope of their own size, with that size; sizing: those of
    them whose rules set it, as they stand in no cell; counts: expressions that stand for a count,
    by (rule, item, direction); one_by_one: no tables; bodies: what gives the bodies of rules that
    are said where they are used.
    """

    scheme: Scheme
    names: Sequence[str]
    precision: Precision
    reach: Floats
    sized: dict[int, Vector] = field(default_factory=dict)
    sizing: frozenset[int] = frozenset()
    counts: dict[tuple[int, int, int], ast.Expr] = field(default_factory=dict)
    given: Names = field(default_factory=Names)
    tables: list[ast.Table] = field(default_factory=list)
    labels: dict[int, str] = field(default_factory=dict)
    one_by_one: bool = False
    bodies: dict[int, Callable[[], Sequence[ast.Element]]] = field(default_factory=dict)

    def symbol(self, index: int) -> list[ast.Element]:
        """The symbol where it is placed freely: with its own scope, if it needs one."""
        size = None if index in self.sizing else self.sized.get(index)
        own: list[ast.Element] = [] if size is None else [call("size", *size)]
        return [*own, *self.drawn(index)]

    def drawn(self, index: int) -> Sequence[ast.Element]:
        """What draws a symbol: its name, or its body where it is told nowhere else."""
        body = self.bodies.get(index)
        return (ast.Module(self.names[index]),) if body is None else body()

    def fitted(self, terminal: int) -> str:
        """The label of a terminal that is stretched to a scope."""
        if terminal not in self.labels:
            self.labels[terminal] = self.given.give(f"{self.names[terminal]}Fitted")
        return self.labels[terminal]

    def count(self, key: tuple[int, int, int], count: int) -> ast.Expr:
        """How many, as a number or an attribute."""
        return self.counts.get(key, ast.Number(float(count)))


def item_elements(wording: Wording, rule: int, number: int, item: Item) -> list[ast.Element]:
    """The elements that draw an item of a rule."""
    match item:
        case Place():
            return _place(wording, item, wording.scheme.symbols[rule].size)
        case Array():
            return [_array(wording, item, (rule, number))]
        case Ring():
            return [_ring(wording, item, (rule, number))]
        case Split():
            return [_split(wording, item, (rule, number))]
        case Octant():
            return [_octant(wording, item)]
        case _:
            assert_never(item)


# ------------------------------------------------------------------------- copies


def copies_of(wording: Wording, item: Item) -> Copies | None:
    """What an item places as it is, wherever it likes; None for all else."""
    if not isinstance(item, Place) or item.stretch is not None or item.anchors:
        return None
    found = spots(item.frames, wording.precision, float(wording.reach[item.symbol]))
    inner = tuple(wording.symbol(item.symbol))
    return Copies(wording.names[item.symbol], inner, tuple(found))


def _place(wording: Wording, place: Place, scope: Floats) -> list[ast.Element]:
    found = spots(place.frames, wording.precision, float(wording.reach[place.symbol]))
    for axis in place.anchors:
        found = [
            _from_end(wording, spot, axis, float(scope[axis] - position))
            for spot, position in zip(found, place.frames.position[:, axis], strict=True)
        ]
    if place.stretch is not None:
        sizes = _sizes(wording, place.stretch, place.margins)
        return [
            placed(spot, _stretched(wording, place.symbol, size))
            for spot, size in zip(found, sizes, strict=True)
        ]
    inner = wording.symbol(place.symbol)
    if wording.one_by_one or place.anchors:
        return [placed(spot, inner) for spot in found]
    elements, tables = cheapest(found, inner, wording.names[place.symbol], wording.given)
    wording.tables += tables
    return elements


def _from_end(wording: Wording, spot: Spot, axis: int, distance: float) -> Spot:
    """The spot with its place along an axis counted from the end of the scope."""
    place = list(spot.place)
    place[axis] = plus(ast.Name(EXTENTS[axis]), wording.precision.number(-distance))
    return spot.at((place[0], place[1], place[2]))


def _sizes(wording: Wording, stretch: Floats, margins: Floats | None) -> list[Vector]:
    """Sizes as numbers, or as what is less than the scope."""
    if margins is None:
        return [wording.precision.vector(size) for size in stretch]
    return [_size(wording, size, margin) for size, margin in zip(stretch, margins, strict=True)]


def _size(wording: Wording, size: Floats, margin: Floats) -> Vector:
    x, y, z = (
        plus(ast.Name(extent), wording.precision.number(-float(less))) if np.isfinite(less) else own
        for extent, less, own in zip(EXTENTS, margin, wording.precision.vector(size), strict=True)
    )
    return (x, y, z)


def _stretched(wording: Wording, symbol: int, size: Vector) -> list[ast.Element]:
    """A symbol in a scope of a size: a terminal is stretched to it, under a label of its own."""
    name = wording.names[symbol]
    if not isinstance(wording.scheme.symbols[symbol], Terminal):
        return [call("size", *size), ast.Module(name)]
    return [call("size", *size), call("insert", ast.Name(name)), ast.Module(wording.fitted(symbol))]


# --------------------------------------------------------------------- rows and grids


def _array(wording: Wording, array: Array, key: tuple[int, int]) -> ast.Element:
    spot = spots(array.first, wording.precision, float(wording.reach[array.symbol]))[0]
    if array.holes and len(array.directions) > 1:
        return _holed(wording, array, spot)
    place, loops = spot.place, []
    for axis, direction in enumerate(array.directions):
        variable = INDICES[axis]
        count = wording.count((*key, axis), direction.count)
        if direction.steps:
            rows = _offsets(wording, direction.steps, array.symbol)
            along: ast.Expr = ast.Name(f"{variable}.at")
            loops.append(ast.Repeat(ast.Rows(variable, rows), ()))
        else:
            along = ast.Name(variable)
            loops.append(ast.Repeat(ast.Count(variable, count), ()))
        if direction.angle:
            place = _circling(wording, array.first.position[0], direction, along)
        else:
            place = added(place, _moved(wording, direction.step, along, direction.count))
    element: ast.Element = placed(spot.at(place), wording.symbol(array.symbol))
    holes = tuple(ast.Number(float(hole[0])) for hole in sorted(array.holes))
    for loop in reversed(loops):
        element = ast.Repeat(loop.head, (element,), holes)
    return element


def _moved(wording: Wording, step: Floats, along: ast.Expr, count: int) -> Vector:
    """`step * along` in each axis."""
    share = 1.0 / max(1, count - 1)
    x, y, z = (times(each, along) for each in wording.precision.vector(step, share))
    return (x, y, z)


def _circling(wording: Wording, first: Floats, direction: Direction, along: ast.Expr) -> Vector:
    """`center + radius * cos(angle * along)` in one axis, `sin` in another."""
    axis = int(np.argmax(np.abs(direction.axis)))
    radius = float(np.linalg.norm(direction.step))
    u, v = (k for k in range(3) if k != axis)
    turned = float(np.degrees(np.arctan2(direction.step[v], direction.step[u])))
    room = wording.precision.degrees(radius)
    turned = 0.0 if abs(turned) <= room else shortest(turned, room)
    step = direction.angle * float(direction.axis[axis]) * (-1.0 if axis == 1 else 1.0)
    angle = plus(times(ast.Number(step), along), ast.Number(turned))
    arm = wording.precision.number(radius)
    place = list(wording.precision.vector(first - direction.step))
    for k, name in ((u, "cos"), (v, "sin")):
        place[k] = plus(place[k], times(arm, ast.Call(name, (ast.Argument(angle),))))
    return (place[0], place[1], place[2])


def _offsets(wording: Wording, steps: Sequence[float], symbol: int) -> str:
    """The table of how far each member of an uneven row is along it."""
    along = np.concatenate([[0.0], np.cumsum(steps)])
    rows = tuple((wording.precision.number(float(each)),) for each in along)
    name = wording.given.give(f"{wording.names[symbol]}_steps".lower())
    wording.tables.append(ast.Table(name, columns=("at",), rows=rows))
    return name


def _holed(wording: Wording, array: Array, spot: Spot) -> ast.Element:
    """A grid with holes, counted through: `repeat(i < 4 * 6) except (3) { … mod(i, 6) … }`."""
    counts = [direction.count for direction in array.directions]
    place, passed = spot.place, 1
    for direction, count in zip(reversed(array.directions), reversed(counts), strict=True):
        digit = _digit(passed, count, passed * count == math.prod(counts))
        if direction.steps:
            return bracket(_listed(wording, array))
        place = added(place, _moved(wording, direction.step, digit, count))
        passed *= count
    holes = sorted(int(np.ravel_multi_index(hole, counts)) for hole in array.holes)
    total = ast.Number(float(counts[0]))
    limit: ast.Expr = total
    for count in counts[1:]:
        limit = ast.Binary("*", limit, ast.Number(float(count)))
    inner = placed(spot.at(place), wording.symbol(array.symbol))
    return ast.Repeat(
        ast.Count("i", limit), (inner,), tuple(ast.Number(float(hole)) for hole in holes)
    )


def _listed(wording: Wording, array: Array) -> list[ast.Element]:
    """An uneven grid with holes, place by place."""
    from ipmlang.inverse.split.expansion import placements

    symbol, frames = placements(array)[0]
    return _place(wording, Place(symbol, frames), np.zeros(3))


def _digit(passed: int, count: int, last: bool) -> ast.Expr:
    """The digit of i whose unit is `passed`, below `count`."""
    whole: ast.Expr = ast.Name("i")
    if passed > 1:
        share = ast.Binary("/", whole, ast.Number(float(passed)))
        whole = ast.Call("floor", (ast.Argument(share),))
    if last:
        return whole
    return ast.Call("mod", (ast.Argument(whole), ast.Argument(ast.Number(float(count)))))


# ------------------------------------------------------------------------------ rings


def _ring(wording: Wording, ring: Ring, key: tuple[int, int]) -> ast.Element:
    """`[translate(center) rotate(to the axis) repeat(i < n) { [rotate(0, 0, a * i) first] }]`."""
    if not ring.angle:
        return _swelling(wording, ring, key)
    to_axis, first = axis_frame(ring), first_around(ring)
    reach = float(wording.reach[ring.symbol])
    around = reach + float(np.linalg.norm(first.position))
    outer = spots(to_axis, wording.precision, around * max(1.0, ring.growth**ring.count))[0]
    inner = spots(first, wording.precision, reach)[0]
    turning = _turning(wording, ring, key, around)
    body = bracket([*turning, *_at_radius(inner), *wording.symbol(ring.symbol)])
    holes = tuple(ast.Number(float(hole)) for hole in sorted(ring.holes))
    count = wording.count((*key, 0), ring.count)
    loop = ast.Repeat(ast.Count("i", count), (body,), holes)
    return loop if outer.plain and all_nothing(outer.place) else placed(outer, [loop])


def _swelling(wording: Wording, ring: Ring, key: tuple[int, int]) -> ast.Element:
    """`repeat(i < n) { [translate(x, y, z + d * i) *(s * pow(g, i)) first] }`."""
    index, first = ast.Name("i"), first_around(ring)
    size = float(first.scale[0])
    first = replace(first, position=first.position / size, scale=np.ones(1))
    reach = float(wording.reach[ring.symbol]) + float(np.linalg.norm(first.position))
    place = added(
        wording.precision.vector(ring.center),
        _moved(wording, ring.rise * ring.axis, index, ring.count),
    )
    grown = Spot(place, scale=_factor(wording, ring, size, reach))
    inner = spots(first, wording.precision, reach)[0]
    body = bracket([*steps_to(grown), *steps_to(inner), *wording.symbol(ring.symbol)])
    holes = tuple(ast.Number(float(hole)) for hole in sorted(ring.holes))
    count = wording.count((*key, 0), ring.count)
    return ast.Repeat(ast.Count("i", count), (body,), holes)


def _factor(wording: Wording, ring: Ring, size: float, reach: float) -> ast.Expr:
    """`0.5 * pow(0.9, i)` or `0.5 + 0.05 * i`: how large each member is."""
    index, error = ast.Name("i"), wording.precision.ratio(reach)
    first = ast.Number(shortest(size, error))
    largest = max(1.0, size) * max(1, ring.count - 1)
    if ring.gain:
        return plus(first, times(ast.Number(shortest(size * ring.gain, error / largest)), index))
    ratio = ast.Number(shortest(ring.growth, error / (largest * max(1.0, ring.growth**ring.count))))
    return times(first, ast.Call("pow", (ast.Argument(ratio), ast.Argument(index))))


def _at_radius(spot: Spot) -> list[ast.Element]:
    return steps_to(spot)


def _turning(
    wording: Wording, ring: Ring, key: tuple[int, int], around: float
) -> list[ast.Element]:
    """What each member of a ring does before it is placed: turn, rise and grow."""
    index = ast.Name("i")
    share = 1.0 / max(1, ring.count - 1)
    angle = shortest(ring.angle, wording.precision.degrees(around) * share)
    steps: list[ast.Element] = []
    rise = wording.precision.number(ring.rise, share)
    if not is_nothing(rise):
        steps.append(call("translate", NOTHING, NOTHING, times(rise, index)))
    named = wording.counts.get((*key, 0))
    if named is not None and not ring.rise and abs(abs(ring.angle) * ring.count - 360) <= 1e-6:
        full = ast.Number(math.copysign(360.0, ring.angle))
        turn: ast.Expr = ast.Binary("*", ast.Binary("/", full, named), index)
    else:
        turn = times(ast.Number(angle), index)
    steps.append(call("rotate", NOTHING, NOTHING, turn))
    if ring.growth != 1:
        growth = ast.Number(shortest(ring.growth, wording.precision.ratio(around) * share))
        steps.append(call("*", ast.Call("pow", (ast.Argument(growth), ast.Argument(index)))))
    return steps


# ----------------------------------------------------------------- splits and octants


def _split(wording: Wording, split: Split, key: tuple[int, int]) -> ast.Element:
    """`split x { 1: Wall | { ~2: Bay }* | 1: Wall }`."""
    parts: list[ast.SplitPart | ast.SplitGroup] = []
    for cell in split.cells:
        length = wording.precision.number(cell.length)
        size = ast.Size("floating" if cell.elastic else "absolute", length)
        nothing = (ast.Module("nil"),)
        inside = nothing if cell.symbol is None else tuple(wording.drawn(cell.symbol))
        part = ast.SplitPart(size, inside)
        parts.append(ast.SplitGroup((part,), "*") if cell.count > 1 else part)
    return ast.Split("xyz"[split.axis], tuple(parts))


def _octant(wording: Wording, octant: Octant) -> ast.Element:
    """`[octant(x, y, z, q) subdivide(nx, ny, nz) translate(…) Symbol]`."""
    body: list[ast.Element] = [
        call("octant", *wording.precision.vector(cut.point), ast.Number(float(cut.octant)))
        for cut in octant.cuts
    ]
    if max(octant.counts) > 1:
        body.append(call("subdivide", *(ast.Number(float(count)) for count in octant.counts)))
    inner = spots(octant.inner, wording.precision, float(wording.reach[octant.symbol]))[0]
    return bracket([*body, *steps_to(inner), *wording.symbol(octant.symbol)])
