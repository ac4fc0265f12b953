"""The search: sizes, layouts, bodies, proof; the shortest proven recursion wins.

In come strokes; out comes a `Recursion` or None. Time is bounded: the best that was proven so far
is given. Nothing is given that was not expanded and compared.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from ipmlang.inverse.lsystem.frames import Complexes
from ipmlang.inverse.recursion.bodies import Found, programs
from ipmlang.inverse.recursion.grammar import token_count
from ipmlang.inverse.recursion.layout import axiom_layouts, body_layouts
from ipmlang.inverse.recursion.program import Recursion, expand
from ipmlang.inverse.recursion.settle import settled
from ipmlang.inverse.recursion.sizes import solutions
from ipmlang.inverse.recursion.stochastic import stochastic_programs
from ipmlang.inverse.recursion.strokes import Integers, Strokes, letters, make_strokes
from ipmlang.inverse.recursion.windows import Windows, rank_windows

FEWEST_SEGMENTS = 12
MOST_PROOFS = 40
MOST_LETTERS = 48  # plus a share of the joints: a drawing with more kinds of joints has no rule
SHARE = 1 / 8
OVERHEAD = 16  # tokens of a grammar besides its bodies, at least


def fold(
    start: Complexes,
    end: Complexes,
    *,
    styles: Integers | None = None,
    tolerance: float = 1e-6,
    seconds: float = 10.0,
) -> Recursion | None:
    """The L-system whose turtle draws the segments start, end (n,) in this order (x + iy, y up).

    styles: (n,) numbers of their styles; what few styles explain becomes symbols of their own, else
    they are left out (`Recursion.styles` is empty then). tolerance: share of the diagonal that a
    point may be off; seconds: of processor time, after which the best found is given. None where no
    recursion of at least three steps draws the segments.
    """
    if len(start) < FEWEST_SEGMENTS:
        return None
    strokes = make_strokes(start, end, tolerance)
    if strokes is None:
        return None
    spellings = letters(strokes)
    if _varied(spellings[0]):
        return None
    deadline = time.process_time() + seconds
    styled = styles is not None and len(np.unique(styles)) > 1
    if styled and styles is not None:
        found = _drawn_by_chance(strokes, styles)
        if found is not None:
            return found
    variants = (0, 1, 2, 3) if strokes.connected else (0, 1)
    found = _best(strokes, rank_windows(spellings, variants), deadline)
    if found is None:
        found = _drawn_by_chance(strokes, np.zeros(len(start), np.int64))
    return found


def _varied(joints: Integers) -> bool:
    """Whether there are more kinds of joints than rules make."""
    return len(np.unique(joints)) > MOST_LETTERS + len(joints) * SHARE


def _drawn_by_chance(strokes: Strokes, styles: Integers) -> Recursion | None:
    for program in stochastic_programs(strokes, styles):
        proven = settled(program, strokes)
        if proven is not None and np.array_equal(expand(proven).style, styles):
            return proven
    return None


def _best(strokes: Strokes, windows: Windows, deadline: float) -> Recursion | None:
    best: Recursion | None = None
    fewest, tried = 0, 0
    for found in _findings(strokes, windows):
        if time.process_time() > deadline or tried >= MOST_PROOFS:
            break
        if best is not None and found.sizes.weight >= fewest - OVERHEAD:
            break
        for program in programs(found):
            tried += 1
            proven = settled(program, strokes)
            if proven is not None and (best is None or token_count(proven) < fewest):
                best, fewest = proven, token_count(proven)
    return best


def _findings(strokes: Strokes, windows: Windows) -> Iterator[Found]:
    for sizes in solutions(len(strokes), strokes.longest_run):
        for axiom in axiom_layouts(windows, sizes):
            first = axiom.before[0] * sizes.piece(sizes.steps)
            for body in body_layouts(windows, sizes, first):
                yield Found(strokes, sizes, axiom, body)
