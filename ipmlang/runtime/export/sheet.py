"""A flat scene as a drawing: every row in its place, in paint order, with its style.

In goes the instance table, out comes a `Drawing` of `formats.drawing`. Assets are read once each
and placed for all their rows together. Nothing is derived and nothing is written here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import fail
from ipmlang.formats.collection import without_collection
from ipmlang.formats.drawing import ARC, LINE, Drawing, DrawnElement, Effect, Outline, Style
from ipmlang.formats.svg.bounds import transform_segments
from ipmlang.formats.svg.transforms import Matrix, multiply
from ipmlang.runtime.export.drawn_assets import (
    depends_on_frame,
    drawn_assets,
    moved_style,
    placed,
)
from ipmlang.runtime.export.drawn_groups import drawn_groups, paint_order
from ipmlang.runtime.export.placing import drawing_matrices
from ipmlang.runtime.export.row_styles import RowStyles
from ipmlang.runtime.scene import OUTLINE, PATH, SCOPE, SEGMENT, Scene

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]
_Number = TypeVar("_Number", np.float64, np.uint8)

_INSIDE = "#808080"
_THIN = 1 / 500  # width of a segment whose pen sets none, as a share of the drawing's diagonal
_BATCH = 4_000_000  # numbers placed at a time


def drawing_of(scene: Scene) -> Drawing:
    """The drawing of a flat scene; an `IpmError` if the scene is not flat or an asset is wrong."""
    if not scene.flat:
        raise fail(
            "not-flat",
            "this grammar leaves the plane, so it has no drawing",
            hint="write .glb or .obj; pictures of 3-D come with `render`",
        )
    with without_collection():
        return _Sheet(scene).drawing()


@dataclass(slots=True)
class _Sheet:
    """The drawing while it is made: `elements` holds a place for everything that is drawn,
    `groups` the names of the effects around each group.
    """

    scene: Scene
    elements: list[DrawnElement | None] = field(default_factory=list)
    effects: dict[str, Effect] = field(default_factory=dict)
    groups: list[tuple[str, ...]] = field(default_factory=list)
    looks: RowStyles | None = None

    @property
    def flip(self) -> float:
        """y_svg = flip - y: the canvas is mirrored onto itself."""
        canvas = self.scene.canvas
        return 0.0 if canvas is None else 2 * canvas[1] + canvas[3]

    def drawing(self) -> Drawing:
        table = self.scene.instances
        assets, notes = drawn_assets(self.scene)
        if self.scene.groups is not None:
            self.groups, self.effects = drawn_groups(self.scene.groups, self.flip)
        counts = np.ones(len(table), np.intp)
        counts[(table.asset == SCOPE) & ~(table.size[:, :2] != 0).all(axis=1)] = 0
        rows_of = _rows_of(table.asset, list(assets))
        for number, asset in assets.items():
            counts[rows_of[number]] = len(asset.elements)
        order = paint_order(table.layer, self.scene.groups)
        place = np.empty(len(table), np.intp)
        place[order] = np.cumsum(counts[order]) - counts[order]
        self.elements = [None] * int(counts.sum())
        for kind, draw in self._primitives().items():
            rows = np.flatnonzero((table.asset == kind) & (counts > 0))
            if len(rows):
                draw(rows, place[rows])
        self._draw_assets(assets, rows_of, place)
        drawn = tuple(element for element in self.elements if element is not None)
        width, height = self.scene.canvas_size
        return Drawing(drawn, self.scene.canvas, width, height, self.effects, notes)

    def _primitives(self) -> dict[int, Callable[[Rows, Rows], None]]:
        return {
            SEGMENT: self._segments,
            OUTLINE: self._polygons,
            PATH: self._paths,
            SCOPE: self._scopes,
        }

    def _segments(self, rows: Rows, place: Rows) -> None:
        """A line each, from the frame's origin along its x."""
        table = self.scene.instances
        matrices = drawing_matrices(table, rows, self.flip)
        coords = np.zeros((len(rows), 1, 4, 2))
        coords[:, 0, 0] = matrices[:, 4:]
        coords[:, 0, 1] = matrices[:, 4:] + matrices[:, :2] * table.size[rows, :1]
        base = Style(fill="none", stroke="#000000", stroke_width=self._default_width(coords))
        like = _lines(coords[0], False)
        self._fill(rows, place, base, like, self._rounded(like.kind, coords))

    def _scopes(self, rows: Rows, place: Rows) -> None:
        """The rectangle of each scope."""
        table = self.scene.instances
        corners = np.array([[0, 0], [1, 0], [1, -1], [0, -1], [0, 0]], float)
        matrices = drawing_matrices(table, rows, self.flip)
        local = corners * table.size[rows, None, :2]
        points = local @ matrices[:, :4].reshape(-1, 2, 2) + matrices[:, None, 4:]
        coords = np.zeros((len(rows), 4, 4, 2))
        coords[:, :, 0], coords[:, :, 1] = points[:, :-1], points[:, 1:]
        base = Style(fill="none", stroke="#000000", stroke_width=self._default_width(coords))
        like = _lines(coords[0], True)
        self._fill(rows, place, base, like, self._rounded(like.kind, coords))

    def _polygons(self, rows: Rows, place: Rows) -> None:
        """Turtle polygons, filled; their corners are in the world already."""
        shapes = self.scene.instances.shape[rows].tolist()
        outlines = [_polygon(self.scene.polygons[shape], self.flip) for shape in shapes]
        self._outlines(rows, place, outlines, Style(fill=_INSIDE))

    def _paths(self, rows: Rows, place: Rows) -> None:
        """Turtle paths, one element each, as thin as segments."""
        shapes = self.scene.instances.shape[rows].tolist()
        outlines = [_path(self.scene.polygons[shape], self.flip) for shape in shapes]
        width = self._default_width(np.concatenate([each.coords for each in outlines]))
        base = Style(fill="none", stroke="#000000", stroke_width=width)
        self._outlines(rows, place, outlines, base)

    def _outlines(self, rows: Rows, place: Rows, outlines: Sequence[Outline], base: Style) -> None:
        """An element each."""
        styles, sources = self._looks(rows, base)
        for at, outline, style, source in zip(
            place.tolist(), outlines, styles, sources, strict=True
        ):
            rounded = replace(outline, coords=self._rounded(outline.kind, outline.coords))
            self.elements[at] = DrawnElement(rounded, style, None, source)

    def _rounded(self, kind: NDArray[np.uint8], coords: Floats) -> Floats:
        """Points (…, m, 4, 2) with as many decimals as the canvas has; of whole circles the centres
        have them. Other arcs keep all of theirs: rounded ends would move their middles.
        """
        decimals, arcs = self.scene.decimals, kind == ARC
        if decimals is None:
            return coords
        if not arcs.any():
            return np.asarray(np.round(coords, decimals) + 0.0)
        around = np.isclose(np.abs(coords[..., 3, 1].sum(axis=-1)), 2 * np.pi)
        if not (arcs.all() and around.all() and np.ptp(coords[..., 0, :], axis=-2).max() < 1e-9):
            return coords
        rounded = coords.copy()
        rounded[..., 0, :] = np.round(coords[..., 0, :], decimals) + 0.0
        return rounded

    def _looks(self, rows: Rows, base: Style) -> tuple[list[Style], list[tuple[str, ...]]]:
        if self.looks is None:
            self.looks = RowStyles(self.scene, self.groups)
        return self.looks.of(rows, base), self.looks.sources(rows)

    def _default_width(self, coords: Floats) -> float:
        """1 on a canvas, else a share of the diagonal of what is drawn."""
        if self.scene.canvas is not None:
            return 1.0
        points = coords[:, :, :2].reshape(-1, 2)
        diagonal = float(np.hypot(*np.ptp(points, axis=0)))
        return float(f"{diagonal * _THIN:.3g}") or 1.0

    def _fill(self, rows: Rows, place: Rows, base: Style, like: Outline, coords: Floats) -> None:
        """One element a row; outlines that share all but their coordinates (n, m, 4, 2)."""
        styles, sources = self._looks(rows, base)
        elements, kind, starts, closed = self.elements, like.kind, like.starts, like.closed
        for at, points, style, source in zip(place.tolist(), coords, styles, sources, strict=True):
            outline = Outline(kind, points, starts, closed)
            elements[at] = DrawnElement(outline, style, None, source)

    def _draw_assets(
        self, assets: dict[int, Drawing], rows_of: dict[int, Rows], place: Rows
    ) -> None:
        """Their matrices at once, since there may be many assets of a few copies each."""
        every = np.concatenate([np.zeros(0, np.intp), *(rows_of[number] for number in assets)])
        matrices = drawing_matrices(self.scene.instances, every, self.flip)
        first = 0
        plain: list[_Copies] = []
        for number, asset in assets.items():
            rows = rows_of[number]
            own = matrices[first : first + len(rows)]
            first += len(rows)
            for offset, element in enumerate(asset.elements):
                at, outline = place[rows] + offset, element.outline
                if outline is None or depends_on_frame(element.style):
                    self._place_singly(rows, at, own, asset, element)
                else:
                    plain += _parted(_Copies(element.style, outline, rows, at, own))
        for batch in _batches(plain):
            self._draw_copies(batch)

    def _draw_copies(self, batch: Sequence[_Copies]) -> None:
        """Copies of plain outlines, placed together."""
        often = [len(each.rows) for each in batch]
        sizes = np.repeat([len(each.outline.kind) for each in batch], often)
        outlines = [(each.outline, count) for each, count in zip(batch, often, strict=True)]
        kind = np.concatenate([_times(each.kind, count) for each, count in outlines])
        coords = np.concatenate([_times(each.coords, count) for each, count in outlines])
        matrices = np.repeat(np.concatenate([each.matrices for each in batch]), sizes, axis=0)
        moved = transform_segments(kind, coords, matrices)
        straight = not (kind == ARC).any()
        moved = self._rounded(kind, moved) if straight else moved
        first = 0
        for each in batch:
            shape = (len(each.rows), len(each.outline.kind), 4, 2)
            points = moved[first : first + shape[0] * shape[1]].reshape(shape)
            first += shape[0] * shape[1]
            if not straight:
                points = self._rounded(each.outline.kind, points)
            self._fill(each.rows, each.place, each.style, each.outline, points)

    def _place_singly(
        self, rows: Rows, at: Rows, matrices: Floats, asset: Drawing, element: DrawnElement
    ) -> None:
        """Copies of what has a space of its own: fragments, gradients, slanted pens, effects."""
        styles, sources = self._looks(rows, element.style)
        own = element.style.effects
        for index, (position, row) in enumerate(zip(at.tolist(), matrices.tolist(), strict=True)):
            matrix: Matrix = (row[0], row[1], row[2], row[3], row[4], row[5])
            style = moved_style(styles[index], matrix)
            if own:
                outer = style.effects[: -len(own)]
                carried = tuple(self._carry(asset, name, matrix) for name in own)
                style = replace(style, effects=outer + carried)
            outline, fragment = element.outline, element.fragment
            if outline is not None:
                points = placed(outline, matrices[index : index + 1])[0]
                points = self._rounded(outline.kind, points)
                outline = replace(outline, coords=points)
            if fragment is not None:
                fragment = replace(fragment, matrix=multiply(matrix, fragment.matrix))
            self.elements[position] = DrawnElement(outline, style, fragment, sources[index])

    def _carry(self, asset: Drawing, name: str, matrix: Matrix) -> str:
        """An effect inside an asset, in the space of one of its copies."""
        effect = asset.effects[name]
        key = f"{name} {matrix}"
        self.effects[key] = replace(effect, matrix=multiply(matrix, effect.matrix))
        return key


