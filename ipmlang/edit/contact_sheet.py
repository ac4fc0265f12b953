"""A page of drawings side by side, all in one scale, each with a caption under it.

In go drawings with captions, out comes one drawing. What leaves a drawing's own box is clipped, as
it is where that drawing stands alone. Nothing is derived and nothing is written here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from html import escape

import numpy as np

from ipmlang.formats.drawing import Drawing, DrawnElement, Effect, Floats, Fragment, Outline, Style
from ipmlang.formats.numbers import decimal_text
from ipmlang.formats.svg.bounds import transform_segments
from ipmlang.formats.svg.transforms import Matrix, multiply, translate
from ipmlang.formats.svg.write import Box, fitted_box
from ipmlang.runtime.export.drawn_assets import depends_on_frame, moved_style

GAP = 0.06  # between cells, as a share of their longer side
TEXT = 0.055  # height of a caption's line, as a share of the same
GLYPH = 0.62  # width of a letter as a share of its height, at most
SHAPE = 1.3  # width of a page over its height, at best
FRAME = "#dddddd"
INK, ALARM = "#444444", "#b3261e"


@dataclass(frozen=True, slots=True, eq=False)
class Cell:
    """A drawing and the lines under it; without a drawing they say why there is none."""

    drawing: Drawing | None
    caption: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Grid:
    """Where cells stand: so many columns, size of a cell's picture, height of its caption, gap."""

    columns: int
    rows: int
    width: float
    height: float
    line: float
    lines: int
    gap: float

    @property
    def box(self) -> Box:
        across = self.columns * (self.width + self.gap) + self.gap
        return (0.0, 0.0, across, self.rows * self.pitch + self.gap)

    @property
    def pitch(self) -> float:
        """From one row to the next."""
        return self.height + self.lines * self.line * 1.35 + self.gap

    def corner(self, number: int) -> tuple[float, float]:
        """The upper left corner of a cell's picture."""
        row, column = divmod(number, self.columns)
        return self.gap + column * (self.width + self.gap), self.gap + row * self.pitch


def contact_sheet(cells: Sequence[Cell], columns: int | None = None) -> Drawing:
    """All cells on one page, `columns` beside each other, or as many as make a good page.

    >>> page = contact_sheet([Cell(Drawing((), (0, 0, 10, 10)), ("seed 1",))] * 4)
    >>> len(page.elements), [round(side, 2) for side in page.box]
    (8, [0.0, 0.0, 21.8, 23.29])
    """
    boxes = [_box(cell.drawing) for cell in cells]
    grid = _grid(cells, [box for box in boxes if box is not None], columns)
    page = _Page(grid)
    for number, (cell, box) in enumerate(zip(cells, boxes, strict=True)):
        page.add(number, cell, box)
    return Drawing(tuple(page.elements), grid.box, effects=page.effects)


def _box(drawing: Drawing | None) -> Box | None:
    if drawing is None:
        return None
    return fitted_box(drawing.elements) if drawing.box is None else drawing.box


def _grid(cells: Sequence[Cell], boxes: Sequence[Box], columns: int | None) -> _Grid:
    width = max((box[2] for box in boxes), default=1.0)
    height = max((box[3] for box in boxes), default=1.0)
    side = max(width, height)
    lines = max((len(cell.caption) for cell in cells), default=0)
    longest = max((len(line) for cell in cells for line in cell.caption), default=1)
    line = min(TEXT * side, width / (GLYPH * max(longest, 1)))
    found = [
        _Grid(across, math.ceil(len(cells) / across), width, height, line, lines, GAP * side)
        for across in ([columns] if columns else range(1, len(cells) + 1))
    ]
    return min(found, key=lambda grid: _ugliness(grid, len(cells)))


def _ugliness(grid: _Grid, count: int) -> float:
    """How far a page is from a good shape, and how many of its places are empty."""
    _, _, width, height = grid.box
    return abs(math.log(width / height / SHAPE)) + (grid.columns * grid.rows - count) / count


