"""Bodies that say the same are written once, whatever their numbers; others never share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ipmlang.compiler import compile_file, compile_text, ir
from ipmlang.runtime import compiled, content, derive
from ipmlang.runtime.bodies import Writer
from ipmlang.runtime.content import Kept
from ipmlang.runtime.scene import Scene

PARTS = "".join(f'<rect id="{name}" width="{n + 1}" height="1"/>' for n, name in enumerate("abc"))
HEAD = """ipm 1
asset a, b, c in "x.parts.svg"
attr wide = 2
"""
ROW = """table P(x, y) =
    1, 2.5
    4, 8
Row(n) --> repeat(r in P) { [f(r.x) Pair(r.y)] } repeat(i < n) { [f(wide * i) b] }
Pair(y) --> [color("#ff0000") +(y) a] F(y)
"""
BEFORE = """table Q(x) =
    7
Other --> [f(1) c] repeat(r in Q) { [f(r.x) +(9) c] } [c]
"""
EXAMPLES = Path(__file__).parents[2] / "examples"
COLUMNS = ("position", "rotation", "scale", "size", "layer")


def made(folder: Path, text: str) -> ir.Program:
    """The program of a text."""
    svg = f'<svg xmlns="http://www.w3.org/2000/svg">{PARTS}</svg>'
    (folder / "x.parts.svg").write_text(svg, encoding="utf-8")
    path = folder / "x.ipm"
    path.write_text(HEAD + text + "\n", encoding="utf-8")
    return compile_file(path)[1]


def drawn(scene: Scene) -> list[object]:
    """All that a scene tells of what it draws, bit by bit; what it is by its name."""
    table = scene.instances
    names = [scene.labels[number] for number in table.label.tolist()]
    assets = [scene.assets[k].name if k >= 0 else "" for k in table.asset.tolist()]
    return [names, assets, *(np.asarray(getattr(table, name)).tobytes() for name in COLUMNS)]


def fresh(program: ir.Program, monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """What is drawn where no body was written before."""
    with monkeypatch.context() as patched:
        patched.setattr(compiled, "KEPT", Kept(0))
        return drawn(derive(program))


@pytest.fixture
def written(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """A row for each body that is written; nothing is kept from other tests."""
    found: list[bool] = []
    begin = Writer.__init__

    def noted(self: Writer, setting: object, single: bool, *more: object) -> None:
        found.append(single)
        begin(self, setting, single, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(Writer, "__init__", noted)
    monkeypatch.setattr(compiled, "KEPT", Kept())
    return found


def test_shifted_numbers_share_bodies(
    tmp_path: Path, written: list[bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    first = made(tmp_path, ROW + "start Row(3)")
    derive(first)
    program = made(tmp_path, BEFORE + ROW + "start [Other] Row(3)")
    names = [symbol.name for symbol in first.symbols]
    assert names.index("Pair") != [each.name for each in program.symbols].index("Pair")
    written.clear()
    found = drawn(derive(program))
    assert len(written) == 2, "the start and the new rule alone"
    written.clear()
    assert found == fresh(program, monkeypatch)
    assert len(written) > 2
    assert drawn(derive(first)) == fresh(first, monkeypatch)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("start [f(3) a]", "start [f(3) b b]"),
        ("start [f(3) a] [b]", "start [f(3) b] [a]"),
        ("start [f(3) a] [a]", "start [f(3) a] [b]"),
        ("start [f(wide) a]", "attr high = 3\nstart [f(high) a]"),
        ('start [color("#ff0000") a]', 'start [color("#00ff00") a]'),
        ("S --> a\nstart [f(1) S]", "S --> b\nstart [f(1) S]"),
        ("S --> a\nstart [f(1) S]", "start [f(1) a]"),
        ("table P(x, y) =\n    1, 2\nstart repeat(r in P) { [f(r.x) a] }",
         "table P(x, y) =\n    1, 2\nstart repeat(r in P) { [f(r.y) a] }"),
    ],
)  # fmt: skip
def test_what_differs_is_written_again(
    tmp_path: Path, written: list[bool], monkeypatch: pytest.MonkeyPatch, one: str, other: str
) -> None:
    for text in (one, other, one):
        program = made(tmp_path, text)
        assert drawn(derive(program)) == fresh(program, monkeypatch)
    assert written


def test_values_of_attributes_are_part_of_what_a_body_says(
    tmp_path: Path, written: list[bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    program = made(tmp_path, ROW + "start Row(3)")
    assert drawn(derive(program)) != drawn(derive(program, attrs={"wide": 5}))
    assert drawn(derive(program)) == fresh(program, monkeypatch)


def test_what_is_kept_is_bounded() -> None:
    kept = Kept(10)
    code = compile("1", "<test>", "exec")
    for number in range(9):
        kept.keep((number,), 3, code)
        assert kept.get((0,)) is not None, "what is used stays"
    assert [kept.get((number,)) is not None for number in (0, 6, 7, 8)] == [True, False, True, True]
    kept.keep((99,), 11, code)
    assert kept.get((99,)) is None


BOXES = """ipm 1
attr high = 2.5
Wall(n) --> [translate({x}, 0, 1) size(0.5, {y}, 2) cube Stone] repeat(i < n) {{
    [translate({z} * i, {turn}, 0) rotate(0, 0, {turn}) size(1.25, 0.75, high) cube Brick] [Post(i)]
}}
Post(i) --> translate(i, {x}, 0) mirror split x {{ ~{y}: a | 0.25: b }}
start Wall(3) on box(4, 1.5, 2)
"""
LENGTHS = (
    {"x": "0.3", "y": "1.7", "z": "0.1", "turn": "22.5"},
    {"x": "1e-7", "y": "2.77", "z": "7.5", "turn": "0.7"},
    {"x": "-7.25", "y": "0.11", "z": "1234.5", "turn": "-89.9"},
)


def test_bodies_that_differ_in_lengths_are_written_once(
    tmp_path: Path, written: list[bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    for number, each in enumerate(LENGTHS):
        program = compile_text(BOXES.format(**each), folder=tmp_path)[1]
        written.clear()
        found = drawn(derive(program))
        assert bool(written) == (number == 0)
        with monkeypatch.context() as patched:
            patched.setattr(content, "is_length", lambda const: False)
            assert found == fresh(program, monkeypatch), "the same bits as with literals"
        assert written
        written.clear()
        taller = drawn(derive(program, attrs={"high": 2.75}))
        assert taller != found and not written, "an attribute's length has a name, too"
    whole = compile_text(BOXES.format(**{**LENGTHS[0], "x": "2"}), folder=tmp_path)[1]
    written.clear()
    assert drawn(derive(whole)) == fresh(whole, monkeypatch) != found


@pytest.mark.parametrize("name", ("castle", "house", "palace", "terrace"))
def test_examples_are_the_same_with_names_for_lengths(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = compile_file(EXAMPLES / f"{name}.ipm")[1]
    assert program.scoped, "others have no names for lengths"
    found = fresh(program, monkeypatch)
    monkeypatch.setattr(content, "is_length", lambda const: False)
    assert found == fresh(program, monkeypatch)
