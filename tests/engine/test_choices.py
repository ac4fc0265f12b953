"""`start … choices "…"`: what was drawn is written down, short, and drawn again."""

from __future__ import annotations

from dataclasses import replace
from random import Random

import pytest

import ipmlang
from ipmlang.compiler import ir
from ipmlang.runtime import derive
from ipmlang.runtime.bind import bind
from ipmlang.runtime.choices import Decisions, Lazy, encode, read
from ipmlang.runtime.replay import Recording
from ipmlang.runtime.strings import derive_string
from tests.engine.grammars import compiled
from tests.engine.random_grammars import Grammar

GARDEN = """ipm 1
Row(n) --> repeat(i < n) { [f(3 * i) Leaf] }
Leaf : 33% --> F(1)
Leaf : 33% --> F(2)
Leaf : else --> F(3)
attr n = 6
start Row(n)"""


def recorded(program: ir.Program, seed: int) -> tuple[list[int], str]:
    """The keys of what a seed draws, and the text that draws it again."""
    program, attrs = bind(program, None, seed)
    recording = Recording(program)
    scene = derive_string(program, attrs, seed, program.limits, recording)
    return scene.instances.rule.tolist(), recording.text()


def lengths(text: str, **given: object) -> list[float]:
    found: list[float] = ipmlang.parse(text).run(**given).instances.size[:, 0].tolist()  # type: ignore[arg-type]
    return found


def garden(*taken: int) -> str:
    return f'{GARDEN} choices "{encode([Decisions("Leaf", 2, taken)])}"\n'


def test_choices_are_drawn_again_and_a_seed_draws_anew() -> None:
    text = garden(2, 0, 1, 1, 0, 2)
    assert lengths(text) == [3, 1, 2, 2, 1, 3]
    assert lengths(text, seed=5) == lengths(GARDEN + "\n", seed=5) != lengths(text)


@pytest.mark.parametrize("seed", range(40))
def test_what_any_grammar_drew_is_drawn_again(seed: int) -> None:
    """The draws of numbers come from the seed, which is 0 when choices are drawn again."""
    program = compiled(Grammar(seed).text())
    rules, text = recorded(program, 0)
    assert derive(program, seed=0).instances.rule.tolist() == rules
    again = derive(replace(program, choices=text))
    assert again.instances.rule.tolist() == rules
    assert again.instances.key.tolist() == derive(program, seed=0).instances.key.tolist()


@pytest.mark.parametrize(
    "text",
    [
        "A(n) : n > 0 : 40% --> F A(n - 1) + B F A(n - 2)\nA(n) : n > 0 : 40% --> [+ A(n - 1)] B\n"
        "A(n) : else --> F(3)\nB : 50% --> F(2)\nB : else --> + F(1)\nstart A(6) A(5) B F\n",
        "F : 30% --> F [+ F] F\nF : 30% --> F [- F]\nstart F F steps 5\n",  # the rest stays
        "A < B : 50% --> A B\nA : weight 2 --> B A\nA : weight 1 --> A B A\nB --> B\n"
        "interpret A : 50% --> F(1)\ninterpret A : else --> F(2)\nstart A A B A steps 5\n",
        "A : 20% --> F cut [F] A\nA : 30% --> [F A] F(2) A\nA : else --> F(3)\nstart A A A\n",
    ],
)
def test_threads_contexts_weights_and_what_stays(text: str) -> None:
    program = compiled("ipm 1\n" + text)
    seen = set()
    for seed in range(12):
        rules, choices = recorded(program, seed)
        again = derive(replace(program, choices=choices))
        assert again.instances.rule.tolist() == rules
        seen.add(tuple(rules))
    assert len(seen) > 3  # seeds draw different things, or this test would show nothing


