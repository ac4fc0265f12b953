"""What tests of models share: small images, and scenes of a few rows."""

from __future__ import annotations

import struct
import zlib

import numpy as np

from ipmlang.geometry.solid import Solid
from ipmlang.runtime.scene import AssetRef, Instances, Origin, PenStyle, Scene


def png(*pixels: int, kind: int = 0) -> bytes:
    """An image of one row: grey (kind 0), or red, green, blue and opacity (6)."""
    width = len(pixels) // (4 if kind == 6 else 1)
    parts = {
        b"IHDR": struct.pack(">IIBBBBB", width, 1, 8, kind, 0, 0, 0),
        b"IDAT": zlib.compress(bytes([0, *pixels])),
        b"IEND": b"",
    }
    packed = [
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        for name, data in parts.items()
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(packed)


def table(sizes: list[list[float]], asset: int) -> Instances:
    """Rows of those sizes: at 10, 20, 30, .. along x, turned by 90 degrees about z, scaled by 2."""
    count = len(sizes)
    position = np.zeros((count, 3))
    position[:, 0] = 10 * np.arange(1, count + 1)
    rotation = np.tile([np.sqrt(0.5), 0, 0, np.sqrt(0.5)], (count, 1))
    none = np.zeros(count, np.int32)
    return Instances(
        position,
        rotation,
        np.full(count, 2.0),
        np.array(sizes),
        np.full(count, asset, np.int32),
        none.copy(),
        none.copy(),
        np.full(count, np.nan, np.float32),
        np.zeros(count, np.uint32),
        np.zeros(count),
        none.copy(),
        none.copy(),
        np.arange(count, dtype=np.uint64),
    )


def scene(rows: Instances, *assets: AssetRef, solids: tuple[Solid, ...] = ()) -> Scene:
    """A scene of those rows."""
    origin = (Origin("a.ipm", "A", 1),)
    return Scene(rows, assets, (PenStyle(),), ("part",), origin, False, solids=solids)
