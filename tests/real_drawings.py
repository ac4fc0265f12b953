"""The collected drawings, each read once in a process however many tests look at it.

Takes names without suffix; gives what `read_svg` gives, which is frozen. Nothing is written.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from ipmlang.formats.drawing import Drawing
from ipmlang.formats.svg import read_svg, split_compound
from ipmlang.inverse.observation import Observation, observe

FOLDER = Path(__file__).resolve().parents[2] / "shared" / "data" / "svg"
NAMES = sorted(path.stem for path in FOLDER.glob("*.svg")) or ["none"]


def path_of(name: str) -> Path:
    """Where a drawing lies, or a skip that says that it does not."""
    path = FOLDER / f"{name}.svg"
    if not path.exists():
        pytest.skip(f"real drawings are not here: {FOLDER} is absent")
    return path


@cache
def whole(name: str) -> Drawing:
    """A drawing as it was written."""
    return read_svg(path_of(name))


@cache
def parted(name: str) -> Drawing:
    """A drawing whose compound paths are taken apart."""
    return split_compound(whole(name))


@cache
def observed(name: str) -> Observation:
    """The classes of a drawing's elements."""
    return observe(parted(name))
