"""Straight skeletons: one face for each edge, tiling the polygon, in its edge's moving plane."""

from __future__ import annotations

import itertools
from time import process_time

import numpy as np
import pytest
from made_footprints import (
    COURT,
    L_SHAPE,
    NAMED,
    PLUS,
    SQUARE,
    Rings,
    area_of,
    hard_cases,
    rectilinear,
    regular,
    rings_of,
    star,
    the_300,
    turned,
    with_courtyards,
    with_more_corners,
    with_tiny_edges,
)
from numpy.random import default_rng
from shapely.geometry import Polygon
from shapely.ops import unary_union

from ipmlang.geometry import skeleton_contacts
from ipmlang.geometry.skeleton import MOST, Skeleton, moved_rings, straight_skeleton
from ipmlang.geometry.skeleton_rings import fit_rings
from ipmlang.geometry.solid import GeometryError


def offset_rings(
    rings: Rings, distance: float, speeds: list[float] | None = None
) -> list[tuple[np.ndarray, list[int]]]:
    """Moved rings as points and the numbers of their edges."""
    own = speeds or [1.0] * sum(map(len, rings))
    return [(ring.points, ring.edges) for ring in moved_rings(fit_rings(rings), distance, own)]


def face_areas(found: Skeleton) -> list[float]:
    """By an independent reader, which counts what crosses itself wrongly on purpose."""
    plan = found.vertices[:, :2]
    return [
        Polygon(plan[face], [plan[hole] for hole in found.holes.get(k, ())]).area if face else 0.0
        for k, face in enumerate(found.faces)
    ]


def check(rings: Rings, speeds: list[float] | None = None) -> Skeleton:
    """What is claimed of every skeleton, from its input alone."""
    found = straight_skeleton(rings, speeds)
    edges = [
        (ring[k], ring[(k + 1) % len(ring)])
        for ring in (np.array(ring, float) for ring in rings)
        for k in range(len(ring))
    ]
    assert len(found.faces) == len(edges)
    assert all(len(face) >= 3 for face in found.faces)
    size = float(np.ptp(np.array(rings[0]), axis=0).max())
    own = [1.0] * len(edges) if speeds is None else speeds
    for face, (start, end), speed in zip(found.faces, edges, own, strict=True):
        points = found.vertices[face]
        assert np.allclose(points[:2], [[*start, 0], [*end, 0]], atol=1e-9 * size)
        along = (end - start) / np.hypot(*(end - start))
        away = (points[:, :2] - start) @ (-along[1], along[0])
        assert np.abs(away - speed * points[:, 2]).max() <= 1e-9 * size * max(1, *own)
    assert sum(face_areas(found)) == pytest.approx(area_of(rings), rel=1e-9)
    return found


@pytest.mark.parametrize("first", range(0, 300, 50))
def test_the_300_footprints(first: int) -> None:
    for name, rings in itertools.islice(the_300(), first, first + 50):
        try:
            check(rings)
        except (GeometryError, AssertionError) as failure:
            pytest.fail(f"{name}: {failure}")


