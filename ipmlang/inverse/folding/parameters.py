"""Which numbers of a rule are parameters, and which of the others follow one of these.

Takes a table of the numbers of several stretches, a line for each; gives for every column how it is
said: a number, or first + slope * parameter. Nothing here knows rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ast
from ipmlang.inverse.numbers import linear, shortest

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]
PLAIN = 3  # decimals that the slope of a number that follows another one may have
SURE = 3  # stretches from which a slope other than 1 is believed
LEADERS = 2  # numbers that follow each other of which one becomes the parameter


@dataclass(frozen=True, slots=True)
class Said:
    """How a number of a rule is written: first + slope * parameter, -1 for none."""

    first: float
    parameter: int = -1
    slope: float = 0.0

    def expr(self, names: Sequence[str]) -> ast.Expr:
        """As an expression of the parameters so called."""
        if self.parameter < 0:
            return ast.Number(self.first)
        return linear(self.first, self.slope, names[self.parameter], (0.0, 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class Parameters:
    """first, parameter, slope: (h,) how each column is said, see `Said`; used: the columns that are
    parameters, and the sign of each.
    """

    first: Floats
    parameter: Integers
    slope: Floats
    used: list[int]
    signs: Floats

    @property
    def said(self) -> tuple[Said, ...]:
        """How each column is said."""
        columns = (self.first, self.parameter, self.slope)
        return tuple(map(Said, *(each.tolist() for each in columns)))

    @property
    def words(self) -> tuple[Integers, Floats]:
        """(h,) tokens of every column's expression, and the number that it is, nan for none."""
        alone = self.parameter < 0
        tokens = np.where(alone, 1 + (self.first < 0), _tokens(self.first, self.slope))
        return tokens, np.where(alone, self.first, np.nan)


@dataclass(frozen=True, slots=True)
class Means:
    """How many parameters there may be, and the tokens for all that they take: brackets around
    them, each by itself, and what is said with them beyond a token for each number.
    """

    most: int
    room: int
    brackets: int
    each: int

    @property
    def affordable(self) -> int:
        """How many parameters there can be at most."""
        return max(0, min(self.most, (self.room - self.brackets) // self.each))


def parameters(table: Floats, errors: Floats, varying: Flags, means: Means) -> Parameters | None:
    """How each column (k, h) is said; varying: (h,) columns that are not all equal by the errors
    (h,). None where the means do not suffice.
    """
    most, room = means.affordable, means.room - means.brackets
    waiting = np.flatnonzero(varying)
    if len(waiting) and not most:
        return None
    own = table[:, waiting]
    close = _collinear(own, errors[waiting])
    if _directions(close) > most:
        return None
    first = table[0].copy()
    parameter, slope = np.full(len(first), -1, np.int64), np.zeros(len(first))
    used: list[int] = []
    signs: list[float] = []
    left = np.ones(len(waiting), np.bool_)
    while left.any():
        room -= means.each
        if len(used) >= most or room < 0:
            return None
        near = np.flatnonzero(close[int(left.argmax())] & left)
        found = _followers(own, errors[waiting], near)
        column = found.leader
        sign = -1.0 if (own[:, column] < 0).sum() * 2 > len(own) else 1.0
        for other, value, step in found.others:
            first[waiting[other]], slope[waiting[other]] = value, step * sign
            parameter[waiting[other]] = len(used)
            left[other] = False
        room -= found.more
        used.append(int(waiting[column]))
        signs.append(sign)
    if used and room < 0:
        return None
    return Parameters(first, parameter, slope, used, np.array(signs))


def _directions(close: Flags) -> int:
    """How many parameters there are at least: columns of which none follows another one."""
    left, count = np.ones(len(close), np.bool_), 0
    while left.any():
        left &= ~close[int(left.argmax())]
        count += 1
    return count


def _collinear(table: Floats, errors: Floats) -> Flags:
    """(w, w) which columns could be first + slope * another one."""
    if len(table) < SURE:
        apart = np.abs(table[-1] - table[0])
        return np.asarray(np.abs(apart[:, None] - apart) <= errors, np.bool_)
    spread = table - table.sum(axis=0) / len(table)
    products = spread.T @ spread
    sizes = np.diag(products)
    rest = sizes[None, :] - products**2 / np.maximum(sizes, 1e-300)[:, None]
    near = rest <= len(table) * errors[None, :] ** 2 + 1e-12 * sizes[None, :]
    return np.asarray(near | np.eye(len(sizes), dtype=np.bool_), np.bool_)


@dataclass(frozen=True, slots=True, eq=False)
class _Followers:
    """A column that is a parameter; others: those that follow it, itself too, each with what it
    begins with and its slope; more: tokens that these take beyond one for each.
    """

    leader: int
    others: list[tuple[int, float, float]]
    more: int


def _followers(table: Floats, errors: Floats, near: Integers) -> _Followers:
    """Of the columns that follow each other, the one that is best as a parameter, and those that
    are first + slope * this one where that is shorter than another parameter. Slopes are plain
    numbers; two stretches tell none but 1 and -1.
    """
    count = len(table)
    if len(near) == 1:
        return _Followers(int(near[0]), [(int(near[0]), 0.0, 1.0)], 0)
    leaders, others, room = table[:, near[:LEADERS]], table[:, near], errors[near]
    spread = leaders - leaders.sum(axis=0) / count
    slopes = (spread.T @ others) / (spread * spread).sum(axis=0)[:, None]
    places = range(PLAIN + 1 if count >= SURE else 1)
    rounded = np.array([slopes.round(decimals) for decimals in places])  # (places, leaders, n)
    rest = others.T - rounded[..., None] * leaders.T[:, None, :]  # (places, leaders, n, k)
    room = room - (rest.max(axis=-1) - rest.min(axis=-1))
    sound = (room >= 0) & (rounded != 0)
    if count < SURE:
        sound &= np.abs(rounded) == 1
    own = np.arange(len(leaders.T))
    plainest = sound.argmax(axis=0), own[:, None], np.arange(len(near))
    slope = rounded[plainest]
    mean = rest[plainest].sum(axis=-1) / count
    off = np.maximum(room[plainest], errors[near] / 8)
    firsts = np.where(np.abs(mean) <= np.minimum(off, 0.5), 0.0, mean)  # near enough for tokens
    tokens = _tokens(firsts, slope)
    follows = sound.any(axis=0) & (tokens <= count + 2)
    follows[own, own], tokens[own, own] = True, 1
    below, above = (leaders < 0).sum(axis=0), (leaders > 0).sum(axis=0)
    cost = (tokens * follows).sum(axis=1) + count + 1 + np.minimum(below, above)
    best = int(np.argmin(cost - (count + 2) * follows.sum(axis=1)))
    found = [(int(near[best]), 0.0, 1.0)]
    for which in np.flatnonzero(follows[best]).tolist():
        if which != best:
            value = shortest(float(mean[best, which]), float(off[best, which]))
            found.append((int(near[which]), value, float(slope[best, which])))
    more = int(((tokens[best] - 1 - (slope[best] < 0)) * follows[best]).sum())
    return _Followers(int(near[best]), found, more)


def _tokens(first: Floats, slope: Floats) -> Integers:
    """Tokens of first + slope * parameter."""
    tokens = 3 - 2 * (np.abs(slope) == 1) + np.where(first == 0, slope < 0, 2 + (first < 0))
    return np.asarray(tokens, np.int64)
