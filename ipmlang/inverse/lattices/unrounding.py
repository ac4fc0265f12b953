"""The numbers of a lattice before a program rounded its points: plain ones, of which every point
rounds to what stands in the file.

Takes a formula about right, and the rounded points of its members; gives the points as the formula
has them once its numbers are as short as the rounded points allow, and the shape of a member as the
mean of all. Nothing here finds lattices.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import log10

import numpy as np

from ipmlang.inverse.lattices.formula import Formula, frames_at
from ipmlang.inverse.least_largest import least_largest
from ipmlang.inverse.lsystem.curves import Booleans
from ipmlang.inverse.lsystem.frames import (
    Complexes,
    Floats,
    apply,
    frames,
    identity,
    mirrored,
    unit,
)
from ipmlang.inverse.lsystem.symbols import Integers
from ipmlang.inverse.lsystem.symmetry import Symmetry, dihedral

PASSES = 4  # of Gauss and Newton
PLACES = 10  # decimals that are tried are fewer
# Of the last decimal: what rounding moves a coordinate by at most, and less where ties round in
# another way.
ROOMS = (0.50001, 0.4999, 0.49)
HOPEFUL = 1.4  # times the room: by which least squares may be off where a better fit may not be,
AT_FIRST = 2.0  # and before any number is told
SURE = 1e-5  # of a slope: what is left of it where other numbers say the same
EDGES = (1e-3, 1e-5, 1e-8)  # of the last decimal: how far off a tie points are moved
SNAP = 15.0  # degrees: axes are thought to be multiples of it
STRAYS = 0.2  # of the members may be moved
STEP = 1e-6  # of a number, for its derivative

Slot = tuple[str, int]


@dataclass(slots=True)
class Work:
    """How many fits by least squares and by linear programs are left for one drawing."""

    fits: int = 600
    programs: int = 60


@dataclass(frozen=True, slots=True, eq=False)
class Rounded:
    """Members of a lattice as they were written. formula: about right; node: (n,); seen: (n, q)
    points x + iy of each member in one order, multiples of `grain` (units), y up; symmetry: of a
    member, about right; flip: y down is flip - y; work: what may still be done for the drawing.
    """

    formula: Formula
    node: Integers
    seen: Complexes
    grain: float
    symmetry: Symmetry
    flip: float
    work: Work

    @property
    def decimals(self) -> int:
        """Of the file's numbers."""
        return round(-log10(self.grain))

    def rounded(self, points: Complexes) -> Booleans:
        """Whether points, as `seen`, round to what was seen, on a page whose y points down."""
        here, there = (
            np.round(np.stack([each.real, self.flip - each.imag]), self.decimals)
            for each in (points, self.seen)
        )
        return np.asarray((here == there).all(axis=0))


@dataclass(frozen=True, slots=True, eq=False)
class Before:
    """Members before they were rounded. points: (n, q), as `Rounded.seen`; shape: (q,) the points
    of each about its own origin; shift: (n,) by how little a member is to be moved to round to what
    was seen, where the middle between two decimals was rounded otherwise; kept: (n,) whether that
    makes all its points right.
    """

    points: Complexes
    shape: Complexes
    shift: Complexes
    kept: Booleans


@dataclass(frozen=True, slots=True, eq=False)
class _Told:
    """Numbers that say where points are: `values` (s,) of the slots, which are those of the formula
    and the local points of a member.
    """

    given: Rounded
    slots: tuple[Slot, ...]
    values: Floats

    def points(self, values: Floats) -> Complexes:
        """(f, n, q) points for numbers (f, s)."""
        formulas = [self.formula(row) for row in values]
        placed = frames_at(formulas, self.given.node)
        local = _local(self.slots, values, self.given.seen.shape[1])
        there = mirrored(local[:, None, :], placed.handedness[:, :, None])
        return np.asarray(placed.position[:, :, None] + placed.factor[:, :, None] * there)

    def formula(self, values: Floats) -> Formula:
        """The formula with these numbers (s,)."""
        made, told = self.given.formula, values.tolist()

        def filled(name: str, given: Floats) -> Floats:
            array = given.copy()
            for (own, place), value in zip(self.slots, told, strict=True):
                if own == name:
                    array.flat[place] = value
            return array

        lead = filled("lead", np.array([*made.lead.x, *made.lead.y, *made.lead.angle]))
        at = np.array([complex(lead[0], lead[1])])
        return replace(
            made,
            lead=frames(at, float(lead[2]), 1.0, made.lead.handedness),
            moves=None if made.moves is None else filled("moves", made.moves),
            polar=None if made.polar is None else filled("polar", made.polar),
            turn=filled("turn", made.turn),
            growth=filled("growth", made.growth),
        )


