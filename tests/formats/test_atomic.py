"""A result appears whole or not at all."""

from __future__ import annotations

import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from ipmlang.formats import FormatError
from ipmlang.formats.atomic import write_file, write_files


def test_contents_of_all_kinds(tmp_path: Path) -> None:
    """Bytes, text and parts; what was there before is replaced, nothing else is left."""
    (tmp_path / "a").write_text("old")
    write_files({tmp_path / "a": "é", tmp_path / "b": b"\0", tmp_path / "c": ["x", b"y"]})
    assert (tmp_path / "a").read_bytes() == "é".encode()
    assert (tmp_path / "b").read_bytes() == b"\0"
    assert (tmp_path / "c").read_bytes() == b"xy"
    assert len(list(tmp_path.iterdir())) == 3


def test_an_error_while_making_a_file_leaves_all_as_it_was(tmp_path: Path) -> None:
    """Even if another file of the result was complete."""

    def parts() -> Iterator[bytes]:
        yield b"half"
        raise RuntimeError("stop")

    (tmp_path / "b").write_text("old")
    with pytest.raises(RuntimeError):
        write_files({tmp_path / "a": "new", tmp_path / "b": parts()})
    assert [path.name for path in tmp_path.iterdir()] == ["b"]
    assert (tmp_path / "b").read_text() == "old"


def test_a_target_that_cannot_be_written(tmp_path: Path) -> None:
    """A missing folder, and a folder where a file should be, name themselves and give a hint."""
    with pytest.raises(FormatError, match="no such file") as caught:
        write_file(tmp_path / "nowhere" / "a.svg", "x")
    assert caught.value.hint
    (tmp_path / "folder").mkdir()
    with pytest.raises(FormatError, match="folder"):
        write_files({tmp_path / "a": "x", tmp_path / "folder": "y"})
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]


def test_a_failure_while_files_take_their_places(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The files that had taken theirs already are put back."""
    import os

    real = os.replace

    def replace(source: Path, target: Path) -> None:
        if Path(target).name == "b" and not hasattr(replace, "failed"):
            replace.failed = True  # type: ignore[attr-defined]
            raise OSError(5, "input/output error")
        real(source, target)

    (tmp_path / "a").write_text("old")
    monkeypatch.setattr(os, "replace", replace)
    with pytest.raises(FormatError):
        write_files({tmp_path / "a": "new", tmp_path / "b": "new"})
    assert (tmp_path / "a").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_links_and_permissions_stay(tmp_path: Path) -> None:
    """A link is followed, not replaced; a replaced file keeps its permissions."""
    target, link = tmp_path / "a", tmp_path / "link"
    target.write_text("old")
    target.chmod(0o640)
    link.symlink_to(target)
    write_file(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert stat.S_IMODE(target.stat().st_mode) == 0o640


def test_devices_are_written_directly() -> None:
    """`-o /dev/null` works."""
    write_file(Path("/dev/null"), "x")
