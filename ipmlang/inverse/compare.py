"""Whether one drawing shows what another does: the proof behind every inferred grammar.

In come two drawings split the same way, out goes a `Comparison`: elements matched one to one in
paint order, the largest distance between matched curves, what is missing, added, out of order or
painted otherwise, and the first offenders. Neither drawing is changed, and nothing is assumed of
how either was made.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ipmlang.formats.drawing import Drawing, DrawnElement, Outline
from ipmlang.inverse.appearance import same_effects, same_fragment, same_matrix, same_style
from ipmlang.inverse.distance import bounding_boxes, pair_distances, rows_of
from ipmlang.inverse.lsystem.curves import Booleans, Curves, Integers, diagonal_of, stack
from ipmlang.inverse.lsystem.ellipses import find_ellipses
from ipmlang.inverse.lsystem.frames import Floats

LIMIT = 1e-6  # of the diagonal: what counts as given back
STRAY = 1e-3  # of the diagonal: elements further apart than this are looked for elsewhere
CANDIDATES = 32  # nearest elements of which one may be the partner of a stray one
SHOWN = 10


@dataclass(frozen=True, slots=True)
class Offender:
    """One thing that is wrong: element number in the first drawing (in the second for "extra"),
    what ("error", "missing", "extra", "order", "style"), and how far off, a share of the diagonal.
    """

    element: int
    what: str
    error: float = 0.0


@dataclass(frozen=True, slots=True)
class Comparison:
    """What separates two drawings.

    elements: of the first; max_error: largest distance of matched curves, share of the diagonal;
    missing, extra: elements without a partner; order_violations: matched elements to be moved to
    restore the paint order; style_differences: matched elements that are painted otherwise;
    canvas_differs: another viewBox; offenders: the first of each kind, worst errors first.
    """

    elements: int
    max_error: float
    missing: int
    extra: int
    order_violations: int
    style_differences: int
    canvas_differs: bool
    offenders: tuple[Offender, ...]

    def agrees(self, limit: float = LIMIT) -> bool:
        """Whether everything is there, in order, in style, and within the limit."""
        wrong = self.missing + self.extra + self.order_violations + self.style_differences
        return wrong == 0 and self.max_error <= limit and not self.canvas_differs


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Matched elements. left, right: (k,) numbers, left ascending; error: (k,) units; painted: (k,)
    whether both are painted alike.
    """

    left: Integers
    right: Integers
    error: Floats
    painted: Booleans


class _Sides:
    """The two drawings with their curves, and which styles were found alike."""

    def __init__(self, a: Drawing, b: Drawing, limit: float) -> None:
        self.a, self.b = a, b
        self.curves = _curves(a), _curves(b)
        self.unit = diagonal_of(a.box, self.curves[0])
        self.near = max(STRAY, 2 * limit)
        self.apart = 2 * limit * self.unit if limit > LIMIT else 0.0
        # What paint and effects may be off grows with what curves may.
        self.room = self.unit * max(1.0, limit / LIMIT)
        self._alike: dict[tuple[int, int], bool] = {}

    def measure(self, left: Integers, right: Integers) -> _Pairs:
        """Errors and styles of given pairs."""
        fixed = np.array([bool(self.a.elements[row].style.dashes) for row in left], np.bool_)
        curves = _taken(self.curves[0], left), _taken(self.curves[1], right)
        error = pair_distances(*curves, fixed, self.unit, self.apart)
        stroked = np.array([self.a.elements[row].style.stroke != "none" for row in left], np.bool_)
        painted = ~stroked | _same_ends(*curves, self.unit)
        for index, (one, other) in enumerate(zip(left.tolist(), right.tolist(), strict=True)):
            mine, yours = self.a.elements[one], self.b.elements[other]
            painted[index] &= self.alike(mine, yours)
            if mine.fragment is not None or yours.fragment is not None:
                error[index] = _fragment_error(mine, yours)
        return _Pairs(left, right, error, painted)

    def alike(self, one: DrawnElement, other: DrawnElement) -> bool:
        """Whether two elements are painted alike; answers are kept by the styles' identity."""
        key = id(one.style), id(other.style)
        if key not in self._alike:
            effects = one.style.effects, other.style.effects
            self._alike[key] = same_style(one.style, other.style, self.room) and same_effects(
                self.a, self.b, *effects, self.room
            )
        if not self._alike[key]:
            return False
        if one.fragment is None or other.fragment is None:
            return one.fragment is other.fragment
        linear = same_matrix(
            (*one.fragment.matrix[:4], 0, 0), (*other.fragment.matrix[:4], 0, 0), self.unit
        )
        return linear and same_fragment(one.fragment, other.fragment)


