"""What a derivation starts on: closed paths of drawings, faces of models, and random defaults."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import ipmlang
from ipmlang.geometry.solid import area, is_closed, placed, volume
from ipmlang.runtime.scene import Scene
from ipmlang.runtime.scopes.lots import closed_paths

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 60">'
COURT = '<path d="M 30 5 h 20 v 20 h -20 z M 35 10 h 8 v 8 h -8 z"/>'
DATA = Path(__file__).parents[3] / "shared" / "data" / "svg"


def drawing(folder: Path, *elements: str) -> Path:
    path = folder / "lots.svg"
    path.write_text(HEAD + "".join(elements) + "</svg>")
    return path


def grown(path: Path, rules: str = "Lot --> Plate", **more: object) -> Scene:
    attrs = "attr n = irand(0, 1000000)\nattr twice = 2 * n\n"
    text = f'ipm 1\n{attrs}{rules}\nstart Lot on "{path.name}"\n'
    return ipmlang.parse(text, folder=path.parent).run(**more)  # type: ignore[arg-type]


def areas(scene: Scene) -> list[float]:
    found = []
    for row, size in enumerate(scene.instances.size):
        shape = int(scene.instances.shape[row])
        if shape < 0:
            found.append(float(size[0] * size[1]))
        else:
            found.append(area(placed(scene.solids[shape], np.where(size > 0, size, 1), (0, 0, 0))))
    return found


def corners(scene: Scene) -> Sequence[tuple[float, float]]:
    return [tuple(each) for each in np.round(scene.instances.position[:, :2], 9).tolist()]


# ------------------------------------------------------------------------------ drawings


def test_closed_paths_in_their_order_with_y_up(tmp_path: Path) -> None:
    path = drawing(tmp_path, '<rect x="5" y="5" width="12" height="9"/>', COURT)
    scene = grown(path)
    assert areas(scene) == pytest.approx([108, 336])
    assert corners(scene) == [(5, 46), (30, 35)]
    assert (scene.instances.rotation[:, 0] == 1).all()


def test_curves_are_chords_within_a_thousandth_of_the_path(tmp_path: Path) -> None:
    curve = "M 0 0 C 40 0 40 40 0 40 z"
    path = drawing(tmp_path, '<circle cx="50" cy="30" r="20"/>', f'<path d="{curve}"/>')
    (circle, blob), _ = closed_paths(path)
    radius = np.hypot(*(circle.rings[0] - (50, 30)).T)
    assert np.allclose(radius, 20)
    middle = (circle.rings[0] + np.roll(circle.rings[0], -1, axis=0)) / 2
    assert np.hypot(*(middle - (50, 30)).T).min() >= 20 - 40e-3
    assert len(circle.rings[0]) < 100
    t = np.linspace(0, 1, 2000)
    exact = np.stack([3 * t * (1 - t) * 40, 60 - (3 * t * t * (1 - t) * 40 + t**3 * 40)], axis=1)
    start, end = blob.rings[0], np.roll(blob.rings[0], -1, axis=0)
    along = np.clip(((exact[:, None] - start) * (end - start)).sum(2)
                    / ((end - start) ** 2).sum(1), 0, 1)  # fmt: skip
    near = start + along[..., None] * (end - start)
    assert np.hypot(*(exact[:, None] - near).transpose(2, 0, 1)).min(axis=1).max() <= 40e-3


@pytest.mark.parametrize("sense", [1, -1])
def test_holes_and_islands_by_even_odd_however_they_run(tmp_path: Path, sense: int) -> None:
    def square(at: float, side: float, turn: int) -> str:
        return f"M {at} {at} h {side} v {side} h {-side} z" if turn > 0 else (
            f"M {at} {at} v {side} h {side} v {-side} z")  # fmt: skip

    inner = square(10, 10, -sense) + square(12, 4, sense)
    path = drawing(tmp_path, f'<path d="{inner}{square(5, 40, sense)}"/>')
    scene = grown(path, 'Lot --> report("hole", geometry.sides) Plate')
    assert sorted(areas(scene)) == pytest.approx([16, 1500])
    assert scene.reports == {"hole": (12, 2)}
    assert scene.notes == ()


def test_what_runs_clockwise_is_read_from_its_end(tmp_path: Path) -> None:
    path = drawing(tmp_path, '<path d="M 10 50 L 40 50 L 40 30 L 10 30 z"/>',
                   '<path d="M 40 50 L 10 50 L 10 30 L 40 30 z"/>')  # fmt: skip
    scene = grown(path)
    assert corners(scene) == [(10, 10), (40, 30)]
    assert np.allclose(scene.instances.rotation[:, 0], [1, 0])


def test_open_paths_are_left_out_and_told(tmp_path: Path) -> None:
    line = '<path d="M 0 0 L 9 0 L 9 9"/>'
    back = '<path d="M 20 0 L 29 0 L 29 9 L 20 0"/>'
    scene = grown(drawing(tmp_path, line, back, line))
    assert areas(scene) == pytest.approx([40.5])
    assert scene.notes == ("lots.svg: 2 open paths left out",)


def test_near_rectangular_tiny_edges_and_repeated_points(tmp_path: Path) -> None:
    outlines = (
        "M 0 0 L 30 0.2 L 29.9 20 L 0.1 19.9 z",
        "M 0 0 L 10 0 L 10.000001 0.000001 L 10 10 L 0 10 z",
        "M 0 0 L 0 0 L 10 0 L 10 0 L 10 10 L 5 10 L 0 10 L 0 0 z",
        "M 0 0 H 30 V 10 H 20 V 5 H 10 V 10 H 0 z",
    )
    path = drawing(tmp_path, *(f'<path d="{each}"/>' for each in outlines))
    scene = grown(path, "Lot --> extrude(3) comp { all: Wall }")
    assert [scene.labels[each] for each in set(scene.instances.label.tolist())] == ["Wall"]
    scene = grown(path, "Lot --> roofHip(30) Roof")
    assert len(scene.instances) == 4
    for row in range(4):
        size = scene.instances.size[row]
        roof = placed(scene.solids[int(scene.instances.shape[row])], size, (0, 0, 0))
        assert is_closed(roof) and volume(roof) > 0
    assert any("repeated point" in note and "shape" in note for note in scene.notes)


def test_bad_outlines_are_told_with_number_name_and_place(tmp_path: Path) -> None:
    bow = '<path id="bow" d="M 0 0 L 10 10 L 10 0 L 0 10 z"/>'
    crossing = '<path d="M 0 0 h 10 v 10 h -10 z M 5 5 h 10 v 10 h -10 z"/>'
    good = '<rect width="5" height="5"/>'
    with pytest.raises(ipmlang.IpmError) as caught:
        grown(drawing(tmp_path, good, bow, crossing))
    first, second = (each.message for each in caught.value.diagnostics)
    assert first == "lots.svg, shape 2 (bow): the polygon crosses itself at (5, 55)"
    assert "shape 3: its rings cross each other near (" in second


def test_many_bad_outlines_are_counted(tmp_path: Path) -> None:
    bow = '<path d="M 0 0 L 10 10 L 10 0 L 0 10 z"/>'
    with pytest.raises(ipmlang.IpmError) as caught:
        grown(drawing(tmp_path, *[bow] * 500))
    assert len(caught.value.diagnostics) == 21
    assert "480 more" in caught.value.diagnostics[-1].message


def test_a_drawing_without_closed_paths(tmp_path: Path) -> None:
    with pytest.raises(ipmlang.IpmError, match=r"no closed path in lots.svg"):
        grown(drawing(tmp_path, '<path d="M 0 0 L 9 0"/>'))
    with pytest.raises(ipmlang.IpmError, match=r"no shape in lots.svg has any area"):
        grown(drawing(tmp_path, '<path d="M 0 0 L 9 0 z"/>'))


@pytest.mark.parametrize("name", ["map_usa_counties", "flag_us", "cad_lego", "batik_mapSpain"])
def test_drawings_of_all_kinds_give_shapes_or_say_why(name: str) -> None:
    path = DATA / f"{name}.svg"
    if not path.exists():
        pytest.skip("the shared drawings are not here")
    try:
        assert len(grown(path).instances)
    except ipmlang.IpmError as error:
        assert all("shape" in each.message or "path" in each.message for each in error.diagnostics)


# -------------------------------------------------------------------------------- models


OBJ = """v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 2\nv 4 0 2\n
o floor\nf 1 2 3 4\no wall\nf 1 2 6 5\nf 1 2 2\n"""


def test_each_face_of_a_model_is_a_shape(tmp_path: Path) -> None:
    path = tmp_path / "lots.obj"
    path.write_text(OBJ)
    scene = grown(path)
    assert areas(scene) == pytest.approx([12, 8])
    front = scene.instances.rotation[1]
    assert np.allclose(np.abs(front), np.sqrt([0.5, 0.5, 0, 0]))


def test_one_node_of_a_model(tmp_path: Path) -> None:
    (tmp_path / "lots.obj").write_text(OBJ)
    text = 'ipm 1\nLot --> extrude(1) Mass\nstart Lot on "lots.obj#wall"\n'
    scene = ipmlang.parse(text, folder=tmp_path).run()
    assert len(scene.instances) == 1
    assert scene.instances.size[0] == pytest.approx([4, 2, 1])


def test_a_face_that_is_not_flat(tmp_path: Path) -> None:
    path = tmp_path / "lots.obj"
    path.write_text("v 0 0 0\nv 4 0 0\nv 4 3 1\nv 0 3 0\nf 1 2 3 4\n")
    with pytest.raises(ipmlang.IpmError, match=r"lots.obj, shape 1: the face is not flat: point"):
        grown(path)


def test_a_model_without_faces(tmp_path: Path) -> None:
    path = tmp_path / "lots.obj"
    path.write_text("v 0 0 0\nv 4 0 0\n")
    with pytest.raises(ipmlang.IpmError, match=r"no faces in lots.obj"):
        grown(path)


# ---------------------------------------------------------------------------------- `on`


def test_on_takes_the_place_of_the_start(tmp_path: Path) -> None:
    path = drawing(tmp_path, COURT, '<rect id="b" width="5" height="4"/>')
    grammar = ipmlang.parse("ipm 1\nLot --> extrude(2) Mass\nstart Lot on box(3, 3, 0)\n")
    assert len(grammar.run().instances) == 1
    assert len(grammar.run(on=path).instances) == 2
    assert grammar.run(on=f"{path}#b").instances.size[0] == pytest.approx([5, 4, 2])


def test_on_a_file_that_is_not_there(tmp_path: Path) -> None:
    path = drawing(tmp_path, COURT)
    grammar = ipmlang.parse("ipm 1\nLot --> extrude(2) Mass\nstart Lot\n")
    with pytest.raises(ipmlang.IpmError) as caught:
        grammar.run(on=path.with_name("lotz.svg"))
    assert caught.value.diagnostics[0].suggestions == ("lots.svg",)


def test_on_a_program_of_the_turtle(tmp_path: Path) -> None:
    grammar = ipmlang.parse("ipm 1\nstart F(1) +(90) F(1)\n")
    with pytest.raises(ipmlang.IpmError, match=r"has a scope"):
        grammar.run(on=drawing(tmp_path, COURT))


# ---------------------------------------------------------------------- random attributes

REPORT = 'Lot --> [report("n", n) report("twice", twice)] Child\nChild --> report("below", n) P'


def many(folder: Path, count: int = 8) -> Path:
    squares = [f'<rect x="{k}" width="1" height="1"/>' for k in range(count)]
    return drawing(folder, *squares)


def test_random_defaults_differ_from_shape_to_shape(tmp_path: Path) -> None:
    rules = "Lot --> size(n, twice, 1) Child\nChild --> size(n, scope.sy, n) P"
    scene = grown(many(tmp_path), rules)
    x, y, z = scene.instances.size.T
    assert len(set(x.tolist())) == 8
    assert (y == 2 * x).all() and (z == x).all()
    other = grown(many(tmp_path), rules, seed=1).instances.size[:, 0]
    assert not set(x.tolist()) & set(other.tolist())


def test_a_shape_keeps_its_draws_when_others_follow(tmp_path: Path) -> None:
    rules = "Lot --> size(n, twice, rand()) Child\nChild --> size(scope.sx, rand(), scope.sz) P"
    few = grown(many(tmp_path, 3), rules).instances.size
    more = grown(many(tmp_path, 9), rules).instances.size
    assert (few == more[:3]).all()


def test_an_attribute_from_outside_is_the_same_for_all(tmp_path: Path) -> None:
    scene = grown(many(tmp_path), REPORT, attrs={"n": 5})
    assert scene.reports == {"n": (40, 8), "twice": (80, 8), "below": (40, 8)}


def test_a_dependent_default_alone_is_given(tmp_path: Path) -> None:
    rules = "Lot --> size(n, twice, 1) P"
    scene = grown(many(tmp_path), rules, attrs={"twice": 3})
    assert (scene.instances.size[:, 1] == 3).all()
    assert len(set(scene.instances.size[:, 0].tolist())) == 8


def test_set_goes_before_what_was_drawn(tmp_path: Path) -> None:
    rules = "Lot --> [set n = 7 Child] Child\nChild --> size(n, 1, 1) P"
    x = grown(many(tmp_path), rules).instances.size[:, 0]
    assert (x[::2] == 7).all() and len(set(x[1::2].tolist())) == 8


def test_a_single_start_keeps_the_draw_of_the_seed() -> None:
    text = "ipm 1\nattr n = irand(0, 1000000)\nLot --> size(n, 1, 1) P\nstart Lot{}\n"
    turtle = ipmlang.parse("ipm 1\nattr n = irand(0, 1000000)\nstart F(n)\n")
    for seed in range(3):
        wanted = turtle.run(seed=seed).instances.size[0, 0]
        for place in ("", " on box(1, 1, 0)"):
            scene = ipmlang.parse(text.format(place)).run(seed=seed)
            assert scene.instances.size[0, 0] == wanted


def test_a_drawn_default_out_of_range_names_the_shape(tmp_path: Path) -> None:
    text = 'ipm 1\nattr n = irand(0, 9) in 0..4\nLot --> size(n, 1, 1) P\nstart Lot on "lots.svg"\n'
    many(tmp_path, 30)
    for seed in range(20):
        grammar = ipmlang.parse(text, folder=tmp_path)
        with pytest.raises(ipmlang.IpmError) as caught:
            grammar.run(seed=seed)
        message = caught.value.diagnostics[0].message
        if "first shape" in message:
            return
    raise AssertionError("no seed draws a number in range for the run itself")


def test_rows_follow_the_order_of_the_file(tmp_path: Path) -> None:
    rules = "Lot --> split x { ~1: A | ~1: B }\nA --> [Left] Right"
    scene = grown(many(tmp_path, 5), rules)
    names = [scene.labels[each] for each in scene.instances.label.tolist()]
    assert names == ["Left", "Right", "B"] * 5
    assert (np.diff(scene.instances.position[:, 0]) >= 0).all()


def test_a_trail_names_the_first_shape(tmp_path: Path) -> None:
    rules = "Lot --> size(1, 1, 1) Part(scope.x)\nPart(x) : x < 2.5 --> P"
    with pytest.raises(ipmlang.IpmError) as caught:
        grown(many(tmp_path, 5), rules)
    assert caught.value.diagnostics[0].trail == "start[3] > Lot > Part"
