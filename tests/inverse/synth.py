"""Drawings made up for tests: known shapes in rows, rings, grids, mirrored cells and scaled
sequences, with jitter if wanted, built without any file. y is downward, as in `Drawing`.

A shape is an Outline about the origin; an arrangement is an array of placements (k, 5) of x, y,
angle (degrees, counter-clockwise in the drawing's own axes), scale and handedness.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import ARC, CUBIC, LINE, Drawing, DrawnElement, Floats, Outline, Style
from ipmlang.inverse.lsystem.curves import flipped, moved
from ipmlang.inverse.lsystem.frames import frames
from ipmlang.inverse.observation import Observation

BLACK = Style()
STROKED = Style(fill="none", stroke="#000000", stroke_width=0.5)


def polygon(corners: Sequence[tuple[float, float]] | Floats, closed: bool = True) -> Outline:
    """Straight segments through the corners (k, 2), closed by one more if wanted."""
    points = np.asarray(corners, np.float64)
    ends = np.roll(points, -1, axis=0) if closed else points[1:]
    begins = points if closed else points[:-1]
    coords = np.zeros((len(ends), 4, 2))
    coords[:, 0], coords[:, 1] = begins, ends
    return _outline(np.full(len(ends), LINE), coords, closed)


def line(length: float) -> Outline:
    """From the origin along +x."""
    return polygon([(0.0, 0.0), (length, 0.0)], closed=False)


def rectangle(width: float, height: float) -> Outline:
    """About the origin."""
    x, y = width / 2, height / 2
    return polygon([(-x, -y), (x, -y), (x, y), (-x, y)])


def star(points: int, outer: float = 5.0, inner: float = 2.0) -> Outline:
    """A star of so many points."""
    angle = np.arange(2 * points) * np.pi / points
    radius = np.where(np.arange(2 * points) % 2 == 0, outer, inner)
    return polygon(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1))


def circle(radius: float, pieces: int = 1, start: float = 0.0) -> Outline:
    """A full circle of so many arcs, starting at an angle in radians."""
    coords = np.zeros((pieces, 4, 2))
    coords[:, 1, 0] = coords[:, 2, 1] = radius
    coords[:, 3, 0] = start + np.arange(pieces) * 2 * np.pi / pieces
    coords[:, 3, 1] = 2 * np.pi / pieces
    return _outline(np.full(pieces, ARC), coords, True)


def leaf(size: float = 10.0) -> Outline:
    """A closed shape of two curves and a line without any symmetry."""
    corners = np.array([[0.0, 0.0], [1.0, 0.25], [0.4, 0.9]])
    coords = np.zeros((3, 4, 2))
    coords[0] = [corners[0], (0.3, -0.2), (0.8, -0.1), corners[1]]
    coords[1] = [corners[1], (1.1, 0.5), (0.7, 0.8), corners[2]]
    coords[2, :2] = [corners[2], corners[0]]
    return _outline(np.array([CUBIC, CUBIC, LINE]), coords * size, True)


def compound(*parts: Outline) -> Outline:
    """Several outlines as the subpaths of one."""
    lengths = [len(part.kind) for part in parts]
    return Outline(
        np.concatenate([part.kind for part in parts]),
        np.concatenate([part.coords for part in parts]),
        np.cumsum([0, *lengths], dtype=np.int32),
        np.concatenate([part.closed for part in parts]),
    )


def at(shape: Outline, x: float, y: float, angle: float = 0.0) -> Outline:
    """The outline turned about the origin, then moved."""
    return moved(shape, frames(np.array(complex(x, y)), angle))


def row(count: int, step: tuple[float, float], start: tuple[float, float] = (0.0, 0.0)) -> Floats:
    """Equal steps."""
    index = np.arange(count)[:, None]
    return _placements(np.array(start) + index * np.array(step))


def ring(count: int, radius: float, centre: tuple[float, float] = (0.0, 0.0)) -> Floats:
    """Evenly about a centre, each turned with its place."""
    angle = np.arange(count) * 360.0 / count
    turn = np.deg2rad(angle)
    at = np.array(centre) + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return _placements(at, angle)


def grid(columns: int, rows: int, right: tuple[float, float], down: tuple[float, float]) -> Floats:
    """Columns by rows of two steps, row by row; the steps need not be at right angles."""
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    at = i.reshape(-1, 1) * np.array(right) + j.reshape(-1, 1) * np.array(down)
    return _placements(at)


def scaled(count: int, step: float, factor: float, turn: float = 0.0) -> Floats:
    """A sequence in which each copy is `factor` as large as the one before, moved by `step` of its
    own size along its heading and turned by `turn` degrees.
    """
    placed = np.zeros((count, 5))
    at, scale, angle = 0j, 1.0, 0.0
    for index in range(count):
        placed[index] = at.real, at.imag, angle, scale, 1
        at += step * scale * np.exp(1j * np.deg2rad(angle))
        scale, angle = scale * factor, angle + turn
    return placed


def mirror_cell(cell: Floats, axis: float) -> Floats:
    """Placements and their images in the vertical line x = axis."""
    image = cell.copy()
    image[:, 0] = 2 * axis - cell[:, 0]
    image[:, 2] = -cell[:, 2]
    image[:, 4] = -cell[:, 4]
    return np.concatenate([cell, image])


def jittered(placements: Floats, amount: float, seed: int = 0) -> Floats:
    """Positions moved by up to `amount` units in each coordinate."""
    result = placements.copy()
    result[:, :2] += np.random.default_rng(seed).uniform(-amount, amount, (len(result), 2))
    return result


def holed(placements: Floats, share: float, seed: int = 0) -> Floats:
    """Without a share of the rows, the first and last kept."""
    keep = np.random.default_rng(seed).random(len(placements)) >= share
    keep[[0, -1]] = True
    return placements[keep]


def copies(
    shape: Outline, placements: Floats, style: Style = BLACK, source: tuple[str, ...] = ()
) -> list[DrawnElement]:
    """One element for each placement."""
    at = placements[:, 0] + 1j * placements[:, 1]
    hand = placements[:, 4].astype(np.int8)
    placed = frames(at, placements[:, 2], placements[:, 3], hand)
    return [
        DrawnElement(moved(shape, placed[index]), style, None, source)
        for index in range(len(placements))
    ]


def drawing(
    elements: Sequence[DrawnElement],
    box: tuple[float, float, float, float] | None = (0.0, 0.0, 100.0, 100.0),
) -> Drawing:
    """A drawing of these elements."""
    return Drawing(tuple(elements), box)


def restarted(outline: Outline, first: int, backwards: bool = False) -> Outline:
    """The same closed curve from another segment on, or run the other way."""
    order = np.roll(np.arange(len(outline.kind)), -first)
    kind, coords = outline.kind[order], outline.coords[order]
    if backwards:
        kind, coords = kind[::-1], coords[::-1].copy()
        for code, last in ((LINE, 2), (CUBIC, 4)):
            rows = kind == code
            coords[rows, :last] = coords[rows, :last][:, ::-1]
        arcs = kind == ARC
        start, sweep = coords[arcs, 3, 0].copy(), coords[arcs, 3, 1].copy()
        coords[arcs, 3] = np.stack([start + sweep, -sweep], axis=1)
    return Outline(kind, coords, outline.starts, outline.closed)


def _placements(at: Floats, angle: Floats | None = None) -> Floats:
    count = len(at)
    turn = np.zeros(count) if angle is None else angle
    return np.column_stack([at, turn, np.ones(count), np.ones(count)])


def _outline(kind: NDArray[np.integer], coords: Floats, closed: bool) -> Outline:
    starts = np.array([0, len(kind)], np.int32)
    return Outline(kind.astype(np.uint8), coords, starts, np.array([closed]))


def rebuilt(observed: Observation) -> Drawing:
    """The drawing that an observation describes: each representative in each frame."""
    elements = []
    for index, element in enumerate(observed.drawing.elements):
        shape = observed.classes[observed.shape[index]]
        if shape.outline is None:
            elements.append(element)
            continue
        placed = moved(shape.outline, observed.frames[index])
        points = flipped(
            placed.kind, placed.coords[..., 0] + 1j * placed.coords[..., 1], observed.flip
        )
        coords = np.stack([points.real, points.imag], axis=-1)
        outline = Outline(placed.kind, coords, placed.starts, placed.closed)
        elements.append(replace(element, outline=outline))
    return replace(observed.drawing, elements=tuple(elements))
