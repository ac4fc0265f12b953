"""The result of a derivation: an instance table, not a mesh.

One row a terminal in derivation order. Frames are kept as position, unit quaternion and signed
scale (64 bytes); matrices are made when somebody asks. Export lives in `formats`, which takes
a scene and never derives.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.solid import Solid

SEGMENT = -1  # `asset` of a drawn turtle segment: from the frame's origin along its x by size[0]
OUTLINE = -2  # `asset` of a turtle polygon: `shape` indexes Scene.polygons
SCOPE = -3  # `asset` of a terminal without geometry of its own: its box is drawn
SOLID = -4  # `asset` of a terminal with geometry: `shape` indexes Scene.solids
PATH = -5  # `asset` of a turtle path: `shape` indexes Scene.polygons, NaN between its parts
OUTLINES = (OUTLINE, PATH)  # corners in the world, whatever the frame


@dataclass(frozen=True, slots=True)
class AssetRef:
    """A named piece of geometry in a file: `picket`, fences/fence.parts.svg, id `picket` (None: the
    whole file); how many times as large along x, y and z, () for as large as it is there.
    """

    name: str
    path: Path
    node: str | None
    stretch: tuple[float, ...] = ()


@dataclass(slots=True, eq=False)
class Instances:
    """Columns of equal length n, in derivation order; about 124 bytes a row.

    position (n, 3) f64; rotation (n, 4) f64 unit quaternion w, x, y, z; scale (n,) f64, its sign is
    the handedness (negative: local x is mirrored first, then scaled by |scale|, then rotated);
    size (n, 3) f64, in units of the frame (a segment's length is size[:, 0] * |scale|);
    asset (n,) int32 index into Scene.assets, or SEGMENT, OUTLINE, SCOPE, SOLID, PATH;
    shape (n,) int32 index into Scene.polygons for OUTLINE and PATH rows, into Scene.solids for
    SOLID rows, else -1;
    style (n,) int32 index into Scene.styles; width (n,) f32 in file units, NaN where the pen sets
    none; color (n,) u32 0xRRGGBBAA, 0 where the pen sets none; layer (n,) f64 paint order, stable
    ties by row; label (n,) int32 index into Scene.labels (the terminal's symbol); rule (n,) int32
    index into Scene.rules (the production that made it); key (n,) u64.
    """

    position: NDArray[np.float64]
    rotation: NDArray[np.float64]
    scale: NDArray[np.float64]
    size: NDArray[np.float64]
    asset: NDArray[np.int32]
    shape: NDArray[np.int32]
    style: NDArray[np.int32]
    width: NDArray[np.float32]
    color: NDArray[np.uint32]
    layer: NDArray[np.float64]
    label: NDArray[np.int32]
    rule: NDArray[np.int32]
    key: NDArray[np.uint64]

    def __len__(self) -> int:
        return len(self.scale)


@dataclass(frozen=True, slots=True)
class PenStyle:
    """What a pen sets beside width, colour and layer. `css`: SVG declarations that override the
    asset's own; `material`: a name (3-D); `texture`: an image file (3-D).
    """

    css: str = ""
    material: str = ""
    texture: Path | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Groups:
    """Every application of `effect`, m of them, in no order.

    of: (n,) int32 the innermost group of each instance, -1 outside all; parent: (m,) int32 the
    group around each, -1 for none; effect: (m,) int32 into `effects`, the `<g>` of a parts file
    that makes it (None: nothing). position (m, 3), rotation (m, 4), scale (m,): the frame that it
    is anchored in, as in `Instances`; layer: (m,) paint order of the group among what surrounds it.
    The instances of a group follow each other in derivation order.
    """

    of: NDArray[np.int32]
    parent: NDArray[np.int32]
    effect: NDArray[np.int32]
    effects: tuple[AssetRef | None, ...]
    position: NDArray[np.float64]
    rotation: NDArray[np.float64]
    scale: NDArray[np.float64]
    layer: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.parent)


@dataclass(frozen=True, slots=True, eq=False)
class TextureMaps:
    """The ways in which textures lie on what is drawn, m of them, in no order.

    of (n,) int32: the way of each instance, -1: each side of its box is one image. projected (m,)
    bool: by the plane of a frame, of which plane (m, 2) are the axes of u and v, position (m, 3)
    and rotation (m, 4) are as in `Instances`, hand (m,) is -1 if it is mirrored; else on the sides
    of the box. tile (m, 2): the size of an image in the world, NaN: that of the side; map
    (m, 2, 3): what then happens to (u, v, 1).
    """

    of: NDArray[np.int32]
    projected: NDArray[np.bool_]
    plane: NDArray[np.int64]
    position: NDArray[np.float64]
    rotation: NDArray[np.float64]
    hand: NDArray[np.float64]
    tile: NDArray[np.float64]
    map: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a production stands: the grammar file, the rule's name, line."""

    path: str
    rule: str
    line: int


@dataclass(slots=True, eq=False)
class Scene:
    """Everything an exporter needs. `flat`: nothing leaves z = 0. `canvas`: x, y, width,
    height, y up. `shapes`: the start, all modules made whose symbols have rules, and all terminals.
    `polygons`: corners (m, 2 or 3) of outlines; in a path a row of NaN stands between two parts.
    `groups`: what `effect` wraps, None where nothing does. `solids`: geometry in the unit box of
    its scope; a row's size stretches it, along an axis of size 0 by 1. `reports`: for each key that
    something was reported under, the sum and how many did. `decimals`: of the points of a drawing,
    None for all there are.
    """

    instances: Instances
    assets: tuple[AssetRef, ...]
    styles: tuple[PenStyle, ...]
    labels: tuple[str, ...]
    rules: tuple[Origin, ...]
    flat: bool
    polygons: tuple[NDArray[np.float64], ...] = ()
    canvas: tuple[float, float, float, float] | None = None
    canvas_size: tuple[str | None, str | None] = (None, None)
    up: Literal["y-up", "z-up"] = "z-up"
    generations: int = 0
    shapes: int = 0
    seed: int = 0
    backend: str = "cpu"
    seconds: float = 0.0
    notes: tuple[str, ...] = field(default=())
    groups: Groups | None = None
    solids: tuple[Solid, ...] = ()
    texture_maps: TextureMaps | None = None
    reports: dict[str, tuple[float, int]] = field(default_factory=dict)
    decimals: int | None = None
