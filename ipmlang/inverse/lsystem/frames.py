"""Placements in the plane as columns: position, angle, scale and handedness.

In come and out go arrays of equal (broadcastable) shape; world = position + scale * R(angle) *
diag(handedness, 1) * local, the frame of the language seen from above. Angles are degrees, so that
quarter turns are exact. Nothing here knows shapes, drawings or grammars.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import EllipsisType
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Complexes: TypeAlias = NDArray[np.complex128]
Rows: TypeAlias = NDArray[np.integer] | NDArray[np.bool_]
Index: TypeAlias = int | slice | Rows | tuple[int | slice | Rows | EllipsisType | None, ...]

Row: TypeAlias = tuple[float, float, float, float, int]  # x, y, angle, scale, handedness

QUARTERS = np.array([1, 1j, -1, -1j])  # the powers of i
# As arrays, which numpy need not convert for each of very many short columns.
QUARTER, HALF, WHOLE = np.array(90.0), np.array(180.0), np.array(360.0)


@dataclass(slots=True, eq=False)  # frozen ones take four times as long, and very many are made
class Frames:
    """Columns of one shape: x, y (units of the drawing, y up), angle (degrees, (-180, 180]), scale
    (> 0) all f64, handedness (+1 or -1, int8). Nobody puts another column in place of one.
    """

    x: Floats
    y: Floats
    angle: Floats
    scale: Floats
    handedness: NDArray[np.int8]

    def __len__(self) -> int:
        return len(self.x)

    def __getitem__(self, rows: Index) -> Frames:
        return Frames(
            np.asarray(self.x[rows]),
            np.asarray(self.y[rows]),
            np.asarray(self.angle[rows]),
            np.asarray(self.scale[rows]),
            np.asarray(self.handedness[rows]),
        )

    def flat(self) -> Frames:
        """The same as one row of columns."""
        return Frames(
            self.x.ravel(), self.y.ravel(), self.angle.ravel(), self.scale.ravel(),
            self.handedness.ravel(),
        )  # fmt: skip

    def rows(self) -> list[Row]:
        """Each row by itself, for what is written down one by one."""
        columns = (self.x, self.y, self.angle, self.scale, self.handedness)
        return list(zip(*(each.tolist() for each in columns), strict=True))

    @property
    def position(self) -> Complexes:
        """x + iy."""
        return _complex(self.x, self.y)

    @property
    def factor(self) -> Complexes:
        """scale * exp(i angle): what a local point is multiplied by after mirroring."""
        return self.scale * unit(self.angle)


def frames(
    position: Complexes,
    angle: Floats | float = 0.0,
    scale: Floats | float = 1.0,
    handedness: NDArray[np.int8] | int = 1,
) -> Frames:
    """Columns from complex positions (any shape) and what goes with them, broadcast.

    >>> len(frames(np.zeros(3, complex), 90.0))
    3
    """
    at = np.asarray(position, np.complex128)
    turn, size = np.zeros(at.shape), np.empty(at.shape)
    hand = np.empty(at.shape, np.int8)
    size[...], hand[...] = scale, handedness
    if not isinstance(angle, float) or angle:
        turn[...] = angle
        turn = wrap(turn)
    return Frames(at.real.copy(), at.imag.copy(), turn, size, hand)


def identity(count: int) -> Frames:
    """`count` frames at the origin that change nothing."""
    x, y, angle = np.zeros((3, count))
    return Frames(x, y, angle, np.ones(count), np.ones(count, np.int8))


def join(parts: list[Frames]) -> Frames:
    """The rows of all parts, one after the other."""
    if not parts:
        return identity(0)
    return Frames(
        np.concatenate([part.x for part in parts]),
        np.concatenate([part.y for part in parts]),
        np.concatenate([part.angle for part in parts]),
        np.concatenate([part.scale for part in parts]),
        np.concatenate([part.handedness for part in parts]),
    )


def replaced(given: Frames, rows: Index, new: Frames) -> Frames:
    """A copy of `given` in which `rows` are those of `new`.

    >>> replaced(identity(3), np.array([1]), frames(np.array([2 + 0j]))).x.tolist()
    [0.0, 2.0, 0.0]
    """
    made = Frames(
        given.x.copy(),
        given.y.copy(),
        given.angle.copy(),
        given.scale.copy(),
        given.handedness.copy(),
    )
    made.x[rows], made.y[rows], made.angle[rows] = new.x, new.y, new.angle
    made.scale[rows], made.handedness[rows] = new.scale, new.handedness
    return made


def compose(outer: Frames, inner: Frames) -> Frames:
    """outer after inner, broadcast: `compose(f[:, None], g)` is every f with every g.

    >>> both = compose(frames(np.array([1j]), 90.0), frames(np.array([2 + 0j]), 90.0))
    >>> float(both.y[0]), float(both.angle[0])
    (3.0, 180.0)
    """
    # The columns of `frames(apply(outer, inner.position), …)`, without a copy of each.
    at = outer.factor * _complex(inner.x * outer.handedness, inner.y)
    return Frames(
        at.real + outer.x,
        at.imag + outer.y,
        wrap(outer.angle + outer.handedness * inner.angle),
        outer.scale * inner.scale,
        outer.handedness * inner.handedness,
    )


def inverse(given: Frames) -> Frames:
    """The frames that undo `given`."""
    angle = -given.handedness * given.angle
    back = unit(angle) / given.scale
    at = -back * _complex(given.x * given.handedness, given.y)
    return Frames(at.real.copy(), at.imag.copy(), wrap(angle), 1 / given.scale, given.handedness)


def apply(given: Frames, points: Complexes | complex) -> Complexes:
    """World points of local points x + iy, broadcast with the frames."""
    return given.position + given.factor * mirrored(points, given.handedness)


def mirrored(points: Complexes | complex, handedness: NDArray[np.int8]) -> Complexes:
    """Points with local x flipped where the handedness is -1."""
    return _complex(np.asarray(points.real * handedness), points.imag)


def _complex(real: Floats, imaginary: Floats | float) -> Complexes:
    """Complex numbers of parts, which takes half as long as multiplying by i."""
    made = np.empty(real.shape, np.complex128)
    made.real, made.imag = real, imaginary
    return made


def unit(angle: Floats) -> Complexes:
    """exp(i angle) for degrees, exact at multiples of a quarter turn.

    >>> complex(unit(np.array(-270.0)))
    1j
    """
    turn = np.asarray(angle, np.float64)
    made = np.empty(turn.shape, np.complex128)
    # Most things in a drawing stand upright, and one look tells.
    if not np.count_nonzero(turn):
        made.fill(1.0)
        return made
    quarter = np.rint(turn / QUARTER)
    rest = np.deg2rad(turn - QUARTER * quarter)
    np.cos(rest, out=made.real)
    np.sin(rest, out=made.imag)
    if np.count_nonzero(quarter):
        made *= QUARTERS.take(quarter.astype(np.int64), mode="wrap")
    else:
        made.imag += 0.0
    return made


def wrap(angle: Floats) -> Floats:
    """Degrees brought into (-180, 180], exact where they already are.

    >>> wrap(np.array([-180.0, 270.0, 30.0])).tolist()
    [180.0, -90.0, 30.0]
    """
    return np.asarray(angle - WHOLE * np.ceil((angle - HALF) / WHOLE), np.float64)


def _fixed(given: Frames) -> Frames:
    """Frames that nobody may change, since many share them."""
    for column in (given.x, given.y, given.angle, given.scale, given.handedness):
        column.flags.writeable = False
    return given


NONE = _fixed(identity(0))
ORIGIN = _fixed(identity(1))  # the frame that changes nothing
