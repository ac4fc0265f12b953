"""The house rules that a machine can check: lint, format, types, import direction, file size."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = Path(sys.executable).parent


@pytest.mark.parametrize(
    "command",
    [
        ["ruff", "check", "."],
        ["ruff", "format", "--check", "."],
        ["mypy"],
        ["lint-imports", "--no-cache"],
    ],
    ids=lambda command: " ".join(command[:2]),
)
def test_tool_is_content(command: list[str]) -> None:
    """Each tool passes on the whole tree, with the settings of pyproject.toml."""
    done = subprocess.run(
        [SCRIPTS / command[0], *command[1:]], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_file_has_one_subject() -> None:
    """No file of the package runs over 480 lines (the style says 400, rarely more); the syntax tree
    is one long declaration.
    """
    lengths = {
        str(path.relative_to(ROOT)): path.read_text(encoding="utf-8").count("\n")
        for path in (ROOT / "ipmlang").rglob("*.py")
    }
    long = {
        name: lines
        for name, lines in lengths.items()
        if lines > 480 and not name.endswith("compiler/ast.py")
    }
    assert not long


HEAVY = "trimesh scipy shapely svgpathtools networkx moderngl PIL rich lxml manifold3d"
LIGHT = {
    "importing the package and the command line": (
        "import ipmlang, ipmlang.__main__, ipmlang.cli, ipmlang.compiler"
    ),
    "checking a small grammar": (
        "from ipmlang.compiler.load import load_text\n"
        "from ipmlang.compiler.check import check\ncheck(load_text('ipm 1\\nstart F\\n'))"
    ),
}


@pytest.mark.parametrize("work", LIGHT)
def test_start_up_stays_light(work: str) -> None:
    """What every command does first loads none of the heavy libraries."""
    code = f"{LIGHT[work]}\nimport sys\nprint([n for n in {HEAVY!r}.split() if n in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_no_pattern_has_possessive_groups() -> None:
    """`(…)*+` and `(?>…)` do not match what they should before Python 3.11.5, which Debian 12 has
    not; a possessive quantifier of one character or class is sound.
    """
    groups = re.compile(r"\)[*+?]\+|\(\?>")
    named = {"ipmlang/compiler/items.py", "ipmlang/formats/svg/units.py"}  # they say why, once each
    found = {
        str(path.relative_to(ROOT)): len(groups.findall(path.read_text(encoding="utf-8")))
        for kind in ("*.py", "*.lark")
        for path in (ROOT / "ipmlang").rglob(kind)
    }
    assert dict.fromkeys(named, 1) == {name: count for name, count in found.items() if count}
    tables = ROOT / "ipmlang" / "compiler" / "grammar.tables"
    assert not groups.search(json.loads(tables.read_text(encoding="utf-8"))["pattern"])
