"""What a 2-D drawing is, free of any file format: outlines, styles, elements in paint order.

Readers make these, writers and inference take them. Coordinates are those of the file's outermost
user space (the root viewBox), y downward as in SVG, every transform already applied. Nothing here
reads, writes or derives.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]

LINE, QUADRATIC, CUBIC, ARC = 1, 2, 3, 4


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """Curves of one element.

    kind: (n,) uint8, LINE, QUADRATIC, CUBIC or ARC.
    coords: (n, 4, 2) f64. LINE uses points 0-1, QUADRATIC 0-2, CUBIC 0-3 (the rest is zero). ARC is
        (centre, u, v, (start, sweep)): point(t) = centre + u cos(a) + v sin(a) with
        a = start + sweep t in radians, so that any affine map acts on centre, u and v alone.
    starts: (s + 1,) int32, segment offsets of the s subpaths.
    closed: (s,) bool, subpath ends with a closing command (its closing line is a segment of its own
        unless the subpath already ended where it began).
    """

    kind: NDArray[np.uint8]
    coords: Floats
    starts: NDArray[np.int32]
    closed: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class PaintServer:
    """A gradient or pattern as paint: its definition as XML and the map from its space to world.

    `xml` is canonical and self-contained: gradientUnits/patternUnits userSpaceOnUse, hrefs
    resolved, no id, no transform attribute. `matrix` is (a, b, c, d, e, f).
    """

    kind: str
    xml: str
    matrix: tuple[float, float, float, float, float, float]


Paint: TypeAlias = "str | PaintServer"


@dataclass(frozen=True, slots=True)
class Style:
    """Resolved presentation of one element, hashable.

    fill, stroke: `none`, `#rrggbb`, or a paint server. stroke_width, dashes and dash offset are in
    world units (scaled by the square root of |det| of the element's matrix). `more` holds every
    other property that differs from SVG's initial value, sorted: (("fill-rule", "evenodd"), …).
    stroke_matrix: None, or (a, b, c, d) when the pen is an ellipse (stroke under a non-similar
    transform): the linear part of the element's matrix divided by the square root of |det|.
    effects: keys into Drawing.effects, outermost first.
    """

    fill: Paint = "#000000"
    stroke: Paint = "none"
    stroke_width: float = 1.0
    dashes: tuple[float, ...] = ()
    dash_offset: float = 0.0
    more: tuple[tuple[str, str], ...] = ()
    stroke_matrix: tuple[float, float, float, float] | None = None
    effects: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Fragment:
    """Text, a raster image or foreign content that is carried through: self-contained XML (what it
    refers to included) that `matrix` (a, b, c, d, e, f) maps from its own space to the world.
    """

    kind: str
    xml: str
    matrix: tuple[float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class Effect:
    """A group effect (opacity, clip-path, mask, filter, blend mode) that wraps a run of elements.

    `attributes` are the presentation attributes of the group, `definitions` the self-contained XML
    of what they refer to (ids as in the attributes), `matrix` the group's own space to the world.
    """

    attributes: tuple[tuple[str, str], ...]
    definitions: str
    matrix: tuple[float, float, float, float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class DrawnElement:
    """One drawn thing: an outline with its style, or a fragment. `source` is the id and class of
    the element and the ids of its groups, outermost first, hints for names: ("forest", "leaf").
    space: (a, b, c, d) of the map from the numbers that a file gave the outline in, a hint for
    whoever writes it again; None where these are the drawing's own.
    """

    outline: Outline | None
    style: Style
    fragment: Fragment | None = None
    source: tuple[str, ...] = ()
    space: tuple[float, float, float, float] | None = None


@dataclass(frozen=True, slots=True)
class Note:
    """Something the reader wants said: a kebab-case code, a sentence, how often it happened."""

    code: str
    message: str
    count: int = 1
    line: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Drawing:
    """A whole drawing. `box` is the viewBox (x, y, width, height), None if neither it nor a size
    was given; width and height are the root's attributes as written.
    """

    elements: tuple[DrawnElement, ...]
    box: tuple[float, float, float, float] | None = None
    width: str | None = None
    height: str | None = None
    effects: Mapping[str, Effect] = field(default_factory=dict)
    notes: tuple[Note, ...] = ()
    source_bytes: int = 0
