"""Queries between shapes: two passes, who is tested against whom, and every place to ask from."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import ipmlang
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.verify import verify
from ipmlang.geometry.oriented import Boxes, distances, meetings
from ipmlang.runtime import pending
from ipmlang.runtime.frontier import Frontier
from ipmlang.runtime.scene import Scene


def run(text: str, seed: int = 0, **attrs: int | float | bool | str) -> Scene:
    grammar = ipmlang.parse("ipm 1\n" + text)
    assert verify(grammar.program) == []
    return grammar.run(seed=seed, attrs=attrs)


def drawn(scene: Scene) -> Counter[str]:
    return Counter(scene.labels[number] for number in scene.instances.label.tolist())


def places(scene: Scene, name: str) -> list[tuple[float, ...]]:
    rows = scene.instances.label == scene.labels.index(name) if name in scene.labels else []
    return [tuple(each) for each in scene.instances.position[rows].round(9).tolist()]


TWO_MASSES = """
start Lot on box(10, 4, 6)
Lot --> split x { 5: Mass | 5: Mass }
Mass --> comp { side: Wall }
Wall --> split x { { ~1: Tile }* }
"""


def test_tiles_of_walls_that_abut_are_left_out() -> None:
    """The party wall is in both masses' boundary: 2 x 4 tiles of 36; none is in its own mass."""
    scene = run(TWO_MASSES + 'Tile : inside("Mass") --> nil\nTile : else --> Window')
    assert drawn(scene) == {"Window": 28}
    assert not any(x == 5 and 0 < y < 4 for x, y, _ in places(scene, "Window"))


def test_touching_is_no_overlap() -> None:
    assert drawn(run(TWO_MASSES + 'Tile : overlaps("Mass") --> nil\nTile : else --> W')) == {
        "W": 36
    }
    touching = run(TWO_MASSES + 'Tile : touches("Mass") --> nil\nTile : else --> W')
    assert drawn(touching) == {"W": 36 - 8 - 4}  # the party wall, and the tiles beside its edges


def test_a_label_is_of_the_geometry_where_it_stands() -> None:
    """What stands in other brackets is another shape, though its shape is the same."""
    text = """
start Lot on box(12, 4, 6)
Lot --> [size(2, 4, 6) label("block") Block]
  repeat(i < 12) { [translate(i, 0, 0) size(1, 1, 1) Post(overlaps("block"))] }
Post(o) : o --> nil
Post(o) : else --> Stick
"""
    assert [x for x, _, _ in places(run(text), "Stick")] == list(range(2, 12))


def test_all_of_one_line_of_descent_is_left_out() -> None:
    """It is no use to ask about oneself, one's ancestors, one's parts."""
    text = """
start Lot on box(4, 4, 4)
Lot --> label("whole") split x { 2: Part | 2: nil }
Part : overlaps("whole") or overlaps("Part") or overlaps("Piece") --> Wrong
Part : else --> split y { 1: Piece | ~1: Piece }
Piece : overlaps("Part") or overlaps("whole") or overlaps() --> Wrong
Piece : else --> Right
"""
    assert drawn(run(text)) == {"Right": 2}


def test_the_second_pass_tests_what_the_first_made() -> None:
    """Two that overlap both go: neither is there first."""
    text = """
start Lot on box(4, 1, 1)
Lot --> [size(3, 1, 1) A] [translate(2, 0, 0) size(2, 1, 1) B] [translate(9, 0, 0) A]
A : overlaps("B") --> Gone
A : else --> Here
B : overlaps("A") --> Gone
B : else --> Here
"""
    assert drawn(run(text)) == {"Gone": 2, "Here": 1}


def test_the_order_of_rules_and_of_elements_is_the_same() -> None:
    one = 'Lot --> [Ps("a", 0)] [Ps("b", 1.5)]'
    two = 'Lot --> [Ps("b", 1.5)] [Ps("a", 0)]'
    rest = """
start Lot on box(9, 1, 1)
Ps(l, d) --> repeat(i < 3) { [translate(3 * i + d, 0, 0) size(1 + i * 0.5, 1, 1) label(l) P(l)] }
P(l) : l == "a" and overlaps("b") --> Hit
P(l) : l == "b" and overlaps("a") --> Hit
P(l) : else --> Miss
"""
    scenes = [run(rest + each) for each in (one, two)]
    for name in ("Hit", "Miss"):
        assert sorted(places(scenes[0], name)) == sorted(places(scenes[1], name))
    assert drawn(scenes[0]) == {"Hit": 2, "Miss": 4}


