"""Buildings that an author wrote are found again from their triangles: exactly, and in about as
many tokens.

The bounds of each stand in buildings/bounds.json, as tight as inference has come so far.
"""

from __future__ import annotations

import pytest
from inverse.buildings.answers import FOLDER, answer, bounds, names

import ipmlang

EXACT = 1e-6  # of the diagonal
WELDED = ("09_round_tower", "16_tables_and_chairs", "26_courtyard")  # the rest are in the bench


def test_every_building_has_its_bounds() -> None:
    assert {key.split()[0] for key in bounds()} == set(names())


@pytest.mark.parametrize("name", names())
def test_author_writes_in_the_one_layout(name: str) -> None:
    path = FOLDER / f"{name}.ipm"
    assert ipmlang.load(path).format() == path.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "disguise"),
    [*((name, "turned") for name in names()), *((name, "welded") for name in WELDED)],
)
def test_known_building(name: str, disguise: str) -> None:
    found = answer(name, disguise)
    assert found.error <= EXACT, found.text
    ceiling = bounds()[f"{name} {disguise}"]
    told = f"{found.inferred} tokens, author {found.author}, ceiling {ceiling}\n{found.text}"
    assert found.ratio <= ceiling + 0.005, told
