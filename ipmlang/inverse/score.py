"""Description length: how many tokens a placement, a rule or a sequence takes when printed.

The one measure that decides whether a rule pays. It follows `compiler.tokens`: a name, a number, a
sign, a mark or a bracket is one token. Nothing here prints or searches.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import Floats, Frames, compose, inverse, wrap
from ipmlang.inverse.lsystem.patterns import Pattern
from ipmlang.inverse.recursion.branching import Branching

Integers = NDArray[np.int64]

SMALL = 1e-9  # degrees or ratio: what is printed as nothing at all
HEAD = 2  # `Name -->`
EVEN = 1e-5  # degrees or ratio: what steps of one sequence may differ by
COUNTED = 3  # `(n)` on a use, and as much again on the head
LOOP = 9  # `repeat(i < n) { … }`
TREE = 2 * (HEAD + COUNTED + 4) + 10  # both rules of a branching structure of one twig, at least
TABLE_ROWS = 8  # fewer placements of one symbol are written out
INLINE_ROWS = 24  # a longer table goes to the parts file
AROUND = 6  # `[at(…) A]` about the numbers of a placement
TABLE = 23  # `table T(x, y) =` and `repeat(r in T) { [at(r.x, r.y) A] }`
DIGITS = 1.5  # of a number that weigh as much as a word or a mark: about five bits


def placement_tokens(placed: Frames, small: float) -> Integers:
    """(n,) tokens of `[at(x, y, angle, scale) mirror A]`, what is not needed left out.

    small: units, distances that are printed as 0.

    >>> from ipmlang.inverse.lsystem.frames import frames
    >>> placement_tokens(frames(np.array([0, 3 + 4j, -3j]), np.array([0.0, 0, 90])), 1e-9).tolist()
    [1, 8, 10]
    """
    angle, scaled = placed.angle, np.abs(placed.scale - 1) > SMALL
    turned, sign = np.abs(angle) > SMALL, angle < -SMALL
    moved = (np.abs(placed.x) > small) | (np.abs(placed.y) > small)
    at = np.add(placed.x < -small, placed.y < -small, dtype=np.int64)
    at += (turned | scaled) + (sign + (scaled + np.int64(5)))
    inside = np.where(moved, at, (turned + scaled.astype(np.int64)) * 4)
    inside += placed.handedness < 0
    return np.asarray(np.where(inside > 0, inside + 3, 1), np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Tabled:
    """Tokens of n placements as they are printed without any rule.

    alone: (n,) each by itself; total, spared: (n + 1,) sums, before each row, of those tokens and
    of what long runs of one symbol spare as rows of a table; begin, end: (n,) rows where the run of
    each begins and ends.
    """

    alone: Integers
    total: Floats
    spared: Floats
    begin: Integers
    end: Integers

    @property
    def needed(self) -> float:
        """Tokens of all."""
        return float(self.total[-1] - self.spared[-1])

    def saved(self, rows: Integers, counts: Integers) -> float:
        """Tokens of `counts` neighbours from each of the rows (k,) on, rising, which a rule takes
        out, less what the tables that it tears apart spared.
        """
        return float(self.saved_by(rows, counts, np.zeros(1, np.int64))[0])

    def saved_by(self, rows: Integers, counts: Integers, begin: Integers) -> Floats:
        """(g,) the same of rules one by one, each of the rows from one of `begin` (g,) on."""
        after = rows + counts
        parts = self.total[after] - self.total[rows] - self.spared[after] + self.spared[rows]
        other = np.ones(len(rows) + 1, np.bool_)
        other[1:-1] = self.begin[rows[1:]] != self.begin[rows[:-1]]
        other[begin] = True
        from_row = np.empty_like(after)
        from_row[1:] = after[:-1]
        from_row[other[:-1]] = self.begin[rows[other[:-1]]]
        torn = self._torn(from_row, rows)
        torn += self._torn(after, np.where(other[1:], self.end[rows], after))
        return np.asarray(np.add.reduceat(parts, begin) - np.add.reduceat(torn, begin))

    def _torn(self, begin: Integers, end: Integers) -> Floats:
        """What is no longer spared in each piece that is too short for a table."""
        short = (end > begin) & (end - begin < TABLE_ROWS)
        return np.where(short, self.spared[end] - self.spared[begin], 0.0)


def tabled(placed: Frames, other: NDArray[np.bool_], small: float) -> Tabled:
    """What placements take; other: (n - 1,) where the next one cannot be in the same table.

    A row of a table takes its share of what the table itself takes.

    >>> from ipmlang.inverse.lsystem.frames import frames
    >>> cost = tabled(frames(np.full(23, 3 + 4j)), np.zeros(22, np.bool_), 1e-9)
    >>> cost.saved(np.array([0]), np.array([23])), cost.saved(np.array([4]), np.array([15]))
    (115.0, 51.0)
    """
    alone = placement_tokens(placed, small)
    starts = np.flatnonzero(np.concatenate([[True], other])[: len(alone)])
    sizes = np.diff(np.append(starts, len(alone)))
    row = AROUND - 2 * (sizes <= INLINE_ROWS)
    share = np.where(sizes >= TABLE_ROWS, np.maximum(row - TABLE / sizes, 0.0), 0.0)
    spared = np.minimum(np.repeat(share, sizes), alone - 1.0)
    total, less = (np.concatenate([[0.0], np.cumsum(each)]) for each in (alone, spared))
    begin = np.repeat(starts, sizes)
    return Tabled(alone, total, less, begin, begin + np.repeat(sizes, sizes))


def followed_tokens(placed: Frames, rows: Integers, length: int, small: float) -> float:
    """Tokens of placements (k,) of one symbol that stands for `length` rows from each of `rows` on,
    where those that follow each other at even steps are said as a sequence.

    >>> from ipmlang.inverse.lsystem.frames import frames
    >>> row = frames(np.arange(20) * 7 + 3j)
    >>> followed_tokens(row, np.arange(20) * 2, 2, 1e-9), int(placement_tokens(row, 1e-9).sum())
    (25.0, 160)
    """
    each = placement_tokens(placed, small)
    if len(rows) < 3:
        return float(each.sum())
    step = compose(inverse(placed[:-1]), placed[1:])
    follows = np.diff(rows) == length
    even = follows[1:] & follows[:-1] & (step.handedness[1:] == step.handedness[:-1])
    even &= np.abs(np.diff(step.position)) * placed.scale[1:-1] <= 4 * small
    even &= np.abs(wrap(np.diff(step.angle))) <= EVEN
    even &= np.abs(np.diff(step.scale)) <= EVEN
    edges = np.flatnonzero(np.diff(np.concatenate([[0], even.astype(np.int8), [0]])))
    total = float(each.sum())
    for first, last in zip(edges[::2].tolist(), (edges[1::2] + 2).tolist(), strict=True):
        said = LOOP + float(each[first] + placement_tokens(step[first : first + 1], small)[0])
        total -= max(0.0, float(each[first:last].sum()) - said)
    return total


def sequence_tokens(pattern: Pattern) -> int:
    """Tokens of the body that makes a sequence, without its rule's head."""
    base, delta = pattern.base, pattern.delta
    inside = 4 * (abs(pattern.rest) > SMALL) + 6 * (pattern.inner != 0)
    more = 4 * sum(value != 0.0 for value in delta) + inside
    if pattern.kind == "even":
        steps = sum(abs(value) > SMALL for value in base)
        return LOOP + 3 + 4 + 2 * steps + more
    if pattern.kind == "listed":
        return LOOP + 6 + len(pattern.steps) + more
    if pattern.kind == "polar":
        further = abs(base[2]) > SMALL or pattern.rooted
        growing = 8 * (abs(base[3]) > SMALL)
        return LOOP + 3 + 6 + 4 + 4 * further + growing + 4 * pattern.upright + more
    neutral = (0.0, 0.0, 1.0, 0.0)
    used = sum(
        abs(t0 - rest) > SMALL or t1 != 0.0
        for t0, t1, rest in zip(base, delta, neutral, strict=True)
    )
    return LOOP + 3 + 4 * used + more + pattern.mirrored


def tree_tokens(branching: Branching) -> int:
    """Tokens of both rules of a branching structure, heads included."""
    total = TREE - 8
    for twig in branching.twigs:
        total += 8 + (twig.hand < 0)
        for first, slope, rest in zip(twig.first, twig.slope, (0.0, 0.0, 1.0, 0.0), strict=True):
            total += 4 * bool(abs(first - rest) > SMALL or slope) + 4 * bool(slope)
    return total
