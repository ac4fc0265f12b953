"""Bodies of the functions whose last bits depend on the machine: trigonometry, powers, noise.

Angles are degrees; whole quarters are exact (sin(180) is 0). The scalar body calls the batched one,
because numpy's own vector code and the C library differ in the last bits. Nothing here warns; what
has no value is NaN. Guards that hang on these are listed by the checker.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.ops.exact import Batch, nan, quiet


def one(batch: Callable[..., Batch]) -> Callable[..., float]:
    """The body for Python floats that gives the bits of `batch`."""

    def single(*values: float) -> float:
        # an array of one, as the batch sees it: numpy may take other code for its scalars
        return float(batch(*(np.full(1, value) for value in values))[0])

    return single


def _quarters(degrees: Batch) -> tuple[Batch, NDArray[np.int64]]:
    """Degrees as a remainder in [-45, 45], in radians, and whole quarters (0 to 3)."""
    turn = np.fmod(np.asarray(degrees, dtype=np.float64), 360.0)
    count = np.rint(turn / 90.0)
    whole = np.where(np.isfinite(count), count, 0.0).astype(np.int64) & 3
    return np.radians(turn - 90.0 * count), whole


def _wave(degrees: Batch, shift: int) -> Batch:
    with quiet():
        rest, quarter = _quarters(degrees)
        quarter = (quarter + shift) & 3
        value = np.where(quarter & 1, np.cos(rest), np.sin(rest))
        return np.where(quarter & 2, -value, value) + 0.0


def sine(degrees: Batch) -> Batch:
    """The sine of an angle."""
    return _wave(degrees, 0)


def cosine(degrees: Batch) -> Batch:
    """The cosine of an angle."""
    return _wave(degrees, 1)


def tangent(degrees: Batch) -> Batch:
    """The tangent of an angle; infinite at 90."""
    with quiet():
        return np.divide(sine(degrees), cosine(degrees))


def arc_sine(value: Batch) -> Batch:
    """The angle from -90 to 90 whose sine it is; NaN beyond 1."""
    with quiet():
        return np.degrees(np.arcsin(value))


def arc_cosine(value: Batch) -> Batch:
    """The angle from 0 to 180 whose cosine it is; NaN beyond 1."""
    with quiet():
        return np.degrees(np.arccos(value))


def arc_tangent(value: Batch) -> Batch:
    """The angle from -90 to 90 whose tangent it is."""
    with quiet():
        return np.degrees(np.arctan(value))


def direction(y: Batch, x: Batch) -> Batch:
    """The angle of the point (x, y), from -180 to 180."""
    with quiet():
        return np.degrees(np.arctan2(y, x))


def power(base: Batch, exponent: Batch) -> Batch:
    """base to the power of exponent; NaN for a fractional power of a negative number."""
    with quiet():
        return np.power(np.asarray(base, dtype=np.float64), exponent)


def exponential(value: Batch) -> Batch:
    """e to the power of value."""
    with quiet():
        return np.exp(value)


def logarithm(value: Batch) -> Batch:
    """The natural logarithm; NaN at 0 and below."""
    with quiet():
        return np.where(np.greater(value, 0), np.log(value), nan)


# Wichura, Algorithm AS 241 (1988), PPND7: the normal quantile to about 7 digits, which is all that
# a 24-bit uniform can tell apart. Numerators and denominators, highest power first.
_MIDDLE = (
    (59.109374720, 159.29113202, 50.434271938, 3.3871327179),
    (67.187563600, 78.757757664, 17.895169469, 1.0),
)
_SIDE = (
    (0.17023821103, 1.3067284816, 2.7568153900, 1.4234372777),
    (0.12021132975, 0.73700164250, 1.0),
)
_FAR = (
    (0.017337203997, 0.42868294337, 3.0812263860, 6.6579051150),
    (0.012258202635, 0.24197894225, 1.0),
)


def _ratio(curve: tuple[tuple[float, ...], tuple[float, ...]], x: Batch) -> Batch:
    quotient: Batch = np.divide(np.polyval(curve[0], x), np.polyval(curve[1], x))
    return quotient


def normal(u: Batch, mean: Batch, deviation: Batch) -> Batch:
    """A normally distributed number, from the uniform u by the inverse of its distribution."""
    with quiet():
        middle = np.asarray(u, dtype=np.float64) + 2.0**-25  # 24-bit steps, never 0 or 1
        offset = middle - 0.5
        depth = np.sqrt(-np.log(np.minimum(middle, 1.0 - middle)))
        tail = np.where(depth <= 5.0, _ratio(_SIDE, depth - 1.6), _ratio(_FAR, depth - 5.0))
        centre = offset * _ratio(_MIDDLE, 0.180625 - offset * offset)
        value = np.where(np.abs(offset) <= 0.425, centre, np.copysign(tail, offset))
        drawn: Batch = np.add(mean, np.multiply(deviation, value))
        return drawn


def noise(x: Batch, y: Batch | float = 0.0, z: Batch | float = 0.0) -> Batch:
    """Smooth noise from -1 to 1 over the line, the plane or space; unit cells, no randomness."""
    with quiet():
        x, y, z = np.broadcast_arrays(np.asarray(x, dtype=np.float64), y, z)
        cells = [np.floor(axis) for axis in (x, y, z)]
        rest = [axis - cell for axis, cell in zip((x, y, z), cells, strict=True)]
        ease = [t * t * t * (t * (t * 6.0 - 15.0) + 10.0) for t in rest]
        total = np.zeros(x.shape)
        for corner in range(8):
            high = [corner & 1, corner >> 1 & 1, corner >> 2 & 1]
            share = np.ones(x.shape)
            for side, t in zip(high, ease, strict=True):
                share = share * (t if side else 1.0 - t)
            point = [cell + side for cell, side in zip(cells, high, strict=True)]
            total = total + share * _lattice(point)
        finite = np.isfinite(x) & np.isfinite(y) & np.isfinite(z)
        return np.where(finite, total, nan)


def _lattice(place: list[Batch]) -> Batch:
    """A number from -1 to 1 for each point of the integer lattice: pcg3d of its coordinates."""
    a, b, c = (
        np.where(np.isfinite(axis), np.mod(axis, 2.0**32), 0.0).astype(np.uint32) for axis in place
    )
    factor, step = np.uint32(1664525), np.uint32(1013904223)
    a, b, c = (word * factor + step for word in (a, b, c))
    for turn in range(2):
        a = a + b * c
        b = b + c * a
        c = c + a * b
        if turn == 0:
            a, b, c = (word ^ (word >> np.uint32(16)) for word in (a, b, c))
    return (a >> np.uint32(8)).astype(np.float64) * 2.0**-23 - 1.0
