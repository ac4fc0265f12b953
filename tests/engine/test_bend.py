"""Levelling and tropism: both ways to walk agree, and each does what the book says."""

from __future__ import annotations

import numpy as np
import pytest

from ipmlang.runtime import scan
from ipmlang.runtime.bend import BEND, LEVEL, TURN, Bending

BENDING = Bending((-0.61, 0.77, -0.19, 0.4))


def rotations(count: int, random: np.random.Generator) -> scan.Columns:
    columns = random.normal(size=(4, count))
    columns[:, : count // 8] = np.array([[0.5], [0.5], [-0.5], [0.5]])  # upright: nothing to level
    return tuple(columns / np.linalg.norm(columns, axis=0))


@pytest.mark.parametrize("hand", [1.0, -1.0])
def test_one_turtle_steps_as_many_do(hand: float) -> None:
    random = np.random.default_rng(3)
    count = 300
    before = rotations(count, random)
    kind = random.choice([TURN, LEVEL, BEND], count)
    rotation = tuple(np.where(kind == TURN, own, one) for own, one in
                     zip(rotations(count, random), (1, 0, 0, 0), strict=True))  # fmt: skip
    hands = np.full(count, hand)
    many = BENDING.columns((*before, kind, hands), (*rotation, kind, hands))
    for i in range(count):
        state = tuple(float(column[i]) for column in before)
        row = (*(float(column[i]) for column in rotation), float(kind[i]), hand)
        one = BENDING.single((*state, TURN, hand), row)
        assert one == pytest.approx([column[i] for column in many], abs=1e-12)


def test_a_levelled_frame_has_its_left_in_the_horizontal_plane() -> None:
    before = rotations(200, np.random.default_rng(4))
    kind, hand = np.full(200, LEVEL), np.ones(200)
    still = (np.ones(200), *(np.zeros(200) for _ in range(3)))
    after = BENDING.columns((*before, kind, hand), (*still, kind, hand))[:4]
    zero, one = np.zeros(200), np.ones(200)
    np.testing.assert_allclose(
        scan.turned(after, (one, zero, zero)), scan.turned(before, (one, zero, zero)), atol=1e-12
    )
    left = scan.turned(after, (zero, one, zero))
    assert np.abs(left[2][25:]).max() < 1e-12
    assert (scan.turned(after, (zero, zero, one))[2] > -1e-12)[25:].all()


@pytest.mark.parametrize("sizes", [[1, 40], [300] * 20 + [700] * 3, [5] * 9, [0, 3]])
def test_walks_of_all_shapes_are_steps_one_after_the_other(sizes: list[int]) -> None:
    random = np.random.default_rng(5)
    lengths = np.array(sizes)
    count = int(lengths.sum())
    kind = random.choice([TURN, LEVEL, BEND], count)
    columns = (*rotations(count, random), kind, np.ones(count))
    expected = [column.tolist() for column in columns]
    row = 0
    for length in sizes:
        for k in range(row + 1, row + length):
            state = tuple(column[k - 1] for column in expected)
            after = BENDING.single(state, tuple(column[k] for column in expected))
            for column, value in zip(expected, after, strict=True):
                column[k] = value
        row += length
    got = scan.walked(tuple(column.copy() for column in columns), lengths, BENDING)
    for column, values in zip(got[:4], expected[:4], strict=True):
        np.testing.assert_allclose(column, values, atol=1e-9)
