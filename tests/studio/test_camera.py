"""The camera sees all of a model, as large as it can, from wherever it looks."""

from __future__ import annotations

import numpy as np
import pytest

from ipmlang.compiler.diagnostics import IpmError
from ipmlang.studio.camera import Camera, Floats, axes_of, fitted, orbit
from ipmlang.studio.look import VIEWS, View, parse_background, parse_size, parse_view
from ipmlang.studio.outline import hull, hull_of_copies

SIZES = [(1600, 1000), (400, 900), (512, 512)]
FREE = 0.16  # the share of the picture that stays free on both sides together


def on_picture(camera: Camera, points: Floats) -> Floats:
    """(k, 3) where points are in the picture, -1 to 1, and in depth."""
    clip = np.column_stack([points, np.ones(len(points))]) @ camera.matrix().T
    return clip[:, :3] / clip[:, 3:]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("view", [*VIEWS.values(), View(123.0, -35.0), View(10.0, -90.0)])
@pytest.mark.parametrize("stretch", [(1, 1, 1), (20, 1, 1), (1, 1, 15), (5, 3, 0)])
def test_it_sees_all_and_wastes_nothing(
    size: tuple[int, int], view: View, stretch: tuple[float, float, float]
) -> None:
    random = np.random.default_rng(5)
    points = random.uniform(-1, 1, (200, 3)) * stretch + [3.0, -7.0, 2.0]
    seen = on_picture(fitted(points, view, size), points)
    reach = np.abs(seen[:, :2]).max(axis=0)
    assert reach.max() == pytest.approx(1 - FREE)
    assert (np.abs(seen[:, 2]) < 1).all()


def test_it_is_centred_where_the_model_is_not_in_the_way() -> None:
    points = np.random.default_rng(1).uniform(0, 1, (50, 3))
    seen = on_picture(fitted(points, VIEWS["iso"], (500, 500)), points)
    tight = np.abs(seen[:, :2]).max(axis=0).argmax()
    assert seen[:, tight].max() == pytest.approx(-seen[:, tight].min())


@pytest.mark.parametrize("factor", [1e-3, 1e6])
def test_units_do_not_matter(factor: float) -> None:
    points = np.random.default_rng(2).uniform(-1, 1, (60, 3))
    one = on_picture(fitted(points, VIEWS["iso"], (640, 400)), points)
    other = on_picture(fitted(points * factor, VIEWS["iso"], (640, 400)), points * factor)
    assert other == pytest.approx(one)


def test_named_views_look_where_they_say() -> None:
    forward = {name: axes_of(view)[2].round(12).tolist() for name, view in VIEWS.items()}
    assert forward["front"] == [0, 1, 0]  # from -y towards +y
    assert forward["back"] == [0, -1, 0]
    assert forward["left"] == [1, 0, 0]
    assert forward["right"] == [-1, 0, 0]
    assert forward["top"] == [0, 0, -1]
    x, y, z = forward["iso"]
    assert x < 0 < y and z < 0  # from the right, the front, and above
    for view in VIEWS.values():
        assert axes_of(view) @ axes_of(view).T == pytest.approx(np.eye(3))
    assert axes_of(VIEWS["top"])[1].round(12).tolist() == [0, 1, 0]


def test_rays_are_those_of_the_matrix() -> None:
    camera = fitted(np.random.default_rng(3).uniform(-1, 1, (9, 3)), View(50, 30), (300, 200))
    shift = (0.01, -0.02)
    for x, y in ((0.3, -0.8), (-1.0, 1.0)):
        point = camera.eye + 2.5 * (camera.rays(shift) @ [x, y, 1.0])
        clip = camera.matrix(shift) @ [*point, 1.0]
        assert clip[:2] / clip[3] == pytest.approx([x, y])


def test_a_turn_keeps_its_distance_and_loses_nothing() -> None:
    points = np.random.default_rng(4).uniform(-1, 1, (80, 3)) * [4, 1, 2] + [9, 0, 5]
    cameras = orbit(points, View(30, 20), (400, 300), 7)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    distances = [float(np.hypot(*(each.eye - middle)[:2])) for each in cameras]
    assert distances == pytest.approx([distances[0]] * 7)
    for camera in cameras:
        assert np.abs(on_picture(camera, points)[:, :2]).max() <= 1 - FREE + 1e-9


def test_the_outline_reaches_as_far_as_the_model() -> None:
    random = np.random.default_rng(6)
    vertices = random.normal(size=(500, 3))
    matrices = random.normal(size=(40, 3, 4))
    world = np.einsum("kij,vj->kvi", matrices[:, :, :3], vertices) + matrices[:, None, :, 3]
    world = world.reshape(-1, 3)
    outline = hull_of_copies(vertices, matrices)
    assert len(outline) < len(world) / 20
    directions = random.normal(size=(3, 100))
    assert (outline @ directions).max(axis=0) == pytest.approx((world @ directions).max(axis=0))


def test_the_outline_of_what_is_flat_is_its_box() -> None:
    points = np.random.default_rng(7).uniform(0, 1, (300, 3)) * [1, 1, 0]
    assert np.ptp(hull(points), axis=0) == pytest.approx(np.ptp(points, axis=0))


@pytest.mark.parametrize(
    ("parse", "word", "expected"),
    [
        (parse_size, "1600", "1600x1000"),
        (parse_size, "0x10", "1 to"),
        (parse_size, "99999x10", "1 to"),
        (parse_view, "fron", "did you mean front"),
        (parse_view, "10,95", "AZIMUTH,ELEVATION"),
        (parse_view, "nan,0", "AZIMUTH,ELEVATION"),
        (parse_background, "#12", "colour"),
    ],
)
def test_a_wrong_word_is_explained(parse: object, word: str, expected: str) -> None:
    assert callable(parse)
    with pytest.raises(IpmError) as caught:
        parse(word)
    assert caught.value.diagnostics[0].code == "bad-command"
    assert expected in (caught.value.diagnostics[0].hint or "")
