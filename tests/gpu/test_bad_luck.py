"""Bad luck on the way: a card that is full, lost or wrong, another thread, a forked process. Who
asks for the card gets one message, `auto` gets what the CPU makes and one note; nothing is left
behind, and the next derivation works.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import ipmlang
from ipmlang.compiler.diagnostics import Diagnostic, IpmError
from ipmlang.compiler.ir import Program
from ipmlang.runtime import derive
from ipmlang.runtime.gpu import attempt, machine, memory, prefix, seeds
from ipmlang.runtime.gpu.device import Device, device
from ipmlang.runtime.gpu.isa import Count
from ipmlang.runtime.gpu.storage import Storage
from ipmlang.runtime.scene import Scene
from tests.agreement import assert_agree

TEXTS = {
    "scopes": """ipm 1
Town --> split x { { ~2: Lot }* }
Lot --> extrude(rand(3, 9)) House
House --> comp { side: Wall | top: Roof }
Wall : 60% --> Fill
Wall : else --> nil
Roof --> roofHip(30)
start Town on box(12, 8, 0)
""",
    "copies": """ipm 1
A(n) --> repeat(i < n) { [+(i) f(rand(5)) B(i)] }
B(i) : 50% --> F(1 + i) repeat(j < 7) { [C(j)] }
B(i) : else --> F(2)
C(j) --> F(j + 1)
start A(90) A(1)
""",
    "threaded": """ipm 1
A(n) : n > 0 --> F(1) +(rand(20)) [A(n - 1)] B(n) A(n - 1)
A(n) : else --> F(0.5)
B(n) --> -(n) F(0.1)
start A(5) F(3)
""",
}
PROGRAMS: dict[str, Program] = {name: ipmlang.parse(text).program for name, text in TEXTS.items()}


@pytest.fixture(autouse=True)
def a_real_card(card: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    """`auto` computes on it, however small its tables, and has said nothing yet."""
    monkeypatch.setattr(card, "info", replace(card.info, software=False))
    monkeypatch.setattr(machine, "BUDGET", machine.BUDGET_SOFTWARE)
    monkeypatch.setattr(memory, "FEWEST", 16)
    monkeypatch.setattr(seeds, "SLOTS", 2)
    monkeypatch.setattr(attempt._Told, "notes", frozenset())


class Allocations:
    """Counts buffers, those that live by name, and refuses some."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.count = 0
        self.live: set[int] = set()
        self.refused: Callable[[int], bool] = lambda number: False
        buffer, release = Device.buffer, Storage.release

        def allocating(own: Device, content: bytes | int) -> Storage:
            self.count += 1
            if self.refused(self.count):
                raise own._full(content if isinstance(content, int) else len(content))
            made = buffer(own, content)
            self.live.add(id(made))
            return made

        def releasing(own: Storage) -> None:
            self.live.discard(id(own))
            release(own)

        monkeypatch.setattr(Device, "buffer", allocating)
        monkeypatch.setattr(Storage, "release", releasing)


@pytest.fixture
def allocations(card: Device, monkeypatch: pytest.MonkeyPatch) -> Iterator[Allocations]:
    yield Allocations(monkeypatch)


def run(name: str, backend: str = "gpu") -> Scene:
    return derive(PROGRAMS[name], seed=5, backend=backend)


def the_error(name: str = "copies") -> Diagnostic:
    with pytest.raises(IpmError) as caught:
        run(name)
    (found,) = caught.value.diagnostics
    return found


def assert_auto_falls_back(name: str, said: str) -> None:
    scene = run(name, "auto")
    assert scene.backend == "cpu"
    assert [said in note for note in scene.notes if "CPU" in note] == [True]
    assert_agree(run(name, "cpu"), scene)


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_card_that_is_full_once(name: str, allocations: Allocations) -> None:
    wanted = run(name, "cpu")
    assert run(name).backend.startswith("gpu")
    survived = 0
    for number in range(1, allocations.count + 1):
        allocations.count, allocations.refused = 0, number.__eq__
        try:
            found = run(name)
        except IpmError as error:
            assert error.diagnostics[0].code == "gpu-memory"
        else:
            survived += found.backend.startswith("gpu")
            assert_agree(wanted, found)
        assert not allocations.live
    assert survived > 1  # with smaller tables, or those that nobody needed any more


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_card_that_is_full_from_then_on(name: str, allocations: Allocations) -> None:
    assert run(name).backend.startswith("gpu")
    failed = 0
    for number in range(1, allocations.count + 1):
        allocations.count, allocations.refused = 0, number.__le__
        attempt._Told.notes = frozenset()
        scene = run(name, "auto")
        if scene.backend == "cpu" and scene.notes:
            failed += 1
            assert "the graphics card" in scene.notes[0]
        assert not allocations.live
    assert failed > allocations.count / 4 or failed > 3
    allocations.count, allocations.refused = 0, lambda asked: True
    assert the_error(name).code == "gpu-memory"
    allocations.refused = lambda asked: False
    assert run(name).backend.startswith("gpu")