FIELD = """
attr near = 0
start Field on box(100, 100, 0)
Field --> [repeat(i < 9) { repeat(j < 9) { [
    translate(8 * i + rand(0, 5), 8 * j + rand(0, 5), 0) rotate(rand(0, 30), 0, rand(0, 90))
    size(rand(1, 6), rand(1, 6), rand(1, 6)) cube Block] } }]
  [repeat(i < 9) { repeat(j < 9) { [
    translate(8 * i + rand(0, 5), 8 * j + rand(0, 5), 0) rotate(0, 0, rand(0, 90))
    size(rand(1, 6), rand(1, 6), rand(1, 6)) cube Tree] } }]
Tree : near > 0 and distance("Block") < near --> Hit
Tree : near == 0 and overlaps("Block") --> Hit
Tree : else --> Miss
"""


def boxes_of(scene: Scene, *names: str) -> Boxes:
    rows = np.isin(scene.instances.label, [scene.labels.index(each) for each in names])
    q, half = scene.instances.rotation[rows], scene.instances.size[rows] / 2
    w, x, y, z = q.T
    axes = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
        [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
        [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
    ]).transpose(2, 0, 1)  # fmt: skip
    return Boxes(scene.instances.position[rows] + np.einsum("nk,nkc->nc", half, axes), axes, half)


@pytest.mark.parametrize("near", [0.0, 0.2])
def test_many_boxes_against_every_pair(near: float) -> None:
    scene = run(FIELD, seed=5, near=near)
    blocks = boxes_of(scene, "Block")
    for name in ("Hit", "Miss"):
        own = boxes_of(scene, name)
        rows, columns = np.divmod(np.arange(len(own) * len(blocks)), len(blocks))
        if near:
            pairs = distances(own.take(rows), blocks.take(columns)) < near
        else:
            pairs, _ = meetings(own.take(rows), blocks.take(columns))
        hit = pairs.reshape(len(own), len(blocks)).any(axis=1)
        assert len(hit) > 10
        assert hit.all() if name == "Hit" else not hit.any()


def test_the_size_of_batches_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = run(FIELD, seed=2)
    monkeypatch.setattr(pending, "CHUNK", 7)
    parts = run(FIELD, seed=2)
    assert whole.instances.key.tolist() == parts.instances.key.tolist()
    assert whole.instances.label.tolist() == parts.instances.label.tolist()


def test_distances_are_numbers_that_bodies_can_use() -> None:
    text = """
start Lot on box(12, 4, 6)
Lot --> split x { 2: A | { ~1: B(distance("A")) }* | 1: C(distance("nowhere")) }
A --> Wall
B(d) --> size(1, 1, d) Post
C(d) --> report("far", d) Post
"""
    scene = run(text)
    posts = scene.instances.label == scene.labels.index("Post")
    assert scene.instances.size[posts][:9, 2].tolist() == pytest.approx(list(range(9)))
    assert scene.reports["far"] == (1e9, 1)


def test_without_a_label_all_that_is_drawn_counts() -> None:
    text = """
start Lot on box(6, 1, 1)
Lot --> split x { 1: Post | 1: Tile | 2: nil | 2: Tile }
Tile : touches() --> Beside
Tile : else --> Free
"""
    assert drawn(run(text)) == {"Post": 1, "Beside": 1, "Free": 1}


def test_functions_ask_and_labels_may_be_attributes() -> None:
    text = """
attr what = "tower"
fn hit() = overlaps(what)
start Lot on box(6, 1, 1)
Lot --> [size(2, 1, 1) label("tower") T] [translate(1, 0, 0) size(3, 1, 1) label("shed") S] [P]
P : hit() --> Hit
P : else --> Miss
"""
    assert drawn(run(text))["Hit"] == 1
    assert drawn(run(text, what="hut"))["Miss"] == 1


def test_roofs_are_more_exact_than_their_boxes() -> None:
    """A post beside the slope stands in the roof's box, and not in the roof."""
    text = """
start Lot on box(8, 8, 0)
Lot --> [roofHip(45) Roof] [Posts]
Posts --> [translate(0.1, 0.1, 2) size(0.2, 0.2, 3) cube Post]
  [translate(3.9, 3.9, 2) size(0.2, 0.2, 3) cube Post]
  [translate(3.9, 3.9, 1) size(0.2, 0.2, 0.2) cube Post]
Post : inside("Roof") --> Within
Post : overlaps("Roof") --> Through
Post : else --> Beside
"""
    assert drawn(run(text)) == {"Roof": 1, "Within": 1, "Through": 1, "Beside": 1}


