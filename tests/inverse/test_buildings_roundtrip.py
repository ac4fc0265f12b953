"""Real models there and back: inferred, saved, loaded, derived, written and compared as triangles.

The comparison reads OBJ files by itself and shares nothing with the proof of the product. Models
that take long are left to `tests/bench/bench_buildings.py`.
"""

from __future__ import annotations

import json
import subprocess
import sys
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from inverse.disguise import Floats, triangles_of
from scipy.spatial import cKDTree

import ipmlang
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.formats.mesh import read_mesh
from ipmlang.formats.mesh_types import triangulated
from ipmlang.inverse import infer

MODELS = Path(__file__).parents[2] / ".." / "shared" / "data" / "mesh"
SMALL = [
    "building_F_nobase.obj", "market.obj", "pins.glb", "recast_nav_test.obj", "tower_A.obj",
    "wall_straight.obj", "warehouse_boxes.glb", "warehouse_roof.glb", "windmill_fan.obj",
]  # fmt: skip
LIMIT = 1e-6


def _model(name: str) -> Path:
    path = MODELS / name
    if not path.is_file():
        pytest.skip(f"{name} is not there")
    return path


def _triangles(path: Path) -> Floats:
    """(t, 3, 3) of a model, z up where its format says which way is up."""
    if path.suffix == ".obj":
        return triangles_of(path)
    mesh = read_mesh(path)
    return np.asarray(mesh.vertices[mesh.corners[triangulated(mesh)[0]]])


def _apart(first: Floats, second: Floats, limit: float) -> float:
    """How far the triangles of two bags are from each other at most, each with one of its own;
    infinite where one has more. What the first has twice, the second has once.
    """
    one, two = (_sound(each, limit) for each in (first, second))
    tree = cKDTree(one.reshape(-1, 9))
    twice = tree.query_pairs(limit, p=np.inf, output_type="ndarray")
    one = np.delete(one, twice[:, 1], axis=0)
    if len(one) != len(two):
        return float("inf")
    tree = cKDTree(two.reshape(-1, 9))
    found = [tree.query(one[:, list(order)].reshape(-1, 9), p=np.inf)
             for order in permutations(range(3))]  # fmt: skip
    distance, index = (np.stack([each[k] for each in found]) for k in (0, 1))
    best = np.argmin(distance, axis=0)[None]
    partner = np.take_along_axis(index, best, axis=0)[0]
    if len(np.unique(partner)) != len(partner):
        return float("inf")
    return float(np.max(np.take_along_axis(distance, best, axis=0), initial=0.0))


def _sound(triangles: Floats, limit: float) -> Floats:
    """Triangles (t, 3, 3) that have an area."""
    a, b, c = (triangles[:, k] for k in range(3))
    height = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return np.asarray(triangles[height > 1e-3 * limit * np.abs(b - a).max(axis=1)])


def _diagonal(triangles: Floats) -> float:
    return float(np.linalg.norm(np.ptp(triangles.reshape(-1, 3), axis=0)))


@pytest.mark.parametrize("name", SMALL)
def test_a_model_comes_back(name: str, tmp_path: Path) -> None:
    """Every triangle within 1e-6 of the diagonal, the same materials, no warning, two files."""
    path = _model(name)
    found = infer(path)
    found.save(tmp_path / "there.ipm")
    assert {each.name for each in tmp_path.iterdir()} == {
        "there.ipm", f"there.parts{found.suffix}"}  # fmt: skip
    grammar = ipmlang.load(tmp_path / "there.ipm")
    assert not grammar.warnings
    back = tmp_path / "back.obj"
    ipmlang.save(grammar.run(), back)
    was = _triangles(path)
    assert _apart(was, triangles_of(back), LIMIT * _diagonal(was)) <= LIMIT * _diagonal(was)
    assert _materials(back) == {each.name for each in read_mesh(path).materials}
    text = (tmp_path / "there.ipm").read_text(encoding="utf-8")
    assert grammar.format() == text
    assert found.report.tokens == count_text_tokens(text) <= found.report.tokens_flat


def _materials(path: Path) -> set[str]:
    lines = path.read_text(encoding="utf-8").splitlines()
    return {line.split()[1] for line in lines if line.startswith("usemtl")}


@pytest.mark.parametrize("name", ["tower_A.obj", "warehouse_boxes.glb"])
def test_the_same_bytes_every_time(name: str) -> None:
    """Text and parts."""
    first, second = infer(_model(name)), infer(_model(name))
    assert _undated(first.text) == _undated(second.text) and first.parts == second.parts


