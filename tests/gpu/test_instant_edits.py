"""An edit compiles nothing on the graphics card: no attribute and no rule changes the shader."""

from __future__ import annotations

import pytest

import ipmlang
from ipmlang.runtime.gpu import encode as encoding
from ipmlang.runtime.gpu.device import Device, device
from ipmlang.runtime.scene import Scene

TOWN = """
ipm 1
attr floors : int = 4 in 1..20
start Town on box(60, 60, 0)
Town  --> split x { { ~12: split y { { ~12: Lot }* } }* }
Lot : 60%  --> extrude(floors * 3) comp { side: Face | top: Roof }
Lot : else --> Green
Face  --> split y { { ~3: split x { { ~2.5: Window }* } }* }
"""


@pytest.fixture
def compiled(card: Device, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the shaders that are compiled once the first derivation is over."""
    names: list[str] = []
    derived(TOWN)
    monkeypatch.setattr(
        type(device().context), "compute_shader", lambda *_: names.append("compiled")
    )
    return names


def derived(text: str, **attrs: int) -> Scene:
    """The scene of a grammar, which the card derives all of."""
    found = ipmlang.parse(text).run(seed=1, attrs=attrs or None, backend="gpu")
    assert found.backend == "gpu"
    return found


def test_an_attribute_compiles_nothing(compiled: list[str]) -> None:
    few, many = derived(TOWN, floors=2), derived(TOWN, floors=9)
    assert len(many.instances) > 3 * len(few.instances)
    assert not compiled


def test_a_rule_compiles_nothing(compiled: list[str]) -> None:
    found = derived(TOWN.replace("{ ~2.5: Window }*", "~1: Wall | 1.2: Window | ~1: Wall"))
    assert "Wall" in {found.labels[label] for label in found.instances.label.tolist()}
    assert not compiled


def test_an_attribute_writes_no_bytecode(
    compiled: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The words of a program are kept from run to run, and are those of that program alone."""
    written: list[int] = []
    encode = encoding.encode
    monkeypatch.setattr(encoding, "encode", lambda *given: (written.append(1), encode(*given))[1])
    town = ipmlang.parse(TOWN)
    few, many = (town.run(seed=1, attrs={"floors": each}, backend="gpu") for each in (2, 9))
    assert len(many.instances) > 3 * len(few.instances)
    assert len(written) == 1
    other = derived(TOWN.replace("60%", "20%"), floors=9)
    assert len(written) == 2 and len(other.instances) < len(many.instances)
