"""The operations that take a shape apart, by name: faces, strips, cells, points.

In go the scopes of a batch, out come for each selector the pieces that it takes: whose they are,
their number, and their scopes, as columns. The first selector that takes a piece has it; pieces
that none takes vanish. Nothing here makes children.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.geometry.pieces import Piece
from ipmlang.geometry.solid import Floats, GeometryError, Solid
from ipmlang.runtime import keys
from ipmlang.runtime.code import Column
from ipmlang.runtime.keys import Words
from ipmlang.runtime.scopes import boxes
from ipmlang.runtime.scopes.boxes import FACE_QUATERNIONS, FACES, FLAT_FACE, SIZES, State
from ipmlang.runtime.scopes.framing import Framed, framed, joined
from ipmlang.runtime.scopes.pool import BOX, NOTHING
from ipmlang.runtime.scopes.shaping import Given, Value
from ipmlang.runtime.scopes.tables import Table, distinct, table

Numbers = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Apart:
    """One use of an operation: its arguments, the selectors of its parts, the scopes, the keys of
    the shapes with the site and the copies, and the rows that are there (None: all).
    """

    given: Given
    selectors: Sequence[ir.Const]
    state: State
    keys: tuple[Words, Words, int, tuple[Words, ...]]
    shown: Numbers | None


@dataclass(frozen=True, slots=True, eq=False)
class Batched:
    """The m pieces of one part, those of each row together: how many each row has (n,), the row of
    each piece (m,), its number in its row, how many its row has, and the scopes.
    """

    counts: Numbers
    owner: Numbers
    index: Words
    many: Floats
    state: State


def _cell_total(given: Given) -> Floats:
    sides = [np.maximum(boxes.full(each, given.count), 1.0) for each in given.args]
    return np.asarray(np.prod(sides, axis=0))


def _point_total(given: Given) -> Floats:
    return np.maximum(np.nan_to_num(boxes.full(given.args[0], given.count)), 0.0)


# operations that may make very many pieces: how many each row will (n,), before they are made
AHEAD: Mapping[str, Callable[[Given], Floats]] = {"subdivide": _cell_total, "scatter": _point_total}


def apart(use: Apart) -> list[Batched]:
    """The pieces that each selector takes."""
    given = use.given
    if given.name == "scatter":
        return _scattered(use)
    sizes = [use.state[name] for name in SIZES]
    kinds = table(use.shown, given.count, use.state["geo"], *sizes, *given.args)
    if given.name == "comp" and _all_boxes(use) and _of_faces(given):
        return _boxes_apart(use)
    if given.name == "subdivide" and np.all(np.asarray(use.state["geo"]) == BOX):
        grids = [
            _grid(np.array(size[:3]), _cell_counts(np.array(size[:3]), given.resolved(size[3:])))
            for _, *size in kinds.rows()
        ]
        whole = frozenset({"all"})
        return _spread(use, kinds, joined(grids), [[whole] * len(own.size) for own in grids])
    pieces: list[list[Piece]] = []
    for number, *size in kinds.rows():
        own: list[Piece] = []
        if number != NOTHING:
            extents = np.array(size[:3])
            solid = given.pool.local(int(number), extents)
            own = APART[given.name](solid, extents, *given.resolved(size[3:]))
        pieces.append(own)
    found = framed(given.pool, [piece for own in pieces for piece in own])
    return _spread(use, kinds, found, [[piece.words for piece in own] for own in pieces])


def _of_faces(given: Given) -> bool:
    return not given.args or given.word(0) in (None, "faces")


def _all_boxes(use: Apart) -> bool:
    return bool(np.all(use.given.pool.are_boxes(use.state["geo"])))


# ------------------------------------------------------------------------------ selecting

ORIENTED = frozenset().union(*boxes.WORDS) | {"aslant"}  # they say where a face looks, now


def selects(selector: ir.Const, words: frozenset[str], number: int) -> bool:
    """Whether a selector takes a piece with these words, by its number among all pieces.

    >>> selects(("and", ("word", "side"), ("not", ("index", 2))), frozenset({"side"}), 2)
    False
    """
    match selector:
        case ("all",):
            return True
        case ("word", word):
            return word in words or (word not in ORIENTED and _ends_a_tag(str(word), words))
        case ("index", index):
            return index == number
        case ("not", inner):
            return not selects(inner, words, number)  # type: ignore[arg-type]
        case ("and", left, right):
            return selects(left, words, number) and selects(right, words, number)  # type: ignore[arg-type]
        case ("or", left, right):
            return selects(left, words, number) or selects(right, words, number)  # type: ignore[arg-type]
        case _:
            raise AssertionError(f"no selector: {selector!r}")


def _ends_a_tag(word: str, words: frozenset[str]) -> bool:
    """Whether a word is the last one of a tag: `slope` of `roof.slope`."""
    return any(each.endswith(f".{word}") for each in words)


def _taken(selectors: Sequence[ir.Const], words: Sequence[frozenset[str]]) -> list[list[int]]:
    """For each selector the pieces that it is the first to take."""
    found: list[list[int]] = [[] for _ in selectors]
    for number, own in enumerate(words):
        for place, selector in enumerate(selectors):
            if selects(selector, own, number):
                found[place].append(number)
                break
    return found


# ---------------------------------------------------------------------------- faces of boxes


def _boxes_apart(use: Apart) -> list[Batched]:
    """The faces of shapes that fill their scopes, as columns."""
    count = use.given.count
    rows = np.arange(count) if use.shown is None else use.shown
    sizes = np.stack([boxes.full(use.state[name], count)[rows] for name in SIZES], axis=1)
    numbers = boxes.full(use.state["geo"], count)[rows].astype(np.int64)
    flat = np.where((sizes <= 0).sum(axis=1) == 1, np.argmax(sizes <= 0, axis=1), -1)
    lost = (sizes <= 0).sum(axis=1) > 1
    code = np.where(lost, -1, numbers * 4 + flat + 1)
    codes, kind = distinct(code)
    chosen = [_faces_taken(use, each) for each in codes.tolist()]
    made = []
    for place in range(len(use.selectors)):
        many = np.array([len(each[place][0]) for each in chosen], np.int64)
        owner, index = _dealt(many[kind])
        at = (np.cumsum(many) - many)[kind[owner]] + index
        faces = np.array([face for each in chosen for face in each[place][0]], np.int64)[at]
        tagged = np.array([tag for each in chosen for tag in each[place][1]], np.float64)
        state = _face_state(use, rows[owner], sizes[owner], faces)
        geometry: Column = float(BOX)
        if len(tagged) and not (tagged == BOX).all():
            geometry = tagged[at]
        state["geo"] = geometry
        made.append(_batched(count, rows, many[kind], owner, index, state))
    return made


def _dealt(per_row: Numbers) -> tuple[Numbers, Numbers]:
    """Of so many pieces a row (n,): the row of each piece (m,), and its number there."""
    owner = np.repeat(np.arange(len(per_row)), per_row)
    return owner, np.arange(len(owner)) - (np.cumsum(per_row) - per_row)[owner]


def _batched(
    count: int, rows: Numbers, per_row: Numbers, owner: Numbers, index: Numbers, state: State
) -> Batched:
    """The pieces of one part, dealt to the rows that are there."""
    counts = np.zeros(count, np.int64)
    counts[rows] = per_row
    many = per_row[owner].astype(float)
    return Batched(counts, rows[owner], index.astype(np.uint32), many, state)


def _faces_taken(use: Apart, code: int) -> list[tuple[list[int], list[int]]]:
    """For each selector the faces that it takes of one kind of box, and their geometries."""
    if code < 0:
        return [([], []) for _ in use.selectors]
    pool, number, flat = use.given.pool, code >> 2, (code & 3) - 1
    tags = pool.tags(number)
    faces = range(6) if flat < 0 else (FLAT_FACE[flat],)
    own = tags if len(tags) == len(faces) else (frozenset[str](),) * len(faces)
    if tags and len(tags) != len(faces):
        own = (frozenset.intersection(*tags),) * len(faces)
    words = [boxes.WORDS[face] | tag for face, tag in zip(faces, own, strict=True)]
    found = []
    for taken in _taken(use.selectors, words):
        geometry = [pool.box((own[each],)) for each in taken]
        found.append(([faces[each] for each in taken], geometry))
    return found


_CORNERS = np.array([corner for _, corner, _ in FACES], np.float64)
_EXTENTS = np.array([extents for _, _, extents in FACES])


def _face_state(use: Apart, rows: Numbers, sizes: Floats, faces: Numbers) -> State:
    """The scopes of faces: x along the lower edge, z outward."""
    frame = {name: _of(use.state[name], rows) for name in use.state if name not in (*SIZES, "geo")}
    corner = _CORNERS[faces] * sizes
    place = boxes.moved(frame, (corner[:, 0], corner[:, 1], corner[:, 2]))
    turn = boxes.turned(frame, tuple(FACE_QUATERNIONS[faces].T))
    each = np.arange(len(faces))
    extents = _EXTENTS[faces]
    sx, sy = sizes[each, extents[:, 0]], sizes[each, extents[:, 1]]
    return {**frame, **place, **turn, "sx": sx, "sy": sy, "sz": 0.0}


def _of(column: Column, rows: Numbers) -> Column:
    return column[rows] if isinstance(column, np.ndarray) and column.ndim else column


# ------------------------------------------------------------------------- any geometry


def _spread(
    use: Apart, kinds: Table, found: Framed, words: Sequence[Sequence[frozenset[str]]]
) -> list[Batched]:
    """The pieces of every kind of shape, one kind after the other, for all shapes; `words`: those
    of each piece of each kind.
    """
    count = use.given.count
    rows = np.arange(count) if use.shown is None else use.shown
    taken = [_taken(use.selectors, own) for own in words]
    starts = np.cumsum([0, *(len(own) for own in words)])
    made = []
    for place in range(len(use.selectors)):
        own = [np.array(each[place], np.int64) + starts[k] for k, each in enumerate(taken)]
        many = np.array([len(each) for each in own], np.int64)
        flat = np.concatenate([np.zeros(0, np.int64), *own])
        per_row = many[kinds.kind] if len(rows) else np.zeros(0, np.int64)
        owner, index = _dealt(per_row)
        at = flat[(np.cumsum(many) - many)[kinds.kind[owner]] + index]
        state = _piece_state(
            use, rows[owner], found.corner[at], found.turn[at], found.size[at], found.geometry[at]
        )
        made.append(_batched(count, rows, per_row, owner, index, state))
    return made


def _piece_state(
    use: Apart, rows: Numbers, corner: Floats, turn: Floats, size: Floats, geometry: Floats
) -> State:
    frame = {name: _of(use.state[name], rows) for name in use.state if name not in (*SIZES, "geo")}
    place = boxes.moved(frame, (corner[:, 0], corner[:, 1], corner[:, 2]))
    own: State = {**frame, **place}
    if (turn[:, 0] < 1.0 - 1e-15).any():
        own.update(boxes.turned(frame, tuple(turn.T)))
    own.update(zip(SIZES, size.T, strict=True))
    own["geo"] = geometry
    return own


def _scattered(use: Apart) -> list[Batched]:
    """Points at random on the surfaces, in the volumes or in the scopes of shapes."""
    from ipmlang.geometry.scattering import scatter

    given, state = use.given, use.state
    rows = np.arange(given.count) if use.shown is None else use.shown
    over = given.word(1) or "surface"
    amounts = boxes.full(given.args[0], given.count)[rows]
    wrong = np.flatnonzero(~((amounts >= 0) & (amounts <= MOST)))
    if len(wrong):
        raise GeometryError(f"`scatter` cannot place {amounts[wrong[0]]:g} points")
    numbers = boxes.full(state["geo"], given.count)[rows].astype(np.int64)
    counts = np.where(numbers == NOTHING, 0, amounts.astype(np.int64))
    if counts.sum() > MOST:
        raise GeometryError(f"`scatter` cannot place {counts.sum():,} points")
    sizes = np.stack([boxes.full(state[name], given.count)[rows] for name in SIZES], axis=1)
    draws = _draws(use, rows, counts)
    ends = np.cumsum(counts)
    points = [
        scatter(given.pool.local(number, size), count, over, draws[end - count : end])
        for number, size, count, end in zip(
            numbers.tolist(), sizes, counts.tolist(), ends.tolist(), strict=True
        )
        if count
    ]
    corner = np.concatenate([np.zeros((0, 3)), *points])
    blank = np.zeros(corner.shape)
    turn = np.tile((1.0, 0.0, 0.0, 0.0), (len(corner), 1))
    each = np.arange(len(rows))
    words = [[frozenset({"all"})] * count for count in counts.tolist()]
    found = Framed(corner, turn, blank, np.zeros(len(corner)))
    return _spread(use, Table((), use.shown, each, each), found, words)


MOST = 10_000_000  # points that one `scatter` may place


def _draws(use: Apart, rows: Numbers, counts: Numbers) -> Floats:
    """Three draws for each point (p, 3), under the keys of the shapes."""
    k0, k1, site, copies = use.keys
    base = keys.child(k0[rows], k1[rows], site, *(each[rows] for each in copies))
    owner, index = _dealt(counts)
    first, second = (word[owner] for word in base)
    steps = index.astype(np.uint32)
    return np.stack([keys.uniform(first, second, axis, steps) for axis in range(3)], axis=1)


# --------------------------------------------------------------------- bodies, by operation


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
    counts = _cell_counts(size, (nx, ny, nz))
    edges = [np.linspace(0.0, size[axis], count + 1) for axis, count in enumerate(counts)]
    spans = [
        [tuple(edges[axis][place : place + 2]) for axis, place in enumerate((i, j, k))]
        for k in range(counts[2])
        for j in range(counts[1])
        for i in range(counts[0])
    ]
    return list(_cells(solid, size, spans))


def _cell_counts(size: Floats, args: Sequence[Value]) -> list[int]:
    """How many cells there are along each axis: one where there is no extent."""
    counts = [max(int(_given(each)), 1) for each in args]
    return [count if size[axis] > 0 else 1 for axis, count in enumerate(counts)]


def _grid(size: Floats, counts: Sequence[int]) -> Framed:
    """The cells of a box, which are boxes, x first."""
    places = np.indices(counts[::-1]).reshape(3, -1)[::-1].T
    cell = size / counts
    many = len(places)
    turn = np.tile((1.0, 0.0, 0.0, 0.0), (many, 1))
    return Framed(places * cell, turn, np.tile(cell, (many, 1)), np.full(many, float(BOX)))


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
