"""Where assets stand: as they are in the frames of their rows, or fitted into the scopes of these.

In go rows and the box of an asset, out come matrices, all at once. No file is read here.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime.export.placing import frame_matrices
from ipmlang.runtime.scene import Instances

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]


def fitted_matrices(table: Instances, rows: Rows, low: Floats, high: Floats) -> Floats:
    """(n, 3, 4) maps from an asset whose box is `low` to `high` (3,) to the world.

    A row without size takes the asset as it is. Else the asset's box becomes the scope's: from the
    scope's origin to its size. Along an axis in which the scope or the asset has no extent the
    asset keeps its own.
    """
    matrices = frame_matrices(table, rows)
    size = table.size[rows]
    fits = (size != 0).any(axis=1)
    if not fits.any():
        return matrices
    extent = high - low
    factors = np.where((size != 0) & (extent > 0), size / np.where(extent > 0, extent, 1.0), 1.0)
    factors[~fits] = 1.0
    offsets = np.where(fits[:, None], -low * factors, 0.0)
    linear, places = matrices[:, :, :3], matrices[:, :, 3]
    moved = places + np.einsum("nij,nj->ni", linear, offsets)
    return np.concatenate([linear * factors[:, None, :], moved[:, :, None]], axis=2)
