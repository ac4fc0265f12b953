"""Longest sequences of one symbol whose steps are constant or change linearly (section 5.3).

Takes an arrangement; gives runs of neighbours in paint order with a pattern fitted by least squares
over the whole run: rows, rings, spirals, scaled sequences. Frames that symmetry leaves open are
chosen so that steps become regular. Whether a run is exact enough is checked by whoever uses it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import Floats, Frames, compose, frames, inverse, replaced, wrap
from ipmlang.inverse.lsystem.patterns import Pattern
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers

Booleans = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """`count` neighbours from row `first` on, a pattern fitted to them, and the world frame of the
    first member under that pattern.
    """

    first: int
    count: int
    pattern: Pattern
    lead: Frames


def find_runs(alphabet: Alphabet, arrangement: Arrangement) -> list[Run]:
    """All longest runs of three members or more, rows before rings before spirals."""
    if len(arrangement) < 3:
        return []
    stretch = _stretches(arrangement)
    regular = _regular(alphabet, arrangement, stretch)
    reach = np.array([each.radius for each in alphabet.definitions])[arrangement.symbol]
    slack = 3 * alphabet.tolerance
    free = np.array([each.free for each in alphabet.definitions])[arrangement.symbol]
    runs = list(_even_runs(regular, stretch, reach, slack))
    runs += _listed_runs(regular, stretch, free, reach, alphabet.tolerance)
    runs += _turtle_runs(regular, np.where(free, -1 - np.arange(len(free)), stretch), reach, slack)
    if free.any():
        runs += _ring_runs(regular, np.where(free, stretch, -1 - np.arange(len(free))), slack)
    return runs


def _stretches(arrangement: Arrangement) -> Integers:
    """(n,) equal for neighbours of the same symbol under the same effects."""
    symbol, effects = arrangement.symbol, arrangement.wrap
    new = (symbol[1:] != symbol[:-1]) | (effects[1:] != effects[:-1])
    return np.concatenate([[0], np.cumsum(new)])


def _regular(alphabet: Alphabet, arrangement: Arrangement, stretch: Integers) -> Frames:
    """World frames chosen among the equivalent ones: the handedness of the first in the stretch,
    then the smallest turn from one member to the next.
    """
    placed = _same_handed(alphabet, arrangement)
    inner = np.concatenate([[False], stretch[1:] == stretch[:-1]])
    order = np.array([_rotations(each.stabiliser, each.free) for each in alphabet.definitions])
    cell = 360.0 / np.maximum(order, 1)[arrangement.symbol]
    turn = np.diff(placed.angle, prepend=0.0)
    before = np.roll(placed.handedness, 1)
    local = before * turn
    least = local - cell * np.ceil(local / cell - 0.5 - 1e-9)
    moved = np.where(inner, before * (least - local), 0.0)
    total = np.cumsum(moved)
    starts = np.maximum.accumulate(np.where(inner, 0, np.arange(len(inner))))
    extra = total - total[starts]
    quarter = np.round(extra * placed.handedness / cell).astype(np.int64)
    return _spun(alphabet, arrangement.symbol, placed, quarter, order)


def _rotations(stabiliser: Frames, free: bool) -> int:
    return 1 if free else int((stabiliser.handedness > 0).sum())


def _same_handed(alphabet: Alphabet, arrangement: Arrangement) -> Frames:
    """Right-handed frames wherever the shape has a mirror; no turn for circles."""
    result = arrangement.placed
    for symbol in np.unique(arrangement.symbol[result.handedness < 0]).tolist():
        definition = alphabet[symbol]
        mirrors = np.flatnonzero(definition.stabiliser.handedness < 0)
        rows = np.flatnonzero((arrangement.symbol == symbol) & (result.handedness < 0))
        if len(mirrors):
            mirror = definition.stabiliser[mirrors[:1]]
            result = replaced(result, rows, compose(result[rows], mirror))
    free = np.array([each.free for each in alphabet.definitions])[arrangement.symbol]
    angle = np.where(free & (result.handedness > 0), 0.0, result.angle)
    return Frames(result.x, result.y, angle, result.scale, result.handedness)


def _spun(
    alphabet: Alphabet, symbol: Integers, placed: Frames, steps: Integers, order: Integers
) -> Frames:
    """Frames after so many of the symbol's own rotations."""
    changed = np.flatnonzero(steps % np.maximum(order, 1)[symbol])
    for each in np.unique(symbol[changed]).tolist():
        rows = changed[symbol[changed] == each]
        known = alphabet[each].stabiliser
        turns = known[known.handedness > 0]
        cell = 360.0 / len(turns)
        which = np.round((turns.angle % 360.0) / cell).astype(np.int64) % len(turns)
        by_step = np.argsort(which)
        placed = replaced(
            placed, rows, compose(placed[rows], turns[by_step[steps[rows] % len(turns)]])
        )
    return placed


