"""What executors draw: one row for each terminal, in derivation order, in columns.

Whichever executor made them, `assemble` makes a scene of them. Nothing here computes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime.scene import Groups, TextureMaps

TEXT_FIELDS = ("css", "fill", "stroke", "material", "texture")  # pen fields that make a style


@dataclass(slots=True, eq=False)
class Rows:
    """What was drawn, n rows.

    Frames and `size` as in `Instances`; `asset` a number of Program.assets, SEGMENT, OUTLINE, PATH
    or SCOPE; `shape` a polygon's number or -1; `width` NaN and `color` -1 where the pen sets none,
    else a number of Program.strings; `texts` the same for each of TEXT_FIELDS that some row sets;
    `symbol` the terminal's number; `rule` the production that made it, -1 for the axiom; `key`
    (n,) u64; `groups` what `effect` wraps; `texture_maps` how textures lie; `drawn` (n,) which of
    all that was drawn each row is, None where booleans joined none of it.
    """

    position: NDArray[np.float64]
    rotation: NDArray[np.float64]
    scale: NDArray[np.float64]
    size: NDArray[np.float64]
    asset: NDArray[np.int32]
    shape: NDArray[np.int32]
    width: NDArray[np.float32]
    color: NDArray[np.int32]
    texts: dict[str, NDArray[np.int32]]
    layer: NDArray[np.float64]
    symbol: NDArray[np.int32]
    rule: NDArray[np.int32]
    key: NDArray[np.uint64]
    groups: Groups | None = None
    texture_maps: TextureMaps | None = None
    drawn: NDArray[np.int64] | None = None
