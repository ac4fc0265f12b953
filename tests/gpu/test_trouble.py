"""What the card cannot tell: grammars that never end, numbers that are none, geometry it has no
body for. Numpy derives these, and says the same as if nobody had asked the card; in time, and
without memory that was never there.
"""

from __future__ import annotations

from dataclasses import dataclass

import pytest

import ipmlang
from ipmlang.compiler.diagnostics import Diagnostic
from ipmlang.compiler.ir import Limits
from ipmlang.runtime import derive
from ipmlang.runtime.gpu import machine
from ipmlang.runtime.gpu.derive import GpuFrontier
from ipmlang.runtime.gpu.device import Device
from ipmlang.runtime.gpu.isa import Trouble
from ipmlang.runtime.gpu.machine import TroubleError
from ipmlang.runtime.gpu.storage import Storage
from ipmlang.runtime.scene import Scene
from tests.agreement import Outcome, assert_agree, outcome

pytestmark = pytest.mark.usefixtures("card")


@dataclass(frozen=True)
class Endless:
    text: str
    code: str
    limits: Limits
    most: int = 2_000_000  # bytes of one table on the card


ENDLESS = {
    "a chain": Endless("A --> [F(1)] A\nstart A", "steps", Limits(steps=300)),
    "depth": Endless("A --> [F(1)] A\nstart A", "depth", Limits(depth=200)),
    "growth": Endless("A --> [A] [A]\nstart A", "shapes", Limits(shapes=5000)),
    "drawings": Endless(
        f"A --> {'[F(1)] ' * 9} [A] [A]\nstart A", "shapes", Limits(shapes=2000)
    ),
    "memory": Endless("A --> [F] [F] [A] [A]\nstart A", "memory", Limits(memory=400_000)),
    "a string": Endless("A --> F(1) A F(1)\nstart A", "steps", Limits(steps=300)),
    "a string's growth": Endless(
        "A --> F(1) A +(1) A F(1)\nstart A", "shapes", Limits(shapes=3000)
    ),
    "a stack": Endless("A --> F A +(1) B\nB --> +(3)\nstart A", "depth", Limits(depth=200)),
    "copies": Endless("A(n) --> repeat(i < n) { [F(i)] }\nstart A(1e9)", "shapes", Limits()),
    "copies of shapes": Endless(
        "A(n) --> repeat(i < n) { [B(i)] }\nB(i) --> F(1)\nstart A(1e9)", "shapes", Limits()
    ),
    "copies of copies": Endless(
        "A(n) --> repeat(i < n) { repeat(j < n) { [B(i)] } }\nB(i) --> F(1)\nstart A(2000)",
        "shapes", Limits(shapes=50_000),
    ),
    "copies in a string": Endless(
        "A(n) --> repeat(i < n) { F(1) B }\nB --> +(1)\nstart A(1e9) F", "shapes", Limits()
    ),
    "scopes": Endless(
        "A --> split x { ~1: A | ~1: A }\nstart A on box(3, 3, 3)", "shapes", Limits(shapes=3000)
    ),
    "scopes in a chain": Endless(
        "A --> Fill A\nstart A on box(3, 3, 3)", "steps", Limits(steps=200)
    ),
}  # fmt: skip
NO_NUMBERS = {
    "a percentage": "A(x) : 100 * sqrt(x)% --> F(1)\nA(x) : else --> F(2)\nstart A(-1)",
    "a weight": "A(x) : weight sqrt(x) --> F(1)\nA(x) : weight 1 --> F(2)\nstart A(-1)",
    "an argument": "A(x) --> B(sqrt(x))\nB(y) --> F(1)\nstart A(-1)",
    "an infinite argument": "A(x) --> B(1 / x)\nB(y) --> F(1)\nstart A(0)",
    "a drawing": "A(x) --> [F(sqrt(x))]\nstart A(-1)",
    "an infinite drawing": "A(x) --> [F(1 / x)]\nstart A(0)",
    "a place": "A(x) --> f(sqrt(x)) B\nB --> F(1)\nstart A(-1)",
    "a turn": "A(x) --> +(sqrt(x)) B\nB --> F(1)\nstart A(-1)",
    "a factor": "A(x) --> *(sqrt(x)) B\nB --> F(1)\nstart A(-1)",
    "an infinite factor": "A(x) --> *(1 / x) B\nB --> F(1)\nstart A(0)",
    "the less of two": "A(x) --> F(min(sqrt(x), 1))\nstart A(-1)",
    "the less of two, again": "A(x) --> F(min(1, sqrt(x)))\nstart A(-1)",
    "the more of two": "A(x) --> F(max(sqrt(x), 1))\nstart A(-1)",
    "the more of two, again": "A(x) --> F(max(1, sqrt(x)))\nstart A(-1)",
    "a number of copies": "A(x) --> repeat(i < sqrt(x)) { [F(1)] }\nstart A(-1)",
    "infinite copies": "A(x) --> repeat(i < 1 / x) { [F(1)] }\nstart A(0)",
    "a draw": "A(x) --> F(rand(sqrt(x), 2))\nstart A(-1)",
    "a string's argument": "A(x) --> B(sqrt(x)) F(1)\nB(y) --> +(3)\nstart A(-1)",
    "a string's place": "A(x) --> B(x) F(1)\nB(y) --> f(sqrt(y)) F(1)\nstart A(-1)",
    "an extent": "A(x) --> size(sqrt(x), 1, 1) Fill\nstart A(-1) on box(3, 3, 3)",
    "a part": "A(x) --> split x { sqrt(x): Fill | ~1: B }\nB --> Fill\nstart A(-1) on box(3, 3, 3)",
    "parts": "A(x) --> split x { { sqrt(x): B }* }\nB --> Fill\nstart A(-1) on box(3, 3, 3)",
    "parts to the end": (
        "A(x) --> split x { { sqrt(x): B }+ }\nB --> Fill\nstart A(-1) on box(3, 3, 3)"
    ),
    "shared parts": (
        "A(x) --> split x { { ~sqrt(x): B }* }\nB --> Fill\nstart A(-1) on box(3, 3, 3)"
    ),
    "a height": "A(x) --> extrude(sqrt(x)) B\nB --> Fill\nstart A(-1) on box(3, 3, 0)",
    "a scope's place": "A(x) --> f(sqrt(x)) B\nB --> Fill\nstart A(-1) on box(3, 3, 3)",
    "what nobody sees": "A(x) --> B(2) [f(sqrt(x))]\nB(y) --> F(y)\nstart A(-1)",
    "a scope's turn": "A(x) --> +(sqrt(x)) B\nB --> Fill\nstart A(-1) on box(3, 3, 3)",
}
AS_NUMPY = {
    "an infinite part": (
        "A(x) --> split x { 1 / x: B | ~1: B }\nB --> Fill\nstart A(0) on box(3, 3, 3)"
    ),
}
GEOMETRY = {
    "a guard asks": """Town --> split x { { ~3: Lot }* }
Lot --> roofHip(30) Cut
Cut : geometry.area > 30 --> split x { 1: Fill | ~1: Bit }
Cut : else --> Bit
Bit --> color("#ff0000") split y { 20: Fill | 5: Bot }
Bot --> Fill
start Town on box(12, 8, 0)""",
    "one after the other": """Town --> split x { { ~3: Lot }* }
Lot : 50% --> extrude(3) Cut
Lot : else --> roofHip(30) Cut
Cut --> split x { 1: Fill | ~1: Bit }
Bit --> split y { ~1: Fill | ~1: Bot | ~1: Fill }
Bot : 50% --> size(scope.sx, scope.sy, 1) Fill
Bot : else --> Fill
start Town on box(40, 8, 0)""",
}


