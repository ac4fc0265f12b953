"""Footprints, assets and rules that no solid can come of: a message that says what and where, exit
code 1, no file.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from ipmlang.cli import run_command_line

FILES = {
    "points.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\n",
    "bent.obj": "v 0 0 0\nv 4 0 0\nv 4 3 1\nv 0 3 0\nf 1 2 3 4\n",
    "bow.svg": '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10">'
    '<rect width="1" height="1"/><path id="bow" d="M0 0L10 10L10 0L0 10z"/></svg>',
}
GROUNDS = {
    "polygon [(0,0), (10,10), (10,0), (0,10)]": ["crosses itself at (5, 5)"],
    "polygon [(0,0,0), (10,0,0), (10,10,2), (0,10,0)]": ["not flat: point", "off its plane"],
    "polygon [(0,0), (5,0), (9,0)]": ["its points lie on a line"],
    "box(3, 0, 0)": ["cannot stand on box(3, 0, 0)"],
    '"bent.obj"': ["bent.obj, shape 1: the face is not flat: point"],
    '"bow.svg"': ["bow.svg, shape 2 (bow): the polygon crosses itself at (5, 5)"],
    '"points.obj"': ["points.obj: there are no faces"],
}
RULES = {
    "insert(thing) Mass": ["points.obj: there are no faces"],
    "roofHip(0) Mass": ["rule Lot (", "slope by 0 degrees", "in start > Lot"],
    "extrude(1) roofHip(30) Mass": ["rule Lot (", "not on 6 faces"],
    "extrude(1 / 0) Mass": ["rule Lot (", "not a finite number"],
    "size(-1, 1, 1) Mass": ["rule Lot (", "extents of 0 or more"],
    "union { Mass | extrude(2) Tall }": ["rule Lot (", "its part 1 draws has open edges"],
    "split x { ~1: Lot | ~1: Lot }": ["rule Lot (", "limit of 20,000 shapes", "in start > Lot"],
    "[extrude(1) comp { top: Lot }]": ["rule Lot (", "limit of 300 steps", "Lot[0] > Lot[0]"],
    "subtract { Lot | extrude(1) Mass }": ["rule Lot (", "limit of 300 steps"],
    "split x { { ~0.000001: Tile }* }": ["rule Lot (", "limit of 20,000 shapes"],
    "extrude(1) subdivide(300, 300, 3) Tile": ["rule Lot (", "limit of 20,000 shapes"],
    "scatter(1000000) Tree": ["rule Lot (", "limit of 20,000 shapes"],
}


def told(text: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """What a run of a grammar says on its way to exit code 1."""
    for name, content in FILES.items():
        (folder / name).write_text(content)
    (folder / "bad.ipm").write_text(f'ipm 1\nasset thing = "points.obj"\n{text}\n')
    limits = ["--limit", "shapes=20000", "--limit", "steps=300"]
    words = ["run", str(folder / "bad.ipm"), "-o", str(folder / "out.glb"), *limits]
    assert run_command_line(words) == 1
    assert not (folder / "out.glb").exists()
    return capsys.readouterr().err


@pytest.mark.parametrize("place", GROUNDS)
def test_what_nothing_can_stand_on(
    place: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = told(f"Lot --> extrude(3) Mass\nstart Lot on {place}", tmp_path, capsys)
    assert all(each in said for each in GROUNDS[place]), said


@pytest.mark.parametrize("body", RULES)
def test_what_no_solid_comes_of(
    body: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = told(f"Lot --> {body}\nstart Lot on box(3, 2, 0)", tmp_path, capsys)
    assert all(each in said for each in RULES[body]), said


def test_a_program_with_scopes_stops_sooner(tmp_path: Path) -> None:
    from ipmlang import parse

    deep = parse("ipm 1\nLot --> extrude(1) comp { top: Lot }\nstart Lot")
    assert deep.program.limits.steps == 5_000
    own = parse("ipm 1\nlimit steps 7\nLot --> extrude(1) comp { top: Lot }\nstart Lot")
    assert own.program.limits.steps == 7
