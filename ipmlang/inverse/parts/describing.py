"""What a person would call a shape of which the file says nothing: by its form and by its place.

Takes a mesh, or boxes; gives words. Nothing here reads names or knows of other shapes.
"""

from __future__ import annotations

import numpy as np

from ipmlang.formats.distinct import distinct_rows
from ipmlang.formats.mesh_types import Mesh
from ipmlang.inverse.frames import Floats, Integers

FLAT = 1e-6  # of the largest side, that a panel is thick at most
THIN = 0.25  # of the largest side, that the others of a post are at most
LEVEL = 0.2  # of the middle side, that a slab is thick at most
SOLID = 0.6  # of its box, that a block fills at least
ROUND = 5  # sides of what is round, at least
TAPERED = 0.5  # of its foot, that the top of a cone is wide at most
SPANS = 0.6  # of the whole, by what stands on no side of it
ASIDE = 0.3  # of the whole, that what stands on a side is off its middle
NEAR = 0.02  # of the whole's height, from its ground or its top


def shape_word(mesh: Mesh) -> str:
    """What a shape is called by its box and faces."""
    size = np.ptp(mesh.vertices, axis=0)
    small, middle, large = np.sort(size)
    if large <= 0:
        return "Point"
    if small <= FLAT * large:
        return "Panel" if middle > 0.1 * large else "Strip"
    if middle <= THIN * large:
        return "Post" if size[2] == large else "Bar"
    if small <= LEVEL * middle:
        return "Slab" if size[2] == small else "Plate"
    return "Box" if _fills_box(mesh, size) else _solid_word(mesh, size)


def _fills_box(mesh: Mesh, size: Floats) -> bool:
    """Whether all vertices are corners of the box."""
    share = mesh.vertices / size
    return len(share) == 8 and bool((np.abs(share - np.rint(share)) < 1e-6).all())


def _solid_word(mesh: Mesh, size: Floats) -> str:
    """A word for what is as thick as it is wide: round about an axis, or nearly a box."""
    for axis, word in ((2, "Drum"), (0, "Roll"), (1, "Roll")):
        bottom = _ring(mesh.vertices, axis, 0.0)
        if _is_round(bottom):
            top = _ring(mesh.vertices, axis, float(size[axis]))
            wide = TAPERED * np.linalg.norm(np.ptp(bottom, axis=0))
            if axis == 2 and np.linalg.norm(np.ptp(top, axis=0)) <= wide:
                return "Cone"
            if _is_round(top):
                return word
    eight_corners = len(np.unique(mesh.corners)) == 8  # a box that is bevelled or slanted
    full = _volume(mesh) >= SOLID * float(np.prod(size))
    return "Block" if eight_corners or full else "Part"


def _ring(points: Floats, axis: int, level: float) -> Floats:
    """(k, 2) the points at a height along an axis."""
    along = points[:, axis]
    near = np.flatnonzero(np.abs(along - level) <= 1e-6 * max(float(np.ptp(along)), 1e-300))
    flat = np.round(points[near[:, None], [each for each in range(3) if each != axis]], 9)
    return np.asarray(flat[distinct_rows(flat)[0]])


def _is_round(points: Floats) -> bool:
    """Whether points (k, 2) lie on a circle, all around it."""
    if len(points) < ROUND:
        return False
    arm = points - points.mean(axis=0)
    far = np.linalg.norm(arm, axis=1)
    if far.min() < 0.98 * far.max():
        return False
    angle = np.sort(np.arctan2(arm[:, 1], arm[:, 0]))
    gaps = np.diff(np.append(angle, angle[0] + 2 * np.pi))
    return bool(gaps.max() <= 2.2 * np.pi / ROUND)


def _volume(mesh: Mesh) -> float:
    """Of what faces enclose, by their fans; of open ones something smaller or larger."""
    points = mesh.vertices - mesh.vertices.mean(axis=0)
    first = np.repeat(mesh.corners[mesh.offsets[:-1]], np.diff(mesh.offsets))
    after: Integers = np.roll(mesh.corners, -1)
    after[mesh.offsets[1:] - 1] = mesh.corners[mesh.offsets[:-1]]
    one, two, three = points[first], points[mesh.corners], points[after]
    return abs(float(np.einsum("ij,ij->", one, np.cross(two, three)))) / 6


def place_word(low: Floats, high: Floats, whole: Floats, shape: str) -> str:
    """A shape's word with where it stands in the whole (2, 3): `Base`, `TopBar`, `LeftPost`.

    >>> whole = np.array([[0.0, 0, 0], [10, 10, 20]])
    >>> place_word(np.zeros(3), np.array([10.0, 10, 1]), whole, "Slab")
    'Base'
    >>> place_word(np.array([0.0, 4, 2]), np.array([1.0, 5, 9]), whole, "Post")
    'LeftPost'
    """
    extent = np.maximum(whole[1] - whole[0], 1e-300)
    share = (high - low) / extent
    foot, head = (low[2] - whole[0, 2]) / extent[2], (whole[1, 2] - high[2]) / extent[2]
    if share[:2].min() >= SPANS:
        if foot <= NEAR:
            return "Base" if share[2] < SPANS else "Body"
        return "Roof" if head <= NEAR else shape
    off = ((low + high) / 2 - (whole[0] + whole[1]) / 2) / extent
    off = np.where(share >= SPANS, 0.0, off)
    axis = int(np.argmax(np.abs(off)))
    if abs(off[axis]) < ASIDE:
        return shape
    sides = (("Left", "Right"), ("Front", "Back"), ("Low", "Top"))
    return sides[axis][int(off[axis] > 0)] + shape
