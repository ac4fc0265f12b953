"""Floors and bays as numbers: what is printed for a façade is derived with more of them."""

from __future__ import annotations

import numpy as np
import pytest
from inverse.test_split_facades import SMALL, front, listed

from ipmlang.compiler import ast
from ipmlang.compiler.format import format_grammar
from ipmlang.formats.mesh_types import Mesh, triangle_mesh
from ipmlang.inverse.split.facades.splitting import as_splits
from ipmlang.inverse.split.parts_file import parts_name, write_parts
from ipmlang.inverse.split.placing import Precision
from ipmlang.inverse.split.printing.grammar import print_scheme
from ipmlang.inverse.split.printing.lifting import counted, repeated
from ipmlang.inverse.split.proof import derived
from ipmlang.inverse.split.scheme import Scheme, Terminal

CORNERS = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)], float)
TRIANGLES = np.array([
    [0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
    [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5],
])  # fmt: skip


def printed(scheme: Scheme, changes: dict[str, str]) -> Mesh:
    """What a scheme draws when it is printed, changed as a person would, and derived."""
    found = print_scheme(scheme, "House", Precision(1e-7))
    meshes = {
        name: triangle_mesh(CORNERS * symbol.size, TRIANGLES, name)
        for name, symbol in zip(found.names, scheme.symbols, strict=True)
        if isinstance(symbol, Terminal)
    }
    file = write_parts(meshes, 7)
    asset = ast.Asset(tuple(meshes), parts_name("house", file.suffix), True)
    text = format_grammar(ast.Grammar((ast.Version(1), asset, *found.items)))
    for old, new in changes.items():
        assert text.count(old) == 1, text
        text = text.replace(old, new)
    return derived(text, file, "house")


def corners(mesh: Mesh) -> np.ndarray:
    return np.unique(np.round(mesh.vertices[mesh.corners], 4), axis=0)


@pytest.mark.parametrize(
    ("changes", "bays", "floors"),
    [
        ({}, 5, 3),
        ({"floors : int = 3": "floors : int = 4"}, 5, 4),
        ({"bays   : int = 5": "bays   : int = 11"}, 11, 3),
        ({"floors : int = 3": "floors : int = 1", "bays   : int = 5": "bays   : int = 2"}, 2, 1),
    ],
)
def test_one_number_makes_more_floors_and_bays(
    changes: dict[str, str], bays: int, floors: int
) -> None:
    """With walls and a cornice that fit, but for the door, which stays where it was."""
    scheme = as_splits(listed(front(5, 3).parts()), SMALL)
    expected = front(bays, floors).parts()
    kept = [k for k, each in enumerate(expected.classes) if each.name != "door"]
    points = np.concatenate([
        low + CORNERS * (high - low)
        for shape, low, high in zip(expected.shape, expected.low, expected.high, strict=True)
        if shape in kept
    ])  # fmt: skip
    drawn = corners(printed(scheme, changes))
    away = np.abs(points[:, None] - drawn[None]).max(axis=2).min(axis=1)
    assert away.max() < 2e-4


def test_counts_are_those_of_free_scopes() -> None:
    scheme = as_splits(listed(front(5, 3).parts()), SMALL)
    found = {each.axis: each for each in counted(repeated(scheme))}
    assert {axis: each.count for axis, each in found.items()} == {0: 5, 2: 3}
    for axis, each in found.items():
        size = scheme.symbols[each.root].size[axis]
        assert each.rest + each.count * each.period == pytest.approx(size)