def test_only_corners_near_segments_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beyond some pairs of corners and segments boxes say which may meet; nothing is overlooked."""
    chosen = [rings for _, rings in itertools.islice(the_300(), 0, 300, 6)]
    chosen += [rings_of(star(default_rng(k), 60)) for k in range(3)]
    all_pairs = [straight_skeleton(rings) for rings in chosen]
    monkeypatch.setattr(skeleton_contacts, "FEW", 0)
    for rings, before in zip(chosen, all_pairs, strict=True):
        found = straight_skeleton(rings)
        assert (found.faces, found.holes) == (before.faces, before.holes)
        assert (found.vertices == before.vertices).all()


@pytest.mark.parametrize("seed", range(3))
def test_hard_cases(seed: int) -> None:
    for name, rings in hard_cases(seed):
        try:
            check(rings)
        except (GeometryError, AssertionError) as failure:
            pytest.fail(f"{name}: {failure}")


@pytest.mark.parametrize("off", [0.0, 1e-12, 1e-9, 1e-6, 1e-3])
def test_corners_on_edges_and_nearly_on_them(off: float) -> None:
    for k in range(15):
        chance = default_rng(k)
        rings = with_more_corners(rings_of(rectilinear(chance)), chance, off)
        if Polygon(rings[0], rings[1:]).is_valid:
            check(rings)


def test_tiny_edges() -> None:
    for k in range(30):
        chance = default_rng(k)
        make = [rectilinear, star, with_courtyards][k % 3]
        check(with_tiny_edges(rings_of(make(chance)), chance, 1e-3))


def test_faces_do_not_overlap() -> None:
    for rings in (L_SHAPE, COURT, rings_of(with_courtyards(default_rng(1)))):
        found = check(rings)
        shapes = [Polygon(found.vertices[face, :2]) for face in found.faces]
        assert all(shape.is_valid for shape in shapes)
        assert unary_union(shapes).area == pytest.approx(area_of(rings), rel=1e-9)


def test_turning_a_footprint_turns_its_skeleton() -> None:
    for k in range(20):
        rings = rings_of(rectilinear(default_rng(k)))
        still = face_areas(straight_skeleton(rings))
        assert face_areas(straight_skeleton(turned(rings, 0.7 * k))) == pytest.approx(still)


def test_size_and_place_do_not_matter() -> None:
    rings = rings_of(star(default_rng(4), 30))
    still = np.array(face_areas(straight_skeleton(rings)))
    for scale, far in ((1e-3, 0.0), (1.0, 5e5), (1e4, -3e6)):
        moved = [[(x * scale + far, y * scale - far) for x, y in ring] for ring in rings]
        found = np.array(face_areas(straight_skeleton(moved))) / scale**2
        assert np.allclose(found, still, rtol=1e-6, atol=1e-6)


def test_a_rectangle() -> None:
    found = straight_skeleton([[(0, 0), (5, 0), (5, 2), (0, 2)]])
    ridge = found.vertices[found.vertices[:, 2] > 0]
    assert sorted(ridge.round(12).tolist()) == [[1, 1, 1], [4, 1, 1]]
    assert face_areas(found) == pytest.approx([4, 1, 4, 1])


def test_what_meets_at_once_meets_in_one_vertex() -> None:
    for rings in (SQUARE, [regular(7)], [regular(200)]):
        found = straight_skeleton(rings)
        assert len(found.vertices) == len(rings[0]) + 1
    plus = straight_skeleton(PLUS)
    assert len(plus.vertices) == 12 + 5  # the wings' ends and the crossing


def test_edges_of_unequal_speed() -> None:
    found = check([[(0, 0), (4, 0), (4, 3), (0, 3)]], [2.0, 1.0, 1.0, 1.0])
    assert found.vertices[:, 2].max() == pytest.approx(1.0)  # 2 t + t = 3
    for k in range(40):
        chance = default_rng([3, k])
        make = [rectilinear, star, with_courtyards][k % 3]
        rings = rings_of(make(chance))
        check(rings, chance.uniform(0.2, 2, sum(map(len, rings))).tolist())


def test_an_edge_that_stays_gives_an_upright_face() -> None:
    found = check([[(0, 0), (5, 0), (5, 2), (0, 2)]], [1.0, 0.0, 1.0, 0.0])
    assert face_areas(found) == pytest.approx([5, 0, 5, 0])
    assert found.vertices[found.faces[1]].tolist() == [[5, 0, 0], [5, 2, 0], [5, 1, 1]]


def test_a_fast_edge_runs_around_a_slow_courtyard() -> None:
    outline = [(0.0, 0.0), (20.0, 0.0), (20.0, 40.0), (0.0, 40.0)]
    court = [(9.0, 4.0), (9.0, 5.0), (10.0, 5.5), (11.0, 5.0), (11.0, 4.0)]
    found = check([outline, court], [10.0, 1.0, 1.0, 1.0, 0.1, 0.1, 0.1, 0.1, 0.1])
    assert list(found.holes) == [0]
    assert len(found.holes[0]) == 1


def test_unequal_speeds_in_one_line_part_at_a_wall() -> None:
    rings = [[(0.0, 0.0), (3.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0)]]
    found = straight_skeleton(rings, [1.0, 2.0, 1.0, 1.0, 1.0])
    assert len(found.walls) == 1
    assert np.ptp(found.vertices[found.walls[0]][:, 0]) == 0
    assert sum(face_areas(found)) == pytest.approx(24)


def test_points_that_repeat_give_edges_without_a_face() -> None:
    found = straight_skeleton([[(0, 0), (4, 0), (4, 0), (4, 4), (0, 4), (0, 4 + 1e-12)]])
    assert [len(face) for face in found.faces] == [3, 0, 3, 3, 0, 3]
    assert face_areas(found) == pytest.approx([4, 0, 4, 4, 0, 4])


def test_rings_may_run_either_way() -> None:
    rings = [COURT[0][::-1], COURT[1][::-1]]
    still, found = face_areas(straight_skeleton(COURT)), face_areas(straight_skeleton(rings))
    # The reversed ring's edge k is the edge from its point k, too.
    assert found == pytest.approx([*still[2::-1], still[3], *still[6:3:-1], still[7]])
    unequal = offset_rings(rings, 1.0, [0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0])[0][0]
    assert unequal.min(axis=0).tolist() == [0.0, 0.5]  # edge 2 is the lowest side


@pytest.mark.parametrize(
    "hole",
    [
        [(5, 0), (3, 3), (7, 3)],
        [(0, 0), (1, 3), (3, 1)],
        [(10, 10), (9, 7), (7, 9)],
        [(5, 0), (0, 5), (5, 10), (10, 5)],
    ],
)
def test_holes_may_touch_the_outline(hole: list[tuple[float, float]]) -> None:
    check([[(0, 0), (10, 0), (10, 10), (0, 10)], hole])


def test_holes_may_touch_each_other() -> None:
    check([COURT[0], [(2, 2), (2, 5), (5, 5)], [(5, 5), (8, 8), (8, 5)]])


def test_upright_edges_all_around_are_refused() -> None:
    rings = [[(0, 0), (2, 0), (2, 2), (2.5, 2), (2.5, -3), (5, -3), (5, 4), (0, 4)]]
    speeds = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    with pytest.raises(GeometryError, match="enclose") as caught:
        straight_skeleton(rings, speeds)
    assert caught.value.hint


def test_a_spike_is_left_out() -> None:
    found = straight_skeleton([[(0, 0), (4, 0), (4, 2), (9, 2), (4, 2), (4, 4), (0, 4)]])
    assert sum(face_areas(found)) == pytest.approx(16)


@pytest.mark.parametrize(
    ("rings", "speeds", "message"),
    [
        ([[(0, 0), (4, 4), (4, 0), (0, 4)]], None, "crosses itself"),
        ([[(0, 0), (4, 0), (8, 0)]], None, "no area"),
        ([[(0, 0), (4, 0)]], None, "no area"),
        ([], None, "rings"),
        ([[(0, 0), (4, 0), (float("nan"), 4)]], None, "numbers"),
        ([COURT[0], [(20, 20), (21, 20), (21, 21)]], None, "outside"),
        ([COURT[0], [(10, 10), (14, 10), (14, 14), (10, 14)]], None, "crosses itself"),
        ([*COURT, [(5, 5), (5, 6), (6, 6)]], None, "within another"),
        ([SQUARE[0], [(1, 0), (3, 0), (3, 2)]], None, "proved right"),
        (SQUARE, [1, 1, 1], "4 edges need 4 speeds"),
        (SQUARE, [1, 1, 1, -1], "at least 0"),
        (SQUARE, [0, 0, 0, 0], "no edge moves"),
    ],
)
def test_bad_input(rings: Rings, speeds: list[float] | None, message: str) -> None:
    with pytest.raises(GeometryError, match=message):
        straight_skeleton(rings, speeds)


def test_moving_edges_of_rectilinear_rings_is_erosion_by_a_square() -> None:
    for k in range(20):
        rings = rings_of(rectilinear(default_rng([9, k])))
        shape = Polygon(rings[0], rings[1:])
        for distance in (0.3, 0.7, 1.3, 2.2, -0.4, -1.2):
            moved = offset_rings(rings, distance)
            # Shapely's mitred buffers go wrong where edges vanish; squares never do.
            expected = _eroded(shape, distance)
            assert _area(moved) == pytest.approx(expected, abs=1e-9), (k, distance)


def _area(rings: list[tuple[np.ndarray, list[int]]]) -> float:
    return sum(
        float(ring[:, 0] @ np.roll(ring[:, 1], -1) - ring[:, 1] @ np.roll(ring[:, 0], -1)) / 2
        for ring, _ in rings
    )


def _eroded(shape: Polygon, distance: float) -> float:
    """The area after erosion (or growth) by squares: what their sides cover, taken off (or on)."""
    boundary = []
    for ring in (shape.exterior, *shape.interiors):
        points = list(ring.coords)
        for (ax, ay), (bx, by) in itertools.pairwise(points):
            d = abs(distance)
            low, high = (min(ax, bx) - d, min(ay, by) - d), (max(ax, bx) + d, max(ay, by) + d)
            boundary.append(Polygon([low, (high[0], low[1]), high, (low[0], high[1])]))
    band = unary_union(boundary)
    return float((shape.difference(band) if distance > 0 else shape.union(band)).area)


def test_moved_edges_are_known_by_number() -> None:
    (ring, edges), (court, inner) = offset_rings(COURT, 1.0)
    assert sorted(edges) == [0, 1, 2, 3] and sorted(inner) == [4, 5, 6, 7]
    for points, own in ((ring, edges), (court, inner)):
        for k, edge in enumerate(own):
            start = np.array((COURT[0] + COURT[1])[edge])
            side = COURT[0] if edge < 4 else COURT[1]
            end = np.array(side[(side.index(tuple(start)) + 1) % 4])
            onward = points[(k + 1) % 4] - points[k]
            assert onward @ (end - start) > 0
            assert abs(onward[0] * (end - start)[1] - onward[1] * (end - start)[0]) < 1e-12


def test_moving_edges_by_nothing_or_too_much() -> None:
    ((ring, edges),) = offset_rings(SQUARE, 0.0)
    assert ring.tolist() == [list(map(float, point)) for point in SQUARE[0]]
    assert edges == [0, 1, 2, 3]
    assert offset_rings(SQUARE, 2.5) == []


@pytest.mark.parametrize(
    ("rings", "seconds"),
    [
        (NAMED["rectangle"], 0.001),
        (rings_of(star(default_rng(3), 12)), 0.004),
        ([regular(200)], 0.4),
        (rings_of(star(default_rng(3), 200)), 0.4),
    ],
    ids=["rectangle", "12 corners", "200-gon", "200-corner star"],
)
def test_speed(rings: Rings, seconds: float) -> None:
    """Within ten times the aim, whatever else the machine does; tests/bench measures exactly."""
    straight_skeleton(rings)
    start = process_time()
    straight_skeleton(rings)
    assert process_time() - start < 10 * seconds


def test_too_many_corners_are_refused_before_the_work() -> None:
    start = process_time()
    with pytest.raises(GeometryError, match="10,000 corners"):
        straight_skeleton([regular(10_000)])
    assert process_time() - start < 5
    assert MOST >= 1000


def test_crossings_of_many_edges_are_found() -> None:
    """Beyond a few edges only those whose boxes meet are looked at."""
    ring = [(float(x), float(y)) for x, y in regular(300)]
    ring[10], ring[12] = ring[12], ring[10]
    with pytest.raises(GeometryError, match="crosses itself"):
        straight_skeleton([ring])
