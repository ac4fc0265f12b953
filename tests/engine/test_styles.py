"""Styles of a file, and what a file puts in the place of rules and values that it imports."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest

import ipmlang
from ipmlang.compiler.verify import verify
from tests.engine.random_grammars import Grammar

SHOP = (
    'ipm 1\nattr bay = 2 in 1..5 "width"\nattr deep = bay / 4\nconst high = 1\n'
    "fn twice(x) = 2 * x\nFront --> split x { { ~bay: Bay(deep) }* }\n"
    'Bay(d) --> report("deep", d) [Window] Sign\n'
    "Window --> size(twice(1), high, 0.1) Pane\n"
    "Frame --> Wood\nLamp : 50% --> Bulb\nLamp : else --> nil\n"
    "style Old\nOld.Window --> Shutter\nconst Old.high = 3\nstart Front on box(8, 2, 0)\n"
)
STREET = 'ipm 1\nimport "shop"\nRow --> shop.Front [translate(0, 0, 1) shop.Front]\nstart Row\n'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "shop.ipm").write_text(SHOP, encoding="utf-8")
    (tmp_path / "street.ipm").write_text(STREET, encoding="utf-8")
    return tmp_path


def grammar(text: str, folder: Path, style: str | None = None) -> ipmlang.Grammar:
    made = ipmlang.parse("ipm 1\n" + text, folder=folder, style=style)
    assert verify(made.program) == []
    return made


def labels(text: str, folder: Path, style: str | None = None, seed: int = 0) -> dict[str, int]:
    """How often each terminal is drawn."""
    scene = grammar(text, folder, style).run(seed=seed)
    return dict(Counter(scene.labels[each] for each in scene.instances.label))


def names(made: ipmlang.Grammar) -> list[str]:
    return [each.name for each in made.program.attrs]


FRONT = "start shop.Front on box(8, 2, 0)\n"


def test_a_rule_of_a_library_is_replaced(folder: Path) -> None:
    text = 'import "shop"\nshop.Window --> Mine\nMine --> A B\n' + FRONT
    assert labels(text, folder) == {"A": 4, "B": 4, "Sign": 4}


def test_a_terminal_of_a_library_is_a_rule_that_it_asks_for(folder: Path) -> None:
    text = 'import "shop"\nshop.Sign --> Board\n' + FRONT
    assert labels(text, folder) == {"Pane": 4, "Board": 4}


def test_a_replacement_may_have_alternatives_and_use_the_library(folder: Path) -> None:
    text = 'import "shop"\nshop.Window : 50% --> shop.Frame\nshop.Window : else --> B\n' + FRONT
    found = labels(text, folder, seed=2)
    assert found["B"] + found["Wood"] == 4
    assert 0 < found["B"] < 4


def test_another_import_of_the_same_file_stays_as_it_is(folder: Path) -> None:
    text = (
        'import "shop"\nimport "shop" as plain\nimport "street"\n'
        "shop.Window --> plain.Window Frame\n"
        "start [shop.Front] [plain.Front] street.Row on box(8, 2, 0)\n"
    )
    assert labels(text, folder) == {"Pane": 16, "Frame": 12, "Sign": 16}


def test_what_a_file_replaces_holds_in_all_that_it_imports(folder: Path) -> None:
    text = 'import "street"\nimport "shop"\nshop.Window --> Mine\nattr shop.bay = 4\n'
    text += "start [shop.Front] street.Row on box(8, 2, 0)\n"
    assert labels(text, folder) == {"Mine": 6, "Sign": 6}
    assert names(grammar(text, folder)) == ["shop.bay", "shop.deep"]


def test_an_import_of_an_import_is_reached_by_its_path(folder: Path) -> None:
    text = (
        'import "street"\nimport "shop"\nstreet.shop.Window --> Mine\n'
        "start [street.Row] shop.Front on box(8, 2, 0)\n"
    )
    assert labels(text, folder) == {"Mine": 8, "Pane": 4, "Sign": 12}


def test_values_are_replaced_with_what_reads_them(folder: Path) -> None:
    text = 'import "shop"\nattr shop.bay = 4\nconst shop.high = 0.5\nfn shop.twice(x) = 7 * x\n'
    made = grammar(text + FRONT, folder)
    scene = made.run()
    assert scene.reports["deep"] == (2.0, 2)
    sizes = {tuple(size) for size in scene.instances.size.tolist()}
    assert (7.0, 0.5, 0.1) in sizes
    bay = made.program.attrs[names(made).index("shop.bay")]
    assert (bay.low, bay.high, bay.doc) == (1.0, 5.0, "width")


def test_units_share_the_attributes_that_are_the_same(folder: Path) -> None:
    text = 'import "shop"\nimport "shop" as two\nattr two.bay = 4\nstart shop.Front two.Front\n'
    made = grammar(text, folder)
    assert names(made) == ["shop.bay", "shop.deep", "two.bay", "two.deep"]
    text = 'import "shop"\nimport "shop" as two\ntwo.Sign --> B\nstart shop.Front two.Front\n'
    assert names(grammar(text, folder)) == ["shop.bay", "shop.deep"]


def test_an_asset_takes_the_place_of_a_rule(folder: Path) -> None:
    (folder / "pane.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg"><path id="pane" d="M0 0h9v3z"/></svg>'
    )
    text = 'import "shop"\nasset shop.Window = "pane.svg#pane"\n' + FRONT
    scene = grammar(text, folder).run()
    assert [asset.node for asset in scene.assets] == ["pane"]
    assert (scene.instances.asset == 0).sum() == 4


def test_a_library_is_imported_in_a_style(folder: Path) -> None:
    text = 'import "shop" style Old\nimport "shop" as new\nstart [shop.Front] new.Front\n'
    assert labels(text.replace("Front\n", "Front on box(8, 2, 0)\n"), folder) == {
        "Shutter": 4, "Pane": 4, "Sign": 8
    }  # fmt: skip


HOUSE = (
    "attr lit = 0.5 in 0..1\nattr far = 2 * lit\n"
    "House --> [Window] Door\nWindow --> Pane\nDoor --> Leaf Knob\n"
    "Pane --> report(\"far\", far) Glass\n"
    "style Dusk\nDusk.Pane --> report(\"far\", far) Dim\nattr Dusk.lit = 0.25\n"
    "style Night extends Dusk\nNight.Window --> Pane Curtain\nNight.Knob --> Lamp\n"
)  # fmt: skip


@pytest.mark.parametrize(
    ("style", "wanted", "far"),
    [
        (None, {"Glass": 1, "Leaf": 1, "Knob": 1}, 1.0),
        ("Dusk", {"Dim": 1, "Leaf": 1, "Knob": 1}, 0.5),
        ("Night", {"Dim": 1, "Curtain": 1, "Leaf": 1, "Lamp": 1}, 0.5),
    ],
)
def test_a_style_is_chosen(
    style: str | None, wanted: dict[str, int], far: float, tmp_path: Path
) -> None:
    text = HOUSE + "start House on box(1, 1, 0)\n"
    assert labels(text, tmp_path, style) == wanted
    made = grammar(text, tmp_path, style)
    assert made.run().reports["far"] == (far, 1)
    assert names(made) == ["lit", "far"] or style is not None
    assert set(names(made)) == {"lit", "far"}
    assert made.run(attrs={"lit": 1}).reports["far"] == (2.0, 1)


def test_a_rule_makes_something_in_a_style(tmp_path: Path) -> None:
    text = HOUSE + "Street --> House [Night.House] Dusk.Door\nstart Street on box(1, 1, 0)\n"
    assert labels(text, tmp_path) == {
        "Glass": 1, "Leaf": 3, "Knob": 2, "Dim": 1, "Curtain": 1, "Lamp": 1
    }  # fmt: skip
    made = grammar(text, tmp_path)
    assert set(names(made)) == {"lit", "far", "Dusk.lit", "Dusk.far"}  # which Night has too
    assert labels(text, tmp_path, "Night")["Lamp"] == 2


def test_a_style_of_what_is_imported_is_reached_by_its_path(folder: Path) -> None:
    text = 'import "shop"\nstart [shop.Old.Front] shop.Front on box(8, 2, 0)\n'
    assert labels(text, folder) == {"Shutter": 4, "Pane": 4, "Sign": 8}
    text = 'import "shop"\nshop.Old.Sign --> Board\nstart [shop.Old.Front] shop.Front\n'
    found = labels(text.replace("Front\n", "Front on box(8, 2, 0)\n"), folder)
    assert found == {"Shutter": 4, "Board": 4, "Pane": 4, "Sign": 4}


def test_a_style_replaces_rules_of_a_library(folder: Path) -> None:
    text = 'import "shop"\nstyle Night\nNight.shop.Sign --> Neon\n' + FRONT
    assert labels(text, folder) == {"Pane": 4, "Sign": 4}
    assert labels(text, folder, "Night") == {"Pane": 4, "Neon": 4}


def test_what_a_style_leaves_alone_draws_as_before(folder: Path) -> None:
    text = 'import "shop"\nstyle Dark\nDark.Sign --> B\nSign --> A\nstart shop.Lamp Sign\n'
    for seed in range(8):
        plain = grammar(text, folder).run(seed=seed).instances.key
        dark = grammar(text, folder, "Dark").run(seed=seed).instances.key
        assert plain.tolist() == dark.tolist()


def test_turtles_have_styles(tmp_path: Path) -> None:
    text = "A(n) : n > 0 --> F(n) [+ L] A(n - 1)\nA(n) : else --> L\nL --> F(1)\nF(n) --> F(n) F\n"
    text += "style Winter\nWinter.L --> f\nWinter.draw(n) --> f(n)\nstart A(2) steps 3\n"
    assert len(grammar(text, tmp_path).run().instances) == 8
    assert len(grammar(text, tmp_path, "Winter").run().instances) == 0


def test_a_style_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(ipmlang.IpmError, match="has no style `Nihgt`"):
        grammar(HOUSE + "start House\n", tmp_path, "Nihgt")


@pytest.mark.parametrize("seed", range(30))
def test_a_style_is_the_file_with_its_rules_exchanged(seed: int, tmp_path: Path) -> None:
    lines, others = (Grammar(each).text().splitlines() for each in (seed, seed + 1000))
    other = [line for line in others if line.startswith("A(n, x) : ")]
    other = [line for line in other if not re.search(r"\b[BC]\(", line)]
    kept = [line for line in lines if not line.startswith("A(n, x) : ")]
    other = other or ["A(n, x) --> F(x)"]
    exchanged = "\n".join([*kept[1:-1], *other, kept[-1]]) + "\n"
    styled = "\n".join([*lines[1:-1], "style S", *(f"S.{line}" for line in other), lines[-1]])
    one, two = grammar(exchanged, tmp_path), grammar(styled + "\n", tmp_path, "S")
    try:
        found = one.run(seed=seed).instances
    except ipmlang.IpmError as error:  # the alternatives that are left may not cover everything
        with pytest.raises(ipmlang.IpmError, match=error.diagnostics[0].code):
            two.run(seed=seed)
        return
    wanted = two.run(seed=seed).instances
    assert found.key.tolist() == wanted.key.tolist()
    assert found.position.tolist() == wanted.position.tolist()
