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

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.formats import FormatError
from ipmlang.geometry.footprints import footprint
from ipmlang.geometry.solid import Floats, GeometryError, Solid, normals, ring_points
from ipmlang.runtime import keys
from ipmlang.runtime.bind import evaluated
from ipmlang.runtime.boxes import quaternion
from ipmlang.runtime.pool import BOX, NOTHING, Pool

ON_SITE = 0x50000000  # the site under which the shapes of a file have their keys
FILES = (".svg", ".svgz", ".obj", ".ply", ".stl", ".off", ".glb")


@dataclass(frozen=True, slots=True, eq=False)
class Standing:
    """The first shapes: position (n, 3), rotation (n, 4), size (n, 3), geometry (n,); `many`: they
    come from a file, and have keys by their number.
    """

    position: Floats
    rotation: Floats
    size: Floats
    geometry: Floats
    many: bool = False
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
        return file_ground(ground.path, pool)
    values = evaluated(ground.code, ground.outputs, attrs, seed)
    if not np.isfinite(values).all():
        raise fail("not-a-number", "what the start stands on has a number that is not finite")
    if ground.kind == "box":
        return _box(values)
    corners = np.array(values).reshape(-1, ground.width)
    return _outlines([[corners]], pool, "the polygon that the start stands on", many=False)


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
            if each.op == "repeat":
                waiting.append(each.body)
            if each.op != "module" or each.const in found:
                continue
            assert isinstance(each.const, int)
            symbol = found[each.const] = program.symbols[each.const]
            waiting += [program.productions[number].body for number in symbol.productions]
    return list(found.values())


# ----------------------------------------------------------------------------------- files


def file_ground(path: Path, pool: Pool) -> Standing:
    """Every face or closed path of a file."""
    suffix = path.suffix.lower()
    if suffix not in FILES:
        raise fail(
            "bad-ground",
            f"the start cannot stand on {path.name}",
            hint=f"take a file of one of these kinds: {', '.join(FILES)}",
        )
    try:
        faces = _paths(path) if suffix in (".svg", ".svgz") else _faces(path)
    except FormatError as error:
        place = f"{path.name}:{error.line}" if error.line else path.name
        raise fail("bad-ground", f"{place}: {error.message}", hint=error.hint) from error
    if not faces:
        raise fail("bad-ground", f"there is no face and no closed path in {path.name}")
    return _outlines(faces, pool, path.name, many=True)


def _faces(path: Path) -> list[list[Floats]]:
    from ipmlang.formats.mesh import read_mesh

    mesh = read_mesh(path)
    points = mesh.vertices[mesh.corners]
    return [[points[a:b]] for a, b in pairwise(mesh.offsets.tolist())]


def _paths(path: Path) -> list[list[Floats]]:
    from ipmlang.runtime.lots import closed_paths

    return closed_paths(path)


def _outlines(faces: Sequence[Sequence[Floats]], pool: Pool, name: str, *, many: bool) -> Standing:
    """Scopes on outlines with holes: x along the first edge, z out of the face."""
    rows: list[tuple[float, ...]] = []
    notes: list[str] = []
    errors = []
    for number, rings in enumerate(faces):
        where = f"{name}, shape {number + 1}" if many else name
        try:
            solids, mended = footprint(rings)
        except GeometryError as error:
            errors.append(fail("bad-ground", f"{where}: {error.message}", hint=error.hint))
            continue
        notes += [f"{where}: {each}" for each in mended]
        rows += [_scope(solid, pool) for solid in solids]
    if errors:
        raise IpmError([each.diagnostics[0] for each in errors])
    found = np.array(rows)
    position, rotation, size, geometry = np.split(found, (3, 7, 10), axis=1)
    return Standing(position, rotation, size, geometry[:, 0], many, tuple(notes))


def _scope(solid: Solid, pool: Pool) -> tuple[float, ...]:
    z = normals(solid)[0]
    first, second = ring_points(solid, 0)[0][:2]
    x = (second - first) - z * ((second - first) @ z)
    x /= np.linalg.norm(x)
    axes = np.stack([x, np.cross(z, x), z])
    turned = replace(solid, vertices=solid.vertices @ axes.T)
    number, low, size = pool.add(turned)
    return (*(low @ axes), *quaternion(axes), *size, float(number))


def first_keys(seed: int, count: int, many: bool) -> tuple[keys.Words, keys.Words]:
    """The keys of the first shapes: the root, or for those of a file its children by number."""
    first, second = keys.root(seed)
    k0, k1 = np.full(count, first, np.uint32), np.full(count, second, np.uint32)
    if not many:
        return k0, k1
    return keys.child(k0, k1, ON_SITE, np.arange(count, dtype=np.uint32))
