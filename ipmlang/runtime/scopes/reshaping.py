"""The operations that give a shape another geometry or another frame, on solids, by name.

In go geometries in the coordinates of their scopes, axes of the world there, and the operation's
arguments; out come solids and perhaps axes for the scopes. Some bodies work on many solids at once
(`TOGETHER`); they leave out those that take more care. Nothing here knows rules or children.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ipmlang.geometry.solid import Floats, GeometryError, Solid, tagged
from ipmlang.runtime.algebra import cosine_and_sine
from ipmlang.runtime.scopes.shaping import Value


@dataclass(frozen=True, slots=True, eq=False)
class Shaped:
    """A solid in the coordinates of the scope it was made in; `axes` (3, 3): the unit axes of its
    new scope as rows in those, None where the scope keeps its own.
    """

    solid: Solid
    axes: Floats | None = None


def _number(value: Value, default: float = 0.0) -> float:
    assert not isinstance(value, str)
    return default if value is None else value


def _one_extrude(solid: Solid, world: Floats, height: Value, along: Value = None) -> Shaped:
    from ipmlang.geometry.raising import extrude

    fixed = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
    direction = None
    if along == "up":
        direction = world
    elif isinstance(along, str) and along in fixed:
        direction = np.array(fixed[along])
    return Shaped(extrude(solid, _number(height), direction))


def _one_taper(solid: Solid, world: Floats, height: Value, inset: Value = None) -> Shaped:
    from ipmlang.geometry.raising import taper

    return Shaped(taper(solid, _number(height), None if inset is None else _number(inset)))


def _roof(name: str) -> Callable[..., Shaped]:
    def body(solid: Solid, world: Floats, angle: Value, overhang: Value, ridge: Value) -> Shaped:
        from ipmlang.geometry import roofs

        make = getattr(roofs, name)
        more = {} if ridge is None or name == "roof_hip" else {"ridge": _number(ridge)}
        return Shaped(make(solid, _number(angle), overhang=_number(overhang), **more))

    return body


def _one_pyramid(solid: Solid, world: Floats, height: Value) -> Shaped:
    from ipmlang.geometry.roofs import roof_pyramid

    return Shaped(roof_pyramid(solid, _number(height)))


def _one_mansard(
    solid: Solid, world: Floats, lower: Value, height: Value, upper: Value, overhang: Value
) -> Shaped:
    from ipmlang.geometry.roofs import roof_mansard

    numbers = (_number(lower), _number(height), _number(upper))
    return Shaped(roof_mansard(solid, *numbers, overhang=_number(overhang)))


def _one_envelope(
    solid: Solid, world: Floats, height: Value, front: Value, side: Value, back: Value, angle: Value
) -> Shaped:
    from ipmlang.geometry.envelope import envelope

    given = {"front": front, "side": side, "back": back, "angle": angle}
    known = {name: _number(value) for name, value in given.items() if value is not None}
    return Shaped(envelope(solid, _number(height), **known))


def _one_offset(solid: Solid, world: Floats, distance: Value) -> Shaped:
    from ipmlang.geometry.setbacks import offset

    return Shaped(_only(offset(solid, _number(distance)), "inside", "offset"))


def _one_inner(solid: Solid, world: Floats) -> Shaped:
    from ipmlang.geometry.rectangles import inner_rect

    return Shaped(_only(inner_rect(solid), "shape", "innerRect"))


def _only(pieces: Sequence[object], word: str, name: str) -> Solid:
    from ipmlang.geometry.pieces import Piece
    from ipmlang.geometry.solid import joined

    chosen = [each.solid for each in pieces if isinstance(each, Piece) and word in each.words]
    if not chosen:
        raise GeometryError(f"`{name}` leaves nothing of this polygon")
    return chosen[0] if len(chosen) == 1 else joined(chosen)


def _one_tag(solid: Solid, world: Floats, word: Value) -> Shaped:
    return Shaped(tagged(solid, str(word)))


def _one_reversed(solid: Solid, world: Floats) -> Shaped:
    from ipmlang.geometry.converting import reversed_normals

    return Shaped(reversed_normals(solid))


def _one_converted(solid: Solid, world: Floats, to: Value) -> Shaped:
    from ipmlang.geometry.converting import converted

    return Shaped(converted(solid, str(to)))


def _one_turned(solid: Solid, world: Floats, x: Value, y: Value, z: Value) -> Shaped:
    axes = np.eye(3)
    for axis, angle in enumerate((x, y, z)):
        cosine, sine = cosine_and_sine(_number(angle))
        turn = np.eye(3)
        second, third = (axis + 1) % 3, (axis + 2) % 3
        turn[second, [second, third]] = cosine, sine
        turn[third, [second, third]] = -sine, cosine
        axes = turn @ axes
    return Shaped(solid, axes)


def _one_to_axes(solid: Solid, world: Floats, *rest: Value) -> Shaped:
    axes = world.reshape(3, 3)
    axis = rest[0] if rest else None
    if axis is None:
        return Shaped(solid, axes)
    number = "xyz".index(str(axis))
    return Shaped(solid, _aligned(number, axes[number]))


def _aligned(axis: int, target: Floats) -> Floats:
    """Axes of which one is the target, and the next as near to what it was as can be."""
    other = np.eye(3)[(axis + 1) % 3]
    side = other - target * (other @ target)
    if np.linalg.norm(side) < 1e-9:
        side = np.eye(3)[(axis + 2) % 3] - target * target[(axis + 2) % 3]
    side /= np.linalg.norm(side)
    axes = np.zeros((3, 3))
    axes[axis], axes[(axis + 1) % 3] = target, side
    axes[(axis + 2) % 3] = np.cross(target, side)
    return axes


def _one_to_geometry(solid: Solid, world: Floats, *rest: Value) -> Shaped:
    from ipmlang.geometry.aligning import alignment

    return Shaped(solid, alignment(solid, str(rest[0]) if rest and rest[0] else "lowest"))


SHAPES: Mapping[str, Callable[..., Shaped]] = {
    "extrude": _one_extrude,
    "taper": _one_taper,
    "roofHip": _roof("roof_hip"),
    "roofGable": _roof("roof_gable"),
    "roofShed": _roof("roof_shed"),
    "roofPyramid": _one_pyramid,
    "roofMansard": _one_mansard,
    "envelope": _one_envelope,
    "offset": _one_offset,
    "innerRect": _one_inner,
    "tag": _one_tag,
    "reverseNormals": _one_reversed,
    "convert": _one_converted,
    "rotateScope": _one_turned,
    "alignScopeToAxes": _one_to_axes,
    "alignScopeToGeometry": _one_to_geometry,
}


# ------------------------------------------------------------------ many geometries together

Values: TypeAlias = Sequence[Sequence[Value]]


def shaped(name: str, solids: Sequence[Solid], ways: Floats, values: Values) -> list[Shaped]:
    """What an operation makes of each of many solids (n), each with axes of the world in a row of
    `ways` and arguments of its own.
    """
    body, together = SHAPES[name], TOGETHER.get(name)
    known = together(solids, ways, values) if together and solids else [None] * len(solids)
    return [
        body(solid, way, *own) if made is None else Shaped(made)
        for solid, way, own, made in zip(solids, ways, values, known, strict=True)
    ]


def _extrudes(solids: Sequence[Solid], ways: Floats, values: Values) -> list[Solid | None]:
    from ipmlang.geometry.raising import extrusions

    heights = np.array([_number(each[0]) for each in values])
    along = {each[1] if len(each) > 1 else None for each in values}
    if along == {"up"}:
        return extrusions(solids, heights, ways)
    return extrusions(solids, heights) if along == {None} else [None] * len(solids)


def _roofs(*, gabled: bool) -> Callable[[Sequence[Solid], Floats, Values], list[Solid | None]]:
    def body(solids: Sequence[Solid], ways: Floats, values: Values) -> list[Solid | None]:
        from ipmlang.geometry.roofs_together import roofs

        degrees, overhang, ridge = np.array(values, np.float64).T  # None becomes NaN
        overhang = np.where(np.isnan(overhang), 0.0, overhang)
        return roofs(solids, degrees, overhang, ridge, gabled=gabled)

    return body


TOGETHER: Mapping[str, Callable[[Sequence[Solid], Floats, Values], list[Solid | None]]] = {
    "extrude": _extrudes,
    "roofHip": _roofs(gabled=False),
    "roofGable": _roofs(gabled=True),
}