def compare(a: Drawing, b: Drawing, limit: float = LIMIT) -> Comparison:
    """What separates b from a, both split into elements the same way. limit: share of the diagonal
    by which matched elements may be apart, for drawings that are not meant to be equal.

    >>> compare(Drawing(()), Drawing(())).agrees()
    True
    """
    sides = _Sides(a, b, limit)
    pairs = _matched(sides)
    broken = _out_of_order(pairs.right)
    runs = _broken_runs(a, b, pairs) if not len(broken) else np.zeros(0, np.int64)
    missing = np.setdiff1d(np.arange(len(a.elements)), pairs.left)
    extra = np.setdiff1d(np.arange(len(b.elements)), pairs.right)
    styles = np.union1d(pairs.left[~pairs.painted], runs)
    share = pairs.error / sides.unit
    worst = np.argsort(-share, kind="stable")[:SHOWN]
    offenders = [
        *(Offender(int(pairs.left[row]), "error", float(share[row])) for row in worst),
        *_named(missing, "missing"),
        *_named(extra, "extra"),
        *_named(pairs.left[broken], "order"),
        *_named(styles, "style"),
    ]
    return Comparison(
        elements=len(a.elements),
        max_error=float(share.max(initial=0.0)),
        missing=len(missing),
        extra=len(extra),
        order_violations=len(broken),
        style_differences=len(styles),
        canvas_differs=_canvas_differs(a, b, sides.unit),
        offenders=tuple(each for each in offenders if each.what != "error" or each.error > 0),
    )


def _named(rows: Integers, what: str) -> Iterable[Offender]:
    return (Offender(row, what) for row in rows[:SHOWN].tolist())


def _curves(drawing: Drawing) -> Curves:
    empty = Outline(
        np.zeros(0, np.uint8), np.zeros((0, 4, 2)), np.zeros(1, np.int32), np.zeros(0, np.bool_)
    )
    return stack([empty if each.outline is None else each.outline for each in drawing.elements])


def _taken(curves: Curves, rows: Integers) -> Curves:
    """The curves of some elements, in the order given."""
    if len(rows) == len(curves.counts) and (rows == np.arange(len(rows))).all():
        return curves
    segments = rows_of(curves.offsets, rows)
    offsets = np.concatenate([[0], np.cumsum(curves.counts[rows])])
    return Curves(
        curves.kind[segments],
        curves.points[segments],
        offsets,
        curves.subpaths[rows],
        curves.closed[rows],
    )


def _canvas_differs(a: Drawing, b: Drawing, unit: float) -> bool:
    """Whether the second viewBox is another; a drawing without one is given any."""
    if a.box is None or b.box is None:
        return a.box is not None
    return bool(np.abs(np.subtract(a.box, b.box)).max() > LIMIT * unit)


def _fragment_error(one: DrawnElement, other: DrawnElement) -> float:
    if one.fragment is None or other.fragment is None:
        return np.inf
    return float(np.hypot(*np.subtract(one.fragment.matrix[4:], other.fragment.matrix[4:])))


def _same_ends(a: Curves, b: Curves, unit: float) -> Booleans:
    """(n,) whether subpaths are closed alike, since caps are not joins; on a full ellipse neither
    shows.
    """
    same = (a.closed == b.closed) | (a.counts == 0)
    if not same.all():
        same |= find_ellipses(a, LIMIT * unit).full & find_ellipses(b, LIMIT * unit).full
    return np.asarray(same)


def _matched(sides: _Sides) -> _Pairs:
    """Elements by paint order, and those that do not fit there by place and paint."""
    counts = len(sides.a.elements), len(sides.b.elements)
    if counts[0] != counts[1]:
        left, right = np.arange(counts[0]), np.arange(counts[1])
        found = sides.measure(*_neighbours(sides, left, right))
        return _some(found, found.error <= sides.near * sides.unit)
    everything = np.arange(counts[0])
    straight = sides.measure(everything, everything)
    fits = (straight.error <= sides.near * sides.unit) & straight.painted
    if fits.all():
        return straight
    stray = np.flatnonzero(~fits)
    found = sides.measure(*_neighbours(sides, stray, stray))
    found = _some(found, found.error <= sides.near * sides.unit)
    # What has no better partner keeps the one of its own number, as moved or repainted.
    alone = ~np.isin(everything, found.left) & ~np.isin(everything, found.right)
    alone &= ~fits & np.isfinite(straight.error)
    return _joined(found, _some(straight, fits | alone))


