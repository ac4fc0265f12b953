"""Labelled things: a key and its letter, a tick and its number, a dot and its name, so often.

Takes the axiom of a drawing; gives stretches of it in which a few terminals follow each other again
and again, the same but for one (the label), and stand to each other as they did before. Where they
stand is a formula of the copy, or listed; a table names the labels. Nothing here prints.
"""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.boards.coordinates import Coordinate, coordinate
from ipmlang.inverse.boards.raster import Raster, rasters
from ipmlang.inverse.gridded_tables import grid_of
from ipmlang.inverse.lsystem.curves import Booleans
from ipmlang.inverse.lsystem.frames import Complexes, Frames
from ipmlang.inverse.lsystem.symbols import Integers
from ipmlang.inverse.score import SMALL
from ipmlang.inverse.simplify import AXIOM, Book

MOST = 16  # terminals of a copy
LEAST = 4  # copies that are worth a table
UNLIKE = 3  # labels: two by turns are a rhythm, which rules say
HEAD = 26  # tokens of the table's head, of the loop, and of a formula
ALONE = 6  # tokens that a terminal takes which is placed by itself
ROOM = 2e-7  # of the diagonal: what a place may be off


@dataclass(frozen=True, slots=True, eq=False)
class Labelled:
    """Rows `start` to `stop` of the axiom as copies of `inside` (p) symbols.

    label: which of these differs; labels: (n,) the symbol that stands for it in each copy; frames:
    (p) of the symbols about the copy's place; raster: the node of each copy; x, y: where it is.
    """

    start: int
    stop: int
    inside: tuple[int, ...]
    label: int
    labels: Integers
    frames: Frames
    raster: Raster
    x: Coordinate
    y: Coordinate
    irregular: bool = False  # rules may say the rest of the drawing shorter

    @property
    def symbols(self) -> set[int]:
        """All that it names."""
        return {*self.inside, *self.labels.tolist()}

    @property
    def listed(self) -> bool:
        """Whether the table says where each copy is."""
        return self.x.rest is not None and self.y.rest is not None


@dataclass(frozen=True, slots=True)
class _Run:
    """Copies of so many rows, from `start` to `stop`, whose place in each but one is the same."""

    start: int
    stop: int
    period: int
    label: int

    @property
    def copies(self) -> int:
        """How many there are."""
        return (self.stop - self.start) // self.period


def with_labels(book: Book, terminals: int, bound: Set[int], diagonal: float) -> list[Labelled]:
    """The labelled things that stand in the axiom; bound: symbols that cannot be named in a table;
    terminals: how many there are; diagonal: units.
    """
    body = book.bodies[AXIOM]
    able = (body.parts < terminals) & ~np.isin(body.parts, list(bound))
    made: list[Labelled] = []
    taken = np.zeros(len(body.parts), np.bool_)
    for run in sorted(_runs(body.parts, body.places, able, ROOM * diagonal), key=_worth):
        if taken[run.start : run.stop].any():
            continue
        found = _labelled(run, body.parts, body.places, ROOM * diagonal)
        if found is not None:
            made.append(found)
            taken[run.start : run.stop] = True
    return sorted(made, key=_begin)


def _begin(labelled: Labelled) -> int:
    return labelled.start


def _worth(run: _Run) -> tuple[int, int, int]:
    """What is taken first: what says most rows, in copies of as few rows as do."""
    return -(run.stop - run.start), run.period, run.start


def _runs(parts: Integers, places: Frames, able: Booleans, room: float) -> Iterator[_Run]:
    """The longest runs of copies of each length, from wherever they may begin."""
    for period in range(2, MOST + 1):
        if len(parts) < LEAST * period:
            return
        moved = places.position[period:] - places.position[:-period]
        alike = _alike(places, period) & able[period:] & able[:-period]
        same = parts[period:] == parts[:-period]
        # From row k on: whether the next copy is this one moved, and how many symbols differ in it.
        windows = np.lib.stride_tricks.sliding_window_view
        steady = windows(alike, period).all(axis=1)
        steps = windows(moved, period)
        steady &= np.abs(steps - steps[:, :1]).max(axis=1) <= room
        for first in range(period):
            own = steady[first::period]
            ends = np.flatnonzero(np.diff(np.concatenate([[False], own, [False]]).astype(np.int8)))
            for low, high in zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True):
                start, stop = first + low * period, first + (high + 1) * period
                yield from _one_label(same[start : stop - period], start, stop, period)


