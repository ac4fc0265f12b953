"""Textures in grammars: where they come from, how far they reach, how they lie on parts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ipmlang
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.formats.mesh import read_meshes
from ipmlang.formats.mesh_types import MeshScene
from ipmlang.runtime.export.models import mesh_scene_of
from tests.formats.built import png

START = "ipm 1\nstart Lot on box(12, 8, 9)\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with two images."""
    (tmp_path / "brick.png").write_bytes(png(0, 255))
    (tmp_path / "stone.png").write_bytes(png(7))
    return tmp_path


def model(folder: Path, rules: str) -> MeshScene:
    """The model of a grammar on a box of 12 by 8 by 9."""
    return mesh_scene_of(ipmlang.parse(START + rules, folder=folder).run())


def images(made: MeshScene) -> dict[str, str]:
    """The image on each name."""
    materials = [*(each.texture for each in made.materials), None]
    return {
        made.names[name]: "" if texture is None else texture.name
        for name, number in zip(made.name.tolist(), made.material.tolist(), strict=True)
        for texture in [materials[number]]
    }


def texture_points(made: MeshScene) -> tuple[np.ndarray, np.ndarray]:  # type: ignore[type-arg]
    """Places in the world (c, 3) and texture points (c, 2) of all that has some."""
    places, points = [], []
    for mesh, matrix in zip(made.mesh.tolist(), made.matrix, strict=True):
        own = made.meshes[mesh]
        if own.uv is not None:
            places.append(own.vertices[own.corners] @ matrix[:, :3].T + matrix[:, 3])
            points.append(own.uv)
    return np.concatenate(places), np.concatenate(points)


def test_a_texture_is_of_the_pen(folder: Path) -> None:
    """It ends with a bracket, and an empty name takes it away."""
    rule = 'Lot --> [texture("brick.png") A [texture("stone.png") B] C texture("") D] E\n'
    made = images(model(folder, rule))
    assert made == {"A": "brick", "B": "stone", "C": "brick", "D": "", "E": ""}


def test_an_image_goes_on_over_a_split_facade(folder: Path) -> None:
    """All parts of the front together are one wall: coordinates are places over the tile."""
    made = model(
        folder,
        'Lot --> texture("brick.png") comp { front: Front }\n'
        "Front --> setupProjection(xy, 2.5, 1) split y { 1: Part | { ~3: Floor }* }\n"
        "Floor --> split x { ~1: Part | { ~2.5: [Part] }* | 0.7: Part }\n"
        "Part --> projectUV Wall\n",
    )
    places, points = texture_points(made)
    off = points - places[:, [0, 2]] / [2.5, 1.0]
    assert len(places) > 40
    assert np.abs(off - np.rint(off)).max() < 1e-6


def test_a_projection_is_ready_until_the_body_ends(folder: Path) -> None:
    """Scope operations end with their rule: what stands beside it has the plain sides."""
    made = model(
        folder,
        'Lot --> texture("brick.png") comp { front: Front }\n'
        "Front --> split x { 6: Laid | ~1: Plain }\n"
        "Laid --> setupProjection(xy, 1, 1) projectUV W\n"
        "Plain --> P\n",
    )
    top = {
        made.names[name]: made.meshes[mesh].uv
        for name, mesh in zip(made.name.tolist(), made.mesh.tolist(), strict=True)
    }
    assert top["W"] is not None
    assert top["P"] is not None
    assert top["W"].max(axis=0) == pytest.approx([6, 9])
    assert top["P"].max(axis=0) == pytest.approx([1, 1])


def test_tiles_on_solids_and_boxes(folder: Path) -> None:
    """In the scope's units on every side; a roof's slopes are measured along themselves."""
    made = model(
        folder,
        'Lot --> texture("brick.png") tileUV(2, 1) [Box] comp { top: roofGable(45) Roof }\n',
    )
    sizes = {}
    for name, mesh in zip(made.name.tolist(), made.mesh.tolist(), strict=True):
        uv = made.meshes[mesh].uv
        assert uv is not None
        sizes[made.names[name]] = uv.max(axis=0).round(6).tolist()
    # 12 by 8 by 9: the longest side is 12 / 2 images wide; the highest 9 images high. Half of 8,
    # and as much up, is 4 * sqrt(2) long.
    assert sizes["Box"] == [6, 9]
    assert sizes["Roof"][0] == 6
    assert sizes["Roof"][1] == pytest.approx(8)  # its bottom, which is flat


def test_equal_tiles_of_a_large_wall_share_meshes(folder: Path) -> None:
    """Thousands of parts, few meshes."""
    made = model(
        folder,
        'Lot --> texture("brick.png") comp { front: Front }\n'
        "Front --> setupProjection(xy, 0.6, 0.9) split x { { ~0.2: Column }* }\n"
        "Column --> split y { { 0.1: Part }* }\n"
        "Part --> projectUV W\n",
    )
    assert len(made.mesh) == 60 * 90
    assert len(made.meshes) == 3 * 9


def test_an_imported_grammar_brings_its_images(folder: Path) -> None:
    """A file that it names lies beside it, not beside the main file."""
    (folder / "lib").mkdir()
    (folder / "lib" / "own.png").write_bytes(png(3))
    (folder / "lib" / "walls.ipm").write_text('ipm 1\nWall --> texture("own.png") W\n')
    made = model(folder, 'import "lib/walls"\nLot --> walls.Wall\n')
    assert list(images(made).values()) == ["own"]


def test_a_texture_is_carried_to_files(folder: Path) -> None:
    """Written and read back, from both formats."""
    grammar = ipmlang.parse(START + 'Lot --> texture("brick.png") A\n', folder=folder)
    for suffix in (".obj", ".glb"):
        ipmlang.save(grammar.run(), folder / f"out{suffix}")
        (mesh,) = read_meshes(folder / f"out{suffix}").meshes
        texture = mesh.materials[mesh.material[0]].texture
        assert texture is not None
        content = texture.source if isinstance(texture.source, bytes) else b""
        assert (content or Path(str(texture.source)).read_bytes()) == png(0, 255)


@pytest.mark.parametrize(
    ("rules", "code", "said"),
    [
        ("Lot --> projectUV W\n", "bad-projection", "no projection was set up"),
        ("Lot --> tileUV(scope.sx - 12, 1) W\n", "bad-projection", "above 0"),
        ('Lot --> texture("text.png") W\n', "bad-texture", "neither a PNG nor a JPEG"),
    ],
)
def test_what_cannot_be_is_said(folder: Path, rules: str, code: str, said: str) -> None:
    """As a diagnostic that names the rule, where a rule is at fault."""
    (folder / "text.png").write_text("no image")
    with pytest.raises(IpmError) as caught:
        model(folder, rules)
    (found,) = caught.value.diagnostics
    assert found.code == code
    assert said in found.message
    assert ("Lot" in found.message) == (code == "bad-projection")