def _some(pairs: _Pairs, keep: Booleans) -> _Pairs:
    return _Pairs(pairs.left[keep], pairs.right[keep], pairs.error[keep], pairs.painted[keep])


def _joined(one: _Pairs, other: _Pairs) -> _Pairs:
    left = np.concatenate([one.left, other.left])
    order = np.argsort(left)
    return _Pairs(
        left[order],
        np.concatenate([one.right, other.right])[order],
        np.concatenate([one.error, other.error])[order],
        np.concatenate([one.painted, other.painted])[order],
    )


def _neighbours(sides: _Sides, left: Integers, right: Integers) -> tuple[Integers, Integers]:
    """Pairs of elements in about the same place, each used once: painted alike if possible, then
    the nearest, then the first in paint order.
    """
    from scipy.spatial import cKDTree

    if not len(left) or not len(right):
        return left[:0], right[:0]
    mine, yours = _boxes(sides.a, sides.curves[0])[left], _boxes(sides.b, sides.curves[1])[right]
    reach = sides.near * sides.unit + 0.05 * np.abs(mine[:, 2:] - mine[:, :2]).max(axis=1)
    near = min(CANDIDATES, len(right))
    found, number = cKDTree(yours).query(mine, k=near, p=np.inf)
    distance = np.asarray(found).reshape(len(left), near)
    index = np.minimum(np.asarray(number).reshape(len(left), near), len(right) - 1)
    free = np.ones(len(right), np.bool_)
    pairs = []
    for row, element in enumerate(left.tolist()):
        within = index[row][(distance[row] <= reach[row]) & free[index[row]]]
        if not len(within):
            continue
        steps = np.round(np.abs(yours[within] - mine[row]).max(axis=1) / (1e-5 * sides.unit))
        by_distance = within[np.lexsort((within, steps))].tolist()
        here = sides.a.elements[element]
        alike = (each for each in by_distance if sides.alike(here, sides.b.elements[right[each]]))
        best = next(alike, by_distance[0])
        free[best] = False
        pairs.append((element, int(right[best])))
    both = np.array(pairs, np.int64).reshape(-1, 2)
    return both[:, 0], both[:, 1]


def _boxes(drawing: Drawing, curves: Curves) -> Floats:
    """(n, 4) least and largest x and y of points along the elements; a fragment's origin."""
    boxes = np.zeros((len(curves.counts), 4))
    drawn = np.flatnonzero(curves.counts)
    boxes[drawn] = np.nan_to_num(bounding_boxes(curves, drawn))
    for row, element in enumerate(drawing.elements):
        if element.fragment is not None:
            boxes[row] = [*element.fragment.matrix[4:], *element.fragment.matrix[4:]]
    return boxes


def _out_of_order(right: Integers) -> Integers:
    """Positions outside a longest increasing subsequence."""
    if (np.diff(right) > 0).all():
        return np.zeros(0, np.int64)
    tails: list[int] = []
    last: list[int] = []
    before = np.full(len(right), -1)
    for position, value in enumerate(right.tolist()):
        slot = bisect_left(tails, value)
        before[position] = last[slot - 1] if slot else -1
        tails[slot : slot + 1] = [value]
        last[slot : slot + 1] = [position]
    kept = np.zeros(len(right), np.bool_)
    position = last[-1]
    while position >= 0:
        kept[position] = True
        position = int(before[position])
    return np.flatnonzero(~kept)


def _broken_runs(a: Drawing, b: Drawing, pairs: _Pairs) -> Integers:
    """First elements after which one drawing stays in a group effect and the other does not: two
    runs that overlap are not composed like one.
    """
    if not (a.effects or b.effects):
        return np.zeros(0, np.int64)
    runs = _shared_effects(a, pairs.left), _shared_effects(b, pairs.right)
    return np.asarray(pairs.left[:-1][runs[0] != runs[1]])


def _shared_effects(drawing: Drawing, rows: Integers) -> Integers:
    """How many outer effects each element shares with the next."""
    stacks = [drawing.elements[row].style.effects for row in rows.tolist()]
    shared = []
    for one, other in pairwise(stacks):
        depth = 0
        while depth < min(len(one), len(other)) and one[depth] == other[depth]:
            depth += 1
        shared.append(depth)
    return np.array(shared, np.int64)
