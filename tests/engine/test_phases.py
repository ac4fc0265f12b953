"""Phases: what is shared among siblings, in any order, and what is reported."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import pytest

import ipmlang
from ipmlang.cli import run_command_line
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.verify import verify
from ipmlang.runtime import pending
from ipmlang.runtime.scene import Scene

# exactly one door in each façade, and one main door in the building
DOORS = """
ipm 1
attr bays = 5
start Lot on box(20, 16, 9)
Lot --> comp { side: label("facade") Facade }
Facade --> split y { 3: Ground | { ~3: Upper }* }
Ground --> split x { { ~(scope.sx / bays): label("bay") phase(2) Bay }* }
Bay : rank("bay", "facade") > 0 --> Window
Bay : rank("bay") == 0 --> MainDoor
Bay : else --> phase(3) Entry
Entry : count("MainDoor") == 1 and count("Window", "facade") > 0 --> Door
Upper --> Band
"""

# thirty storeys in all, dealt out to towers of all sizes by what each wishes for
TOWERS = """
ipm 1
attr storeys : int = 30
attr towers : int = 7
start Site on box(70, 10, 0)
Site --> split x { { ~(70 / towers): Plot }* }
Plot --> report("wish", rand(1, 5)) phase(2) Tower
Tower --> Mass(share("wish", storeys))
Mass(n) : n > 0 --> report("storeys", n) extrude(3 * n) split z { { ~3: Floor }* }
Mass(n) : else --> report("storeys", n)
"""


def run(text: str, seed: int = 0, **attrs: int | float | bool | str) -> Scene:
    grammar = ipmlang.parse(text if text.startswith("\nipm") else "ipm 1\n" + text)
    assert verify(grammar.program) == []
    return grammar.run(seed=seed, attrs=attrs)


def drawn(scene: Scene) -> Counter[str]:
    return Counter(scene.labels[number] for number in scene.instances.label.tolist())


@pytest.mark.parametrize("seed", range(5))
def test_exactly_one_door_in_each_facade(seed: int) -> None:
    scene = run(DOORS, seed)
    doors = [scene.labels.index(each) for each in ("Door", "MainDoor") if each in scene.labels]
    rows = [n for n, label in enumerate(scene.instances.label.tolist()) if label in doors]
    sides = {tuple(scene.instances.rotation[row].round(6)) for row in rows}
    counts = drawn(scene)
    assert len(rows) == len(sides) == 4
    assert counts["Window"] == 16
    assert counts["MainDoor"] <= 1


def test_the_door_is_where_the_seed_puts_it() -> None:
    doors = {
        tuple(scene.instances.position[scene.instances.label == scene.labels.index("Door")][0])
        for scene in (run(DOORS, seed, bays=9) for seed in range(8))
    }
    assert len(doors) > 4


def test_the_first_of_a_building_is_one() -> None:
    text = """
start Lot on box(20, 16, 3)
Lot --> comp { side: Facade }
Facade --> split x { { ~4: label("bay") phase(2) Bay }* }
Bay : rank("bay") == 0 --> Door
Bay : else --> Window
"""
    for seed in range(4):
        assert drawn(run(text, seed)) == {"Door": 1, "Window": 17}


@pytest.mark.parametrize(("seed", "storeys", "towers"), [(0, 30, 7), (1, 1, 3), (2, 1000, 40)])
def test_storeys_are_dealt_out_without_a_rest(seed: int, storeys: int, towers: int) -> None:
    scene = run(TOWERS, seed, storeys=storeys, towers=towers)
    assert scene.reports["storeys"] == (storeys, towers)
    assert drawn(scene) == {"Floor": storeys}


def test_shares_follow_the_wishes() -> None:
    text = """
start Site on box(4, 1, 0)
Site --> split x { 1: Plot(1) | 1: Plot(2) | 1: Plot(3) | 1: Plot(4) }
Plot(w) --> report("wish", w) phase(2) Tower(w)
Tower(w) : share("wish", 100) == 10 * w --> Right
"""
    assert drawn(run(text)) == {"Right": 4}


def test_results_do_not_depend_on_batches(monkeypatch: pytest.MonkeyPatch) -> None:
    scenes = [run(text, 3) for text in (DOORS, TOWERS)]
    monkeypatch.setattr(pending, "CHUNK", 2)
    for text, whole in zip((DOORS, TOWERS), scenes, strict=True):
        parts = run(text, 3)
        assert parts.instances.key.tolist() == whole.instances.key.tolist()
        assert parts.instances.label.tolist() == whole.instances.label.tolist()
        assert parts.instances.size.tolist() == whole.instances.size.tolist()
        assert parts.reports == whole.reports


def test_a_phase_sees_those_before_it_and_not_itself() -> None:
    text = """