@dataclass(frozen=True, slots=True, eq=False)
class _Copies:
    """Copies of an outline in a style: their rows, their places among all elements, and their
    matrices (n, 6).
    """

    style: Style
    outline: Outline
    rows: Rows
    place: Rows
    matrices: Floats

    @property
    def numbers(self) -> int:
        """How many are to be placed."""
        return 8 * len(self.outline.kind) * len(self.rows)


def _parted(copies: _Copies) -> Iterator[_Copies]:
    """The copies in parts of a bounded size."""
    step = max(1, _BATCH // (8 * len(copies.outline.kind) + 1))
    for begin in range(0, len(copies.rows), step):
        rows = slice(begin, begin + step)
        yield replace(
            copies,
            rows=copies.rows[rows],
            place=copies.place[rows],
            matrices=copies.matrices[rows],
        )


def _batches(every: Sequence[_Copies]) -> Iterator[list[_Copies]]:
    """Copies that are placed together, so that memory stays bounded."""
    batch: list[_Copies] = []
    left = _BATCH
    for each in every:
        if batch and each.numbers > left:
            yield batch
            batch, left = [], _BATCH
        batch.append(each)
        left -= each.numbers
    if batch:
        yield batch


def _times(values: NDArray[_Number], count: int) -> NDArray[_Number]:
    """So many copies of rows, one after the other."""
    return values if count == 1 else np.tile(values, (count, *[1] * (values.ndim - 1)))


def _rows_of(assets: NDArray[np.integer], numbers: list[int]) -> dict[int, Rows]:
    """The rows of each asset, rising."""
    order = np.argsort(assets, kind="stable")
    first, after = (np.searchsorted(assets[order], numbers, side) for side in ("left", "right"))
    bounds = zip(numbers, first.tolist(), after.tolist(), strict=True)
    return {number: order[begin:end] for number, begin, end in bounds}


def _lines(coords: Floats, closed: bool) -> Outline:
    """Lines (m, 4, 2) one after the other."""
    kind, starts = np.full(len(coords), LINE, np.uint8), np.array([0, len(coords)], np.int32)
    return Outline(kind, coords, starts, np.array([closed]))


def _polygon(corners: Floats, flip: float) -> Outline:
    """A closed outline through corners (m, 2 or 3) of the model."""
    count = len(corners)
    coords = np.zeros((count, 4, 2))
    coords[:, 0, 0], coords[:, 0, 1] = corners[:, 0], flip - corners[:, 1]
    coords[:, 1] = np.roll(coords[:, 0], -1, axis=0)
    return _lines(coords, True)


def _path(points: Floats, flip: float) -> Outline:
    """The open lines through points (m, 2 or 3) of the model, rows of NaN between them."""
    flat = np.stack([points[:, 0], flip - points[:, 1]], axis=1)
    drawn = ~np.isnan(points[:-1, 0]) & ~np.isnan(points[1:, 0])
    coords = np.zeros((int(drawn.sum()), 4, 2))
    coords[:, 0], coords[:, 1] = flat[:-1][drawn], flat[1:][drawn]
    lifts = np.flatnonzero(np.isnan(points[:, 0]))
    parts = np.cumsum(drawn)[np.append(lifts, len(points) - 1) - 1]
    starts = np.concatenate([[0], parts]).astype(np.int32)
    return Outline(
        np.full(len(coords), LINE, np.uint8), coords, starts, np.zeros(len(parts), np.bool_)
    )
