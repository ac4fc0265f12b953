"""Grammars written by hand are found again from their drawings: exactly, in about as many tokens,
and with as many elements under rules.

The bounds of each stand in known/bounds.json, as tight as inference has come so far.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from inverse.known.answers import FOLDER, answer, bounds, names, tokens_of

import ipmlang
from ipmlang.inverse import infer

ROUNDING = 0.005


def test_every_known_answer_has_its_bounds() -> None:
    assert sorted(bounds()) == names()


@pytest.mark.parametrize("name", names())
def test_author_writes_in_the_one_layout(name: str) -> None:
    path = FOLDER / f"{name}.ipm"
    assert ipmlang.load(path).format() == path.read_text(encoding="utf-8")


def test_tokens_are_counted_as_a_report_counts_them(tmp_path: Path) -> None:
    ipmlang.save(ipmlang.load(FOLDER / "scatter.ipm").run(), tmp_path / "drawn.svg")
    found = infer(tmp_path / "drawn.svg")
    found.save(tmp_path / "found.ipm")
    assert tokens_of(tmp_path / "found.ipm") == found.report.tokens


@pytest.mark.parametrize("name", names())
def test_known_answer(name: str) -> None:
    found = answer(name)
    assert found.comparison.agrees(), found.comparison.offenders
    ceiling, floor = bounds()[name]
    told = f"{found.inferred} tokens, author {found.author}, ceiling {ceiling}\n{found.text}"
    assert found.ratio <= ceiling + ROUNDING, told
    assert found.ruled >= floor - ROUNDING, f"{found.ruled:.0%} under rules\n{found.text}"
