"""One coordinate of the places on a board: a formula in the node, exact for every place.

Takes the nodes of a raster and where things stand along x or along y; gives the shortest formula:
even steps, even steps with a few jumps, even steps rounded to the decimals of the file, or the last
resort, a number for each place. Where things have sizes and the file has rounded a point that lies
off the middle by as much, the size takes part in it. Nothing here prints.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from ipmlang.inverse.boards.raster import Raster
from ipmlang.inverse.least_largest import least_largest
from ipmlang.inverse.lsystem.curves import Booleans
from ipmlang.inverse.lsystem.frames import Floats
from ipmlang.inverse.lsystem.symbols import Integers
from ipmlang.inverse.numbers import shortest

DECIMALS = 4  # that a file may be rounded to
COARSE = 20.0  # times the room: what is finer cannot be told from no rounding
JUMPS = 8  # of a ladder are fewer
JUMP = 8  # tokens of one
LEAST_JUMPS = 2 * JUMP  # of any ladder: a number for each place takes more yet
ROUNDED = 8  # of `round(100 * (…)) / 100`
RESIDUAL = 3  # of `+ r.x`, and as many as there are places
DIGITS = 9  # decimals that are tried
NUDGE = 2.0  # times the room: what a size may be changed by to break a tie
TIE = 0.25  # of the room: how far from a tie places are kept, at most


Terms: TypeAlias = "tuple[float, float, float, float]"


@dataclass(frozen=True, slots=True)
class Ladder:
    """What is added from a step along the line (or from a line on, if `lines`) up to the next."""

    lines: bool
    starts: tuple[int, ...]
    adds: tuple[float, ...]

    def at(self, raster: Raster) -> Floats:
        """(n,) what is added to each place."""
        index = raster.j if self.lines else raster.i
        which = np.searchsorted(np.array(self.starts), index, side="right") - 1
        return np.asarray(np.array(self.adds)[which])


@dataclass(frozen=True, slots=True, eq=False)
class Coordinate:
    """first + along * i + down * j + aside * (j mod 2) + by * size, and what a ladder adds, rounded
    to `decimals` if there are any, and the rest (n,) of each place, if there is one.

    tokens: about what it takes beside even steps; size: (n,) sizes, nudged where a tie in rounding
    has to be broken.
    """

    terms: Terms
    size: Floats
    by: float = 0.0
    ladder: Ladder | None = None
    decimals: int | None = None
    rest: Floats | None = None

    @property
    def tokens(self) -> int:
        """About what it takes beside even steps."""
        jumps = 0 if self.ladder is None else JUMP * len(self.ladder.adds)
        rest = 0 if self.rest is None else RESIDUAL + len(self.rest)
        return jumps + rest + ROUNDED * (self.decimals is not None) + 4 * (self.by != 0)

    @property
    def even(self) -> bool:
        """Whether it is even steps and nothing else."""
        return self.tokens == 0 and self.terms[3] == 0

    def at(self, raster: Raster) -> Floats:
        """(n,) the coordinate of each place."""
        made = _basis(raster) @ np.array(self.terms) + self.by * self.size
        made = made if self.ladder is None else made + self.ladder.at(raster)
        if self.decimals is not None:
            made = np.rint(made * 10.0**self.decimals) / 10.0**self.decimals
        return np.asarray(made if self.rest is None else made + self.rest)


def coordinate(
    raster: Raster, value: Floats, size: Floats, still: Booleans, by: float, room: float
) -> Coordinate | None:
    """The shortest formula of places (n,), None where it would take a number for each and a size
    besides. size: (n,) of things; still: (n,) where it may not be changed to break a tie; by: how
    far the point that is placed lies off the middle, for each unit of size; room: units, what a
    place may be off.
    """
    even = _even(raster, value, size, room) if by == 0 else None
    if even is not None:  # nothing takes less
        return even
    made = [_rounded(raster, value, size, still, by, room)]
    if by == 0 and (made[0] is None or made[0].tokens > LEAST_JUMPS):
        made.append(_jumping(raster, value, size, room))
        made.append(_with_rest(raster, value, size, room))
    return min((each for each in made if each is not None), key=_tokens, default=None)


def _tokens(made: Coordinate) -> int:
    return made.tokens


def _basis(raster: Raster) -> Floats:
    """(n, 4) what the terms are multiplied by."""
    i, j = raster.i, raster.j
    return np.stack([np.ones(len(i)), i, j, j % 2], axis=1)


def _even(raster: Raster, value: Floats, size: Floats, room: float) -> Coordinate | None:
    terms = _short(_basis(raster), value, _solved(raster, value), room)
    return None if terms is None else Coordinate(terms, size)


def _with_rest(raster: Raster, value: Floats, size: Floats, room: float) -> Coordinate:
    solved = _solved(raster, value)
    worst = float(np.abs(_basis(raster) @ solved - value).max())
    terms = _short(_basis(raster), value, solved, 1.2 * worst + room)
    made = Coordinate(terms or tuple(solved.tolist()), size)
    rest = value - made.at(raster)
    return replace(made, rest=np.array([shortest(each, room / 4) for each in rest.tolist()]))


# ------------------------------------------------------------------------ even steps


def _solved(raster: Raster, value: Floats) -> Floats:
    """(4,) terms by least squares, the stagger only where it is needed."""
    basis = _basis(raster)
    some = np.zeros(4)
    some[:3] = np.linalg.lstsq(basis[:, :3], value, rcond=None)[0]
    every: Floats = np.asarray(np.linalg.lstsq(basis, value, rcond=None)[0], np.float64)
    off, less = (np.abs(basis @ each - value).max() for each in (some, every))
    return every if less < 0.5 * off else some


def _short(basis: Floats, value: Floats, terms: Floats, most: float) -> Terms | None:
    """Terms with few decimals that come as near to all values as `most`, None where none do: the
    steps first, and where they begin in the middle of what is left open.
    """
    made = terms.copy()
    for number in (3, 2, 1, 0):
        for digits in range(DIGITS + 1):
            tried = made.copy()
            tried[number] = round(float(made[number]), digits) + 0.0
            off = value - basis @ tried
            tried[0] += (off.max() + off.min()) / 2 if number else 0.0
            if np.abs(value - basis @ tried).max() <= most:
                made = tried
                break
        else:
            return None
    first, along, down, aside = made.tolist()
    return first, along, down, aside


# ----------------------------------------------------------------------------- jumps


def _jumping(raster: Raster, value: Floats, size: Floats, room: float) -> Coordinate | None:
    """Even steps in one direction only, with a few jumps."""
    for lines, index in ((False, raster.i), (True, raster.j)):
        steps, first = np.unique(index, return_index=True)
        known = value[first]
        if np.abs(value - known[np.searchsorted(steps, index)]).max() > room or len(steps) < 3:
            continue
        each = np.round(np.diff(known) / np.diff(steps), DIGITS - 3)
        often, count = np.unique(each, return_counts=True)
        usual = shortest(float(often[np.argmax(count)]), room / len(steps))
        begin = shortest(float(known[0] - usual * steps[0]), room / 4)
        off = known - begin - usual * steps
        change = np.flatnonzero(np.abs(np.diff(off)) > room) + 1
        if not 0 < len(change) < JUMPS:
            continue
        starts = [0, *steps[change].astype(int).tolist()]
        adds = [shortest(float(each), room / 4) for each in off[[0, *change.tolist()]]]
        ladder = Ladder(lines, tuple(starts), tuple(adds))
        slope = (0.0, usual) if lines else (usual, 0.0)
        made = Coordinate((begin, *slope, 0.0), size, ladder=ladder)
        if np.abs(made.at(raster) - value).max() <= room:
            return made
    return None


# -------------------------------------------------------------------------- rounding


def _rounded(
    raster: Raster, value: Floats, size: Floats, still: Booleans, by: float, room: float
) -> Coordinate | None:
    """Even steps and a share of the size, rounded as the file was."""
    decimals = _decimals(value, room)
    if decimals is None:
        return None
    grain, tie = 10.0**-decimals, 10.0 ** math.floor(math.log10(TIE * room))
    value = np.rint(value / grain) * grain  # as it was written, or a tie may look like none
    basis, middle = _basis(raster), value - by * size
    solved = _solved(raster, middle)
    if np.abs(basis @ solved - middle).max() > grain:
        return None
    nearest = least_largest(basis, middle)
    if nearest is None:
        return None
    terms: Terms | None = None
    for most in (grain / 2 - tie, grain / 2 + NUDGE * room):
        terms = _short(basis, middle, nearest, most)
        if terms is not None:
            break
    else:
        return None
    plain = Coordinate(terms, size, by, None, decimals)
    still = still | (by == 0)
    made = _untied(raster, plain, middle, still, (grain / 2 - tie, tie, room))
    if made is None or np.abs(made.at(raster) - value).max() > room:
        return None
    return made


def _decimals(value: Floats, room: float) -> int | None:
    """The decimals that all values have, None for so many that it makes no difference."""
    for decimals in range(DECIMALS + 1):
        grain = 10.0**-decimals
        if grain < COARSE * room:
            return None
        if np.abs(value - np.rint(value / grain) * grain).max() <= room:
            return decimals
    return None


def _untied(
    raster: Raster,
    made: Coordinate,
    middle: Floats,
    still: Booleans,
    bounds: tuple[float, float, float],
) -> Coordinate | None:
    """The same with each place clearly on its side of a tie: by a ladder where the size may not be
    changed, else by the size; bounds: how far off the middle a place may be rounded from, by how
    much a tie is broken, and what a place may be off.
    """
    most, tie, room = bounds
    off = middle - _basis(raster) @ np.array(made.terms)
    want = np.where(off > most, 1, np.where(off < -most, -1, 0))
    fixed = want * still
    if fixed.any():
        both = _sides(raster, fixed)
        if both is None:
            return None
        first, along, down, aside = made.terms
        first = round(first + both[0] * tie, DIGITS)
        ladder = both[1]
        if ladder is not None:
            adds = tuple(round(2 * tie * each, DIGITS) for each in ladder.adds)
            ladder = replace(ladder, adds=adds)
        made = replace(made, terms=(first, along, down, aside), ladder=ladder)
        off = middle - _basis(raster) @ np.array(made.terms)
        off = off - (0.0 if ladder is None else ladder.at(raster))
    if not made.by:
        return made
    excess = np.where(still, 0.0, np.sign(off) * np.maximum(np.abs(off) - most, 0.0))
    nudged = made.size + np.sign(excess) * (np.abs(excess) + tie) / made.by
    if np.abs(nudged - made.size).max() > 2 * NUDGE * room:
        return None
    return replace(made, size=np.where(excess == 0, made.size, nudged))


def _sides(raster: Raster, want: Integers) -> tuple[int, Ladder | None] | None:
    """By how many ties to move all places, and which lines or steps by two more, where they want up
    (1), down (-1) or do not mind (0); None where it is not a matter of a few lines or steps.
    """
    if not (want > 0).any() or not (want < 0).any():
        return (1 if (want > 0).any() else -1), None
    for lines, index in ((True, raster.j), (False, raster.i)):
        count = int(index.max()) + 1
        up, down = (
            np.bincount(index[want == side].astype(np.int64), minlength=count) > 0
            for side in (1, -1)
        )
        if (up & down).any():
            continue
        minds = np.flatnonzero(up | down)
        side = up[minds]
        starts = [0, *minds[1:][side[1:] != side[:-1]].tolist()]
        if len(starts) <= JUMPS:
            first = bool(side[0])
            adds = tuple(float(first ^ bool(k % 2)) for k in range(len(starts)))
            return -1, Ladder(lines, tuple(starts), adds)
    return None
