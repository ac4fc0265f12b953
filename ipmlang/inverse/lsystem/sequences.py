"""Longest sequences of one symbol whose steps are constant or change evenly (section 5.3).

Takes an arrangement; gives runs of neighbours in paint order with a pattern fitted over the whole
run: rows, rings, spirals, scaled sequences. Whether a run is exact enough is checked by whoever
uses it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.fits import (
    Fits,
    Sequence,
    fit_even,
    fit_polar,
    fit_rooted,
    fit_turtle,
    fit_turtle_linear,
    worst,
)
from ipmlang.inverse.lsystem.frames import Floats, Frames, compose, frames, inverse, unit, wrap
from ipmlang.inverse.lsystem.patterns import NOTHING, Pattern
from ipmlang.inverse.lsystem.regular import further_turned, regular_frames, stretches
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers

Booleans = NDArray[np.bool_]

LEAST = 3  # members of a run
LEAST_CURVED = 6  # members of a run whose steps change
LEAST_ROOTED = 8
MOST_RUNS = 100  # of one kind in one round
TWICE = 2.0  # a symbol may be in two runs of one pattern


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """`count` neighbours from row `first` on, a pattern fitted to them, and the world frame of the
    sequence.
    """

    first: int
    count: int
    pattern: Pattern
    lead: Frames


@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """What the fits look at, a row for each symbol: regular frames; stretch: equal for neighbours
    of one symbol; reach: extents; free: without a heading; slack: units; fits: what was fitted.
    """

    regular: Frames
    stretch: Integers
    reach: Floats
    free: Booleans
    slack: float
    fits: Fits

    def together(self, count: int) -> Booleans:
        """(n - count + 1,) whether so many rows from each on are of one stretch and handedness."""
        last = len(self.stretch) - count + 1
        hand = self.regular.handedness
        fits = self.stretch[count - 1 :] == self.stretch[:last]
        for k in range(1, count):
            fits &= hand[k : last + k] == hand[:last]
        return np.asarray(fits, np.bool_)

    def sequence(self, first: int, count: int) -> Sequence:
        """The members of a run."""
        rows = slice(first, first + count)
        return Sequence(
            self.regular[rows], float(self.reach[first]), bool(self.free[first]), self.slack
        )


def find_runs(
    alphabet: Alphabet,
    arrangement: Arrangement,
    fits: Fits | None = None,
    tokens: Floats | None = None,
    least: float = 1.0,
) -> list[Run]:
    """All longest runs of three members or more, rows before rings before spirals; fits: what was
    fitted in earlier rounds, which this one adds to; tokens: (n,) of each symbol's placement: of
    symbols that take less than `least` in all, no runs are needed.
    """
    stretch = stretches(arrangement)
    rows = np.flatnonzero(np.bincount(stretch)[stretch] >= LEAST)
    if tokens is not None and len(rows) <= 2 * MOST_RUNS:  # of more, only the longest are looked at
        symbol = arrangement.symbol[rows]
        rows = rows[TWICE * np.bincount(symbol, tokens[rows])[symbol] >= least]
    if not len(rows):
        return []
    stretch, string = stretch[rows], arrangement[rows]
    field = Field(
        regular_frames(alphabet, string, stretch),
        stretch,
        alphabet.radii[string.symbol],
        alphabet.frees[string.symbol],
        3 * alphabet.tolerance,
        Fits() if fits is None else fits,
    )
    runs = list(_even_runs(field))
    runs += _listed_runs(field, alphabet.tolerance)
    runs += _turtle_runs(field)
    runs += _polar_runs(field)
    for turned, those in further_turned(alphabet, string.symbol, field.regular, rows):
        apart = np.where(those, stretch, -1 - np.arange(len(stretch)))
        runs += _polar_runs(replace(field, regular=turned, stretch=apart))
    runs += _round_runs(field)
    return [replace(run, first=int(rows[run.first])) for run in runs]


def _blocks(fits: Booleans, more: int) -> Iterator[tuple[int, int]]:
    """(first row, count of rows) of maximal blocks of windows that all fit; a window covers `more`
    rows beyond its first. Where there are very many, the longest: what is short and comes again is
    found as a motif, whose body is searched in turn.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[0], fits.astype(np.int8), [0]])))
    starts, sizes = edges[::2], edges[1::2] - edges[::2]
    if len(starts) > MOST_RUNS:
        longest = np.sort(np.argsort(-sizes, kind="stable")[:MOST_RUNS])
        starts, sizes = starts[longest], sizes[longest]
    for start, size in zip(starts.tolist(), sizes.tolist(), strict=True):
        yield start, size + more


