"""What is worked out for many polygons at once is what the general algorithms give of each by
itself: on thousands of random polygons, those that nearly touch or nearly vanish among them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import shapely

from ipmlang.geometry.edges import edges, edges_of
from ipmlang.geometry.faces import faces, faces_of
from ipmlang.geometry.footprints import footprint, sound
from ipmlang.geometry.pieces import Piece
from ipmlang.geometry.raising import extrude, extrusions
from ipmlang.geometry.roof_ridges import FACING, gables_of_four
from ipmlang.geometry.roofs import roof_gable, roof_hip
from ipmlang.geometry.roofs_together import roofs
from ipmlang.geometry.setbacks import setback
from ipmlang.geometry.setbacks_together import setbacks
from ipmlang.geometry.skeleton import straight_skeleton
from ipmlang.geometry.solid import (
    Floats,
    GeometryError,
    Solid,
    is_closed,
    makeup,
    polygon,
    ring_points,
)

MANY = 1500


def ring(draw: np.random.Generator) -> Floats:
    """A star of 3 to 8 corners somewhere, or a near-rectangle; some have corners in one place or in
    one line.
    """
    if draw.random() < 0.5:
        w, h = draw.uniform(1, 20, 2)
        points = np.array([(0, 0), (w, 0), (w, h), (0, h)]) + draw.uniform(-1, 1, (4, 2))
    else:
        angles = np.sort(draw.uniform(0, 2 * np.pi, draw.integers(3, 9)))
        radii = draw.uniform(2, 12, len(angles))
        points = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)
    if draw.random() < 0.1:
        points[1] = points[0] + draw.choice([0.0, 1e-12, 1e-6]) * (points[2] - points[0])
    moved: Floats = points + draw.uniform(-50, 50, 2)
    return moved


def lots(seed: int, count: int = MANY) -> list[Solid]:
    draw = np.random.default_rng(seed)
    return [polygon(ring(draw), tags=["lot"] * int(draw.integers(0, 2))) for _ in range(count)]


def same(one: Solid, other: Solid) -> bool:
    """Whether two solids are the same to the last bit."""
    return makeup(one) == makeup(other) and bool((one.vertices == other.vertices).all())


def same_pieces(some: Sequence[Piece], others: Sequence[Piece]) -> bool:
    return len(some) == len(others) and all(
        a.words == b.words
        and same(a.solid, b.solid)
        and ((a.axes is None and b.axes is None) or np.array_equal(a.axes, b.axes))  # type: ignore[arg-type]
        for a, b in zip(some, others, strict=True)
    )


def test_setbacks_are_those_of_each_by_itself() -> None:
    polygons = lots(1)
    draw = np.random.default_rng(2)
    widths = draw.uniform(0, 2, (MANY, 4)) * (draw.random((MANY, 4)) < 0.8)
    widths[:, 1:][draw.random((MANY, 3)) < 0.4] = np.nan
    served = 0
    for one, row, made in zip(polygons, widths, setbacks(polygons, widths), strict=True):
        if made is not None:
            given = [None if np.isnan(each) else float(each) for each in row]
            assert given[0] is not None
            assert same_pieces(made, setback(one, given[0], *given[1:]))
            served += 1
    assert served > MANY / 2


def test_outlines_that_are_sound_are_taken_as_they_are() -> None:
    draw = np.random.default_rng(7)
    rings = [ring(draw)[:: -1 if k % 7 == 0 else 1] for k in range(MANY)]
    rings += [np.array([(0, 0), (2, 2), (2, 0), (0, 2)]), np.array([(0, 0), (1, 0), (2, 0)]),
              np.array([(0, 0), (np.nan, 0), (1, 1)]), np.zeros((2, 2)),
              np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0.1)])]  # fmt: skip
    taken = sound(rings).tolist()
    assert not any(taken[MANY:])
    assert sum(taken) > MANY / 2
    for one, yes in zip(rings, taken, strict=True):
        if yes:
            (made,), notes = footprint([one])
            assert not notes
            assert same(made, polygon(one))


def test_extrusions_are_those_of_each_by_itself() -> None:
    polygons = lots(3, 300)
    heights = np.random.default_rng(4).choice([3.0, -2.0, 0.0, 1e-7], len(polygons))
    up = np.tile((0.0, 0.6, 0.8), (len(polygons), 1))
    for directions in (None, up):
        many = extrusions(polygons, heights, directions)
        for one, height, made in zip(polygons, heights.tolist(), many, strict=True):
            if made is None:
                with pytest.raises(GeometryError):
                    extrude(one, height, None if directions is None else up[0])
                continue
            alone = extrude(one, height, None if directions is None else up[0])
            assert makeup(made) == makeup(alone)
            assert made.vertices == pytest.approx(alone.vertices, abs=1e-12)


def test_faces_are_those_of_each_by_itself() -> None:
    solids = [extrude(one, 2.0) for one in lots(5, 200)] + lots(6, 100)
    for one, many in zip(solids, faces_of(solids), strict=True):
        assert same_pieces(many, faces(one))


def test_edges_are_those_of_each_by_itself() -> None:
    solids = [extrude(one, 2.0) for one in lots(5, 60)]
    solids += [roof for one in lots(11, 60) for roof in roofs_of(one)] + lots(12, 30)
    for one, many in zip(solids, edges_of(solids), strict=True):
        assert same_pieces(many, edges(one))


def roofs_of(polygon_: Solid) -> list[Solid]:
    """A hip roof, of what bears one."""
    try:
        return [roof_hip(polygon_, 40)]
    except GeometryError:
        return []


def quadrilateral(draw: np.random.Generator) -> Floats:
    """Rectangles, squares, parallelograms, circles' corners and any four points, more or less
    disturbed: ties of moments and folds are among them.
    """
    w, h = draw.uniform(1, 20, 2)
    rectangle = np.array([(0, 0), (w, 0), (w, h), (0, h)])
    angles = np.sort(draw.uniform(0, 2 * np.pi, 4))
    kinds = [
        rectangle + draw.uniform(-1, 1, (4, 2)) * draw.choice([0.0, 1e-9, 1e-3, 0.3, 1.0]),
        rectangle / (w, h) * w + draw.uniform(-1, 1, (4, 2)) * draw.choice([0.0, 1e-12, 1e-5]),
        rectangle + np.array([(0, 0), (0, 0), (1, 1), (1, 1)]) * draw.uniform(-5, 5, 2),
        np.stack([np.cos(angles), np.sin(angles)], axis=1) * 10,
        draw.uniform(-10, 10, (4, 2)),
    ]
    points = kinds[int(draw.integers(len(kinds)))]
    turn = draw.uniform(0, 2 * np.pi) * draw.integers(2)
    cosine, sine = np.cos(turn), np.sin(turn)
    moved: Floats = points @ np.array([(cosine, sine), (-sine, cosine)]) + draw.uniform(-99, 99, 2)
    return moved


def bent(points: Floats, near: float) -> Floats:
    """A ring (n, 3) without points at the place of the one before, or in the middle of an edge."""
    points = points[np.abs(points - np.roll(points, 1, axis=0)).max(axis=1) > near]
    back, on = np.roll(points, 1, axis=0) - points, np.roll(points, -1, axis=0) - points
    (a, b, c), (u, v, w) = back.T, on.T
    across = np.sqrt((b * w - c * v) ** 2 + (c * u - a * w) ** 2 + (a * v - b * u) ** 2)
    span = np.sqrt(np.maximum((back**2).sum(axis=1), (on**2).sum(axis=1)))
    kept: Floats = points[across > near * span]
    return kept


def assert_same_faces(one: Solid, other: Solid, near: float) -> None:
    """The same faces with the same tags, but for points in the middle of straight edges."""
    assert one.tags == other.tags
    for face in range(len(one)):
        for mine, yours in zip(ring_points(one, face), ring_points(other, face), strict=True):
            left, right = bent(mine, near), bent(yours, near)
            assert left.shape == right.shape
            assert np.abs(left - right).max() <= near


@pytest.mark.parametrize("gabled", [False, True])
def test_roofs_are_those_of_the_general_algorithm(gabled: bool) -> None:
    draw, many = np.random.default_rng(8), 600
    polygons = [polygon(quadrilateral(draw)) for _ in range(many)]
    degrees, overhang = draw.uniform(2, 80, many), draw.choice([0.0, 0.4, 3.0], many)
    ridge = draw.choice([np.nan, 0.0, 33.0], many)
    served = 0
    for k, made in enumerate(roofs(polygons, degrees, overhang, ridge, gabled=gabled)):
        if made is None:
            continue
        served += 1
        assert is_closed(made)
        angle, reach = float(degrees[k]), float(overhang[k])
        if gabled:
            way = None if np.isnan(ridge[k]) else float(ridge[k])
            alone = roof_gable(polygons[k], angle, reach, way)
        else:
            alone = roof_hip(polygons[k], angle, reach)
        size = float(np.ptp(alone.vertices, axis=0).max())
        assert_same_faces(made, alone, 1e-7 * size)
    assert served > many / 2


def test_gables_of_four_stand_on_triangles_of_the_hip_roof() -> None:
    """By definition: sides between sides that face each other, whose faces of a hip roof are
    triangles, the most upright on the ridge first, never two that touch.
    """
    draw, many = np.random.default_rng(9), 800
    corners = [quadrilateral(draw) for _ in range(many)]
    corners = [each for each in corners if shapely.Polygon(each).is_valid
               and shapely.Polygon(each).convex_hull.area < shapely.Polygon(each).area * (1 + 1e-9)
               and shapely.LinearRing(each).is_ccw]  # fmt: skip
    marks = gables_of_four(np.array(corners), np.full(len(corners), np.nan))
    seen = 0
    for each, gables in zip(corners, marks, strict=True):
        faces_ = straight_skeleton([each]).faces
        along = np.roll(each, -1, axis=0) - each
        facing = np.roll(along, 1, axis=0), np.roll(along, -1, axis=0)
        cosine = (facing[0] * facing[1]).sum(axis=1)
        cosine /= np.linalg.norm(facing[0], axis=1) * np.linalg.norm(facing[1], axis=1)
        fit = np.array([len(face) == 3 for face in faces_]) & (cosine < FACING)
        if fit.any() and len(set(map(len, faces_))) == 2:
            assert not (gables & ~fit).any()
            assert gables.any()
            seen += 1
        assert not (gables & np.roll(gables, 1)).any()
    assert seen > many / 4