def before_rounding(given: Rounded, known: Sequence[Complexes] = ()) -> Before | None:
    """The points before they were rounded, None where no numbers of the formula round to nearly all
    of them; known: shapes (q,) of members that are tried first.
    """
    told = _started(given)
    found = next(_of_shapes(told, known), None)
    if found is not None:
        return found
    wanted = _independent(told)
    fitted = _fitted(_plain(told, ~wanted), wanted, ROOMS[0] * given.grain, AT_FIRST)
    own = None if fitted is None else _shortest(fitted, wanted)
    if own is not None and _is_plain(own.shape, given.grain):
        return own
    return next(_of_shapes(told, _symmetric(told)), own)


def _is_plain(shape: Complexes, grain: float) -> bool:
    """Whether points have no more decimals than the file."""
    numbers = np.concatenate([shape.real, shape.imag]) / grain
    return bool(np.abs(numbers - np.round(numbers)).max() <= SURE)


def _of_shapes(told: _Told, shapes: Iterable[Complexes]) -> Iterator[Before]:
    """The points where members have one of some shapes."""
    made = (_of_shape(told, shape) for shape in shapes)
    return (each for each in made if each is not None)


def _of_shape(told: _Told, shape: Complexes) -> Before | None:
    """The points where members look like others before them."""
    own = _local(told.slots, told.values[None], len(shape))[0]
    if len(own) == 1:
        return None
    nearest = np.argmin(np.abs(own[:, None] - shape), axis=1)
    if len(np.unique(nearest)) < len(own) or len(own) != len(shape):
        return None
    numbers = np.stack([shape[nearest].real, shape[nearest].imag], axis=1).ravel()
    wanted = np.array([name != "local" for name, _ in told.slots])
    alike = replace(told, values=np.concatenate([told.values[wanted], numbers]))
    fitted = _fitted(alike, wanted, ROOMS[0] * told.given.grain, AT_FIRST)
    return None if fitted is None else _shortest(fitted, wanted)


def _symmetric(told: _Told) -> Iterator[Complexes]:
    """The shape of a member as the mean of all its images, larger or smaller by little so that its
    extent is plain.
    """
    symmetry, grain = told.given.symmetry, told.given.grain
    own = _local(told.slots, told.values[None], told.given.seen.shape[1])[0]
    if len(own) == 1 or (symmetry.order == 1 and symmetry.axis is None):
        return
    axis = symmetry.axis
    if axis is not None:
        plain = SNAP * round(axis / SNAP)
        if np.deg2rad(abs(plain - axis)) * np.abs(own).max() <= 2 * grain:
            own, axis = own * unit(np.array(plain - axis)), plain
    images = apply(dihedral(symmetry.order, axis).stabiliser[:, None], own)
    nearest = np.argmin(np.abs(images[:, None, :] - own[:, None]), axis=2)
    if (np.sort(nearest, axis=1) != np.arange(len(own))).any():
        return
    mean = np.take_along_axis(images, nearest, axis=1).mean(axis=0)
    size, decimals = float(np.abs(mean).max()), told.given.decimals
    for places in range(max(decimals - 1, 0), decimals + 3):
        yield mean * (round(size, places) / size)


def _shortest(fitted: _Told, wanted: Booleans) -> Before | None:
    """With numbers as short as there are; less room is left for rounding where ties do not come out
    as they did. If they never do, a few members are moved.
    """
    best: _Told | None = None
    for room in ROOMS:
        ways = [
            _shortened(fitted, order, room * fitted.given.grain)
            for order in _orders(fitted, wanted)
        ]
        short = sorted((each for each in ways if each is not None), key=_digits)
        for each in short:
            points = _placed(each)
            if points is not None:
                return _before(each, points)
        if not short:
            break
        best = best or short[0]
    return None if best is None else _nearly(best)


def _before(told: _Told, points: Complexes) -> Before:
    count, size = points.shape
    shape = _local(told.slots, told.values[None], size)[0]
    return Before(points, shape, np.zeros(count, np.complex128), np.ones(count, np.bool_))


def _orders(told: _Told, wanted: Booleans) -> Iterator[list[Integers]]:
    """In which order numbers are told: what all points hang on first, or where the lattice stands;
    the shape of a member at last, all of it at once.
    """
    names = np.array([name for name, _ in told.slots])
    shape, place = (np.flatnonzero(wanted & (names == name)) for name in ("local", "lead"))
    steps = np.flatnonzero(wanted & (names != "local") & (names != "lead"))
    last = [shape] if len(shape) else []
    for first, second in ((place[::-1], steps), (steps, place)):
        yield [*np.split(np.concatenate([first, second]), len(first) + len(second)), *last]


