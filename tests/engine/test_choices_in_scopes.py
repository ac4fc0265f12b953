"""`start … choices` in programs with scopes: what a seed drew is drawn again."""

from __future__ import annotations

from dataclasses import replace

import pytest

import ipmlang
from ipmlang.compiler.ir import Program
from ipmlang.runtime import derive, pending
from ipmlang.runtime.bind import bind
from ipmlang.runtime.choices import Decisions, encode
from ipmlang.runtime.numpy_backend import derive_frontier
from ipmlang.runtime.replay import Recording
from tests.engine.grammars import compiled
from tests.engine.random_splits import Splits

STREET = (
    "ipm 1\nStreet --> split x { { 2: House }* }\nHouse : 50% --> split y { 1: Door | ~1: Wall }\n"
    "House : 30% --> Wall\nHouse : else --> Garden\nWall : weight 2 --> A\nWall : weight 1 --> B\n"
    "Garden --> [Tree(3)] Lawn\nTree(n) : n > 0 : 60% --> F Tree(n - 1) [+ Tree(n - 1)] F\n"
    "Tree(n) : n > 0 --> F(2)\nTree(n) : else --> F(3)\nstart Street on box(24, 3, 0)"
)


def recorded(program: Program, seed: int) -> tuple[list[int], str]:
    """Which rules drew what with a seed, and the choices that say so."""
    recording = Recording(program)
    bound, attrs = bind(program, None, seed)
    scene = derive_frontier(bound, attrs, seed, bound.limits, None, recording)
    assert scene is not None
    return scene.instances.rule.tolist(), recording.text()


@pytest.mark.parametrize("seed", range(20))
def test_what_a_seed_drew_is_drawn_again(seed: int) -> None:
    program = compiled(STREET + "\n")
    rules, text = recorded(program, seed)
    assert derive(program, seed=seed).instances.rule.tolist() == rules
    again = derive(replace(program, choices=text))
    assert again.instances.rule.tolist() == rules
    assert again.instances.key.tolist() == derive(program, seed=seed).instances.key.tolist() or seed


@pytest.mark.parametrize("seed", range(60))
def test_random_splits_are_drawn_again(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    program = compiled(Splits(seed).text())
    rules, text = recorded(program, 0)
    assert derive(program, seed=0).instances.rule.tolist() == rules
    monkeypatch.setattr(pending, "CHUNK", 3)
    again = derive(replace(program, choices=text))
    assert again.instances.rule.tolist() == rules
    assert again.instances.key.tolist() == derive(program, seed=0).instances.key.tolist()


def test_decisions_stand_from_left_to_right_within_a_generation() -> None:
    text = (
        "ipm 1\nLot --> split x { 1: A | 1: Later | 1: A | 1: A }\nLater --> A\n"
        "A : 50% --> T\nA : 25% --> U\nA : else --> V\nstart Lot on box(4, 1, 0)"
    )
    decided = encode([Decisions("A", 2, (0, 1, 2, 1))])
    scene = ipmlang.parse(f'{text} choices "{decided}"\n').run()
    assert [scene.labels[each] for each in scene.instances.label] == ["T", "U", "U", "V"]


def test_another_number_of_decisions_is_an_error() -> None:
    decided = encode([Decisions("Wall", 2, (0, 1))])
    with pytest.raises(ipmlang.IpmError, match="choices"):
        ipmlang.parse(f'{STREET} choices "{decided}"\n').run()
