"""Figures of lines that differ in lengths alone: boxes in a view of any kind, ladders, brackets.

Takes a drawing's axiom in which all lines of a style are one symbol, stretched; where the same few
lines in the same directions follow each other again and again, gives what every line is in terms of
the few lengths in which copies differ, so that a copy is a place and these lengths. Nothing here
prints.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace

import numpy as np

from ipmlang.inverse.lsystem.frames import Complexes, Floats, frames, unit, wrap
from ipmlang.inverse.lsystem.symbols import Integers
from ipmlang.inverse.simplify import AXIOM, Book, regauge
from ipmlang.inverse.terminals import Terminal

COPIES = 6  # of a figure at least
LINES = (3, 24)  # of a figure: at least, at most
TRIES = 12  # stretches that are looked at, the longest first
LENGTHS = 4  # in which copies differ at most
DIRECTION = 0.02  # degrees that equal directions may differ by, of a line that is long enough
ROOM = 1e-7  # of the diagonal: what a point may be off


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """One line of a figure: the symbol, its direction in degrees, which length it has (-1 for one
    that is always the same) and the factor of it, and where it begins beside the copy's place: a
    constant, and a factor of each length.
    """

    part: int
    angle: float
    length: int
    factor: float
    begins: Complexes


@dataclass(frozen=True, slots=True, eq=False)
class Figures:
    """Rows `start` to `stop` of the axiom as copies of a figure. at: (k,) places of copies;
    lengths: (k, l); lines: of one copy; like: the row in which figures with the same places and
    lengths begin, None if there are none before.
    """

    start: int
    stop: int
    at: Complexes
    lengths: Floats
    lines: tuple[Line, ...] = ()
    like: int | None = None

    @property
    def irregular(self) -> bool:
        """Whether copies are so different that no rule says them shorter."""
        return len(np.unique(self.lengths, axis=0)) > len(self.at) / 2


@dataclass(frozen=True, slots=True, eq=False)
class _Drawn:
    """Lines in paint order. part: (n,) symbols, -1 for what is no line; begin: (n,) where each
    begins; angle: (n,) its direction in degrees; length: (n,).
    """

    part: Integers
    begin: Complexes
    angle: Floats
    length: Floats


def with_figures(book: Book, terminals: Sequence[Terminal], diagonal: float) -> list[Figures]:
    """The figures in the axiom, their lines given the length of 1; diagonal: of the drawing."""
    lines = {k: each.shape for k, each in enumerate(terminals) if each.shape.kind == "line"}
    units = {k: shape.radius for k, shape in lines.items()}
    directed = {k for k, shape in lines.items() if shape.directed}
    found = _figures(_drawn(book, units, directed), ROOM * diagonal)
    for part in {line.part for each in found for line in each.lines}:
        regauge(book, part, frames(np.zeros(1, np.complex128), 0.0, units[part]))
    return found


def _figures(drawn: _Drawn, room: float) -> list[Figures]:
    """The figures among lines; room: units, what a point may be off."""
    made: list[Figures] = []
    waiting = [(0, len(drawn.part))]
    while waiting:
        start, stop = waiting.pop()
        found = _longest(drawn, start, stop, made, room)
        if found is not None:
            made.append(found)
            waiting += [(start, found.start), (found.stop, stop)]
            waiting.sort(reverse=True)
    return made


def _drawn(book: Book, units: Mapping[int, float], directed: Set[int]) -> _Drawn:
    """What stands in the axiom as lines; units: the length of each, by symbol; directed: symbols of
    which it shows where they begin.
    """
    body = book.bodies[AXIOM]
    size = np.array([units.get(part, 0.0) for part in body.parts.tolist()])
    length, angle = size * body.places.scale, body.places.angle
    # A direction has no sign: lines begin at their lower end, level ones at the left one.
    turned = (angle < -DIRECTION) | (angle > 180 - DIRECTION)
    turned &= ~np.isin(body.parts, list(directed))
    begin = body.places.position + np.where(turned, length * unit(angle), 0.0)
    angle = np.where(turned, angle + np.where(angle > 0, -180.0, 180.0), angle)
    return _Drawn(np.where(size > 0, body.parts, -1), begin, angle, length)


def _longest(
    drawn: _Drawn, start: int, stop: int, known: list[Figures], room: float
) -> Figures | None:
    """The figure whose copies take up most of a stretch."""
    stretches: list[tuple[int, int, int]] = []
    for period in range(LINES[0], min(LINES[1], (stop - start) // COPIES) + 1):
        one, other = slice(start, stop - period), slice(start + period, stop)
        apart = np.abs(wrap(drawn.angle[one] - drawn.angle[other]))
        near = np.deg2rad(apart) * np.minimum(drawn.length[one], drawn.length[other]) <= 4 * room
        same = (drawn.part[one] == drawn.part[other]) & (drawn.part[one] >= 0)
        same &= near | (apart <= DIRECTION / 10)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], same.astype(np.int8), [0]])))
        for low, high in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            if high - low + period >= COPIES * period:
                stretches.append((high - low + period, -period, start + low))
    for size, less, first in sorted(stretches, reverse=True)[:TRIES]:
        period = -less
        for phase in range(period):
            copies = (size - phase) // period
            if copies >= COPIES:
                found = _figure(drawn, first + phase, period, copies, known, room)
                if found is not None:
                    return found
    return None


def _figure(
    drawn: _Drawn, start: int, period: int, copies: int, known: list[Figures], room: float
) -> Figures | None:
    """Copies of so many lines from a row on, if few lengths say them."""
    rows = start + np.arange(copies)[:, None] * period + np.arange(period)
    stop = start + copies * period
    for before in known:
        if len(before.at) == copies:
            like = replace(before, start=start, stop=stop, like=before.start)
            if lines := _lines(drawn, rows, like, room):
                return replace(like, lines=lines)
    lengths = _lengths(drawn.length[rows], room)
    if lengths is None:
        return None
    alone = Figures(start, stop, drawn.begin[rows[:, 0]], lengths)
    lines = _lines(drawn, rows, alone, room)
    return replace(alone, lines=lines) if lines else None


def _lengths(length: Floats, room: float) -> Floats | None:
    """(k, l) the lengths of which all of (k, m) are multiples, None for too many or none."""
    made: list[Floats] = []
    for column in length.T:
        if np.ptp(column) > 2 * room and not any(_multiple(column, each, room) for each in made):
            made.append(column)
    return np.stack(made, axis=1) if 0 < len(made) <= LENGTHS else None


def _multiple(column: Floats, of: Floats, room: float) -> float:
    """The factor between two columns, 0 where there is none."""
    factor = round(float(column @ of / (of @ of)), 9)
    return factor if np.abs(column - factor * of).max() <= room * max(1.0, factor) else 0.0


def _lines(drawn: _Drawn, rows: Integers, known: Figures, room: float) -> tuple[Line, ...]:
    """What every line is, none where one of them is something else."""
    made: list[Line] = []
    basis = np.hstack([np.ones((len(rows), 1)), known.lengths])
    for row in rows.T:
        length = drawn.length[row]
        factors = [_multiple(length, each, room) for each in known.lengths.T]
        which = int(np.argmax(np.array(factors) != 0)) if any(factors) else -1
        if which < 0 and np.ptp(length) > 2 * room:
            return ()
        factor = factors[which] if which >= 0 else float(np.median(length))
        longest = int(np.argmax(length))
        angle = float(drawn.angle[row][longest])
        begins = _begins(basis, drawn.begin[row] - known.at, room)
        if begins is None:
            return ()
        ends = drawn.begin[row] + length * unit(drawn.angle[row])
        if np.abs(drawn.begin[row] + length * unit(np.array(angle)) - ends).max() > 2 * room:
            return ()
        made.append(Line(int(drawn.part[row[0]]), angle, which, factor, begins))
    return tuple(made)


def _begins(basis: Floats, away: Complexes, room: float) -> Complexes | None:
    """(1 + l,) factors that lead to where a line begins, those that are nothing 0."""
    both = np.stack([away.real, away.imag], axis=1)
    solved = np.linalg.lstsq(basis, both, rcond=None)[0]
    reach = np.abs(basis).max(axis=0)[:, None]
    solved = np.where(np.abs(solved) * reach <= 4 * room, 0.0, solved)
    for column in range(2):
        keep = solved[:, column] != 0
        if keep.any():
            less = np.linalg.lstsq(basis[:, keep], both[:, column], rcond=None)[0]
            solved[keep, column] = less
    if np.abs(basis @ solved - both).max() > 2 * room:
        return None
    return np.asarray(solved[:, 0] + 1j * solved[:, 1])
