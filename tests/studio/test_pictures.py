"""What is seen in a picture: the model where it stands, in its colours, in the right light."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from studio.scenes import boxes, cube

from ipmlang.formats.mesh_types import Material, MeshScene
from ipmlang.formats.textures import texture_of
from ipmlang.studio import Look, pictures_of
from ipmlang.studio.look import VIEWS, View

pytestmark = pytest.mark.usefixtures("opengl")

Pixels = NDArray[np.uint8]
SIZE = (160, 100)
WHITE = (1.0, 1.0, 1.0, 1.0)
RED = Material("red", (0.8, 0.1, 0.1, 1.0))
BLUE = Material("blue", (0.1, 0.1, 0.8, 1.0))
BARE = Look(SIZE, VIEWS["front"], ground=False, background=WHITE)


def picture(scene: MeshScene, look: Look = BARE) -> Pixels:
    (pixels,) = pictures_of(scene, look)
    assert pixels.shape == (look.pixels(None)[1], look.pixels(None)[0], 4)
    return pixels


def hue(pixel: NDArray[np.uint8]) -> str:
    red, green, blue = pixel[:3].astype(int).tolist()
    if max(red, green, blue) - min(red, green, blue) < 30:
        return "white" if red > 240 else "grey"
    return "red" if red > blue else "blue"


def test_a_model_stands_before_its_background() -> None:
    pixels = picture(boxes([[0, 0, 0]], materials=[RED]))
    assert (pixels[[0, 0, -1, -1], [0, -1, 0, -1]] == 255).all()
    assert hue(pixels[50, 80]) == "red"
    seen = (pixels != 255).any(axis=2)
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    assert rows[[0, -1]].tolist() == pytest.approx([8, 91], abs=1)  # with a margin of 8 %
    assert columns[0] == pytest.approx(160 - 1 - columns[-1], abs=1)


def test_left_is_left_and_up_is_up() -> None:
    pixels = picture(boxes([[-1, 0, 0], [1, 0, 2]], materials=[RED, BLUE]))
    assert hue(pixels[80, 57]) == "red"
    assert hue(pixels[20, 103]) == "blue"
    assert hue(pixels[20, 57]) == "white"


@pytest.mark.parametrize(("view", "first"), [("front", "red"), ("back", "blue")])
def test_what_is_near_hides_what_is_far(view: str, first: str) -> None:
    scene = boxes([[0, -2, 0], [0, 2, 0]], materials=[RED, BLUE])
    assert hue(picture(scene, replace(BARE, view=VIEWS[view]))[50, 80]) == first


@pytest.mark.parametrize("worth", [0, 10**9], ids=["copy by copy", "baked"])
def test_a_mirrored_copy_looks_like_its_image(worth: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ipmlang.studio.surfaces._WORTH", worth)
    scene = boxes([[0, 0, 0]] * 2)
    mirrored = replace(scene, matrix=scene.matrix * np.array([[-1.0], [1.0], [1.0]]))
    look = replace(BARE, view=VIEWS["iso"])
    assert np.abs(picture(scene, look).astype(int) - picture(mirrored, look)).max() <= 3


def test_faces_turned_inside_out_are_seen_all_the_same() -> None:
    inside_out = cube()
    inside_out.corners[:] = inside_out.corners.reshape(-1, 4)[:, ::-1].reshape(-1)
    look = replace(BARE, view=VIEWS["iso"])
    right = picture(boxes([[0, 0, 0]]), look).astype(int)
    assert np.abs(right - picture(boxes([[0, 0, 0]], mesh=inside_out), look)).mean() < 0.5


@pytest.mark.parametrize(("unit", "place"), [(1e-3, 0.0), (1e6, 0.0), (1.0, 4e6)])
def test_units_and_place_do_not_matter(unit: float, place: float) -> None:
    scene = boxes([[0, 0, 0], [2, 1, 0]], materials=[RED, BLUE])
    matrix = scene.matrix * unit
    matrix[:, :, 3] += place
    look = Look(SIZE)
    near, far = picture(scene, look), picture(replace(scene, matrix=matrix), look)
    assert np.abs(near.astype(int) - far).mean() < 0.2


def test_the_same_model_gives_the_same_bytes() -> None:
    scene = boxes([[0, 0, 0], [2, 1, 0]])
    assert picture(scene, Look(SIZE)).tobytes() == picture(scene, Look(SIZE)).tobytes()


def test_the_sun_comes_from_the_left_and_the_ground_takes_the_shadow() -> None:
    scene = boxes([[0, 0, 0]], scale=(1, 1, 3))
    look = Look(SIZE, View(0, 30), background=WHITE)
    shaded = picture(scene, look).astype(int)[:, :, 0]
    plain = picture(scene, replace(look, ground=False)).astype(int)[:, :, 0]
    darker = plain - shaded
    assert (darker >= -3).all()
    assert darker[:, 90:].sum() > 3 * darker[:, :70].sum()
    assert darker.max() > 40
    assert darker[0].max() <= 2  # and leaves the far backdrop alone


def test_a_niche_is_darker_than_a_free_wall() -> None:
    scene = boxes([[0, 0, 0], [-2, -2, 0], [2, -2, 0], [0, 2, 0], [9, 0, 0]], scale=(2, 2, 4))
    look = replace(BARE, size=(400, 200), view=View(0, 20))
    pixels = picture(scene, look).astype(int)[:, :, 0]
    walls = [pixels[120, 20:200].min(), pixels[120, 320:].min()]
    assert walls[0] < walls[1]


def test_what_is_behind_glass_shines_through() -> None:
    glass = Material("glass", (0.1, 0.1, 0.9, 0.4))
    scene = boxes([[0, -2, 0], [0, 0, 0]], materials=[glass, RED])
    red, _, blue = picture(scene)[50, 80, :3].astype(int).tolist()
    assert red > 60
    assert blue > 60


def test_no_background_leaves_the_model_and_its_shadow() -> None:
    look = Look(SIZE, background=(0.0, 0.0, 0.0, 0.0))
    pixels = picture(boxes([[0, 0, 0]], materials=[RED]), look)
    alpha = pixels[:, :, 3]
    assert alpha[0, 0] == 0
    assert alpha[50, 80] == 255
    assert ((alpha > 20) & (alpha < 200)).sum() > 100


def test_an_image_lies_as_its_coordinates_say() -> None:
    image = np.zeros((8, 8, 3), np.uint8)
    image[:4, :, 0] = 255  # red above, blue below
    image[4:, :, 2] = 255
    stream = io.BytesIO()
    Image.fromarray(image).save(stream, "PNG")
    wall = Material("wall", None, texture_of("wall", stream.getvalue()))
    pixels = picture(boxes([[0, 0, 0]], materials=[wall]))
    assert [hue(pixels[row, 80]) for row in (25, 75)] == ["red", "blue"]


def test_lines_are_drawn_where_faces_meet() -> None:
    look = replace(BARE, size=(320, 200), view=VIEWS["iso"])
    plain = picture(boxes([[0, 0, 0]]), look).astype(int)
    lined = picture(boxes([[0, 0, 0]]), replace(look, lines=True)).astype(int)
    changed = np.abs(plain - lined).max(axis=2) > 40
    assert 0.002 < changed.mean() < 0.05


def test_a_background_is_exactly_the_colour_that_was_asked_for() -> None:
    look = replace(BARE, background=(0x12 / 255, 0xAB / 255, 0x80 / 255, 1.0))
    assert (picture(boxes([[0, 0, 0]]), look)[0] == [0x12, 0xAB, 0x80, 255]).all()


def test_a_turn_has_as_many_pictures_as_asked_for() -> None:
    scene = boxes([[1, 0, 0], [-1, 0, 0]], materials=[RED, BLUE])
    turn = list(pictures_of(scene, BARE, 4))
    assert len(turn) == 4
    sides = [(hue(each[50, 50]), hue(each[50, 110])) for each in turn]
    assert sides[0] == ("blue", "red")
    assert sides[2] == ("red", "blue")
