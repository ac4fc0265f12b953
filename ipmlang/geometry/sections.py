"""Level sections of a closed solid: how much lies below a height, and where in a section.

Triangles come in; between the heights of their vertices each section changes evenly, so areas are
quadratic in height and volumes cubic, and both are inverted without error but rounding. All of it
works on many heights at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.solid import Floats, Indices

Marks = NDArray[np.bool_]

_HALVINGS = 52
_THIN = 1e-12
"""The share of the height below which a side is level."""
_STEEP = 1e-9
"""The share of a section's width below which an edge of it runs along y."""


@dataclass(frozen=True, slots=True, eq=False)
class Sides:
    """Parts of triangles over a range of heights: a section's edge runs from one line to another.

    low, high (s,): the range; start, end (s, 2, 3): the lower and upper point of the two lines.
    """

    low: Floats
    high: Floats
    start: Floats
    end: Floats


def sides_of(points: Floats) -> Sides:
    """The sides that triangles (t, 3, 3) give; the inside is on the left of a section's edges."""
    normal = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    order = np.argsort(points[:, :, 2], axis=1, kind="stable")
    low, middle, high = np.take_along_axis(points, order[:, :, None], axis=1).transpose(1, 0, 2)
    rise = high[:, 2] - low[:, 2]
    share = (middle[:, 2] - low[:, 2]) / np.where(rise > 0, rise, 1.0)
    bulge = middle - low - share[:, None] * (high - low)
    onward = (bulge[:, 1] * normal[:, 0] - bulge[:, 0] * normal[:, 1] >= 0)[:, None, None]
    long = np.stack([low, high], axis=1)
    found = []
    for short in (np.stack([low, middle], axis=1), np.stack([middle, high], axis=1)):
        start, end = np.where(onward, long, short), np.where(onward, short, long)
        found.append((short[:, 0, 2], short[:, 1, 2], start, end))
    below, above, starts, ends = (np.concatenate(each) for each in zip(*found, strict=True))
    extent = float(np.ptp(points[:, :, 2])) if len(points) else 0.0
    keep = above - below > _THIN * extent
    return Sides(below[keep], above[keep], starts[keep], ends[keep])


@dataclass(frozen=True, slots=True, eq=False)
class Layers:
    """Ranges of height within which no side begins or ends.

    levels (l + 1,): where they begin and end; areas (l, 3): of the section at the low end, the
    middle and the high end; below (l,): the volume up to the high end; sides: those of each layer,
    one layer after the other; first, counts (l,): where they begin in there, and how many.
    """

    levels: Floats
    areas: Floats
    below: Floats
    sides: Indices
    first: Indices
    counts: Indices


def layers_of(sides: Sides) -> Layers:
    """The layers between all heights where sides begin or end."""
    levels = np.unique(np.concatenate([sides.low, sides.high]))
    first, last = np.searchsorted(levels, sides.low), np.searchsorted(levels, sides.high)
    spans = last - first
    side = np.repeat(np.arange(len(spans)), spans)
    layer = np.arange(len(side)) - np.repeat(np.cumsum(spans) - spans - first, spans)
    order = np.argsort(layer, kind="stable")
    side, layer = side[order], layer[order]
    thick = np.diff(levels)
    areas = np.empty((len(thick), 3))
    for k, share in enumerate((0.0, 0.5, 1.0)):
        a, b = _edge(sides, side, levels[layer] + share * thick[layer])
        twice = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        areas[:, k] = np.bincount(layer, twice / 2, len(thick))
    areas = np.maximum(areas, 0.0)
    volumes = thick * (areas @ (1 / 6, 4 / 6, 1 / 6))
    counts = np.bincount(layer, minlength=len(thick))
    below = np.cumsum(volumes) if len(volumes) else np.zeros(1)
    return Layers(levels, areas, below, side, np.cumsum(counts) - counts, counts)


def _edge(sides: Sides, side: Indices, z: Floats) -> tuple[Floats, Floats]:
    """Where the edges of sections at heights z begin and end, x and y of each."""
    return _on(sides.start[side], z), _on(sides.end[side], z)


def _on(lines: Floats, z: Floats) -> Floats:
    low, high = lines[..., 0, :], lines[..., 1, :]
    share = (z - low[..., 2]) / (high[..., 2] - low[..., 2])
    found: Floats = low[..., :2] + share[..., None] * (high[..., :2] - low[..., :2])
    return found