def test_points_without_geometry_stand_in_polygons() -> None:
    text = """
start Lot on polygon [(0, 0), (8, 0), (4, 6)]
Lot --> [label("lake") Lake] [Trees]
Trees --> repeat(i < 5) { [translate(2 * i, 4, 0) size(0, 0, 0) Tree] }
Tree : inside("lake") --> report("wet", 1)
Tree : else --> report("dry", 1)
"""
    assert run(text).reports == {"dry": (4.0, 4), "wet": (1.0, 1)}


def test_inserted_assets_and_placed_ones(tmp_path: Path) -> None:
    """An L-shaped asset: what stands in its notch is beside it."""
    base = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
    lines = [f"v {x} {y} {z}" for z in (0, 1) for x, y in base]
    lines += ["f 6 5 4 3 2 1", "f 7 8 9 10 11 12"]
    lines += [f"f {k + 1} {(k + 1) % 6 + 1} {(k + 1) % 6 + 7} {k + 7}" for k in range(6)]
    (tmp_path / "ell.obj").write_text("\n".join(lines) + "\n")
    rules = """
Post : overlaps("ell") --> Hit
Post : else --> Miss
Posts --> [translate(0.4, 2, 0) size(0.2, 0.2, 1) cube Post]
  [translate(2, 2, 0) size(0.2, 0.2, 1) cube Post]
"""
    for hit, start in (
        (0.4, '[size(3, 3, 1) insert(ell) label("ell") Shown] [Posts]'),
        (0.4, "[ell] [Posts]"),
        (2.0, '[size(3, 3, 1) insert(ell) mirrorScope(x) label("ell") Shown] [Posts]'),
    ):
        text = f'ipm 1\nasset ell = "ell.obj"\nstart Lot on box(3, 3, 0)\nLot --> {start}\n{rules}'
        scene = ipmlang.parse(text, folder=tmp_path).run()
        assert [x for x, _, _ in places(scene, "Hit")] == [hit]
        assert [x for x, _, _ in places(scene, "Miss")] == pytest.approx([2.4 - hit])


def test_only_programs_that_ask_are_derived_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    runs: list[int] = []
    before = Frontier.run

    def counted(self: Frontier, seed: int) -> None:
        runs.append(seed)
        before(self, seed)

    monkeypatch.setattr(Frontier, "run", counted)
    run("start Lot on box(1, 1, 1)\nLot --> Wall")
    assert len(runs) == 1
    run('start Lot on box(1, 1, 1)\nLot --> label("a") phase(2) A\nA : count("a") > 0 --> Wall')
    assert len(runs) == 2
    run("start Lot on box(1, 1, 1)\nLot : overlaps() --> nil\nLot : else --> Wall")
    assert len(runs) == 4


@pytest.mark.parametrize(
    "item",
    ['attr a = count("x")', 'limit shapes count("x")', 'fn f() = distance("x")\nattr a = f()'],
)
def test_where_there_is_no_shape_nothing_can_be_asked(item: str) -> None:
    with pytest.raises(IpmError) as caught:
        ipmlang.parse(f"ipm 1\n{item}\nstart Lot on box(1, 1, 1)\nLot --> Wall")
    assert caught.value.diagnostics[0].code == "no-shape"
    assert caught.value.diagnostics[0].source is not None


def test_a_repeat_that_moves_on_by_an_answer_is_refused_with_a_hint() -> None:
    text = 'start Lot on box(9, 1, 1)\nLot --> repeat(i < 3) { f(distance("x")) F(1) }'
    with pytest.raises(IpmError, match="moves on"):
        run(text)


def test_a_rule_without_else_may_wait_for_the_answer() -> None:
    text = """
start Lot on box(4, 1, 1)
Lot --> split x { 2: Wall | 2: Tile }
Wall --> Stone
Tile : touches("Wall") --> Beside
"""
    assert drawn(run(text)) == {"Stone": 1, "Beside": 1}
    with pytest.raises(IpmError, match="no production of Tile"):
        run(text.replace('touches("Wall")', 'overlaps("Wall")'))
