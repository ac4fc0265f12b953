"""Directions, and the body that measuring along them leaves: it holds what was measured."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from ipmlang.studio import ways

Floats = NDArray[np.float64]
COUNT = 24


def measured(points: Floats, along: Floats) -> Floats:
    """How far points go along directions, and against them."""
    reach = points @ along.T
    found: Floats = np.stack([reach.max(axis=0), -reach.min(axis=0)], axis=1)
    return found


def farthest(points: Floats, along: Floats) -> Floats:
    """The points that go farthest along directions, and against them."""
    reach = points @ along.T
    found: Floats = points[np.concatenate([reach.argmax(axis=0), reach.argmin(axis=0)])]
    return found


def body_of(points: Floats) -> Floats:
    along = ways.even(COUNT)
    along = np.concatenate([along, ways.facing(points, COUNT)])
    return ways.within(along, measured(points, along))


def assert_held(points: Floats, body: Floats) -> None:
    """Every point lies within the hull of the body."""
    sides = ConvexHull(body).equations
    assert (points @ sides[:, :3].T + sides[:, 3]).max() < 1e-9 * np.abs(points).max()


def test_even_directions_are_unit_and_apart() -> None:
    even = ways.even(COUNT)
    assert even.shape == (COUNT, 3)
    assert np.allclose(np.linalg.norm(even, axis=1), 1)
    alike = np.abs(even @ even.T) - np.eye(COUNT)
    assert alike.max() < 0.99


@pytest.mark.parametrize("shift", [0.0, 5e6])
def test_a_turned_box_is_held_by_itself(shift: float) -> None:
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    box = np.array([[x, y, z] for x in (0, 7) for y in (0, 3) for z in (0, 1)]) @ turn + shift
    body = body_of(box)
    assert_held(box, body)
    assert np.ptp(body, axis=0) == pytest.approx(np.ptp(box, axis=0), rel=2e-3)


def test_a_ball_is_held_closely_after_another_look() -> None:
    points = np.random.default_rng(5).normal(size=(4000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    along = ways.even(COUNT)
    body = ways.within(along, measured(points, along))
    known = farthest(points, along)
    for _ in range(3):
        more = ways.toward(body, known, COUNT)
        along = np.concatenate([along, more])
        known = np.concatenate([known, farthest(points, more)])
        before, body = body, ways.within(along, measured(points, along))
        assert np.linalg.norm(body, axis=1).max() < np.linalg.norm(before, axis=1).max()
    assert_held(points, body)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_what_is_flat_is_held(axis: int) -> None:
    flat = np.insert(np.random.default_rng(7).random((30, 2)) * 9, axis, 4.0, axis=1)
    body = body_of(flat)
    assert_held(flat, body)
    assert np.ptp(body, axis=0)[axis] < 0.01


def test_what_is_held_needs_no_other_look() -> None:
    box = np.array([[x, y, z] for x in (0.0, 7) for y in (0.0, 3) for z in (0.0, 1)])
    assert len(ways.toward(body_of(box), box, COUNT)) == 0
