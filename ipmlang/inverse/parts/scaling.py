"""Which shapes are others made larger or smaller, so that one of them can stand for all.

Takes the classes of pieces; gives those that are scaled copies of another, with the map from its
coordinates to their own. Every map is proved, vertex by vertex, in units of the model. Whether it
pays to draw them as one is not known here: `as_one` does so for those it is told.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipmlang.inverse.frames import Floats, Integers, compose, from_matrices, join
from ipmlang.inverse.numbers import shortest
from ipmlang.inverse.parts.aligning import aligned
from ipmlang.inverse.parts.classes import Classes
from ipmlang.inverse.parts.copies import Model, stacked
from ipmlang.inverse.parts.describing import place_word, shape_word
from ipmlang.inverse.parts.invariants import alike, face_kinds
from ipmlang.inverse.parts.observation import Likeness, PartClass, Parts
from ipmlang.inverse.parts.pieces import Pieces, chosen, sums
from ipmlang.inverse.parts.plainest import snapped

LARGER = 0.01  # share by which a copy is larger or smaller at least: what is nearly equal is not
COARSE = 1e-3  # of a shape's size, that any two may be off before they are laid on each other
MOST_SAID = 16  # factors that are looked at to choose the shape that stands for others
PLAINER = 2  # digits a factor that make another shape the one that stands for all
ROUNDED = 0.1  # share of the tolerance that a factor may be rounded by


@dataclass(frozen=True, slots=True, eq=False)
class _Shapes:
    """The shapes of k classes about their centres, all made one unit large: number (k,) of each
    class; pieces; size (k,) what they were divided by; often (k,) how many members they have.
    """

    number: Integers
    pieces: Pieces
    size: Floats
    often: Integers


def likenesses(
    pieces: Pieces, found: Classes, levers: Floats, tolerance: float
) -> tuple[Likeness, ...]:
    """The classes that are scaled copies of others, by number. levers (c, 3): where each class's
    own coordinates begin, from its centre; tolerance: how far off copies may be, a length.
    """
    number = _numerous(pieces, found)
    if not len(number):
        return ()
    shapes = _shapes(pieces, found, number)
    lax = min(tolerance / float(shapes.size.min()), COARSE)
    every: list[_Copy] = []
    for group in alike(shapes.pieces, np.zeros((len(number), 3)), lax):
        left = group[np.lexsort((group, -shapes.size[group], -shapes.often[group]))]
        left = _plainest_first(shapes, left, tolerance)
        while len(left) > 1:
            own = list(_copies_of(shapes, int(left[0]), left[1:], tolerance))
            every += own
            left = left[1:][~np.isin(number[left[1:]], [each.shape for each in own])]
    made = [each.likeness(levers) for each in _agreed(every, tolerance)]
    return tuple(sorted(made, key=lambda each: each.shape))


def _plainest_first(shapes: _Shapes, rows: Integers, tolerance: float) -> Integers:
    """The rows, the smallest instead of the largest first where others are plainer multiples of it.
    Those with fewest members stay behind.
    """
    most = rows[shapes.often[rows] == shapes.often[rows[0]]]
    small, large = int(most[-1]), int(most[0])
    others = rows[:MOST_SAID]
    gain = _digits(shapes, large, others, tolerance) - _digits(shapes, small, others, tolerance)
    if gain < PLAINER * (len(others) - 1):
        return rows
    return np.concatenate([[small], rows[rows != small]])


def _digits(shapes: _Shapes, row: int, others: Integers, tolerance: float) -> int:
    """How many digits it takes to say others as multiples of one."""
    own = float(shapes.size[row])
    factors = (shapes.size[others] / own).tolist()
    return sum(len(repr(shortest(factor, tolerance / own))) for factor in factors)


def _numerous(pieces: Pieces, found: Classes) -> Integers:
    """The classes that others have as many vertices as, and the same kinds of faces."""
    model = np.array([each.model for each in found.classes], np.int64)
    starts = (pieces.face_start, pieces.corner_start, pieces.vertex_start)
    columns = [start[model + 1] - start[model] for start in starts]
    columns.append(sums(face_kinds(pieces), pieces.face_start).view(np.int64)[model])
    told = np.stack(columns, axis=1)
    _, kind, count = np.unique(told, axis=0, return_inverse=True, return_counts=True)
    return np.flatnonzero(count[kind.reshape(-1)] > 1)


def _shapes(pieces: Pieces, found: Classes, number: Integers) -> _Shapes:
    classes = [found.classes[each] for each in number.tolist()]
    model = np.array([each.model for each in classes], np.int64)
    own = chosen(pieces, model)
    counts = np.diff(own.vertex_start)
    points = own.vertices - np.repeat(found.center[model], counts, axis=0)
    for each, begin, end in zip(classes, own.vertex_start, own.vertex_start[1:], strict=False):
        if each.shape is not None:
            points[begin:end] = each.shape
    square = sums((points**2).sum(axis=1), own.vertex_start) / counts
    size = np.maximum(np.sqrt(square), 1e-300)
    unit = replace(own, vertices=points / np.repeat(size, counts)[:, None])
    return _Shapes(number, unit, size, np.array([len(each.rows) for each in classes]))


@dataclass(frozen=True, slots=True, eq=False)
class _Copy:
    """A class that is `factor` times another, of these numbers: turn (3, 3); whole, there (v, 3):
    the other's vertices and its own, each about its centre.
    """

    shape: int
    of: int
    factor: float
    turn: Floats
    whole: Floats
    there: Floats

    @property
    def reach(self) -> float:
        """How far the other gets from its centre."""
        return float(np.linalg.norm(self.whole, axis=1).max())

    def off(self, factor: float) -> float:
        """How far vertices are off at most where it is so many times as large."""
        away = self.there - factor * self.whole @ self.turn.T
        return float(np.linalg.norm(away, axis=1).max())

    def likeness(self, levers: Floats) -> Likeness:
        """The map between both classes' own coordinates."""
        grown = self.factor * self.turn
        moved = grown @ levers[self.of] - levers[self.shape]
        frame = from_matrices(np.append(grown, moved[:, None], axis=1)[None])
        return Likeness(self.shape, self.of, frame, self.off(self.factor))