def _blocks(fits: Booleans) -> Iterator[tuple[int, int]]:
    """Half-open ranges of consecutive true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], fits.astype(np.int8), [0]])))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)


def _even_runs(regular: Frames, stretch: Integers, reach: Floats, slack: float) -> Iterator[Run]:
    """Position, angle and scale linear in the index: second differences vanish."""
    turn = np.diff(regular.angle)
    angle = regular.angle[0] + np.concatenate([[0.0], np.cumsum(wrap(turn))])
    arm = np.maximum(reach * regular.scale, slack)
    fits = stretch[2:] == stretch[:-2]
    same = regular.handedness[2:] == regular.handedness[:-2]
    fits &= same & (regular.handedness[1:-1] == regular.handedness[:-2])
    for value, weight in (
        (regular.x, 1.0),
        (regular.y, 1.0),
        (angle, np.deg2rad(arm[1:-1])),
        (regular.scale, reach[1:-1]),
    ):
        fits &= np.abs(np.diff(value, 2)) * weight <= slack
    for first, end in _blocks(fits):
        yield _even_run(regular, angle, first, end - first + 2)


def _even_run(regular: Frames, angle: Floats, first: int, count: int) -> Run:
    rows = slice(first, first + count)
    index = np.arange(count) - (count - 1) / 2
    weight = index / float(index @ index)
    columns = regular.x[rows], regular.y[rows], angle[rows], regular.scale[rows]
    x, y, turn, scale = (float(weight @ column) for column in columns)
    middle = [float(column.mean()) for column in columns]
    back = (count - 1) / 2
    hand = int(regular.handedness[first])
    start = frames(
        np.array([complex(middle[0] - back * x, middle[1] - back * y)]),
        middle[2] - back * turn,
        middle[3] - back * scale,
        hand,
    )
    if start.scale[0] <= 0:
        start = regular[first : first + 1]
    step = complex(x, y) / start.factor[0]
    local = complex(step.real * hand, step.imag)
    base = (local.real, local.imag, turn * hand, scale / float(start.scale[0]))
    return Run(first, count, Pattern("even", base), start)


def _listed_runs(
    regular: Frames, stretch: Integers, free: Booleans, reach: Floats, slack: float
) -> Iterator[Run]:
    """Members that stand alike on a straight line, at uneven steps."""
    move = np.diff(regular.position)
    alike = (stretch[1:] == stretch[:-1]) & (np.diff(regular.handedness) == 0)
    alike &= np.deg2rad(np.abs(wrap(np.diff(regular.angle)))) * reach[1:] <= slack
    alike &= np.abs(np.diff(regular.scale)) * reach[1:] <= slack
    turned = move[1:] * move[:-1].conj()
    length = np.abs(move)
    straight = np.abs(turned.imag) <= slack * np.maximum(length[1:], length[:-1])
    ahead = (turned.real > 0) & (np.minimum(length[1:], length[:-1]) > 10 * slack)
    for start, end in _blocks(alike[1:] & alike[:-1] & straight & ahead):
        members = slice(start, end + 2)
        if end - start < 2 or np.ptp(length[start : end + 1]) <= 3 * slack:
            continue
        at = regular.position[members]
        heading = float(np.angle(at[-1] - at[0], deg=True))
        scale = float(regular.scale[start])
        along = (at - at[0]) * np.exp(-1j * np.deg2rad(heading)) / scale
        hand = int(regular.handedness[start])
        # In a mirrored frame x points the other way.
        turn = heading if hand > 0 else heading - 180.0
        rest = 0.0 if free[start] else hand * float(wrap(regular.angle[start] - turn))
        steps = tuple(np.diff(along.real).tolist())
        lead = frames(at[:1], turn, scale, hand)
        yield Run(start, end - start + 2, Pattern("listed", (rest, 0, 0, 0), steps=steps), lead)


def _turtle_runs(regular: Frames, stretch: Integers, reach: Floats, slack: float) -> Iterator[Run]:
    """Steps from member to member constant, or linear in the index."""
    step = compose(inverse(regular[:-1]), regular[1:])
    size = regular.scale[:-1]
    distance = np.abs(step.position)
    arm = np.maximum(distance, reach[:-1]) * size
    still = distance * size <= slack
    alpha = np.where(still, 0.0, np.angle(step.position, deg=True))
    beta = wrap(step.angle - alpha)
    values = (alpha, distance, step.scale, beta)
    weights = (np.deg2rad(arm), size, arm, np.deg2rad(arm))
    inner = stretch[1:] == stretch[:-1]
    same = inner[1:] & inner[:-1] & (step.handedness[1:] == step.handedness[:-1])
    constant, linear = same.copy(), (same[1:] & same[:-1] & (step.handedness[2:] > 0))
    for column, (value, weight) in enumerate(zip(values, weights, strict=True)):
        first = np.diff(value) if column in (1, 2) else wrap(np.diff(value))
        constant &= np.abs(first) * weight[1:] <= slack
        linear &= np.abs(np.diff(first)) * weight[1:-1] <= slack
    for start, end in _blocks(constant):
        base = _mean([value[start : end + 1] for value in values])
        mirrored = bool(step.handedness[start] < 0)
        pattern = Pattern("turtle", base, mirrored=mirrored)
        yield Run(start, end - start + 2, pattern, regular[start : start + 1])
    for start, end in _blocks(linear):
        if end - start >= 2:
            yield _linear_run(regular, values, start, end - start + 3)


def _mean(values: list[Floats]) -> tuple[float, float, float, float]:
    alpha, distance, scale, beta = (
        float(np.mean(value[0] + wrap(value - value[0])))
        if index in (0, 3)
        else float(value.mean())
        for index, value in enumerate(values)
    )
    return alpha, distance, scale, beta


def _linear_run(regular: Frames, values: tuple[Floats, ...], first: int, count: int) -> Run:
    rows = slice(first, first + count - 1)
    base, delta = [], []
    for index, value in enumerate(values):
        column = value[rows]
        if index in (0, 3):
            column = column[0] + np.concatenate([[0.0], np.cumsum(wrap(np.diff(column)))])
        slope, start = np.polyfit(np.arange(count - 1), column, 1)
        base.append(float(start))
        delta.append(float(slope))
    pattern = Pattern(
        "turtle", (base[0], base[1], base[2], base[3]), (delta[0], delta[1], delta[2], delta[3])
    )
    return Run(first, count, pattern, regular[first : first + 1])


def _ring_runs(regular: Frames, stretch: Integers, slack: float) -> Iterator[Run]:
    """Circles have no heading: it is the direction to the next one, and only turns count."""
    move = np.diff(regular.position)
    inner = stretch[1:] == stretch[:-1]
    distance = np.abs(move) / regular.scale[:-1]
    growth = regular.scale[1:] / regular.scale[:-1]
    heading = np.angle(move, deg=True)
    turn = wrap(np.diff(heading))
    size = regular.scale[:-1]
    same = inner[1:] & inner[:-1] & (np.abs(move[1:]) > slack)
    same &= np.abs(np.diff(distance)) * size[1:] <= slack
    same &= np.abs(np.diff(growth)) * np.abs(move[1:]) <= slack
    bent = same[1:] & same[:-1]
    bent &= np.deg2rad(np.abs(wrap(np.diff(turn)))) * np.abs(move[2:]) <= slack
    for start, end in _blocks(bent):
        steps = slice(start, end + 2)
        beta = float(turn[start] + np.mean(wrap(turn[start : end + 1] - turn[start])))
        base = (0.0, float(distance[steps].mean()), float(growth[steps].mean()), beta)
        lead = frames(
            regular.position[start : start + 1], heading[start : start + 1], regular.scale[start]
        )
        yield Run(start, end - start + 3, Pattern("turtle", base), lead)
