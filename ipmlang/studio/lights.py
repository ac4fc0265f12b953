"""The light of a photographer's table: a broad sun over the camera's left shoulder, a bright sky.

Gives directions and strengths for each of a picture's passes, and for each direction the matrix
that a shadow is drawn with. Many small lights with sharp shadows add up to soft ones, so that what
is occluded darkens by itself. Nothing here knows OpenGL.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SKIES = 4  # lights of the sky in each pass, beside one of the sun
SUN = np.array([1.0, 0.955, 0.88]) * 1.18
SKY = np.array([0.90, 0.955, 1.0]) * 0.62
BOUNCE = np.array([1.0, 0.97, 0.93]) * 0.34
"""Linear light on a surface that faces the sun, lies under the whole sky, faces the lit ground."""

_SUN_AZIMUTH, _SUN_ELEVATION = -62.0, 44.0  # degrees, the azimuth from the camera's own
_SUN_RADIUS = 0.018  # tangent of half the angle that the sun spans: wider than the real one
_LOWEST = 0.10  # sine of the lowest light of the sky
_GOLDEN = np.pi * (3 - np.sqrt(5))


@dataclass(frozen=True, slots=True, eq=False)
class Lights:
    """`direction` (p, 1 + SKIES, 3) unit, toward the lights of each of p passes, the sun first;
    `share` (p, SKIES) of the sky's light, such that level ground gets all of it in the mean over
    all passes; `open_ground` (3,) the light that free ground gets.
    """

    direction: Floats
    share: Floats
    open_ground: Floats


def lights(azimuth: float, passes: int) -> Lights:
    """The lights for a camera at this azimuth in degrees."""
    direction = np.concatenate([_sun(azimuth, passes)[:, None], _sky(azimuth, passes)], axis=1)
    height = direction[:, 1:, 2]
    share = (1 + 2 * height) / 3  # brightness of an overcast sky towards the zenith
    share *= passes / (share * height).sum()
    return Lights(direction, share, SKY + SUN * direction[:, 0, 2].mean())


def _sun(azimuth: float, passes: int) -> Floats:
    """Directions (p, 3) spread over the sun's disc."""
    middle = _toward(np.radians(azimuth + _SUN_AZIMUTH), np.sin(np.radians(_SUN_ELEVATION)))
    side = np.cross([0.0, 0.0, 1.0], middle)
    side /= np.linalg.norm(side)
    number = np.arange(passes)
    radius = _SUN_RADIUS * np.sqrt((number + 0.5) / passes)
    x, y = radius * np.cos(_GOLDEN * number), radius * np.sin(_GOLDEN * number)
    spread: Floats = middle + x[:, None] * side + y[:, None] * np.cross(middle, side)
    spread /= np.linalg.norm(spread, axis=1, keepdims=True)
    return spread


def _sky(azimuth: float, passes: int) -> Floats:
    """Directions (p, SKIES, 3) spread evenly over the sky; each pass gets low and high ones."""
    count = passes * SKIES
    number = np.arange(count)
    height = _LOWEST + (1 - _LOWEST) * (number + 0.5) / count
    found = _toward(np.radians(azimuth) + _GOLDEN * number, height)
    return found.reshape(SKIES, passes, 3).transpose(1, 0, 2)


def _toward(azimuth: Floats | float, height: Floats | float) -> Floats:
    level = np.sqrt(1 - np.square(height))
    parts = level * np.sin(azimuth), -level * np.cos(azimuth), height + 0.0 * np.cos(azimuth)
    return np.stack(parts, axis=-1)


def shadow_matrix(direction: Floats, points: Floats) -> Floats:
    """(4, 4) from the world to the clip space of a shadow that holds the points (k, 3) just so."""
    side = np.array([0.0, 1.0, 0.0]) if abs(direction[2]) > 0.9 else np.array([0.0, 0.0, 1.0])
    right = np.cross(side, direction)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(direction, right), -direction])
    seen = points @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    room = 0.01 * (high - low) + 1e-3
    half = (high - low) / 2 + room
    matrix = np.eye(4)
    matrix[:3, :3] = axes / half[:, None]
    matrix[:3, 3] = -(low + high) / 2 / half
    return matrix