def _undated(text: str) -> str:
    return "\n".join(line for line in text.splitlines() if not line.startswith("//"))


def test_flat_is_one_placement_per_component() -> None:
    """Without rules and without tables."""
    found = infer(_model("tower_A.obj"), flat=True)
    assert found.report.rules == 0 and "repeat" not in found.text and "table" not in found.text
    assert found.report.tokens == found.report.tokens_flat


def test_one_piece_is_said_to_be_one(tmp_path: Path) -> None:
    """In one line, with the way out, and nothing is written."""
    model, output = tmp_path / "cube.obj", tmp_path / "out.ipm"
    model.write_text(_cubes([(0, 0, 0)]))
    done = _command("infer", str(model), "-o", str(output))
    assert done.returncode != 0 and "one connected piece of 12 triangles" in done.stderr
    assert "docking" in done.stderr and "Traceback" not in done.stderr
    assert [each.name for each in tmp_path.iterdir()] == ["cube.obj"]


def test_the_command_tells_what_was_found(tmp_path: Path) -> None:
    """As JSON with the columns of the paper's table."""
    output = tmp_path / "wall.ipm"
    done = _command("infer", str(_model("wall_straight.obj")), "-o", str(output), "--json")
    record = json.loads(done.stdout)
    assert (record["elements"], record["labels"], record["terminals"]) == (26, 2, 2)
    assert record["method"] == "split" and record["ratio"] > 1
    assert {"rules", "tokens", "tokens_flat", "grammar_bytes", "parts_bytes"} <= record.keys()


def _command(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "ipmlang", *words], capture_output=True, text=True, check=False
    )


CUBE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
SIDES = [(4, 3, 2, 1), (5, 6, 7, 8), (1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8)]


def _cubes(places: list[tuple[float, float, float]], materials: str = "ab") -> str:
    """An OBJ of unit cubes whose tops are of one material and whose sides are of another."""
    lines = []
    for count, (x, y, z) in enumerate(places):
        lines += [f"v {x + a} {y + b} {z + c}" for a, b, c in CUBE]
        for number, side in enumerate(SIDES):
            lines.append(f"usemtl {materials[number == 1]}")
            lines.append("f " + " ".join(str(8 * count + corner) for corner in side))
    return "\n".join(lines) + "\n"


def test_colours_of_a_library_come_back(tmp_path: Path) -> None:
    """They stand in the parts file, which needs no other beside it."""
    model = tmp_path / "cubes.obj"
    model.write_text("mtllib cubes.mtl\n" + _cubes([(3.0 * k, 0, 0) for k in range(5)]))
    (tmp_path / "cubes.mtl").write_text("newmtl a\nKd 0.5 0.25 0.125\nnewmtl b\nKd 1 0 0\n")
    found = infer(model, up="z")
    (tmp_path / "out").mkdir()
    found.save(tmp_path / "out" / "other.ipm")
    assert found.suffix == ".obj"
    ipmlang.save(ipmlang.load(tmp_path / "out" / "other.ipm").run(), tmp_path / "back.obj")
    shades = {each.name: each.color for each in read_mesh(tmp_path / "back.obj").materials}
    assert shades == {"a": (0.5, 0.25, 0.125, 1.0), "b": (1.0, 0.0, 0.0, 1.0)}


def test_what_is_up_is_kept(tmp_path: Path) -> None:
    """A model with y up is a grammar with z up that writes y up."""
    model = tmp_path / "tower.obj"
    model.write_text(_cubes([(0, 2.0 * k, 0) for k in range(4)]))
    found = infer(model, up="y")
    found.save(tmp_path / "found.ipm")
    assert "axes y-up" in found.text and "split z" in found.text
    ipmlang.save(ipmlang.load(tmp_path / "found.ipm").run(), tmp_path / "back.obj")
    assert _apart(triangles_of(model), triangles_of(tmp_path / "back.obj"), 1e-6) < 1e-9


def test_nothing_to_read_is_said(tmp_path: Path) -> None:
    """A file without faces, and one that is a drawing's name only."""
    empty = tmp_path / "empty.obj"
    empty.write_text("v 0 0 0\n")
    done = _command("infer", str(empty))
    assert done.returncode != 0 and "there are no faces" in done.stderr
    with pytest.raises(ipmlang.IpmError, match="does not read"):
        infer(empty, method="lsystem")
    with pytest.raises(ipmlang.IpmError, match="is for drawings"):
        infer(empty, similarity=0.8)