def _digits(told: _Told) -> int:
    """How many digits the numbers of the formula have."""
    numbers = [
        value for (name, _), value in zip(told.slots, told.values, strict=True) if name != "local"
    ]
    return sum(len(f"{abs(value):.9f}".strip("0").replace(".", "")) for value in numbers)


def _started(given: Rounded) -> _Told:
    """The numbers that are looked for, in the order in which they are told: what all points hang on
    first. What a member looks like begins as the mean of all.
    """
    made = given.formula
    formula = replace(made, inside=identity(1))
    back = frames_at([formula], given.node)
    off = given.seen - back.position.T
    local = off / back.factor.T
    local = mirrored(local, back.handedness.T).mean(axis=0)
    given = replace(given, formula=formula)
    slots = tuple(_slots(given))
    values = [_value(formula, slot, local) for slot in slots]
    return _Told(given, slots, np.array(values))


def _slots(given: Rounded) -> Iterator[Slot]:
    formula, several = given.formula, given.seen.shape[1] > 1
    if formula.polar is not None:
        whole = abs(abs(formula.turned_by) * formula.length - 360) <= 1e-9
        if not whole:
            yield "polar", 0
        yield from (("polar", place) for place in (1, 3, 2) if formula.polar[place])
    if formula.moves is not None:
        yield from (("moves", int(place)) for place in np.flatnonzero(formula.moves.ravel()))
    if several:
        yield from (("turn", int(place)) for place in np.flatnonzero(formula.turn))
        yield from (("growth", int(place)) for place in np.flatnonzero(formula.growth))
    if formula.polar is not None:
        yield "lead", 2
    yield from (("lead", 0), ("lead", 1))
    if several:
        yield from (("local", place) for place in range(2 * given.seen.shape[1]))


