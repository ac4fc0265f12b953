"""The operations that take a shape apart, by name: faces, strips, cells, points.

In go the scopes of a batch, out come for each selector the pieces that it takes: whose they are,
their number, and their scopes, as columns. The first selector that takes a piece has it; pieces
that none takes vanish. Nothing here makes children.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.geometry.pieces import Piece
from ipmlang.geometry.solid import Floats, GeometryError
from ipmlang.runtime import keys
from ipmlang.runtime.code import Column
from ipmlang.runtime.keys import Words
from ipmlang.runtime.scopes import boxes
from ipmlang.runtime.scopes.boxes import FACE_QUATERNIONS, FACES, FLAT_FACE, SIZES, State
from ipmlang.runtime.scopes.dividing import cell_counts, parts_of
from ipmlang.runtime.scopes.framing import Framed, framed, joined
from ipmlang.runtime.scopes.pool import BOX, NOTHING, Pool
from ipmlang.runtime.scopes.shaping import Given
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
    columnar = COLUMNAR.get(given.name)
    made = None if columnar is None else columnar(use)
    if made is not None:
        return made
    sizes = [use.state[name] for name in SIZES]
    kinds = table(use.shown, given.count, use.state["geo"], *sizes, *given.args)
    pieces: list[list[Piece]] = [[] for _ in kinds.first]
    rows = [(place, row) for place, row in enumerate(kinds.rows()) if row[0] != NOTHING]
    extents = np.array([row[1:4] for _, row in rows]).reshape(-1, 3)
    solids = given.pool.all_local([int(row[0]) for _, row in rows], extents)
    values = [given.resolved(row[4:]) for _, row in rows]
    for (place, _), own in zip(rows, parts_of(given.name, solids, extents, values), strict=True):
        pieces[place] = own
    found = framed(given.pool, [piece for own in pieces for piece in own])
    return _spread(use, kinds, found, [[piece.words for piece in own] for own in pieces])


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


def _taken(
    selectors: Sequence[ir.Const], pieces: Sequence[Sequence[frozenset[str]]]
) -> list[list[list[int]]]:
    """For each shape and each selector the pieces that it is the first to take; `pieces`: the words
    of those of each shape. Shapes have pieces like each other's: each is looked at once.
    """
    known: dict[tuple[int, frozenset[str]], int] = {}
    found: list[list[list[int]]] = []
    for words in pieces:
        own: list[list[int]] = [[] for _ in selectors]
        for number, each in enumerate(words):
            place = known.get((number, each))
            if place is None:
                place = known[number, each] = _taker(selectors, each, number)
            if place >= 0:
                own[place].append(number)
        found.append(own)
    return found


def _taker(selectors: Sequence[ir.Const], words: frozenset[str], number: int) -> int:
    """The first selector that takes a piece; -1 if none does."""
    takes = (place for place, each in enumerate(selectors) if selects(each, words, number))
    return next(takes, -1)


# ---------------------------------------------------------------------------- faces of boxes


def _boxes_apart(use: Apart) -> list[Batched] | None:
    """The faces of shapes that fill their scopes, as columns; None where others are among them."""
    given, count = use.given, use.given.count
    if not np.all(given.pool.are_boxes(use.state["geo"])):
        return None
    if given.args and given.word(0) not in (None, "faces"):
        return None
    rows = np.arange(count) if use.shown is None else use.shown
    sizes = np.stack([boxes.full(use.state[name], count)[rows] for name in SIZES], axis=1)
    numbers = boxes.full(use.state["geo"], count)[rows].astype(np.int64)
    flat = np.where((sizes <= 0).sum(axis=1) == 1, np.argmax(sizes <= 0, axis=1), -1)
    lost = (sizes <= 0).sum(axis=1) > 1
    code = np.where(lost, -1, numbers * 4 + flat + 1)
    codes, kind = distinct(code)
    chosen = [faces_taken(given.pool, use.selectors, each) for each in codes.tolist()]
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


def faces_taken(
    pool: Pool, selectors: Sequence[ir.Const], code: int
) -> list[tuple[list[int], list[int]]]:
    """For each selector the faces that it takes of one kind of box, and their geometries; `code`:
    four times the number of the box, and the axis along which it has no extent, from 1 on, or 0.
    """
    if code < 0:
        return [([], []) for _ in selectors]
    number, flat = code >> 2, (code & 3) - 1
    tags = pool.tags(number)
    faces = range(6) if flat < 0 else (FLAT_FACE[flat],)
    own = tags if len(tags) == len(faces) else (frozenset[str](),) * len(faces)
    if tags and len(tags) != len(faces):
        own = (frozenset.intersection(*tags),) * len(faces)
    words = [boxes.WORDS[face] | tag for face, tag in zip(faces, own, strict=True)]
    found = []
    for taken in _taken(selectors, [words])[0]:
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
    taken = _taken(use.selectors, words)
    starts = [0, *accumulate(len(own) for own in words)]
    made = []
    for place in range(len(use.selectors)):
        own = [each[place] for each in taken]
        many = np.array([len(each) for each in own], np.int64)
        flat = np.array(
            [k + n for k, each in zip(starts, own, strict=False) for n in each], np.int64
        )
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
    from ipmlang.geometry.scattering import scattered

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
    there = np.flatnonzero(counts)
    solids = given.pool.all_local(numbers[there].tolist(), sizes[there])
    corner = scattered(solids, counts[there], over, draws)
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


def _grids(use: Apart) -> list[Batched] | None:
    """The cells of plain boxes, which are boxes; None where others are among them."""
    given = use.given
    if not np.all(np.asarray(use.state["geo"]) == BOX):
        return None
    sizes = [use.state[name] for name in SIZES]
    kinds = table(use.shown, given.count, use.state["geo"], *sizes, *given.args)
    grids = [
        _grid(np.array(size[:3]), cell_counts(np.array(size[:3]), given.resolved(size[3:])))
        for _, *size in kinds.rows()
    ]
    whole = frozenset({"all"})
    return _spread(use, kinds, joined(grids), [[whole] * len(own.size) for own in grids])


def _grid(size: Floats, counts: Sequence[int]) -> Framed:
    """The cells of a box, which are boxes, x first."""
    places = np.indices(counts[::-1]).reshape(3, -1)[::-1].T
    cell = size / counts
    many = len(places)
    turn = np.tile((1.0, 0.0, 0.0, 0.0), (many, 1))
    return Framed(places * cell, turn, np.tile(cell, (many, 1)), np.full(many, float(BOX)))


# bodies that work on columns, and come first; they give None where they cannot serve
COLUMNAR: Mapping[str, Callable[[Apart], list[Batched] | None]] = {
    "comp": _boxes_apart,
    "scatter": _scattered,
    "subdivide": _grids,
}
