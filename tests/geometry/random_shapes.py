"""Random polygons and solids for properties: unions of boxes on a grid, whose edges meet and touch
as those of real plans do, and stars; raised to prisms, or read off trimesh as an oracle.
"""

from __future__ import annotations

import numpy as np
import shapely
import trimesh
from hypothesis import strategies as st

from ipmlang.geometry.raising import extrude
from ipmlang.geometry.solid import Solid, polygon, ring_points

_SPAN = st.integers(1, 3)
_PLACE = st.integers(0, 5)
_BOX = st.tuples(_PLACE, _PLACE, _SPAN, _SPAN)


def polygon_of(shape: shapely.Polygon) -> Solid:
    """The polygon of one of shapely's, its outline turned counter-clockwise."""
    turned = shapely.geometry.polygon.orient(shape)
    holes = [np.array(hole.coords)[:-1] for hole in turned.interiors]
    return polygon(np.array(turned.exterior.coords)[:-1], holes)


@st.composite
def plans(draw: st.DrawFn) -> Solid:
    """A polygon of grid squares, maybe with holes that may touch its outline."""
    boxes = draw(st.lists(_BOX, min_size=1, max_size=7))
    holes = draw(st.lists(st.tuples(_PLACE, _PLACE), max_size=3))
    whole = shapely.union_all([shapely.box(x, y, x + w, y + h) for x, y, w, h in boxes])
    for x, y in holes:
        less = whole.difference(shapely.box(x, y, x + 1, y + 1))
        whole = less if less.area else whole
    return polygon_of(max(getattr(whole, "geoms", [whole]), key=lambda part: part.area))


@st.composite
def stars(draw: st.DrawFn) -> Solid:
    """A polygon of 3 to 12 corners around the origin, seldom convex."""
    radii = draw(st.lists(st.floats(1, 5), min_size=3, max_size=12))
    angles = np.arange(len(radii)) * 2 * np.pi / len(radii)
    return polygon(np.stack([np.cos(angles), np.sin(angles)], axis=1) * np.array(radii)[:, None])


def polygons() -> st.SearchStrategy[Solid]:
    """Plans and stars."""
    return plans() | stars()


@st.composite
def prisms(draw: st.DrawFn) -> Solid:
    """A closed solid: a polygon raised."""
    return extrude(draw(polygons()), draw(st.sampled_from([1.0, 2.0, 0.37])))


def mesh_of(solid: Solid) -> trimesh.Trimesh:
    """Triangles of a solid, made by trimesh and shapely alone: an oracle."""
    corners, triangles = [], []
    for face in range(len(solid)):
        rings = ring_points(solid, face)
        normal = sum(np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0) for ring in rings)
        drop = int(np.argmax(np.abs(normal)))
        keep = [(drop + 1) % 3, (drop + 2) % 3]
        shape = shapely.Polygon(rings[0][:, keep], [ring[:, keep] for ring in rings[1:]])
        for triangle in shapely.constrained_delaunay_triangles(shape).geoms:
            flat = np.array(shapely.geometry.polygon.orient(triangle).exterior.coords)[:3]
            space = np.empty((3, 3))
            space[:, keep] = flat
            space[:, drop] = ((rings[0][0] @ normal) - flat @ normal[keep]) / normal[drop]
            triangles.append(np.arange(3)[:: 1 if normal[drop] > 0 else -1] + 3 * len(triangles))
            corners.append(space)
    return trimesh.Trimesh(np.concatenate(corners), np.array(triangles), process=False)
