"""Real drawings and back: the grammar that is inferred for one must give it back exactly, and known
structure must be found. The drawings are not part of this repository.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import ipmlang
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.formats.svg import read_svg, split_compound
from ipmlang.inverse import Inference, infer
from ipmlang.inverse.compare import compare

DATA = Path(__file__).parents[2] / ".." / "shared" / "data" / "svg"
QUICK = [
    "batik_cards",
    "batik_moonPhases",
    "batik_sunRise",
    "batik_symbolViewBox",
    "cad_ex13",
    "cad_lego",
    "flag_eu",
    "flag_ir",
    "flag_ni",
    "flag_us",
    "flag_uz",
    "flag_ve",
    "knotwork",
    "mandala",
    "pattern_tile",
    "pcb_moire",
    "resvg_image",
    "resvg_use_nested",
]
FEWER = {"flag_eu": 5, "flag_uz": 5, "flag_ve": 4, "mandala": 5, "cad_lego": 2, "knotwork": 2}
RULES = {"flag_eu": 4, "flag_uz": 4, "flag_ve": 4}


def drawing_path(name: str) -> Path:
    path = DATA / f"{name}.svg"
    if not path.is_file():
        pytest.skip(f"the drawing is not there: {path}")
    return path


@pytest.mark.parametrize("name", QUICK)
def test_given_back_through_files(name: str, tmp_path: Path) -> None:
    """Infer, save under another name, run, write, read again, compare."""
    path = drawing_path(name)
    found = infer(path)
    assert found.report.max_error < 1e-6
    found.save(tmp_path / "again.ipm")
    ipmlang.save(ipmlang.load(tmp_path / "again.ipm").run(), tmp_path / "again.svg")
    before, after = (split_compound(read_svg(each)) for each in (path, tmp_path / "again.svg"))
    comparison = compare(before, after)
    assert comparison.agrees(), comparison
    assert found.report.tokens_flat >= FEWER.get(name, 1) * found.report.tokens
    if name in RULES:
        assert found.report.rules == RULES[name]
        assert found.report.explained > 0.9


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
