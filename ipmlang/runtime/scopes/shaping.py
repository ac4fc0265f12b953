"""The operations that give shapes another geometry or another frame, as columns, by name.

In go the scopes of a batch and an operation's arguments; out come the columns that it changes.
These bodies (`FAST`) come first and serve what fills its scope; they give None where they cannot,
and `reshaping` works on each geometry by itself. Nothing here knows rules or children.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache as remember
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.ops import OPERATIONS
from ipmlang.compiler.ops.record import NOT_GIVEN, Param
from ipmlang.geometry.solid import BOX_TAGS, GeometryError, Solid
from ipmlang.runtime.code import Column
from ipmlang.runtime.primitives import unit
from ipmlang.runtime.scopes import boxes
from ipmlang.runtime.scopes.boxes import SIZES, State, full
from ipmlang.runtime.scopes.pool import BOX, Pool
from ipmlang.runtime.scopes.scope_bodies import TURNING
from ipmlang.runtime.scopes.tables import distinct

Value: TypeAlias = "float | str | None"
Flags = NDArray[np.bool_]
WORLD = {"extrude": "z", "alignScopeToAxes": "xyz"}  # the world's axes that a body must know
LARGEST = 1e100  # of arguments: squares and cubes of it are numbers still


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
            if param.optional and value == NOT_GIVEN:
                return None
            what = "too large a number" if math.isfinite(value) else "not a finite number"
            raise GeometryError(f"`{param.name}` of `{self.name}` is {what}")
        return self._text(param, value) if _is_text(param) else value

    def _text(self, param: Param, value: float) -> str:
        found = self.program.strings[int(value)]
        if param.words and found not in param.words:
            known = ", ".join(param.words)
            message = f"`{param.name}` of `{self.name}` cannot be `{found}`"
            raise GeometryError(message, f"it is one of {known}")
        return found

    def word(self, place: int) -> str | None:
        """A text that is the same for all shapes; None where it is not given."""
        given = self.args[place]
        if isinstance(given, float):
            return None if given == NOT_GIVEN else self._text(self._params[place], given)
        found = np.ravel(np.asarray(given, np.float64))
        if (found[1:] != found[:-1]).any():
            raise GeometryError(f"the words of `{self.name}` must be the same for all shapes")
        return None if found[0] == NOT_GIVEN else self._text(self._params[place], float(found[0]))

    def texts(self) -> list[int]:
        """The places of arguments that are texts, and not the same for all shapes."""
        return [
            place
            for place, (param, arg) in enumerate(zip(self._params, self.args, strict=True))
            if isinstance(arg, np.ndarray)
            and _is_text(param)
            and arg.size > 1
            and len(distinct(np.asarray(arg))[0]) > 1
        ]


def _is_text(param: Param) -> bool:
    return bool(param.words) or param.type == "string"


@remember
def _params(name: str, count: int) -> tuple[Param, ...]:
    """The parameters of the form of an operation that has so many."""
    return next(form for form in OPERATIONS[name].forms if len(form) == count)


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
    if isinstance(given.args[0], float):
        return _inserted(given, state, int(given.args[0]))
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
    natural = (high - low)[:, None]
    fit = given.word(1) or "scope"
    align = given.word(3) or ("corner" if fit == "none" else "middle")
    extents = tuple(state[name] for name in SIZES)
    same = all(isinstance(each, float) for each in (*extents, given.args[2]))
    if same and fit == "scope" and given.args[2] in (0.0, NOT_GIVEN):
        own = _filled(given.pool, asset, natural[:, 0], cast("tuple[float, ...]", extents))
        if own is not None:
            return {**{axis: state[axis] for axis in boxes.AXES}, **own}
    count = 1 if same else given.count
    kept = full(given.args[2], count)
    keep = (kept != 0) & (kept != NOT_GIVEN) | (fit in ("none", "inside"))
    scope = np.stack([full(each, count) for each in extents])
    # an axis along which either has no extent says nothing of how much the asset is scaled
    there = (scope > 0) & (natural > 0)
    factors = np.where(there, scope / np.where(natural == 0, 1.0, natural), np.inf)
    one = factors.min(axis=0)
    one = np.where(np.isfinite(one) & (fit != "none"), one, 1.0)
    sizes = np.where(keep | ~there, natural * one, scope)
    share = np.array(SHARES[align])[:, None]
    steps = np.where(scope > 0, (scope - sizes) * share, 0.0)
    x, y, z = steps[:, 0].tolist() if same else steps
    place = boxes.moved(state, (x, y, z))
    made = sizes[:, 0].tolist() if same else sizes
    number = float(given.pool.asset(asset))
    return {**place, **dict(zip(SIZES, made, strict=True)), "geo": number}


def _filled(
    pool: Pool, asset: int, natural: NDArray[np.float64], extents: tuple[float, ...]
) -> State | None:
    """The scope that an asset fills, where it and the scope extend along the same axes: that is
    the scope as it was.
    """
    for extent, own in zip(extents, natural.tolist(), strict=True):
        if not (0 < extent < math.inf if own > 0 else extent == 0):
            return None
    sizes = (extent + 0.0 for extent in extents)
    return {**dict(zip(SIZES, sizes, strict=True)), "geo": float(pool.asset(asset))}


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
