"""A house with its parts, a flower and a star, in a folder where edits may write."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import ipmlang
from ipmlang.formats.drawing import Drawing
from ipmlang.runtime.export.sheet import drawing_of

FILES = Path(__file__).parent / "files"
Where = Callable[[Path, str], NDArray[np.float64]]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the files that edits are tried on."""
    shutil.copytree(FILES, tmp_path / "in")
    return tmp_path / "in"


@pytest.fixture
def house(folder: Path) -> Path:
    """The grammar of a house, beside its parts."""
    return folder / "house.ipm"


@pytest.fixture(scope="session")
def where() -> Where:
    """Where the terminals of a label stand that a grammar draws: (n, 2)."""

    def found(path: Path, label: str) -> NDArray[np.float64]:
        scene = ipmlang.load(path).run()
        rows = scene.instances.label == scene.labels.index(label)
        return scene.instances.position[rows, :2]

    return found


@pytest.fixture(scope="session")
def drawn() -> Callable[[Path], Drawing]:
    """What a grammar draws."""
    return lambda path: drawing_of(ipmlang.load(path).run())