start Lot on box(6, 1, 1)
Lot --> split x { 1: A(1) | 1: phase(3) A(3) | 1: phase(2) A(2) | 1: phase(2) A(2) | ~1: A(1) }
A(p) : count("A") == 0 and p == 1 --> One
A(p) : count("A") == 2 and p == 2 --> Two
A(p) : count("A") == 4 and p == 3 --> Three
"""
    assert drawn(run(text)) == {"One": 2, "Two": 2, "Three": 1}


def test_phases_reach_all_that_follows_and_never_go_back() -> None:
    text = """
start Lot on box(3, 1, 1)
Lot --> split x { 1: phase(2) A | 1: B | 1: phase(2) phase(1) A }
A --> phase(1) C
B --> label("b") D
C : count("b") == 1 --> Late
C : else --> Early
D --> Wall
"""
    assert drawn(run(text)) == {"Late": 2, "Wall": 1}


def test_totals_within_a_shape() -> None:
    text = """
start Lot on box(4, 2, 1)
Lot --> split x { 1: Block(3) | 3: Block(5) }
Block(v) --> split y { 1: label("unit") report("area", v) | 1: phase(2) Check(v) }
Check(v) : total("area", "Block") == v and total("area") == 8 and count("unit", "Block") == 1
  and count("unit") == 2 and count("unit", "nowhere") == 0 --> Right
"""
    assert drawn(run(text)) == {"Right": 2}


def test_one_that_does_not_compete_has_no_rank_and_no_share() -> None:
    text = """
start Lot on box(4, 1, 1)
Lot --> split x { 1: label("bay") report("wish", 2) A | 1: phase(2) B }
B : rank("bay") == -1 and share("wish", 9) == 0 and count("bay") == 1 --> Right
A --> Wall
"""
    assert drawn(run(text)) == {"Wall": 1, "Right": 1}


def test_phases_and_occlusion_go_together() -> None:
    """Ranks are among what the second pass made: the doors that another mass hides are none."""
    text = """
start Lot on box(12, 4, 3)
Lot --> [size(6, 4, 3) Mass] [translate(6, 0, 0) size(6, 4, 3) Other]
Other --> comp { all: Face }
Mass --> comp { side: split x { { ~2: Bay }* } }
Bay : inside("Other") --> Hidden
Bay : else --> label("free") phase(2) Free
Free : rank("free") == 0 --> Door
Free : else --> Window
"""
    for seed in range(6):
        assert drawn(run(text, seed)) == {"Face": 6, "Hidden": 2, "Door": 1, "Window": 7}


@pytest.mark.parametrize(
    ("number", "told"),
    [
        ("scope.sx - 3", "phases are the whole numbers"),
        ("scope.sx + 0.5", "phases are the whole numbers"),
        ("1 / (scope.sx - 2)", "an argument of phase is not a finite number"),
    ],
)
def test_a_phase_is_a_whole_number(number: str, told: str) -> None:
    with pytest.raises(IpmError, match=told):
        run(f"start Lot on box(2, 1, 1)\nLot --> phase({number}) A\nA --> Wall")


def test_reports_sum_up_the_same_in_any_order(monkeypatch: pytest.MonkeyPatch) -> None:
    text = """
start Lot on box(9, 1, 1)
Lot --> split x { { ~0.01: A(exp(rand(-20, 20))) }* }
A(v) --> report("v", v) report("w", -v)
"""
    whole = run(text).reports
    monkeypatch.setattr(pending, "CHUNK", 13)
    assert run(text).reports == whole
    assert whole["v"][0] == -whole["w"][0]
    assert whole["v"][1] == 900


def test_a_report_must_be_finite() -> None:
    with pytest.raises(IpmError, match="an argument of report is not a finite number"):
        run('start Lot on box(9, 1, 1)\nLot --> report("v", 1 / (scope.sx - 9)) Wall')


def test_run_shows_reports(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "lot.ipm").write_text(TOWERS.lstrip())
    command = ["run", str(tmp_path / "lot.ipm"), "-o", str(tmp_path / "lot.glb")]
    assert run_command_line(command) == 0
    lines = capsys.readouterr().out.splitlines()[1:]
    assert [line.split()[0] for line in lines] == ["report", "storeys", "wish"]
    assert lines[1].split()[1:] == ["30", "7"]
    assert run_command_line([*command, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["reports"]["storeys"] == {"sum": 30.0, "count": 7}


def test_each_of_many_first_shapes_has_its_own_competitors(tmp_path: Path) -> None:
    """Lots of a file that lie on each other; the one that stands alone has no bays."""
    rects = "".join(f'<rect x="{x}" y="0" width="10" height="8"/>' for x in (0, 20, 5))
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 40 20">{rects}</svg>'
    (tmp_path / "lots.svg").write_text(svg)
    text = """ipm 1
start Lot on "lots.svg"
Lot : overlaps("Lot") --> split x { { ~2: label("bay") phase(2) Bay }* }
Lot : else --> Free
Bay : rank("bay", "Lot") == 0 --> Door
Bay : else --> Window
"""
    scene = ipmlang.parse(text, folder=tmp_path).run()
    assert drawn(scene) == {"Door": 2, "Window": 8, "Free": 1}
