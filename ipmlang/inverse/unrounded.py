"""A drawing as it was before its program rounded it: rings, spirals and rows of points with few
decimals, moved back to where their rule has them.

Takes a drawing whose coordinates all have few decimals; gives the same with the points of every
lattice where plain numbers put them, so that they round to what stands in the file. What is on no
lattice stays. Nothing here writes a grammar.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from ipmlang.formats.drawing import ARC, CUBIC, LINE, QUADRATIC, Drawing, DrawnElement, Outline
from ipmlang.inverse.lattices.build import Lattice
from ipmlang.inverse.lattices.find import Memory, lattices_once
from ipmlang.inverse.lattices.formula import fitted_formula
from ipmlang.inverse.lattices.unrounding import Before, Rounded, Work, before_rounding
from ipmlang.inverse.lsystem.frames import Complexes, apply, compose, inverse
from ipmlang.inverse.lsystem.symbols import Integers
from ipmlang.inverse.lsystem.symmetry import Symmetry
from ipmlang.inverse.observation import Observation, ShapeClass, observe
from ipmlang.inverse.options import Options
from ipmlang.inverse.pages import Page
from ipmlang.inverse.tolerances import Tolerances, seen

# Of the last decimal: by which shapes that were one before rounding differ, and by which what maps
# a shape onto itself misses.
APART = (3.0, 8.0)
EXACT = 1.0  # the same, of the places of points,
TURNED = 2.0  # and of what lies at the edge of a shape by its angle and size
FINE = 1e-3  # of the usual tolerances: what is near the middle of two decimals must not be moved
PROOF = 0.25  # of the last decimal: what any point of the result may be off
LARGEST = 0.05  # radians, and share of its size, that a small shape is turned and grown by rounding
NOISE = 0.0  # of the step: rounding is no noise, and what is noisier has no plain numbers
LEAST = 6  # members of a lattice
MOST = 2000  # elements
PART = 0.1  # of the elements that must have been on lattices
DIGITS = 5  # of the ten that the last decimals of coordinates are, where these were rounded
MOST_POINTS = 24  # of a shape
SIZES = 9  # decimals of a size that tell circles apart
USED = {LINE: 2, QUADRATIC: 3, CUBIC: 4}  # points of a segment
Box: TypeAlias = tuple[float, float, float, float]
Moved: TypeAlias = tuple[Complexes, complex]  # points, y up, and `Unrounded.shift`


@dataclass(frozen=True, slots=True, eq=False)
class Unrounded:
    """The drawing before it was rounded to so many decimals; shift: by how much some elements, by
    row, are to be moved before that, x + iy, y up.
    """

    drawing: Drawing
    decimals: int
    shift: Mapping[int, complex]


def unrounded(drawing: Drawing) -> Unrounded | None:
    """The drawing before it was rounded; None where nothing says that it was."""
    if not LEAST <= len(drawing.elements) <= MOST:
        return None
    points = [_points(each) for each in drawing.elements]
    decimals = None if drawing.box is None else _decimals(drawing.box, points)
    if decimals is None:
        return None
    grain = 10.0**-decimals
    exact = observe(drawing)
    upward = [each.real + 1j * (exact.flip - each.imag) for each in points]
    moved, work = dict[int, Moved](), Work()
    searched: Memory = {}
    for apart in APART:
        loose = observe(drawing, apart * grain / exact.diagonal)
        for shape in loose.classes:
            _move(loose, shape, upward, grain, moved, work, searched)
    off = [np.abs(new - upward[row]).max() for row, (new, _) in moved.items()]
    far = sum(bool(each > exact.tolerance) for each in off)
    if far < max(LEAST, PART * len(points)):
        return None
    elements = list(drawing.elements)
    for row, (new, _) in moved.items():
        down = new.real + 1j * (exact.flip - new.imag)
        elements[row] = _moved(elements[row], points[row], down)
    shift = {row: by for row, (_, by) in moved.items() if by}
    if shift and any(each.style.effects for each in elements):
        return None
    return Unrounded(replace(drawing, elements=tuple(elements)), decimals, shift)


def seen_before(before: Unrounded, options: Options) -> tuple[Observation, Tolerances]:
    """What was seen before points were rounded, and tolerances that leave no point near enough to
    another one of so many decimals.
    """
    observed, given = seen(before.drawing, options)
    grain = 10.0**-before.decimals / observed.diagonal
    given = Tolerances(
        given.shapes, FINE * given.search, FINE * given.rounding, min(given.proof, PROOF * grain)
    )
    return replace(observed, decimals=before.decimals, shift=before.shift), given


def _decimals(box: Box, points: list[Complexes]) -> int | None:
    """Of all points, None where they have too many, or where their last digits are those of plain
    steps.
    """
    _, y, width, height = box
    page = Page(float(np.hypot(width, height)), 2 * y + height, True)
    every = np.concatenate([np.zeros(0, np.complex128), *points])
    decimals = page.decimals(every)
    if decimals is None:
        return None
    last = np.rint(np.concatenate([every.real, every.imag]) * 10**decimals) % 10
    return decimals if len(np.unique(last)) >= DIGITS else None


def _points(element: DrawnElement) -> Complexes:
    """(q,) different points of an element, y down: ends and controls, of whole circles the middle,
    nothing of what is not rounded.
    """
    outline = element.outline
    if outline is None or not len(outline.kind):
        return np.zeros(0, np.complex128)
    places = _places(outline)
    found = outline.coords[places]
    every: Complexes = found[:, 0] + 1j * found[:, 1]
    _, first = np.unique(every, return_index=True)
    return every[np.sort(first)]


def _places(outline: Outline) -> tuple[Integers, Integers]:
    """Which rows of which segments are points of the page."""
    kind = outline.kind
    if (kind == ARC).any():
        whole = (kind == ARC).all()
        rows = np.arange(len(kind)) if whole else np.zeros(0, np.int64)
        return rows, np.zeros(len(rows), np.int64)
    used = np.zeros((len(kind), 4), np.bool_)
    for code, count in USED.items():
        used[kind == code, :count] = True
    segment, point = np.nonzero(used)
    return segment, point


def _moved(element: DrawnElement, old: Complexes, new: Complexes) -> DrawnElement:
    """The element with its points (q,) elsewhere, y down."""
    outline = element.outline
    assert outline is not None
    places = _places(outline)
    found = outline.coords[places]
    number = np.argmax((found[:, 0] + 1j * found[:, 1])[:, None] == old, axis=1)
    coords = outline.coords.copy()
    coords[places] = np.stack([new.real, new.imag], axis=1)[number]
    return replace(element, outline=replace(outline, coords=coords))


# ------------------------------------------------------------------------ lattices


def _move(
    seen: Observation,
    shape: ShapeClass,
    points: list[Complexes],
    grain: float,
    moved: dict[int, Moved],
    work: Work,
    searched: Memory,
) -> None:
    """Add to `moved` the points, by row, of members of lattices of one shape, before rounding;
    searched: what was found among the same frames, which is added to.
    """
    if shape.fragment is not None or shape.kind == "point":
        return
    around = shape.symmetry.order == 0
    near = (EXACT if around else TURNED) * grain
    keeps, known = shape.symmetry.stabiliser, list[Complexes]()
    for own in _alike(seen, shape, moved):
        placed = seen.frames[own]
        size = (placed, keeps, around, shape.radius)
        for lattice in lattices_once(searched, *size, near, NOISE, own, LARGEST):
            rows = own[lattice.rows].tolist()
            if any(row in moved for row in rows):
                continue
            there = [points[row] for row in rows]
            made = _before(lattice, shape.symmetry, seen.flip, there, grain, known, work)
            if made is not None:
                told = zip(made.points, made.shift.tolist(), strict=True)
                found = zip(rows, told, made.kept.tolist(), strict=True)
                moved.update({row: each for row, each, kept in found if kept})


def _alike(seen: Observation, shape: ShapeClass, moved: Container[int]) -> Iterator[Integers]:
    """Rows of one shape and style not moved yet; of one size, where rounding leaves sizes as they
    are.
    """
    members = shape.members[[row not in moved for row in shape.members.tolist()]]
    style, scale = seen.style[members], np.ones(len(members))
    if shape.symmetry.order == 0:
        scale = np.round(seen.frames.scale[members], SIZES)
    keys = np.stack([style, scale], axis=1)
    which = np.unique(keys, axis=0, return_inverse=True)[1].ravel()
    for number in range(int(which.max(initial=-1)) + 1):
        rows = members[which == number]
        if len(rows) >= LEAST:
            yield rows


def _before(
    lattice: Lattice,
    symmetry: Symmetry,
    flip: float,
    own: list[Complexes],
    grain: float,
    known: list[Complexes],
    work: Work,
) -> Before | None:
    """The members of a lattice, their points in the order of `own`, before they were rounded, None
    where no plain numbers say them; known: shapes of members, which are added to.
    """
    if len(lattice) < LEAST or lattice.handedness.kind != "regular":
        return None
    made, count = fitted_formula(lattice), len(own[0])
    if made is None or not 0 < count <= MOST_POINTS or any(len(each) != count for each in own):
        return None
    there = np.stack(own)
    order = _matched(lattice, there)
    if order is None:
        return None
    given = Rounded(*made, np.take_along_axis(there, order, axis=1), grain, symmetry, flip, work)
    found = before_rounding(given, known)
    if found is None:
        return None
    if not any(np.array_equal(found.shape, each) for each in known):
        known.append(found.shape)
    back = np.empty_like(found.points)
    np.put_along_axis(back, order, found.points, axis=1)
    return replace(found, points=back)


def _matched(lattice: Lattice, there: Complexes) -> Integers | None:
    """(n, q) which point of each member (n, q) is which of the first one's, None where that is not
    plain.
    """
    steps = compose(lattice.chosen, inverse(lattice.chosen[:1]))
    images = apply(steps[:, None], there[:1])
    nearest = np.argmin(np.abs(images[:, :, None] - there[:, None, :]), axis=2)
    once = (np.sort(nearest, axis=1) == np.arange(there.shape[1])).all()
    return nearest if once else None