@dataclass(slots=True)
class _Page:
    """The page while it is made."""

    grid: _Grid
    elements: list[DrawnElement] = field(default_factory=list)
    effects: dict[str, Effect] = field(default_factory=dict)

    def add(self, number: int, cell: Cell, box: Box | None) -> None:
        """One cell: its frame, its drawing in the middle, its caption."""
        left, top = self.grid.corner(number)
        self.elements.append(self._frame(left, top))
        if cell.drawing is not None and box is not None:
            across = left + (self.grid.width - box[2]) / 2 - box[0]
            down = top + (self.grid.height - box[3]) / 2 - box[1]
            self._draw(number, cell.drawing, box, translate(across, down))
        ink = ALARM if cell.drawing is None else INK
        for line, text in enumerate(cell.caption):
            at = top + self.grid.height + (line + 1) * self.grid.line * 1.3
            self.elements.append(_text(text, left, at, self.grid.line, ink))

    def _frame(self, left: float, top: float) -> DrawnElement:
        outline = _rectangle((left, top, self.grid.width, self.grid.height))
        width = self.grid.gap / 40
        return DrawnElement(outline, Style(fill="none", stroke=FRAME, stroke_width=width))

    def _draw(self, number: int, drawing: Drawing, box: Box, matrix: Matrix) -> None:
        """A drawing moved to its place, clipped if it reaches out of its box."""
        names = {name: f"{number} {name}" for name in drawing.effects}
        for name, effect in drawing.effects.items():
            self.effects[names[name]] = replace(effect, matrix=multiply(matrix, effect.matrix))
        outer: tuple[str, ...] = ()
        if _reaches_out(drawing, box):
            outer = (f"{number}",)
            self.effects[outer[0]] = _clip(number, box, matrix)
        styles: dict[int, Style] = {}
        coords = iter(_moved_coords(drawing, matrix))
        for element in drawing.elements:
            style = styles.get(id(element.style))
            if style is None:
                effects = outer + tuple(names[name] for name in element.style.effects)
                style = replace(_moved(element.style, matrix), effects=effects)
                styles[id(element.style)] = style
            outline, fragment = element.outline, element.fragment
            if outline is not None:
                outline = Outline(outline.kind, next(coords), outline.starts, outline.closed)
            if fragment is not None:
                fragment = replace(fragment, matrix=multiply(matrix, fragment.matrix))
            self.elements.append(DrawnElement(outline, style, fragment, element.source))


def _moved(style: Style, matrix: Matrix) -> Style:
    return moved_style(style, matrix) if depends_on_frame(style) else style


def _moved_coords(drawing: Drawing, matrix: Matrix) -> list[Floats]:
    """The coordinates of all outlines, moved at once."""
    outlines = [each.outline for each in drawing.elements if each.outline is not None]
    if not outlines:
        return []
    kind = np.concatenate([outline.kind for outline in outlines])
    coords = np.concatenate([outline.coords for outline in outlines])
    moved = transform_segments(kind, coords, np.array(matrix))
    ends = np.cumsum([len(outline.kind) for outline in outlines])
    return np.split(moved, ends[:-1])


def _reaches_out(drawing: Drawing, box: Box) -> bool:
    if drawing.box is None or not drawing.elements:
        return False
    x, y, width, height = fitted_box(drawing.elements)
    inside = x >= box[0] and y >= box[1]
    return not (inside and x + width <= box[0] + box[2] and y + height <= box[1] + box[3])


def _clip(number: int, box: Box, matrix: Matrix) -> Effect:
    """A group that shows no more than a box."""
    x, y, width, height = (decimal_text(value) for value in box)
    rectangle = f'<rect x="{x}" y="{y}" width="{width}" height="{height}"/>'
    xml = f'<clipPath id="cell{number}">{rectangle}</clipPath>'
    return Effect((("clip-path", f"url(#cell{number})"),), xml, matrix)


def _rectangle(box: Box) -> Outline:
    x, y, width, height = box
    corners = np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]])
    coords = np.zeros((4, 4, 2))
    coords[:, 0], coords[:, 1] = corners, np.roll(corners, -1, axis=0)
    kind, starts = np.ones(4, np.uint8), np.array([0, 4], np.int32)
    return Outline(kind, coords, starts, np.array([True]))


def _text(text: str, x: float, y: float, size: float, ink: str) -> DrawnElement:
    """A line of text whose left end stands at a place."""
    look = f'font-family="sans-serif" fill="{ink}"'
    xml = f'<text x="0" y="0" font-size="10" {look}>{escape(text)}</text>'
    scale = size / 10
    place = (scale, 0.0, 0.0, scale, x, y)
    return DrawnElement(None, Style(), Fragment("text", xml, place))