def ran(text: str, backend: str, limits: Limits | None = None) -> Outcome:
    program = ipmlang.parse(f"ipm 1\n{text}\n").program
    return outcome(lambda: derive(program, seed=2, backend=backend, limits=limits))


@pytest.mark.parametrize("name", ENDLESS)
def test_what_never_ends(name: str, card: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    each = ENDLESS[name]
    largest: list[int] = []
    buffer = Device.buffer

    def allocating(own: Device, content: bytes | int) -> Storage:
        largest.append(content if isinstance(content, int) else len(content))
        return buffer(own, content)

    monkeypatch.setattr(Device, "buffer", allocating)
    wanted, found = (ran(each.text, backend, each.limits) for backend in ("cpu", "gpu"))
    assert isinstance(found, Diagnostic)
    assert found.code == f"limit-{each.code}"
    assert found == wanted
    assert 0 < max(largest) < each.most


@pytest.mark.parametrize("name", NO_NUMBERS)
def test_numbers_that_are_none(name: str) -> None:
    wanted, found = (ran(NO_NUMBERS[name], backend) for backend in ("cpu", "gpu"))
    assert isinstance(found, Diagnostic)
    assert "rule A" in found.message or "A" in (found.trail or "")
    assert found == wanted


@pytest.mark.parametrize("name", AS_NUMPY)
def test_what_numpy_takes_the_card_takes(name: str) -> None:
    wanted, found = (ran(AS_NUMPY[name], backend) for backend in ("cpu", "gpu"))
    assert isinstance(found, Scene) and found.backend == "gpu"
    assert_agree(wanted, found)
    assert isinstance(wanted, Scene) and wanted.notes == found.notes


@pytest.mark.parametrize("name", GEOMETRY)
def test_geometry_that_only_numpy_knows(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    learned: list[int] = []
    learn = GpuFrontier._learn

    def learning(own: GpuFrontier, found: TroubleError) -> None:
        learned.append(found.blamed)
        learn(own, found)

    monkeypatch.setattr(GpuFrontier, "_learn", learning)
    wanted, found = (ran(GEOMETRY[name], backend) for backend in ("cpu", "gpu"))
    assert isinstance(wanted, Scene) and isinstance(found, Scene)
    assert found.backend == "gpu+cpu"
    assert 1 <= len(learned) == len(set(learned))  # none twice
    assert wanted.instances.key.tolist() == found.instances.key.tolist()
    assert wanted.notes == found.notes
    assert_agree(wanted, found)


@pytest.mark.parametrize("threads", [False, True])
def test_trouble_that_numpy_does_not_share(threads: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """The card gives up, the CPU does not: its scene, and a note."""

    def give_up(own: machine.Machine, *args: object, **more: object) -> None:
        raise TroubleError(Trouble.COUNT)

    for kind in (machine.Machine, *machine.Machine.__subclasses__()):
        monkeypatch.setattr(kind, "run", give_up)
    text = "A --> F B F\nB --> +(3)\nstart A" if threads else "A --> [F] [+(3) F]\nstart A"
    wanted, found = (ran(text, backend) for backend in ("cpu", "gpu"))
    assert isinstance(found, Scene) and found.backend == "cpu"
    assert any("CPU" in note for note in found.notes)
    assert_agree(wanted, found)
