"""Motifs: stretches of the string that occur again, whole, elsewhere (a star, a window, a skull).

Takes an arrangement with labels of the steps between neighbours; gives stretches worth a rule, and
for a motif the frames in which its other occurrences are the same. Found before patterns, since in
real drawings most parts have a twin and few stand in a row. Whether an occurrence is exact is for
the caller to check.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from ipmlang.inverse.lsystem.frames import (
    Complexes,
    Floats,
    Frames,
    compose,
    frames,
    inverse,
    join,
    mirrored,
)
from ipmlang.inverse.lsystem.repeats import apart, find_repeats
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers
from ipmlang.inverse.score import HEAD, Tabled, followed_tokens, tabled

LEAST = 3  # symbols
MOST = 6  # stretches of one order of magnitude that are looked at closely
SNAP = 1e-7  # relative: a fitted turn or size this close to a plain one may be the plain one


@dataclass(frozen=True, slots=True, eq=False)
class Motif:
    """`length` symbols from each of `rows` (k,) on; gain: tokens that a rule for them saves."""

    gain: float
    rows: Integers
    length: int


def find_motifs(
    arrangement: Arrangement, labels: Integers, cost: Tabled, small: float, least: float = 1.0
) -> list[Motif]:
    """Stretches of three symbols or more; labels: (n - 1,) equal for equal steps; cost: of the
    arrangement; small: units; least: tokens to be saved.
    """
    places: list[Integers] = []
    lengths: list[int] = []
    for repeat in find_repeats(labels, cost.alone[1:].astype(np.float64), MOST):
        rows = apart(repeat.places, repeat.length + 1)
        if repeat.length + 1 >= LEAST and len(rows) > 1:
            places.append(rows)
            lengths.append(repeat.length + 1)
    if not places:
        return []
    often = np.array([len(rows) for rows in places], np.int64)
    every, begin = np.concatenate(places), np.cumsum(often) - often
    saved = cost.saved_by(every, np.repeat(lengths, often), begin)
    left = np.add.reduceat(cost.alone[every], begin)
    found = []
    for rows, length, saves, takes in zip(places, lengths, saved, left.tolist(), strict=True):
        gain = _gain(arrangement, cost, rows, length, float(saves), takes, small, least)
        if gain >= least:
            found.append(Motif(gain, rows, length))
    return found


def _gain(
    arrangement: Arrangement,
    cost: Tabled,
    rows: Integers,
    length: int,
    saved: float,
    left: int,
    small: float,
    least: float,
) -> float:
    """Tokens that a rule for a stretch saves, 0 if less than `least`; saved: by its symbols, left:
    by what stands for them one by one. What does not pay alone may do so as a row, at the end.
    """
    follows = np.diff(rows) == length
    row = bool((follows[1:] & follows[:-1]).any())
    # Each symbol in the rule takes a token at least.
    if saved - HEAD - length - (0 if row and least <= 1.0 else left) < least:
        return 0.0
    inside = relative_places(arrangement.placed, int(rows[0]), length)
    other = np.diff(cost.begin[rows[0] : rows[0] + length]) != 0
    saved -= HEAD + tabled(inside, other, small).needed
    gain = saved - left
    if row and gain < 1.0 <= saved:
        gain = min(1.0, saved - followed_tokens(arrangement.placed[rows], rows, length, small))
    return gain


def relative_places(placed: Frames, row: int, length: int) -> Frames:
    """(length,) frames of the symbols from `row` on in the frame of the first of them."""
    return compose(inverse(placed[row : row + 1]), placed[row : row + length])


def motif_leads(
    alphabet: Alphabet,
    arrangement: Arrangement,
    motif: Motif,
    misses: Callable[[Frames, Integers], Floats],
) -> tuple[Frames, Floats]:
    """(k,) world frames in which the first occurrence is laid over each one, and what that misses.

    The frames that the first symbol may have are tried, then the least-squares fit of all origins
    for either handedness. misses: the error of so many frames for so many rows.
    """
    rows = motif.rows
    best = arrangement.placed[rows]
    error = misses(best, rows)
    for options in _options(alphabet, arrangement, motif):
        open_rows = np.flatnonzero(error > 0.25 * alphabet.tolerance)
        if not len(open_rows):
            break
        tried = options(open_rows)
        missed = misses(tried, rows[open_rows])
        better = missed < error[open_rows]
        error[open_rows[better]] = missed[better]
        best = _with(best, open_rows[better], tried[np.flatnonzero(better)])
    return best, error


def _options(
    alphabet: Alphabet, arrangement: Arrangement, motif: Motif
) -> Iterator[Callable[[Integers], Frames]]:
    first = alphabet[int(arrangement.symbol[motif.rows[0]])]
    placed = arrangement.placed[motif.rows]
    for which in range(1, len(first.stabiliser)):
        yield partial(_kept, placed, first.stabiliser[which : which + 1])
    columns = motif.rows[:, None] + np.arange(motif.length)
    seen = arrangement.placed.position[columns]
    model = relative_places(arrangement.placed, int(motif.rows[0]), motif.length).position
    for hand in (1, -1):
        yield partial(_plain_fit, model, seen, hand)
        yield partial(_fit, model, seen, hand)


def _kept(placed: Frames, keeps: Frames, rows: Integers) -> Frames:
    return compose(placed[rows], keeps)


def _plain_fit(model: Complexes, seen: Complexes, hand: int, rows: Integers) -> Frames:
    return _plain(_fit(model, seen, hand, rows))


def _fit(model: Complexes, seen: Complexes, hand: int, rows: Integers) -> Frames:
    """(k,) frames that lay the model (m,) over these rows of `seen` (n, m), by least squares."""
    seen = seen[rows]
    local = mirrored(model, np.array(hand, np.int8))
    middle, centre = local.mean(), seen.mean(axis=1)
    centred = local - middle
    power = max(float(np.sum(np.abs(centred) ** 2)), 1e-300)
    factor = (seen - centre[:, None]) @ centred.conj() / power
    factor = np.where(np.abs(factor) > 0, factor, 1.0)
    angle = np.angle(factor, deg=True)
    return frames(centre - factor * middle, angle, np.abs(factor), hand)


def _plain(fitted: Frames) -> Frames:
    """Sizes nearly 1 and turns that are nearly whole degrees made so."""
    whole = np.round(fitted.angle)
    angle = np.where(np.abs(whole - fitted.angle) <= 60 * SNAP, whole, fitted.angle)
    scale = np.where(np.abs(fitted.scale - 1) <= SNAP, 1.0, fitted.scale)
    return frames(fitted.position, angle, scale, fitted.handedness)


def _with(given: Frames, rows: Integers, new: Frames) -> Frames:
    order = np.arange(len(given))
    order[rows] = len(given) + np.arange(len(rows))
    return join([given, new])[order]
