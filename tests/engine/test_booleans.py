"""`union`, `subtract` and `intersect` between parts of a rule: one solid for what they draw."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ipmlang
from ipmlang.geometry.solid import Solid, is_closed, placed, unit_box, volume
from ipmlang.runtime.scene import SCOPE, SOLID, Scene


def drawn(rules: str, **more: object) -> Scene:
    text = f"ipm 1\n{rules}\n"
    if "start" not in text:
        text += "start Lot on box(10, 6, 4)\n"
    return ipmlang.parse(text).run(**more)  # type: ignore[arg-type]


def solid(scene: Scene, row: int = 0) -> Solid:
    size = scene.instances.size[row]
    if scene.instances.asset[row] == SCOPE:
        return placed(unit_box(), size, (0, 0, 0))
    assert scene.instances.asset[row] == SOLID
    return placed(scene.solids[int(scene.instances.shape[row])], size, (0, 0, 0))


def volumes(scene: Scene) -> list[float]:
    found = [solid(scene, row) for row in range(len(scene.instances))]
    assert all(map(is_closed, found))
    return [volume(each) * abs(float(scale)) ** 3
            for each, scale in zip(found, scene.instances.scale, strict=True)]  # fmt: skip


def labels(scene: Scene) -> list[str]:
    return [scene.labels[each] for each in scene.instances.label.tolist()]


WINGS = "{ Mass | translate(7, -3, 1) size(2, 12, 6) Wing }"


@pytest.mark.parametrize(
    ("kind", "expected"),
    [("union", 240 + 144 - 36), ("subtract", 240 - 36), ("intersect", 36)],
)
def test_one_closed_solid_with_the_volume_of_the_operation(kind: str, expected: float) -> None:
    scene = drawn(f"Lot --> {kind} {WINGS}")
    assert volumes(scene) == pytest.approx([expected])
    assert labels(scene) == ["Mass"]


def test_the_pen_is_that_of_the_first_terminal_of_the_first_part() -> None:
    rules = 'Lot --> union { Red | color("#0000ff") Wing }\nRed --> color("#ff0000") Mass Roof'
    scene = drawn(rules)
    assert [hex(each) for each in scene.instances.color.tolist()] == ["0xff0000ff"]
    assert labels(scene) == ["Mass"]


def test_each_part_begins_with_the_shape_as_it_is() -> None:
    rules = "Lot --> translate(1, 0, 0) subtract { size(4, 4, 4) Mass | size(1, 1, 1) Hole } After"
    scene = drawn(rules)
    assert volumes(scene) == pytest.approx([63, 240])
    assert labels(scene) == ["Mass", "After"]
    assert scene.instances.position[:, 0] == pytest.approx([1, 1])


def test_nested_operations_work_inside_out() -> None:
    rules = (
        "Lot --> subtract { union { Mass | translate(10, 0, 0) Wing } "
        "| intersect { translate(8, 1, 1) size(4, 1, 1) Bar | translate(9, 0, 0) Rest } } Far"
    )
    scene = drawn(rules)
    assert volumes(scene) == pytest.approx([480 - 3, 240])
    assert labels(scene) == ["Mass", "Far"]


def test_a_boolean_in_a_rule_that_a_part_becomes() -> None:
    rules = (
        "Lot --> subtract { Mass | Passage }\n"
        "Passage --> union { translate(4, -1, -1) size(2, 9, 2) Way | translate(-1, 2, -1) "
        "size(19, 2, 2) Cross }"
    )
    assert volumes(drawn(rules)) == pytest.approx([240 - 12 - 20 + 4])


def test_what_the_parts_of_a_comp_draw_closes_again() -> None:
    rules = "Lot --> subtract { comp { all: Face } | translate(1, 1, 1) size(1, 1, 1) Hole }"
    assert volumes(drawn(rules)) == pytest.approx([239])


def test_several_solids_of_a_part_are_united_first() -> None:
    rules = "Lot --> intersect { split x { 3: A | 3: nil | ~1: B } | size(8, 2, 2) Bar }"
    assert volumes(drawn(rules)) == pytest.approx([(3 + 2) * 4])


def test_frames_that_turn_scale_and_mirror() -> None:
    rules = (
        "Lot --> rotate(10, 20, 30) *(2) mirrorScope(x) translate(1, 2, 3) "
        "subtract { roofGable(30) Mass | translate(4, 2, 0) rotate(5, 0, 40) mirrorScope(y) "
        "size(3, 2, 1) Hole }\n"
        "start Lot on box(10, 6, 0)"
    )
    scene = drawn(rules)
    whole = volumes(drawn(rules.replace("subtract {", "[").replace("|", "] [").replace("}", "]")))
    both = volumes(drawn(rules.replace("subtract", "intersect")))
    assert volumes(scene) == pytest.approx([whole[0] - both[0]])


def test_where_nothing_is_left_nothing_is_drawn() -> None:
    assert len(drawn("Lot --> intersect { Mass | translate(99, 0, 0) Far }").instances) == 0
    assert len(drawn("Lot --> subtract { Mass | size(10, 6, 4) Same }").instances) == 0
    assert len(drawn("Lot --> subtract { nil | Mass }").instances) == 0
    assert labels(drawn("Lot --> union { nil | Mass }")) == ["Mass"]


def test_what_fills_its_scope_again_is_a_box() -> None:
    scene = drawn("Lot --> union { split x { ~1: A | ~1: B } }")
    assert scene.instances.asset.tolist() == [SCOPE]
    assert scene.instances.size[0] == pytest.approx([10, 6, 4])


def test_equal_operations_are_worked_out_once() -> None:
    bays = "Lot --> split x { { ~0.01: Bay }* }\nBay --> subtract { Wall | Hole }\n"
    bays += "Hole --> translate(0.001, -1, 1) size(0.005, 9, 1) Cut"
    scene = drawn(bays)
    assert len(scene.instances) == 1000
    assert len(scene.solids) < 10
    assert sum(volumes(scene)) == pytest.approx(240 - 1000 * 0.005 * 6)


def test_copies_of_a_repeat_have_operations_of_their_own() -> None:
    body = "[translate(20 * i, 0, 0) subtract { Mass | size(i + 1, 6, 4) A }]"
    rules = f"Lot --> repeat(i < 3) {{ {body} }}"
    scene = drawn(rules)
    assert volumes(scene) == pytest.approx([216, 192, 168])
    assert scene.instances.position[:, 0] == pytest.approx([1, 22, 43])


def test_the_order_of_rows_is_that_of_the_derivation() -> None:
    rules = "Lot --> split x { { ~5: [Before] Cut After }* }\nCut --> subtract { Mass | "
    rules += "size(1, 1, 1) Hole }"
    assert labels(drawn(rules)) == ["Before", "Mass", "After"] * 2


def test_a_shape_that_is_no_solid_says_which_part() -> None:
    with pytest.raises(ipmlang.IpmError) as caught:
        drawn("Lot --> subtract { Mass | comp { top: Face } }")
    found = caught.value.diagnostics[0]
    assert "rule Lot" in found.message
    assert (
        "`subtract` needs closed solids, and what its part 2 draws has open edges" in found.message
    )
    assert found.hint is not None and "extrude" in found.hint


def test_a_segment_is_no_solid() -> None:
    with pytest.raises(ipmlang.IpmError, match="a segment of the turtle is no solid"):
        drawn("Lot --> union { Mass | [F(3)] }")


def test_assets_are_solids_too(tmp_path: Path) -> None:
    corners = [(x, y, z) for x in (0, 2) for y in (0, 2) for z in (0, 2)]
    faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    lines += [f"f {' '.join(map(str, face))}" for face in faces]
    (tmp_path / "block.obj").write_text("\n".join(lines))
    text = 'ipm 1\nasset block = "block.obj"\nLot --> subtract {{ Mass | {} }}\n'
    text += "start Lot on box(10, 6, 4)\n"
    for part, left in (("size(1, 1, 1) insert(block) Hole", 239), ("[block]", 232)):
        scene = ipmlang.parse(text.format(part), folder=tmp_path).run()
        assert volumes(scene) == pytest.approx([left])


def test_random_boxes_against_counted_volumes() -> None:
    """Boxes on whole numbers: the volume is the number of unit cubes."""
    rng = np.random.default_rng(3)
    for _ in range(5):
        low = rng.integers(0, 5, (4, 3))
        size = rng.integers(1, 5, (4, 3))
        grid = np.zeros((4, 9, 9, 9), np.bool_)
        for k, (a, b) in enumerate(zip(low, low + size, strict=True)):
            grid[k, a[0] : b[0], a[1] : b[1], a[2] : b[2]] = True
        parts = [f"translate({a[0]}, {a[1]}, {a[2]}) size({b[0]}, {b[1]}, {b[2]}) P"
                 for a, b in zip(low, size, strict=True)]  # fmt: skip
        rules = (
            f"Lot --> subtract {{ union {{ {parts[0]} | {parts[1]} }} | {parts[2]} | {parts[3]} }}"
        )
        wanted = ((grid[0] | grid[1]) & ~grid[2] & ~grid[3]).sum()
        assert sum(volumes(drawn(rules))) == pytest.approx(wanted)
