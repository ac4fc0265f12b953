"""What was seen in a drawing, free of file formats: elements as placed copies of shape classes.

`observe` takes a drawing and gives columns over its elements in paint order: which class, in which
frame, with which style, and the classes themselves with their symmetry groups. Coordinates are
those of the model, y up. Nothing here looks for patterns or writes grammars.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import Drawing, Floats, Fragment, Outline, Style
from ipmlang.inverse.lsystem.curves import Curves, diagonal_of, evaluate, stack
from ipmlang.inverse.lsystem.elements import Found, Kind, group_elements
from ipmlang.inverse.lsystem.frames import Frames, identity, join
from ipmlang.inverse.lsystem.resemblance import merge_similar
from ipmlang.inverse.lsystem.rewriting import merge_rewritten
from ipmlang.inverse.lsystem.symmetry import Symmetry, trivial

TOLERANCE = 2e-7  # of the diagonal: what instancing may move a point by, see `observe`


@dataclass(frozen=True, slots=True, eq=False)
class ShapeClass:
    """Elements of one shape, whatever their position, turn, scale and handedness.

    kind: "line" (one straight segment; a class holds one length and all scales are 1), "ellipse" (a
        full one, circles too), "path", "point" (everything in one place), "fragment".
    outline: the representative, y up, about its own origin; None for fragments. Its origin is the
        start of a line (which runs along +x), the centre of a full ellipse (long axis along x),
        else the mean of points evenly spread over the segments, which every symmetry keeps (rounded
        to the input's decimals where no symmetry fixes it). It is
        turned and sized like the first member that has the most frequent scale, so most frames are
        plain.
    fragment: the fragment of kind "fragment", as in the drawing (y down, its own matrix).
    symmetry: the frames that map the representative onto itself, see `Symmetry`.
    radius: largest distance of the representative from its origin, in units.
    members: (k,) rows of the elements, in paint order.
    directed: start and direction are visible (dashes), so they are kept.
    """

    kind: Kind
    outline: Outline | None
    fragment: Fragment | None
    symmetry: Symmetry
    radius: float
    members: NDArray[np.int64]
    directed: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """n elements in paint order, as columns, with what they refer to.

    shape: (n,) int32 into classes; frames: n rows, world = frame(representative), simplest of the
    equivalent ones (see `alternatives` in `symmetry` for the others; a fragment's frame is the
    identity); style: (n,) int32 into styles, independent of shape; z: (n,) int64 paint order, row
    numbers; error: (n,) f64 largest distance between the placed representative and the element,
    units; sources: n name hints, outermost first (group effects are in the styles).

    box: (x, y, width, height), the same numbers as the viewBox, None if there is none; flip: c of
    y_model = c - y_svg; diagonal: of the box, else of what is drawn, never 0; precision: decimals
    that write every coordinate of the input exactly, 17 if there is no such number below 10;
    tolerance: units, the bound on `error` unless similar shapes were asked for; drawing: what was
    read; decimals: to which its points are rounded once they are drawn, None where they are not;
    shift: by row, how far some elements are from where rules have them before that, x + iy.
    """

    shape: NDArray[np.int32]
    frames: Frames
    style: NDArray[np.int32]
    z: NDArray[np.int64]
    error: Floats
    sources: tuple[tuple[str, ...], ...]
    classes: tuple[ShapeClass, ...]
    styles: tuple[Style, ...]
    box: tuple[float, float, float, float] | None
    flip: float
    diagonal: float
    precision: int
    tolerance: float
    drawing: Drawing
    decimals: int | None = None
    shift: Mapping[int, complex] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.shape)


def observe(drawing: Drawing, tolerance: float = TOLERANCE, similarity: float = 1.0) -> Observation:
    """The drawing as placed copies of shape classes.

    tolerance: share of the diagonal that a placed representative may be off its element. The
    default leaves most of the promised 1e-6 to what is built on the classes.
    similarity: 1 makes elements one class only within the tolerance; less (the paper uses 0.6) also
    where they are so similar, see `lsystem.similarity`, and `error` says how far off they are.

    >>> observe(Drawing(())).precision
    0
    """
    flip = 0.0 if drawing.box is None else 2 * drawing.box[1] + drawing.box[3]
    drawn = [row for row, element in enumerate(drawing.elements) if element.outline is not None]
    outlines = [element.outline for element in drawing.elements if element.outline is not None]
    curves = stack(outlines, flip)
    diagonal = diagonal_of(drawing.box, curves)
    style, styles = _styles(drawing)
    dashed = np.array([bool(each.dashes) for each in styles], np.bool_)[style]
    decimals = _precision(curves)
    found = group_elements(outlines, curves, dashed[drawn], tolerance * diagonal, decimals)
    found = merge_rewritten(found, tolerance * diagonal)
    if similarity < 1:
        found = merge_similar(found, similarity)
    rows = np.array(drawn, np.int64)
    classes = _fragments(drawing) + [_class(each, rows) for each in found]
    classes.sort(key=lambda each: int(each[0].members[0]))
    shape, placed, error = _columns(len(drawing.elements), classes)
    return Observation(
        shape=shape,
        frames=placed,
        style=style,
        z=np.arange(len(drawing.elements)),
        error=error,
        sources=tuple(element.source for element in drawing.elements),
        classes=tuple(each for each, _, _ in classes),
        styles=styles,
        box=drawing.box,
        flip=flip,
        diagonal=diagonal,
        precision=decimals,
        tolerance=tolerance * diagonal,
        drawing=drawing,
    )


Placed: TypeAlias = tuple[ShapeClass, Frames, Floats]


def _class(found: Found, drawn: NDArray[np.int64]) -> Placed:
    members = drawn[found.members]
    made = ShapeClass(
        found.kind, found.outline, None, found.symmetry, found.radius, members, found.directed
    )
    return made, found.frames, found.error


def _fragments(drawing: Drawing) -> list[Placed]:
    made = []
    for row, element in enumerate(drawing.elements):
        if element.outline is None:
            alone = np.array([row], np.int64)
            shape = ShapeClass("fragment", None, element.fragment, trivial(), 0.0, alone)
            made.append((shape, identity(1), np.zeros(1)))
    return made


def _columns(count: int, classes: Sequence[Placed]) -> tuple[NDArray[np.int32], Frames, Floats]:
    """Classes with their members' frames and errors as columns in paint order."""
    order = np.zeros(0, np.int64)
    if classes:
        order = np.argsort(np.concatenate([each.members for each, _, _ in classes]))
    sizes = [len(each.members) for each, _, _ in classes]
    shape = np.repeat(np.arange(len(classes), dtype=np.int32), sizes)
    placed = join([frames for _, frames, _ in classes])
    error = np.concatenate([np.zeros(0), *(error for _, _, error in classes)])
    assert len(order) == count
    return shape[order], placed[order], error[order]


def _styles(drawing: Drawing) -> tuple[NDArray[np.int32], tuple[Style, ...]]:
    """Style numbers (n,) and the different styles in the order of their first use."""
    known: dict[Style, int] = {}
    numbers = [known.setdefault(element.style, len(known)) for element in drawing.elements]
    return np.array(numbers, np.int32), tuple(known)


def _precision(curves: Curves) -> int:
    """Decimals that write the ends of all segments, or 17.

    Sums of written steps miss their decimals by some units in the last place, so that is allowed.
    """
    ends = evaluate(curves.kind, curves.points, np.array([0.0, 1.0])).ravel()
    numbers = np.unique(np.abs(np.concatenate([ends.real, ends.imag])))
    for decimals in range(10):
        scaled = numbers * 10.0**decimals
        if (np.abs(scaled - np.round(scaled)) <= 1e-5 + 1e-13 * scaled).all():
            return decimals
    return 17
