"""Textbook L-systems, written from their published rules, and the segments that their turtles draw.

Each is the text of a grammar; `drawn` runs one and gives its segments in derivation order, y up.
Figures without another name are those of The Algorithmic Beauty of Plants.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import ipmlang
from ipmlang.inverse.lsystem.frames import unit
from ipmlang.runtime.scene import SEGMENT

Complexes = NDArray[np.complex128]


def system(angle: float, start: str, steps: int, **rules: str) -> str:
    """The text of a grammar of one rule a symbol; symbols that are no marks draw as F."""
    lines = ["ipm 1", f"turtle angle {angle}"]
    lines += [f"{head} --> {body}" for head, body in rules.items()]
    lines += [f"interpret {head} --> F" for head in rules if head in ("A", "B", "G")]
    return "\n".join([*lines, f"start {start} steps {steps}", ""])


SYSTEMS = {
    "Koch curve": system(60, "F", 5, F="F + F - - F + F"),
    "Koch snowflake": system(60, "F - - F - - F", 4, F="F + F - - F + F"),
    "quadratic Koch, 1.7b": system(90, "F", 4, F="F + F - F - F + F"),
    "quadratic island, 1.6": system(90, "F - F - F - F", 3, F="F - F + F + F F - F - F + F"),
    "Koch, 1.9a": system(90, "F - F - F - F", 4, F="F F - F - F - F - F - F + F"),
    "Koch, 1.9b": system(90, "F - F - F - F", 4, F="F F - F - F - F - F F"),
    "Koch, 1.9d": system(90, "F - F - F - F", 4, F="F F - F - - F - F"),
    "islands and lakes, 1.8": system(
        90,
        "F + F + F + F",
        3,
        F="F + f - F F + F + F F + F f + F F - f + F F - F - F F - F f - F F F",
        f="f f f f f f",
    ),
    "rings": system(90, "F + F + F + F", 4, F="F F + F + F + F + F + F - F"),
    "board": system(90, "F + F + F + F", 4, F="F F + F + F + F + F F"),
    "crystal": system(90, "F + F + F + F", 4, F="F F + F + + F + F"),
    "triangle": system(120, "F + F + F", 6, F="F - F + F"),
    "quadratic snowflake": system(90, "F", 5, F="F - F + F + F - F"),
    "penta plexity": system(
        36, "F + + F + + F + + F + + F", 4, F="F + + F + + F + + + + + F - F + + F"
    ),
    "Levy C": system(45, "F", 10, F="+ F - - F +"),
    "terdragon": system(120, "F", 6, F="F + F - F"),
    "dragon, 1.10a": system(90, "A", 10, A="A + B +", B="- A - B"),
    "Sierpinski arrowhead, 1.10b": system(60, "B", 6, A="B + A + B", B="A - B - A"),
    "Sierpinski triangle": system(120, "F - G - G", 6, F="F - G + F + G - F", G="G G"),
    "Gosper, 1.11a": system(
        60,
        "A",
        4,
        A="A + B + + B - A - - A A - B +",
        B="- A + B B + + B + A - - A - B",
    ),
    "Hilbert": system(90, "L", 5, L="+ R F - L F L - F R +", R="- L F + R F R + F L -"),
    "Moore": system(
        90, "L F L + F + L F L", 4, L="- R F + L F L + F R -", R="+ L F - R F R - F L +"
    ),
    "Peano": system(
        90,
        "X",
        3,
        X="X F Y F X + F + Y F X F Y - F - X F Y F X",
        Y="Y F X F Y - F - X F Y F X + F + Y F X F Y",
    ),
    "square Sierpinski": system(
        90, "F + X F + F + X F", 4, X="X F - F + F - X F + F + X F - F + F - X"
    ),
    "Cantor set": system(90, "F", 7, F="F f F", f="f f f"),
    "weed, 1.24a": system(25.7, "F", 4, F="F [+ F] F [- F] F"),
    "weed, 1.24b": system(20, "F", 5, F="F [+ F] F [- F] [F]"),
    "bush, 1.24c": system(22.5, "F", 4, F="F F - [- F + F + F] + [+ F - F - F]"),
    "plant, 1.24d": system(20, "X", 6, X="F [+ X] F [- X] + X", F="F F"),
    "plant, 1.24e": system(25.7, "X", 6, X="F [+ X] [- X] F X", F="F F"),
    "plant, 1.24f": system(22.5, "X", 5, X="F - [[X] + X] + F [+ F X] - X", F="F F"),
    "binary tree": system(45, "X", 8, X="F [+ X] - X", F="F F"),
    "shrinking tree": system(30, "X", 8, X="F *(0.7) [+ X] [- X]"),
    "Pythagoras-like": system(45, "X", 7, X="F [+ *(0.6) X] [- *(0.8) X]"),
}

STOCHASTIC = """ipm 1
turtle angle 22.5 step 3
X : 50% --> F [+ X] F [- X] X
X : 30% --> F [- X] F X
X : 20% --> F [+ X] [- X] F [+ F X] - X
F --> F F
start +(90) X steps 6
"""

PAGE_28 = """ipm 1
turtle angle 25.7
F : 33% --> F [+ F] F [- F] F
F : 33% --> F [+ F] F
F : 34% --> F [- F] F
start F steps 5
"""


def drawn(text: str, seed: int | None = None) -> tuple[Complexes, Complexes]:
    """Start and end points (n,) of the segments that a grammar draws."""
    rows = ipmlang.parse(text).run(seed=seed).instances
    rows_drawn = rows.asset == SEGMENT
    start = rows.position[rows_drawn, 0] + 1j * rows.position[rows_drawn, 1]
    half = np.arctan2(rows.rotation[rows_drawn, 3], rows.rotation[rows_drawn, 0])
    length = rows.size[rows_drawn, 0] * np.abs(rows.scale[rows_drawn])
    return start, start + length * unit(np.rad2deg(2 * half))
