"""A card of any size gives what the CPU gives: slices are halved, tables added, stacks grown, and
what is too small for one shape is told. Memory is counted: whatever happened, nothing is left.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import ipmlang
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.ir import Limits
from ipmlang.runtime import derive
from ipmlang.runtime.bind import bind
from ipmlang.runtime.gpu import machine, memory, seeds
from ipmlang.runtime.gpu.derive import derive_gpu
from ipmlang.runtime.gpu.device import Device
from ipmlang.runtime.gpu.prefix import BLOCK, prefix_sums
from ipmlang.runtime.gpu.storage import Storage
from ipmlang.runtime.scene import Scene
from tests.agreement import assert_agree

TOWN = """ipm 1
Town --> split x { { ~2: Row }* }
Row --> split y { { ~2: Lot }* }
Lot : 70% --> color("#aa3344") Fill
Lot : else --> extrude(rand(3, 9)) House
House --> comp { side: Wall | top: Roof }
Wall --> split x { 0.1: Fill | { ~0.6: Tile }* | 0.1: Fill }
Tile --> split y { { ~0.7: Pane }* }
Pane : 30% --> nil
Pane : else --> Fill
Roof --> roofHip(30)
start Town on box(40, 40, 0)
"""
COPIES = """ipm 1
A(n) --> repeat(i < n) { [+(i) f(rand(5)) B(i)] }
B(i) : 50% --> F(1 + i) repeat(j < 7) { [C(j)] }
B(i) : else --> F(2)
C(j) : rand(1) < 0.6 --> F(j + 1)
C(j) : else --> nil
start A(700) A(1) A(0) A(40)
"""
THREADED = """ipm 1
A(n) : n > 0 --> F(1) +(rand(20)) B(n) [A(n - 1)] -(7) A(n - 1)
A(n) : else --> F(0.5)
B(n) : n > 3 --> +(3) B(n - 1) F(0.1)
B(n) : else --> F(n) +(5)
start A(7) F(3)
"""
DEEP = """ipm 1
A(n) : n > 0 --> F(1) [+(3) A(n - 1)] +(1) B F(0.5)
A(n) : else --> F(9)
B --> +(2) F(0.1)
start A(90)
"""
MANY = """ipm 1
A(n) : n > 1500 --> F(n)
A(n) : else --> [F(1)] [+(n) F(rand(9))]
start repeat(i < 3000) { [A(i)] }
"""
CHAINS = """ipm 1
A(n) : n > 0 --> [+(rand(9)) A(n - 1)] [F(1 + n)]
A(n) : else --> F(9)
start repeat(i < 40) { [A(150 + i)] }
"""
PROGRAMS = {"many": MANY, "town": TOWN, "copies": COPIES, "threaded": THREADED, "deep": DEEP}


class Watched:
    """What a machine asked of the card: threads of each pass, and how much memory lives."""

    def __init__(self) -> None:
        self.passes: list[int] = []
        self.live: set[int] = set()
        self.allocated = 0
        self.largest = 0


@pytest.fixture
def watched(card: Device, monkeypatch: pytest.MonkeyPatch) -> Iterator[Watched]:
    seen = Watched()
    buffer, release, dispatch = Device.buffer, Storage.release, machine.Machine.dispatch

    def allocating(own: Device, content: bytes | int) -> Storage:
        made = buffer(own, content)
        seen.live.add(id(made.raw))
        seen.allocated += 1
        seen.largest = max(seen.largest, made.size)
        return made

    def releasing(own: Storage) -> None:
        seen.live.discard(id(own.raw))
        release(own)

    def dispatching(own: machine.Machine, uniforms: dict[str, int], *more: object) -> object:
        seen.passes.append(uniforms["threads"])
        return dispatch(own, uniforms, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(Device, "buffer", allocating)
    monkeypatch.setattr(Storage, "release", releasing)
    monkeypatch.setattr(machine.Machine, "dispatch", dispatching)
    yield seen
    assert not seen.live


def on_cpu(text: str, **more: int) -> Scene:
    return derive(ipmlang.parse(text).program, seed=3, limits=Limits(**more))


def on_card(text: str, **more: int) -> Scene:
    program, values = bind(ipmlang.parse(text).program, None, 3)
    found = derive_gpu(program, values, 3, Limits(**more))
    assert found is not None
    return found


def assert_same(text: str) -> None:
    wanted, found = on_cpu(text), on_card(text)
    assert wanted.instances.key.tolist() == found.instances.key.tolist()  # also their order
    assert_agree(wanted, found, text)
    assert sorted(wanted.notes) == sorted(found.notes)


@pytest.mark.parametrize("name", PROGRAMS)
@pytest.mark.parametrize("block", [1 << 17, 1 << 20, 1 << 27])
def test_blocks_of_any_size(
    name: str, block: int, card: Device, watched: Watched, monkeypatch: pytest.MonkeyPatch
) -> None:
    card.limits = replace(card.limits, block_bytes=block)
    monkeypatch.setattr(memory, "FEWEST", 8)
    assert_same(PROGRAMS[name])
    assert watched.largest <= block


@pytest.mark.parametrize("name", ["town", "copies"])
def test_slices_of_any_size(name: str, watched: Watched, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "SLICE", 100)
    assert_same(PROGRAMS[name])
    assert max(watched.passes) == 100
    assert len(watched.passes) > 20


def test_what_overflows_is_run_again_with_exact_room(
    watched: Watched, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(memory, "FEWEST", 1)
    monkeypatch.setattr(machine, "GROWTH", 0.01)
    assert_same(COPIES)
    again = [a for a, b in zip(watched.passes, watched.passes[1:], strict=False) if a == b]
    assert again and len(watched.passes) > 8


def test_stacks_grow(watched: Watched, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(seeds, "SLOTS", 1)
    assert_same(DEEP)
    assert len(watched.passes) > 6  # 1, 2, 4, ... 128 frames


def test_threads_whose_stacks_find_no_room_run_in_smaller_parts(
    card: Device, watched: Watched, monkeypatch: pytest.MonkeyPatch
) -> None:
    card.limits = replace(card.limits, block_bytes=1 << 17)
    monkeypatch.setattr(memory, "FEWEST", 8)
    again = 0
    back = seeds.Seeds._back

    def counted(own: seeds.Seeds, *args: object) -> None:
        nonlocal again
        again += 1
        back(own, *args)  # type: ignore[arg-type]

    monkeypatch.setattr(seeds.Seeds, "_back", counted)
    assert_same(CHAINS)
    assert again >= 2
    assert {40, 20} <= set(watched.passes)


def test_a_stack_that_finds_no_room_is_the_cpus(card: Device, watched: Watched) -> None:
    card.limits = replace(card.limits, block_bytes=1 << 13)
    text = DEEP.replace("A(90)", "A(400)")
    program, values = bind(ipmlang.parse(text).program, None, 3)
    assert derive_gpu(program, values, 3, Limits()) is None


def test_one_shape_that_is_too_large_is_told(card: Device, watched: Watched) -> None:
    card.limits = replace(card.limits, block_bytes=1 << 12)
    with pytest.raises(IpmError) as caught:
        on_card(f"ipm 1\nA --> {'[B(1)] ' * 90}\nB(n) --> F(n)\nstart A")
    assert caught.value.diagnostics[0].code == "gpu-memory"
    assert "4,096 bytes" in caught.value.diagnostics[0].message


def test_a_start_without_shapes(watched: Watched) -> None:
    assert_same("ipm 1\nA --> repeat(i < 0) { [F(1)] }\nstart A A")
    assert_same("ipm 1\nA --> repeat(i < 0) { F(1) +(3) }\nB --> A +(1) A\nstart B A")


# ------------------------------------------------------------------- prefix sums

COUNTS = (1, 2, 63, 64, 65, 255, 257, BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK, 1_000_003)


@pytest.mark.parametrize("count", COUNTS)
def test_prefix_sums(count: int, card: Device) -> None:
    words = np.random.default_rng(count).integers(0, 4000, count + 9, dtype=np.uint32)
    assert (_sums(card, words, 5, count) == _wanted(words[5 : 5 + count])).all()


def test_prefix_sums_of_many_levels_and_rows_of_groups(
    card: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    card.limits = replace(card.limits, groups=(7, 65535, 64))  # so blocks lie in rows of seven
    words = np.random.default_rng(1).integers(0, 1 << 32, 10 * BLOCK + 1, dtype=np.uint32)
    assert (_sums(card, words, 0, len(words)) == _wanted(words)).all()


def test_prefix_sums_of_nothing(card: Device) -> None:
    assert len(_sums(card, np.zeros(4, np.uint32), 2, 0)) == 0


def _wanted(words: NDArray[np.uint32]) -> NDArray[np.uint32]:
    return np.cumsum(np.append(np.uint32(0), words[:-1]), dtype=np.uint64).astype(np.uint32)


def _sums(card: Device, words: NDArray[np.uint32], first: int, count: int) -> NDArray[np.uint32]:
    live: list[Storage] = []

    def allocate(size: int) -> Storage:
        live.append(card.buffer(size))
        return live[-1]

    def free(storage: Storage) -> None:
        live.remove(storage)
        storage.release()

    source = card.buffer(words.tobytes())
    made = prefix_sums(card, source, first, count, allocate, free)
    found = made.array(np.uint32, count)
    free(made)
    assert not live
    source.release()
    return found
