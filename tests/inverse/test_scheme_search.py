"""The search gives back what was planted, exactly and shortly, and invents nothing."""

from __future__ import annotations

import numpy as np
import pytest
from inverse.planted_schemes import at, box, mirrored, observed, places, planted, turned, wedge

from ipmlang.inverse.frames import Frames, compose, identity, join, matrices
from ipmlang.inverse.split.cost import scheme_tokens
from ipmlang.inverse.split.expansion import expand
from ipmlang.inverse.split.facades.homes import at_home
from ipmlang.inverse.split.scheme import Array, Direction, Place, Ring, Rule, Scheme, Terminal
from ipmlang.inverse.split.search.assembly import flat, largest_error
from ipmlang.inverse.split.search.shortest import shortest


def _items(scheme: Scheme, kind: type) -> list:
    return [
        item
        for symbol in scheme.symbols
        if isinstance(symbol, Rule)
        for item in symbol.items
        if isinstance(item, kind)
    ]


def _checked(parts) -> Scheme:
    scheme = shortest(parts)
    small = 1e-9 * parts.diagonal
    assert largest_error(parts, scheme) <= 1e-6 * parts.diagonal
    assert scheme_tokens(scheme, small) <= scheme_tokens(flat(parts), small)
    return scheme


def _rules(scheme: Scheme) -> int:
    return sum(isinstance(symbol, Rule) for symbol in scheme.symbols) - 1


def _row(symbol: int, count: int, step: tuple[float, float, float], **more) -> Array:
    return Array(symbol, identity(), (Direction(count, np.array(step, np.float64)),), **more)


def test_a_row_is_one_array() -> None:
    parts = planted([box((1, 2, 3))], [[_row(0, 9, (2.5, 0, 0))]])
    (array,) = _items(_checked(parts), Array)
    assert [direction.count for direction in array.directions] == [9]
    assert np.allclose(np.abs(array.directions[0].step), [2.5, 0, 0])


def test_a_grid_with_uneven_steps_is_one_array() -> None:
    uneven = Direction(4, np.array([0.0, 0, 1]), (0.8, 0.7, 0.9))
    grid = Array(0, identity(), (Direction(7, np.array([1.5, 0, 0])), uneven))
    (array,) = _items(_checked(planted([wedge((0.4, 0.2, 0.5))], [[grid]])), Array)
    assert sorted(direction.count for direction in array.directions) == [4, 7]
    assert (0.8, 0.7, 0.9) in [direction.steps for direction in array.directions]


def test_a_grid_with_a_hole_is_one_array() -> None:
    sides = (Direction(6, np.array([1.5, 0, 0])), Direction(5, np.array([0.0, 0, 2])))
    grid = Array(0, identity(), sides, frozenset({(2, 1)}))
    (array,) = _items(_checked(planted([wedge((0.4, 0.2, 0.5))], [[grid]])), Array)
    assert len(array.holes) == 1


def test_a_window_of_three_parts_is_one_rule_in_one_grid() -> None:
    window = [
        places(0, at((0, 0, 0))),
        places(1, at((0.1, 0.05, 0.1))),
        places(2, at((0, 0, -0.1))),
    ]
    classes = [wedge((1, 0.2, 1.5)), box((0.8, 0.02, 1.3)), wedge((1.2, 0.3, 0.1))]
    grid = Array(
        3, identity(), (Direction(6, np.array([2.0, 0, 0])), Direction(4, np.array([0, 0, 3.0])))
    )
    scheme = _checked(planted(classes, [window, [grid]]))
    assert _rules(scheme) == 1
    (array,) = _items(scheme, Array)
    assert sorted(direction.count for direction in array.directions) == [4, 6]


@pytest.mark.parametrize("count", [4, 7, 12])
def test_a_ring_is_one_item(count: int) -> None:
    ring = Ring(0, at((3, 0, 0)), count, np.zeros(3), np.array([0.0, 0, 1]), 360 / count)
    (found,) = _items(_checked(planted([wedge((1, 0.4, 0.7))], [[ring]])), Ring)
    assert found.count == count
    assert abs(found.angle) == pytest.approx(360 / count)


def test_a_spiral_stair_is_one_item() -> None:
    stair = Ring(0, at((1, 0, 0)), 15, np.array([0.5, 0.5, 0]), np.array([0.0, 0, 1]), 24, 0.18)
    (found,) = _items(_checked(planted([box((1, 0.3, 0.05))], [[stair]])), Ring)
    assert found.count == 15
    assert found.rise == pytest.approx(0.18)


