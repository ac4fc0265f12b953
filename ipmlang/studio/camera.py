"""A camera that holds a model in view, from any side, without wasting the picture.

Takes points whose hull is the model's and a view; gives the matrix that OpenGL wants. The distance
follows from the four sides of the picture touching the points, not from a sphere around them.
Nothing here knows OpenGL.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.studio.look import View

Floats = NDArray[np.float64]

_LENS = 0.30  # tangent of half the angle that the longer side of the picture spans (33 degrees)
_MARGIN = 0.08  # share of the picture left free on each side
_BEFORE, _BEHIND = 0.2, 2.2  # the ground that is seen: a share of the distance, sizes of the model


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """`eye` (3,); `axes` (3, 3), rows right, up and forward; `lens` (2,) the tangents of half the
    angles across and down; `near` and `far` distances along forward.
    """

    eye: Floats
    axes: Floats
    lens: Floats
    near: float
    far: float

    def matrix(self, shift: tuple[float, float] = (0.0, 0.0)) -> Floats:
        """(4, 4) from the world to clip space; `shift` moves the picture, in half pictures."""
        turn = np.eye(4)
        turn[:3, :3] = self.axes * np.array([[1.0], [1.0], [-1.0]])
        turn[:3, 3] = -turn[:3, :3] @ self.eye
        depth = self.far - self.near
        lens = np.zeros((4, 4))
        lens[0, 0], lens[1, 1] = 1 / self.lens
        lens[0, 2], lens[1, 2] = -shift[0], -shift[1]
        lens[2, 2], lens[2, 3] = -(self.far + self.near) / depth, -2 * self.far * self.near / depth
        lens[3, 2] = -1.0
        result: Floats = lens @ turn
        return result

    def rays(self, shift: tuple[float, float] = (0.0, 0.0)) -> Floats:
        """(3, 3) columns: from the middle of the picture to its right edge, to its upper edge, and
        from the eye to its middle, of length 1 along forward.
        """
        right, up = self.axes[:2] * self.lens[:, None]
        return np.stack([right, up, self.axes[2] - shift[0] * right - shift[1] * up], axis=1)


def axes_of(view: View) -> Floats:
    """(3, 3): right, up and forward of a camera that looks at the model; z is up in the world.

    >>> axes_of(View(90.0, 0.0)).round(9).tolist()
    [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]
    """
    azimuth, elevation = np.radians(view.azimuth), np.radians(view.elevation)
    right = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    level = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    forward = np.cos(elevation) * level - np.array([0.0, 0.0, np.sin(elevation)])
    return np.stack([right, np.cross(right, forward), forward]) + 0.0


def fitted(points: Floats, view: View, size: tuple[int, int]) -> Camera:
    """The camera nearest to the points (k, 3) that still sees all of them, a margin around."""
    lens = _LENS * np.array(size, np.float64) / max(size)
    axes = axes_of(view)
    across, along, depth = (points @ axis for axis in axes)
    x, far_x = _between(across, depth, lens[0] * (1 - 2 * _MARGIN))
    y, far_y = _between(along, depth, lens[1] * (1 - 2 * _MARGIN))
    spread = float(np.ptp(points, axis=0).max()) or 1.0
    back = min(far_x, far_y, float(depth.min()) - 1e-3 * spread)
    eye = np.array([x, y, back]) @ axes
    near, far = float(depth.min()) - back, float(depth.max()) - back
    return Camera(eye, axes, lens, near * _BEFORE, far + _BEHIND * spread)


def orbit(points: Floats, view: View, size: tuple[int, int], count: int) -> list[Camera]:
    """Cameras all around the model, equally far from its upright middle axis, so that nothing jumps
    from picture to picture; the first stands where `view` says.
    """
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    still = fitted(_revolved(points - middle), View(0.0, view.elevation), size)
    cameras = []
    for number in range(count):
        axes = axes_of(View(view.azimuth + 360 * number / count, view.elevation))
        eye = still.axes @ still.eye @ axes + middle
        cameras.append(replace(still, eye=eye, axes=axes))
    return cameras


def _revolved(points: Floats) -> Floats:
    """Rings that hold all the points whichever way these turn about the z axis."""
    radius = np.hypot(points[:, 0], points[:, 1])
    angle = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    x, y = np.outer(np.cos(angle), radius), np.outer(np.sin(angle), radius)
    return np.stack([x, y, np.broadcast_to(points[:, 2], x.shape)], axis=2).reshape(-1, 3)


def _between(offset: Floats, depth: Floats, tangent: float) -> tuple[float, float]:
    """Where an eye must stand, sideways and in depth, for both sides of its view to touch points.

    |offset - x| <= tangent * (depth - back) for all points: the largest of each side's bound.
    """
    low = float((offset - tangent * depth).max())
    high = float((-offset - tangent * depth).max())
    return (low - high) / 2, -(low + high) / (2 * tangent)