def _value(formula: Formula, slot: Slot, local: Complexes) -> float:
    name, place = slot
    if name == "lead":
        lead = formula.lead
        return float((lead.x, lead.y, lead.angle)[place][0])
    if name == "local":
        point = local[place // 2]
        return float(point.imag if place % 2 else point.real)
    return float(np.ravel(getattr(formula, name))[place])


def _local(slots: tuple[Slot, ...], values: Floats, count: int) -> Complexes:
    """(f, q) the points of a member, its only one at its origin."""
    first = next((k for k, (name, _) in enumerate(slots) if name == "local"), None)
    if first is None:
        return np.zeros((len(values), count), np.complex128)
    numbers = values[:, first:]
    return np.asarray(numbers[:, 0::2] + 1j * numbers[:, 1::2])


# ------------------------------------------------------------------------- fitting


def _independent(told: _Told) -> Booleans:
    """(s,) the numbers without those of a shape that say what others do: of one that is turned
    about a centre, how far it is from there.
    """
    slopes, _ = _linear(told, np.ones(len(told.slots), np.bool_))
    gram = slopes.T @ slopes
    size = np.sqrt(np.diagonal(gram))
    size[size == 0] = 1.0
    left = gram / size[:, None] / size
    kept = np.zeros(len(gram), np.bool_)
    for slot in range(len(gram)):
        kept[slot] = left[slot, slot] > SURE**2
        if kept[slot]:  # what it says is taken from all others
            left = left - np.outer(left[:, slot], left[slot]) / left[slot, slot]
    return kept


def _plain(told: _Told, rows: Booleans) -> _Told:
    """With some numbers of as many decimals as the file has."""
    short = np.round(told.values, told.given.decimals)
    return replace(told, values=np.where(rows, short, told.values))


def _fitted(told: _Told, free: Booleans, room: float, hopeful: float = HOPEFUL) -> _Told | None:
    """With the free numbers such that no coordinate is off by more than so many units, None where
    there are none such.
    """
    if not free.any():
        return told if _off(told) <= room else None
    made, work = told, told.given.work
    if not work.fits:
        return None
    work.fits -= 1
    for _ in range(PASSES):
        slopes, rest = _linear(made, free)
        if np.abs(rest).max() <= room and made is not told:
            return made
        made = _changed(made, free, _least_squares(slopes, rest))
    off = _off(made)
    if off <= room:
        return made
    if off > hopeful * room or not work.programs:
        return None
    work.programs -= 1
    slopes, rest = _linear(made, free)
    grain = told.given.grain  # in units of which a linear program is exact enough
    found = least_largest(slopes / grain, rest / grain)
    if found is None:
        return None
    made = _changed(made, free, found)
    return made if _off(made) <= room else None


def _least_squares(slopes: Floats, rest: Floats) -> Floats:
    """(s,) the change that fits best, by the normal equations of independent numbers."""
    size = np.sqrt((slopes**2).sum(axis=0))
    size[size == 0] = 1.0
    scaled = slopes / size
    return np.asarray(np.linalg.lstsq(scaled.T @ scaled, scaled.T @ rest, rcond=None)[0] / size)


def _changed(told: _Told, free: Booleans, change: Floats) -> _Told:
    values = told.values.copy()
    values[free] += change
    return replace(told, values=values)


def _linear(told: _Told, free: Booleans) -> tuple[Floats, Floats]:
    """(2nq, s) how coordinates change with each free number, and (2nq,) how far they are off."""
    rows = np.flatnonzero(free)
    steps = STEP * np.maximum(1.0, np.abs(told.values[rows]))
    tried = np.repeat(told.values[None], len(rows) + 1, axis=0)
    tried[np.arange(1, len(rows) + 1), rows] += steps
    points = told.points(tried)
    base = points[0].ravel()
    slopes = (points[1:].reshape(len(rows), -1) - base) / steps[:, None]
    rest = told.given.seen.ravel() - base
    return (
        np.concatenate([slopes.real, slopes.imag], axis=1).T,
        np.concatenate([rest.real, rest.imag]),
    )


def _off(told: _Told) -> float:
    """How far off the worst coordinate is."""
    apart = told.points(told.values[None])[0] - told.given.seen
    return float(max(np.abs(apart.real).max(), np.abs(apart.imag).max()))


def _shortened(told: _Told, order: list[Integers], room: float) -> _Told | None:
    """With numbers as short as coordinates that are off by so many units allow, in some order while
    those not told yet are fitted to them.
    """
    made, free = told, np.zeros(len(told.slots), np.bool_)
    free[np.concatenate(order)] = True
    for slots in order:
        free[slots] = False
        shorter = (
            each if _off(each) <= room else _fitted(each, free, room)
            for each in _shorter(made, slots)
        )
        made = next((each for each in shorter if each is not None), made)
    return made if _off(made) <= room else None


def _shorter(told: _Told, slots: Integers) -> Iterator[_Told]:
    """With more and more decimals of some numbers."""
    for places in range(PLACES):
        values = told.values.copy()
        values[slots] = np.round(values[slots], places) + 0.0
        yield replace(told, values=values)


def _placed(told: _Told) -> Complexes | None:
    """The points, moved as a whole so that ties round as they did."""
    points: Complexes = told.points(told.values[None])[0]
    seen, grain = told.given.seen, told.given.grain
    if told.given.rounded(points).all():
        return points
    x = _shift(points.real, seen.real, grain)
    y = _shift(points.imag, seen.imag, grain)
    return None if x is None or y is None else np.asarray(points + complex(x, y))


def _nearly(told: _Told) -> Before | None:
    """The points, a few members moved by little, None where too many are to be."""
    points, seen, grain = told.points(told.values[None])[0], told.given.seen, told.given.grain
    made = _before(told, points)
    shift, kept = made.shift, made.kept
    for row in np.flatnonzero(~told.given.rounded(points).all(axis=1)).tolist():
        x = _shift(points[row].real, seen[row].real, grain)
        y = _shift(points[row].imag, seen[row].imag, grain)
        kept[row] = x is not None and y is not None
        shift[row] = complex(x or 0.0, y or 0.0)
    few = (~kept | (shift != 0)).sum() <= STRAYS * len(points)
    return replace(made, shift=shift, kept=kept) if few else None


def _shift(value: Floats, seen: Floats, grain: float) -> float | None:
    """The shortest number by which values are moved so that they round to those seen, none of them
    near the middle of two decimals where that can be.
    """
    low = float((seen - 0.5 * grain - value).max())
    high = float((seen + 0.5 * grain - value).min())
    if low < -EDGES[-1] * grain and high > EDGES[-1] * grain:
        return 0.0
    for edge in EDGES:
        least, most = low + edge * grain, high - edge * grain
        for places in range(PLACES):
            unit = grain * 10.0**-places
            moved = np.floor(most / unit) * unit if most < 0 else np.ceil(least / unit) * unit
            if least <= moved <= most:
                return float(moved)
    return None
