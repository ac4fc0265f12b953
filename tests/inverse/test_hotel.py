"""The README's building: read into a grammar, and grown by two numbers."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import ipmlang
from ipmlang.inverse import Inference, infer
from ipmlang.runtime.scene import Scene

HOTEL = Path(__file__).parents[2] / "examples" / "hotel.obj"
NEAR = 1e-3  # metres: numbers are printed as exactly as the first size asks for


@pytest.fixture(scope="module")
def found() -> Inference:
    return infer(HOTEL)


@pytest.fixture(scope="module")
def grown(found: Inference, tmp_path_factory: pytest.TempPathFactory) -> Scene:
    path = tmp_path_factory.mktemp("hotel") / "hotel.ipm"
    found.save(path)
    return ipmlang.load(path).run(attrs={"floors": 7, "bays": 9})


def _rows(scene: Scene, label: str) -> list[int]:
    number = scene.labels.index(label)
    return np.flatnonzero(scene.instances.label == number).tolist()


def _box(scene: Scene, label: str) -> tuple[np.ndarray, np.ndarray]:
    (row,) = _rows(scene, label)
    low = scene.instances.position[row]
    return low, low + scene.instances.size[row]


def test_floors_and_bays_are_attributes(found: Inference) -> None:
    assert "attr floors : int = 4" in found.text
    assert "attr bays   : int = 6" in found.text
    assert found.report.tokens < found.report.tokens_flat / 4


def test_windows_are_multiplied(grown: Scene) -> None:
    drawn = Counter(grown.labels[label] for label in grown.instances.label.tolist())
    assert drawn["Frame"] == drawn["Pane"] == drawn["Sill"] == 63
    assert drawn["Column"] == 9
    assert drawn["Bracket"] == 27


def test_what_stands_above_and_beside_goes_along(grown: Scene) -> None:
    body, cornice, roof = (_box(grown, f"{name}Fitted") for name in ("Body", "Cornice", "Roof"))
    assert body[1][2] == pytest.approx(cornice[0][2], abs=NEAR)
    assert cornice[1][2] == pytest.approx(roof[0][2], abs=NEAR)
    assert body[1][2] - body[0][2] == pytest.approx(12.5 + 3 * 3, abs=NEAR)
    for low, high in (body, _box(grown, "DeckFitted"), _box(grown, "ShopFitted")):
        assert high[0] - low[0] == pytest.approx(27, abs=NEAR)
    assert cornice[1][0] - cornice[0][0] == pytest.approx(27.8, abs=NEAR)
