"""What `infer` promises beside giving drawings back: a flat baseline, equal bytes, clear errors."""

from __future__ import annotations

from pathlib import Path

import pytest

from ipmlang.compiler.diagnostics import IpmError
from ipmlang.inverse import Inference, infer

DATA = Path(__file__).parents[2] / ".." / "shared" / "data" / "svg"


def drawing_path(name: str) -> Path:
    path = DATA / f"{name}.svg"
    if not path.is_file():
        pytest.skip(f"the drawing is not there: {path}")
    return path


def test_flat_is_one_placement_per_element(tmp_path: Path) -> None:
    path = drawing_path("flag_eu")
    flat = infer(path, flat=True)
    assert flat.report.rules == 0
    assert flat.report.tokens == flat.report.tokens_flat == infer(path).report.tokens_flat


def test_the_same_bytes_twice() -> None:
    path = drawing_path("mandala")

    def pair(found: Inference) -> tuple[str, bytes]:
        timeless = "\n".join(line for line in found.text.splitlines() if line[:2] != "//")
        return timeless, found.parts

    assert pair(infer(path)) == pair(infer(path))


def test_what_cannot_be_read_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "cut.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'><g>")
    with pytest.raises(IpmError, match=r"cut\.svg"):
        infer(tmp_path / "cut.svg")
    with pytest.raises(IpmError, match="no-such-method"):
        infer(tmp_path / "cut.svg", method="no-such-method")
    with pytest.raises(IpmError, match="cannot read"):
        infer(tmp_path / "missing.svg")


def test_nothing_half_written(tmp_path: Path) -> None:
    (tmp_path / "one.svg").write_text(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 9 9'>"
        "<rect width='4' height='2'/></svg>"
    )
    found = infer(tmp_path / "one.svg")
    with pytest.raises(IpmError):
        found.save(tmp_path / "no" / "such" / "folder.ipm")
    assert [each.name for each in tmp_path.iterdir()] == ["one.svg"]


def test_a_name_that_no_reference_can_hold_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.svg").write_text(
        "<svg xmlns='http://www.w3.org/2000/svg'><rect width='1' height='1'/></svg>"
    )
    with pytest.raises(IpmError, match="parts file"):
        infer(tmp_path / "x.svg").save(tmp_path / "a#b.ipm")
    assert [each.name for each in tmp_path.iterdir()] == ["x.svg"]
