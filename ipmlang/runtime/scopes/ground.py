"""What a derivation starts on: the scopes of its first shapes.

In go a program's ground with the values of its attributes, or a file given in its place; out come
columns of frames, extents and geometries, one row a shape: a box, a polygon, or every face or
closed path of a file, in the order of the file. Bad outlines are told with their place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.compiler.references import no_such_file
from ipmlang.formats import FormatError
from ipmlang.geometry.footprints import footprint, sound
from ipmlang.geometry.pieces import Piece
from ipmlang.geometry.solid import Floats, GeometryError, Solid, joined, normals, polygon
from ipmlang.runtime import keys
from ipmlang.runtime.bind import evaluated
from ipmlang.runtime.scopes.framing import framed
from ipmlang.runtime.scopes.lots import Lot, closed_paths
from ipmlang.runtime.scopes.pool import BOX, NOTHING, Pool

Numbers = NDArray[np.int64]

ON_SITE = 0x50000000  # the site under which the shapes of a file have their keys
THIN = 1e-12  # points that are off a line by this part of its length lie on it
SHOWN = 5  # shapes that a note names
MANY = 20  # shapes whose errors are told one by one
FILES = (".svg", ".svgz", ".obj", ".ply", ".stl", ".off", ".glb")


@dataclass(frozen=True, slots=True, eq=False)
class Standing:
    """The first shapes: position (n, 3), rotation (n, 4), size (n, 3), geometry (n,); `owners`
    (n, 2): where they come from a file, the number of the face or path of each, and of the part
    that it is of that; these give their keys.
    """

    position: Floats
    rotation: Floats
    size: Floats
    geometry: Floats
    owners: Numbers | None = None
    notes: tuple[str, ...] = ()


def standing(program: ir.Program, attrs: Sequence[float], seed: int, pool: Pool) -> Standing:
    """Where a program's start stands. Raises IpmError for what is no ground."""
    ground = program.ground
    if ground is None:
        turtle = _draws_as_turtle(program)
        from ipmlang.runtime.fields import FLAT, UPRIGHT

        rotation = UPRIGHT if turtle else FLAT
        size = (0.0, 0.0, 0.0) if turtle else (1.0, 1.0, 0.0)
        return _one(rotation, size, float(NOTHING if turtle else BOX))
    if ground.kind == "file":
        assert ground.path is not None
        return file_ground(ground.path, ground.node, pool)
    values = evaluated(ground.code, ground.outputs, attrs, seed)
    if not np.isfinite(values).all():
        raise fail("not-a-number", "what the start stands on has a number that is not finite")
    if ground.kind == "box":
        return _box(values)
    corners = np.array(values).reshape(-1, ground.width)
    one = Lot((corners,))
    return _outlines([one], pool, "the polygon that the start stands on", many=False)


def _one(rotation: Sequence[float], size: Sequence[float], geometry: float) -> Standing:
    return Standing(
        np.zeros((1, 3)), np.array([rotation]), np.array([size], np.float64), np.array([geometry])
    )


def _box(values: Sequence[float]) -> Standing:
    size = (*values, 0.0, 0.0)[:3]
    if min(size) < 0 or sum(each > 0 for each in size) < 2:
        shown = ", ".join(f"{each:g}" for each in values)
        raise fail(
            "bad-ground",
            f"the start cannot stand on box({shown})",
            hint="a box has an extent above 0 along two axes or three",
        )
    return _one((1.0, 0.0, 0.0, 0.0), size, float(BOX))


def _draws_as_turtle(program: ir.Program) -> bool:
    """Whether the axiom reaches a motion of the turtle before any scope."""
    return any(
        each.op in ("segment", "rotate", "move", "level") and not symbol.held
        for symbol in _reached(program)
        for each in symbol.meaning or ()
    )


def _reached(program: ir.Program) -> list[ir.Symbol]:
    """The symbols in the axiom, and in what its symbols become, outside parts of scopes."""
    found: dict[int, ir.Symbol] = {}
    waiting = [program.axiom.body]
    while waiting:
        for each in waiting.pop():
            if each.op in ("repeat", "join", "part"):
                waiting.append(each.body)
            if each.op != "module" or each.const in found:
                continue
            assert isinstance(each.const, int)
            symbol = found[each.const] = program.symbols[each.const]
            waiting += [program.productions[number].body for number in symbol.productions]
    return list(found.values())


# ----------------------------------------------------------------------------------- files


def standing_on(program: ir.Program, reference: str) -> ir.Program:
    """The program with a start on the faces or closed paths of a file, perhaps of one node of it.

    Raises IpmError where there is no such file, or nothing in the program has a scope.
    """
    path, node = Path(reference), ""
    if not path.exists():
        name, _, node = reference.rpartition("#")
        path = Path(name) if name else path
    if not path.is_file():
        raise no_such_file(path, f"there is no file {path} to start on")
    if not program.scoped:
        raise fail(
            "bad-command",
            f"nothing in {Path(program.path).name} has a scope, so it cannot start on {path.name}",
            hint=f'write `on "{path.name}"` behind its `start`: then symbols that nothing else '
            "gives a meaning draw their shapes",
        )
    return replace(program, ground=ir.Ground("file", path=path.absolute(), node=node or None))


