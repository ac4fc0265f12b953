"""The meshes that terminals of a table on the graphics card are drawn as.

A table's model makes them, and copies are made of them. Nothing here computes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ipmlang.studio.surfaces import Surface


@dataclass(frozen=True, slots=True, eq=False)
class Kinds:
    """The meshes that terminals are drawn as: numbers (k, 12) f32 as the shaders read them, and how
    many triangles each has; `used` are those that have one of `surfaces`; colors (t,) u32 what the
    program's texts are as colours; `thin` the width of segments whose pen sets none.
    """

    numbers: NDArray[np.float32]
    triangles: NDArray[np.int64]
    used: tuple[int, ...] = ()
    surfaces: tuple[Surface, ...] = ()
    colors: NDArray[np.uint32] = field(default_factory=lambda: np.zeros(1, np.uint32))
    thin: float = 0.0
