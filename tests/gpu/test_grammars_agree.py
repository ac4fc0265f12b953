"""Both executors make the same of every grammar there is: the examples, the standard library, the
corpus, and six hundred random ones. Numpy says what is right; `tests.agreement` says how near
floats must lie, and names key, rule and field where they do not.

Grammars that the graphics card has no body for are derived by numpy either way; there must not be
too many of these among the random ones, or nothing would be shown.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from random import Random

import pytest

from ipmlang.compiler import compile_file, compile_text
from ipmlang.compiler.diagnostics import Diagnostic
from ipmlang.compiler.ir import Program
from ipmlang.runtime import derive
from ipmlang.runtime.gpu import machine, seeds
from ipmlang.runtime.gpu.device import Device
from ipmlang.runtime.scene import Scene
from tests.agreement import assert_agree, outcome
from tests.random_grammars import FOLDER, grammar

ROOT = Path(__file__).resolve().parents[2]
FILES = [
    path
    for folder in ("examples", "stdlib", "tests/corpus")
    for path in sorted((ROOT / folder).glob("*.ipm"))
]
SMALLER: dict[str, dict[str, int | float]] = {
    "town": {"trees": 20},
    "castle": {"keep": 12},
    "terrace": {"houses": 2},
    "flats": {"floors": 2},
    "tower": {"floors": 14},
}
GROUND = {"town": 120, "streets": 70, "city": 200}  # as large a square is enough
RANDOM, CHUNK = 600, 40
SMALL = {
    "a symbol in a hole moves the turtle": """
        A --> repeat(i < 3) except (1) { B(i) f(2) } F
        B(i) --> [F C] - C
        C : 50% --> +(30)
        C : else --> F +(20)
        start A""",
    "a symbol in a hole has holes of its own": """
        A --> repeat(i < 3) except (1) { repeat(j < 2) { B(i + j) - } } F
        B(n) : n > 0 --> repeat(k < 3) except (2) { f(k) F [C] } +(25) B(n - 1)
        B(n) : else --> F
        C --> repeat(k < 2) except (0) { F } F
        start A F""",
    "copies that are broken off keep all their registers": """
        A(n, g) --> split y { { ~max(n, 1): V V | 1.13: rotate(0, 0, 40, about: bottom) V }* }
        B --> split x { 1: A(floor(split.count), 1) }
        Z --> repeat(k < 1) { translate(1, 1, 1) } A(1, 1)
        start Z on box(1, 6)""",
    "no production for a symbol in a hole": """
        A --> repeat(i < 2) except (1) { B(i) f(2) } F
        B(i) : i < 1 --> -
        start A""",
    "a symbol with interpret rules alone": """
        A(n) : n > 0 --> [X(n)] [+(30) A(n - 1)]
        A(n) : else --> X(2)
        interpret X(n) --> F(n) F
        start A(3) X(1)""",
}


def agreed(
    program: Program,
    seed: int,
    told: str = "",
    attrs: dict[str, int | float] | None = None,
    on: Path | None = None,
) -> str:
    """Which back end derived a program, once what it gave is what numpy gives."""
    found = outcome(lambda: derive(program, seed=seed, attrs=attrs, on=on, backend="gpu"))
    ran = found.backend if isinstance(found, Scene) else "error"
    if ran != "cpu":
        wanted = outcome(lambda: derive(program, seed=seed, attrs=attrs, on=on))
        assert_agree(wanted, found, told)
        if isinstance(wanted, Diagnostic):
            assert found == wanted, told
    return ran


def square(side: int, folder: Path) -> Path:
    """A file with one lot."""
    corners = (f"v {x * side} {y * side} 0" for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))
    path = folder / "lot.obj"
    path.write_text("\n".join([*corners, "f 1 2 3 4", ""]))
    return path


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parts[-2]}-{path.stem}")
def test_files_agree(path: Path, card: Device, tmp_path: Path) -> None:
    side = GROUND.get(path.stem)
    on = None if side is None else square(side, tmp_path)
    agreed(compile_file(path)[1], 3, attrs=SMALLER.get(path.stem), on=on)


@pytest.mark.parametrize("budget", [20, machine.BUDGET_SOFTWARE])
@pytest.mark.parametrize("name", SMALL)
def test_what_once_differed_agrees(
    name: str, budget: int, card: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(machine, "BUDGET_SOFTWARE", budget)
    monkeypatch.setattr(machine, "BUDGET", budget)
    text = "\n".join(["ipm 1", *(line.strip() for line in SMALL[name].splitlines()), ""])
    for seed in range(3):
        assert agreed(compile_text(text)[1], seed, text) in ("gpu", "gpu+cpu", "error")


@pytest.mark.parametrize("start", range(0, 96, 32))
def test_random_grammars_agree_where_room_is_tight(
    start: int, card: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Passes are cut small, tables run over, bodies are broken off, narrow growth goes by threads
    with stacks that are too small: what is made stays the same.
    """
    for number in range(start, start + 32):
        draw = Random(number)
        monkeypatch.setattr(machine, "SLICE", draw.choice((1, 3, 17, 1 << 20)))
        monkeypatch.setattr(machine, "GROWTH", draw.choice((0.01, 0.3, 1.3)))
        monkeypatch.setattr(machine, "DEEP", draw.choice((0, 1, 64)))
        monkeypatch.setattr(machine, "BUDGET_SOFTWARE", draw.choice((20, 60, 300)))
        monkeypatch.setattr(machine, "BUDGET", draw.choice((20, 60, 300)))
        monkeypatch.setattr(seeds, "SLOTS", draw.choice((1, 2, 16)))
        text = grammar(number)
        agreed(compile_text(text, folder=FOLDER)[1], number, f"grammar({number}):\n{text}")


@pytest.mark.parametrize("start", range(0, RANDOM, CHUNK))
def test_random_grammars_agree(start: int, card: Device) -> None:
    ran = Counter(
        agreed(compile_text(text, folder=FOLDER)[1], number, f"grammar({number}):\n{text}")
        for number, text in ((each, grammar(each)) for each in range(start, start + CHUNK))
    )
    assert ran["gpu"] + ran["gpu+cpu"] >= CHUNK // 2, ran
    assert ran["error"] <= CHUNK // 8, ran
