"""The closed paths of a drawing as rings of points: what a start stands on.

In goes an SVG file, out come outlines with holes in model coordinates (y up). Curves become chords;
open paths are left out. Nothing is mended here.
"""

from __future__ import annotations

from pathlib import Path

from ipmlang.geometry.solid import Floats


def closed_paths(path: Path) -> list[list[Floats]]:
    """Every closed path, its outline first, in the order of the file."""
    raise NotImplementedError