@pytest.mark.parametrize("name", PROGRAMS)
def test_threads_that_do_not_come_to_their_end(
    name: str, allocations: Allocations, monkeypatch: pytest.MonkeyPatch
) -> None:
    array = Storage.array

    def reading(
        own: Storage, kind: type[np.uint32], count: int | None = None, offset: int = 0
    ) -> NDArray[np.uint32]:
        found = array(own, kind, count, offset)
        if count is None:  # all that there are: the counts
            found[Count.ENDED] -= 1
        return found

    monkeypatch.setattr(Storage, "array", reading)
    assert the_error(name).code == "gpu-failed"
    assert "ended 1 of" in the_error(name).message
    assert_auto_falls_back(name, "before their time")
    assert not allocations.live


def test_loops_that_the_driver_breaks_off(
    card: Device, allocations: Allocations, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Mesa ends an invocation after 65,535 turns of all its loops, and says nothing."""
    if "llvmpipe" not in card.info.renderer:
        pytest.skip("this driver lets loops go on")
    text = "A(n) : n > 0 --> F(1) +(3) A(n - 1)\nA(n) : else --> F\nstart A(9000) F"
    program = ipmlang.parse(f"ipm 1\n{text}\n").program
    assert derive(program, backend="gpu").backend == "gpu"
    monkeypatch.setattr(machine, "BUDGET", 10**8)
    with pytest.raises(IpmError) as caught:
        derive(program, backend="gpu")
    assert "before their time" in caught.value.diagnostics[0].message
    assert not allocations.live


def test_a_shader_that_the_driver_refuses(
    allocations: Allocations, monkeypatch: pytest.MonkeyPatch
) -> None:
    for place in ((machine, "source"), (prefix, "_source")):
        with monkeypatch.context() as own:
            own.setattr(*place, lambda **kind: "#version 430\nvoid main() { nonsense; }")
            found = the_error("copies")
            assert found.code == "gpu-failed"
            assert "the driver refuses the shader" in found.message
            assert_auto_falls_back("copies", "refuses the shader")
        attempt._Told.notes = frozenset()
        assert not allocations.live
    assert run("copies").backend == "gpu+cpu" or run("copies").backend == "gpu"


@pytest.mark.parametrize("error", ["GL_OUT_OF_MEMORY", "GL_INVALID_OPERATION"])
def test_errors_that_the_driver_reports_late(
    error: str, card: Device, allocations: Allocations, monkeypatch: pytest.MonkeyPatch
) -> None:
    checks = 0
    check = Device.check

    def third(own: Device, name: str) -> None:
        nonlocal checks
        checks += 1
        with monkeypatch.context() as now:
            if checks == 3:
                now.setattr(Device, "_errors", lambda own: [error])
            check(own, name)

    monkeypatch.setattr(Device, "check", third)
    assert the_error("copies").code in ("gpu-memory", "gpu-failed")
    assert not allocations.live
    assert run("copies").backend.startswith("gpu")


def test_another_thread(card: Device) -> None:
    assert run("copies").backend.startswith("gpu")
    found: list[Diagnostic | Scene] = []

    def ask() -> None:
        found.append(the_error("copies"))
        found.append(run("copies", "auto"))

    thread = threading.Thread(target=ask)
    thread.start()
    thread.join()
    told, scene = found
    assert isinstance(told, Diagnostic) and "another thread" in told.message
    assert isinstance(scene, Scene) and scene.backend == "cpu"
    assert ["another thread" in note for note in scene.notes] == [True]
    assert run("copies").backend.startswith("gpu")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no processes are forked here")
def test_a_forked_process(card: Device) -> None:
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            scene = run("copies", "auto")
            said = f"{scene.backend} {len(scene.instances)} {scene.notes} {the_error().message}"
        except BaseException as error:
            said = repr(error)
        os.write(write, said.encode())
        os._exit(0)
    os.waitpid(child, 0)
    os.close(write)
    with os.fdopen(read) as told:
        said = told.read()
    assert said.startswith(f"cpu {len(run('copies', 'cpu').instances)} ")
    assert said.count("forked") == 2
    assert run("copies").backend.startswith("gpu")


@pytest.mark.parametrize("at", [5, 12])
def test_a_context_that_is_lost(
    at: int, card: Device, allocations: Allocations, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as own:
        checks = 0

        def gone(self: Device) -> list[str]:
            nonlocal checks
            checks += 1
            return ["GL_UNKNOWN_ERROR"] * 16 if checks > at else []

        own.setattr(Device, "_errors", gone)
        assert_auto_falls_back("copies", "was lost")
    assert card.lost
    assert not allocations.live
    fresh = device()
    assert fresh is not card and not fresh.lost
    buffer = fresh.buffer(np.arange(3, dtype=np.uint32).tobytes())
    assert buffer.array(np.uint32).tolist() == [0, 1, 2]
    buffer.release()
