"""What generated bodies call, for columns and for plain numbers, and how their source is compiled.

In goes source, out comes a function; the names it may use are listed here. Nothing is derived.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from types import CodeType

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime import bend, keys, scan
from ipmlang.runtime.algebra import cosine_and_sine
from ipmlang.runtime.code import Column, namespace


class UnscannableError(Exception):
    """Copies follow each other by something that no scan can cut: levelling."""


def take(column: Column, rows: NDArray[np.int64]) -> Column:
    """Chosen rows of a column; one number for all stays one number."""
    return column[rows] if isinstance(column, np.ndarray) and column.ndim else column


def unit(degrees: Column) -> tuple[Column, Column]:
    """Cosine and sine of angles in degrees."""
    if isinstance(degrees, np.ndarray) and degrees.ndim:
        return scan.unit(degrees)
    return cosine_and_sine(float(degrees))


def normal(w: Column, x: Column, y: Column, z: Column) -> tuple[Column, ...]:
    """A quaternion of length 1."""
    length = np.sqrt(np.square(w) + np.square(x) + np.square(y) + np.square(z))
    return w / length, x / length, y / length, z / length


def level(w: Column, i: Column, j: Column, k: Column, hand: Column) -> tuple[Column, ...]:
    """A rotation rolled about its heading until the left is horizontal."""
    columns = np.broadcast_arrays(*(np.atleast_1d(each) for each in (w, i, j, k, hand)))
    rolled = bend.levelled(tuple(columns[:4]), columns[4])
    if all(not isinstance(each, np.ndarray) for each in (w, i, j, k, hand)):
        return tuple(float(column[0]) for column in rolled)
    return rolled


def compiled(lines: Sequence[str], params: Sequence[str], result: str) -> CodeType:
    """The code of a function of its source."""
    head = f"def body({', '.join(params)}):"
    return _code("\n    ".join([head, *lines, f"return {result}"]))


@lru_cache(maxsize=256)
def _code(text: str) -> CodeType:
    """Source compiled once, where bodies that say other things are written alike."""
    return compile(text, "<production>", "exec")


def function(
    lines: Sequence[str], params: Sequence[str], result: str, space: Mapping[str, object]
) -> Callable[..., object]:
    """A function of its source."""
    return bound(compiled(lines, params, result), space)


def bound(code: CodeType, *spaces: Mapping[str, object]) -> Callable[..., object]:
    """A function of its code, with the names of its own that it may use."""
    own: dict[str, object] = {}
    for space in spaces:
        own.update(space)
    exec(code, own)
    made = own["body"]
    assert callable(made)
    return made


def names_for(single: bool) -> dict[str, object]:
    """The names that bodies use."""
    from ipmlang.runtime.order import Copies
    from ipmlang.runtime.runs import place_runs
    from ipmlang.runtime.symbol_rows import place_named

    return {
        **namespace(single),
        "child": keys.child_single,
        "take": take,
        "unit": cosine_and_sine if single else unit,
        "normal": normal,
        "level": level,
        "isfinite": math.isfinite,
        "copysign": np.copysign,
        "flatnonzero": np.flatnonzero,
        "arange": np.arange,
        "Copies": Copies,
        "place_named": place_named,
        "place_runs": place_runs,
    }
