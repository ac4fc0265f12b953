"""Contexts: `fetch` against scipy's interpolation, and the same numbers whatever way runs them."""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from scipy.ndimage import map_coordinates

import ipmlang
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.verify import verify
from ipmlang.runtime.numpy_backend import derive_frontier
from ipmlang.runtime.sampling import Context, fetch, fetch_single
from ipmlang.runtime.scene import SEGMENT, Scene
from ipmlang.runtime.strings import derive_string

GREY = np.random.default_rng(5).integers(0, 256, (7, 11), dtype=np.uint8)
PLACE = (-3.0, 2.0, 20.0, 10.0)
EXTREME = (0.0, -3.0, 17.0, 12.0, 1e-300, 1e308, -1e308, math.inf, -math.inf, math.nan)


def context(nearest: bool = False, numbers: np.ndarray = GREY) -> Context:
    return Context(numbers[::-1, :, None], PLACE, nearest, 255.0, 1.0, 0.0)


def oracle(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """What scipy makes of the picture: rows are counted from its top."""
    left, bottom, width, height = PLACE
    down = (bottom + height - y) / height * GREY.shape[0] - 0.5
    along = (x - left) / width * GREY.shape[1] - 0.5
    return map_coordinates(GREY / 255, [down, along], order=1, mode="nearest")


def test_between_texels_it_is_what_scipy_says() -> None:
    random = np.random.default_rng(1)
    x, y = random.uniform(-6, 20, 2000), random.uniform(0, 15, 2000)
    np.testing.assert_allclose(fetch(context(), 0, x, y), oracle(x, y), atol=1e-12)


def test_at_the_middle_of_a_texel_it_is_the_texel() -> None:
    rows, columns = np.mgrid[:7, :11]
    x = -3 + (columns + 0.5) * 20 / 11
    y = 12 - (rows + 0.5) * 10 / 7
    found = fetch(context(), 0, x.ravel(), y.ravel())
    np.testing.assert_allclose(found, GREY.ravel() / 255, atol=1e-13)


@pytest.mark.parametrize("nearest", [False, True])
@given(st.floats(width=64), st.floats(width=64))
def test_one_place_has_the_bits_of_many(nearest: bool, x: float, y: float) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        many = fetch(context(nearest), 0, np.array([x, 0.5]), np.array([y, 4.5]))
    assert isinstance(many, np.ndarray)
    one = fetch_single(context(nearest), 0, x, y)
    assert np.array_equal(many[:1], [one], equal_nan=True)
    same = fetch(context(nearest), 0, x, y)
    assert isinstance(same, float) and np.array_equal([same], [one], equal_nan=True)


@pytest.mark.parametrize("nearest", [False, True])
def test_it_is_a_number_wherever_its_place_is_one(nearest: bool) -> None:
    for x in EXTREME:
        for y in EXTREME:
            found = fetch_single(context(nearest), 0, x, y)
            assert math.isnan(found) == (math.isnan(x) or math.isnan(y))
            assert math.isnan(found) or 0 <= found <= 1


@given(st.integers(1, 60), st.integers(1, 60), st.integers(-50, 50))
@settings(max_examples=50)
def test_single_texels_begin_at_their_lower_left_corner(count: int, size: int, begin: int) -> None:
    """Where texels are as long as the steps of a grid, the grid's corners lie in them exactly."""
    row = np.arange(count, dtype=np.uint8)[None, :, None]
    across = Context(row, (begin, 0, count * size, 1), True, 1.0, 1.0, 0.0)
    upward = Context(row.transpose(1, 0, 2), (0, begin, 1, count * size), True, 1.0, 1.0, 0.0)
    corners = begin + np.arange(count) * float(size)
    expected = np.arange(count).tolist()
    assert np.asarray(fetch(across, 0, corners, 0.5)).tolist() == expected
    assert np.asarray(fetch(upward, 0, 0.5, corners)).tolist() == expected


# ------------------------------------------------------------------------------ programs

HEAD = """ipm 1
context mask = "grey.png" over (-3, 2, 20, 10)
context zones = "grey.png" over (-3, 2, 20, 10) nearest
context wind : vector = "wind.npy" over (0, 0, 1, 1)
context color = "color.png"
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    Image.fromarray(GREY).save(tmp_path / "grey.png")
    color = np.array([[[255, 0, 51], [0, 255, 102]]], np.uint8)
    Image.fromarray(color).save(tmp_path / "color.png")
    np.save(tmp_path / "wind.npy", np.array([[[1.5, -2], [3, 4]]], np.float32))
    return tmp_path


def grammar(folder: Path, text: str) -> ipmlang.Grammar:
    made = ipmlang.parse(HEAD + text, folder=folder)
    assert verify(made.program) == []
    return made


def lengths(scene: Scene) -> list[float]:
    return scene.instances.size[:, 0].tolist()


WAYS = {
    "batch": "P --> repeat(i < 500) { [A(mod(i, 25) - 5, i / 20 - 4)] }\n"
    "A(x, y) : fetch(zones, x, y) > 0.3 --> F(1 + fetch(mask, x, y)) B(x, y)\n"
    "A(x, y) : else --> nil\n"
    "B(x, y) : 100 * fetch(mask, x, y)% --> F(2 + fetch(mask, y, x))\nB(x, y) : else --> nil\n",
    "single": "P --> [A(1.5, 3)] [A(12, 7)] [A(15, 4)]\nA(x, y) : fetch(zones, x, y) > 0.1 --> "
    "F(1 + fetch(mask, x, y)) [B(x + 1, y)]\nA(x, y) : else --> F(9)\n"
    "B(x, y) : 100 * fetch(mask, x, y)% --> F(2 + fetch(mask, y, x))\nB(x, y) : else --> nil\n",
    "chain": "P --> A(-4)\nA(x) : fetch(mask, x, 6) > 0.02 and x < 20 --> "
    "F(1 + fetch(mask, x, 6)) A(x + 0.05)\nA(x) : else --> F(7)\n",
    "looped": "P --> A(-4, 1)\nA(x, y) : fetch(mask, x, y) > 0.001 and x < 20 --> "
    "F(1 + fetch(mask, x, y)) A(x + 0.05 + 0.1 * fetch(mask, x, y), y * 1.01)\n"
    "A(x, y) : else --> F(7)\n",
    "copies": "P --> repeat(i < 40) { F(1 + fetch(mask, i - 10, 0.3 * i)) +(10) }\n",
}


@pytest.mark.parametrize("name", WAYS)
@pytest.mark.parametrize("seed", [0, 7])
def test_the_frontier_and_the_string_give_the_same_bits(name: str, seed: int, folder: Path) -> None:
    program = grammar(folder, WAYS[name] + "start P\n").program
    batched = derive_frontier(program, (), seed, program.limits)
    string = derive_string(program, (), seed, program.limits)
    assert batched is not None
    assert len(string.instances) >= 3
    assert lengths(batched) == lengths(string)
    assert batched.instances.key.tolist() == string.instances.key.tolist()


def test_a_string_has_the_numbers_of_its_parameters(folder: Path) -> None:
    text = "P --> A(1, 3) F\nA(x, y) --> F(fetch(mask, x, y)) +(10) B(x, y)\n"
    scene = grammar(folder, text + "B(x, y) --> F(fetch(mask, y, x))\nstart P\n").run()
    expected = oracle(np.array([1.0, 3]), np.array([3.0, 1]))
    assert lengths(scene)[:2] == pytest.approx(expected.tolist())


TOWN = """Town --> split y { { ~1: split x { { ~1: Lot }* } }* }
Lot : fetch(zones) > 0.5 --> extrude(1 + fetch(mask)) House
Lot : else --> Plant
Plant --> F(fetch(mask, 5, 5)) A +(20) F
A --> F(2)
start Town on box(16, 8, 0)
"""


def test_in_scopes_it_is_asked_where_their_origin_is(folder: Path) -> None:
    scene = grammar(folder, TOWN).run()
    table = scene.instances
    houses = table.label == scene.labels.index("House")
    x, y = table.position[houses, 0], table.position[houses, 1]
    np.testing.assert_allclose(table.size[houses, 2], 1 + oracle(x, y))
    rows = 6 - np.floor((y - 2) * 7 / 10).clip(0, 6).astype(int)
    columns = np.floor((x + 3) * 11 / 20).clip(0, 10).astype(int)
    assert (GREY[rows, columns] > 127).all() and 20 < houses.sum() < 110
    plants = table.size[table.asset == SEGMENT]
    assert len(plants) == 3 * (128 - houses.sum())
    assert float(plants[0, 0]) == pytest.approx(float(oracle(np.array([5.0]), np.array([5.0]))[0]))


def test_channels_and_components(folder: Path) -> None:
    text = (
        "start F(fetch(color, 0, 0)) F(fetch(color, 0, 0, 2)) F(fetch(color, 1, 0, 1)) "
        "F(fetch(wind, 0, 0, 0)) F(fetch(wind, 1, 0, 1)) F(fetch(wind, 0, 9, 0) + 2)\n"
    )
    assert lengths(grammar(folder, text).run()) == [1, 0.2, 1, 1.5, 4, 3.5]


def test_a_vector_of_a_picture_goes_both_ways(folder: Path) -> None:
    text = 'context v : vector = "color.png"\nfn at(c) = 2 + fetch(v, 0, 0, c)\n'
    text += "start F(at(1)) F(at(0))\n"
    assert lengths(grammar(folder, text).run()) == [1, 3]


def test_attributes_may_say_what_it_covers(folder: Path) -> None:
    text = 'context c = "grey.png" over (0, 0, 2 * w, w)\nattr w = 5\nstart F(1 + fetch(c, 3, 3))\n'
    made = grammar(folder, text)
    for width in (5, 40):
        x, y = -3 + 3 / (2 * width) * 20, 2 + 3 / width * 10
        expected = 1 + float(oracle(np.array([x]), np.array([y]))[0])
        assert lengths(made.run(attrs={"w": width}))[0] == pytest.approx(expected)
    with pytest.raises(IpmError, match=r"the context `c` would lie over \(0, 0, -4, -2\)"):
        made.run(attrs={"w": -2})


def test_an_imported_context_lies_beside_its_file(folder: Path) -> None:
    (folder / "lib").mkdir()
    (folder / "grey.png").rename(folder / "lib" / "grey.png")
    library = 'ipm 1\ncontext mask = "grey.png"\nfn high(x) = fetch(mask, x, 0.5)\n'
    (folder / "lib" / "land.ipm").write_text(library)
    text = 'ipm 1\nimport "lib/land"\nstart F(land.high(0.3)) F(fetch(land.mask, 0.3, 0.5))\n'
    (folder / "main.ipm").write_text(text)
    one, other = lengths(ipmlang.load(folder / "main.ipm").run())
    assert one == other > 0


def test_a_style_or_an_importer_may_put_another_context_in_its_place(folder: Path) -> None:
    text = 'style Blank\ncontext Blank.mask = "dot.png" over (0, 0, 1, 1)\n'
    text += "A --> F(1 + fetch(mask, 5, 5))\nstart A Blank.A\n"
    Image.fromarray(np.array([[51]], np.uint8)).save(folder / "dot.png")
    first, second = lengths(grammar(folder, text).run())
    assert first != second == 1.2
    (folder / "land.ipm").write_text(HEAD + "A --> F(1 + fetch(mask, 5, 5))\n")
    text = 'import "land"\ncontext land.mask = "dot.png" over (0, 0, 1, 1)\nstart land.A\n'
    assert lengths(grammar(folder, text).run()) == [1.2]


def test_a_changed_picture_is_read_again(folder: Path) -> None:
    made = grammar(folder, "start F(1 + fetch(mask, 5, 5))\n")
    Image.fromarray(np.full((3, 3), 51, np.uint8)).save(folder / "grey.png")
    assert lengths(made.run()) == [1.2]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("attr a = fetch(mask, 1, 2)\nstart F(a)", "no-shape.*before there are any"),
        ("limit shapes fetch(mask, 1, 2)\nstart F", "no-shape"),
        ("P(n) --> F(fetch(mask, 1, 2, n))\nstart P(1)", "not-constant.*channel must be known"),
        ("const c = 1\nP --> F(fetch(mask, 1, 2, c))\nstart P", "1 channel, and the channel 1"),
        ("start F(mask)", r"(?s)not-executable.*it is fetch\(mask\)"),
    ],
)
def test_what_is_refused(text: str, message: str, folder: Path) -> None:
    with pytest.raises(IpmError, match=message):
        grammar(folder, text + "\n").run()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda path: path.unlink(), "there is no file grey.png"),
        (lambda path: path.write_bytes(path.read_bytes()[:60]), "grey.png is broken"),
        (lambda path: path.write_bytes(b"no picture"), "neither a PNG nor a JPEG"),
    ],
)
def test_a_file_that_broke_since_it_was_checked(make, message: str, folder: Path) -> None:  # type: ignore[no-untyped-def]
    made = grammar(folder, "start F(1 + fetch(mask, 5, 5))\n")
    assert made.program.contexts
    make(folder / "grey.png")
    with pytest.raises(IpmError, match=message) as raised:
        made.run()
    (found,) = raised.value.diagnostics
    assert found.source is not None and found.source.place(found.start)[0] == 2


def test_a_context_that_nobody_asks_is_not_read(folder: Path) -> None:
    made = grammar(folder, "start F\n")
    assert made.program.contexts == ()


def test_no_place_is_an_error_with_its_rule(folder: Path) -> None:
    text = "P(x) --> Q(fetch(mask, x / (x - x), 1))\nQ(n) --> F(n)\nstart P(0)\n"
    with pytest.raises(IpmError, match="not a finite number"):
        grammar(folder, text).run()
