"""The edges of a polygon, and the corners of strips of given widths along them.

Rings and a width per edge come in. Where two strips meet, their inner lines give the corner; this
file also says how corners end that would lie too far away, and which strips keep their full width.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.planar import Rings
from ipmlang.geometry.solid import Floats, Indices

Marks = NDArray[np.bool_]

THIN = 1e-10
"""Strips narrower than this part of the polygon's size are none."""
MITRE = 5.0
"""A mitre around a corner that juts in reaches this many widths; what is longer is cut off."""


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """The edges of all rings: start and end (n, 2), unit direction, unit inward normal, length,
    and the numbers of the edges before and after each on its ring.
    """

    start: Floats
    end: Floats
    along: Floats
    inward: Floats
    length: Floats
    before: Indices
    after: Indices
    counts: list[int]


def edges_of(rings: Rings) -> Edges:
    """The edges, ring by ring; each begins at the point of its number."""
    counts = [len(ring) for ring in rings]
    ends = np.cumsum(counts)
    start = np.concatenate(rings)
    number = np.arange(len(start))
    before, follows = number - 1, number + 1
    before[ends - counts], follows[ends - 1] = ends - 1, ends - counts
    step = start[follows] - start
    length = np.hypot(step[:, 0], step[:, 1])
    along = step / length[:, None]
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1)
    return Edges(start, start[follows], along, inward, length, before, follows, counts)


@dataclass(frozen=True, slots=True, eq=False)
class Corners:
    """Where strips meet at the start of each edge.

    Inner corner of the strip before it and of its own (n, 2); between them, where a long mitre is
    cut off, the middle of the cut. apart: the strips end at different widths on the line that
    halves the angle, for their inner lines meet nowhere near; long: the mitre is cut off; juts:
    the polygon juts in here. Elsewhere all three points are one.
    """

    before: Floats
    middle: Floats
    own: Floats
    apart: Marks
    long: Marks
    juts: Marks


def corners_of(edges: Edges, widths: Floats, mitre: float = MITRE) -> Corners:
    """The corners of strips of these widths (n,), one per edge, all at least 0."""
    here, other = edges.inward, edges.inward[edges.before]
    wide, wide_before = widths, widths[edges.before]
    turn = (other * edges.along).sum(axis=1)  # the sine: above 0 where it turns left
    dot = (here * other).sum(axis=1)
    # the point on both inner lines, as mean width and difference: stable on straight edges, and
    # nowhere on one that goes straight back
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = ((wide + wide_before) / 2 / (1 + dot))[:, None] * (here + other)
        skew = ((wide_before - wide) / 2 / (1 - dot))[:, None] * (other - here)
        skew = np.where((wide == wide_before)[:, None], 0.0, skew)
        reach = mean + skew
        leans = ((reach * edges.along).sum(axis=1) > 0) | (
            (reach * edges.along[edges.before]).sum(axis=1) < 0
        )
    single = edges.start + reach
    most = mitre * np.maximum(wide, wide_before)
    juts = turn < 0
    apart = (length_of(skew) > most) | (juts & leans & (wide != wide_before))
    long = juts & (length_of(reach) > most) & ~apart
    before, middle, own = single.copy(), single.copy(), single.copy()
    if apart.any():
        line = (here + other)[apart] / length_of((here + other)[apart])[:, None]
        share = (line * here[apart]).sum(axis=1)[:, None]
        own[apart] = edges.start[apart] + line * wide[apart, None] / share
        before[apart] = edges.start[apart] + line * wide_before[apart, None] / share
        middle[apart] = own[apart]
    if long.any():
        _cut_off(edges, widths, reach[long], long, mitre, (before, middle, own))
    return Corners(before, middle, own, apart, long, juts)


def _cut_off(
    edges: Edges, widths: Floats, reach: Floats, long: Marks, mitre: float,
    ends: tuple[Floats, Floats, Floats],
) -> None:  # fmt: skip
    """Cut a mitre square off at its limit."""
    before, middle, own = ends
    last = edges.before[long]
    away = reach / length_of(reach)[:, None]
    start = edges.start[long]
    limit = mitre * np.maximum(widths[long], widths[last])
    for found, which, way in ((before, last, 1.0), (own, np.flatnonzero(long), -1.0)):
        line = start + edges.inward[which] * widths[which, None]
        along = edges.along[which] * way
        short = limit - ((line - start) * away).sum(axis=1)
        found[long] = line + along * (short / (along * away).sum(axis=1))[:, None]
    middle[long] = start + away * limit[:, None]


def length_of(vectors: Floats) -> Floats:
    """The lengths (n,) of vectors (n, 2)."""
    return np.hypot(vectors[:, 0], vectors[:, 1])


def held(edges: Edges, widths: Floats, corners: Corners) -> Marks:
    """Of which edges (n,) the claims (see `claims`) end, at both ends, where the strips do.

    They do where the strip has its full width, and nothing beyond the mitres of its ends lies
    out of the reach of its neighbours' strips.
    """
    last = edges.before
    dot = (edges.along * edges.along[last]).sum(axis=1)
    turn = (edges.inward[last] * edges.along).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):  # a corner may be nowhere
        share = np.where(dot >= 0, turn, 1 / turn)
        to_own = ((corners.own - edges.start) * edges.along).sum(axis=1)
        to_last = -((corners.before - edges.start) * edges.along[last]).sum(axis=1)
        shared = corners.juts | corners.apart  # claims end on one line
        at_start = np.where(shared, 0.0, np.maximum(to_own, widths[last] * share))
        at_end = np.where(shared, 0.0, np.maximum(to_last, widths * share))[edges.after]
        full = ((corners.before[edges.after] - corners.own) * edges.along).sum(axis=1) > 0
    found: Marks = full & (at_start + at_end <= edges.length)
    return found
