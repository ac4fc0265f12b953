"""Every operation that makes or takes apart geometry, in grammars, on a box and on an L.

What is closed stays closed, what is taken apart adds up to the whole. The geometry itself is tested
in tests/geometry; here it goes through scopes, frames and the pool.
"""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import ipmlang
from ipmlang.geometry.solid import Solid, area, is_closed, placed, unit_box, unit_square, volume
from ipmlang.runtime.scene import SCOPE, Scene

BOX = "on box(8, 11, 0)"
ELL = "on polygon [(0, 0), (12, 0), (12, 4), (5, 4), (5, 9), (0, 9)]"
AREAS = {BOX: 88.0, ELL: 73.0}


def run(text: str) -> Scene:
    return ipmlang.parse("ipm 1\n" + text).run()


def names(scene: Scene) -> Counter[str]:
    return Counter(scene.labels[label] for label in scene.instances.label)


def solids(scene: Scene, name: str | None = None) -> list[Solid]:
    """The geometry of terminals, in their scopes."""
    table = scene.instances
    found = []
    for row in range(len(table)):
        if name is not None and scene.labels[table.label[row]] != name:
            continue
        size = table.size[row]
        if table.asset[row] == SCOPE:
            unit = unit_box() if size.all() else unit_square()
        else:
            unit = scene.solids[table.shape[row]]
        found.append(placed(unit, size, (0, 0, 0)))
    return found


@pytest.mark.parametrize("ground", [BOX, ELL])
@pytest.mark.parametrize(
    "operation",
    ["extrude(3)", "extrude(-3)", "extrude(3, along: up)", "taper(4, 0.5)", "taper(4)",
     "roofHip(30)", "roofHip(30, overhang: 0.5)", "roofGable(35)",
     "roofGable(35, overhang: 0.4, ridge: 90)", "roofShed(12)", "roofPyramid(4)",
     "roofMansard(70, 1, 25)", "envelope(18, front: 1, angle: 60)", "cube",
     "size(1, 2, 3) cylinder", "size(1, 2, 3) cone(8)", "size(1, 2, 3) sphere(12)",
     "extrude(2) convert(box)",
     "extrude(3) rotateScope(10, 20, 30)", "extrude(3) rotate(30, 20, 10) alignScopeToAxes",
     "roofHip(30) alignScopeToGeometry", "extrude(3) mirrorScope(y)", 'extrude(3) tag("q")'],
)  # fmt: skip
def test_what_makes_a_solid_makes_a_closed_one(operation: str, ground: str) -> None:
    if operation == "cube":
        operation = "size(1, 1, 1) cube"
    scene = run(f"A --> {operation} B\nstart A {ground}\n")
    (solid,) = solids(scene, "B")
    assert is_closed(solid) and volume(solid) > 0
    if operation.startswith("extrude(3)"):
        assert volume(solid) == pytest.approx(3 * AREAS[ground], rel=1e-9)


@pytest.mark.parametrize("ground", [BOX, ELL])
@pytest.mark.parametrize(
    "operation",
    ["setback(0.5) { shape: B | border: C }", "setback(0.5, front: 2) { shape: B | border: C }",
     "offset(-0.5) { inside: B | border: C }", "innerRect { shape: B | rest: C }",
     "shapeL(3, 2) { shape: B | rest: C }", "shapeU(3, 2, 2) { shape: B | rest: C }",
     "shapeO(1, 1, 1, 1) { shape: B | rest: C }", "split area { 10: B | ~1: C }", "comp { all: B }",
     "split x { { ~2: B }* }", "split y { 3: B | '0.2: C | ~1: B }", "subdivide(3, 2, 1) B",
     "[octant(4, 3, 0, 1) B] [octant(4, 3, 0, 2) B] [octant(4, 3, 0, 3) B] [octant(4, 3, 0, 4) B]"],
)  # fmt: skip
def test_what_takes_a_polygon_apart_keeps_its_area(operation: str, ground: str) -> None:
    scene = run(f"A --> {operation}\nstart A {ground}\n")
    assert sum(map(area, solids(scene))) == pytest.approx(AREAS[ground], rel=1e-9)