def heights_of(layers: Layers, shares: Floats) -> tuple[Indices, Floats]:
    """The layers (n,) and heights (n,) below which these shares of the volume lie."""
    wanted = shares * layers.below[-1]
    layer = np.minimum(np.searchsorted(layers.below, wanted, "right"), len(layers.below) - 1)
    thick = np.diff(layers.levels)[layer]
    wanted = wanted - np.where(layer > 0, layers.below[layer - 1], 0.0)
    low, middle, high = layers.areas[layer].T
    linear, square = -3 * low + 4 * middle - high, 2 * low - 4 * middle + 2 * high
    less, more = np.zeros(len(shares)), np.ones(len(shares))
    for _ in range(_HALVINGS):
        t = (less + more) / 2
        enough = thick * t * (low + t * (linear / 2 + t * square / 3)) >= wanted
        less, more = np.where(enough, less, t), np.where(enough, t, more)
    return layer, layers.levels[layer] + (less + more) / 2 * thick


def sections(
    sides: Sides, layers: Layers, layer: Indices, z: Floats
) -> tuple[Floats, Floats, Marks]:
    """The sections at heights z (n,): their edges' starts and ends (n, m, 2), and which count."""
    counts = layers.counts[layer]
    place = np.arange(int(counts.max()))
    used = place < counts[:, None]
    side = layers.sides[np.where(used, layers.first[layer][:, None] + place, 0)]
    at = np.clip(z[:, None], sides.low[side], sides.high[side])
    starts, ends = _edge(sides, side, at)
    return starts, ends, used


def within(starts: Floats, ends: Floats, used: Marks, shares: Floats) -> Floats:
    """A point (n, 2) in each section: x by the share of its area before it, y by that of length."""
    x, y = starts[..., 0], starts[..., 1]
    run = ends[..., 0] - x
    low, high = np.minimum(x, ends[..., 0]), np.maximum(x, ends[..., 0])
    width = np.where(used, high, -np.inf).max(axis=1) - np.where(used, low, np.inf).min(axis=1)
    used = used & (np.abs(run) > _STEEP * width[:, None])
    slope = (ends[..., 1] - y) / np.where(used, run, 1.0)
    found = np.empty((len(x), 2))
    found[:, 0] = _abscissae(x, y, slope, run, used, shares[:, 0])
    at = found[:, :1]
    crossed = used & (low <= at) & (at < high)
    found[:, 1] = _ordinates(np.where(crossed, y + (at - x) * slope, np.inf), shares[:, 1])
    return found


def _abscissae(
    x: Floats, y: Floats, slope: Floats, run: Floats, used: Marks, shares: Floats
) -> Floats:
    """The x (n,) before which these shares of the sections lie.

    The length of a section along y is linear in x between the ends of its edges: lower edges,
    which run to the right, take their y from it, upper ones add it.
    """
    sign = np.where(used, -np.sign(run), 0.0)
    still = np.where(used, x, x[:, :1]).max(axis=1, keepdims=True)
    ends = np.concatenate([np.where(used, np.minimum(x, x + run), still),
                           np.where(used, np.maximum(x, x + run), still)], axis=1)  # fmt: skip
    flat, steep = sign * (y - slope * x), sign * slope
    order = np.argsort(ends, axis=1)
    at = np.take_along_axis(ends, order, axis=1)
    base = _summed(np.concatenate([flat, -flat], axis=1), order)
    rise = _summed(np.concatenate([steep, -steep], axis=1), order)
    first = np.maximum(base + rise * at[:, :-1], 0.0)
    last = np.maximum(base + rise * at[:, 1:], 0.0)
    step = np.diff(at, axis=1)
    k, rest = _found((first + last) / 2 * step, shares)
    first, last, step = first[k], last[k], step[k]
    root = np.sqrt(np.maximum(first**2 + 2 * (last - first) * rest / _over(step), 0.0))
    moved: Floats = at[:, :-1][k] + np.minimum(2 * rest / _over(first + root), step)
    return moved


def _summed(values: Floats, order: Indices) -> Floats:
    found: Floats = np.cumsum(np.take_along_axis(values, order, axis=1), axis=1)[:, :-1]
    return found


def _ordinates(crossings: Floats, shares: Floats) -> Floats:
    """The y (n,) below which these shares of what lies between crossings (n, m) are."""
    y = np.sort(crossings, axis=1)
    y = y[:, : y.shape[1] // 2 * 2].reshape(len(y), -1, 2)
    y = np.where(np.isfinite(y[..., 1:]), y, 0.0)
    k, rest = _found(y[..., 1] - y[..., 0], shares)
    found: Floats = y[..., 0][k] + rest
    return found


def _found(amounts: Floats, shares: Floats) -> tuple[tuple[Indices, Indices], Floats]:
    """In which of its amounts (n, m) each row reaches its share, and how much of that it takes."""
    below = np.cumsum(amounts, axis=1)
    wanted = shares * below[:, -1]
    k = np.minimum((below <= wanted[:, None]).sum(axis=1), amounts.shape[1] - 1)
    at = (np.arange(len(shares)), k)
    return at, np.clip(wanted - (below[at] - amounts[at]), 0.0, amounts[at])


def _over(values: Floats) -> Floats:
    """Divisors, none 0."""
    return np.where(values > 0, values, 1.0)
