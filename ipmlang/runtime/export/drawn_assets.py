"""Assets of a flat scene: read from their SVG files, and moved to where their copies stand.

In go references and matrices, out come drawings, coordinates and styles. Each asset is read once a
scene. Which rows use it is not known here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import fail
from ipmlang.formats import FormatError
from ipmlang.formats.drawing import Drawing, Effect, Note, Outline, Paint, PaintServer, Style
from ipmlang.formats.svg.bounds import transform_segments
from ipmlang.formats.svg.transforms import Matrix, multiply
from ipmlang.runtime.scene import AssetRef, Scene

Floats = NDArray[np.float64]
_Read = TypeVar("_Read")


def drawn_assets(scene: Scene) -> tuple[dict[int, Drawing], tuple[Note, ...]]:
    """The drawings of the assets that rows use, by number, and what their readers noted."""
    used = np.unique(scene.instances.asset)
    drawings: dict[int, Drawing] = {}
    nodes: dict[Path, list[int]] = {}
    for number in used[used >= 0].tolist():
        asset = scene.assets[number]
        _check_drawing(asset)
        if asset.node is None:
            drawings[number] = _whole(asset)
        else:
            nodes.setdefault(asset.path, []).append(number)
    for numbers in nodes.values():
        drawings |= _parts(scene, numbers)
    notes = [note for drawing in drawings.values() for note in drawing.notes]
    return drawings, tuple(dict.fromkeys(notes))


def effects_of(reference: AssetRef) -> tuple[tuple[str, Effect], ...]:
    """The effects of a group of a parts file with their ids, outermost first."""
    from ipmlang.formats.svg.parts import read_effect

    return _read(reference, lambda: read_effect(reference.path, reference.node or ""))


def placed(outline: Outline, matrices: Floats) -> Floats:
    """(n, m, 4, 2) coordinates of an outline of m segments under n maps (n, 6)."""
    copies, size = len(matrices), len(outline.kind)
    kind = np.tile(outline.kind, copies)
    coords = np.tile(outline.coords, (copies, 1, 1))
    moved = transform_segments(kind, coords, np.repeat(matrices, size, axis=0))
    return moved.reshape(copies, size, 4, 2)


def depends_on_frame(style: Style) -> bool:
    """Whether a style has parts in a space of its own, which move with each copy."""
    servers = isinstance(style.fill, PaintServer) or isinstance(style.stroke, PaintServer)
    return servers or style.stroke_matrix is not None or bool(style.effects)


def moved_style(style: Style, matrix: Matrix) -> Style:
    """The style under a similarity: gradients and slanted pens go along, widths stay."""
    pen = style.stroke_matrix
    if pen is not None:
        size = math.sqrt(abs(matrix[0] * matrix[3] - matrix[1] * matrix[2])) or 1.0
        pen = _slanted(multiply(matrix, (*pen, 0.0, 0.0)), size)
    return replace(
        style,
        fill=_moved_paint(style.fill, matrix),
        stroke=_moved_paint(style.stroke, matrix),
        stroke_matrix=pen,
    )


def _slanted(matrix: Matrix, size: float) -> tuple[float, float, float, float]:
    return (matrix[0] / size, matrix[1] / size, matrix[2] / size, matrix[3] / size)


def _moved_paint(paint: Paint, matrix: Matrix) -> Paint:
    if not isinstance(paint, PaintServer):
        return paint
    return replace(paint, matrix=multiply(matrix, paint.matrix))


def _check_drawing(asset: AssetRef) -> None:
    if asset.path.suffix.lower() not in (".svg", ".svgz"):
        raise fail(
            "not-a-drawing",
            f"the asset `{asset.name}` is no drawing: {asset.path.name}",
            hint="a drawing takes assets from .svg files; write .glb or .obj for solid ones",
        )


def _whole(asset: AssetRef) -> Drawing:
    from ipmlang.formats.svg import read_svg

    return _read(asset, lambda: read_svg(asset.path))


def _parts(scene: Scene, numbers: list[int]) -> dict[int, Drawing]:
    """Assets that are nodes of one file, which is read once for all of them."""
    from ipmlang.formats.svg import read_nodes

    ids = {number: scene.assets[number].node or "" for number in numbers}
    first = scene.assets[numbers[0]]
    found = _read(first, lambda: read_nodes(first.path, dict.fromkeys(ids.values())))
    return {number: found[node] for number, node in ids.items()}


def _read(asset: AssetRef, read: Callable[[], _Read]) -> _Read:
    try:
        return read()
    except FormatError as error:
        place = f"{asset.path.name}:{error.line}" if error.line else asset.path.name
        raise fail("bad-asset", f"{place}: {error.message}", hint=error.hint) from error
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise fail("bad-asset", f"cannot read {asset.path}: {reason}") from error
