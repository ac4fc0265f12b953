"""Structure planted among clutter is found again: recall and precision stay above what was reached,
and the measure itself tells lists of places from rules.

The floors stand in known/planted_floors.json. The targets are 0.95 at a jitter of 0.1 % of the step
and 0.85 at 1 %.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from inverse.planted import CASES, KINDS, Case, Kind, floors, inferred, name_of, plant, score
from inverse.provenance import ruled_share, sites

from ipmlang.compiler.diagnostics import Source
from ipmlang.compiler.parse import parse

DOT = """<svg xmlns="http://www.w3.org/2000/svg"><path id="dot" d="M0 0L2 0L1 1Z"/></svg>"""
LISTED = "repeat(r in T) { [at(r.x, r.y) dot] }"
WITH_RESIDUALS = "repeat(i < 3) with r in T { [at(9 * i + r.x, r.y) dot] }"
STEPPED = "repeat(r in T) { [dot] f(r.x) }"


def test_every_case_has_a_floor() -> None:
    assert list(floors()) == [name_of(case) for case in CASES]


@pytest.mark.parametrize("case", CASES, ids=name_of)
def test_planted_structure_is_found(case: Case) -> None:
    planted = plant(*case)
    found = inferred(planted)
    reached = score(planted, found)
    recall, precision = floors()[name_of(case)]
    assert reached.recall >= recall, f"{reached}\n{found.text}"
    assert reached.precision >= precision, f"{reached}\n{found.text}"


@pytest.mark.parametrize("kind", KINDS)
def test_the_regular_grammar_has_what_noise_and_order_hide(kind: Kind) -> None:
    planted = plant(kind, 0.001, "shuffled", 0.2)
    reached = score(planted, inferred(planted, symmetrized=True))
    assert reached.recall >= 0.95 <= reached.precision, reached


def test_clutter_is_not_structure() -> None:
    planted = plant("row", 0.0, "contiguous")
    found = inferred(planted)
    nothing = replace(planted, member=planted.member * 0 - 1)
    assert score(planted, found).found > 0
    assert score(nothing, found).found == 0


@pytest.mark.parametrize(
    ("body", "regular"),
    [
        (LISTED, False),
        (WITH_RESIDUALS, True),
        (STEPPED, True),
        ("repeat(i < 3) { [at(5 * i, 0) dot] }", True),
        ("repeat(i < 3) with r in T { [at(r.x, r.y) dot] }", False),
        ("repeat(i < 4) steps (3, 4, 5) { [dot] }", True),
    ],
)
def test_a_list_of_places_is_no_rule(body: str, regular: bool, tmp_path: Path) -> None:
    (tmp_path / "x.parts.svg").write_text(DOT)
    text = f"""ipm 1
asset dot in "x.parts.svg"
table T(x, y) = (0, 0), (5, 1), (3, 8)
A --> {body}
start A [at(50, 50) dot]
"""
    found = sites(parse(Source("x.ipm", text))[0], tmp_path)
    assert [(site.where, site.repeats, site.shared) for site in found] == [
        (0, regular, False),
        ("A", False, False),
    ]
    assert len(found[0].boxes) == len(found[1].boxes) == (4 if "4" in body else 3)


def test_recursion_and_shared_rules(tmp_path: Path) -> None:
    (tmp_path / "x.parts.svg").write_text(DOT)
    text = """ipm 1
asset dot in "x.parts.svg"
P(m) : m > 0 --> [dot] f(9) *(0.9) P(m - 1)
P(m) : else  --> [dot]
Pair         --> [dot] [at(0, 3) dot]
start P(5) [at(0, 50) Pair] [at(9, 60) mirror Pair] [at(80, 80) dot]
"""
    grammar = parse(Source("x.ipm", text))[0]
    found = {each.where: each for each in sites(grammar, tmp_path)}
    assert found["P"].repeats and not found["Pair"].repeats
    assert found["Pair"].shared
    assert len(found["P"].boxes) == 6
    assert len(found["Pair"].boxes) == 4
    assert ruled_share(grammar, tmp_path) == 10 / 11


def test_a_residual_moves_what_is_traced(tmp_path: Path) -> None:
    (tmp_path / "x.parts.svg").write_text(DOT)
    text = """ipm 1
asset dot in "x.parts.svg"
table T(x, layer) = (0, 2), (0.5, 1), (0, 0)
residual T
A --> repeat(i < 3) { [dot] f(9) }
start A
"""
    repeat = sites(parse(Source("x.ipm", text))[0], tmp_path)[0]
    assert repeat.repeats
    assert sorted(repeat.boxes[:, 0].tolist()) == [0, 9.5, 18]