def _alike(places: Frames, period: int) -> Booleans:
    """Whether rows `period` apart are turned and sized alike."""
    return np.asarray(
        (np.abs(places.angle[period:] - places.angle[:-period]) <= SMALL)
        & (np.abs(places.scale[period:] / places.scale[:-period] - 1) <= SMALL)
        & (places.handedness[period:] == places.handedness[:-period])
    )


def _one_label(same: Booleans, start: int, stop: int, period: int) -> Iterator[_Run]:
    """The stretches of a run in which one symbol of a copy differs from copy to copy."""
    changes = ~same.reshape(-1, period)
    often = changes.sum(axis=0)
    label = int(np.argmax(often))
    if not often[label]:
        return
    others = np.flatnonzero(np.delete(changes, label, axis=1).any(axis=1))
    cuts = np.concatenate([[-1], others, [len(changes)]])
    for low, high in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True):
        copies = high - low
        if copies >= LEAST and changes[low + 1 : high, label].any():
            first = start + (low + 1) * period
            yield _Run(first, first + copies * period, period, label)


def _labelled(run: _Run, parts: Integers, places: Frames, room: float) -> Labelled | None:
    rows = slice(run.start, run.stop)
    own, at = parts[rows].reshape(-1, run.period), places.position[rows].reshape(-1, run.period)
    inside = places[run.start : run.start + run.period]
    points = at[:, 0]
    placed = _placed(points, room)
    if placed is None:
        return None
    raster, x, y = placed
    listed = (x.rest is not None) + (y.rest is not None)
    said = HEAD + ALONE * run.period + x.tokens + y.tokens + run.copies * (1 + listed)
    if said >= ALONE * (run.stop - run.start) or len(np.unique(own[:, run.label])) < UNLIKE:
        return None
    return Labelled(
        run.start,
        run.stop,
        tuple(own[0].tolist()),
        run.label,
        own[:, run.label],
        _about(inside, points[0]),
        raster,
        x,
        y,
    )


def _about(places: Frames, origin: complex) -> Frames:
    return Frames(
        places.x - origin.real, places.y - origin.imag, places.angle, places.scale,
        places.handedness,
    )  # fmt: skip


def _placed(points: Complexes, room: float) -> tuple[Raster, Coordinate, Coordinate] | None:
    """The nodes of copies and the shortest formulas of where they are."""
    count = len(points)
    ones, still = np.ones(count), np.ones(count, np.bool_)
    best: tuple[Raster, Coordinate, Coordinate] | None = None
    for raster in _rasters(points, room):
        x = coordinate(raster, points.real, ones, still, 0.0, room)
        y = coordinate(raster, points.imag, ones, still, 0.0, room)
        if x is None or y is None:
            continue
        off = np.hypot(x.at(raster) - points.real, y.at(raster) - points.imag)
        if off.max() > 2 * room:
            continue
        if best is None or x.tokens + y.tokens < best[1].tokens + best[2].tokens:
            best = raster, x, y
    return best


def _rasters(points: Complexes, room: float) -> Iterator[Raster]:
    """Ways to number copies: one after the other, and along the lines of a grid."""
    count = len(points)
    every = np.arange(count)
    yield Raster(0, count, count, every)
    grid = grid_of(points, room)
    if grid is not None and grid.formula.across:
        yield Raster(0, count, grid.formula.across, every + grid.skipped)
    for raster in rasters(points, np.zeros(count, np.int64)):
        if raster.stop - raster.start == count:
            yield raster
