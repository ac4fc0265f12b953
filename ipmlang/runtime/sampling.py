"""Contexts while a program runs: their files read once, and asked at places of the ground.

In go the contexts of a bound program and columns of x and y, out come numbers. A context is read
when a run starts, and kept for the next run while its file stays the same. What is read here is
never drawn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.formats import FormatError

Numbers: TypeAlias = NDArray[np.generic]
Coordinates: TypeAlias = "float | NDArray[np.float64]"
Texels: TypeAlias = NDArray[np.float64]
Whole: TypeAlias = NDArray[np.int64]
KEPT = 4  # files that stay in memory between runs


@dataclass(frozen=True, slots=True, eq=False)
class Context:
    """A picture or a field over a rectangle of the ground. `numbers` (height, width, channels) are
    those of the file with the lowest row first; a texel stands for `number / white * slope +
    offset`.
    """

    numbers: Numbers
    place: ir.Rectangle
    nearest: bool
    white: float
    slope: float
    offset: float

    def at(self, rows: Whole, columns: Whole, channel: int) -> Texels:
        """What some texels stand for."""
        return self.meant(self.numbers[rows, columns, channel])

    def meant(self, numbers: Numbers) -> Texels:
        """What numbers of its file stand for."""
        found: Texels = np.asarray(numbers, np.float64) / self.white * self.slope + self.offset
        return found

    def one(self, row: int, column: int, channel: int) -> float:
        """What one texel stands for."""
        return float(self.numbers[row, column, channel]) / self.white * self.slope + self.offset


def load_contexts(program: ir.Program) -> tuple[Context, ...]:
    """The contexts of a bound program. Raises IpmError for a file that is missing or broken."""
    return tuple(_load(each) for each in program.contexts)


def fetch(context: Context, channel: int, x: Coordinates, y: Coordinates) -> Coordinates:
    """The numbers of a context at (x, y), each (n,) or one number: between the middles of four
    texels by both distances, beyond the edges as at the edge. NaN only where x or y is NaN.
    """
    left, bottom, width, height = context.place
    down, across, _ = context.numbers.shape
    with np.errstate(all="ignore"):
        columns = _along(x, left, width, across, context.nearest)
        rows = _along(y, bottom, height, down, context.nearest)
        if context.nearest:
            found = context.at(rows[0], columns[0], channel) + (rows[2] + columns[2])
        else:
            lower, upper = (
                _between(context.at(row, columns[0], channel),
                         context.at(row, columns[1], channel), columns[2])
                for row in rows[:2]
            )  # fmt: skip
            found = _between(lower, upper, rows[2])
    return found if found.ndim else float(found)


def fetch_single(context: Context, channel: int, x: float, y: float) -> float:
    """The same number for one place, bit for bit."""
    if x != x or y != y:
        return math.nan
    left, bottom, width, height = context.place
    down, across, _ = context.numbers.shape
    first, second, aside = _along_single(x, left, width, across, context.nearest)
    low, high, above = _along_single(y, bottom, height, down, context.nearest)
    if context.nearest:
        return context.one(low, first, channel)
    lower, upper = (
        _between_single(context.one(row, first, channel), context.one(row, second, channel), aside)
        for row in (low, high)
    )
    return _between_single(lower, upper, above)


def _along(
    place: Coordinates, begin: float, length: float, count: int, nearest: bool
) -> tuple[Whole, Whole, Texels]:
    """The texels before and behind places along one axis, and how far it is to the second; 0, or
    NaN for a place that is NaN, where single texels are asked.
    """
    texels = (np.asarray(place, np.float64) - begin) * count / length
    texels = np.minimum(np.maximum(texels if nearest else texels - 0.5, 0.0), count - 1.0)
    first = np.floor(texels)
    number = np.fmax(first, 0.0).astype(np.int64)
    return number, np.minimum(number + 1, count - 1), texels * 0.0 if nearest else texels - first


def _between(first: Texels, second: Texels, part: Texels) -> Texels:
    return np.asarray(first + (second - first) * part)


def _along_single(
    place: float, begin: float, length: float, count: int, nearest: bool
) -> tuple[int, int, float]:
    texels = (place - begin) * count / length
    texels = min(max(texels if nearest else texels - 0.5, 0.0), count - 1.0)
    number = int(texels)
    return number, min(number + 1, count - 1), texels - number


def _between_single(first: float, second: float, part: float) -> float:
    return first + (second - first) * part


# ------------------------------------------------------------------------------- reading


def _load(context: ir.ContextFile) -> Context:
    assert context.place is not None
    try:
        stat = context.path.stat()
        numbers, white = _read(context.path, stat.st_mtime_ns, stat.st_size)
    except OSError as error:
        raise _failed(context, "no-such-file", f"there is no file {context.path.name}") from error
    except FormatError as error:
        raise _failed(context, "bad-file", error.message, error.hint) from error
    if numbers.shape[2] < context.channels:
        count = numbers.shape[2]
        raise _failed(
            context,
            "out-of-range",
            f"{context.path.name} has {count} channel{'s' * (count > 1)}, and the channel "
            f"{context.channels - 1} is asked for",
            "channels are counted from 0",
        )
    signed = context.kind == "vector" and white != 1.0
    slope, offset = (2.0, -1.0) if signed else (1.0, 0.0)
    return Context(numbers, context.place, context.nearest, white, slope, offset)


@lru_cache(maxsize=KEPT)
def _read(path: Path, changed: int, size: int) -> tuple[Numbers, float]:
    """The numbers of a file, its lowest row first, and which stands for 1; read again when it
    changed.
    """
    from ipmlang.formats.pixels import read_pixels

    pixels = read_pixels(path)
    return np.ascontiguousarray(pixels.numbers[::-1]), pixels.white


def _failed(context: ir.ContextFile, code: str, message: str, hint: str | None = None) -> IpmError:
    return fail(
        code,
        f"context `{context.name}`: {message}",
        hint=hint,
        source=context.source,
        start=context.start,
        end=context.end,
    )
