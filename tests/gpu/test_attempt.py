"""Which back end derives when somebody asks: what `auto` and `gpu` do with a card, without one, and
with a grammar that has no place there. Who computes on the card is played here.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace

import pytest

import ipmlang
from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.compiler.ir import Limits, Program
from ipmlang.rule_table import rule_lines, rule_rows
from ipmlang.runtime import derive
from ipmlang.runtime.choices import Decisions, encode
from ipmlang.runtime.gpu import attempt
from ipmlang.runtime.scene import Scene

HOUSE = """\
ipm 1
Lot --> House
House --> F(1) Roof
Roof --> F(2)
start Lot
"""

Played = Callable[[Program, tuple[float, ...], int, Limits], "Scene | None"]


@dataclass(frozen=True)
class Reason:
    rule: str
    operation: str
    line: int
    why: str
    path: str = "<text>"


class Card:
    """Somebody who derives on a card, or says that there is none."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.calls = 0
        self.error: IpmError | None = None
        self.software = False
        self.able = True
        self.reasons = [Reason("Roof", "roofHip", 4, "it makes geometry")]
        monkeypatch.setattr(attempt._Told, "notes", frozenset())
        for name, content in (
            ("derive", SimpleNamespace(derive_gpu=self.derive)),
            ("explain", SimpleNamespace(reasons=lambda program: self.reasons)),
            ("device", SimpleNamespace(device=self.device)),
        ):
            monkeypatch.setitem(sys.modules, f"ipmlang.runtime.gpu.{name}", content)  # type: ignore[arg-type]

    def device(self) -> SimpleNamespace:
        if self.error is not None and self.error.diagnostics[0].code == "no-opengl":
            raise self.error
        return SimpleNamespace(
            is_software=self.software, info=SimpleNamespace(renderer="llvmpipe (LLVM 15)")
        )

    def derive(
        self, program: Program, values: tuple[float, ...], seed: int, limits: Limits
    ) -> Scene | None:
        self.calls += 1
        if self.error is not None:
            raise self.error
        if not self.able:
            return None
        scene = derive(program, seed=seed, limits=limits)
        scene.backend = "gpu"
        return scene


@pytest.fixture
def card(monkeypatch: pytest.MonkeyPatch) -> Card:
    return Card(monkeypatch)


def run(backend: str, text: str = HOUSE, **more: int) -> Scene:
    return ipmlang.parse(text).run(backend=backend, **more)  # type: ignore[arg-type]


def test_numpy_is_what_runs_unless_asked(card: Card) -> None:
    assert ipmlang.parse(HOUSE).run().backend == "cpu"
    assert run("cpu").backend == "cpu"
    assert card.calls == 0


@pytest.mark.parametrize("backend", ["gpu", "auto"])
def test_a_card_is_used(card: Card, backend: str) -> None:
    scene = run(backend, seed=5)
    assert (scene.backend, scene.seed, scene.notes) == ("gpu", 5, ())


def test_a_back_end_that_is_none(card: Card) -> None:
    with pytest.raises(IpmError) as caught:
        run("cuda")
    assert caught.value.diagnostics[0].code == "no-such-backend"
    assert "`gpu`" in (caught.value.diagnostics[0].hint or "")


@pytest.mark.parametrize("code", ["no-opengl", "gpu-memory", "gpu-failed"])
def test_bad_luck_is_an_error_with_gpu_and_a_note_with_auto(card: Card, code: str) -> None:
    card.error = fail(code, "what went wrong")
    with pytest.raises(IpmError):
        run("gpu")
    first, second = run("auto"), run("auto")
    assert first.backend == second.backend == "cpu"
    assert first.notes == ("derived on the CPU: what went wrong",)
    assert second.notes == ()  # once a process


@pytest.mark.parametrize("backend", ["gpu", "auto"])
def test_errors_of_the_grammar_stay_errors(card: Card, backend: str) -> None:
    card.error = fail("not-finite", "a number is not finite")
    with pytest.raises(IpmError) as caught:
        run(backend)
    assert caught.value.diagnostics[0].code == "not-finite"


def test_auto_computes_on_no_card_that_is_a_program(card: Card) -> None:
    card.software = True
    scene = run("auto")
    assert (scene.backend, card.calls) == ("cpu", 0)
    assert "llvmpipe (LLVM 15) is no graphics card" in scene.notes[0]
    assert run("gpu").backend == "gpu"  # who asks for it gets it


@pytest.mark.parametrize("backend", ["gpu", "auto"])
def test_a_grammar_that_cannot_run_there_says_why(card: Card, backend: str) -> None:
    card.able = False
    scene = run(backend)
    assert scene.backend == "cpu"
    assert "Roof, line 4: it makes geometry" in scene.notes[0]


def test_choices_are_drawn_again_by_numpy(card: Card) -> None:
    drawn = encode([Decisions("A", 1, (0, 1))])
    text = f'ipm 1\nA : 50% --> F(1)\nA : else --> F(2)\nstart A A choices "{drawn}"\n'
    scene = run("gpu", text)
    assert (scene.backend, card.calls) == ("cpu", 0)
    assert "choices" in scene.notes[0]
    assert run("gpu", text, seed=1).backend == "gpu"


def test_the_table_of_rules(card: Card) -> None:
    rows = rule_rows(ipmlang.parse(HOUSE).program)
    assert [(row["rule"], row["line"], row["runs_on"]) for row in rows] == [
        ("start", 5, "cpu"), ("Lot", 2, "gpu"), ("House", 3, "gpu"), ("Roof", 4, "cpu"),
    ]  # fmt: skip
    assert rule_lines(rows)[-1] == "Roof      4  cpu      roofHip: it makes geometry"


def test_what_keeps_the_whole_program_keeps_every_rule(card: Card) -> None:
    card.reasons = [Reason("", "thread", 0, "modules follow the turtle", "")]
    rows = rule_rows(ipmlang.parse(HOUSE).program)
    assert {row["runs_on"] for row in rows} == {"cpu"}
    assert rows[-1]["why"] == "modules follow the turtle"
