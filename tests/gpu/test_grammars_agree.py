"""Both executors make the same of every grammar there is: the examples, the standard library, the
corpus, and a thousand random ones. Numpy says what is right; `tests.agreement` says how near floats
must lie, and names key, rule and field where they do not.

Grammars that the graphics card has no body for are derived by numpy either way; there must not be
too many of these among the random ones, or nothing would be shown.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from ipmlang.compiler import compile_file, compile_text
from ipmlang.compiler.ir import Program
from ipmlang.runtime import derive
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
RANDOM, CHUNK = 1000, 40


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


@pytest.mark.parametrize("start", range(0, RANDOM, CHUNK))
def test_random_grammars_agree(start: int, card: Device) -> None:
    ran = Counter(
        agreed(compile_text(text, folder=FOLDER)[1], number, f"grammar({number}):\n{text}")
        for number, text in ((each, grammar(each)) for each in range(start, start + CHUNK))
    )
    assert ran["gpu"] + ran["gpu+cpu"] >= CHUNK // 2, ran
    assert ran["error"] <= CHUNK // 8, ran
