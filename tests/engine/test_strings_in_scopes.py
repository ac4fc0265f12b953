"""L-systems that a program with scopes reaches: strings of their own, as they are alone."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import numpy as np
import pytest

import ipmlang
from ipmlang.compiler.verify import verify
from ipmlang.runtime.scene import OUTLINE, OUTLINES, SEGMENT, Scene

LEAF = "L --> polygon { F(0.2) +(120) F(0.2) }\n"
SYSTEMS = {
    "threads": "P --> A(3) F(1)\nA(n) : n > 0 --> F(n) +(20) A(n - 1) -(5) F(0.5)\n"
    "A(n) : else --> F(0.1)\n",
    "draws": "P --> A(4)\nA(n) : n > 0 : 60% --> F(rand(1, 2)) A(n - 1) [+(rand(40)) A(n - 1)] F\n"
    "A(n) : n > 0 --> +(rand(9)) F A(n - 1) F\nA(n) : else --> nil\n",
    "paths": "P --> [+(30) path { B f F(2) }] F A\nA --> f(1) [path { F [+(40) F] B }] F\n"
    "B --> F(0.2) +(120) F(0.2)\n",
    "polygons": "P --> [+(30) L] F A\nA --> f(1) [L] F\n" + LEAF,
    "contexts": "P --> B C C C\nB < C --> B F(2)\nB --> [+(45) F(0.3)] C\nC --> C\n",
    "cuts": "P --> A(4)\nA(n) : n > 1 --> F A(n - 1) [+(40) F cut F A(1)] F(0.2)\n"
    "A(n) : else --> F\n",
    "pens": 'P --> color("red") A F A\nA --> F(2) color("blue") !(0.3) F layer(1)\n',
    "sizes": "P --> A(5) F\nA(n) : n > 0 --> F *(0.8) mirror A(n - 1) +(30) F\nA(n) : else --> F\n",
    "repeats": "P --> repeat(i < 3) { A(i) } F\nA(n) --> repeat(i < n + 1) { F(i + 1) +(10) }\n",
    "interprets": "P --> B B F\nB --> [C] C\ninterpret C --> F(0.4) +(15)\n",
}
SPACE = {
    "levels": "P --> A(4)\nA(n) : n > 0 --> F &(20) /(50) $ [^(30) A(n - 1)] A(n - 1) F(0.3)\n"
    "A(n) : else --> F\n",
    "bends": "tropism (0.3, 0, -1) 0.4\nP --> A(4)\n"
    "A(n) : n > 0 --> F(1) [&(40) A(n - 1)] /(137) A(n - 1)\nA(n) : else --> F(0.5)\n",
    "copies": "P --> repeat(i < 5) { F(1) &(20) /(40) $ [^(30) F(0.3)] }\n",
    "fills": "P --> F A &(40) F\nA --> [&(70) L] /(50) F\n" + LEAF,
}


def run(text: str, seed: int = 3) -> Scene:
    grammar = ipmlang.parse("ipm 1\n" + text)
    assert verify(grammar.program) == []
    return grammar.run(seed=seed)


def assert_alike(found: Scene, alone: Scene, turn: np.ndarray, step: tuple[float, ...]) -> None:
    """The same rows, in a frame that is turned by a matrix and moved."""
    one, other = found.instances, alone.instances
    assert one.key.tolist() == other.key.tolist()
    assert one.asset.tolist() == other.asset.tolist()
    names = [[scene.labels[each] for each in scene.instances.label] for scene in (found, alone)]
    assert names[0] == names[1]
    free = ~np.isin(one.asset, OUTLINES)  # whose corners are in the world
    places = other.position @ turn.T + np.array(step)
    np.testing.assert_allclose(one.position[free], places[free], atol=1e-9)
    np.testing.assert_allclose(one.size, other.size, rtol=1e-12)
    np.testing.assert_allclose(np.abs(one.scale), np.abs(other.scale), rtol=1e-12)
    np.testing.assert_array_equal(one.color, other.color)
    np.testing.assert_array_equal(one.width, other.width)
    np.testing.assert_array_equal(one.layer, other.layer)
    heading = matrices(one.rotation, one.scale)[free, :, 0]
    wanted = matrices(other.rotation, other.scale)[free, :, 0] @ turn.T
    np.testing.assert_allclose(heading, wanted, atol=1e-9)
    for corners, before in zip(found.polygons, alone.polygons, strict=True):
        np.testing.assert_allclose(corners, before @ turn.T + np.array(step), atol=1e-9)


def matrices(rotation: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Rotations as matrices whose first column is the heading, mirrored where the scale says."""
    w, x, y, z = rotation.T
    found = np.stack(
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
         2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
         2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], 1
    ).reshape(-1, 3, 3)  # fmt: skip
    found[:, :, 0] *= np.sign(scale)[:, None]
    return found