def test_areas_are_those_asked_for() -> None:
    scene = run(f"A --> split area {{ 10: B | 20: C | ~1: D }}\nstart A {ELL}\n")
    assert [area(solids(scene, name)[0]) for name in "BC"] == pytest.approx([10, 20])
    scene = run(f"A --> setback(0, area: 20) {{ shape: B }}\nstart A {ELL}\n")
    assert sum(map(area, solids(scene, "B"))) == pytest.approx(20)


def test_strips_of_a_setback_turn_with_their_edges() -> None:
    """x along the edge, y inward: whatever the edge, a strip is as long and as wide as it is."""
    scene = run(
        "A --> setback(1) { border: Lawn | shape: Mass }\n"
        "start A on polygon [(0, 0), (8, 6), (2, 14), (-6, 8)]\n"
    )
    table = scene.instances
    lawns = table.label == scene.labels.index("Lawn")
    assert table.size[lawns] == pytest.approx(np.tile((10.0, 1.0, 0.0), (4, 1)))
    along = 2 * np.degrees(np.arctan2(table.rotation[lawns, 3], table.rotation[lawns, 0]))
    assert np.diff(along, append=along[:1]) % 360 == pytest.approx([90, 90, 90, 90])
    corners = [(0, 0), (8, 6), (2, 14), (-6, 8)]
    assert table.position[lawns, :2] == pytest.approx(np.array(corners, float))
    assert table.rotation[~lawns] == pytest.approx(table.rotation[lawns][:1])  # of the shape


def test_points_that_draw_nothing_are_told() -> None:
    ground = "start A on box(9, 9, 0)\n"
    (note,) = run(f"A --> [Lawn] scatter(20) Tree\n{ground}").notes
    assert "Tree draws nothing" in note and "20 shapes" in note
    assert not run(f"A --> [Lawn] scatter(9) size(1, 1, 1) cube Tree\n{ground}").notes
    asked = (
        f'A --> [Lawn] [scatter(9) label("spot") Spot] B\nB : distance("spot") < 9 --> C\n{ground}'
    )
    assert not run(asked).notes  # it stands for a place


def test_roofs_are_selected_by_their_parts() -> None:
    scene = run(
        f"A --> roofGable(30) comp {{ slope: B | gable: C | bottom: nil }}\nstart A {ELL}\n"
    )
    assert names(scene) == {"B": 4, "C": 2}
    scene = run(
        f"A --> roofHip(30) comp(edges) {{ ridge: B | eave: C | hip: D | valley: E }}\n"
        f"start A {BOX}\n"
    )
    assert names(scene) == {"B": 1, "C": 4, "D": 4}
    ridge = scene.instances.size[scene.instances.label == scene.labels.index("B")]
    assert ridge[0, 0] == pytest.approx(11 - 8)


@pytest.mark.parametrize("over", ["surface", "volume", "scope"])
def test_scattered_points_lie_where_they_should(over: str) -> None:
    scene = run(f"A --> extrude(3) scatter(200, over: {over}) size(0.1, 0.1, 0.1) cube B\n"
                f"start A {ELL}\n")  # fmt: skip
    places = scene.instances.position
    assert len(places) == 200 == len(np.unique(places, axis=0))
    assert (places >= -1e-9).all() and (places <= np.array((12, 9, 3)) + 1e-9).all()
    inside = (places[:, 0] <= 5 + 1e-9) | (places[:, 1] <= 4 + 1e-9)
    assert inside.all() == (over != "scope")
    again = run(f"A --> extrude(3) scatter(200, over: {over}) size(0.1, 0.1, 0.1) cube B\n"
                f"start A {ELL}\n")  # fmt: skip
    assert again.instances.position.tobytes() == places.tobytes()


