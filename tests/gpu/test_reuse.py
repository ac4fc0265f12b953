"""What was derived last stays on the card, and is derived again only if its inputs changed."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import ipmlang
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.runtime import derive_table
from ipmlang.runtime.gpu import device as devices
from ipmlang.runtime.gpu import reuse
from ipmlang.runtime.gpu.device import Device
from ipmlang.runtime.gpu.table import Table

WALL = """
ipm 1
attr width : float = 2 in 1..4
Wall --> split x { { ~width: Bay }* }
Bay : 50%  --> Pane
Bay : else --> Stone
start Wall on box(24, 0, 3)
"""
PARTS = """
ipm 1
asset part = "part.obj"
Row --> split x { { ~2: Place }* }
Place --> size(1, 1, 1) part
start Row on box(8, 2, 2)
"""
PART = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\nf 1 2 3\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@pytest.fixture
def dispatches(card: Device, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """The names of the shaders that ran."""
    names: list[str] = []
    dispatch = Device.dispatch
    monkeypatch.setattr(
        Device,
        "dispatch",
        lambda own, shader, groups, name: (names.append(name), dispatch(own, shader, groups, name)),
    )
    reuse.forget()
    yield names
    reuse.forget()


def table(grammar: ipmlang.Grammar, seed: int = 1, **attrs: float) -> Table:
    found = derive_table(grammar.program, seed=seed, attrs=attrs or None)
    assert found is not None
    return found


def places(found: Table) -> NDArray[np.float64]:
    word = found.word("x")
    assert word is not None
    return np.sort(np.concatenate([part.numbers(word) for part in found.parts]))


def test_what_did_not_change_is_not_derived_again(dispatches: list[str]) -> None:
    grammar = ipmlang.parse(WALL)
    first = table(grammar)
    wanted, ran = places(first), len(dispatches)
    first.release()
    again = table(grammar)
    assert ran and len(dispatches) == ran
    np.testing.assert_array_equal(places(again), wanted)
    again.release()
    again.release()  # a second time does nothing
    assert len(places(table(grammar))) == len(wanted)


@pytest.mark.parametrize(
    ("seed", "width", "text"),
    [(2, 2.0, WALL), (1, 3.0, WALL), (1, 2.0, WALL.replace("box(24", "box(36"))],
)
def test_what_changed_is(dispatches: list[str], seed: int, width: float, text: str) -> None:
    table(ipmlang.parse(WALL), width=2.0).release()
    ran = len(dispatches)
    other = ipmlang.parse(text)
    found = table(other, seed, width=width)
    assert len(dispatches) > ran
    alone = other.run(seed=seed, attrs={"width": width})
    np.testing.assert_array_equal(places(found), np.sort(alone.instances.position[:, 0]))


def test_who_holds_a_table_keeps_it(dispatches: list[str]) -> None:
    grammar = ipmlang.parse(WALL)
    held = table(grammar)
    wanted = places(held)
    table(grammar, seed=2).release()
    np.testing.assert_array_equal(places(held), wanted)
    held.release()
    assert all(part.storage.size == 0 for part in held.parts)


def test_a_file_that_was_written_again(dispatches: list[str], tmp_path: Path) -> None:
    file = tmp_path / "part.obj"
    file.write_text(PART)
    grammar = ipmlang.parse(PARTS, folder=tmp_path)
    table(grammar).release()
    ran = len(dispatches)
    os.utime(file, ns=(1, 1))
    table(grammar).release()
    assert len(dispatches) > ran


def test_where_the_card_is_full_it_goes_first(
    dispatches: list[str], card: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = table(ipmlang.parse(WALL))
    kept.release()
    allocated = Device._allocated

    def refusing(own: Device, content: bytes | int) -> object:
        if any(part.storage.size for part in kept.parts):
            raise own._full(16)
        return allocated(own, content)

    monkeypatch.setattr(Device, "_allocated", refusing)
    card.buffer(16).release()
    assert all(part.storage.size == 0 for part in kept.parts)


def test_nothing_is_kept_of_what_failed(dispatches: list[str]) -> None:
    grammar = ipmlang.parse(WALL)
    with pytest.raises(IpmError):
        derive_table(grammar.program, attrs={"width": 99.0})
    assert reuse._Kept.made is None


def test_a_card_that_is_opened_again(dispatches: list[str]) -> None:
    grammar = ipmlang.parse(WALL)
    wanted = places(table(grammar))
    devices.release()
    np.testing.assert_array_equal(places(table(grammar)), wanted)
