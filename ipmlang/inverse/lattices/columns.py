"""What else follows from where a member stands: angle, scale and handedness as columns.

Takes the frames of members that are known to lie on a lattice, what maps their symbol onto itself,
and their nodes; says of each column whether it is regular (a polynomial of the node, or of scale
its logarithm), alternates, or is arbitrary. Of all equivalent frames of a member the one nearest to
the rule is chosen. Few members that break a rule count as strays. Position is not looked at.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lattices.cloud import Integers
from ipmlang.inverse.lsystem.frames import Floats, Frames

Mask: TypeAlias = NDArray[np.bool_]
STRAYS = 0.2  # of the members may break the rule of a column
LEAST = 5  # members with strays
ROUNDS = 12
NOTHING = (0.0, 0.0, 0.0, 0.0)
PARITIES: tuple[tuple[int, int], ...] = ((1, 0), (0, 1), (1, 1))


@dataclass(frozen=True, slots=True)
class Column:
    """value(i, j) = t0 + t1 i + t2 j + t3 i², its exponential if geometric, plus `other` where
    parity · (i, j) is odd. arbitrary: t0 is only a middle value. exact: no member is off.
    """

    kind: Literal["regular", "alternating", "arbitrary"]
    terms: tuple[float, float, float, float]
    other: float = 0.0
    parity: tuple[int, int] = (0, 0)
    geometric: bool = False
    exact: bool = True

    def at(self, index: Integers) -> Floats:
        """(m,) values of nodes (m, 2).

        >>> Column("regular", (1.0, 0.5, 0.0, 0.0)).at(np.array([[0, 0], [2, 7]])).tolist()
        [1.0, 2.0]
        """
        i, j = index.T.astype(np.float64)
        t0, t1, t2, t3 = self.terms
        value = t0 + t1 * i + t2 * j + t3 * i * i
        value = value + self.other * odd(index, self.parity)
        return np.asarray(np.exp(value) if self.geometric else value, np.float64)


Rule: TypeAlias = tuple[Column, Mask]  # and who follows it


@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """angle (degrees), scale and handedness of the members; chosen: (m,) their frames, with the
    position untouched; keep: (m,) which follow every column that has a rule.
    """

    angle: Column
    scale: Column
    handedness: Column
    chosen: Frames
    keep: Mask


@dataclass(frozen=True, slots=True, eq=False)
class Slack:
    """(m,) how far angles (degrees) and scales may be off where exact, and with noise."""

    angle: tuple[Floats, Floats]
    scale: tuple[Floats, Floats]


def odd(index: Integers, parity: tuple[int, int]) -> Floats:
    """(m,) 1 where parity · (i, j) is odd, else 0."""
    return np.asarray((index @ np.array(parity)) % 2, np.float64)


def fit_columns(
    given: Frames, stabiliser: Frames, free: bool, index: Integers, slack: Slack, turn: float
) -> Columns:
    """Columns of members (m,) on nodes (m, 2); turn: degrees by which the lattice itself turns from
    i to i + 1, 0 for none: members that turn along come before others.
    """
    given = _one_hand(given, stabiliser, free)
    hand = _handedness(given, index)
    scale, kept = _scale(given.scale, index, slack)
    period = 360.0 / max(1, int((stabiliser.handedness > 0).sum()))
    if free:
        angle, angles, turned = Column("regular", NOTHING), np.zeros(len(given)), kept | True
    else:
        angle, angles, turned = _angle(given.angle, index, slack, turn, period, hand)
    chosen = Frames(given.x, given.y, angles, given.scale, given.handedness)
    return Columns(angle, scale, hand, chosen, kept & turned)


def _one_hand(given: Frames, stabiliser: Frames, free: bool) -> Frames:
    """Unmirrored frames where the symbol is its own mirror image."""
    mirrors = np.flatnonzero(stabiliser.handedness < 0)
    if not free and not len(mirrors):
        return given
    angle = given.angle
    if len(mirrors):
        there = given.handedness < 0
        angle = np.where(there, angle - float(stabiliser.angle[mirrors[0]]), angle)
    return Frames(given.x, given.y, angle, given.scale, np.ones(len(given), np.int8))


def _handedness(given: Frames, index: Integers) -> Column:
    first = float(given.handedness[0])
    if (given.handedness == first).all():
        return Column("regular", (first, 0.0, 0.0, 0.0))
    for parity in PARITIES if len(given) >= 4 else ():
        turned = odd(index, parity) == 1
        for start in (1.0, -1.0):
            if (given.handedness == np.where(turned, -start, start)).all():
                return Column("alternating", (start, 0.0, 0.0, 0.0), -2 * start, parity)
    common = 1.0 if given.handedness.sum() >= 0 else -1.0
    return Column("arbitrary", (common, 0.0, 0.0, 0.0), exact=False)


# ------------------------------------------------------------------------ scale


def _scale(value: Floats, index: Integers, slack: Slack) -> Rule:
    everyone = np.ones(len(value), np.bool_)
    for number, room in enumerate(slack.scale):
        for geometric in (False, True):
            shown = np.log(value) if geometric else value
            given = room / value if geometric else room
            made = _first_rule(shown, index, given)
            if made is not None:
                return replace(made[0], geometric=geometric, exact=number == 0), made[1]
    return Column("arbitrary", (float(np.median(value)), 0.0, 0.0, 0.0), exact=False), everyone


def _whole(every: Iterable[Rule | None]) -> Rule | None:
    """The first rule that all members follow, or else the first that nearly all do: a turn that is
    slightly wrong makes strays of the last members.
    """
    first: Rule | None = None
    for made in every:
        if made is not None and made[1].all():
            return made
        first = first or made
    return first


def _first_rule(value: Floats, index: Integers, room: Floats) -> Rule | None:
    """The simplest rule of numbers, and who follows it."""
    for parity, powers in _designs(index):
        made = _rule(value, index, room, powers, parity)
        if made is not None:
            return made
    return None


def _designs(index: Integers) -> Iterator[tuple[tuple[int, int], tuple[int, ...]]]:
    """Parity and powers used, simplest first: 0 for 1, 1 for i, 2 for j, 3 for i²."""
    wide = bool(index[:, 1].any())
    linear = (0, 1, 2) if wide else (0, 1)
    yield (0, 0), (0,)
    yield (0, 0), linear
    parities = PARITIES if wide else PARITIES[:1]
    for parity in parities:
        yield parity, (0,)
    if not wide:
        yield (0, 0), (0, 1, 3)
    for parity in parities:
        yield parity, linear


def _rule(
    value: Floats, index: Integers, room: Floats, powers: tuple[int, ...], parity: tuple[int, int]
) -> Rule | None:
    """Least squares, then with strays left out; None unless nearly all follow."""
    alternates = parity != (0, 0)
    terms = len(powers) + alternates
    spare = 2 if alternates or 3 in powers else 1
    if len(value) < terms + spare:
        return None
    i, j = index.T.astype(np.float64)
    every = [np.ones(len(i)), i, j, i * i]
    columns = [every[k] for k in powers] + ([odd(index, parity)] if alternates else [])
    design = np.stack(columns, axis=1)
    solved, keep = _robust(design, value, room)
    if keep.sum() < max((1 - STRAYS) * len(value), terms + spare):
        return None
    if not keep.all() and keep.sum() < LEAST:
        return None
    full = np.zeros(4)
    full[list(powers)] = solved[: len(powers)]
    kind: Literal["regular", "alternating"] = "alternating" if alternates else "regular"
    t0, t1, t2, t3 = full.tolist()
    return Column(kind, (t0, t1, t2, t3), float(solved[-1]) if alternates else 0.0, parity), keep


def _robust(design: Floats, value: Floats, room: Floats) -> tuple[Floats, Mask]:
    """Least squares; where members are off, least absolute errors first, then without strays."""
    solved = _least(design, value)
    keep = np.abs(value - design @ solved) <= room
    if keep.all() or len(value) < LEAST:
        return solved, keep
    for _ in range(ROUNDS):
        weight = 1 / np.sqrt(np.maximum(np.abs(value - design @ solved), room / 4))
        solved = _least(design * weight[:, None], value * weight)
    keep = np.abs(value - design @ solved) <= 1.5 * room
    if keep.sum() >= design.shape[1]:
        solved = _least(design[keep], value[keep])
        keep = np.abs(value - design @ solved) <= room
    return solved, keep


def _least(design: Floats, value: Floats) -> Floats:
    return np.asarray(np.linalg.lstsq(design, value, rcond=None)[0], np.float64)


# ------------------------------------------------------------------------ angle


def _angle(
    angle: Floats, index: Integers, slack: Slack, turn: float, period: float, hand: Column
) -> tuple[Column, Floats, Mask]:
    """The rule of the angles, the equivalent angles nearest to it, and who follows it."""
    for number, room in enumerate(slack.angle):
        every = (
            _turning(angle, index, room, slopes, period, hand)
            for slopes in _slopes(angle, index, turn, period)
        )
        made = _whole(every)
        if made is not None:
            column = replace(made[0], exact=number == 0)
            near = angle + period * np.round((column.at(index) - angle) / period)
            return column, near, made[1]
    everyone = np.ones(len(angle), np.bool_)
    return Column("arbitrary", NOTHING, exact=False), _within(angle, period), everyone


def _within(angle: Floats, period: float) -> Floats:
    """The equivalent angle in (-period / 2, period / 2]."""
    return np.asarray(angle - period * np.ceil(angle / period - 0.5), np.float64)


def _slopes(
    angle: Floats, index: Integers, turn: float, period: float
) -> Iterator[tuple[float, float, float]]:
    """Guesses of turn by i, by j and by i², likely ones first."""
    if turn:
        yield turn, 0.0, 0.0
    yield 0.0, 0.0, 0.0
    by_i, bend = _stepped(angle, index[:, 0], index[:, 1], period)
    by_j, _ = _stepped(angle, index[:, 1], index[:, 0], period)
    yield by_i, by_j, 0.0
    if turn:
        yield turn, by_j, 0.0
    if bend and len(angle) > LEAST:
        first = by_i - bend * float(np.median(2 * index[:, 0] + 1)) / 2
        yield first, by_j, bend / 2


def _stepped(angle: Floats, along: Integers, line: Integers, period: float) -> tuple[float, float]:
    """The usual turn from one node to the next on a line, and how that turn itself changes."""
    order = np.lexsort((along, line))
    next_to = (np.diff(along[order]) == 1) & (np.diff(line[order]) == 0)
    step = np.diff(angle[order])
    steps = step[next_to]
    if not len(steps):
        return 0.0, 0.0
    usual = _usual(steps, period)
    twice = next_to[1:] & next_to[:-1]
    bends = np.diff(step)[twice]
    return usual, _usual(bends, period) if len(bends) else 0.0


def _usual(value: Floats, period: float) -> float:
    """The middle of angles, each known up to the period."""
    mean = _mean(value, period)
    return mean + float(np.median(_within(value - mean, period)))


def _mean(value: Floats, period: float) -> float:
    return float(np.angle(np.exp(2j * np.pi * value / period).sum()) * period / (2 * np.pi))


def _turning(
    angle: Floats,
    index: Integers,
    room: Floats,
    slopes: tuple[float, float, float],
    period: float,
    hand: Column,
) -> Rule | None:
    """The simplest rule of what is left after a guessed turn."""
    by_i, by_j, bend = slopes
    i, j = index.T.astype(np.float64)
    left = angle - by_i * i - by_j * j - bend * i * i
    for parity, powers in _designs(index):
        if hand.kind == "alternating" and parity not in ((0, 0), hand.parity):
            continue
        if parity != (0, 0) and bend:
            continue
        near = np.empty(len(left))
        for side in (0, 1):
            rows = odd(index, parity) == side
            middle = _usual(left[rows], period) if rows.any() else 0.0
            near[rows] = _within(np.array(middle), period) + _within(left[rows] - middle, period)
        made = _rule(near, index, room, powers, parity)
        if made is not None:
            t0, t1, t2, t3 = made[0].terms
            terms = t0, t1 + by_i, t2 + by_j, t3 + bend
            other = float(_within(np.array(made[0].other), period))
            return replace(made[0], terms=terms, other=other), made[1]
    return None
