"""Rows and rings that a person lengthens: begun at the bottom, around their axis, with what spans
them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from inverse.planted_schemes import turned
from inverse.test_split_facades import SMALL
from inverse.test_split_lifting import corners, printed

from ipmlang.inverse.frames import Frames, identity, moved_to
from ipmlang.inverse.split.cost import scheme_tokens
from ipmlang.inverse.split.expansion import expand
from ipmlang.inverse.split.facades.anchoring import anchored
from ipmlang.inverse.split.facades.following import following
from ipmlang.inverse.split.facades.homes import at_home
from ipmlang.inverse.split.facades.matching import matched
from ipmlang.inverse.split.facades.splitting import as_splits
from ipmlang.inverse.split.rows import risen
from ipmlang.inverse.split.scheme import (
    Array,
    Direction,
    Item,
    Place,
    Ring,
    Rule,
    Scheme,
    Terminal,
)
from ipmlang.inverse.split.turning import in_axes

UP = np.array([0.0, 0.0, 1.0])


def at(x: float, y: float, z: float) -> Frames:
    return moved_to(np.array([[x, y, z]]))


def whole(*items: Item, size: tuple[float, float, float], **shapes: tuple[float, ...]) -> Scheme:
    """A building of items that place these shapes, in their order."""
    terminals = [
        Terminal(name, np.array(size), part) for part, (name, size) in enumerate(shapes.items())
    ]
    return Scheme((*terminals, Rule("House", np.array(size), items)), identity())


def steps(rise: float) -> Array:
    going = np.array([0.0, 0.3, rise])
    return Array(0, at(0, 0, 2), (Direction(5, going),), frozenset({(1,)}))


def winding(rise: float, growth: float = 1.0) -> Ring:
    holes = frozenset({2})
    return Ring(0, at(3, 1, 4), 6, np.array([1.0, 1.0, 0.0]), UP, 15.0, rise, growth, holes)


@pytest.mark.parametrize("item", [steps(-0.2), winding(-0.3)])
def test_what_goes_down_begins_at_the_bottom(item: Item) -> None:
    scheme = whole(item, size=(5, 5, 5), tread=(1, 0.3, 0.2))
    found = risen(scheme)
    rule = found.symbols[-1]
    assert isinstance(rule, Rule)
    assert matched(expand(found), expand(scheme), 1e-9)
    first = rule.items[0]
    assert isinstance(first, Array | Ring)
    heights = expand(found)[1].position[:, 2]
    assert first.first.position[0, 2] == pytest.approx(heights.min())


@pytest.mark.parametrize("item", [steps(0.2), steps(0.0), winding(0.3), winding(-0.3, 1.1)])
def test_what_goes_up_stays_as_it_is(item: Item) -> None:
    scheme = whole(item, size=(5, 5, 5), tread=(1, 0.3, 0.2))
    rule = risen(scheme).symbols[-1]
    assert isinstance(rule, Rule)
    assert rule.items[0] is item


def test_slabs_follow_the_row_on_them() -> None:
    """Both of them; what stands beyond the row keeps its distance from the end."""
    scheme = anchored(following(balcony(), SMALL, most=60), SMALL)
    drawn = corners(printed(scheme, {"bays : int = 3": "bays : int = 5"}))
    low, high = drawn.min(axis=0), drawn.max(axis=0)
    assert high[0] - low[0] == pytest.approx(9 + 2 * 2.8)
    for z in (0.0, 3.0):
        ends = drawn[np.abs(drawn[:, 2] - z) < 1e-4][:, 0]
        assert (ends.min(), ends.max()) == pytest.approx((0, 14.6))
    posts = drawn[np.abs(drawn[:, 2] - 2.5) < 1e-4][:, 0]
    assert np.unique(posts.round(3))[::2].tolist() == pytest.approx(
        [0.3 + 2.8 * k for k in range(5)]
    )
    piers = drawn[np.abs(drawn[:, 2] - 2.9) < 1e-4][:, 0]
    assert piers.max() == pytest.approx(14.5)


def balcony() -> Scheme:
    row = Array(1, at(0.3, 0.2, 0.3), (Direction(3, np.array([2.8, 0, 0])),))
    slabs = Place(0, moved_to(np.array([[0.0, 0, 0], [0, 0, 3]])))
    pier = Place(2, at(8.7, 0, 0.3))
    return whole(
        slabs,
        row,
        pier,
        size=(9, 6, 3.3),
        slab=(9, 6, 0.3),
        post=(0.1, 0.1, 2.2),
        pier=(0.2, 1, 2.6),
    )


def test_a_newel_follows_its_stair() -> None:
    ring = Ring(1, at(2, 1, 0), 20, np.array([1.0, 1, 0]), UP, 15.0, 0.2)
    scheme = whole(
        Place(0, at(0.9, 0.9, 0)), ring, size=(2, 2, 4), newel=(0.2, 0.2, 4.0), tread=(1, 0.3, 0.2)
    )
    found = as_splits(scheme, SMALL)
    assert corners(printed(found, {}))[:, 2].max() == pytest.approx(4)
    drawn = corners(printed(found, {"treads : int = 20": "treads : int = 30"}))
    newel = drawn[np.abs(drawn[:, 0] - 0.9) + np.abs(drawn[:, 1] - 0.9) < 1e-3]
    assert newel[:, 2].max() == pytest.approx(6)


def test_a_row_that_nothing_spans_is_a_plain_count() -> None:
    row = Array(0, at(0, 0, 0), (Direction(9, np.array([2.0, 0.5, 0])),))
    scheme = whole(row, size=(17, 5, 3), post=(0.5, 0.5, 3))
    assert as_splits(scheme, SMALL) is scheme


@pytest.mark.parametrize("axis", [(0.0, 0, 1), (1.0, 0, 0), (0.6, 0, -0.8), (0.0, 0, -1)])
def test_a_rule_in_a_ring_is_drawn_around_its_axis(axis: tuple[float, float, float]) -> None:
    """The same is drawn, and said with less."""
    scheme = whole(size=(9, 9, 9), drum=(1, 1, 2), merlon=(0.5, 0.3, 1))
    first = replace(turned(2, 40.0), position=np.array([[2.0, 0.3, 0.1]]))
    pair = Rule("Pair", np.ones(3), (Place(0, identity()), Place(1, at(1, 0, 0))))
    ring = Ring(2, first, 5, np.array([4.0, 4, 0]), np.array(axis), 72.0)
    scheme = replace(
        scheme, symbols=(*scheme.symbols[:2], pair, Rule("House", np.full(3, 9.0), (ring,)))
    )
    (found,) = in_axes(scheme)
    assert matched(expand(found), expand(scheme), 1e-9)
    printed_as, _ = at_home(scheme, 1e-9)
    assert scheme_tokens(printed_as, 1e-9) < scheme_tokens(scheme, 1e-9)
