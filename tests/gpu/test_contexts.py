"""What `fetch` gives on the card: the bits of numpy, and the CPU where a context is too large."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import ipmlang
from ipmlang.runtime.bind import bind
from ipmlang.runtime.gpu import words
from ipmlang.runtime.gpu.derive import derive_gpu
from ipmlang.runtime.gpu.device import Device
from ipmlang.runtime.gpu.encode import encode
from ipmlang.runtime.numpy_backend import derive_frontier
from ipmlang.runtime.scene import Scene

pytestmark = pytest.mark.usefixtures("card")
RANDOM = np.random.default_rng(9)
EXTREME = (0.0, -3.0, 17.0, 1e-300, -1e-300, 1e308, -1e308, 4.1, 10 / 7, 20 / 11, 1e15)
TABLE = "table T(x, y) =" + "".join(f"\n    ({x!r}, {y!r})" for x in EXTREME for y in EXTREME)
HEAD = f"""ipm 1
context grey = "grey.png" over (-3, 2, 20, 10)
context zone = "grey.png" over (-3, 2, 20, 10) nearest
context wind : vector = "wind.npy" over (-1, 0, side, 7.3)
context dot = "dot.png"
attr side = 9
{TABLE}
"""
PROGRAMS = {
    "places": "P --> repeat(i < 3000) { [A(rand(-9, 25), rand(-3, 20))] }\n",
    "extremes": "P --> repeat(r in T) { [A(r.x, r.y)] }\n",
}
RULES = """A(x, y) : fetch(zone, x, y) > 0.5 --> F(1 + fetch(grey, x, y)) B(x, y)
A(x, y) : else --> F(9 + fetch(wind, x, y, 0)) F(9 + fetch(wind, y, x, 1))
B(x, y) : 100 * fetch(grey, y, x)% --> F(1 + fetch(dot, x, y)) F(1 + fetch(grey, y, x))
B(x, y) : else --> nil
start P
"""
TOWN = """Town --> split y { { ~1: split x { { ~1: Lot }* } }* }
Lot : fetch(zone) > 0.5 --> extrude(1 + fetch(grey)) House
Lot : else --> extrude(9 + fetch(wind, scope.x, scope.y, 1)) Shed
start Town on box(16, 8, 0)
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    grey = RANDOM.integers(0, 256, (7, 11), dtype=np.uint8)
    Image.fromarray(grey).save(tmp_path / "grey.png")
    Image.fromarray(grey[:1, :1]).save(tmp_path / "dot.png")
    np.save(tmp_path / "wind.npy", RANDOM.normal(size=(13, 5, 2)))
    return tmp_path


def both(text: str, folder: Path) -> tuple[Scene, Scene]:
    """The scenes of the card and of numpy."""
    program, values = bind(ipmlang.parse(text, folder=folder).program, None, 4)
    there = derive_gpu(program, values, 4, program.limits)
    here = derive_frontier(program, values, 4, program.limits)
    assert there is not None and here is not None
    return there, here


@pytest.mark.parametrize("name", PROGRAMS)
def test_places_give_the_same_bits(name: str, folder: Path) -> None:
    there, here = both(HEAD + PROGRAMS[name] + RULES, folder)
    assert there.backend.startswith("gpu") and len(here.instances) > 100
    assert there.instances.key.tolist() == here.instances.key.tolist()
    assert there.instances.size.tobytes() == here.instances.size.tobytes()


def test_scopes_ask_where_they_stand(folder: Path) -> None:
    there, here = both(HEAD + TOWN, folder)
    assert len(set(there.instances.label.tolist())) == 2
    assert there.instances.key.tolist() == here.instances.key.tolist()
    assert there.instances.size.tobytes() == here.instances.size.tobytes()


def test_a_context_that_is_too_large_is_left_to_the_cpu(
    folder: Path, monkeypatch: pytest.MonkeyPatch, card: Device
) -> None:
    program = ipmlang.parse(HEAD + PROGRAMS["places"] + RULES, folder=folder).program
    extents = tuple(1 if each.name == "dot" else 77 for each in program.contexts)
    assert not encode(program, ("x", "y", "angle", "scale"), 1, extents).reasons
    monkeypatch.setattr(words, "MOST", 100)
    reasons = encode(program, ("x", "y", "angle", "scale"), 1, extents).reasons
    assert {each.what for each in reasons} == {"fetch"}
    there, here = both(HEAD + PROGRAMS["places"] + RULES, folder)
    assert there.instances.size.tobytes() == here.instances.size.tobytes()
