"""The search: sizes, layouts, bodies, proof; the shortest proven recursion wins.

In come strokes; out comes a `Recursion` or None. Time is bounded: the best that was proven so far
is given. Nothing is given that was not expanded and compared.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from itertools import chain, islice

import numpy as np

from ipmlang.inverse.lsystem.frames import Complexes
from ipmlang.inverse.recursion.bodies import Found, programs
from ipmlang.inverse.recursion.grammar import token_count
from ipmlang.inverse.recursion.layout import axiom_layouts, body_layouts
from ipmlang.inverse.recursion.program import Recursion, expand
from ipmlang.inverse.recursion.settle import settled
from ipmlang.inverse.recursion.sizes import solutions
from ipmlang.inverse.recursion.stems import stem_program
from ipmlang.inverse.recursion.stochastic import stochastic_programs
from ipmlang.inverse.recursion.strokes import Integers, Strokes, letters, make_strokes
from ipmlang.inverse.recursion.styling import with_styles
from ipmlang.inverse.recursion.windows import Windows, rank_windows

FEWEST_SEGMENTS = 12
MOST_FINDINGS = 400
MOST_PROOFS = 40
MOST_LETTERS = 48  # plus a share of the joints: a drawing with more kinds of joints has no rule
SHARE = 1 / 8
MOST_STYLES = 8
LONGEST_PERIOD = 12  # joints of what a sequence says better than a recursion
OVERHEAD = 16  # tokens of a grammar besides its bodies, at least


def fold(
    start: Complexes,
    end: Complexes,
    *,
    styles: Integers | None = None,
    tolerance: float = 1e-6,
    grain: float = 0.0,
    seconds: float = 10.0,
) -> Recursion | None:
    """The L-system whose turtle draws the segments start, end (n,) in this order (x + iy, y up).

    styles: (n,) numbers of their styles. Where symbols explain them they are part of the result,
        else `Recursion.styles` is empty.
    tolerance: share of the diagonal; no point of the result is off by more.
    grain: what the coordinates were rounded to, units; those of the result round to the same.
    seconds: of processor time, after which the best found so far is given.
    None where no recursion of at least three steps draws the segments.
    """
    if len(start) < FEWEST_SEGMENTS:
        return None
    strokes = make_strokes(start, end, tolerance, grain)
    if strokes is None:
        return None
    spellings = letters(strokes)
    if _varied(spellings[0]) or _periodic(spellings[0]):
        return None
    deadline = time.process_time() + seconds
    variants = (0, 1, 2, 3) if strokes.connected else (0, 1)
    windows = rank_windows(spellings, variants)
    found: Recursion | None = None
    if styles is not None and 1 < len(np.unique(styles)) <= MOST_STYLES:
        found = _drawn_by_chance(strokes, styles) or _best(strokes, windows, deadline, styles)
    found = found or _best(strokes, windows, deadline, None)
    return found or _drawn_by_chance(strokes, np.zeros(len(start), np.int64))


def _varied(joints: Integers) -> bool:
    """Whether there are more kinds of joints than rules make."""
    return len(np.unique(joints)) > MOST_LETTERS + len(joints) * SHARE


def _periodic(joints: Integers) -> bool:
    """Whether a few joints repeat all along: a row, a ring, a zigzag."""
    most = min(LONGEST_PERIOD, len(joints) // 4)
    return any(np.array_equal(joints[k:], joints[:-k]) for k in range(1, most + 1))


def _drawn_by_chance(strokes: Strokes, styles: Integers) -> Recursion | None:
    """A proven program with alternatives. styles: those it has to explain, all 0 if none."""
    stem = None if np.any(styles) else stem_program(strokes)
    several = stochastic_programs(strokes, styles)
    for program in chain([stem] if stem is not None else [], several):
        proven = settled(program, strokes)
        if proven is not None and np.array_equal(expand(proven).style, styles):
            return proven
    return None


def _best(
    strokes: Strokes, windows: Windows, deadline: float, styles: Integers | None
) -> Recursion | None:
    """The shortest that was proven; one that explains the styles if there are any."""
    best: Recursion | None = None
    fewest, tried = 0, 0
    for found in islice(_findings(strokes, windows), MOST_FINDINGS):
        if time.process_time() > deadline or tried >= MOST_PROOFS:
            break
        if best is not None and found.sizes.weight >= fewest - OVERHEAD:
            break
        for program in programs(found):
            tried += 1
            proven = settled(program, strokes)
            if proven is not None and styles is not None:
                proven = with_styles(proven, styles)
            if proven is not None and (best is None or token_count(proven) < fewest):
                best, fewest = proven, token_count(proven)
    return best


def _findings(strokes: Strokes, windows: Windows) -> Iterator[Found]:
    for sizes in solutions(len(strokes), strokes.longest_run):
        for axiom in axiom_layouts(windows, sizes):
            first = axiom.before[0] * sizes.piece(sizes.steps)
            for body in body_layouts(windows, sizes, first):
                yield Found(strokes, sizes, axiom, body)
