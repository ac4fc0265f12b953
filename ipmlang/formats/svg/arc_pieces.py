"""Elliptical arcs as what SVG can say: endpoint arcs (`A`), or cubics where those lose accuracy.

Takes arcs as centre, two conjugate radii and an angle range; gives rows of commands with their
numbers. SVG's `A` tells an arc by its endpoints and radii, from which a reader computes the centre;
near a half turn and for thin ellipses that is ill-conditioned, so such arcs are cut or replaced.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.intp]

_CUBIC = 3
_THINNEST = 1e-2  # ry / rx below which rounding the endpoints would shift the centre too far
_SLACK = 20.0  # how much the rounding of an end may grow in the centre
_FINER = 3  # decimals more for arcs that are delicate but worth keeping whole
_CUBIC_TURN = np.pi / 16  # a cubic's error over this angle is below 1e-9 of the radius
_EXACT = 1e-9


@dataclass(slots=True)
class Pieces:
    """Commands in order. segment (p,): the segment drawn; code (p,): 1 L, 2 Q, 3 C, 4-7 A with
    large-arc flag * 2 + sweep flag; numbers (p, 6): the command's, padded; start, end (p, 2).
    """

    segment: Integers
    code: Integers
    numbers: Floats
    start: Floats
    end: Floats


def extra_decimals(arcs: Floats) -> int:
    """How many decimals more than usual arcs (n, 4, 2) need to keep their centres."""
    return _FINER if (growth(np.abs(arcs[:, 3, 1])) > _SLACK).any() else 0


def arc_pieces(arcs: Floats, segment: Integers, unit: Floats) -> Pieces:
    """Commands for arcs (n, 4, 2) as `Outline.coords` holds them; unit: (n,) what rounding
    keeps.
    """
    long, short, rotation, positive = ellipse_axes(arcs[:, 1], arcs[:, 2])
    sweep = np.clip(arcs[:, 3, 1], -2 * np.pi, 2 * np.pi)
    turn = np.abs(sweep)
    chord = 2 * short * np.abs(np.sin(turn / 2))
    small = (chord < 4 * unit) & (turn < 2 * np.pi - _EXACT)
    cubic = (short < _THINNEST * long) | (long < 4 * unit) | small
    count = np.where(cubic, np.ceil(turn / _CUBIC_TURN), _arc_count(turn)).astype(np.intp)
    count = np.maximum(count, 1)
    owner = np.repeat(np.arange(len(arcs)), count)
    position = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    step = (sweep / count)[owner]
    begin = arcs[owner, 3, 0] + step * position
    start, end = _points(arcs[owner], begin), _points(arcs[owner], begin + step)
    numbers = np.zeros((len(owner), 6))
    code = np.full(len(owner), _CUBIC, np.intp)
    bent = cubic[owner]
    numbers[bent] = _cubic_numbers(arcs[owner[bent]], begin[bent], step[bent])
    kept = ~bent
    half = np.abs(np.abs(step) - np.pi) <= 2 * _EXACT
    # A chord a little longer than the ellipse puts the centre in its middle, in every reader: the
    # only stable way to say half an ellipse.
    shrink = np.where(half, 1 - 1e-7, 1.0)
    numbers[kept, :5] = np.column_stack(
        [long[owner] * shrink, short[owner] * shrink, rotation[owner], end]
    )[kept]
    large = np.abs(step) > np.pi + 2 * _EXACT
    clockwise = (step > 0) == positive[owner]
    code[kept] = (4 + 2 * large + clockwise)[kept]
    return Pieces(segment[owner], code, numbers, start, end)


def ellipse_axes(u: Floats, v: Floats) -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
    """The principal radii (long >= short) of ellipses given by two conjugate radii (n, 2), the
    angle of the long one in degrees within (-90, 90], and whether u turns to v by the short way
    from x to y. A closed form of the singular values of 2 by 2 matrices.
    """
    half_sum, half_difference = (u[:, 0] + v[:, 1]) / 2, (u[:, 0] - v[:, 1]) / 2
    cross_sum, cross_difference = (u[:, 1] + v[:, 0]) / 2, (u[:, 1] - v[:, 0]) / 2
    middle = np.hypot(half_sum, cross_difference)
    spread = np.hypot(half_difference, cross_sum)
    long, short = middle + spread, np.abs(middle - spread)
    angle = np.arctan2(cross_sum, half_difference) + np.arctan2(cross_difference, half_sum)
    degrees = np.degrees(angle / 2)
    degrees = 90.0 - np.mod(90.0 - degrees, 180.0)
    round_enough = np.minimum(middle, spread) <= 1e-13 * long
    degrees = np.where(round_enough, 0.0, degrees)
    return long, short, degrees, middle >= spread


def growth(turn: Floats) -> Floats:
    """How much a shift of an end shifts the centre; 0 for half and whole turns, which are exact."""
    half, whole = (np.abs(turn - exact) <= _EXACT for exact in (np.pi, 2 * np.pi))
    with np.errstate(divide="ignore"):
        across = np.abs(np.tan(turn / 2))
        along = np.where(turn > np.pi, 1 / np.abs(np.sin(turn / 2)), 0.0)
    return np.where(half | whole, 0.0, np.maximum(across, along))


def _arc_count(turn: Floats) -> Floats:
    """Into how many `A` commands an arc is cut: as few as keep the centre well-conditioned."""
    whole = np.abs(turn - 2 * np.pi) <= _EXACT
    cut = np.where(turn > 1.5 * np.pi, 3.0, 2.0)
    delicate = growth(turn) > _SLACK * 10.0**_FINER
    return np.where(whole, 2.0, np.where(delicate, cut, 1.0))


def _points(arcs: Floats, angle: Floats) -> Floats:
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.asarray(arcs[:, 0] + arcs[:, 1] * cosine + arcs[:, 2] * sine)


def _cubic_numbers(arcs: Floats, begin: Floats, step: Floats) -> Floats:
    """Two handles and the end of the cubic that meets an arc with its tangents at both ends."""
    handle = (4 / 3 * np.tan(step / 4))[:, None]
    start, end = _points(arcs, begin), _points(arcs, begin + step)
    return np.concatenate(
        [
            start + handle * _tangents(arcs, begin),
            end - handle * _tangents(arcs, begin + step),
            end,
        ],
        axis=1,
    )


def _tangents(arcs: Floats, angle: Floats) -> Floats:
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.asarray(arcs[:, 2] * cosine - arcs[:, 1] * sine)
