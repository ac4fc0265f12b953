"""Lattices found among frames: what was put there is found with its numbers, whatever the order,
noise, holes and clutter; what chance made is not.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np
import pytest

from ipmlang.compiler import ast
from ipmlang.inverse.lattices.build import Lattice
from ipmlang.inverse.lattices.find import find_lattices
from ipmlang.inverse.lattices.formula import lattice_rule
from ipmlang.inverse.lattices.printing import printed, whole
from ipmlang.inverse.lsystem.frames import (
    Complexes,
    Floats,
    Frames,
    compose,
    frames,
    identity,
    join,
    wrap,
)

EXACT = 1e-4
SQUARE = frames(
    np.zeros(8, np.complex128), np.tile([0.0, 90, 180, -90], 2), 1.0, np.repeat([1, -1], 4)
)
STAR = frames(np.zeros(5, np.complex128), 72.0 * np.arange(5))


def find(
    placed: Frames,
    stabiliser: Frames | None = None,
    free: bool = False,
    order: Sequence[int] | None = None,
    loose: float = 0.015,
) -> list[Lattice]:
    rank = np.arange(len(placed)) if order is None else np.asarray(order, np.int64)
    group = identity(1) if stabiliser is None else stabiliser
    found = find_lattices(placed, group, free, 2.0, EXACT, loose, rank)
    for lattice in found:
        check(lattice, placed, group, free)
    return found


def check(lattice: Lattice, placed: Frames, stabiliser: Frames, free: bool) -> None:
    """What every lattice says must be so."""
    assert len(set(lattice.rows.tolist())) == len(lattice)
    nodes = {tuple(np.atleast_1d(each)) for each in lattice.index.tolist()}
    holes = {tuple(np.atleast_1d(each)) for each in lattice.holes.tolist()}
    assert len(nodes) == len(lattice)
    assert not nodes & holes
    predicted = lattice.frames(lattice.index)
    given = placed[lattice.rows]
    off = lattice.chosen.position - predicted.position
    if lattice.anchor == 0:
        assert np.allclose(off, lattice.residual[:, 0] + 1j * lattice.residual[:, 1])
    assert np.allclose(wrap(predicted.angle + lattice.residual[:, 2] - lattice.chosen.angle), 0)
    assert np.allclose(predicted.scale + lattice.residual[:, 3], lattice.chosen.scale)
    assert np.allclose(lattice.chosen.scale, given.scale)
    if not free:
        every = compose(given[:, None], stabiliser)
        apart = np.abs(every.factor - lattice.chosen.factor[:, None])
        apart += np.abs(every.position - lattice.chosen.position[:, None])
        apart += every.handedness != lattice.chosen.handedness[:, None]
        assert apart.min(axis=1).max() < 1e-9
    if lattice.exact:
        assert np.abs(lattice.residual[:, :2]).max() <= EXACT


def noisy(at: Complexes, amount: float, seed: int = 0) -> Complexes:
    random = np.random.default_rng(seed)
    return at + amount * (random.uniform(-1, 1, len(at)) + 1j * random.uniform(-1, 1, len(at)))


def clutter(count: int, seed: int = 5, size: float = 300.0) -> Frames:
    """Frames anywhere."""
    random = np.random.default_rng(seed)
    at = random.uniform(-size / 2, size, count) + 1j * random.uniform(-size / 2, size, count)
    return frames(at, random.uniform(-180, 180, count), random.uniform(0.5, 2, count))


def shuffled(
    placed: Frames, seed: int = 3
) -> tuple[Frames, np.ndarray[tuple[int], np.dtype[np.int64]]]:
    """In another order; number of each in the old one."""
    order = np.random.default_rng(seed).permutation(len(placed))
    return placed[order], order


# ------------------------------------------------------------------------ rows


def test_exact_row_in_clutter() -> None:
    row = frames(10 + 20j + (9 + 2j) * np.arange(12), 30.0)
    placed, old = shuffled(join([row, clutter(12)]))
    best = find(placed)[0]
    assert best.kind == "row"
    assert best.exact
    assert sorted(old[best.rows].tolist()) == list(range(12))
    assert abs(complex(best.parameters["x1"], best.parameters["y1"])) == pytest.approx(abs(9 + 2j))
    assert best.angle.kind == best.scale.kind == best.handedness.kind == "regular"
    assert best.angle.terms == pytest.approx((30.0, 0, 0, 0))


def test_three_make_a_row_only_if_exact() -> None:
    exact = frames(np.array([0, 10, 20]) + 0j)
    assert [len(each) for each in find(exact)] == [3]
    assert find(frames(np.array([0, 10.05, 20]) + 0j)) == []
    assert find(frames(np.array([0, 10, 20]) + 0j, np.array([0.0, 50, 7]))) == []


def test_row_with_noise_and_holes() -> None:
    index = np.delete(np.arange(16), [3, 7, 8])
    row = frames(noisy(9.0 * index + 0j, 0.09))
    placed, old = shuffled(join([row, clutter(13)]))
    best = find(placed)[0]
    assert not best.exact
    assert old[best.rows].tolist() == list(range(13)) or old[best.rows].tolist() == list(
        range(12, -1, -1)
    )
    assert len(best.holes) == 3
    assert abs(best.parameters["x1"]) == pytest.approx(9.0, abs=0.05)


def test_noisy_row_with_no_three_members_side_by_side() -> None:
    index = np.array([0, 1, 4, 6, 7, 9, 11, 12])
    placed, old = shuffled(join([frames(noisy((9 + 2j) * index, 0.05)), clutter(3)]))
    best = find(placed)[0]
    assert (best.kind, len(best.holes)) == ("row", 5)
    assert set(old[best.rows].tolist()) == set(range(8))


def test_row_with_linear_angle_and_scale() -> None:
    index = np.arange(10)
    best = find(frames(12.0 * index + 0j, 5 + 7.0 * index, 1 + 0.25 * index))[0]
    assert best.exact
    assert best.angle.terms == pytest.approx((5, 7, 0, 0), abs=1e-6)
    assert best.scale.terms == pytest.approx((1, 0.25, 0, 0), abs=1e-6)


def test_row_that_bends() -> None:
    index = np.arange(14.0)
    at = 6 * index + 1j * 0.9 * index * (index - 7)
    best = find(join([frames(at), clutter(10)]))[0]
    assert (best.kind, len(best), best.exact) == ("row", 14, True)
    assert (best.parameters["x2"], best.parameters["y2"]) == pytest.approx((0, 0.9), abs=1e-9)


def test_columns_that_are_arbitrary_or_alternate() -> None:
    random = np.random.default_rng(1)
    at = 10.0 * np.arange(12) + 0j
    best = find(frames(at, 0.0, random.uniform(0.2, 2, 12)))[0]
    assert (best.angle.kind, best.scale.kind, best.exact) == ("regular", "arbitrary", True)
    assert np.ptp(best.residual[:, 3]) > 0.5
    best = find(frames(at, random.uniform(-180, 180, 12)))[0]
    assert (best.angle.kind, best.scale.kind) == ("arbitrary", "regular")
    best = find(frames(at, np.tile([0.0, 180.0], 6), np.tile([1.0, 0.5], 6)))[0]
    assert (best.angle.kind, best.scale.kind) == ("alternating", "alternating")
    assert abs(best.scale.other) == pytest.approx(0.5)


def test_mirrored_alternation() -> None:
    hand = np.tile([1, -1], 5).astype(np.int8)
    best = find(frames(10j * np.arange(10), np.tile([20.0, -50.0], 5), 1.0, hand))[0]
    assert best.handedness.kind == "alternating"
    assert best.angle.kind == "alternating"
    assert best.exact
    assert (best.frames(best.index).handedness == best.chosen.handedness).all()


def test_symmetric_symbols_take_the_frame_that_fits() -> None:
    random = np.random.default_rng(2)
    at = (7 + 1j) * np.arange(9)
    turned = compose(frames(at, 12.0), SQUARE[random.integers(0, 8, 9)])
    best = find(turned, SQUARE)[0]
    assert (best.angle.kind, best.handedness.kind, best.exact) == ("regular", "regular", True)
    assert np.ptp(best.chosen.angle) < 1e-9


def test_group_whose_origin_is_not_its_middle() -> None:
    middle = frames(np.array([3 + 1j]))
    around = compose(compose(middle, STAR), frames(np.array([-3 - 1j])))
    random = np.random.default_rng(4)
    placed = compose(frames(25.0 * np.arange(8) + 0j, 10.0), around[random.integers(0, 5, 8)])
    best = find(placed, around)[0]
    assert (len(best), best.exact, best.angle.kind) == (8, True, "regular")
    assert best.anchor == pytest.approx(3 + 1j)
    assert np.allclose(best.frames(best.index).position, best.chosen.position)


@pytest.mark.parametrize(("jitter", "turn"), [(0.0, 12.0), (0.03, 80.0)])
def test_row_of_copies_that_turn_about_no_middle(jitter: float, turn: float) -> None:
    row = frames(noisy((8 + 3j) * np.arange(14), jitter), turn * np.arange(14))
    best = find(compose(row, frames(np.array([-0.7 + 1j]))))[0]
    assert (best.kind, len(best), best.exact) == ("row", 14, jitter == 0)
    assert abs(best.anchor - (0.7 - 1j)) <= 10 * jitter + EXACT


def test_one_stray_becomes_a_hole() -> None:
    angle = np.zeros(9)
    angle[4] = 33.0
    best = find(frames(10.0 * np.arange(9) + 0j, angle))[0]
    assert len(best) == 8
    assert best.holes.tolist() == [4]
    assert best.exact


# ------------------------------------------------------------------------ rings and spirals


def test_ring_that_turns_and_ring_that_stays_upright() -> None:
    around = np.exp(2j * np.pi * np.arange(12) / 12)
    turning = find(frames(5 + 40 * around, 30.0 * np.arange(12)))[0]
    assert (turning.kind, turning.exact, turning.parameters["closed"]) == ("ring", True, 12)
    assert abs(turning.angle.terms[1]) == pytest.approx(30)
    upright = find(frames(5 + 40 * around, 8.0))[0]
    assert upright.angle.terms == pytest.approx((8, 0, 0, 0))
    assert upright.parameters["radius"] == pytest.approx(40)


@pytest.mark.parametrize("jitter", [0.0, 0.001, 0.01])
def test_ring_of_circles_with_holes_in_clutter(jitter: float) -> None:
    index = np.delete(np.arange(16), [2, 9, 10])
    at = noisy(30 * np.exp(2j * np.pi * index / 16), jitter * 11)
    placed, old = shuffled(join([frames(at), clutter(13)]))
    best = find(placed, free=True)[0]
    assert best.kind == "ring"
    assert best.parameters["closed"] == 16
    assert len(best.holes) == 3
    assert set(old[best.rows].tolist()) == set(range(13))


@pytest.mark.parametrize(("around", "gone"), [(15, [4, 11, 14]), (16, [4, 8, 14])])
def test_ring_whose_every_second_or_third_member_is_there(around: int, gone: list[int]) -> None:
    index = np.delete(np.arange(around), gone)
    at = noisy(20 * np.exp(2j * np.pi * index / around), 0.01)
    best = find(frames(at, 360.0 / around * index))[0]
    assert (best.kind, len(best), best.parameters["closed"]) == ("ring", len(index), around)


def test_arc_is_no_full_ring() -> None:
    best = find(frames(50 * np.exp(1j * np.deg2rad(10.0 * np.arange(14)))), free=True)[0]
    assert (best.kind, best.parameters["closed"], len(best.holes)) == ("ring", 0, 0)


def test_rings_about_one_centre_are_one_lattice() -> None:
    turn = 2j * np.pi * np.arange(10) / 10
    at = np.concatenate([(20 + 9 * ring) * np.exp(turn + 0.1j * ring) for ring in range(4)])
    best = find(frames(at), free=True)[0]
    assert (best.kind, len(best), best.exact) == ("ring", 40, True)
    assert best.index.max(axis=0).tolist() == [9, 3]
    assert best.parameters["growth"] == pytest.approx(9)
    assert best.order_kind == "row-major"


def test_spirals() -> None:
    index = np.arange(24)
    log = find(frames(50 * np.exp((0.4j - 0.06) * index), 0.0, 0.94**index), free=True)[0]
    assert (log.kind, log.exact, len(log)) == ("spiral", True, 24)
    assert abs(log.parameters["growth"]) == pytest.approx(0.06)
    arm = (10 + 2.0 * index) * np.exp(0.35j * index)
    archimedes = find(frames(arm), free=True)[0]
    assert (archimedes.kind, archimedes.exact, len(archimedes)) == ("spiral", True, 24)
    assert abs(archimedes.parameters["growth"]) == pytest.approx(2)


@pytest.mark.parametrize("jitter", [0.0, 0.05])
def test_sunflower_of_circles(jitter: float) -> None:
    index = np.arange(150)
    at = 3 + 1j + 4 * np.sqrt(index + 0.5) * np.exp(1j * np.deg2rad(137.508) * index)
    placed, _ = shuffled(frames(noisy(at, jitter)))
    best = find(placed, free=True)[0]
    assert best.kind == "spiral"
    assert len(best) >= 0.97 * len(at)
    assert abs(best.parameters["step"]) == pytest.approx(137.508, abs=0.01)
    assert best.parameters["spread"] == pytest.approx(4, abs=0.01)


@pytest.mark.parametrize("seed", range(6))
def test_shrinking_row_with_noise_as_large_as_its_last_steps(seed: int) -> None:
    random = np.random.default_rng(seed)
    arm = 0.93 * np.exp(1j * np.deg2rad(-1))
    index = np.arange(18)
    at = 9 * arm**index / (arm - 1) + random.uniform(-0.09, 0.09, 18)
    at = at + 1j * random.uniform(-0.09, 0.09, 18)
    kept = random.random(18) >= 0.2
    row = frames(at, -1.0 * index, 0.93**index)[kept]
    other = random.uniform(-100, 100, (8, 2)) @ np.array([1, 1j])
    clutter = frames(other, random.uniform(-180, 180, 8), random.uniform(0.6, 1.5, 8))
    found = find(join([row, clutter]), order=random.permutation(len(row) + 8).tolist())
    assert sorted(found[0].rows.tolist()) == list(range(len(row)))
    assert found[0].scale.exact and found[0].angle.exact


def test_scale_sequences_at_one_place() -> None:
    even = find(frames(np.full(7, 4 + 4j), 0.0, 1 + 0.5 * np.arange(7)), free=True)[0]
    assert (even.kind, even.exact, even.scale.geometric) == ("nest", True, False)
    assert abs(even.scale.terms[1]) == pytest.approx(0.5)
    ratio = find(frames(np.full(7, 4 + 4j), 0.0, 1.3 ** np.arange(7)), free=True)[0]
    assert (ratio.kind, ratio.exact, ratio.scale.geometric) == ("nest", True, True)


# ------------------------------------------------------------------------ grids


def grid(columns: int, rows: int, u: complex, v: complex, stagger: float = 0.0) -> Complexes:
    j, i = np.mgrid[0:rows, 0:columns]
    return np.asarray((i + stagger * (j % 2)) * u + j * v).ravel()


@pytest.mark.parametrize("jitter", [0.0, 0.001, 0.01])
def test_skewed_grid_with_holes_in_clutter(jitter: float) -> None:
    at = grid(6, 5, 18 + 2j, 3 + 19j)
    there = np.delete(np.arange(30), [4, 9, 13, 14, 22, 25])
    placed, old = shuffled(join([frames(noisy(at[there], jitter * 18)), clutter(24)]))
    best = find(placed)[0]
    assert best.kind == "grid"
    assert set(old[best.rows].tolist()) <= set(range(24))
    assert len(best) >= 23
    assert sorted((best.index.max(axis=0) + 1).tolist()) == [5, 6]
    steps = {
        round(abs(complex(best.parameters[f"{k}x"], best.parameters[f"{k}y"])), 1) for k in "uv"
    }
    assert steps <= {18.0, 18.1, 18.2, 19.1, 19.2, 19.3}


def test_staggered_grid_with_a_scale_per_dot() -> None:
    random = np.random.default_rng(3)
    at = noisy(grid(56, 44, 10, 8j, 0.5), 0.02)
    placed = frames(at, 0.0, random.uniform(0.1, 1, len(at)))
    began = time.process_time()
    found = find(placed, free=True)
    assert time.process_time() - began < 5
    assert len(found) == 1
    best = found[0]
    assert (best.kind, len(best), len(best.holes)) == ("grid", 2464, 0)
    assert best.parameters["stagger"] == 0.5
    assert (best.scale.kind, best.order_kind, best.stride) == ("arbitrary", "row-major", 1)


def test_small_grids() -> None:
    exact = find(join([frames(grid(3, 2, 10, 14j)), clutter(6)]))
    assert [(each.kind, len(each)) for each in exact][:1] == [("grid", 6)]
    noise = find(frames(noisy(grid(3, 2, 10, 14j), 0.05)))
    assert all(each.kind != "grid" for each in noise)
    assert find(join([frames(noisy(grid(3, 3, 10, 14j), 0.05)), clutter(6)]))[0].kind == "grid"


def test_last_line_of_a_grid_may_end_early() -> None:
    best = find(frames(grid(7, 5, 10, -14j)[:31]))[0]
    rule = lattice_rule(0, best, np.arange(31), 2.0, EXACT)
    assert rule is not None
    assert (rule.formula.count, rule.holes) == (31, ())
    loop, _ = printed(rule, (), (EXACT, EXACT, EXACT), "Rest")
    assert (loop.head, loop.holes) == (ast.Count("k", ast.Number(31.0)), ())
    assert not whole(rule)


def test_rounded_stars_of_a_flag_are_one_staggered_grid() -> None:
    i, j = np.meshgrid(np.arange(11), np.arange(9))
    there = (i + j) % 2 == 0
    at = np.round(30.43 * i[there]) + 1j * np.round(25.85 * j[there])
    best = find(frames(at), STAR)[0]
    assert (len(best), best.parameters["stagger"], len(best.holes)) == (50, 0.5, 4)


def test_round_grid_keeps_its_shape() -> None:
    at = grid(31, 31, 10, 10j) - 150 - 150j
    at = at[np.abs(at) < 148]
    best = find(frames(at), free=True)[0]
    assert len(best) == len(at)


def test_checkerboard_of_mirrored_copies() -> None:
    at = grid(6, 6, 10, 10j)
    hand = np.where(np.add(*np.divmod(np.arange(36), 6)) % 2, -1, 1).astype(np.int8)
    best = find(frames(at, 0.0, 1.0, hand))[0]
    assert (best.handedness.kind, best.handedness.parity, best.exact) == (
        "alternating",
        (1, 1),
        True,
    )


def test_paint_orders() -> None:
    at = grid(5, 4, 10, 12j)
    i, j = np.tile(np.arange(5), 4), np.repeat(np.arange(4), 5)
    orders = {
        "row-major": j * 5 + i,
        "column-major": i * 4 + j,
        "boustrophedon": j * 5 + np.where(j % 2, 4 - i, i),
        "arbitrary": np.random.default_rng(0).permutation(20),
    }
    for kind, rank in orders.items():
        best = find(frames(at), order=rank.tolist())[0]
        assert best.order_kind == kind
        assert find(frames(at), order=(19 - rank).tolist())[0].order_kind == kind
    row = frames(10.0 * np.arange(6) + 0j)
    assert find(row, order=[0, 1, 2, 3, 4, 5])[0].order_kind == "contiguous"
    backwards = find(row, order=[25, 20, 15, 10, 5, 0])[0]
    assert (backwards.order_kind, backwards.stride, backwards.parameters["x"]) == ("linear", 5, 50)


# ------------------------------------------------------------------------ nothing


@pytest.mark.parametrize("count", [3, 10, 30, 100, 400])
def test_clutter_has_no_lattice(count: int) -> None:
    for seed in range(3 if count < 400 else 1):
        assert find(clutter(count, seed)) == []
        assert find(clutter(count, seed), free=True) == []


def test_many_random_frames_are_quick_and_nothing() -> None:
    placed = clutter(8744, size=3000.0)
    began = time.process_time()
    assert find(placed) == []
    assert time.process_time() - began < 5  # 1.3 s where nothing else runs


def test_packing_on_a_hidden_raster_is_no_row() -> None:
    random = np.random.default_rng(0)
    at = random.integers(0, 40, 30) * 0.5774 + 1j * random.integers(0, 40, 30) * 0.3731
    assert all(len(each) > 3 or each.kind != "row" for each in find(frames(np.unique(at))))


@pytest.mark.parametrize(
    "make",
    [
        lambda: identity(0),
        lambda: identity(2),
        lambda: identity(3000),
        lambda: frames(np.array([0, 0, 0, 1]) + 0j),
        lambda: frames(np.full(5, 1e9 + 0j), 0.0, np.array([1e-9, 1, 2, 1e9, 3])),
    ],
)
def test_degenerate_input_ends_cleanly(make: Callable[[], Frames]) -> None:
    assert all(len(each) >= 3 for each in find(make()))


def test_same_result_each_time() -> None:
    placed = join([frames(noisy(grid(5, 5, 10, 12j), 0.08)), clutter(25)])
    first, second = find(placed), find(placed)
    assert [each.rows.tolist() for each in first] == [each.rows.tolist() for each in second]
    assert [each.parameters for each in first] == [each.parameters for each in second]


# ------------------------------------------------------------------------ recall and precision


def _row(count: int, turn: complex) -> Complexes:
    return np.asarray(9 * turn * np.arange(count))


def _ring(count: int, turn: complex) -> Complexes:
    return np.asarray(
        9 * count / (2 * np.pi) * turn * np.exp(2j * np.pi * np.arange(count) / count)
    )


def _grid(count: int, turn: complex) -> Complexes:
    return grid(6, count // 3, 18 * turn, (3 + 19j) * turn)


def _scaled(count: int, turn: complex) -> Complexes:
    return np.asarray(120 * turn * np.exp((0.08j - 0.05) * np.arange(count)))


def _bent(count: int, turn: complex) -> Complexes:
    index = np.arange(count)
    return np.asarray(turn * (6.3 * index + 0.9j * index * (index - count / 2)))


@pytest.mark.parametrize("make", [_row, _ring, _grid, _scaled, _bent])
@pytest.mark.parametrize(("jitter", "floor"), [(0.001, 0.95), (0.01, 0.85)])
def test_recall_and_precision(
    make: Callable[[int, complex], Complexes], jitter: float, floor: float
) -> None:
    planted = found = claimed = 0
    for seed in range(8):
        random = np.random.default_rng(seed)
        at = make(int(random.integers(12, 19)), complex(np.exp(2j * np.pi * random.random())))
        step: Floats = np.abs(np.diff(at))
        there = random.random(len(at)) > (0.2 if seed % 2 else 0.0)
        at = noisy(at[there], jitter * float(np.median(step)), seed)
        placed, old = shuffled(join([frames(at), clutter(len(at), seed)]), seed)
        rows = {int(row) for each in find(placed) for row in old[each.rows]}
        planted += len(at)
        found += sum(row < len(at) for row in rows)
        claimed += len(rows)
    assert found / planted >= floor
    assert found / max(claimed, 1) >= 0.95