def about_z(degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("steps", ["", " steps 3"])
def test_a_string_among_scopes_is_what_it_is_alone(name: str, steps: str) -> None:
    if name == "contexts" and not steps:
        return  # it never ends
    alone = run(SYSTEMS[name] + f"start P{steps}\n")
    found = run(SYSTEMS[name] + f"start P on box(1, 1, 0){steps}\n")
    assert len(found.instances) > 2
    assert_alike(found, alone, np.eye(3), (0, 0, 0))
    assert (found.generations, found.shapes) == (alone.generations, alone.shapes)


@pytest.mark.parametrize("name", SYSTEMS)
def test_it_starts_where_its_scope_stands(name: str) -> None:
    alone = run(SYSTEMS[name] + "start f(0) +(0) P steps 4\n")
    text = "start translate(1, 2, 3) rotate(0, 0, 40) P on box(1, 1, 0) steps 4\n"
    assert_alike(run(SYSTEMS[name] + text), alone, about_z(40), (1, 2, 3))
    flip = np.diag((-1.0, 1.0, 1.0))
    text = "start f(0) mirrorScope(x) P on box(5, 1, 0) steps 4\n"
    assert_alike(run(SYSTEMS[name] + text), alone, flip, (5, 0, 0))


@pytest.mark.parametrize("name", SPACE)
def test_in_space_too(name: str) -> None:
    alone = run(SPACE[name] + "start at(0, 0, 0, 1, 0, 0, 0) P\n")
    text = "start at(0, 0, 0, 0.5, 0.5, -0.5, 0.5) P on box(1, 1, 0)\n"
    assert_alike(run(SPACE[name] + text), alone, np.eye(3), (0, 0, 0))


def test_many_shapes_grow_at_once_each_in_its_place() -> None:
    text = SYSTEMS["draws"] + "Lot --> split x { { 1: Box | 1: [P] Post }* }\n"
    scene = run(text + 'P2 --> P\nstart color("green") Lot on box(8, 1, 0)\n')
    labels = [scene.labels[each] for each in scene.instances.label]
    counts = Counter(labels)
    assert (counts["Box"], counts["Post"]) == (4, 4)
    bounds = [place for place, label in enumerate(labels) if label in ("Box", "Post")]
    assert labels[0] == "Box" and labels[-1] == "Post"
    grown = [set(labels[a + 1 : b]) for a, b in pairwise(bounds)]
    assert grown == [{"F"}, set(), {"F"}, set(), {"F"}, set(), {"F"}]
    first = [scene.instances.position[place + 1] for place in bounds[::2]]
    np.testing.assert_allclose(first, [(1, 0, 0), (3, 0, 0), (5, 0, 0), (7, 0, 0)], atol=1e-9)
    assert set(scene.instances.color.tolist()) == {0x008000FF}


def test_a_terminal_of_a_string_draws_the_scope_of_its_shape() -> None:
    scene = run("Lot --> split x { 2: P | ~1: nil }\nP --> A Mark\nA --> F(1) +(90)\n"
                "start Lot on box(5, 3, 0)\n")  # fmt: skip
    (mark,) = np.flatnonzero(scene.instances.asset < SEGMENT)
    assert scene.instances.size[mark].tolist() == [2, 3, 0]
    np.testing.assert_allclose(scene.instances.position[mark], (1, 0, 0), atol=1e-12)


def test_ivy_on_a_house_is_written() -> None:
    scene = run(
        "House --> extrude(3) comp { front: Wall | top: Roof }\nWall --> [Brick] Ivy(3)\n"
        "Ivy(n) : n > 0 --> F(0.5) [+(40) Ivy(n - 1)] Stem F [L] Ivy(n - 1)\n"
        "Ivy(n) : else --> L\nStem --> F(0.2) -(10)\n" + LEAF + "start House on box(4, 5, 0)\n"
    )
    kinds = Counter(scene.instances.asset.tolist())
    assert kinds[OUTLINE] == len(scene.polygons) == 15
    assert all(abs(corners[:, 1]).max() < 1e-9 for corners in scene.polygons)  # on the wall


@pytest.mark.parametrize(
    ("text", "place", "what"),
    [
        ("Lot --> size(1, 1, 1) A B\nA --> F\nB --> F\n", "A", "moves the turtle"),
        ("Lot --> size(1, 1, 1) [polygon { F +(90) F }]\n", "polygon", "a polygon of the turtle"),
        ("Lot --> size(1, 1, 1) [path { F }]\n", "path", "a path of the turtle"),
        ("Lot --> size(1, 1, 1) [F cut F]\n", "cut", "`cut`"),
        ("tropism (0, 0, -1) 0.2\nLot --> size(1, 1, 1) [F]\n", "F]", "that a tropism bends"),
        ("Lot --> size(1, 1, 1) [B] [C]\nB < C --> F\n", "C]", "what stands beside it"),
        ("Lot --> size(1, 1, 1) repeat(i < 3) { F &(9) $ }\n", "repeat", "levels the turtle"),
        ("Lot --> [B] C\nB < C --> size(1, 1, 1) F\n", "C", "what stands beside it"),
    ],
)
def test_what_needs_a_string_is_told_where_there_is_none(text: str, place: str, what: str) -> None:
    with pytest.raises(ipmlang.IpmError, match=what) as caught:
        run(text + "start Lot on box(1, 1, 0)\n")
    (found,) = caught.value.diagnostics
    assert found.source is not None and found.hint is not None
    assert found.source.text[found.start :].startswith(place)


def test_limits_hold_in_strings() -> None:
    text = "P --> A F\nA --> F A A F\nLot --> [P] size(1, 1, 1) Box\nstart Lot on box(1, 1, 0)\n"
    for limit, what in (
        ("shapes 5000", "shapes"),
        ("steps 12", "steps"),
        ("memory 90000", "bytes"),
    ):
        with pytest.raises(ipmlang.IpmError, match=f"limit.*{what}"):
            run(f"limit {limit}\n{text}")


@pytest.mark.parametrize("rule", ["A(n) --> F(1 / (n - 1))", "A(n) : n < 1 --> F"])
def test_an_error_in_a_string_tells_the_way_to_it(rule: str) -> None:
    text = f"Lot --> split x {{ {{ 1: House }}* }}\nHouse --> [P]\nP --> A(1) F\n{rule}\n"
    with pytest.raises(ipmlang.IpmError) as caught:
        run(text + "start Lot on box(3, 1, 0)\n")
    assert caught.value.diagnostics[0].trail == "start > Lot > House[0] > P > A"


@pytest.mark.parametrize("last", ["polygon { }", "nil", "polygon { F(1) }", "f(2)"])
def test_strings_that_draw_nothing_stand_among_others(last: str) -> None:
    scene = run(
        "Lot --> split x { 1: [Q(split.index)] | 2: [Q(split.index)] | ~1: [Q(split.index)] }\n"
        f"Q(n) : n < 1 --> F(1) [P]\nQ(n) : else --> P\nP --> {last}\nstart Lot on box(8, 1, 0)\n"
    )
    assert scene.instances.position.tolist() == [[0, 0, 0]]
