"""The symmetry group of a shape: every frame that maps it onto itself.

A `Symmetry` belongs to the representative of a class, in that representative's own coordinates.
The group makes an element's frame ambiguous; which of the equivalent frames shows a pattern best is
decided later, so nothing here chooses. Finding groups from points is in `alignment`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.lsystem.frames import ORIGIN, Floats, Frames, compose, frames


@dataclass(frozen=True, slots=True, eq=False)
class Symmetry:
    """The stabiliser of a representative.

    order: rotations that keep it (1: none beside identity); 0 means any rotation, a circle.
    axis: direction in degrees, [0, 180), of one mirror axis, None if there is none; a shape of
        order n with a mirror has n axes, 180 / n degrees apart.
    stabiliser: (k,) Frames g with g(representative) = representative, identity first, then the
        other rotations by angle, then mirrors. For a circle only identity and one mirror stand
        here. Scale is always 1; positions are 0 except for a line, whose origin is its start.
    """

    order: int
    axis: float | None
    stabiliser: Frames


def trivial() -> Symmetry:
    """No symmetry."""
    return Symmetry(1, None, ORIGIN)


def dihedral(order: int, axis: float | None) -> Symmetry:
    """Rotations by 360 / order about the origin, and mirrors if an axis is given (degrees).

    A mirror at an axis of direction a is the frame of handedness -1 and angle 2a + 180.

    >>> dihedral(4, 0.0).stabiliser.angle.tolist()
    [0.0, 90.0, 180.0, -90.0, 180.0, -90.0, 0.0, 90.0]
    """
    count = max(order, 1)
    steps: Floats = np.arange(count, dtype=np.float64) * (360.0 / count)
    if axis is None:
        return Symmetry(order, None, frames(np.zeros(count, complex), steps))
    angles = np.concatenate([steps, steps + 2 * axis + 180.0])
    hands = np.repeat(np.array([1, -1], np.int8), count)
    return Symmetry(order, axis % 180.0, frames(np.zeros(2 * count, complex), angles, 1.0, hands))


def of_line(length: float, directed: bool) -> Symmetry:
    """The group of the segment from the origin to (length, 0): four frames, two if directed."""
    keep = slice(0, 2 if directed else 4)
    stabiliser = Frames(
        np.array([0.0, 0.0, length, length])[keep],
        np.zeros(4)[keep],
        np.array([0.0, 180.0, 180.0, 0.0])[keep],
        np.ones(4)[keep],
        np.array([1, -1, 1, -1], np.int8)[keep],
    )
    return Symmetry(1 if directed else 2, 0.0, stabiliser)


def alternatives(given: Frames, symmetry: Symmetry) -> Frames:
    """(n, k) frames: for each given frame (n,) all k that draw the same shape there.

    >>> turned = frames(np.array([5 + 0j]), 30.0)
    >>> alternatives(turned, dihedral(2, None)).angle.tolist()
    [[30.0, -150.0]]
    """
    return compose(given[:, None], symmetry.stabiliser)


def simplest(given: Frames, symmetry: Symmetry) -> Frames:
    """(n,) equivalent frames: not mirrored where possible, then the smallest turn, and no turn at
    all for circles.
    """
    if symmetry.order == 0:
        return frames(given.position, 0.0, given.scale)
    if len(symmetry.stabiliser) == 1:
        return given
    every = alternatives(given, symmetry)
    # Rounding keeps +180 ahead of -180 whatever the last bits are; ties go to the first.
    cost = np.round(np.abs(every.angle), 7) + np.where(every.handedness < 0, 1000.0, 0.0)
    cost += np.where(every.angle < -1e-7, 1e-3, 0.0)
    best = every[np.arange(len(given)), np.argmin(cost, axis=1)]
    # Taking turns of 360 / n away leaves last bits where people write whole degrees.
    whole = np.round(best.angle)
    angle = np.where(np.abs(best.angle - whole) < 1e-9, whole, best.angle)
    return Frames(best.x, best.y, angle, best.scale, best.handedness)