def _run(first: int, count: int, fitted: tuple[Pattern, Frames] | None) -> Iterator[Run]:
    if fitted is not None:
        yield Run(first, count, *fitted)


def _unrolled(field: Field) -> Floats:
    """(n,) angles without jumps of a full turn between neighbours."""
    angle = field.regular.angle
    if not len(angle):
        return angle
    return np.asarray(angle[0] + np.concatenate([[0.0], np.cumsum(wrap(np.diff(angle)))]))


# -------------------------------------------------------------------------- rows


def _even_runs(field: Field) -> Iterator[Run]:
    """Position, angle and scale are polynomials in the index: differences vanish."""
    angle = _unrolled(field)
    arm = np.maximum(field.reach * field.regular.scale, field.slack)
    columns = (
        (field.regular.x, np.ones_like(arm)),
        (field.regular.y, np.ones_like(arm)),
        (angle, np.deg2rad(arm)),
        (field.regular.scale, field.reach),
    )
    for degree, least in ((1, 3), (2, LEAST_CURVED)):
        if len(angle) < least:
            continue
        fits = field.together(degree + 2)
        for value, weight in columns:
            room = field.slack * (1 if degree == 1 else 2)
            fits &= np.abs(np.diff(value, degree + 1)) * weight[: len(fits)] <= room
        for first, count in _blocks(fits, degree + 1):
            if count >= least:
                yield from _run(
                    first, count, field.fits(fit_even, field.sequence(first, count), degree)
                )


def _listed_runs(field: Field, slack: float) -> Iterator[Run]:
    """Members that stand alike on a straight line, at uneven steps."""
    regular = field.regular
    move = np.diff(regular.position)
    alike = field.together(2)
    alike &= np.deg2rad(np.abs(wrap(np.diff(regular.angle)))) * field.reach[1:] <= slack
    alike &= np.abs(np.diff(regular.scale)) * field.reach[1:] <= slack
    turned = move[1:] * move[:-1].conj()
    length = np.abs(move)
    straight = np.abs(turned.imag) <= slack * np.maximum(length[1:], length[:-1])
    ahead = (turned.real > 0) & (np.minimum(length[1:], length[:-1]) > 10 * slack)
    for start, count in _blocks(alike[1:] & alike[:-1] & straight & ahead, 2):
        if count < 4 or np.ptp(length[start : start + count - 1]) <= 3 * slack:
            continue
        at = regular.position[start : start + count]
        heading = float(np.angle(at[-1] - at[0], deg=True))
        scale = float(regular.scale[start])
        along = (at - at[0]) * np.exp(-1j * np.deg2rad(heading)) / scale
        steps = np.diff(along.real)
        if _periodic(steps, 6 * slack / scale):
            continue
        hand = int(regular.handedness[start])
        # In a mirrored frame x points the other way.
        turn = heading if hand > 0 else heading - 180.0
        rest = 0.0 if field.free[start] else hand * float(wrap(regular.angle[start] - turn))
        lead = frames(at[:1], turn, scale, hand)
        pattern = Pattern("listed", NOTHING, steps=tuple(steps.tolist()), rest=rest)
        yield Run(start, count, pattern, lead)


def _periodic(steps: Floats, slack: float) -> bool:
    """Whether uneven steps come again and again: a row of groups says that better."""
    most = len(steps) // 3
    return any(
        bool(np.all(np.abs(steps[period:] - steps[:-period]) <= slack))
        for period in range(2, most + 1)
    )


# ------------------------------------------------------------------------ turtle


