"""Points evenly spread along curves with direction and curvature: what two shapes are compared by.

In come outlines, out go equally many samples of each with the curve's direction and how far it
turns within a window about the sample, all relative to the shape's own place and size. How a curve
is cut into segments, where it starts and on which points it was drawn leaves no trace. Nothing here
compares.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import ARC, LINE, Outline
from ipmlang.inverse.lsystem.curves import Booleans, Integers, evaluate, stack
from ipmlang.inverse.lsystem.frames import Complexes, Floats

SAMPLES = 64  # of each shape
# Half of the stretch over which a turn is measured, in radii: shorter is noise, longer is form.
WINDOW = 0.25
STEPS = 16  # chords of a curved segment, and of a quarter of an ellipse


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """k shapes as M samples each, in order along their subpaths, one subpath after the other.

    points: (k, M) about the shape's centre, in radii; heading: (k, M) unit numbers, the direction;
    turn: (k, M) radians, left positive, from the stretch before a sample to the one after it;
    after, before: (k, M) the next and the last sample of the subpath, itself where there is none;
    centre: (k,) the mean along the curve; radius: (k,) units, the root-mean-square distance from
    it; length: (k,) radii; ring: (k,) whether all subpaths are closed, which then all run
    counter-clockwise.
    """

    points: Complexes
    heading: Complexes
    turn: Floats
    after: Integers
    before: Integers
    centre: Complexes
    radius: Floats
    length: Floats
    ring: Booleans


@dataclass(frozen=True, slots=True, eq=False)
class _Polylines:
    """Curves as chords. start, end: (c,) of each; along: (c + 1,) how far it is to each chord, all
    curves one after the other; first: (s + 1,) the first chord of each subpath; closed: (s,);
    owner: (s,) the shape of each subpath.
    """

    start: Complexes
    end: Complexes
    along: Floats
    first: Integers
    closed: Booleans
    owner: Integers

    @property
    def bounds(self) -> Floats:
        """(s + 1,) how far it is to each subpath."""
        return self.along[self.first]


def sample(outlines: Sequence[Outline]) -> Samples:
    """Samples of outlines, each of some length."""
    lines = _polylines(outlines)
    whole = np.searchsorted(lines.owner, np.arange(len(outlines) + 1))
    edges = lines.bounds[whole]
    length = np.diff(edges)
    share = (np.arange(SAMPLES) + 0.5) / SAMPLES
    along = edges[:-1, None] + share * length[:, None]
    path = np.clip(np.searchsorted(lines.bounds, along, "right") - 1, 0, len(lines.closed) - 1)
    centre, radius = _place(lines, whole)
    points = _at(lines, along) - centre[:, None]
    heading, turn = _directions(lines, along, path, WINDOW * radius[:, None])
    ring = np.minimum.reduceat(lines.closed, whole[:-1]) if len(outlines) else np.zeros(0, np.bool_)
    points = points / np.maximum(radius, 1e-300)[:, None]
    flip = _clockwise(points, path) & ring[:, None]
    heading, turn = np.where(flip, -heading, heading), np.where(flip, -turn, turn)
    after, before = _order(path, lines.closed)
    length = length / np.maximum(radius, 1e-300)
    return Samples(points, heading, turn, after, before, centre, radius, length, ring)


def _polylines(outlines: Sequence[Outline]) -> _Polylines:
    curves = stack(outlines)
    quarters = np.where(curves.kind == ARC, np.abs(curves.points[:, 3].imag) * 2 / np.pi, 1.0)
    counts = np.where(curves.kind == LINE, 1, np.ceil(STEPS * quarters)).astype(np.int64)
    segment = np.repeat(np.arange(len(counts)), counts)
    step = np.arange(len(segment)) - np.repeat(np.cumsum(counts) - counts, counts)
    at = np.stack([step, step + 1], axis=1) / counts[segment][:, None]
    ends = evaluate(curves.kind[segment], curves.points[segment], at)
    along = np.concatenate([[0.0], np.cumsum(np.abs(ends[:, 1] - ends[:, 0]))])
    firsts = [
        offset + outline.starts[:-1]
        for offset, outline in zip(curves.offsets.tolist(), outlines, strict=False)
    ]
    chord = np.concatenate([[0], np.cumsum(counts)])
    begins = np.concatenate([np.zeros(0, np.int64), *firsts]).astype(np.int64)
    return _Polylines(
        ends[:, 0],
        ends[:, 1],
        along,
        chord[np.append(begins, curves.offsets[-1])],
        np.concatenate([np.zeros(0, np.bool_), *(outline.closed for outline in outlines)]),
        np.repeat(np.arange(len(outlines)), [len(outline.closed) for outline in outlines]),
    )


def _place(lines: _Polylines, whole: Integers) -> tuple[Complexes, Floats]:
    """Mean and root-mean-square radius of whole shapes, given by their first subpaths."""
    length = np.diff(lines.along)
    shape = np.repeat(lines.owner, np.diff(lines.first))
    count = len(whole) - 1
    total = np.maximum(np.bincount(shape, length, count), 1e-300)
    middle = (lines.start + lines.end) / 2 * length
    centre = _sums(shape, middle, count) / total
    a, b = lines.start - centre[shape], lines.end - centre[shape]
    square = (np.abs(a) ** 2 + np.abs(b) ** 2 + (a * np.conj(b)).real) / 3 * length
    return centre, np.sqrt(np.bincount(shape, square, count) / total)


def _sums(shape: Integers, values: Complexes, count: int) -> Complexes:
    real, imaginary = (np.bincount(shape, part, count) for part in (values.real, values.imag))
    return np.asarray(real + 1j * imaginary)


def _at(lines: _Polylines, along: Floats) -> Complexes:
    """Points so far along the curves."""
    chord = np.clip(np.searchsorted(lines.along, along, "right") - 1, 0, len(lines.start) - 1)
    length = lines.along[chord + 1] - lines.along[chord]
    part = np.clip((along - lines.along[chord]) / np.maximum(length, 1e-300), 0.0, 1.0)
    return lines.start[chord] + part * (lines.end[chord] - lines.start[chord])


def _directions(
    lines: _Polylines, along: Floats, path: Integers, window: Floats
) -> tuple[Complexes, Floats]:
    """Heading and turn at places along subpaths. Towards the ends of an open one the window stays
    inside.
    """
    low, high, closed = lines.bounds[path], lines.bounds[path + 1], lines.closed[path]
    window = np.minimum(window, (high - low) / np.where(closed, 4.0, 2.0))
    middle = np.where(closed, along, np.clip(along, low + window, high - window))

    def beside(step: Floats) -> Complexes:
        there = middle + step
        round_trip = low + np.mod(there - low, np.maximum(high - low, 1e-300))
        return _at(lines, np.where(closed, round_trip, np.clip(there, low, high)))

    here, ahead, behind = _at(lines, middle), beside(window), beside(-window)
    chord = ahead - behind
    size = np.abs(chord)
    heading = np.where(size > 0, chord / np.where(size > 0, size, 1.0), 1.0)
    return heading, np.angle((ahead - here) * np.conj(here - behind))


def _clockwise(points: Complexes, path: Integers) -> NDArray[np.bool_]:
    """(k, M) whether the subpath of each sample encloses a negative area."""
    after, _ = _order(path, np.ones(path.max(initial=-1) + 1, np.bool_))
    near = np.take_along_axis(points, after, axis=1)
    area = np.bincount(path.ravel(), (np.conj(points) * near).imag.ravel())
    return np.asarray(area[path] < 0) if path.size else np.zeros(path.shape, np.bool_)


def _order(path: Integers, closed: Booleans) -> tuple[Integers, Integers]:
    """(k, M) the samples after and before each one on its subpath."""
    place = np.broadcast_to(np.arange(path.shape[1]), path.shape)
    first = (place == 0) | (path != np.roll(path, 1, axis=1))
    last = np.roll(first, -1, axis=1)
    begin = np.maximum.accumulate(np.where(first, place, 0), axis=1)
    back = np.where(last, place, path.shape[1])[:, ::-1]
    finish = np.minimum.accumulate(back, axis=1)[:, ::-1]
    around = closed[path]
    after = np.where(last, np.where(around, begin, place), place + 1)
    before = np.where(first, np.where(around, finish, place), place - 1)
    return after, before
