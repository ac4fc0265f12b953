"""The threaded-string executor against a slow, obviously right one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipmlang.compiler import ir
from ipmlang.runtime.scene import OUTLINE, OUTLINES, SEGMENT, Scene
from ipmlang.runtime.strings import derive_modules, derive_string
from tests import oracle_strings as oracle
from tests.engine.grammars import compiled
from tests.engine.programs import program

ARITY = {
    "A": 1, "B": 2, "C": 0, "F": 1, "f": 1, "+": 1, "-": 1, "&": 1, "^": 1, "\\": 1, "/": 1,
    "at": 2, "*": 1, "mirror": 0, "$": 0, "!": 1, "layer": 1, "{": 0, "}": 0, "vertex": 0,
    "path{": 0, "}path": 0, "cut": 0, "asset": 0,
}  # fmt: skip
PLANAR = ["F", "f", "+", "-", "at", "*", "mirror", "!", "layer", "asset", "vertex"]
SOLID = [*PLANAR, "&", "^", "\\", "/", "$"]
NUMBER = st.sampled_from([0.0, 0.5, 1.0, 2.0, 90.0, 25.7, -3.0])


@st.composite
def expressions(
    draw: st.DrawFn, params: int, copies: tuple[int, ...], depth: int = 0
) -> oracle.Expr:
    kinds = ["number", "number"] + ["p"] * bool(params) + ["index"] * bool(copies)
    kind = draw(st.sampled_from([*kinds, "uniform"] + ["add", "mul", "sub"] * (depth < 2)))
    match kind:
        case "number":
            return draw(NUMBER)
        case "p":
            return ("p", draw(st.integers(0, params - 1)))
        case "index":
            return ("index", draw(st.sampled_from(copies)))
        case "uniform":
            return ("uniform", draw(st.integers(100, 102)))
    parts = [draw(expressions(params, copies, depth + 1)) for _ in range(2)]
    return (kind, *parts)


@st.composite
def bodies(
    draw: st.DrawFn, names: list[str], params: int, copies: tuple[int, ...] = (), depth: int = 0
) -> list[oracle.Element]:
    body: list[oracle.Element] = []
    for _ in range(draw(st.integers(0, 4))):
        inner = ["branch", "polygon", "path", "repeat"]
        kind = draw(st.sampled_from(["module"] * 6 + inner * (depth < 2)))
        if kind == "module":
            name = draw(st.sampled_from(names))
            args = [draw(expressions(params, copies)) for _ in range(ARITY[name])]
            if name == "*":
                args = [("add", 0.5, ("uniform", 100))]
            body.append((name, *args))
        elif kind == "repeat":
            number = len(copies)
            inner = draw(bodies(names, params, (*copies, number), depth + 1))
            count = draw(st.sampled_from([0.0, 1.0, 2.0, 3.0, ("mul", 3.0, ("uniform", 101))]))
            holes = draw(st.lists(st.sampled_from([0.0, 1.0]), max_size=1))
            body.append(("repeat", number, count, inner, holes))
        else:
            inner = draw(bodies(names, params, copies, depth + 1))
            begin, end = {"branch": "[]", "polygon": "{}", "path": ("path{", "}path")}[kind]
            body += [(begin,), *inner, (end,)]
    return body


@st.composite
def systems(draw: st.DrawFn, turtle: list[str], *, contexts: bool, cuts: bool) -> oracle.System:
    names = [*turtle, "A", "B", "C", *(["cut"] if cuts else [])]
    rules = []
    for head in draw(st.permutations(["A", "B", "C", "F"]))[: draw(st.integers(1, 4))]:
        for chance in draw(st.sampled_from([[None], ["percent"], ["percent"] * 2, ["weight"] * 3])):
            left = draw(st.lists(st.sampled_from(["A", "B", "C", "*"]), max_size=2))
            right = draw(CONTEXT)
            if not contexts or draw(st.booleans()):
                left, right = [], []
            params = sum(0 if name == "*" else ARITY[name] for name in [*left, head, *flat(right)])
            guard = draw(st.sampled_from([None, ("lt", ("uniform", 100), 0.6)]))
            if guard and params and draw(st.booleans()):
                guard = ("lt", ("p", draw(st.integers(0, params - 1))), 1.0)
            amount = {None: None, "percent": ("percent", 45.0), "weight": ("weight", 2.0)}[chance]
            body = draw(bodies(names, params))
            rules.append(oracle.Rule(head, body, guard, amount, left, right))
    if draw(st.booleans()):
        rules.append(oracle.Rule("C", draw(bodies(turtle, 0)), interpret=True))
    axiom = draw(bodies(names, 0))
    planar = not set(turtle) & {"&", "$"}
    ignore = ("+", "F") if contexts and draw(st.booleans()) else ()
    return oracle.System(axiom, rules, draw(st.integers(0, 3)), ARITY, ignore, planar)


CONTEXT = st.recursive(
    st.lists(st.sampled_from(["A", "B", "C", "*"]), max_size=2),
    lambda inner: st.lists(
        st.one_of(st.sampled_from(["A", "B", "C"]), inner.filter(bool)), max_size=3
    ),
    max_leaves=4,
)


def flat(names: list) -> list[str]:
    return [n for name in names for n in (flat(name) if isinstance(name, list) else [name])]


def compare(system: oracle.System, seed: int) -> None:
    string = oracle.derive(system, seed)
    if len(string) > 3000:
        return
    code = program(system)
    limits = ir.Limits()
    got = derive_modules(code, (), seed, limits)
    assert [name for name, _ in got] == [module.name for module in string]
    for (_, args), module in zip(got, string, strict=True):
        assert args == pytest.approx(module.args)
    rows, polygons = oracle.walk(system, oracle.interpret(system, string), not system.planar)
    agree(derive_string(code, (), seed, limits), rows, polygons)


def agree(scene: Scene, rows: list, polygons: list) -> None:
    found = scene.instances
    assert len(found) == len(rows)
    size = 1 + max((float(abs(row[1]).max() + abs(row[2]).max()) for row in rows), default=0.0)
    for i, (kind, position, axes, argument, pens, layer, key) in enumerate(rows):
        near = 1e-9 * size
        assert found.key[i] == key[0] << 32 | key[1]
        assert found.layer[i] == pytest.approx(layer)
        assert found.width[i] == pytest.approx(pens["width"], rel=1e-6, nan_ok=True)
        if kind == "}":
            assert found.asset[i] in OUTLINES
            continue
        assert (found.asset[i] == SEGMENT) == (kind == "F")
        assert found.position[i] == pytest.approx(position, abs=near)
        assert matrix(found, i) == pytest.approx(axes, abs=near)
        if kind == "F":
            assert found.size[i, 0] == argument
    rows_of = np.flatnonzero(np.isin(found.asset, OUTLINES))
    assert len(rows_of) == len(polygons) == len(scene.polygons)
    for row, points in zip(rows_of, polygons, strict=True):
        drawn = scene.polygons[found.shape[row]]
        parts = [points] if found.asset[row] == OUTLINE else points
        lifts = np.flatnonzero(np.isnan(drawn[:, 0]))
        split = np.split(drawn, lifts)
        split[1:] = [part[1:] for part in split[1:]]
        assert len(split) == len(parts)
        for one, other in zip(split, parts, strict=True):
            assert one == pytest.approx(np.array(other), abs=1e-9 * size)


def matrix(found: object, row: int) -> np.ndarray:
    w, x, y, z = found.rotation[row]  # type: ignore[attr-defined]
    scale = found.scale[row]  # type: ignore[attr-defined]
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return abs(scale) * turn @ np.diag([np.sign(scale), 1, 1])


MANY = settings(deadline=None, max_examples=80, report_multiple_bugs=False)
SEED = st.integers(0, 5)


@MANY
@given(systems(PLANAR, contexts=False, cuts=False), SEED)
def test_plane(system: oracle.System, seed: int) -> None:
    compare(system, seed)


@MANY
@given(systems(SOLID, contexts=False, cuts=False), SEED)
def test_space(system: oracle.System, seed: int) -> None:
    compare(system, seed)


@MANY
@given(systems(PLANAR, contexts=True, cuts=False), SEED)
def test_contexts(system: oracle.System, seed: int) -> None:
    compare(system, seed)


@MANY
@given(systems(["F", "+", "!"], contexts=True, cuts=True), SEED)
def test_cuts(system: oracle.System, seed: int) -> None:
    compare(system, seed)


@settings(deadline=None, max_examples=60)
@given(systems(SOLID, contexts=False, cuts=False), SEED)
def test_tropism(system: oracle.System, seed: int) -> None:
    system.planar, system.tropism = False, (-0.61, 0.77, -0.19, 0.4)
    compare(system, seed)


def test_brackets_that_touch_are_two_branches() -> None:
    scene = derive_string(compiled("start [f F] [F] F\n"), (), 0, ir.Limits())
    assert scene.instances.position[:, 0].tolist() == [1, 0, 0]


def test_copies_that_draw_nothing_bend_what_follows() -> None:
    text = "tropism (0, -1, 0) 0.3\nstart repeat(i < 3){} {{ F }}\n"
    every, some = (
        derive_string(compiled(text.format(holes)), (), 0, ir.Limits()).instances
        for holes in ("", " except (0, 1)")
    )
    assert len(some) == 1
    np.testing.assert_array_equal(some.position[0], every.position[2])
    np.testing.assert_array_equal(some.rotation[0], every.rotation[2])


def test_an_ignored_symbol_has_contexts_of_its_own() -> None:
    text = "ignore F\nF > A --> f\nB < F --> +\nstart B F F A [F A] F steps 1\n"
    string = derive_modules(compiled(text), (), 0, ir.Limits())
    assert [name for name, _ in string] == ["B", "f", "f", "A", "[", "f", "A", "]", "F"]
