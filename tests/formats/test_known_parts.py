"""Parts of models that are read once: known again by what stands in the file, wherever it lies."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from ipmlang.formats import FormatError, known_parts, obj_read
from ipmlang.formats.known_parts import FILES, part_meshes, part_names

TWO = "o near\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no far\nv 0 0 9\nv 1 0 9\nv 0 1 9\nf 4 5 6\n"


@pytest.fixture
def reads(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """The files whose geometry was read."""
    found: list[Path] = []
    original = obj_read.read_obj
    monkeypatch.setattr(obj_read, "read_obj", lambda path: (found.append(path), original(path))[1])
    return found


def written(path: Path, text: str) -> Path:
    """A file that no test before this one can have read."""
    path.write_text(f"# {path}\n{text}", encoding="utf-8")
    return path


def test_a_copy_of_a_file_is_not_read_again(tmp_path: Path, reads: list[Path]) -> None:
    path = written(tmp_path / "a.obj", TWO)
    (far,) = part_meshes(path, ["far"])
    copy = Path(shutil.copy(path, tmp_path / "b.obj"))
    again, near = part_meshes(copy, ["far", "near"])
    assert reads == [path, copy], "near was not asked for before"
    assert again[0] is far[0]
    assert near[0].vertices[:, 2].tolist() == [0, 0, 0]
    assert part_names(copy) == ("near", "far")
    assert len(part_meshes(path, ["near", "far", "near"])) == 3
    assert len(reads) == 2


def test_a_file_that_changed_is_read_again(tmp_path: Path) -> None:
    path = written(tmp_path / "a.obj", TWO)
    part_meshes(path, ["far"])
    assert part_names(path) == ("near", "far")
    written(path, TWO.replace(" 9", " 7").replace("near", "here"))
    assert part_meshes(path, ["far"])[0][0].vertices[:, 2].tolist() == [7, 7, 7]
    assert part_names(path) == ("here", "far")


def test_a_file_that_names_others_is_read_each_time(tmp_path: Path, reads: list[Path]) -> None:
    """The colours stand in a library, which may change."""
    path = written(tmp_path / "a.obj", f"mtllib a.mtl\nusemtl red\n{TWO}")
    for color in ("1 0 0", "0 0 1"):
        (tmp_path / "a.mtl").write_text(f"newmtl red\nKd {color}\n", encoding="utf-8")
        ((mesh, _),) = part_meshes(path, ["far"])
        assert mesh.materials[0].color == (*map(float, color.split()), 1.0)
    assert len(reads) == 2


def test_what_is_remembered_cannot_be_written_to(tmp_path: Path) -> None:
    ((mesh, _),) = part_meshes(written(tmp_path / "a.obj", TWO), [None])
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0] = 1.0


def test_the_last_few_files_are_remembered(tmp_path: Path, reads: list[Path]) -> None:
    paths = [written(tmp_path / f"{number}.obj", TWO) for number in range(FILES + 1)]
    for path in [*paths, paths[-1], paths[0]]:
        part_meshes(path, [None])
    assert reads == [*paths, paths[0]]


def test_what_cannot_be_read_is_an_error_each_time(tmp_path: Path) -> None:
    path = written(tmp_path / "a.obj", TWO)
    for _ in range(2):
        with pytest.raises(FormatError, match="nothing in the file is called `other`"):
            part_meshes(path, ["other"])
        with pytest.raises(FormatError, match="no such file"):
            part_meshes(tmp_path / "absent.obj", [None])


def test_corners_written_in_several_ways(tmp_path: Path) -> None:
    """As many as a reader meets in one file, read together as one by one."""
    texts = ["1 2//2 3/3/3", "1/1 2/2 3", "-3//-3 -2/-2 -1", "1 2 3"]
    at = np.arange(len(texts))
    together, alone = obj_read._mixed_table(at, texts), obj_read._one_by_one(at, texts)
    assert together.tolist() == alone.tolist()
    for wrong in ("1/0 2 3", "1/ 2 x", "1/2/3/4 2 3", "/1 2 3", "1.5 2 3"):
        with pytest.raises(FormatError, match="corner of a face") as found:
            obj_read._mixed_table(at, [*texts[:3], wrong])
        assert found.value.line == 4


def test_parts_that_are_large_together_are_not_kept(
    tmp_path: Path, reads: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(known_parts, "MOST_CORNERS", 5)
    path = written(tmp_path / "a.obj", TWO)
    for nodes in (["near"], ["far", "near"], ["near", "far"]):
        heights = [mesh.vertices[0, 2] for mesh, _ in part_meshes(path, nodes)]
        assert heights == [9.0 if node == "far" else 0.0 for node in nodes]
    assert len(reads) == 3, "near is kept, far is one too many"
