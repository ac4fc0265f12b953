"""Pictures and fields as numbers: PNG and JPEG by their pixels, .npy by its cells.

Takes a path; gives its extent alone, read from its beginning, or all its numbers as they stand in
the file. What is too large, broken or holds a number that is not finite is a `FormatError`. No
number is interpolated or placed here.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats import FormatError
from ipmlang.formats.textures import PNG, has_alpha, texture_at

PICTURES = (".png", ".jpg", ".jpeg")
FIELDS = (".npy",)
MOST = 1 << 26  # pixels of a picture, numbers of a field: 8192 x 8192
_CHANNELS = {0: 1, 2: 3, 4: 2, 6: 4}  # of a PNG by its colour type
_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}  # JPEG markers that tell the extent


@dataclass(frozen=True, slots=True)
class Extent:
    """How many columns and rows there are, and how many channels each place has."""

    width: int
    height: int
    channels: int


@dataclass(frozen=True, slots=True, eq=False)
class Pixels:
    """The numbers of a picture or a field, (height, width, channels), in the type that the file
    has, the top row first. `white` is the number that stands for 1: 255, 65535, or 1 for a field.
    """

    numbers: NDArray[np.generic]
    white: float


def pixel_extent(path: Path) -> Extent:
    """The extent of a picture or a field, from the beginning of its file."""
    if path.suffix.lower() in FIELDS:
        return _small(path, _field_extent(path), is_field=True)
    texture = texture_at(path)
    with _opened(path) as file:
        if texture.suffix != PNG:
            return _small(path, _jpeg_extent(file, path.name))
        width, height, _, color = struct.unpack(">IIBB", file.read(26)[16:])
    channels = _CHANNELS.get(color, 4 if has_alpha(texture) else 3)
    return _small(path, Extent(width, height, channels))


def read_pixels(path: Path) -> Pixels:
    """All numbers of a picture or a field."""
    extent = pixel_extent(path)
    if path.suffix.lower() in FIELDS:
        return Pixels(_field(path), 1.0)
    return _picture(path, extent.channels)


def _opened(path: Path) -> BinaryIO:
    try:
        return path.open("rb")
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise FormatError(f"cannot read {path.name}: {reason}") from error


def _small(path: Path, extent: Extent, *, is_field: bool = False) -> Extent:
    """An extent that fits into memory."""
    count = extent.width * extent.height * (extent.channels if is_field else 1)
    if count <= MOST:
        return extent
    what = "numbers" if is_field else "pixels"
    raise FormatError(
        f"{path.name} has {extent.width:,} x {extent.height:,} pixels: over {MOST:,} {what}",
        hint="scale it down: between its pixels it is interpolated",
    )


# ------------------------------------------------------------------------------ pictures


def _jpeg_extent(file: BinaryIO, name: str) -> Extent:
    """The frame header of a JPEG, behind the segments that come before it."""
    file.seek(2)
    while len(head := file.read(4)) == 4 and head[0] == 0xFF:
        marker, size = head[1], int.from_bytes(head[2:], "big")
        if marker in _FRAMES:
            frame = file.read(6)
            if len(frame) < 6:
                break
            height, width, channels = struct.unpack(">xHHB", frame)
            if not width or not height:
                break
            return Extent(width, height, channels)
        file.seek(max(size - 2, 0), 1)
    raise FormatError(f"{name} is a broken JPEG: it has no frame")


def _picture(path: Path, channels: int) -> Pixels:
    from PIL import Image

    try:
        with Image.open(path) as image:
            image.load()
            numbers, white = _numbers(image)
    except (OSError, ValueError, SyntaxError, EOFError, struct.error, MemoryError) as error:
        raise FormatError(
            f"{path.name} is broken: {error}", hint="save it anew as a PNG"
        ) from error
    if numbers.shape[2] == 4 and channels == 2:  # grey with opacity, as some depths are decoded
        numbers = numbers[:, :, [0, 3]]
    return Pixels(numbers, white)


def _numbers(image: object) -> tuple[NDArray[np.generic], float]:
    """The pixels of a picture, (height, width, channels), and the number of white."""
    from PIL import Image

    assert isinstance(image, Image.Image)
    if image.mode == "I" or image.mode.startswith("I;16"):
        return np.asarray(image).astype(np.uint16)[:, :, None], 65535.0
    if image.mode == "P":
        image = image.convert("RGBA" if "transparency" in image.info else "RGB")
    elif image.mode not in ("L", "LA", "RGB", "RGBA"):
        image = image.convert("L" if image.mode == "1" else "RGB")
    numbers = np.asarray(image)
    return (numbers if numbers.ndim == 3 else numbers[:, :, None]), 255.0


# -------------------------------------------------------------------------------- fields


def _field_extent(path: Path) -> Extent:
    """The extent of an array of numbers, (rows, columns) or (rows, columns, channels)."""
    from tokenize import TokenError

    from numpy.lib import format as npy

    with _opened(path) as file:
        try:
            version = npy.read_magic(file)
            if version == (1, 0):
                shape, _, kind = npy.read_array_header_1_0(file)
            elif version == (2, 0):
                shape, _, kind = npy.read_array_header_2_0(file)
            else:
                raise ValueError("its version is not known")
        except (ValueError, EOFError, OSError, SyntaxError, TokenError) as error:
            raise FormatError(
                f"{path.name} is no array of numpy", hint="write it with numpy.save"
            ) from error
    channels = shape[2] if len(shape) == 3 else 1
    if kind.kind not in "bifu" or len(shape) not in (2, 3) or not 1 <= channels <= 4:
        raise FormatError(
            f"{path.name} holds {kind} of the shape {shape}",
            hint="a field has numbers of the shape (rows, columns), or of (rows, columns, "
            "components) with up to 4 components",
        )
    if not all(shape):
        raise FormatError(f"{path.name} is an empty array")
    return Extent(shape[1], shape[0], channels)


def _field(path: Path) -> NDArray[np.generic]:
    try:
        numbers: NDArray[np.generic] = np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError, MemoryError) as error:
        raise FormatError(f"{path.name} is cut off or broken: {error}") from error
    numbers = numbers.reshape(*numbers.shape[:2], -1)
    wrong = ~np.isfinite(numbers)
    if wrong.any():
        row, column, _ = (int(each[0]) for each in np.nonzero(wrong))
        raise FormatError(
            f"not every number of {path.name} is finite: {np.count_nonzero(wrong):,} of "
            f"{wrong.size:,} are not, the first in row {row}, column {column}",
            hint="say what holds there: numpy.nan_to_num(field)",
        )
    return numbers
