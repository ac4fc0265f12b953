"""The operations that give a shape another geometry or another frame, by name.

In go a scope's geometry in its own coordinates, axes of the world there, and the operation's
arguments; out comes a solid and perhaps axes for the scope. What fills its scope has a columnar
body as well (`FAST`), which comes first; it gives None where it cannot serve. Nothing here knows
rules or children.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.ops import OPERATIONS
from ipmlang.compiler.ops.record import Param
from ipmlang.geometry.solid import BOX_TAGS, Floats, GeometryError, Solid, tagged
from ipmlang.runtime.algebra import cosine_and_sine
from ipmlang.runtime.code import Column
from ipmlang.runtime.primitives import unit
from ipmlang.runtime.scopes import boxes
from ipmlang.runtime.scopes.boxes import SIZES, State, full
from ipmlang.runtime.scopes.pool import BOX, Pool
from ipmlang.runtime.scopes.scope_bodies import TURNING
from ipmlang.runtime.scopes.tables import distinct

Value: TypeAlias = "float | str | None"
Flags = NDArray[np.bool_]
LARGEST = 1e100  # of arguments: squares and cubes of it are numbers still


@dataclass(frozen=True, slots=True, eq=False)
class Shaped:
    """A solid in the coordinates of the scope it was made in; `axes` (3, 3): the unit axes of its
    new scope as rows in those, None where the scope keeps its own.
    """

    solid: Solid
    axes: Floats | None = None


class Given:
    """The arguments of one use of an operation, for a batch of `count` shapes."""

    def __init__(
        self, program: ir.Program, pool: Pool, name: str, args: Sequence[Column], count: int
    ) -> None:
        self.program = program
        self.pool = pool
        self.name = name
        self.args = tuple(args)
        self.count = count
        self.world = WORLD.get(name, "")
        self.turns = name in TURNING
        self._params = _params(name, len(args))

    def resolved(self, values: Sequence[float]) -> list[Value]:
        """The arguments of one shape: texts instead of their numbers, None where not given."""
        return [self._one(*each) for each in zip(self._params, values, strict=True)]

    def _one(self, param: Param, value: float) -> Value:
        if not abs(value) < LARGEST:
            if param.optional and math.isnan(value):
                return None
            what = "too large a number" if math.isfinite(value) else "not a finite number"
            raise GeometryError(f"`{param.name}` of `{self.name}` is {what}")
        text = bool(param.words) or param.type == "string"
        return self._text(param, value) if text else value

    def _text(self, param: Param, value: float) -> str:
        found = self.program.strings[int(value)]
        if param.words and found not in param.words:
            known = ", ".join(param.words)
            message = f"`{param.name}` of `{self.name}` cannot be `{found}`"
            raise GeometryError(message, f"it is one of {known}")
        return found

    def word(self, place: int) -> str | None:
        """A text that is the same for all shapes; None where it is not given."""
        found = np.ravel(np.asarray(self.args[place], np.float64))
        if (found[1:] != found[:-1]).any() and not np.isnan(found).all():
            raise GeometryError(f"the words of `{self.name}` must be the same for all shapes")
        return None if np.isnan(found[0]) else self._text(self._params[place], float(found[0]))

    def texts(self) -> list[int]:
        """The places of arguments that are texts, and not the same for all shapes."""
        return [
            place
            for place, (param, arg) in enumerate(zip(self._params, self.args, strict=True))
            if (param.words or param.type == "string") and len(distinct(np.asarray(arg))[0]) > 1
        ]


def _params(name: str, count: int) -> tuple[Param, ...]:
    """The parameters of the form of an operation that has so many."""
    return next(form for form in OPERATIONS[name].forms if len(form) == count)


def _number(value: Value, default: float = 0.0) -> float:
    assert not isinstance(value, str)
    return default if value is None else value


# --------------------------------------------------------------------------- columnar bodies


def _boxes(given: Given, state: Mapping[str, Column]) -> Flags | None:
    """Whether all geometries fill their scopes; where each has no extent (3, count)."""
    if not np.all(given.pool.are_boxes(state["geo"])):
        return None
    sizes = np.broadcast_arrays(*(np.asarray(state[name]) for name in SIZES))
    return np.stack([np.asarray(each) <= 0 for each in sizes])


EXTRUDED = tuple(
    frozenset({f"extrude.{word if word in ('top', 'bottom') else 'side'}"}) for word in BOX_TAGS
)


def _extrude(given: Given, state: State) -> State | None:
    """A rectangle becomes a box."""
    flat = _boxes(given, state)
    along = given.word(1)
    if flat is None or not (flat[2] & ~flat[0] & ~flat[1]).all():
        return None
    if along not in (None, "normal", "z"):
        return None
    height = given.args[0]
    if not np.all(np.isfinite(height)) or np.any(np.asarray(height) == 0):
        return None
    below = np.minimum(height, 0.0)
    place = boxes.moved(state, (0.0, 0.0, below)) if np.any(below) else {}
    geometry = float(given.pool.box(EXTRUDED))
    return {**place, "sz": np.abs(height), "geo": geometry}


def _cube(given: Given, state: State) -> State:
    return {"geo": float(BOX)}


def _quad(given: Given, state: State) -> State:
    return {"geo": float(BOX), "sz": 0.0}


def _primitive(given: Given, state: State) -> State:
    sides = np.asarray(given.args[0] if given.args else SIDES[given.name], np.float64)
    kinds, place = distinct(sides)
    found = np.array([_unit_primitive(given, each) for each in kinds.tolist()], np.float64)
    own = found[place.reshape(sides.shape)]
    flat = {"sz": 0.0} if given.name == "disk" else {}
    return {"geo": own if own.ndim else float(own), **flat}


def _unit_primitive(given: Given, sides: float) -> int:
    """The number of a primitive with so many sides."""
    from ipmlang.geometry import primitives

    if not (3 <= sides <= MOST_SIDES and sides == round(sides)):
        raise GeometryError(
            f"`{given.name}` cannot have {sides:g} sides",
            f"give a whole number from 3 to {MOST_SIDES:,}",
        )
    make: Callable[[int], Solid] = getattr(primitives, given.name)
    key, count = (given.name, int(sides)), int(sides)
    found = given.pool.derived(key, lambda: given.pool.add(make(count))[0])
    assert isinstance(found, int)
    return found


MOST_SIDES = 1000
SIDES = {"cylinder": 24, "cone": 24, "sphere": 16, "disk": 24}


def _mirror(given: Given, state: State) -> State:
    return boxes.mirrored(state, "xyz".index(str(given.word(0))))


def _insert(given: Given, state: State) -> State:
    """An asset takes the place of the geometry, stretched to the scope or fitted into it."""
    asset = distinct(np.asarray(given.args[0]))[0]
    parts = [_inserted(given, state, int(each)) for each in asset.tolist()]
    if len(parts) == 1:
        return parts[0]
    own = full(given.args[0], given.count)
    names = parts[0].keys()
    return {
        name: np.select(
            [own == each for each in asset], [full(part[name], given.count) for part in parts]
        )
        for name in names
    }


def _inserted(given: Given, state: State, asset: int) -> State:
    low, high = given.pool.asset_bounds(asset)
    natural = high - low
    fit = given.word(1) or "scope"
    keep = np.nan_to_num(full(given.args[2], given.count)) != 0
    align = given.word(3) or ("corner" if fit == "none" else "middle")
    scope = [full(state[name], given.count) for name in SIZES]
    # an axis along which either has no extent says nothing of how much the asset is scaled
    factors = [
        np.where((size > 0) & (own > 0), size / (own or 1.0), np.nan)
        for size, own in zip(scope, natural.tolist(), strict=True)
    ]
    known = np.stack(factors)
    one = np.where(np.isnan(known), np.inf, known).min(axis=0)
    one = np.where(np.isfinite(one) & (fit != "none"), one, 1.0)
    if fit in ("none", "inside"):
        keep = np.ones(given.count, np.bool_)
    sizes = [
        np.where(keep | np.isnan(factor), own * one, size)
        for factor, own, size in zip(factors, natural.tolist(), scope, strict=True)
    ]
    share = SHARES[align]
    x, y, z = (
        np.where(size > 0, (size - own) * part, 0.0)
        for size, own, part in zip(scope, sizes, share, strict=True)
    )
    place = boxes.moved(state, (x, y, z))
    number = float(given.pool.asset(asset))
    return {**place, **dict(zip(SIZES, sizes, strict=True)), "geo": number}


def _tag(given: Given, state: State) -> State | None:
    """Tags on the faces: the geometry is another one, the scope stays."""
    word = given.word(0)
    numbers = np.asarray(state["geo"])
    kinds, place = distinct(numbers)
    flat = _boxes(given, state)
    if flat is None or word is None:
        return None
    solid = ~flat.any(axis=0)
    made = np.zeros((2, len(kinds)))
    for column, number in enumerate(kinds.astype(int).tolist()):
        for kind, faces in enumerate((1, 6)):
            tags = given.pool.tags(number) or (frozenset[str](),) * faces
            if len(tags) != faces:
                tags = (frozenset.intersection(*tags),) * faces
            made[kind, column] = given.pool.box(tuple(each | {word} for each in tags))
    found = made[np.broadcast_to(solid, numbers.shape or solid.shape).astype(int),
                 place.reshape(numbers.shape)]  # fmt: skip
    return {"geo": found if found.ndim else float(found)}


def _rotate(given: Given, state: State) -> State:
    """The scope turned about the middle of its bottom, of its box or of its top."""
    share = SHARES[str(given.word(3))]
    center = tuple(state[name] * part for name, part in zip(SIZES, share, strict=True))
    found = {**state, **boxes.moved(state, center)}  # type: ignore[arg-type]
    for axis, angle in enumerate(given.args[:3]):
        turn: list[Column] = [0.0, 0.0, 0.0, 0.0]
        turn[0], turn[axis + 1] = unit(np.asarray(angle) * 0.5)
        found.update(boxes.turned(found, tuple(turn)))
    found.update(boxes.moved(found, tuple(-each for each in center)))  # type: ignore[arg-type]
    return found


SHARES = {"corner": (0.0, 0.0, 0.0), "bottom": (0.5, 0.5, 0.0),
          "middle": (0.5, 0.5, 0.5), "top": (0.5, 0.5, 1.0)}  # fmt: skip
FAST: Mapping[str, Callable[[Given, State], State | None]] = {
    "extrude": _extrude,
    "cube": _cube,
    "quad": _quad,
    "cylinder": _primitive,
    "cone": _primitive,
    "sphere": _primitive,
    "disk": _primitive,
    "mirrorScope": _mirror,
    "rotate": _rotate,
    "insert": _insert,
    "tag": _tag,
}


# -------------------------------------------------------------------- bodies of one geometry


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


WORLD = {"extrude": "z", "alignScopeToAxes": "xyz"}  # the world's axes that a body must know
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
