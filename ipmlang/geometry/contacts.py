"""Pairs of solids and polygons: does one lie in the other, do they overlap, touch, how far apart.

In go two solids in the same coordinates, out come truth values or a distance. Volumes are compared
by manifold3d, polygons with the sections of solids in their plane. What is so near as 1e-9 of the
size of the pair is at one place. A mesh of many triangles stands for its convex hull.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ipmlang.geometry.loops import frame
from ipmlang.geometry.oriented import NEAR, segment_distances
from ipmlang.geometry.sharing import first_at_place
from ipmlang.geometry.solid import (
    Floats,
    Indices,
    Solid,
    area_vectors,
    bounds,
    is_closed,
    normals,
    ring_points,
    solid_of,
)
from ipmlang.geometry.triangles import triangles

if TYPE_CHECKING:
    import manifold3d

UNITS = 1024.0  # the size that pairs are scaled to: overlays of polygons round to 1e-8
MOST = 2000  # triangles of a mesh that is taken as it is
_EDGES = np.array([(0, 1), (1, 2), (2, 0)])


class Contact(NamedTuple):
    """What one solid is to another: it lies within it, overlaps it, touches it."""

    inside: bool
    overlaps: bool
    touches: bool


NONE = Contact(inside=False, overlaps=False, touches=False)


@dataclass(frozen=True)
class Face:
    """A face in space: its rings (n, 3), a point of it, and its axes as rows, z out of it."""

    rings: list[Floats]
    axes: Floats

    @property
    def origin(self) -> Floats:
        """The first corner."""
        first: Floats = self.rings[0][0]
        return first


@dataclass(frozen=True, slots=True, eq=False)
class Form:
    """A solid that is compared with others, and what does not depend on where it lies: triangles
    (t, 3) of vertex numbers, whether it is closed, and whether it is a point or a segment.
    """

    solid: Solid
    triangles: Indices
    closed: bool
    thin: bool

    def at(self, vertices: Floats) -> Form:
        """The same with its vertices elsewhere."""
        return replace(self, solid=replace(self.solid, vertices=vertices))


def form_of(solid: Solid) -> Form:
    """What is found once about a solid; a mesh of very many triangles is its convex hull."""
    corners, _ = triangles(solid)
    if len(corners) > MOST:
        solid = _hull(solid)
        corners, _ = triangles(solid)
    closed = is_closed(solid)
    if not closed:
        same = first_at_place(solid.vertices)
        welded = replace(solid, corners=same[solid.corners])
        if is_closed(welded):
            solid, corners, closed = welded, same[corners], True
    return Form(solid, corners, closed, not area_vectors(solid).any())


class Body:
    """A form in the coordinates in which a pair is compared; what that needs is found once."""

    def __init__(self, form: Form) -> None:
        self.form = form
        self.triangles = form.solid.vertices[form.triangles]

    @cached_property
    def manifold(self) -> manifold3d.Manifold | None:
        """The closed solid; None where it is open, or crosses itself."""
        import manifold3d

        if not self.form.closed:
            return None
        a, b, c = np.moveaxis(self.triangles, 1, 0)
        inward = np.einsum("tc,tc->", a, np.cross(b, c)) < 0
        corners = self.form.triangles[:, ::-1] if inward else self.form.triangles
        mesh = manifold3d.Mesh64(
            np.ascontiguousarray(self.form.solid.vertices), corners.astype(np.uint64)
        )
        made = manifold3d.Manifold(mesh)
        return made if made.status() == manifold3d.Error.NoError and made.volume() > 0 else None

    @cached_property
    def faces(self) -> list[Face]:
        """All faces with area."""
        found = []
        for number, normal in enumerate(normals(self.form.solid)):
            if normal.any():
                across = frame((float(normal[0]), float(normal[1]), float(normal[2])))
                axes = np.array((*across, normal))
                found.append(Face(ring_points(self.form.solid, number), axes))
        return found


def _hull(solid: Solid) -> Solid:
    import manifold3d

    mesh = manifold3d.Manifold.hull_points(np.ascontiguousarray(solid.vertices)).to_mesh64()
    corners = np.asarray(mesh.tri_verts).astype(np.int64)
    return solid_of(np.asarray(mesh.vert_properties)[:, :3], corners[:, None].tolist())


def contact(a: Form, b: Form) -> Contact:
    """What `a` is to `b`.

    >>> from ipmlang.geometry.solid import placed, unit_box
    >>> contact(form_of(unit_box()), form_of(placed(unit_box(), (1, 1, 1), (1, 0, 0))))
    Contact(inside=False, overlaps=False, touches=True)
    """
    one, other, _ = _scaled(a, b)
    near = NEAR * UNITS
    if a.thin:
        inside, overlaps = _thin(one, other, near)
    elif b.thin:
        inside, overlaps = False, _thin(other, one, near)[1]
    elif one.manifold is not None and other.manifold is not None:
        inside, overlaps = _solids(one, other, near)
    elif other.manifold is not None:
        inside, overlaps = _polygons(one, other, near)
    elif one.manifold is not None:
        inside, overlaps = False, _polygons(other, one, near)[1]
    else:
        inside, overlaps = _covered(one, other, near), _crossing(one, other, near)
    return Contact(inside, overlaps, not overlaps and _gap(one, other) <= near)


def distance(a: Form, b: Form) -> float:
    """How far two solids are apart, 0 where they overlap or touch."""
    one, other, scale = _scaled(a, b)
    gap = _gap(one, other)
    if gap and contact(a, b).overlaps:
        return 0.0
    return gap / scale


def _scaled(a: Form, b: Form) -> tuple[Body, Body, float]:
    """Both near 0, and of the size that is compared with least error; the factor."""
    lows, highs = zip(bounds(a.solid), bounds(b.solid), strict=True)
    low, high = np.min(lows, axis=0), np.max(highs, axis=0)
    size = max(float((top - bottom).max()) for bottom, top in zip(lows, highs, strict=True))
    scale = UNITS / size if size > 0 else 1.0
    middle = (low + high) / 2
    one, other = (Body(each.at((each.solid.vertices - middle) * scale)) for each in (a, b))
    return one, other, scale


# ------------------------------------------------------------------------------- closed solids


def _solids(a: Body, b: Body, near: float) -> tuple[bool, bool]:
    """Volumes that differ by less than a skin as thick as `near` are the same."""
    assert a.manifold is not None and b.manifold is not None
    shared = (a.manifold ^ b.manifold).volume()
    own, skin = a.manifold.volume(), near * a.manifold.surface_area()
    least = near * min(a.manifold.surface_area(), b.manifold.surface_area())
    return own - shared <= skin, shared > least


# --------------------------------------------------------------------- polygons and a closed solid


def _polygons(a: Body, b: Body, near: float) -> tuple[bool, bool]:
    """Whether all faces of `a` lie in the solid `b`, and whether some of them passes through it:
    the sections just above and just below a face tell on which sides of it the solid is.
    """
    inside, overlaps = True, False
    for face in a.faces:
        own, above, below = _sections(face, b, near)
        skin = 4 * near * sum(_length(ring) for ring in face.rings)
        inside &= (own - (above + below)).area() <= skin
        overlaps |= (own ^ above ^ below).area() > skin
    return inside and bool(a.faces), overlaps


def _sections(
    face: Face, body: Body, near: float
) -> tuple[manifold3d.CrossSection, manifold3d.CrossSection, manifold3d.CrossSection]:
    assert body.manifold is not None
    moved = body.manifold.transform(
        np.concatenate([face.axes, -(face.axes @ face.origin)[:, None]], axis=1)
    )
    return _area(face.rings, face), moved.slice(near), moved.slice(-near)


def _area(rings: list[Floats], plane: Face) -> manifold3d.CrossSection:
    """Rings as an area in the plane of a face."""
    import manifold3d

    flat = [np.ascontiguousarray((ring - plane.origin) @ plane.axes[:2].T) for ring in rings]
    return manifold3d.CrossSection(flat, manifold3d.FillRule.EvenOdd)


def _length(ring: Floats) -> float:
    return float(np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1).sum())


# ------------------------------------------------------------------------------ points and lines


def thin(start: Floats, end: Floats) -> Form:
    """A segment, or a point, for comparing with solids."""
    corners = np.array([[0, 1, 2]])
    return Form(solid_of(np.array((start, end, end)), [corners.tolist()]), corners, False, True)


def _thin(a: Body, b: Body, near: float) -> tuple[bool, bool]:
    """The same for a point or a segment: the planes of `b` part it, each part is in or out."""
    start, end = a.form.solid.vertices[:2]
    planes = np.array([(*face.axes[2], face.axes[2] @ face.origin) for face in b.faces])
    high = np.stack([start, end]) @ planes[:, :3].T - planes[:, 3]
    through = np.flatnonzero(high.min(axis=0) * high.max(axis=0) < 0)
    crossed = high[:, through]
    shares = np.unique([0.0, *(crossed[0] / (crossed[0] - crossed[1])), 1.0])
    middles = start + ((shares[1:] + shares[:-1]) / 2)[:, None] * (end - start)
    on = np.array([_gap_of(point, b) <= near for point in middles])
    if b.manifold is not None:
        within = _winding(middles, b.triangles) > 0.5
        return bool((within | on).all()), bool((within & ~on).any())
    pierced = start + shares[1:-1, None] * (end - start)
    ends = (np.abs(crossed) > near).all(axis=0)
    return bool(on.all()), bool(ends.any()) and any(_gap_of(p, b) <= near for p in pierced)


def _gap_of(point: Floats, body: Body) -> float:
    return _gap(Body(thin(point, point)), body)


def _winding(points: Floats, faces: Floats) -> Floats:
    """How often triangles (t, 3, 3) wind around points (n,): their solid angles together (van
    Oosterom and Strackee 1983).
    """
    a, b, c = np.moveaxis(faces[None] - points[:, None, None], 2, 0)
    la, lb, lc = (np.linalg.norm(each, axis=2) for each in (a, b, c))
    dots = [np.einsum("ntc,ntc->nt", *pair) for pair in ((a, b), (b, c), (c, a))]
    below = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
    angle = 2 * np.arctan2(np.einsum("ntc,ntc->nt", a, np.cross(b, c)), below)
    found: Floats = np.abs(angle.sum(axis=1)) / (4 * np.pi)
    return found


# -------------------------------------------------------------------------------- open surfaces


def _covered(a: Body, b: Body, near: float) -> bool:
    """Whether the faces of `b` in their planes cover all faces of `a`."""
    import manifold3d

    for face in a.faces:
        own = _area(face.rings, face)
        for other in b.faces:
            if _in_plane(face, other, near):
                own -= _area(other.rings, face)
        if own.area() > 4 * near * sum(_length(ring) for ring in face.rings):
            return False
        assert isinstance(own, manifold3d.CrossSection)
    return bool(a.faces)


def _crossing(a: Body, b: Body, near: float) -> bool:
    """Whether faces share area in one plane, or pass through each other."""
    return any(_faces_cross(*pair, near) for pair in product(a.faces, b.faces))


def _faces_cross(a: Face, b: Face, near: float) -> bool:
    if _in_plane(a, b, near):
        skin = 4 * near * min(_length(a.rings[0]), _length(b.rings[0]))
        return bool((_area(a.rings, a) ^ _area(b.rings, a)).area() > skin)
    line = np.cross(a.axes[2], b.axes[2])
    size = float(np.linalg.norm(line))
    if size <= NEAR:
        return False
    line /= size
    cuts = [
        _cuts(one, other, step, line) for one, other in ((a, b), (b, a)) for step in (-near, near)
    ]
    ends = np.unique(np.concatenate(cuts))
    middles = (ends[1:] + ends[:-1]) / 2
    both = np.ones(len(middles), np.bool_)
    for own in cuts:
        both &= np.searchsorted(own, middles) % 2 == 1
    return bool((ends[1:] - ends[:-1])[both].sum() > near)


def _in_plane(a: Face, b: Face, near: float) -> bool:
    points = np.concatenate(b.rings) - a.origin
    return bool((np.abs(points @ a.axes[2]) <= near).all())


def _cuts(face: Face, plane: Face, step: float, line: Floats) -> Floats:
    """Where along a line the border of a face goes through a plane, moved by a step; in order."""
    found = [np.zeros(0)]
    for ring in face.rings:
        high = (ring - plane.origin) @ plane.axes[2] - step
        after = np.roll(high, -1)
        through = np.flatnonzero((high > 0) != (after > 0))
        share = (high[through] / (high[through] - after[through]))[:, None]
        ends = np.roll(ring, -1, axis=0)[through]
        found.append((ring[through] * (1 - share) + ends * share) @ line)
    return np.sort(np.concatenate(found))


# ------------------------------------------------------------------------------------ distance


def _gap(a: Body, b: Body) -> float:
    """The least distance of all triangles: of corners from faces, and of edges from edges."""
    best = np.inf
    step = max(1, 100_000 // max(len(b.triangles), 1))
    for start in range(0, len(a.triangles), step):
        one, other = a.triangles[start : start + step, None], b.triangles[None]
        best = min(best, _over_faces(one, other), _over_faces(other, one))
        edges = segment_distances(one[:, :, _EDGES][:, :, :, None], other[:, :, _EDGES][:, :, None])
        best = min(best, float(edges.min(initial=np.inf)))
    return best


def _over_faces(points: Floats, faces: Floats) -> float:
    """The least distance of the corners of triangles (…, 3, 3) that lie over others."""
    first, second = faces[..., 1, :] - faces[..., 0, :], faces[..., 2, :] - faces[..., 0, :]
    normal = np.cross(first, second)
    square = np.einsum("...c,...c->...", normal, normal)[..., None]
    apart = points - faces[..., :1, :]
    across = np.broadcast_arrays(normal[..., None, :], apart)[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        u = np.einsum("...c,...c->...", np.cross(apart, second[..., None, :]), across) / square
        v = np.einsum("...c,...c->...", np.cross(first[..., None, :], apart), across) / square
        high = np.abs(np.einsum("...c,...c->...", apart, across)) / np.sqrt(square)
    over = (u >= 0) & (v >= 0) & (u + v <= 1)
    return float(np.where(over, high, np.inf).min(initial=np.inf))
