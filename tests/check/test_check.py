"""The checker as a whole: all four families, what it gives besides messages, and re-checking."""

from __future__ import annotations

import random
import sys
from pathlib import Path

import pytest

from ipmlang.compiler.check import Cache, check
from ipmlang.compiler.checked import Checked
from ipmlang.compiler.checking.nearby import is_slip
from ipmlang.compiler.diagnostics import Diagnostic, render
from ipmlang.compiler.load import Cache as LoadCache
from ipmlang.compiler.load import load_text, standard_library

PARTS = Path(__file__).resolve().parents[1] / "errors" / "parts"


def checked(text: str, cache: Cache | None = None) -> Checked:
    return check(load_text(text, PARTS), cache or Cache())


def codes(text: str) -> list[str]:
    return [each.code for each in checked(text).diagnostics]


FAMILIES = {
    "turtle": """\
        ipm 1
        P1(m) : m > 0 --> [picket] f(13) P1(m - 1)
        P1(m) : else  --> [picket]
        R(m)  : m > 0 --> [leaf] [-(17) f(64) *(0.8) -(3) R(m - 1)] [+(7) f(181) +(23) R(m - 1)]
        R(m)  : else  --> [leaf]
        asset picket = "fence.parts.svg#picket"
        start P1(24) R(3)
        """,
    "split": """\
        ipm 1
        attr floors : int = 6 in 1..60 "storeys above ground"
        const module = 2.4
        asset win = "fence.parts.svg#picket"
        asset balcony = "fence.parts.svg#rail"
        Lot     --> extrude(floors * 3.2 + 5) comp { side: Facade | top: Roof }
        Facade  --> split y { 4.4: Ground | { ~3.2: Floor }* | 0.6: Cornice }
        Floor   --> split x { ~1: Wall | { ~module: Bay }* | ~1: Wall }
        Bay : 30% --> split x { ~1: Wall | 1.2: Opening(balcony) | ~1: Wall }
        Bay : else --> split x { ~1: Wall | 1.2: Opening(win) | ~1: Wall }
        Opening(what) --> insert(what, fit: inside)
        Body    --> octant(4, 0, 3, 7) Tower
        Wing    --> subdivide(3, 2, 1) Window
        Window : split.index == 0 or split.index == split.count - 1 --> nil
        Window : else --> roofHip(30, overhang: 0.4) comp { slope or gable: Tiles | bottom: nil }
        start Lot on polygon [(0, 0), (12, 0), (12, 9), (0, 9)]
        """,
    "docking": """\
        ipm 1
        S1 : 60% --> [tower_2] [at(0, 0, 4.1, 1, 0, 0, 0) S1]
        S1 : 40% --> [tower_cap]
        attr nx : int = 6 in 1..
        attr ny : int = 3 in 1..
        Hall --> tile(nx, ny, by: (2.4, 0, 0), (0, 0, 3.1)) { 11: corner | 21: bottom | 22: bay }
        start castle_rest Hall S1 avoiding collisions, retries 10
        """,
    "marching": """\
        ipm 1
        attr branches = 4
        attr pace = 2
        Ivy(n) --> march(pace, 0, when: rand() > 0.5, search: 180) { top: Fork(n) | extruded: B }
        Fork(n)         --> [Side(0, irand(0, branches))] [Ivy(n + 1)]
        Side(n, k) : n < k --> march(pace, rand(-90, 90)) { top: Side(n + 1, k) | extruded: B }
        Side(n, k) : else --> nil
        B               --> tube(0.01, sides: 12, smooth: C1) at each segment { leaf }
        start Ivy(0) seeds 1000 direction uniform steps 200
        """,
}  # fmt: skip


def plain(text: str) -> str:
    return "\n".join(line.strip() for line in text.splitlines()) + "\n"


@pytest.mark.parametrize("family", FAMILIES)
def test_all_four_families_check(family: str) -> None:
    found = checked(plain(FAMILIES[family]))
    assert [render(each) for each in found.diagnostics] == []
    assert bool(found.not_ready) == (family not in ("turtle", "split"))


def test_what_cannot_run_yet_is_named_with_its_place() -> None:
    found = checked(plain(FAMILIES["marching"]))
    assert {"march", "tube"} <= {each.name for each in found.not_ready}
    assert all(
        found.source.text[each.start : each.end].startswith(each.name) for each in found.not_ready
    )


