"""Whether two lists of placed terminals are the same, whatever their order."""

from __future__ import annotations

import numpy as np

from ipmlang.inverse.frames import Floats, Frames, Integers, matrices

Drawn = tuple[Integers, Frames]
TURNED = 1e-5  # differences of directions that do not count


def matched(a: Drawn, b: Drawn, small: float) -> bool:
    """Whether every terminal of one has its own in the other, no further off than `small` units."""
    from scipy.spatial import cKDTree

    if len(a[0]) != len(b[0]):
        return False
    if not len(a[0]):
        return True
    reach = float(np.abs(b[1].position).max()) + 1.0
    rows, others = _rows(*a, small, reach), _rows(*b, small, reach)
    away, nearest = cKDTree(others).query(rows, k=[1], p=np.inf)
    return bool(np.max(away) <= small and len(np.unique(nearest)) == len(rows))


def _rows(part: Integers, frames: Frames, small: float, reach: float) -> Floats:
    """Columns in which what does not count is `small` in all."""
    told = matrices(frames).reshape(-1, 12)
    told[:, np.arange(12) % 4 != 3] *= small / TURNED
    return np.concatenate([part[:, None] * (10.0 * reach), told], axis=1)
