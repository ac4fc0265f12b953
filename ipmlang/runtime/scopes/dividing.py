"""The bodies of the operations that take one geometry apart, by name.

In go a solid in the coordinates of its scope, the scope's extents and the operation's arguments;
out come pieces. Some bodies work on many solids at once (`TOGETHER`), which is what towns of lots
that all differ need; they leave out those that take more care. Rows and keys are not known here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from ipmlang.geometry.pieces import Piece
from ipmlang.geometry.solid import Floats, GeometryError, Solid
from ipmlang.runtime.scopes.shaping import Value


def _comp(solid: Solid, size: Floats, of: Value = None) -> list[Piece]:
    from ipmlang.geometry import parts

    match of:
        case "edges":
            return parts.edges(solid)
        case "vertices":
            return parts.vertices(solid)
        case _:
            return parts.faces(solid)


def _setback(
    solid: Solid,
    size: Floats,
    distance: Value,
    front: Value,
    side: Value,
    back: Value,
    area: Value,
) -> list[Piece]:
    from ipmlang.geometry.setbacks import setback

    if area is not None and distance == 0 and front is side is back is None:
        distance = 1.0  # the area says how far; all edges move alike
    return setback(solid, _given(distance), front=_maybe(front), side=_maybe(side),
                   back=_maybe(back), area=_maybe(area))  # fmt: skip


def _offset(solid: Solid, size: Floats, distance: Value) -> list[Piece]:
    from ipmlang.geometry.setbacks import offset

    return offset(solid, _given(distance))


def _inner_rect(solid: Solid, size: Floats) -> list[Piece]:
    from ipmlang.geometry.rectangles import inner_rect

    return inner_rect(solid)


def _arms(name: str) -> Callable[..., list[Piece]]:
    def body(solid: Solid, size: Floats, *widths: Value) -> list[Piece]:
        from ipmlang.geometry import arms

        make: Callable[..., list[Piece]] = getattr(arms, name)
        return make(solid, *(_given(each) for each in widths))

    return body


def _octant(solid: Solid, size: Floats, x: Value, y: Value, z: Value, octant: Value) -> list[Piece]:
    """q = 1 + [x > vx] + 2 [y > vy] + 4 [z > vz]."""
    number = int(_given(octant))
    if not 1 <= number <= 8:
        raise GeometryError(f"there is no octant {number}", "octants are numbered 1 to 8")
    bits = number - 1
    spans = []
    for axis, point in enumerate((x, y, z)):
        at = float(np.clip(_given(point), 0.0, size[axis]))
        spans.append((at, float(size[axis])) if bits >> axis & 1 else (0.0, at))
    return list(_cells(solid, size, [spans]))


def _subdivide(solid: Solid, size: Floats, nx: Value, ny: Value, nz: Value) -> list[Piece]:
    counts = cell_counts(size, (nx, ny, nz))
    edges = [np.linspace(0.0, size[axis], count + 1) for axis, count in enumerate(counts)]
    spans = [
        [tuple(edges[axis][place : place + 2]) for axis, place in enumerate((i, j, k))]
        for k in range(counts[2])
        for j in range(counts[1])
        for i in range(counts[0])
    ]
    return list(_cells(solid, size, spans))


def cell_counts(size: Floats, args: Sequence[Value]) -> list[int]:
    """How many cells there are along each axis: one where there is no extent."""
    counts = [max(int(_given(each)), 1) for each in args]
    return [count if size[axis] > 0 else 1 for axis, count in enumerate(counts)]


def _cells(
    solid: Solid, size: Floats, spans: Sequence[Sequence[tuple[float, float]]]
) -> Iterator[Piece]:
    """The parts of a geometry in boxes of its scope."""
    from ipmlang.geometry.slabs import slab

    for box in spans:
        part: Solid | None = solid
        for axis, (low, high) in enumerate(box):
            if size[axis] <= 0 or (low <= 0 and high >= size[axis]):
                continue
            if high - low <= 1e-9 * size[axis] or part is None:
                part = None
                break
            part = slab(part, axis, low, high)
        if part is not None and len(part):
            yield Piece(frozenset({"all"}), part)


def _given(value: Value) -> float:
    assert isinstance(value, float)
    return value


def _maybe(value: Value) -> float | None:
    return None if value is None else _given(value)


APART: Mapping[str, Callable[..., list[Piece]]] = {
    "comp": _comp,
    "setback": _setback,
    "offset": _offset,
    "innerRect": _inner_rect,
    "shapeL": _arms("shape_l"),
    "shapeU": _arms("shape_u"),
    "shapeO": _arms("shape_o"),
    "octant": _octant,
    "subdivide": _subdivide,
}


# ------------------------------------------------------------------ many geometries together


def parts_of(
    name: str, solids: Sequence[Solid], sizes: Floats, values: Sequence[Sequence[Value]]
) -> list[list[Piece]]:
    """The pieces of each of many solids (n), in scopes of these extents (n, 3), each with arguments
    of its own.
    """
    if not solids:
        return []
    body, together = APART[name], TOGETHER.get(name)
    known = together(solids, values) if together else [None] * len(solids)
    return [
        body(solid, size, *own) if made is None else made
        for solid, size, own, made in zip(solids, sizes, values, known, strict=True)
    ]


def _comps(
    solids: Sequence[Solid], values: Sequence[Sequence[Value]]
) -> Sequence[list[Piece] | None]:
    from ipmlang.geometry import parts

    kinds = {each[0] if each else None for each in values}
    if kinds <= {None, "faces"}:
        return parts.faces_of(solids)
    return parts.edges_of(solids) if kinds == {"edges"} else [None] * len(solids)


def _setbacks(
    solids: Sequence[Solid], values: Sequence[Sequence[Value]]
) -> Sequence[list[Piece] | None]:
    from ipmlang.geometry.setbacks_together import setbacks

    if any(area is not None for *_, area in values):
        return [None] * len(solids)
    widths = np.array([row[:4] for row in values], np.float64)  # None becomes NaN
    return setbacks(solids, widths)


TOGETHER: Mapping[
    str,
    Callable[[Sequence[Solid], Sequence[Sequence[Value]]], Sequence[list[Piece] | None]],
] = {"comp": _comps, "setback": _setbacks}