def test_symbols_and_values_are_told() -> None:
    found = checked(
        'ipm 1\nimport "roofs"\nattr n = 3\nA(x) --> F(x) Leaf roofs.Hip(n)\nstart A(n)\n'
    )
    kinds = {key: use.kind for key, use in found.symbols.items()}
    assert kinds == {("A", 1): "rule", ("Leaf", 0): "terminal", ("roofs.Hip", 1): "rule"}
    assert found.values["n"].type == "number"
    assert found.values["roofs.pitch"].type == "number"


def test_an_operation_may_be_a_head() -> None:
    assert codes("ipm 1\nF --> F + F\nstart F F(3) steps 3\n") == []


@pytest.mark.parametrize(
    "path", sorted(standard_library().glob("*.ipm")), ids=lambda path: path.stem
)
def test_the_standard_library_is_right_and_imports(path: Path) -> None:
    text = f'ipm 1\nimport "std/{path.stem}" as library\nstart F\n'
    assert codes(text) == []
    assert codes(path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("A --> F\nstart A(1)", "wrong-arguments"),
        ("fn f(x) = x + 1\nstart F(f(1, 2))", "wrong-arguments"),
        ("fn f(x) = x + 1\nstart F(f(true))", "wrong-type"),
        ("fn f(x) = f(x)\nstart F(f(1))", "endless-definition"),
        ("attr a = b\nattr b = a\nstart F(a)", "endless-definition"),
        ("start F(pi(1))", "unknown-function"),
        ("start F(min)", "unknown-name"),
        ('start F("a" + 1)', "wrong-type"),
        ("start [F(1)] steps 1.5", "wrong-type"),
        ("start F steps -1", "out-of-range"),
        ("A : weight 0.2 --> F\nA : 30% --> f\nstart A", "mixed-chances"),
        ("A : 120% --> F\nstart A", "over-100-percent"),
        ("attr a : int = 3 in { 1, 2.5 }\nstart F(a)", "wrong-type"),
        ('attr a = "x" in 1..3\nstart color(a) F', "wrong-type"),
        ("const c = (1, 2, 3, 4)\nstart F", "wrong-arguments"),
        ("A(x) --> F(x.y)\nstart A(1)", "unknown-name"),
        ("table T(x) = (1)\nA --> repeat(r in T) { F(r) }\nstart A", "wrong-type"),
        ("table T(x) = (1)\nstart F(T)", "wrong-type"),
        ("fn f(x) = x\nstart F(f)", "wrong-type"),
        ("nil --> F\nstart nil", "reserved-name"),
        ("start F on polygon [(0, 0), (1, 1)]", "wrong-arguments"),
        ("start F with { S1 }", "unknown-site"),
        ("start F avoiding rain", "wrong-word"),
        ("A(x) : x --> F\nA(x) : x > 1 --> f\nstart A(1)", "wrong-type"),
        ("attr F1 = 2\nstart set F1 = true F", "wrong-type"),
        ("start tube(1) at each corner { leaf }", "wrong-label"),
        ("turtle frame bloop\nstart F", "wrong-word"),
    ],
)
def test_it_is_refused(text: str, code: str) -> None:
    assert code in codes(f"ipm 1\n{text}\n")


@pytest.mark.parametrize(
    "text",
    [
        "A(x) : x > 0 --> F A(x - 1)\nA(x) : else --> nil\nstart A(3)",
        "A : 50% --> A A\nA : else --> nil\nstart A",
        "A --> F A\nstart A steps 9",
        "A --> split x { 1: B | ~1: A }\nstart A on box(9, 1, 1)",
        "A --> repeat(i < irand(0, 3)) { A }\nstart A",
        "A < B > C --> B\nB --> C\nstart A B C steps 3",
        "A : weight 2 --> F\nA : weight 1 --> f\nstart A",
        "attr c = \"teal\" in { \"teal\", \"#fff\" }\nstart color(c) F",
        'table T(c, x) = ("red", 1), ("tan", 2)\nA --> repeat(r in T) { color(r.c) F }\nstart A',
        "A(x) --> color(x) F\nstart A(pick(\"red\", \"blue\"))",
        "turtle angle 25.7 frame abop\nstart F",
        "fn half(x) = x / 2\nconst k = half(3)\nattr n : float = k in 0..9\nstart F(half(n))",
        "interpret A --> F\nstart A A",
        "const on = 3 > 2\nA : on --> F\nA : else --> f\nstart A",
    ],
)  # fmt: skip
def test_it_is_right(text: str) -> None:
    assert [render(each) for each in checked(f"ipm 1\n{text}\n").diagnostics] == []


