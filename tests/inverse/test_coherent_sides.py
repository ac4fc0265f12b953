"""What looks the same from several sides: what is repeated is one whole side, or one whole ring."""

from __future__ import annotations

import numpy as np
import pytest
from inverse.box_models import Boxes

from ipmlang.inverse.frames import Frames, about, identity, turns
from ipmlang.inverse.split.cost import scheme_tokens
from ipmlang.inverse.split.scheme import Array, Rule
from ipmlang.inverse.split.search.drafts import Limits, Motif, first_draft, motif_box, with_motif
from ipmlang.inverse.split.search.figures import figure
from ipmlang.inverse.split.search.patterns import Memory
from ipmlang.inverse.split.search.pruning import with_whole_patterns
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


def test_halves_take_nothing_from_the_ring_of_a_stadium() -> None:
    made = Boxes({"stand": (6, 9, 3), "goal": (0.1, 7, 2.4), "line": (6, 0.1, 1)})
    _turned(made, 20, [("stand", (30, -4.5, 0))])
    _turned(made, 2, [("goal", (17, -3.5, 0)), ("line", (11, -8, 0)), ("line", (11, 8, 0))])
    draft, limits = first_draft(made.parts(), np.zeros(3), Limits(1e-6, 1e-7)), Limits(1e-6, 1e-7)
    rows = np.array([[*range(10), 20, 21, 22], [*range(10, 20), 23, 24, 25]])
    places = Frames(np.zeros((2, 3)), np.eye(4)[[0, 3]], np.ones(2), np.ones(2))
    motif = Motif(rows, places, draft.frames[rows[0]])
    halves = with_motif(draft, motif, figure(*motif_box(draft, motif), identity()))
    whole = with_whole_patterns(halves, limits, Memory())
    assert np.bincount(whole.body[whole.symbol == 0]).tolist() == [20]
    assert (whole.body == 1).sum() == 3


def _turned(made: Boxes, count: int, parts: list[tuple[str, tuple[float, float, float]]]) -> None:
    """Parts, with their low corners, so many times about the vertical."""
    up = np.tile([0.0, 0.0, 1.0], (count, 1))
    for turn in turns(about(up, 360 / count * np.arange(count))):
        for name, low in parts:
            made.placed.append((name, np.column_stack([turn, turn @ low])))


@pytest.mark.parametrize(("count", "missing", "axis"), [(20, 0, 1), (16, 2, 2), (30, 18, 0)])
def test_what_goes_round_without_turning_is_a_circle(count: int, missing: int, axis: int) -> None:
    made = Boxes({"gondola": (1.6, 1.8, 2)})
    turn = np.radians(360 / count * np.arange(count - missing) + 90 / count)
    around = np.stack([0 * turn, 19 * np.cos(turn) + 4, 19 * np.sin(turn) - 2], axis=1)
    for low in np.roll(around, axis, axis=1).tolist():
        made.put("gondola", tuple(low))
    scheme = shortest(made.parts(1))
    (rule,) = (each for each in scheme.symbols if isinstance(each, Rule))
    (circle,) = rule.items
    assert isinstance(circle, Array)
    assert abs(circle.directions[0].angle) == pytest.approx(360 / count)


def test_windows_on_both_sides_of_a_nave_are_as_many_on_each_side() -> None:
    made = Boxes({
        "pane": (1.6, 0.1, 3), "sill": (2, 0.4, 0.2), "jamb": (0.2, 0.3, 3.1),
        "bar": (1.6, 0.2, 0.1), "foot": (0.8, 1.4, 4), "pier": (0.6, 0.9, 3),
    })  # fmt: skip
    window = [("pane", (1.2, 0.1, 2)), ("sill", (1, 0, 1.8)), ("jamb", (1, 0.05, 2))]
    window += [("jamb", (2.8, 0.05, 2)), *(("bar", (1.2, 0.05, 3.0 + k)) for k in range(2))]
    pier = [("foot", (-0.4, -1.4, 0)), ("pier", (-0.3, -0.9, 4))]
    for x in range(8):
        for name, shift in (*(window if x < 7 else ()), *pier):
            low = np.array([4 * x, 0, 0]) + shift
            made.put(name, tuple(low.tolist()))
            far = np.array([28, 10, 0]) - low - np.array(made.sizes[name]) * [1, 1, 0]
            made.put(name, (*far[:2].tolist(), low[2]), 2)
    parts = made.parts(2)
    assert scheme_tokens(shortest(parts), 1e-9 * parts.diagonal) <= 130
