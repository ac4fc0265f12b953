"""`trim`: what stands on faces is cut where it meets what stands on the faces beside them."""

from __future__ import annotations

import numpy as np
import pytest

import ipmlang
from ipmlang.geometry.mitres import mitres
from ipmlang.geometry.solid import Solid, is_closed, placed, polygon, unit_box, volume
from ipmlang.runtime.scene import SOLID, Scene

L = "polygon [(0,0), (12,0), (12,4), (6,4), (6,9), (0,9)]"
TRIANGLE = "polygon [(0,0), (10,0), (5, 8)]"
RING = (
    "Lot --> extrude(6) comp { side: Facade }\n"
    "Facade --> translate(-9, 0, 0) size(scope.sx + 18, scope.sy, 0) extrude(0.5) trim Ledge"
)


def drawn(rules: str, place: str = "box(10, 6, 0)") -> Scene:
    return ipmlang.parse(f"ipm 1\n{rules}\nstart Lot on {place}\n").run()


def solids(scene: Scene) -> list[Solid]:
    made = []
    for row, size in enumerate(scene.instances.size):
        own = unit_box()
        if scene.instances.asset[row] == SOLID:
            own = scene.solids[int(scene.instances.shape[row])]
        made.append(placed(own, size * abs(scene.instances.scale[row]), (0, 0, 0)))
    assert all(map(is_closed, made))
    return made


def whole(scene: Scene) -> float:
    return sum(map(volume, solids(scene)))


def outset(corners: list[tuple[float, float]], distance: float) -> float:
    import shapely

    shape = shapely.Polygon(corners)
    return float(shape.buffer(distance, join_style="mitre", mitre_limit=99).area - shape.area)


@pytest.mark.parametrize(
    ("place", "corners"),
    [
        (L, [(0, 0), (12, 0), (12, 4), (6, 4), (6, 9), (0, 9)]),
        (TRIANGLE, [(0, 0), (10, 0), (5, 8)]),
        ("box(10, 6, 0)", [(0, 0), (10, 0), (10, 6), (0, 6)]),
    ],
)
def test_slabs_around_a_footprint_meet_without_gaps(
    place: str, corners: list[tuple[float, float]]
) -> None:
    scene = drawn(RING, place)
    assert len(scene.instances) == len(corners)
    assert whole(scene) == pytest.approx(6 * outset(corners, 0.5))


@pytest.mark.parametrize("place", [L, TRIANGLE])
def test_slabs_within_a_footprint_meet_without_overlap(place: str) -> None:
    rules = "Lot --> extrude(6) comp { side: Facade }\nFacade --> extrude(-0.5) trim Slab"
    plain = whole(drawn(rules.replace(" trim", ""), place))
    scene = drawn(rules, place)
    joined = drawn(f"Lot --> union {{ {rules.partition('--> ')[2].partition(chr(10))[0]} }}\n"
                   "Facade --> extrude(-0.5) trim Slab", place)  # fmt: skip
    assert whole(scene) == pytest.approx(whole(joined))
    assert whole(scene) < plain - 1


def test_what_a_face_is_split_into_keeps_its_planes() -> None:
    rules = RING.replace(
        "trim Ledge", "split y { { ~2: Strip }* }\nStrip --> split x { ~1: P | ~1: P }\n"
        "P --> trim Ledge"
    )  # fmt: skip
    assert whole(drawn(rules, L)) == pytest.approx(whole(drawn(RING, L)))


def test_turned_scaled_and_mirrored_lots_are_trimmed_alike() -> None:
    turned = RING.replace("Lot -->", "Lot --> rotate(20, 30, 40) *(2) mirrorScope(x)")
    ledges = turned.replace("trim", "")
    assert whole(drawn(turned, L)) == pytest.approx(
        whole(drawn(ledges, L)) * whole(drawn(RING, L)) / whole(drawn(RING.replace("trim", ""), L))
    )


def test_without_a_comp_nothing_is_cut() -> None:
    assert whole(drawn("Lot --> extrude(2) trim Mass")) == pytest.approx(120)


def test_a_shape_beyond_its_face_is_cut_away() -> None:
    rules = "Lot --> extrude(6) comp { front: translate(30, 0, 0) extrude(1) trim Mass }"
    assert len(drawn(rules).instances) == 0


def test_a_face_with_an_inner_corner_is_not_cut_itself() -> None:
    rules = "Lot --> extrude(6) comp { top: extrude(1) trim Top }"
    assert whole(drawn(rules, L)) == pytest.approx(12 * 4 + 6 * 5)


def test_equal_shapes_are_trimmed_once() -> None:
    rules = (
        "Lot --> split x { { ~1: House }* }\nHouse --> size(0.5, 1, 0) extrude(2) "
        "comp { side: Wall }\nWall --> extrude(-0.1) trim(vertical) Slab"
    )
    scene = drawn(rules, "box(400, 1, 0)")
    assert len(scene.instances) == 1600
    assert len(scene.solids) < 20
    assert whole(scene) == pytest.approx(400 * 2 * (0.5 - 0.3 * 0.8))


def test_vertical_and_horizontal_edges() -> None:
    rules = "Lot --> extrude(6) comp {{ front: extrude(-1) trim{} Slab }}"
    found = [whole(drawn(rules.format(edges))) for edges in ("(vertical)", "(horizontal)", "")]
    assert found == pytest.approx([9 * 6, 10 * 5, 10 * 6 - 16 + 4 / 3])


def test_planes_of_a_box_halve_its_edges() -> None:
    points, planes = mitres(unit_box(), 2)
    half = np.sqrt(0.5)
    assert len(points) == 4
    assert np.allclose(np.sort(planes[:, 1]), half)
    assert np.allclose(planes.sum(axis=0), (0, 4 * half, 0))


def test_a_polygon_has_no_neighbours() -> None:
    assert len(mitres(polygon([(0, 0), (1, 0), (1, 1)]), 0)[0]) == 0