def test_faces_of_an_asset_that_was_inserted(tmp_path) -> None:  # type: ignore[no-untyped-def]
    corners = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv 1 0.5 3\n"
    obj = f"{corners}f 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"
    (tmp_path / "hat.obj").write_text(obj, encoding="utf-8")
    text = 'ipm 1\nasset hat = "hat.obj"\nA --> insert(hat) B\nstart A on box(4, 4, 4)\n'
    scene = ipmlang.parse(text, folder=tmp_path).run()
    assert scene.instances.asset.tolist() == [0]
    assert scene.instances.size.tolist() == [[4, 4, 4]]
    text = text.replace("insert(hat) B", "insert(hat, fit: inside, align: bottom) B")
    scene = ipmlang.parse(text, folder=tmp_path).run()
    assert scene.instances.size[0] == pytest.approx((8 / 3, 4 / 3, 4))
    assert scene.instances.position[0] == pytest.approx((2 / 3, 4 / 3, 0))
    text = text.replace("insert(hat, fit: inside, align: bottom) B", "insert(hat) split z { 1: B }")
    scene = ipmlang.parse(text, folder=tmp_path).run()
    (frustum,) = solids(scene)
    assert is_closed(frustum)
    assert volume(frustum) == pytest.approx(16 * 4 / 3 * (1 - (3 / 4) ** 3))


def test_an_asset_is_stretched_where_it_stands_and_where_it_is_inserted(tmp_path: Path) -> None:
    (tmp_path / "hat.obj").write_text("o a\nv 1 0 0\nv 2 0 0\nv 2 1 3\nf 1 2 3\n", encoding="utf-8")
    asset = 'ipm 1\naxes z-up\nasset a in "hat.obj" stretch (1.5, 1, 2)\n'
    placed = ipmlang.parse(
        asset + "A --> translate(1, 0, 0) a\nstart A on box(1, 1, 1)\n", folder=tmp_path
    ).run()
    ipmlang.save(placed, tmp_path / "out.obj")
    written = (tmp_path / "out.obj").read_text(encoding="utf-8").splitlines()
    corners = [each.split()[1:] for each in written if each.startswith("v ")]
    wanted = [[2.5, 0, 0], [4, 0, 0], [4, 1, 6]]
    assert sorted([float(x) for x in each] for each in corners) == wanted
    inserted = ipmlang.parse(
        asset + "A --> insert(a, fit: inside) B\nstart A on box(3, 9, 9)\n", folder=tmp_path
    ).run()
    assert inserted.instances.size.tolist() == [[2.25, 1.5, 9]]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("A --> roofHip(95) B", "roof"),
        ("A --> extrude(0) B", "extrude"),
        ("A --> extrude(2) extrude(3) B", "raise"),
        ("A --> scatter(-3) B", "scatter"),
        ("A --> size(-1, 1, 1) B", "size"),
        ("A --> octant(1, 1, 0, 9) B", "octant"),
        ("A --> extrude(sqrt(0 - 1)) B", "number"),
    ],
)
def test_what_cannot_be_made_names_the_rule(text: str, said: str) -> None:
    with pytest.raises(ipmlang.IpmError) as caught:
        run(f"{text}\nstart A {BOX}\n")
    assert said in str(caught.value)
    assert "A" in str(caught.value)


def test_a_hip_roof_has_the_height_that_its_slope_says() -> None:
    scene = run(f"A --> roofHip(40) B\nstart A {BOX}\n")
    assert scene.instances.size[0] == pytest.approx((8, 11, 4 * math.tan(math.radians(40))))


def test_a_polygon_that_is_given_a_height_is_a_prism() -> None:
    ground = "on polygon [(0, 0), (4, 0), (0, 4)]"
    scene = run(f"A --> size(scope.sx, scope.sy, 0.5) B\nstart A {ground}\n")
    (prism,) = solids(scene)
    assert is_closed(prism) and volume(prism) == pytest.approx(4)
    scene = run(f"A --> size(scope.sx, scope.sy, 0) B\nstart A {ground}\n")
    assert area(solids(scene)[0]) == pytest.approx(8)
    scene = run(f"A --> size(2, 2, 3) split z {{ 1: B | ~1: C }}\nstart A {ground}\n")
    assert [volume(each) for each in solids(scene)] == pytest.approx([2, 4])


@pytest.mark.parametrize(
    "operation",
    ["setback(1) { all: B }", "comp { all: B }", "comp(edges) { all: B }", "innerRect { shape: B }",
     "scatter(3) B", "extrude(2) B", "roofHip(30) B"],
)  # fmt: skip
def test_nothing_comes_of_no_geometry(operation: str) -> None:
    """A turtle's shape has none, in a batch where no other has any."""
    assert len(run(f"A --> F(1) [C]\nC --> {operation}\nstart A\n").instances) == 1