def file_ground(path: Path, node: str | None, pool: Pool) -> Standing:
    """Every face or closed path of a file, or of one node of it."""
    suffix = path.suffix.lower()
    if suffix not in FILES:
        raise fail(
            "bad-ground",
            f"the start cannot stand on {path.name}",
            hint=f"take a file of one of these kinds: {', '.join(FILES)}",
        )
    notes: list[str] = []
    try:
        if suffix in (".svg", ".svgz"):
            lots, notes = closed_paths(path, node)
        else:
            lots = _faces(path, node)
    except FormatError as error:
        place = f"{path.name}:{error.line}" if error.line else path.name
        raise fail("bad-ground", f"{place}: {error.message}", hint=error.hint) from error
    if not lots:
        hint = "; ".join(notes) or None
        raise fail("bad-ground", f"there is no closed path in {path.name}", hint=hint)
    made = _outlines(lots, pool, path.name, many=True)
    return replace(made, notes=(*(f"{path.name}: {note}" for note in notes), *made.notes))


def _faces(path: Path, node: str | None) -> list[Lot]:
    from ipmlang.formats.mesh import read_mesh

    mesh = read_mesh(path, node)
    points = mesh.vertices[mesh.corners]
    return [Lot((points[a:b],)) for a, b in pairwise(mesh.offsets.tolist())]


def _outlines(lots: Sequence[Lot], pool: Pool, name: str, *, many: bool) -> Standing:
    """Scopes on outlines with holes: x along the first edge, z out of the face."""
    made: list[Solid] = []
    owners: list[tuple[int, int]] = []
    mends: dict[str, list[int]] = {}
    errors: list[IpmError] = []
    alone = [len(lot.rings) == 1 and lot.trouble is None for lot in lots]
    rings = [lot.rings[0] for lot, single in zip(lots, alone, strict=True) if single]
    plain = iter(sound(rings).tolist())
    for number, lot in enumerate(lots):
        if alone[number] and next(plain):
            owners.append((number, 0))
            made.append(polygon(lot.rings[0]))
            continue
        if many and _is_empty(lot.rings[0]):
            mends.setdefault("a shape without any area left out", []).append(number)
            continue
        try:
            if lot.trouble is not None:
                raise lot.trouble
            solids, mended = footprint(lot.rings)
        except GeometryError as error:
            own = f" ({lot.name})" if lot.name else ""
            where = f"{name}, shape {number + 1}{own}" if many else name
            errors.append(fail("bad-ground", f"{where}: {error.message}", hint=error.hint))
            continue
        for each in mended:
            mends.setdefault(each, []).append(number)
        owners += [(number, piece) for piece in range(len(solids))]
        made += solids
    if errors:
        raise IpmError([each.diagnostics[0] for each in _fewer(errors, name)])
    if not made:
        raise fail("bad-ground", f"no shape in {name} has any area")
    found = framed(pool, _pieces(made))
    notes = tuple(_told(name, note, numbers, many) for note, numbers in mends.items())
    return Standing(
        found.corner,
        found.turn,
        found.size,
        found.geometry,
        np.array(owners) if many else None,
        notes,
    )


def _is_empty(ring: Floats) -> bool:
    """Whether all points of an outline lie on a line."""
    around = ring - ring[:1]
    squares = np.einsum("ij,ij->i", around, around)
    far, size = around[squares.argmax()], float(squares.max())
    rest = around - np.outer(around @ far / (size or 1.0), far)
    return bool(np.einsum("ij,ij->i", rest, rest).max() <= THIN * THIN * size)


def _told(name: str, note: str, numbers: Sequence[int], many: bool) -> str:
    """A note on what was mended, with the shapes that it is about."""
    if not many:
        return f"{name}: {note}"
    shown = ", ".join(str(number + 1) for number in numbers[:SHOWN])
    more = f" and {len(numbers) - SHOWN:,} more" if len(numbers) > SHOWN else ""
    return f"{name}, shape{'s' if len(numbers) > 1 else ''} {shown}{more}: {note}"


def _fewer(errors: list[IpmError], name: str) -> list[IpmError]:
    """The first errors, and how many more there are."""
    more = len(errors) - MANY
    if more <= 1:
        return errors
    return [*errors[:MANY], fail("bad-ground", f"{name}: and {more:,} more shapes like these")]


def _pieces(solids: Sequence[Solid]) -> list[Piece]:
    """Polygons with axes of their own: x along the first edge, z out of it."""
    whole = joined(solids)
    z = normals(whole)
    begin = whole.rings[whole.faces[:-1]]
    first, second = whole.vertices[whole.corners[begin]], whole.vertices[whole.corners[begin + 1]]
    along = second - first
    x = along - z * np.einsum("ij,ij->i", along, z)[:, None]
    x /= np.sqrt(np.einsum("ij,ij->i", x, x))[:, None]
    axes = np.stack([x, np.cross(z, x), z], axis=1)
    return [Piece(frozenset(), *each) for each in zip(solids, axes, strict=True)]


def first_keys(seed: int, standing: Standing) -> tuple[keys.Words, keys.Words]:
    """The keys of the first shapes: the root, or for those of a file its children by the number of
    the face or path; where that fell apart, the second part and those after it by theirs, too.
    """
    count = len(standing.size)
    first, second = keys.root(seed)
    k0, k1 = np.full(count, first, np.uint32), np.full(count, second, np.uint32)
    if standing.owners is None:
        return k0, k1
    numbers, parts = standing.owners.T.astype(np.uint32)
    k0, k1 = keys.child(k0, k1, ON_SITE, numbers)
    later = parts > 0
    k0[later], k1[later] = keys.child(k0[later], k1[later], ON_SITE, parts[later])
    return k0, k1
