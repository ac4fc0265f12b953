"""Groups: what `effect` wraps, in whose frame, and in what order groups are painted."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

from ipmlang.compiler import ir
from ipmlang.formats.drawing import Drawing
from ipmlang.runtime.export.sheet import drawing_of
from ipmlang.runtime.numpy_backend import derive_frontier
from ipmlang.runtime.scene import Scene
from ipmlang.runtime.strings import derive_string
from tests.engine.grammars import compiled

PARTS = """<svg xmlns="http://www.w3.org/2000/svg">
<g id="cut" clip-path="url(#c)"><defs><clipPath id="c"><rect width="3" height="2"/></clipPath>
</defs></g><g id="pale" opacity="0.5"/>
<g id="outer" opacity="0.7"><g id="inner" transform="scale(2)" opacity="0.4"/></g></svg>"""
CUT, PALE = 'effect("x.parts.svg#cut")', 'effect("x.parts.svg#pale")'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a parts file."""
    (tmp_path / "x.parts.svg").write_text(PARTS)
    return tmp_path


def scenes(grammar: str, folder: Path) -> list[Scene]:
    """The scene of a grammar from every executor that takes it."""
    program = compiled(f"canvas (0, 0, 10, 10)\n{dedent(grammar)}\n", folder)
    found = [derive_string(program, (), 0, ir.Limits())]
    batched = derive_frontier(program, (), 0, ir.Limits())
    return found if batched is None else [batched, *found]


def shown(drawing: Drawing) -> list[tuple[float, list[tuple[str, tuple[float, ...]]]]]:
    """The length of each element, and the kind and rounded matrix of each effect around it."""
    rows = []
    for element in drawing.elements:
        assert element.outline is not None
        ends = element.outline.coords[0]
        effects = [drawing.effects[name] for name in element.style.effects]
        around = [
            (effect.attributes[0][0], tuple(round(value, 9) + 0.0 for value in effect.matrix))
            for effect in effects
        ]
        rows.append((round(float(np.hypot(*(ends[1] - ends[0]))), 9), around))
    return rows


def test_an_effect_is_anchored_in_the_frame_where_it_stands(folder: Path) -> None:
    grammar = f"""
        C --> [{CUT} F(1)]
        start [at(2, 3, 90, 2) C] [at(5, 1) mirror C] C"""
    for scene in scenes(grammar, folder):
        assert shown(drawing_of(scene)) == [
            (2, [("clip-path", (0, -2, 2, 0, 2, 7))]),
            (1, [("clip-path", (-1, 0, 0, 1, 5, 9))]),
            (1, [("clip-path", (1, 0, 0, 1, 0, 10))]),
        ]


@pytest.mark.parametrize("count", [3, 200])
def test_every_application_is_a_group_of_its_own(folder: Path, count: int) -> None:
    """Batches, single shapes and strings alike; nothing but the frames tells the groups apart."""
    grammar = f"""
        C --> [{PALE} F(1) F(2)]
        start repeat(i < {count}) except (1) {{ [C] f(5) }} F(3)"""
    found = scenes(grammar, folder)
    assert len(found) == 2
    for scene in found:
        drawing = drawing_of(scene)
        names = [element.style.effects for element in drawing.elements]
        assert names[-1] == ()
        assert len(set(names[:-1])) == count - 1 == len(drawing.effects)
        assert names[:-1:2] == names[1:-1:2]


def test_groups_nest(folder: Path) -> None:
    grammar = f"""
        A(n) : n > 0 --> [{CUT} F(1) [f(2) {PALE} F(2) [A(n - 1)]] F(3)]
        A(n) : else --> nil
        start [f(1) A(2)]"""
    for scene in scenes(grammar, folder):
        drawing = drawing_of(scene)
        lengths = [length for length, _ in shown(drawing)]
        kinds = ["".join(kind[0] for kind, _ in around) for _, around in shown(drawing)]
        assert list(zip(lengths, kinds, strict=True)) == [
            (1, "c"), (2, "co"), (1, "coc"), (2, "coco"), (3, "coc"), (3, "c"),
        ]  # fmt: skip
        stacks = [element.style.effects for element in drawing.elements]
        assert stacks[0] == stacks[-1] == stacks[3][:1]
        assert stacks[1] == stacks[3][:2]


def test_without_a_bracket_it_holds_for_all_that_follows(folder: Path) -> None:
    """As every pen does: each copy's group stands in that of the copy before."""
    grammar = f"start [repeat(i < 3) {{ {CUT} F(1) f(1) }}] F(2)"
    for scene in scenes(grammar, folder):
        around = [[matrix[4] for _, matrix in stack] for _, stack in shown(drawing_of(scene))]
        assert around == [[0], [0, 2], [0, 2, 4], []]


def test_a_group_of_a_group_of_the_parts_file_brings_both(folder: Path) -> None:
    for scene in scenes('start [f(3) effect("x.parts.svg#inner") F(1)]', folder):
        (_, around), *_ = shown(drawing_of(scene))
        assert [kind for kind, _ in around] == ["opacity", "opacity"]
        assert [matrix[0] for _, matrix in around] == [1, 2]


def test_layers_never_split_a_group(folder: Path) -> None:
    """A group is painted where it began; layers inside order what is in it."""
    grammar = f"""
        start [layer(1) F(1)] [{PALE} F(2) [layer(5) F(3)] F(4) [layer(-9) F(5)]]
            [layer(-1) {PALE} [layer(3) F(6)] F(7)] F(8)"""
    for scene in scenes(grammar, folder):
        drawing = drawing_of(scene)
        assert [length for length, _ in shown(drawing)] == [7, 6, 5, 2, 4, 3, 8, 1]
        stacks = [element.style.effects for element in drawing.elements]
        assert stacks[0] == stacks[1] != stacks[2]
        assert len(set(stacks[2:6])) == 1


def test_groups_without_content_are_no_effects(folder: Path) -> None:
    for scene in scenes(f"start [{CUT} f(1)] [{PALE} [{CUT} F(1)]] F(2)", folder):
        drawing = drawing_of(scene)
        assert len(drawing.effects) == 2
        assert [len(element.style.effects) for element in drawing.elements] == [2, 0]


def test_the_axes_of_the_book_turn_groups_too(folder: Path) -> None:
    for scene in scenes(f"turtle frame abop\nstart f(2) +(90) f(1) [{CUT} F(1)]", folder):
        ((_, ((_, matrix),)),) = shown(drawing_of(scene))
        assert matrix == (0, 1, 1, 0, 2, 11)
