"""Join solids, take one from another, keep what they share (by manifold3d).

Closed solids come in, one closed solid goes out: its faces are polygons again, with the tags of the
faces they come from. Texture coordinates are not carried over.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from ipmlang.geometry.converting import reversed_normals
from ipmlang.geometry.merging import merged_faces
from ipmlang.geometry.sharing import first_at_place
from ipmlang.geometry.solid import (
    Floats,
    GeometryError,
    Indices,
    Solid,
    is_closed,
    solid_of,
    volume,
)
from ipmlang.geometry.touching import GAP, drawn_apart
from ipmlang.geometry.triangles import triangles

if TYPE_CHECKING:
    import manifold3d

Kind = Literal["union", "subtract", "intersect"]


def boolean(parts: Sequence[Solid], kind: Kind) -> Solid | None:
    """The union of all parts, the first less the others, or what all share; None for nothing.

    Parts must be closed; one that is inside out counts as the right way out. GeometryError names
    the first that is not closed. Faces of different parts that lie in one plane and bear the same
    tags become one.

    >>> from ipmlang.geometry.solid import placed, unit_box
    >>> both = boolean([unit_box(), placed(unit_box(), (1, 1, 1), (0.5, 0, 0))], "union")
    >>> len(both), volume(both)
    (6, 1.5)
    """
    if not parts:
        return None
    import manifold3d

    kinds = {
        "union": manifold3d.OpType.Add,
        "subtract": manifold3d.OpType.Subtract,
        "intersect": manifold3d.OpType.Intersect,
    }
    first = manifold3d.Manifold.reserve_ids(len(parts))
    ready = [drawn_apart(_closed(part, n + 1, kind)) for n, part in enumerate(parts)]
    bodies = [_body(part, first + n, n + 1, kind) for n, (part, _) in enumerate(ready)]
    found = manifold3d.Manifold.batch_boolean(bodies, kinds[kind])
    if found.num_tri() == 0 or found.volume() <= 1e-12 * max(
        map(manifold3d.Manifold.volume, bodies)
    ):
        return None  # nothing, or where parts touch
    whole = _solid(found, {first + n: part for n, part in enumerate(parts)})
    return _put_back(whole, np.concatenate([places for _, places in ready]))


def _body(part: Solid, number: int, place: int, kind: Kind) -> manifold3d.Manifold:
    import manifold3d

    corners, face = triangles(part)
    mesh = manifold3d.Mesh64(
        np.ascontiguousarray(part.vertices),
        corners.astype(np.uint64),
        run_index=np.array([0, corners.size], np.uint64),
        run_original_id=np.array([number], np.uint32),
        face_id=face.astype(np.uint64),
    )
    body = manifold3d.Manifold(mesh)
    if body.status() != manifold3d.Error.NoError:
        raise _not_closed(place, kind)
    return body


def _closed(part: Solid, place: int, kind: Kind) -> Solid:
    """A part the right way out, vertices at one place welded where that takes to close it."""
    if not is_closed(part):
        part = replace(part, corners=first_at_place(part.vertices)[part.corners])
        if not is_closed(part):
            raise _not_closed(place, kind)
    return reversed_normals(part) if volume(part) < 0 else part


def _not_closed(place: int, kind: Kind) -> GeometryError:
    return GeometryError(
        f"{kind} needs closed solids, and part {place} has open edges",
        "give polygons a thickness first, as with extrude(0.2)",
    )


def _solid(found: manifold3d.Manifold, parts: dict[int, Solid]) -> Solid:
    mesh = found.to_mesh64()
    points = np.asarray(mesh.vert_properties)[:, :3]
    corners = np.asarray(mesh.tri_verts).astype(np.int64)
    index: Indices = np.asarray(mesh.run_index).astype(np.int64)
    spans = (index[1:] - index[:-1]) // 3
    runs = np.repeat(np.asarray(mesh.run_original_id), spans).tolist()
    faces = np.asarray(mesh.face_id).tolist()
    tags = [parts[run].tags[face] for run, face in zip(runs, faces, strict=True)]
    whole = solid_of(points, corners[:, None].tolist(), tags)
    return merged_faces(whole, 1e-9)


def _put_back(solid: Solid, places: Floats) -> Solid:
    """Vertices that were drawn away from where a part touches itself, at their places again."""
    if not len(places):
        return solid
    vertices = solid.vertices.copy()
    reach = 4 * GAP * float(np.ptp(vertices, axis=0).max())
    for place in places:
        vertices[(np.abs(vertices - place) <= reach).all(axis=1)] = place
    return replace(solid, vertices=vertices)