def test_four_towers_are_one_rule() -> None:
    tower = [
        places(0, at((0, 0, 0))),
        places(1, at((0.1, 0.2, 3))),
        places(2, at((0.5, 0, 4), (0.2, 0.3, 4.5))),
    ]
    classes = [wedge((1, 1, 3)), wedge((0.8, 0.5, 1)), wedge((0.3, 0.2, 0.2)), wedge((9, 9, 0.1))]
    corners = [turned(2, 90 * k, (10.0 * (k in (1, 2)), 10.0 * (k > 1), 0)) for k in range(4)]
    scheme = _checked(planted(classes, [tower, [places(4, *corners), places(3, at((1, 1, 0)))]]))
    assert _rules(scheme) == 1


def test_a_mirrored_building_is_half_of_it_twice() -> None:
    random = np.random.default_rng(5)
    spots = [tuple(row) for row in np.round(random.uniform(0, 9, (8, 3)), 2).tolist()]
    classes = [wedge((1, 0.5 + k / 10, 0.7)) for k in range(8)]
    half = [places(k, at(spot)) for k, spot in enumerate(spots)]
    scheme = _checked(planted(classes, [half, [places(8, identity(), mirrored((-1, 0, 0)))]]))
    assert _rules(scheme) == 1


def test_clutter_has_no_rules() -> None:
    random = np.random.default_rng(3)
    count = 80
    classes = [wedge((1, 0.5, 0.7)), box((1, 0.3, 0.2)), box((0.5, 0.5, 0.5))]
    quaternion = random.normal(size=(count, 4))
    quaternion /= np.linalg.norm(quaternion, axis=1, keepdims=True)
    quaternion *= np.sign(quaternion[:, :1])
    spots = random.uniform(0, 20, (count, 3))
    frames = Frames(spots, quaternion, np.ones(count), np.ones(count))
    parts = observed(classes, random.integers(0, 3, count), frames, 1)
    scheme = _checked(parts)
    assert _rules(scheme) == 0
    assert not _items(scheme, Array)
    assert not _items(scheme, Ring)


def test_terminals_of_one_rule_stand_in_its_coordinates() -> None:
    """`Window --> frame pane sill`; what stands elsewhere too is placed from there."""
    window = [places(0, at((1, 2, 3))), places(1, turned(2, 30, (4, 5, 6)))]
    classes = [wedge((1, 0.2, 1.5)), wedge((0.8, 0.3, 1.3))]
    symbols = [Terminal(f"part{k}", each.size, k) for k, each in enumerate(classes)]
    rule = Rule("", np.ones(3), tuple(window))
    whole = Rule("", np.ones(3), (places(2, at((0, 0, 0), (9, 0, 0))), places(1, at((1, 1, 1)))))
    scheme = Scheme((*symbols, rule, whole), identity())
    moved, homes = at_home(scheme, 1e-9)
    assert set(homes) == {0, 1}
    assert scheme_tokens(moved, 1e-9) < scheme_tokens(scheme, 1e-9)
    shape, frames = expand(moved)
    there = join([compose(frames[k : k + 1], homes[int(part)]) for k, part in enumerate(shape)])
    assert np.allclose(matrices(there), matrices(expand(scheme)[1]))
    assert np.allclose(moved.symbols[0].low, (1, 2, 3))


def test_a_group_that_is_turned_but_for_noise_is_turned_plainly() -> None:
    solids = [wedge((0.5, 0.3, 0.4)), wedge((0.2, 0.6, 0.9)), wedge((1.1, 0.2, 0.2))]
    group = [places(0, at((0, 0, 0))), places(1, at((2, 1, 0))), places(2, at((1, 3, 0.5)))]
    spots = join([at((0, 0, 0)), turned(2, 120.0, (9, 2, 0)), turned(2, -30.0, (3, 14, 1))])
    parts = planted(solids, [group, [Place(3, spots)]], noise=3e-6)
    (frames,) = [item.frames for item in _items(_checked(parts), Place) if len(item.frames) > 1]
    angles = np.degrees(2 * np.arctan2(frames.rotation[:, 3], frames.rotation[:, 0]))
    assert len(frames) == 3
    assert (frames.rotation[:, 1:3] == 0).all()
    assert np.allclose(angles, np.round(angles / 7.5) * 7.5, rtol=0, atol=1e-12)