def _copies_of(shapes: _Shapes, head: int, others: Integers, tolerance: float) -> Iterator[_Copy]:
    """Of the others those that are scaled copies of the head."""
    size = shapes.size[others]
    others = others[np.abs(np.log(size / shapes.size[head])) > LARGER]
    if not len(others):
        return
    center = np.zeros((len(shapes.size), 3))
    lax = min(2 * tolerance / float(shapes.size[np.append(others, head)].min()), COARSE)
    model = Model(stacked(shapes.pieces, center, np.array([head])), lax)
    copies = stacked(shapes.pieces, center, others)
    result = aligned(model, copies)
    whole = model.copies.points[0] * shapes.size[head]
    for row in np.flatnonzero(result.found).tolist():
        there = copies.points[row][result.places[row]] * shapes.size[others[row]]
        turn = snapped(result.linear[row : row + 1], lax)[0]
        factor = float((whole @ turn.T * there).sum() / (whole**2).sum())
        one, two = shapes.number[[others[row], head]].tolist()
        copy = _Copy(one, two, factor, turn, whole, there)
        if copy.off(factor) <= tolerance:
            yield copy


def _agreed(copies: Sequence[_Copy], tolerance: float) -> list[_Copy]:
    """With one factor for all that may have the same: what was scaled together is again."""
    agreed: list[_Copy] = []
    together: list[_Copy] = []
    for copy in sorted(copies, key=lambda each: (each.factor, each.shape)):
        if together and _common([*together, copy], tolerance) is None:
            agreed += _with_one(together, tolerance)
            together = []
        together.append(copy)
    return [*agreed, *_with_one(together, tolerance)]


def _common(copies: Sequence[_Copy], tolerance: float) -> float | None:
    """The factor that all copies may have, None if there is none."""
    weight = np.array([each.reach for each in copies]) ** 2
    factor = float(np.average([each.factor for each in copies], weights=weight))
    room = ROUNDED * tolerance / max(each.reach for each in copies)
    factor = shortest(factor, room)
    return factor if all(each.off(factor) <= tolerance for each in copies) else None


def _with_one(copies: Sequence[_Copy], tolerance: float) -> list[_Copy]:
    factor = _common(copies, tolerance) if copies else None
    return [each if factor is None else replace(each, factor=factor) for each in copies]


def as_one(parts: Parts, which: Sequence[Likeness]) -> Parts:
    """The parts with these classes drawn by those that they are scaled copies of; classes keep
    their numbers, and some have no members then.
    """
    if not which:
        return parts
    shape, misfit = parts.shape.copy(), parts.misfit.copy()
    rows = [np.flatnonzero(parts.shape == each.shape) for each in which]
    rest = np.setdiff1d(np.arange(len(shape)), np.concatenate(rows))
    frames = [parts.frames[rest]]
    for each, own in zip(which, rows, strict=True):
        shape[own] = each.of
        misfit[own] += each.misfit
        frames.append(compose(parts.frames[own], each.frame))
    order = np.argsort(np.concatenate([rest, *rows]))
    heads = {each.of for each in which}
    classes = tuple(
        replace(
            each,
            members=np.flatnonzero(shape == number),
            name=_name_for_all(parts, each) if number in heads else each.name,
        )
        for number, each in enumerate(parts.classes)
    )
    return replace(parts, shape=shape, frames=join(frames)[order], misfit=misfit, classes=classes)


def _name_for_all(parts: Parts, shape: PartClass) -> str:
    """A shape's name without the place where the one stood that has it."""
    form, row = shape_word(shape.mesh), int(shape.members[0])
    whole = np.stack([parts.low.min(axis=0), parts.high.max(axis=0)])
    by_place = place_word(parts.low[row], parts.high[row], whole, form)
    return form if shape.name.rstrip("0123456789") == by_place else shape.name