def _turtle_runs(field: Field) -> Iterator[Run]:
    """Steps from member to member constant, or linear in the index."""
    regular = field.regular
    step = compose(inverse(regular[:-1]), regular[1:])
    size = regular.scale[:-1]
    distance = np.abs(step.position)
    arm = np.maximum(distance, field.reach[:-1]) * size
    alpha = np.where(distance * size <= field.slack, 0.0, np.angle(step.position, deg=True))
    values = (alpha, distance, step.scale, wrap(step.angle - alpha))
    weights = (np.deg2rad(arm), size, arm, np.deg2rad(arm))
    inner = (field.stretch[1:] == field.stretch[:-1]) & ~field.free[1:]
    hand = step.handedness
    constant = inner[1:] & inner[:-1] & (hand[1:] == hand[:-1])
    linear = (constant[1:] & constant[:-1]) & (hand[2:] > 0)
    for column, (value, weight) in enumerate(zip(values, weights, strict=True)):
        first = np.diff(value) if column in (1, 2) else wrap(np.diff(value))
        constant &= np.abs(first) * weight[1:] <= field.slack
        linear &= np.abs(np.diff(first)) * weight[1:-1] <= 2 * field.slack
    for start, count in _blocks(constant, 2):
        yield from _run(start, count, field.fits(fit_turtle, field.sequence(start, count)))
    for start, count in _blocks(linear, 3):
        if count >= LEAST_CURVED and not constant[start : start + count - 2].all():
            yield from _run(
                start, count, field.fits(fit_turtle_linear, field.sequence(start, count))
            )


# ------------------------------------------------------------------------- polar


def _polar_runs(field: Field) -> Iterator[Run]:
    """Members that turn evenly about a centre, at a distance that is constant, grows evenly, or
    with the root of the index.
    """
    if len(field.stretch) < 3:
        return
    turn = np.diff(_unrolled(field))
    arm = np.deg2rad(np.maximum(field.reach * field.regular.scale, field.slack))[1:]
    even = field.together(3) & ~field.free[1:-1] & (np.abs(turn[1:]) * arm[1:] > field.slack)
    even &= np.abs(np.diff(turn)) * arm[1:] <= field.slack
    grown = np.abs(np.diff(field.regular.scale, 2)) * field.reach[1:-1] <= field.slack
    even &= grown
    p = field.regular.position
    for start, count in _blocks(even, 2):
        omega = unit(np.array(float(np.mean(turn[start : start + count - 1]))))
        inside = p[start : start + count]
        once = inside[1:] - omega * inside[:-1]
        ring = np.abs(np.diff(once)) <= 2 * field.slack
        for first, size in _blocks(ring, 2):
            found = field.fits(fit_polar, field.sequence(start + first, size), False)
            yield from _run(start + first, size, found)
        if count < LEAST_CURVED:
            continue
        grows = np.abs(np.diff(once[1:] - omega * once[:-1])) <= 6 * field.slack
        for first, size in _blocks(grows, 3):
            if size >= LEAST_CURVED and not ring[first : first + size - 2].all():
                members = field.sequence(start + first, size)
                found = field.fits(fit_polar, members, True)
                if found is not None and worst(members, found) <= field.slack:
                    yield Run(start + first, size, *found)
        if count >= LEAST_ROOTED and not grows.all() and not ring.any():
            yield from _run(start, count, field.fits(fit_rooted, field.sequence(start, count)))


def _round_runs(field: Field) -> Iterator[Run]:
    """Rings of what has no heading or keeps it: the way from each to the next turns evenly."""
    regular = field.regular
    move = np.diff(regular.position)
    heading = np.angle(move, deg=True)
    turn = wrap(np.diff(heading))
    length = np.abs(move)
    arm = np.maximum(field.reach * regular.scale, field.slack)
    still = np.deg2rad(np.abs(wrap(np.diff(regular.angle)))) * arm[1:] <= field.slack
    still &= np.abs(np.diff(regular.scale)) * field.reach[1:] <= field.slack
    same = field.together(3) & (still | field.free[1:])[1:] & (still | field.free[1:])[:-1]
    same &= (length[1:] > field.slack) & (np.abs(np.diff(length)) <= field.slack)
    same &= np.abs(turn) > 1e-3
    bent = same[1:] & same[:-1]
    bent &= np.deg2rad(np.abs(wrap(np.diff(turn)))) * length[2:] <= 2 * field.slack
    for start, count in _blocks(bent, 3):
        around = float(turn[start] + np.mean(wrap(turn[start : start + count - 2] - turn[start])))
        found = field.fits(fit_polar, field.sequence(start, count), False, around)
        yield from _run(start, count, found)
