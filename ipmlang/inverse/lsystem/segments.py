"""Curves written in as few segments as draw them: what separates two programs' ways of writing.

In come stacked curves, out go the same curves with straight cubics as lines, without empty lines,
and with neighbours made one that continue each other: collinear lines, the two halves of a cubic,
arcs of one ellipse. No point moves by more than the arithmetic of a file's numbers does. Elements
of several subpaths are left as they are; nothing here compares elements.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import ARC, CUBIC, LINE, QUADRATIC
from ipmlang.inverse.lsystem.curves import Booleans, Curves, Integers
from ipmlang.inverse.lsystem.frames import Complexes, Floats

# Of an element's extent: what the last digits of coordinates move a point by. It is relative, so
# that copies of all sizes are written alike.
LIMIT = 2e-8


def fewest_segments(curves: Curves, fixed: Booleans, limit: Floats, empty: float) -> Curves:
    """The curves, rewritten. fixed: (n,) the start must stay (dashes begin there); limit: (n,)
    units, what a point may be off, usually `LIMIT` of the extent; empty: units, the length of lines
    that are nothing but rounding.
    """
    single = (curves.subpaths == 1) & (curves.counts > 0)
    made = _without_empty(_straightened(curves, single, limit), single, empty)
    # What did not fit before does not fit until one of the two has changed.
    fresh = np.ones(len(made.kind), np.bool_)
    while True:
        first, second = _neighbours(made, single & (made.counts > 1), fixed)
        told = fresh[first] | fresh[second]
        first, second = first[told], second[told]
        joined, fits = _joined(made, first, second, limit)
        chosen = np.flatnonzero(fits)[_disjoint(first[fits], second[fits])]
        if not len(chosen):
            return made
        kind, points = made.kind.copy(), made.points.copy()
        points[first[chosen]] = joined[chosen]
        kind[first[chosen][kind[first[chosen]] == QUADRATIC]] = CUBIC
        fresh[:] = False
        fresh[first[fits]] = True
        keep = np.ones(len(kind), np.bool_)
        keep[second[chosen]] = False
        fresh = fresh[keep]
        made = _kept(replace(made, kind=kind, points=points), keep)


def _owners(curves: Curves) -> Integers:
    """(N,) the element of each segment."""
    return np.repeat(np.arange(len(curves.counts)), curves.counts)


def _kept(curves: Curves, keep: Booleans) -> Curves:
    """The curves without some of their segments."""
    if keep.all():
        return curves
    counts = np.bincount(_owners(curves)[keep], minlength=len(curves.counts))
    offsets = np.concatenate([[0], np.cumsum(counts)])
    return replace(curves, kind=curves.kind[keep], points=curves.points[keep], offsets=offsets)


def _straightened(curves: Curves, single: Booleans, limit: Floats) -> Curves:
    """Curves that run forward along their chord made lines."""
    owner = _owners(curves)
    bent = (curves.kind == CUBIC) | (curves.kind == QUADRATIC)
    rows = np.flatnonzero(bent & single[owner])
    points, room = curves.points[rows], limit[owner[rows]]
    cubic = curves.kind[rows] == CUBIC
    end = np.where(cubic, points[:, 3], points[:, 2])
    step = end - points[:, 0]
    length = np.abs(step)
    straight = length > room
    for control in (points[:, 1], np.where(cubic, points[:, 2], points[:, 1])):
        along = (control - points[:, 0]) * np.conj(step) / np.maximum(length, 1e-300)
        straight &= (np.abs(along.imag) <= room) & (along.real >= -room)
        straight &= along.real <= length + room
    if not straight.any():
        return curves
    kind, result = curves.kind.copy(), curves.points.copy()
    lines = rows[straight]
    kind[lines] = LINE
    result[lines, 1], result[lines, 2:] = end[straight], 0
    return replace(curves, kind=kind, points=result)


def _without_empty(curves: Curves, single: Booleans, empty: float) -> Curves:
    """Without the lines that rounding left, unless an element has nothing else."""
    owner = _owners(curves)
    tiny = (curves.kind == LINE) & single[owner]
    tiny[tiny] = np.abs(curves.points[tiny, 1] - curves.points[tiny, 0]) < empty
    left = np.bincount(owner[~tiny], minlength=len(curves.counts))
    return _kept(curves, ~tiny | (left == 0)[owner])


def _neighbours(curves: Curves, some: Booleans, fixed: Booleans) -> tuple[Integers, Integers]:
    """Pairs of segments that follow each other, of one kind, the last of a closed curve with its
    first included unless the start is fixed.
    """
    owner = _owners(curves)
    after = np.arange(1, len(owner) + 1)
    last = curves.offsets[1:][some] - 1
    after[last] = np.where((curves.closed & ~fixed)[some], curves.offsets[:-1][some], -1)
    first = np.flatnonzero(some[owner] & (after >= 0))
    second = after[first]
    alike = curves.kind[first] == curves.kind[second]
    return first[alike], second[alike]


def _disjoint(first: Integers, second: Integers) -> Integers:
    """Pairs of which no two share a segment: every other one of each chain."""
    order = np.arange(len(first))
    chained = np.zeros(len(first), np.bool_)
    chained[1:] = second[:-1] == first[1:]
    start = np.maximum.accumulate(np.where(chained, 0, order))
    taken = (order - start) % 2 == 0
    # A pair over the start of a closed curve comes last; it gives way to those it overlaps.
    used = np.concatenate([first[taken & (first < second)], second[taken & (first < second)]])
    over = np.flatnonzero(first > second)
    taken[over] = ~np.isin(first[over], used) & ~np.isin(second[over], used)
    return np.flatnonzero(taken)


def _joined(
    curves: Curves, first: Integers, second: Integers, limit: Floats
) -> tuple[Complexes, Booleans]:
    """(k, 4) the segments that pairs would make, and (k,) whether they draw the same."""
    kind, room = curves.kind[first], limit[_owners(curves)[first]]
    a, b = curves.points[first], curves.points[second]
    result, fits = a.copy(), np.zeros(len(first), np.bool_)
    for codes, join in (((LINE,), _lines), ((QUADRATIC, CUBIC), _cubics), ((ARC,), _arcs)):
        rows = np.flatnonzero(np.isin(kind, codes))
        if len(rows):
            left, right = a[rows], b[rows]
            if QUADRATIC in codes:
                left, right = (_elevated(kind[rows], each) for each in (left, right))
            result[rows], fits[rows] = join(left, right, room[rows])
    return result, fits


def _lines(a: Complexes, b: Complexes, room: Floats) -> tuple[Complexes, Booleans]:
    """Two lines ahead: the corner lies on the line between their ends."""
    step, part = b[:, 1] - a[:, 0], a[:, 1] - a[:, 0]
    away = np.abs((part * np.conj(step)).imag)
    ahead = (part * np.conj(b[:, 1] - b[:, 0])).real > 0
    result = a.copy()
    result[:, 1] = b[:, 1]
    return result, ahead & (away <= room * np.abs(step)) & _meet(a[:, 1], b[:, 0], room)


def _meet(end: Complexes, start: Complexes, room: Floats) -> Booleans:
    return np.asarray(np.abs(end - start) <= room)


def _elevated(kind: NDArray[np.uint8], points: Complexes) -> Complexes:
    """Quadratics as cubics."""
    result = points.copy()
    rows = kind == QUADRATIC
    p = points[rows]
    result[rows, 1] = (p[:, 0] + 2 * p[:, 1]) / 3
    result[rows, 2] = (p[:, 2] + 2 * p[:, 1]) / 3
    result[rows, 3] = p[:, 2]
    return result


def _cubics(a: Complexes, b: Complexes, room: Floats) -> tuple[Complexes, Booleans]:
    """Two parts of one cubic, told by splitting it where their speeds say."""
    before, after = np.abs(a[:, 3] - a[:, 2]), np.abs(b[:, 1] - b[:, 0])
    t = before / np.maximum(before + after, 1e-300)
    sane = (t > 0.01) & (t < 0.99)
    t = np.where(sane, t, 0.5)
    s = 1 - t
    result = np.stack(
        [a[:, 0], a[:, 0] + (a[:, 1] - a[:, 0]) / t, b[:, 3] + (b[:, 2] - b[:, 3]) / s, b[:, 3]],
        axis=1,
    )
    middle = s * result[:, 1] + t * result[:, 2]
    left, right = s * a[:, 1] + t * middle, s * middle + t * b[:, 2]
    off = np.abs(np.stack([left - a[:, 2], right - b[:, 1], s * left + t * right - a[:, 3]]))
    return result, sane & (off.max(axis=0) <= room) & _meet(a[:, 3], b[:, 0], room)


def _arcs(a: Complexes, b: Complexes, room: Floats) -> tuple[Complexes, Booleans]:
    """Arcs of one ellipse, one after the other and less than once around."""
    same = np.abs(a[:, :3] - b[:, :3]).max(axis=1) <= room
    start, sweep = a[:, 3].real, a[:, 3].imag
    gap = np.angle(np.exp(1j * (b[:, 3].real - start - sweep)))
    same &= np.abs(gap) * np.abs(a[:, 1:3]).max(axis=1) <= room
    total = sweep + b[:, 3].imag
    same &= (sweep * b[:, 3].imag > 0) & (np.abs(total) <= 2 * np.pi)
    result = a.copy()
    result[:, 3] = start + 1j * total
    return result, same
