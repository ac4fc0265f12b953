"""Rows whose members grow: each so many times as large as the one before, or larger by as much.

Takes copies of one symbol that are turned alike; gives rows of three and more with a constant ratio
or difference of scale, whose places follow the scale, the index or both. Members are fitted and
proved. Nothing here counts tokens.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import Floats, Frames, Integers, spread
from ipmlang.inverse.numbers import shortest
from ipmlang.inverse.split.expansion import placements
from ipmlang.inverse.split.scheme import Ring
from ipmlang.inverse.split.search.figures import Figure, misses, probed
from ipmlang.inverse.split.snapping import snap

FEWEST = 3
LEVEL = 1e-4  # share by which scales differ that are not one
AHEAD = 4  # scales behind one that may be the next of its row
MOST_LEVELS = 64  # scales among which rows are looked for


@dataclass(frozen=True, slots=True)
class _Growth:
    """Scales `first * ratio ** k`, or `first * (1 + gain * k)`."""

    ratio: float
    gain: float

    def factors(self, count: int) -> Floats:
        """(count,) of the members."""
        index = np.arange(count, dtype=np.float64)
        return np.asarray(self.ratio**index + self.gain * index)


def swelling(
    shape: Figure, frames: Frames, symbol: int, error: float
) -> Iterator[tuple[Integers, Ring]]:
    """Rows of frames (n,), which are turned alike, with the growing rows that they are."""
    level = snap(-frames.scale, LEVEL * float(frames.scale.max(initial=1.0)))
    count = int(level.max(initial=-1)) + 1
    if not FEWEST <= count <= MOST_LEVELS:
        return
    center = spread(frames, shape.center[None])[:, 0]
    among = [np.flatnonzero(level == each) for each in range(count)]
    for levels in _sequences(np.array([frames.scale[rows].mean() for rows in among])):
        for rows in _chains(center, [among[each] for each in levels]):
            for ordered in (rows, rows[::-1]):
                ring = _fitted(shape, frames[ordered], symbol, error)
                if ring is not None:
                    yield ordered, ring


def _sequences(scales: Floats) -> list[list[int]]:
    """Runs of scales (k,), falling, with one ratio or one difference, the longest first; none that
    is part of one before.
    """
    found: list[list[int]] = []
    for start in range(len(scales) - 2):
        for second in range(start + 1, min(start + 1 + AHEAD, len(scales))):
            found += [_run(scales, start, second, by_ratio) for by_ratio in (False, True)]
    kept: list[list[int]] = []
    for run in sorted(found, key=lambda each: (-len(each), each)):
        if len(run) >= FEWEST and not any(set(run) <= set(other) for other in kept):
            kept.append(run)
    return kept


def _run(scales: Floats, start: int, second: int, by_ratio: bool) -> list[int]:
    """The scales that go on as the first two do."""
    run = [start, second]
    ratio, step = scales[second] / scales[start], scales[second] - scales[start]
    while True:
        wanted = scales[run[-1]] * ratio if by_ratio else scales[run[-1]] + step
        near = int(np.argmin(np.abs(scales - wanted)))
        if near <= run[-1] or abs(scales[near] - wanted) > LEVEL * scales[near]:
            return run
        run.append(near)


def _chains(center: Floats, levels: list[Integers]) -> Iterator[Integers]:
    """For each copy of the first scale the nearest of the next one, and so on."""
    for first in levels[0].tolist():
        rows = [first]
        for level in levels[1:]:
            away = np.linalg.norm(center[level] - center[rows[-1]], axis=1)
            rows.append(int(level[np.argmin(np.round(away, 9))]))
        yield np.array(rows, np.int64)


def _fitted(shape: Figure, frames: Frames, symbol: int, error: float) -> Ring | None:
    """The row that all of these are, in this order; None if it is off."""
    reach = float(np.abs(shape.probes).max()) * float(frames.scale.max())
    for growth in _growths(frames.scale, error / (4 * max(reach, error) * len(frames))):
        ring = _placed(frames, symbol, growth, error)
        if ring is not None:
            made = placements(ring)[0][1]
            if misses(shape, probed(shape, made), frames)[0].max() <= error:
                return ring
    return None


def _growths(scales: Floats, room: float) -> list[_Growth]:
    """The ratio and the difference that fit scales (n,) best."""
    index = np.arange(len(scales), dtype=np.float64)
    ratio = float(np.exp(np.polyfit(index, np.log(scales), 1)[0]))
    gain = float(np.polyfit(index, scales / scales[0], 1)[0])
    return [_Growth(shortest(ratio, room), 0.0), _Growth(1.0, shortest(gain, room))]


def _placed(frames: Frames, symbol: int, growth: _Growth, error: float) -> Ring | None:
    """The row with these scales whose members stand where the frames do, axis by axis."""
    count = len(frames)
    index = np.arange(count, dtype=np.float64)
    ways = [[index * 0], [index], [growth.factors(count)], [growth.factors(count), index]]
    center, begin, rise = np.zeros(3), np.zeros(3), np.zeros(3)
    for axis in range(3):
        told = _explained(frames.position[:, axis], ways[: count if count > 3 else 3], error / 4)
        if told is None:
            return None
        way, (still, *slopes) = told
        swings = slopes[0] if way >= 2 else 0.0
        rise[axis] = shortest(slopes[-1], error / (8 * count)) if way in (1, 3) else 0.0
        center[axis] = shortest(still, error / 16)
        begin[axis] = center[axis] + swings
    first = Frames(begin[None], frames.rotation[:1], frames.hand[:1], frames.scale[:1])
    length = float(np.linalg.norm(rise))
    axis_of = rise / length if length > 0 else np.array([0.0, 0.0, 1.0])
    return Ring(symbol, first, count, center, axis_of, 0.0, length, growth.ratio, gain=growth.gain)


def _explained(
    values: Floats, ways: list[list[Floats]], error: float
) -> tuple[int, list[float]] | None:
    """The first of the ways in which values (n,) are a sum of columns, and how much of each."""
    for number, columns in enumerate(ways):
        known = np.stack([np.ones(len(values)), *columns], axis=1)
        solved = np.linalg.lstsq(known, values, rcond=1e-12)[0]
        if np.abs(known @ solved - values).max() <= error:
            return number, [float(each) for each in solved]
    return None
