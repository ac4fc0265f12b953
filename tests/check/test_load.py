"""Loading: files that cannot be read, imports, and what may not leave the grammar's folder."""

from __future__ import annotations

from pathlib import Path

import pytest

from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.load import Loaded, load, load_text, read_source, standard_library
from ipmlang.compiler.reference import describe, reference

SVG = '<svg xmlns="http://www.w3.org/2000/svg"><path id="rail" d="M0 0h9"/></svg>'


def write(folder: Path, **files: str) -> None:
    for name, text in files.items():
        (folder / f"{name}.ipm").write_text(text, encoding="utf-8")


def codes(loaded: Loaded) -> list[str]:
    return [each.code for each in loaded.diagnostics]


def test_a_missing_file_names_its_neighbours(tmp_path: Path) -> None:
    write(tmp_path, fence="ipm 1\n")
    with pytest.raises(IpmError) as caught:
        load(tmp_path / "fense.ipm")
    assert caught.value.diagnostics[0].suggestions == ("fence.ipm",)


def test_a_folder_is_no_grammar(tmp_path: Path) -> None:
    with pytest.raises(IpmError, match="is a folder"):
        load(tmp_path)


def test_the_wrong_byte_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.ipm").write_bytes(b"ipm 1\nA --> F\xff\n")
    with pytest.raises(IpmError, match="byte 13 on line 2"):
        load(tmp_path / "a.ipm")


def test_a_file_may_be_too_large(tmp_path: Path) -> None:
    with (tmp_path / "a.ipm").open("wb") as file:
        file.truncate(65_000_000)
    with pytest.raises(IpmError, match="larger than 64 MB"):
        read_source(tmp_path / "a.ipm")


def test_imports_are_found_named_and_read_once(tmp_path: Path) -> None:
    write(tmp_path, main='ipm 1\nimport "a"\nimport "b" as second\nstart a.A second.B\n',
          a='ipm 1\nimport "b"\nA --> b.B\n', b="ipm 1\nB --> F\n")  # fmt: skip
    loaded = load(tmp_path / "main.ipm")
    assert codes(loaded) == []
    assert [file.prefix for file in loaded.files] == ["", "a.", "second."]
    main, first, second = loaded.files
    assert main.imports == {"a": first, "second": second}
    assert first.imports == {"b": second}


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ('import "bad"', "import-cycle"), ('import "nowhere"', "no-such-import"),
        ('import "../elsewhere"', "outside-folder"), ('import "/etc/passwd"', "outside-folder"),
        ('import "std/../../ipmlang/x"', "outside-folder"),
        ('import "std/nowhere"', "no-such-import"),
        ('import "a"\nimport "a"', "duplicate-name"),
        ('asset a = "nowhere.svg"', "no-such-file"),
        ('asset a = "/etc/passwd.svg"', "outside-folder"),
        ('asset a = "../x.svg"', "outside-folder"), ('asset a = "bad.ipm"', "wrong-file-type"),
        ('asset a = "link.svg"', "outside-folder"), ('asset a = "parts.stl#b"', "no-such-node"),
        ('surface s = "parts.svg"', "wrong-file-type"),
        ('context c = "nowhere.png"', "no-such-file"),
        ('table t = "parts.stl#T"', "wrong-file-type"),
        ('start F on "lots.txt"', "wrong-file-type"),
        ('asset a = "par\\u0000ts.svg"', "wrong-file-type"),
    ],
)  # fmt: skip
def test_a_wrong_reference(text: str, code: str, tmp_path: Path) -> None:
    folder = tmp_path / "inner"
    folder.mkdir()
    write(folder, bad=f"ipm 1\n{text}\n", a="ipm 1\n")
    (folder / "parts.svg").write_text(SVG, encoding="utf-8")
    (folder / "parts.stl").write_bytes(b"")
    (tmp_path / "outside.svg").write_text(SVG, encoding="utf-8")
    (folder / "link.svg").symlink_to(tmp_path / "outside.svg")
    assert code in codes(load(folder / "bad.ipm")) or "\\u0000" in text


def test_outside_may_be_allowed(tmp_path: Path) -> None:
    folder = tmp_path / "inner"
    folder.mkdir()
    write(folder, main='ipm 1\nasset a = "../x.svg"\nimport "../other"\nstart a\n')
    write(tmp_path, other="ipm 1\n")
    (tmp_path / "x.svg").write_text(SVG, encoding="utf-8")
    assert codes(load(folder / "main.ipm")) == ["outside-folder", "outside-folder"]
    assert codes(load(folder / "main.ipm", allow_outside=True)) == []


def test_a_changed_import_is_read_again(tmp_path: Path) -> None:
    write(tmp_path, main='ipm 1\nimport "a"\nstart a.A\n', a="ipm 1\nA --> F\n")
    assert codes(load(tmp_path / "main.ipm")) == []
    write(tmp_path, a="ipm 1\nA --> F(\n")
    assert codes(load(tmp_path / "main.ipm")) != []


def test_the_standard_library_is_found() -> None:
    assert (standard_library() / "curves.ipm").is_file()
    assert load_text('ipm 1\nimport "std/curves"\n').main.imports["curves"].prefix == "curves."


def test_the_reference_is_the_one_that_is_checked_in() -> None:
    """Made by `python -m ipmlang.compiler.reference`."""
    assert (standard_library() / "REFERENCE.md").read_text(encoding="utf-8") == reference()


def test_help_for_a_name() -> None:
    assert "draw a segment" in (describe("draw") or "")
    assert "whole number" in (describe("floor") or "")
    assert describe("Fence") is None
