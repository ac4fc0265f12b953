"""Numbers and frames for the scope oracle: operators that snap, matrices, the faces of boxes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]
SNAP = 1e-9
AXES = {"x": 0, "y": 1, "z": 2}


def same(a: float, b: float) -> bool:
    """Whether two numbers count as equal."""
    return abs(a - b) <= SNAP * max(abs(a), abs(b))


def whole(a: float, rounded: Callable[[float], float]) -> float:
    """A number rounded, unless it is as good as whole already."""
    near = float(round(a))
    return near if same(a, near) else float(rounded(a))


OPERATORS: dict[str, Callable[[float, float], float]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "<": lambda a, b: float(a < b and not same(a, b)),
    "<=": lambda a, b: float(a < b or same(a, b)),
    ">": lambda a, b: float(a > b and not same(a, b)),
    ">=": lambda a, b: float(a > b or same(a, b)),
    "==": lambda a, b: float(same(a, b)),
    "!=": lambda a, b: float(not same(a, b)),
    "and": lambda a, b: float(bool(a) and bool(b)),
    "or": lambda a, b: float(bool(a) or bool(b)),
}
FUNCTIONS: dict[str, Callable[..., float]] = {
    "min": min,
    "max": max,
    "abs": abs,
    "floor": lambda a: whole(a, math.floor),
    "ceil": lambda a: whole(a, math.ceil),
}


def moved(frame: Matrix, x: float, y: float, z: float) -> Matrix:
    step = np.eye(4)
    step[:3, 3] = x, y, z
    return frame @ step


def turned(frame: Matrix, axis: str, degrees: float) -> Matrix:
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    turn = np.eye(4)
    turn[first, first] = turn[second, second] = cosine
    turn[second, first], turn[first, second] = sine, -sine
    return frame @ turn


def with_axes(frame: Matrix, corner: Sequence[float], axes: Sequence[Sequence[float]]) -> Matrix:
    turn = np.eye(4)
    turn[:3, :3] = np.array(axes).T
    turn[:3, 3] = corner
    return frame @ turn


FACES = (  # name, words, x and y axes: x along the lower edge, x × y outward
    ("bottom", "horizontal", (1, 0, 0), (0, -1, 0)),
    ("top", "horizontal", (1, 0, 0), (0, 1, 0)),
    ("front", "side vertical", (1, 0, 0), (0, 0, 1)),
    ("right", "side vertical", (0, 1, 0), (0, 0, 1)),
    ("back", "side vertical", (-1, 0, 0), (0, 0, 1)),
    ("left", "side vertical", (0, -1, 0), (0, 0, 1)),
)


def faces(size: Sequence[float]) -> list[tuple[set[str], list[float], Matrix, tuple[float, ...]]]:
    """Of each face of a box its words, the corner where it begins, its axes, and its size."""
    found = []
    flat = [axis for axis in range(3) if size[axis] <= 0]
    if len(flat) > 1:
        return []
    for name, more, x, y in FACES:
        axes = np.array((x, y, np.cross(x, y)), float)
        across = int(np.flatnonzero(axes[2])[0])
        if flat and (flat[0] != across or name not in ("right", "top", "front")):
            continue
        # the corner where x, y and outward begin; a flat shape has its one face at 0
        corner = [size[k] if axes[:2, k].sum() < 0 else 0.0 for k in range(3)]
        corner[across] = size[across] if axes[2, across] > 0 else 0.0
        extent = (float(np.abs(axes[0]) @ size), float(np.abs(axes[1]) @ size), 0.0)
        found.append(({"all", name, *more.split()}, corner, axes, extent))
    return found
