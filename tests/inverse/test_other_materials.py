"""What differs in its materials, or in a number, and is else the same: one rule that is told which.

Streets of houses are written as OBJ files in random order; what is inferred is proved by `infer`
itself, and here read as a person would.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ipmlang.compiler import ast
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.parse import Source, parse
from ipmlang.inverse import infer
from ipmlang.inverse.naming import Names
from ipmlang.inverse.split.printing.parameters import told

BOXES = (
    ("wall", (6, 8, 3), (0.5, 0.5, 0)),
    ("roof", (7, 9, 0.5), (0, 0, 3)),
    ("oak", (1, 0.1, 2), (3, 0.4, 0)),
    ("iron", (0.2, 0.3, 0.4), (4.4, 0.2, 1.7)),
    ("glass", (0.8, 0.1, 0.9), (1.2, 0.4, 1.1)),
    ("glass", (0.8, 0.1, 0.9), (5.0, 0.4, 1.1)),
    ("iron", (0.1, 8.0, 0.1), (7.0, 0.5, 2.9)),
)  # material, size and place; what wall and roof are made of differs
FACES = ((1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6))


def street(path: Path, roofs: str, walls: str) -> Path:
    """Houses in places without order, with roofs and walls of these materials, a letter for each
    house, in a file where nothing is in order.
    """
    draw = np.random.default_rng(3)
    boxes = []
    for k, (roof, wall) in enumerate(zip(roofs, walls, strict=True)):
        where = np.array([12 * k + 3 * draw.random(), 20 * draw.random(), 0]).round(2)
        own = {"wall": wall, "roof": roof}
        boxes += [(own.get(name, name), where + low, np.array(size)) for name, size, low in BOXES]
    materials = sorted({material for material, _, _ in boxes})
    lines = ["mtllib street.mtl"]
    for place, row in enumerate(draw.permutation(len(boxes)).tolist()):
        material, low, size = boxes[row]
        corners = [low + size * (k & 1, k >> 1 & 1, k >> 2) for k in range(8)]
        lines += [f"usemtl {material}"]
        lines += ["v " + " ".join(f"{each:.3f}" for each in corner) for corner in corners]
        lines += ["f " + " ".join(str(8 * place + each) for each in face) for face in FACES]
    (path / "street.mtl").write_text("".join(f"newmtl {each}\n" for each in materials))
    (path / "street.obj").write_text("\n".join(lines) + "\n")
    return path / "street.obj"


def test_houses_with_other_roofs_are_one_rule_that_is_told_its_roof(tmp_path: Path) -> None:
    found = infer(street(tmp_path, "abcabcab", "wwwwwwww"), up="z")
    assert re.findall(r"^(\w+)\((\w+)\) -->", found.text, re.MULTILINE) == [("WGroup", "roof")]
    assert "{ WGroup(at.shape) }" in found.text
    assert found.report.explained_repeated == 1.0


def test_houses_that_differ_in_two_things_are_told_both(tmp_path: Path) -> None:
    found = infer(street(tmp_path, "abaabbab", "wwvvwvwv"), up="z")
    heads = re.findall(r"^\w+\((.*)\) -->", found.text, re.MULTILINE)
    assert [sorted(each.split(", ")) for each in heads] == [["body", "roof"]]


def test_one_material_everywhere_needs_no_parameter(tmp_path: Path) -> None:
    found = infer(street(tmp_path, "aaaaaaaa", "wwwwwwww"), up="z")
    assert "at.shape" not in found.text
    assert found.report.rules == 1


def _told(text: str, assets: str) -> str:
    grammar = parse(Source("", text))[0]
    rules = [item for item in grammar.items if isinstance(item, ast.Rule)]
    tables = [item for item in grammar.items if isinstance(item, ast.Table)]
    made = told(rules, tables, dict.fromkeys(assets.split(), ""), Names())
    return format_grammar(ast.Grammar((*made.tables, *made.rules)))


def test_rules_that_differ_in_a_number_are_one_and_rows_tell_it() -> None:
    text = """\
table posts(shape, x) =
    Low, 1
    High, 4
    High, 9
    Well, 3
A --> repeat(at posts) { at.shape } [translate(0, 5, 0) Low]
Low --> base [translate(0, 0, 2) shaft] [translate(1, 0, 2) lamp] [translate(2, 0, 0) base]
High --> base [translate(0, 0, 7) shaft] [translate(1, 0, 7) lamp] [translate(2, 0, 0) base]
Well --> base shaft
"""
    made = _told(text, "base shaft lamp")
    assert "Low(dz) -->" in made
    assert "translate(0, 0, dz) shaft" in made
    assert "[translate(0, 5, 0) Low(2)]" in made
    assert "{ Low(at.dz) }" in made
    assert re.search(r"table \w+\(x, dz\) =\s+1, 2\s+4, 7\s+9, 7", made)


def test_rules_that_would_be_told_all_they_draw_stay() -> None:
    text = (
        "A --> B C\nB --> base [translate(0, 0, 2) shaft]\nC --> lamp [translate(1, 0, 3) base]\n"
    )
    assert "(at" not in _told(text, "base shaft lamp")
    assert "C --> lamp" in _told(text, "base shaft lamp").replace("  ", " ")
