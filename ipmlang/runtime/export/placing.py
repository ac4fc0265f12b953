"""Frames of rows as matrices: those of space, and those of a drawing whose y points down.

In go positions, unit quaternions and signed scales, out come matrices, all at once. Frames are as
in `Instances`: world = position + |s| R diag(h, 1, 1) local. Nothing here knows assets or files.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime.scene import Groups, Instances

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]


def rotation_matrices(quaternion: Floats) -> Floats:
    """(n, 3, 3) rotations of unit quaternions (n, 4), w first.

    >>> rotation_matrices(np.array([[np.sqrt(0.5), 0, 0, np.sqrt(0.5)]])).round(9).tolist()[0][1][0]
    1.0
    """
    w, x, y, z = np.moveaxis(quaternion, -1, 0)
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def frame_matrices(instances: Instances | Groups, rows: Rows) -> Floats:
    """(n, 3, 4) maps from the frames of `rows` to the world."""
    scale = instances.scale[rows]
    linear = rotation_matrices(instances.rotation[rows]) * np.abs(scale)[:, None, None]
    linear[:, :, 0] *= np.sign(scale)[:, None]
    return np.concatenate([linear, instances.position[rows][:, :, None]], axis=2)


def drawing_matrices(instances: Instances | Groups, rows: Rows, flip: float) -> Floats:
    """(n, 6) maps (a, b, c, d, e, f) from an asset's own drawing to the drawing of the scene.

    An asset's y points down about its own zero, the drawing's about `flip`: y_svg = flip - y.
    """
    m = frame_matrices(instances, rows)
    a, c, e = m[:, 0, 0], -m[:, 0, 1], m[:, 0, 3]
    b, d, f = -m[:, 1, 0], m[:, 1, 1], flip - m[:, 1, 3]
    return np.stack([a, b, c, d, e, f], axis=1)
