"""Classes of one curve made one, however programs cut it into segments.

In come classes whose members have equal segments, out go fewer: where one class draws another's
curve within the tolerance, it stands for both. Integrals along the curves say which could be equal,
corners or samples about how they lie, and distances between the curves themselves prove it. Similar
curves that are not equal stay apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ipmlang.formats.drawing import LINE
from ipmlang.inverse.distance import Locus, Segments, derivative
from ipmlang.inverse.lsystem.alignment import Freedom, align
from ipmlang.inverse.lsystem.curvature import sample
from ipmlang.inverse.lsystem.curves import Curves, Integers, evaluate, stack
from ipmlang.inverse.lsystem.elements import Found
from ipmlang.inverse.lsystem.frames import (
    Complexes,
    Floats,
    Frames,
    apply,
    compose,
    frames,
    join,
    mirrored,
    unit,
)
from ipmlang.inverse.lsystem.merging import (
    NEAREST,
    Fits,
    deviation,
    matched,
    merged,
    symmetries,
)
from ipmlang.inverse.lsystem.segments import fewest_segments
from ipmlang.inverse.lsystem.shapes import lumps

RAGGED = 8.0  # the length of a curve of many corners moves so much faster than its points
SMALLEST = 25.0  # tolerances, the radius from which a shape is told by its integrals
QUADRATURE = 1e-6  # relative error of such integrals where a segment is curved
SAME = 0.85  # similarity below which two curves are not the same one
POLISHES = 6  # steps of Gauss and Newton
MOST = 60  # points of a curve by which a frame is polished
SNAP = 15.0  # degrees, as in `alignment`


def merge_rewritten(found: Sequence[Found], tolerance: float) -> list[Found]:
    """Classes of which one draws the other within the tolerance (units) made one."""
    return merged(found, lambda shapes: _Rewritten(shapes, tolerance))


class _Rewritten:
    """Shapes of which some may be one curve, cut otherwise into segments."""

    def __init__(self, shapes: list[Found], tolerance: float) -> None:
        self.shapes, self.tolerance = shapes, tolerance
        self.directed = shapes[0].directed
        self.part_of: dict[int, Integers] = {}
        curves = stack([each.outline for each in shapes])
        self.polygons = _polygons(curves, shapes, tolerance)
        self.writing = _writings(curves, self.polygons)
        self.order = sorted(range(len(shapes)), key=self._rank)
        if (self.writing < 0).all():
            return
        self.features, self.reach = _integrals(curves, tolerance)
        large = np.flatnonzero(self.reach < 1 / SMALLEST)
        parts = [large[part] for part in lumps(self.features[large], self.reach[large])]
        self.part_of = {row: part for part in _mixed(parts, self.writing) for row in part.tolist()}
        bent = [row for row in sorted(self.part_of) if self.polygons.counts[row] == 0]
        self.samples = sample([shapes[row].outline for row in bent])
        self.place = {row: place for place, row in enumerate(bent)}
        bounds = curves.offsets.tolist()
        spans = {row: slice(bounds[row], bounds[row + 1]) for row in self.part_of}
        self.curve = {row: (curves.kind[span], curves.points[span]) for row, span in spans.items()}

    def _rank(self, row: int) -> tuple[bool, int, int, int]:
        shape = self.shapes[row]
        return shape.kind != "ellipse", -symmetries(shape), -len(shape.members), row

    def near(self, lead: int) -> Integers:
        """Shapes with the same integrals that are written otherwise."""
        rows = self.part_of.get(lead)
        if rows is None:
            return np.zeros(0, np.int64)
        apart = np.abs(self.features[rows] - self.features[lead]).max(axis=1)
        good = (apart <= self.reach[rows] + self.reach[lead]) & (rows != lead)
        good &= self.writing[rows] != self.writing[lead]
        # Polygons stay polygons, and as many corners are left when those are dropped that hardly
        # show.
        good &= self.polygons.counts[rows] == self.polygons.counts[lead]
        order = np.argsort(apart[good], kind="stable")
        return np.asarray(rows[good][order][:NEAREST])

    def fit(self, lead: int, rows: Integers) -> Fits:
        """Those that the leading one draws within the tolerance."""
        placed, likely = self._placed(lead, rows)
        fits = [(row, *self._proven(lead, int(rows[row]), placed[row])) for row in likely.tolist()]
        fits = [fit for fit in fits if fit[2] <= self._room(int(rows[fit[0]]))]
        good = np.array([row for row, _, _ in fits], np.int64)
        error = np.array([error for _, _, error in fits])
        return Fits(rows[good], _rows([frame for _, frame, _ in fits]), error)

    def _placed(self, lead: int, rows: Integers) -> tuple[Frames, Integers]:
        """About where shapes lie, and which of them are worth a closer look."""
        if self.polygons.counts[lead]:
            model, *others = (self._corners(row) for row in (lead, *rows.tolist()))
            closed = bool(self.polygons.closed[lead])
            freedom = Freedom(int(closed and not self.directed), not self.directed)
            placed, error = align(model - model.mean(), np.stack(others), freedom, self.tolerance)
            moved = compose(placed, frames(np.array([-model.mean()])))
            near = [
                place
                for place, row in enumerate(rows.tolist())
                if error[place] <= 2 * self._room(row)
                and _corners_apart(moved[place], self.curve[lead], self.curve[row])
                <= 4 * self._room(row)
            ]
            return moved, np.array(near, np.int64)
        places = np.array([self.place[row] for row in rows.tolist()], np.int64)
        found, placed = matched(self.samples, self.place[lead], places, self.directed, SAME)
        return placed, np.flatnonzero(found >= SAME)

    def _corners(self, row: int) -> Complexes:
        span = slice(int(self.polygons.offsets[row]), int(self.polygons.offsets[row + 1]))
        points = self.polygons.points[span]
        return points[:, 0] if self.polygons.closed[row] else np.append(points[:, 0], points[-1, 1])

    def _room(self, row: int) -> float:
        shape = self.shapes[row]
        return float(((self.tolerance - shape.error) / shape.frames.scale).min())

    def _proven(self, lead: int, row: int, placed: Frames) -> tuple[Frames, float]:
        """The frame made exact, and what it is off."""
        room, mine, yours = self._room(row), self.curve[lead], Locus(self.curve[row])
        exact = _polished(placed, mine, yours, 4 * room)
        if exact is None:
            return placed, np.inf
        exact = _snapped(exact, self.shapes[lead].radius, room)
        error = deviation(exact, Locus(mine), yours)
        if self.directed:
            error = max(error, _ends_apart(exact, mine, self.curve[row]))
        return exact, error


def _rows(placed: list[Frames]) -> Frames:
    """Frames of shape () as the rows of one."""
    first = np.zeros(1, np.int64)
    return join(
        [
            frames(each.position[None], each.angle, each.scale, each.handedness)[first]
            for each in placed
        ]
    )


def _polygons(curves: Curves, shapes: list[Found], tolerance: float) -> Curves:
    """The shapes of straight lines without the corners that hardly show, the others without any
    segments.
    """
    owner = np.repeat(np.arange(len(curves.counts)), curves.counts)
    bent = np.bincount(owner[curves.kind != LINE], minlength=len(shapes)) > 0
    keep = ~(bent | (curves.subpaths > 1))
    counts = np.where(keep, curves.counts, 0)
    offsets = np.concatenate([[0], np.cumsum(counts)])
    rows = keep[owner]
    straight = replace(curves, kind=curves.kind[rows], points=curves.points[rows], offsets=offsets)
    room = np.array([2 * tolerance / float(each.frames.scale.min()) for each in shapes])
    fixed = np.full(len(shapes), shapes[0].directed)
    return fewest_segments(straight, fixed, room, tolerance * 1e-2)


def _mixed(parts: list[Integers], writing: Integers) -> list[Integers]:
    """The parts that hold different writings."""
    return [part for part in parts if len(part) > 1 and np.ptp(writing[part])]


def _corners_apart(placed: Frames, lead: Segments, other: Segments) -> float:
    """Largest distance of the corners of a polygon under a frame from another one."""
    start, end = other[1][:, 0], other[1][:, 1]
    corners = apply(placed, np.append(lead[1][:, 0], lead[1][-1, 1]))[:, None]
    step = end - start
    part = ((corners - start) * np.conj(step)).real / np.maximum(np.abs(step) ** 2, 1e-300)
    return float(np.abs(corners - start - np.clip(part, 0, 1) * step).min(axis=1).max())


def _writings(curves: Curves, polygons: Curves) -> Integers:
    """(n,) numbers, equal for elements with equally many segments of each kind, and -1 for polygons
    of corners that all show, since two of those have the same corners.
    """
    owner = np.repeat(np.arange(len(curves.counts)), curves.counts)
    often = np.bincount(owner * 5 + curves.kind, minlength=5 * len(curves.counts)).reshape(-1, 5)
    numbers = np.unique(often, axis=0, return_inverse=True)[1].ravel()
    return np.where(polygons.counts == curves.counts, -1, numbers)


def _integrals(curves: Curves, tolerance: float) -> tuple[Floats, Floats]:
    """(n, 5) numbers that neither similarity nor the cut into segments changes: length and moments
    of curves of unit radius; (n,) how far they may move.
    """
    owner = np.repeat(np.arange(len(curves.counts)), curves.counts)
    count = len(curves.counts)
    nodes, weight, belongs = [], [], []
    for straight, order in ((True, 3), (False, 16)):
        rows = np.flatnonzero((curves.kind == LINE) == straight)
        at, share = np.polynomial.legendre.leggauss(order)
        at, share = (at + 1) / 2, share / 2
        kind, points = np.repeat(curves.kind[rows], order), np.repeat(curves.points[rows], order, 0)
        speed = np.abs(derivative(kind, points, np.tile(at, len(rows))))
        nodes.append(evaluate(curves.kind[rows], curves.points[rows], at).ravel())
        weight.append(speed * np.tile(share, len(rows)))
        belongs.append(np.repeat(owner[rows], order))
    z, w, shape = np.concatenate(nodes), np.concatenate(weight), np.concatenate(belongs)

    def mean(values: Floats) -> Floats:
        return np.bincount(shape, w * values, count) / length

    length = np.maximum(np.bincount(shape, w, count), 1e-300)
    away = z - (mean(z.real) + 1j * mean(z.imag))[shape]
    square = np.maximum(mean(np.abs(away) ** 2), 1e-300)
    radius = np.sqrt(square)
    away = away / radius[shape]
    moments = away**2, away**3, away * np.abs(away) ** 2
    features = [length / (RAGGED * radius), mean(np.abs(away) ** 4)]
    features += [np.abs(mean(each.real) + 1j * mean(each.imag)) for each in moments]
    bent = np.bincount(owner[curves.kind != LINE], minlength=count) > 0
    reach = tolerance / radius + np.where(bent, QUADRATURE, 1e-12)
    return np.stack(features, axis=1), reach


def _polished(placed: Frames, lead: Segments, other: Locus, room: float) -> Frames | None:
    """A frame (of shape ()) that maps one curve onto another as well as a similarity can: distances
    along the normals of the other are made least, which leaves points free to slide. None if some
    stay larger than there is room.
    """
    mine = evaluate(*lead, np.linspace(0.0, 1.0, 5)).ravel()
    local = mirrored(mine[:: 1 + len(mine) // MOST], placed.handedness)
    factor, position = complex(placed.factor), complex(placed.position)
    size = float(np.abs(local).max())
    for step in range(POLISHES):
        there = factor * local + position
        foot, slope = other.closest(there, 2, 3)
        if step > 1 and np.abs(foot - there).max() > room:
            return None
        normal = 1j * slope / np.maximum(np.abs(slope), 1e-300)
        gap = ((foot - there) * np.conj(normal)).real
        turned = np.conj(normal) * local / size
        columns = [turned.real, -turned.imag, normal.real, normal.imag]
        change = np.linalg.lstsq(np.stack(columns, axis=1), gap, rcond=1e-5)[0]
        factor += complex(change[0], change[1]) / size
        position += complex(change[2], change[3])
    turn = np.angle(factor, deg=True)
    return frames(np.array(position), turn, abs(factor), placed.handedness)


def _snapped(placed: Frames, radius: float, room: float) -> Frames:
    """The frame with a turn and a scale that people write, if that hardly moves anything."""
    turn = SNAP * np.round(placed.angle / SNAP)
    angle, scale = placed.angle, placed.scale
    if np.abs(unit(turn) - unit(angle)) * radius * scale <= room / 16:
        angle = turn
    if np.abs(scale - 1) * radius <= room / 16:
        scale = np.ones_like(scale)
    return frames(placed.position, angle, scale, placed.handedness)


def _ends_apart(placed: Frames, lead: Segments, other: Segments) -> float:
    at = np.array([0.0, 1.0])
    mine, yours = (evaluate(*each, at) for each in (lead, other))
    ends = apply(placed, np.array([mine[0, 0], mine[-1, 1]]))
    return float(np.abs(ends - np.array([yours[0, 0], yours[-1, 1]])).max())
