"""One shape that stands for all its copies: what they are on average, and the frame of each.

Takes the copies of a shape with the turns that lay it on them; gives points that are as near to all
of them as one shape can be, plain where the copies are, and turns and shifts refitted to it. Copies
that are equal already keep the member that was chosen, bit by bit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.parts.aligning import turns
from ipmlang.inverse.parts.plainest import snapped, turned_plainly

_ENOUGH = 0.1  # share of the tolerance that copies may be off without looking for a better shape
_NEARLY = 1.1  # times the least misfit that a plainer shape may have
_LEVEL = 1e-9  # share of a shape's size within which coordinates are one
_MOST_DECIMALS = 8
_NEAR = 0.02  # how far turns may be from plain ones that are tried in their place


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """Members of a class as found. center (k, 3); points (k, v, 3) from there, those that stand for
    the shape's; linear (k, 3, 3): what brings the shape there; symmetry (s, 3, 3) of the shape,
    with places (s, v), the vertex that each vertex comes to.
    """

    center: Floats
    points: Floats
    linear: Floats
    symmetry: Floats
    places: Integers


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """A shape (v, 3) and how its copies stand: copy = linear @ shape + shift, about their centres;
    misfit (k,).
    """

    shape: Floats
    linear: Floats
    shift: Floats
    misfit: Floats


def averaged(placed: Placed, chosen: int, decimals: int | None, tolerance: float) -> Fit:
    """The plainest shape whose copies are hardly further off than need be. chosen: the member that
    gives it where copies are equal; decimals: of the file's coordinates, where they have few.
    """
    own = placed.points[chosen]
    alone = fitted(placed, own, tolerance)
    if len(placed.points) == 1 or alone.misfit.max() <= _ENOUGH * tolerance:
        return alone
    mean = fitted(placed, _symmetric(placed, _laid(placed, alone).mean(axis=0)), tolerance)
    laid = _laid(placed, mean)
    middle = _symmetric(placed, (laid.min(axis=0) + laid.max(axis=0)) / 2)
    plainer = [_plainer(own, shape, decimals) for shape in (mean.shape, middle)]
    shapes = [each for some in zip(*plainer, strict=True) for each in some]
    fits = [alone, *_fits(placed, [*shapes, mean.shape, middle], tolerance)]
    off = [float(np.hypot(fit.misfit.max(), _lopsided(placed, fit.shape))) for fit in fits]
    bound = max(_NEARLY * min(off), _ENOUGH * tolerance)
    best = next(fit for fit, each in zip(fits, off, strict=True) if each <= bound)
    return best if best is alone or decimals is None else _neatly(placed, best, decimals, bound)


def _neatly(placed: Placed, fit: Fit, decimals: int, bound: float) -> Fit:
    """The fit with copies whose lowest corners have few decimals, where that is hardly worse."""
    lever = fit.linear @ fit.shape.min(axis=0)
    place = np.round(placed.center + fit.shift + lever, decimals)
    shift = place - placed.center - lever
    off = placed.points - fit.shape @ fit.linear.transpose(0, 2, 1) - shift[:, None]
    misfit = _farthest(off)
    neat = misfit <= np.maximum(_NEARLY * fit.misfit, bound / 2)
    return replace(
        fit,
        shift=np.where(neat[:, None], shift, fit.shift),
        misfit=np.where(neat, misfit, fit.misfit),
    )


def _fits(placed: Placed, shapes: list[Floats], tolerance: float) -> list[Fit]:
    """The fits to several shapes, found together."""
    many, count = len(shapes), len(placed.points)
    row = np.arange(many * count) % count
    every = replace(placed, points=placed.points[row], linear=placed.linear[row])
    found = fitted(every, np.repeat(np.stack(shapes), count, axis=0), tolerance)
    return [
        Fit(shape, found.linear[own], found.shift[own], found.misfit[own])
        for shape, own in zip(shapes, np.split(np.arange(many * count), many), strict=True)
    ]


def fitted(placed: Placed, shape: Floats, tolerance: float) -> Fit:
    """The turns and shifts with which the copies are nearest to a shape, (v, 3), or one for each
    (k, v, 3); plain turns where they are within the tolerance.
    """
    points, linear = placed.points, placed.linear
    sign = np.sign(np.linalg.det(linear))
    own = np.broadcast_to(shape, points.shape)
    best = _shifted(points, shape, linear)
    loose = turns(own, points - best.shift[:, None], sign)
    for other in (loose, snapped(turned_plainly(loose, _NEAR), _NEAR)):
        tried = _shifted(points, shape, other)
        plain = (other != loose).any(axis=(1, 2)) & (tried.misfit <= tolerance)
        better = plain | (tried.misfit < best.misfit)
        best = Fit(
            shape,
            np.where(better[:, None, None], tried.linear, best.linear),
            np.where(better[:, None], tried.shift, best.shift),
            np.where(better, tried.misfit, best.misfit),
        )
    return best


def _shifted(points: Floats, shape: Floats, linear: Floats) -> Fit:
    """Copies moved so that the corners that are off most are off equally, where that helps."""
    off = points - shape @ linear.transpose(0, 2, 1)
    shift = (off.min(axis=1) + off.max(axis=1)) / 2
    still, moved = _farthest(off), _farthest(off - shift[:, None])
    helps = moved < still
    return Fit(shape, linear, np.where(helps[:, None], shift, 0.0), np.where(helps, moved, still))


def _farthest(off: Floats) -> Floats:
    return np.asarray(np.sqrt(np.einsum("kvi,kvi->kv", off, off).max(axis=1, initial=0.0)))


def _laid(placed: Placed, fit: Fit) -> Floats:
    """All members on the shape."""
    return np.asarray((placed.points - fit.shift[:, None]) @ fit.linear)


def _symmetric(placed: Placed, shape: Floats) -> Floats:
    """The mean of a shape's images under its symmetry, so that any of them fits alike."""
    total = np.zeros_like(shape)
    for linear, places in zip(placed.symmetry, placed.places, strict=True):
        total += shape[places] @ linear
    return np.asarray(total / len(placed.symmetry))


def _lopsided(placed: Placed, shape: Floats) -> float:
    """How far at most a shape's images under its symmetry are from it."""
    worst = 0.0
    for linear, places in zip(placed.symmetry[1:], placed.places[1:], strict=True):
        off = shape[places] - shape @ linear.T
        worst = max(worst, float((off**2).sum(axis=1).max(initial=0.0)))
    return float(np.sqrt(worst))


def _plainer(own: Floats, shape: Floats, decimals: int | None) -> list[Floats]:
    """The shape with its corners where the chosen member's are level, after one whose sizes also
    have few decimals.
    """
    level = shape.copy()
    gap = _LEVEL * max(float(np.ptp(own, axis=0).max(initial=0.0)), 1e-300)
    for axis in range(3):
        order = np.argsort(own[:, axis], kind="stable")
        kind = np.zeros(len(own), np.int64)
        kind[order[1:]] = np.cumsum(np.diff(own[order, axis]) > gap)
        level[:, axis] = (np.bincount(kind, shape[:, axis]) / np.bincount(kind))[kind]
    low = level.min(axis=0)
    return [level if decimals is None else low + np.round(level - low, decimals), level]


def decimals_of(points: Floats) -> int | None:
    """How many decimals coordinates have, None for more than a person would write."""
    for decimals in range(_MOST_DECIMALS + 1):
        scaled = points * 10.0**decimals
        if np.abs(scaled - np.rint(scaled)).max(initial=0.0) < 1e-4:
            return decimals
    return None
