"""Published L-systems by what they must be like: counts and strings stand in `tests/corpus`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipmlang.compiler import ir
from ipmlang.runtime.scene import SEGMENT
from ipmlang.runtime.strings import derive_modules, derive_string
from tests import oracle_strings as oracle
from tests.engine.grammars import compiled

CORPUS = Path(__file__).parents[1] / "corpus"


def program(name: str) -> ir.Program:
    return compiled(CORPUS / f"abop_{name}.ipm")


def names(string: list[tuple[str, tuple[float, ...]]]) -> list[str]:
    return [name for name, _ in string]


def segments(code: ir.Program, attrs: list[float], seed: int = 0) -> np.ndarray:
    """Begin, end and width of every segment, (n, 7)."""
    found = derive_string(code, attrs, seed, code.limits).instances
    rows = found.asset == SEGMENT
    w, x, y, z = found.rotation[rows].T
    heading = np.stack((1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)), axis=1)
    length = found.size[rows, 0] * found.scale[rows]
    begin = found.position[rows]
    return np.column_stack((begin, begin + heading * length[:, None], found.width[rows]))


@pytest.mark.parametrize("name", ["1_6_koch_island", "1_7a_koch_island", "1_9a_koch", "1_9f_koch"])
def test_closed_curves_close_exactly(name: str) -> None:
    drawn = segments(program(name), [3])
    assert set(np.unique(drawn[:, :3] % 1)) == {0.0}
    ends = np.roll(drawn[:, :3], -1, axis=0)  # the last one is where the curve began
    np.testing.assert_allclose(drawn[:, 3:6], ends, atol=1e-12)


def test_hilbert_visits_every_lattice_point_once() -> None:
    drawn = segments(program("1_19_hilbert"), [3])
    points = np.round(np.concatenate((drawn[:1, :3], drawn[:, 3:6]))).astype(int)
    points -= points.min(axis=0)
    assert len(points) == 512
    assert len(np.unique(points, axis=0)) == 512
    assert points.max() == 7


def test_stochastic_plant_draws_a_third_each() -> None:
    code = program("p28_stochastic")
    counts = np.zeros(3)
    for seed in range(300):
        string = names(derive_modules(code, [1], seed, code.limits))
        assert string == names(derive_modules(code, [1], seed, code.limits))
        turns = (string.count("+"), string.count("-"))
        counts[[(1, 1), (1, 0), (0, 1)].index(turns)] += 1
    assert np.abs(counts / 300 - 1 / 3).max() < 4 * np.sqrt(2 / 9 / 300)
    deep = names(derive_modules(code, [6], 1, code.limits))
    assert deep.count("[") == deep.count("]") == deep.count("+") + deep.count("-")


HOGEWEG = {"000": "0", "001": "1[+F1F1]", "010": "1", "011": "1", "100": "0", "101": "1F1",
           "110": "0", "111": "0"}  # fmt: skip


def test_hogeweg_and_hesper_against_a_walk_of_the_string() -> None:
    rules = [
        oracle.Rule(c, [(each,) for each in body], left=[a], right=[b])
        for (a, c, b), body in HOGEWEG.items()
    ]
    rules += [oracle.Rule("+", [("-",)]), oracle.Rule("-", [("+",)])]
    axiom = [(each,) for each in "F1F1F1"]
    code = program("p35a_hogeweg")
    for steps in (1, 2, 7, 16, 26):
        system = oracle.System(axiom, rules, steps, {}, ignore=("+", "-", "F"))
        expected = [module.name for module in oracle.derive(system, 0)]
        got = names(derive_modules(code, [steps], 0, code.limits))
        assert [{"S0": "0", "S1": "1"}.get(each, each) for each in got] == expected
    assert expected.count("[") > 10


@pytest.mark.parametrize("letter", "abcd")
def test_monopodial_trees_level_their_branches(letter: str) -> None:
    code = program(f"2_6{letter}_monopodial")
    drawn = segments(code, [6])
    assert len(drawn) == 2**6 - 1
    assert drawn[0, :6] == pytest.approx([0, 0, 0, 0, 0, 1])
    lengths = np.linalg.norm(drawn[:, 3:6] - drawn[:, :3], axis=1)
    assert lengths.max() == lengths[0] == pytest.approx(1)
    assert np.unique(np.round(drawn[:, 6], 4)) == pytest.approx(
        np.sort(10 * 0.707 ** np.arange(6)), abs=2e-4
    )
    assert (drawn[:, 5] > 0).all()


@pytest.mark.parametrize("letter", "ab")
def test_tropism_bends_branches_down(letter: str) -> None:
    code = program(f"2_8{letter}_tropism")
    bent, straight = (segments(each, [4]) for each in (code, replace(code, tropism=None)))
    assert len(bent) == len(straight)
    lengths = [np.linalg.norm(each[:, 3:6] - each[:, :3], axis=1) for each in (bent, straight)]
    np.testing.assert_allclose(*lengths)
    np.testing.assert_allclose(bent[0], straight[0])  # the trunk stands upright either way
    rise = [
        ((each[:, 5] - each[:, 2]) / long).mean()
        for each, long in zip((bent, straight), lengths, strict=True)
    ]
    assert rise[0] < rise[1] - 0.1


def test_brackets_match_across_contexts_of_page_32() -> None:
    string = names(derive_modules(program("p32_brackets"), [1], 0, ir.Limits()))
    assert string.index("found") == 8
    assert "S" not in string
