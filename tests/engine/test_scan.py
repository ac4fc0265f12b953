"""Prefix products against plain loops, and the exactness that drawings rely on."""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipmlang.runtime import scan

LENGTHS = st.lists(
    st.one_of(st.integers(0, 9), st.sampled_from([127, 128, 129, 300, 2100])),
    min_size=1,
    max_size=6,
)


def looped(values: np.ndarray, lengths: np.ndarray, start: np.ndarray | None) -> np.ndarray:
    out, row = np.empty_like(values), 0
    for segment, length in enumerate(lengths):
        total = None if start is None else start[segment]
        for _ in range(length):
            total = values[row] if total is None else total + values[row]
            out[row] = total
            row += 1
    return out


@settings(deadline=None, max_examples=60)
@given(LENGTHS, st.booleans(), st.integers(0, 99))
def test_sums_have_the_bits_of_a_loop(sizes: list[int], started: bool, seed: int) -> None:
    random = np.random.default_rng(seed)
    lengths = np.array(sizes)
    values = random.normal(size=(lengths.sum(), 2))
    start = random.normal(size=(len(sizes), 2)) if started else None
    np.testing.assert_array_equal(
        scan.running_sum(values, lengths, start), looped(values, lengths, start)
    )


def random_frames(count: int, random: np.random.Generator) -> scan.Frames:
    rotation = random.normal(size=(count, 4))
    rotation /= np.linalg.norm(rotation, axis=1, keepdims=True)
    scale = np.exp(random.normal(size=count) * 0.02) * random.choice([-1.0, 1.0], count)
    return scan.Frames(random.normal(size=(count, 3)), rotation, scale)


def matrices(frames: scan.Frames) -> np.ndarray:
    """4 x 4 matrices, written from the definition: position + |s| R diag(h, 1, 1) local."""
    out = np.zeros((len(frames), 4, 4))
    for row, (position, (w, *axis), scale) in enumerate(
        zip(frames.position, frames.rotation, frames.scale, strict=True)
    ):
        x, y, z = axis
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turn = (w * w - np.dot(axis, axis)) * np.eye(3) + 2 * np.outer(axis, axis) + 2 * w * cross
        out[row, :3, :3] = abs(scale) * turn @ np.diag([np.sign(scale), 1, 1])
        out[row, :3, 3] = position
        out[row, 3, 3] = 1
    return out


@settings(deadline=None, max_examples=30)
@given(LENGTHS, st.booleans(), st.integers(0, 99))
def test_chains_of_frames_are_products_of_matrices(
    sizes: list[int], started: bool, seed: int
) -> None:
    random = np.random.default_rng(seed)
    lengths = np.array(sizes)
    steps = random_frames(lengths.sum(), random)
    start = random_frames(len(sizes), random) if started else None
    got = matrices(scan.chain(steps, start, lengths))
    local, before = matrices(steps), matrices(start or scan.identity(len(sizes)))
    row = 0
    for segment, length in enumerate(sizes):
        total = before[segment]
        for _ in range(length):
            total = total @ local[row]
            np.testing.assert_allclose(got[row], total, atol=1e-9 * max(1, abs(total).max()))
            row += 1


@settings(deadline=None, max_examples=30)
@given(LENGTHS, st.integers(0, 99))
def test_the_plane_agrees_with_space(sizes: list[int], seed: int) -> None:
    random = np.random.default_rng(seed)
    lengths = np.array(sizes)
    frames = random_frames(lengths.sum(), random)
    degrees = random.uniform(-180, 180, len(frames))
    frames.position[:, 2] = 0
    frames.rotation = scan.about_z(degrees)
    solid = scan.chain(frames, None, lengths)
    x, y, angle, scale = scan.planar_chain(
        frames.position[:, 0], frames.position[:, 1], degrees, frames.scale, lengths
    )
    np.testing.assert_allclose(np.stack((x, y), axis=1), solid.position[:, :2], atol=1e-8)
    np.testing.assert_allclose(scale, solid.scale)
    same = np.abs((scan.about_z(angle) * solid.rotation).sum(axis=1))
    np.testing.assert_allclose(same, 1, atol=1e-9)


def test_right_angles_are_exact() -> None:
    degrees = np.arange(-20, 21) * 90.0
    cosine, sine = scan.unit(degrees)
    assert set(cosine) | set(sine) == {0.0, 1.0, -1.0}
    np.testing.assert_allclose(cosine, np.cos(np.deg2rad(degrees)), atol=1e-14)
    x, y, angle, _ = scan.planar_chain(
        np.ones(40_000), np.zeros(40_000), np.full(40_000, 90.0), np.ones(40_000)
    )
    assert (x[-1], y[-1], angle[-1]) == (0, 0, 3_600_000)


@pytest.mark.parametrize("degrees", [0.0, 90.0, 180.0, -90.0, 359.0, 540.0, 720.0])
def test_a_turn_about_z_is_a_unit_quaternion(degrees: float) -> None:
    w, x, y, z = scan.about_z(np.array([degrees]))[0]
    assert (x, y) == (0, 0)
    assert w * w + z * z == pytest.approx(1, abs=1e-15)
    assert w * w - z * z == pytest.approx(np.cos(np.deg2rad(degrees)), abs=1e-15)
    assert 2 * w * z == pytest.approx(np.sin(np.deg2rad(degrees)), abs=1e-15)


def test_a_long_chain_keeps_unit_quaternions() -> None:
    random = np.random.default_rng(1)
    steps = random_frames(100_000, random)
    steps.scale[:] = 1
    began = time.process_time()
    frames = scan.chain(steps)
    assert np.abs(np.linalg.norm(frames.rotation, axis=1) - 1).max() < 1e-15 * 4
    assert time.process_time() - began < 5  # a loop over rows would take longer
