"""Twenty edits that a person would make by hand, over ten buildings: each changes three tokens or
fewer, at least eighteen give a building that still holds together.

An edit is a text with what comes instead; the counts of tokens are checked, too.
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest
from edit.holding import pieces, token_changes

from ipmlang import edit
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.edit.buildings.growing import grown
from ipmlang.edit.buildings.soundness import came_apart
from ipmlang.edit.buildings.tree import Tree
from ipmlang.edit.buildings.units import tolerance

ROOT = Path(__file__).parents[2]
OWN = Path(__file__).parent / "buildings"
MOST_TOKENS, LEAST_GOOD = 3, 18


@dataclass(frozen=True)
class Edit:
    """What a person wants, and the texts that give it: each with what comes instead."""

    wish: str
    file: str
    changes: tuple[tuple[str, str], ...]


EDITS = (
    Edit("one more floor", "house", (("floors  : int    = 2", "floors  : int    = 3"),)),
    Edit("a wider front", "house", (("width   : float  = 14", "width   : float  = 18"),)),
    Edit("other windows", "house", (("facades.ShutterBay(1.05, 1.5, 0.85, 2, 3)",
                                     "facades.ShutterBay(1.2, 1.6, 0.7, 2, 3)"),)),
    Edit("one more floor", "flats", (("floors : int = 4", "floors : int = 5"),)),
    Edit("other windows", "flats", (("windows.Window(2, 3)", "windows.Window(1, 2)"),)),
    Edit("narrower bays", "flats", (("{ ~2.8: Bay }*", "{ ~2.2: Bay }*"),)),
    Edit("a longer terrace", "terrace", (("houses : int   = 6", "houses : int   = 9"),)),
    Edit("deeper houses", "terrace", (("depth  : float = 11", "depth  : float = 14"),)),
    Edit("a higher tower", "tower", (("floors : int    = 28", "floors : int    = 40"),)),
    Edit("fewer setbacks", "tower", (("tiers  : int    = 4", "tiers  : int    = 3"),)),
    Edit("twice the width", "warehouse", (("bays    : int = 7", "bays    : int = 14"),)),
    Edit("one more floor", "warehouse", (("storeys : int = 4", "storeys : int = 5"),)),
    Edit("a higher wall", "castle", (("wall  : float  = 9", "wall  : float  = 12"),)),
    Edit("stouter towers", "castle", (("tower : float  = 4", "tower : float  = 5"),)),
    Edit("a higher spire", "town", (("spire  : float = 22", "spire  : float = 30"),)),
    Edit("a seven-fold crown", "round", (("repeat(i < 8)", "repeat(i < 7)"),
                                         ("45 * i", "51.428571 * i"))),
    Edit("larger panes", "court", (("size(1.4, 0.1, 1.6)", "size(1.5, 0.1, 1.7)"),)),
    Edit("one more floor", "floors", (("floors : int   = 4", "floors : int   = 5"),)),
    Edit("twice the width", "floors", (("box(15, 9, 0)", "box(30, 9, 0)"),)),
    Edit("lower windows", "wall", (("repeat(k < 2)", "repeat(k < 1)"),)),
)  # fmt: skip


def path_of(name: str) -> Path:
    own = OWN / f"{name}.ipm"
    return own if own.exists() else ROOT / "examples" / f"{name}.ipm"


def changed(text: str, wanted: Edit) -> str:
    for before, after in wanted.changes:
        assert text.count(before) == 1, f"{before!r} in {wanted.file}"
        text = text.replace(before, after)
    return text


_grown: dict[str, Tree] = {}


def before_of(name: str) -> Tree:
    if name not in _grown:
        _grown[name] = grown(edit.read(path_of(name)))
    return _grown[name]


def fault(wanted: Edit, folder: Path) -> str | None:
    """What is wrong with the building after an edit, nothing if it holds."""
    path = path_of(wanted.file)
    target = folder / path.parent.name
    if not target.exists():
        shutil.copytree(path.parent, target)
    made = target / f"edited_{path.name}"
    made.write_text(changed(path.read_text(encoding="utf-8"), wanted), encoding="utf-8")
    before = before_of(wanted.file)
    near = tolerance(before)
    try:
        after = grown(edit.read(made))
    except IpmError as error:
        return error.diagnostics[0].message
    if (after.terminals.high - after.terminals.low < 0).any():
        return "a part has a negative size"
    loose = came_apart(before, after, near)
    if loose:
        return f"came apart: {', '.join(sorted(loose))}"
    grew = len(after.owner) / len(before.owner)
    if pieces(after, near) > max(1.0, grew) * pieces(before, near):
        return "more of it hangs in the air"
    return None


@pytest.mark.parametrize("wanted", EDITS, ids=lambda each: f"{each.file}: {each.wish}")
def test_an_edit_takes_three_tokens_or_fewer(wanted: Edit) -> None:
    text = path_of(wanted.file).read_text(encoding="utf-8")
    assert 0 < token_changes(text, changed(text, wanted)) <= MOST_TOKENS


def test_eighteen_of_twenty_hold(tmp_path: Path) -> None:
    assert len(EDITS) == 20
    assert len({each.file for each in EDITS}) >= 10
    faults = {f"{each.file}: {each.wish}": fault(each, tmp_path) for each in EDITS}
    wrong = {name: found for name, found in faults.items() if found}
    assert len(EDITS) - len(wrong) >= LEAST_GOOD, wrong