def test_the_order_is_generation_by_generation_then_from_left_to_right() -> None:
    text = (
        "ipm 1\nA(n) : n > 0 : 50% --> [A(n - 1)] F(1) [A(n - 1)]\n"
        "A(n) : n > 0 : 50% --> F(2)\nA(n) : else --> F(3)\n"
    )
    choices = encode([Decisions("A", 2, (0, 1, 0, 0, 1, 0, 1))])
    found = lengths(f'{text}start [A(2)] [A(2)] [A(2)] choices "{choices}"\n')
    #     0: 0 0' of the next generation;  1: ends;  0: 1 0'
    assert found == [3, 1, 3, 1, 2, 2, 3, 1, 3, 1, 2]


def test_names_tell_arities_apart() -> None:
    text = "ipm 1\nA : 50% --> F(1)\nA : else --> F(2)\nA(n) : 50% --> F(n)\nA(n) : else --> F(9)\n"
    choices = encode([Decisions("A/0", 1, (0, 1)), Decisions("A/1", 1, (1,))])
    assert lengths(f'{text}start A A A(4) choices "{choices}"\n') == [1, 2, 9]


def test_symbols_that_are_not_named_draw_from_seed_0() -> None:
    text = GARDEN + ' choices ""\n'
    assert lengths(text) == lengths(text, seed=0)


def test_with_other_attributes_choices_hold_as_far_as_they_go() -> None:
    text = garden(2, 0, 1, 1, 0, 2)
    assert lengths(text, attrs={"n": 3}) == [3, 1, 2]
    longer = lengths(text, attrs={"n": 9})
    assert longer[:6] == [3, 1, 2, 2, 1, 3]
    assert longer[6:] == lengths(text, seed=0, attrs={"n": 9})[6:]


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        ("Leaf", r"start \(.*:7\): `choices` cannot be read at `Leaf`"),
        ("Leaf:x:0", "cannot be read at"),
        ("Leaf:6:0%", "the choices of `Leaf` have a letter `%`"),
        ("Leaves:6:00", "names `Leaves`, which draws no production"),
        ("Leaf:1: Leaf:2:", "decisions of `Leaf` twice"),
        (encode([Decisions("Leaf", 2, (0,) * 5)]), "end after 5 decisions"),
        (encode([Decisions("Leaf", 2, (0,) * 7)]), "are 7 decisions, and the derivation .* 6"),
        ("Leaf:999999999999999:", "are 999,999,999,999,999 decisions"),
        ("Leaf:6:zzzzzzz", "are damaged: 7 letters that do not spell 6 decisions"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_an_error_at_the_start(choices: str, message: str) -> None:
    with pytest.raises(ipmlang.IpmError, match=message):
        lengths(f'{GARDEN} choices "{choices}"\n')


def test_a_choice_whose_condition_is_false_is_an_error() -> None:
    text = "ipm 1\nA(n) : n > 5 : 50% --> F\nA(n) : 50% --> F F\nA(n) : else --> F(2)\n"
    choices = encode([Decisions("A", 2, (0,))])
    with pytest.raises(ipmlang.IpmError, match=r"take a production of A\(3\) whose condition is"):
        lengths(f'{text}start A(3) choices "{choices}"\n')


@pytest.mark.parametrize("seed", range(200))
def test_decisions_survive_their_text(seed: int) -> None:
    random = Random(seed)
    alternatives = random.randrange(1, 6)
    weights = [random.random() ** 4 + 1e-3 for _ in range(alternatives + 1)]
    taken = random.choices(range(alternatives + 1), weights, k=random.randrange(1, 300))
    (part,) = read(encode([Decisions("A", alternatives, taken)]))
    lazy = Lazy(part, alternatives)
    assert lazy.take(len(taken) + 1) == taken
    lazy.finish()


def test_6000_decisions_among_3_take_1600_letters_and_rare_ones_less() -> None:
    random = Random(1)
    sizes = [
        len(encode([Decisions("Leaf", 2, random.choices(range(3), weights, k=6000))]))
        for weights in ([1, 1, 1], [7, 2, 1], [95, 4, 1])
    ]
    assert sizes[0] < 1610 and sizes[1] < 1200 and sizes[2] < 350
