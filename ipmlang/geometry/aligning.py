"""The axes that a solid's own faces suggest for its scope."""

from __future__ import annotations

import numpy as np

from ipmlang.geometry.faces import face_scopes
from ipmlang.geometry.solid import (
    Floats,
    GeometryError,
    Solid,
    area_vectors,
    chosen,
    normals,
    ring_points,
)


def alignment(solid: Solid, edge: str = "lowest") -> Floats:
    """Unit axes (3, 3), rows x, y, z: z out of the largest face, x along an edge of its outline.

    lowest: as `comp` gives it to that face. longest and first: in the sense in which the outline
    runs. Of equal faces and edges the first counts. GeometryError where no face has an area.

    >>> from ipmlang.geometry.solid import placed, unit_box
    >>> alignment(placed(unit_box(), (4, 1, 2), (0, 0, 0))).tolist()
    [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]
    """
    largest = largest_face(solid)
    if edge == "lowest":
        axes: Floats = face_scopes(chosen(solid, [largest])).axes[0]
        return axes
    z = normals(solid)[largest]
    outline = ring_points(solid, largest)[0]
    ahead = np.roll(outline, -1, axis=0) - outline
    length = np.sqrt(np.einsum("ij,ij->i", ahead, ahead))
    least = length.max() * (1 - 1e-9 if edge == "longest" else 1e-9)
    x = ahead[np.argmax(length >= least)]
    x = x - (x @ z) * z
    x = x / np.sqrt(x @ x)
    return np.stack([x, np.cross(z, x), z])


def largest_face(solid: Solid) -> int:
    """The number of the face with the largest area, the first of equal ones."""
    vectors = area_vectors(solid)
    square = np.einsum("ij,ij->i", vectors, vectors)
    if not square.any():
        raise GeometryError(
            "there is no face to align the scope to", "align a polygon or a solid with faces"
        )
    return int(np.argmax(square >= square.max() * (1 - 1e-9)))
