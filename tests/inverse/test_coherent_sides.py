"""Towers that look the same from all sides: what is repeated about the axis is one whole side."""

from __future__ import annotations

import numpy as np
import pytest
from inverse.box_models import Boxes

from ipmlang.inverse.split.cost import scheme_tokens
from ipmlang.inverse.split.search.shortest import shortest

SIZES = {"pane": (2.8, 0.1, 2.9), "mullion": (0.2, 0.3, 2.9)}
TURNS = ((1, 0), (0, 1), (-1, 0), (0, -1))  # cosine and sine of quarters
TIERS = ((6, 4), (4, 3), (2, 5))  # bays a side, and floors


def tower() -> Boxes:
    """Three tiers, each set back, with panes and mullions on four sides."""
    made = Boxes(SIZES)
    low = 0.0
    for bays, floors in TIERS:
        half = 1.5 * bays
        for quarter, storey, bay in np.ndindex(4, floors, bays):
            z = low + 3.2 * storey
            put(made, "pane", (-half + 3 * bay + 0.1, -half - 0.1, z), quarter)
            put(made, "mullion", (-half + 3 * bay - 0.1, -half - 0.2, z), quarter)
        low += 3.2 * floors
    return made


def put(made: Boxes, name: str, low: tuple[float, float, float], quarter: int) -> None:
    """A box of the front, turned about the tower's axis with all of its side."""
    cosine, sine = TURNS[quarter]
    ends = np.array([low[:2], np.add(low, SIZES[name])[:2]])
    x, y = (ends @ [[cosine, sine], [-sine, cosine]]).min(axis=0).tolist()
    made.put(name, (x, y, low[2]), quarter)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_tower_with_set_backs_is_one_side_four_times(seed: int) -> None:
    parts = tower().parts(seed)
    assert scheme_tokens(shortest(parts), 1e-9 * parts.diagonal) <= 170
