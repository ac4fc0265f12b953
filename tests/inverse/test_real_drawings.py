"""The main job on real input: each collected drawing becomes a grammar that gives it back.

Nobody here drew them; they are read where they lie and never copied. What is compared is not what
inference compared: the written grammar is loaded, run and saved, and the saved file is read again.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import ipmlang
from ipmlang.compiler.diagnostics import Source
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.parse import parse
from ipmlang.formats.svg import read_svg, split_compound
from ipmlang.inverse.compare import compare
from tests.real_drawings import NAMES, parted, path_of

FEWER = {  # times as many tokens as the grammar has, one placement per element takes
    "batik_cards": 2.5,
    "batik_symbolViewBox": 4,
    "cad_lego": 2.7,
    "cad_line_types": 5,
    "flag_eu": 7,
    "flag_us": 2.8,
    "flag_uz": 6.5,
    "flag_ve": 5,
    "knotwork": 3.6,
    "mandala": 8,
    "vega_small_multiples": 5,
}
UNSTRUCTURED = ("map_usa_counties", "vpype_7k_lines")  # where nothing may be invented


@pytest.mark.parametrize("name", NAMES)
def test_infer_then_run_gives_the_drawing_back(name: str, tmp_path: Path) -> None:
    path = path_of(name)
    found = ipmlang.infer(path)
    found.save(tmp_path / "x.ipm")
    text = (tmp_path / "x.ipm").read_text(encoding="utf-8")
    grammar, diagnostics = parse(Source("x.ipm", text))
    assert not diagnostics
    assert format_grammar(grammar) == text
    ipmlang.save(ipmlang.load(tmp_path / "x.ipm").run(), tmp_path / "x.svg")
    assert sorted(os.listdir(tmp_path)) in (["x.ipm", "x.parts.svg", "x.svg"], ["x.ipm", "x.svg"])
    given = parted(name)
    again = split_compound(read_svg(tmp_path / "x.svg"))
    comparison = compare(given, again)
    assert comparison.agrees(1e-6), comparison
    assert found.report.max_error <= 1e-6
    assert found.report.elements == len(given.elements)
    assert found.report.tokens_flat >= FEWER.get(name, 1) * found.report.tokens
    if name in UNSTRUCTURED:
        assert found.report.rules == 0
        assert found.report.tokens <= 1.02 * found.report.tokens_flat
