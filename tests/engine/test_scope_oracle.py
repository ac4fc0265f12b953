"""Random split grammars: the engine's terminals are those of the scope oracle, in its order."""

from __future__ import annotations

import numpy as np
import pytest

import ipmlang
from ipmlang.runtime.scene import SCOPE, Scene
from tests.engine.random_splits import Splits
from tests.engine.scope_oracle import Drawn, Oracle


def terminals(scene: Scene) -> list[Drawn]:
    """What a scene has, as the oracle tells it."""
    table = scene.instances
    assert np.all(table.asset == SCOPE)
    frames = np.zeros((len(table), 4, 4))
    w, x, y, z = table.rotation.T
    frames[:, 0, :3] = np.stack(
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], 1
    )
    frames[:, 1, :3] = np.stack(
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], 1
    )
    frames[:, 2, :3] = np.stack(
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], 1
    )
    frames[:, :3, 0] *= np.sign(table.scale)[:, None]
    frames[:, :3, 3], frames[:, 3, 3] = table.position, 1.0
    return [
        Drawn(scene.labels[label], int(key), frame, (size[0], size[1], size[2]))
        for label, key, frame, size in zip(
            table.label, table.key, frames, table.size.tolist(), strict=True
        )
    ]


def compare(text: str, seed: int) -> list[Drawn]:
    """Derive a grammar by both; its terminals."""
    grammar = ipmlang.parse(text)
    wanted = Oracle(grammar.checked.grammar, seed).run()
    found = terminals(grammar.run(seed=seed))
    assert [(each.symbol, each.key) for each in found] == [
        (each.symbol, each.key) for each in wanted
    ]
    for one, other in zip(found, wanted, strict=True):
        assert one.size == pytest.approx(other.size, abs=1e-9)
        assert np.abs(one.frame - other.frame).max() <= 1e-9 * max(1.0, np.abs(other.frame).max())
    return found


@pytest.mark.parametrize("seed", [*range(200), 658, 718, 751])
def test_a_random_grammar_is_that_of_the_oracle(seed: int) -> None:
    compare(Splits(seed).text(), seed)


@pytest.mark.parametrize(
    ("body", "wanted"),
    [
        ("split x { { ~1: T | 3: T }* }", [(0.0, 2.0)]),
        ("split x { { ~0.1: T | 0.8: T }* | '0.2: T }", [(0.0, 0.8), (0.8, 0.8), (1.6, 0.4)]),
        ("split x { 0.1: T | 0.3: T | 1.4: T | 0.2: T | { ~1: T }* }",
         [(0.0, 0.1), (0.1, 0.3), (0.4, 1.4), (1.8, 0.2)]),
        ("repeat(i < 3) { size(0.5, 1, 1) T translate(scope.sx, 0, 0) }",
         [(0.0, 0.5), (0.5, 0.5), (1.0, 0.5)]),
        ("split x { { ~1: repeat(i < 2) { size(0.5, 1, 1) center(x) T } }* }",
         [(0.25, 0.5), (0.25, 0.5), (1.25, 0.5), (1.25, 0.5)]),
        ("split x { 0.3: nil | { 0.8: P | 0.5: P }+ }", [(0.3, 0.8), (1.6, 0.4)]),
    ],
)  # fmt: skip
def test_what_was_once_wrong(body: str, wanted: list[tuple[float, float]]) -> None:
    text = f"ipm 1\nA --> {body}\nP : split.index == 1 --> T\n"
    text += "P : split.index == split.count - 1 --> T\nP : else --> nil\nstart A on box(2, 1, 1)\n"
    found = compare(text, 0)
    assert [(each.frame[0, 3], each.size[0]) for each in found] == [
        pytest.approx(each) for each in wanted
    ]


def test_what_a_repeat_cannot_know_is_said() -> None:
    text = "ipm 1\nA --> repeat(i < 3) { extrude(2) T translate(0, 0, scope.sz) }\n"
    with pytest.raises(ipmlang.IpmError, match="asks how large it is"):
        ipmlang.parse(text + "start A on box(2, 1, 0)\n").run()