@pytest.mark.parametrize(
    ("first", "second", "slip"),
    [
        ("Pickt", "Picket", True), ("Fence", "Fense", True), ("widht", "width", True),
        ("leaf_1", "leaf_2", False), ("Wall", "Walls", True), ("Left", "Right", False),
        ("Tower", "Tower", False),
    ],
)  # fmt: skip
def test_what_is_a_slip(first: str, second: str, slip: bool) -> None:
    assert is_slip(first, second) is slip


def test_leaf_numbers_are_no_slips() -> None:
    assert codes("ipm 1\nleaf_1 --> F\nstart leaf_1 leaf_2 leaf_3\n") == []


# ------------------------------------------------------------------------ re-checking

LINES = (
    "attr size = 3", "attr size : bool = true", "const long = size * 2", "fn twice(x) = x * 2",
    "fn twice(x, y) = x * y",
    "A(x) --> F(twice(x)) B", "A(x, y) --> F(x * y) B", "B --> F(long) C(1)",
    "B : 60% --> f",
    "C(x) : x > 0 --> A(x) C(x - 1)", "C(x) : else --> color(x) F", "start A(size)",
    "start C(3) steps 4", "turtle angle 3", "table T(x, y) = (1, 2), (3, 4)",
    "D --> repeat(r in T) { [at(r.x, r.y) A(r.x)] }", 'asset a = "fence.parts.svg#rail"',
    'import "roofs"', "E --> roofs.Hip(size) a", "B --> F(", "Aa(x) --> nil", "F --> F F",
)  # fmt: skip


def test_after_an_edit_the_same_is_said_as_from_scratch() -> None:
    """Random edits of a grammar, checked with one cache and without: the same diagnostics."""
    chance = random.Random(5)
    cache, load_cache = Cache(), LoadCache()
    lines = ["ipm 1"]
    for _ in range(250):
        if len(lines) > 2 and chance.random() < 0.45:
            lines.pop(chance.randrange(1, len(lines)))
        else:
            lines.insert(chance.randrange(1, len(lines) + 1), chance.choice(LINES))
        text = "\n".join(lines) + "\n"
        again = check(load_text(text, PARTS, cache=load_cache), cache)
        assert _said(again.diagnostics) == _said(checked(text).diagnostics), text


def _said(diagnostics: tuple[Diagnostic, ...]) -> list[str]:
    return [render(each) for each in diagnostics]


def test_an_edit_checks_one_item_again(monkeypatch: pytest.MonkeyPatch) -> None:
    module = sys.modules[check.__module__]
    text = "ipm 1\n" + "".join(f"Part{k}(m) --> F(m) Part{k // 2}(m)\n" for k in range(500))
    text += "start Part9(3)\n"
    cache, load_cache = Cache(), LoadCache()
    check(load_text(text, PARTS, cache=load_cache), cache)
    seen: list[object] = []
    real = module.check_item
    monkeypatch.setattr(module, "check_item", lambda *args: seen.append(args[1]) or real(*args))
    edited = text.replace("Part77(m) --> F(m)", "Part77(m) --> F(m) F(m)")
    check(load_text(edited, PARTS, cache=load_cache), cache)
    assert len(seen) == 1
    check(load_text(text, PARTS, cache=load_cache), cache)
    assert len(seen) == 1  # what the edit began with is known, too


def test_time_grows_linearly() -> None:
    """Calls made for a grammar four times as large stay below five times as many."""

    def calls(count: int) -> int:
        rules = "".join(f"P{k}(m) : m > 0 --> F(m) P{k // 2}(m - 1) leaf{k}\n"
                        f"P{k}(m) : else --> nil\n"
                        for k in range(count))  # fmt: skip
        loaded = load_text(f"ipm 1\n{rules}start P1(3)\n", PARTS)
        made = 0

        def count_call(*_: object) -> None:
            nonlocal made
            made += 1

        sys.setprofile(count_call)
        try:
            check(loaded, Cache())
        finally:
            sys.setprofile(None)
        return made

    assert calls(800) < 5 * calls(200)
