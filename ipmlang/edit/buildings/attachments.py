"""The seven attachments between the boxes of a building, as equations for where their faces go.

In go boxes and the faces that an edit moves, out come all boxes. After section 4.1 of Demir et al.
2016: ground, corner, edge, plane, volume, size, position; axes are independent. Faces that coincide
are one unknown, so what touches cannot come apart. Boxes are marked breadth first from the edited
ones: each unknown gets one equation, and more only where a solution would break a relation.
Overlaps are kept as shares between the nearest faces that are known already, which keeps order too.
"""

from __future__ import annotations

import bisect
import heapq
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.edit.buildings.contacts import neighbours, touching
from ipmlang.edit.buildings.solving import Equations, Factored, Term, equations, factor

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Kind: TypeAlias = Literal["corner", "edge", "plane", "volume", "size", "position", "order"]
Breaks: TypeAlias = list[tuple[float, int]]
BY_AXES: tuple[Kind, ...] = ("volume", "plane", "edge", "corner")  # that a pair abuts along
# volumes weigh less: a different overlap inside is hardly seen (section 4.1)
WEIGHTS: dict[Kind, float] = {
    "corner": 1.0, "edge": 1.0, "plane": 1.0, "volume": 0.3, "size": 0.5, "position": 0.2,
    "order": 100.0,
}  # fmt: skip
ROUNDS = 12  # of equations added where relations broke
LEAST = 0.02  # of its size that a box keeps at least


@dataclass(frozen=True, slots=True, eq=False)
class Attached:
    """n boxes low, high (n, 3) with their neighbours (k, 2); `abuts` (k, 3): along which axes a
    pair touches; faces (2n, 3): the unknown of the low faces, then of the high faces, by axis.
    """

    low: Floats
    high: Floats
    pairs: Integers
    abuts: NDArray[np.bool_]
    faces: Integers
    near: tuple[NDArray[np.int64], ...]
    tolerance: float

    def __len__(self) -> int:
        return len(self.low)


def attach(low: Floats, high: Floats, tolerance: float, held: Integers | None = None) -> Attached:
    """Find the neighbours of n boxes and the faces that coincide. held (h, 2): pairs that belong
    together whether they touch or not.
    """
    pairs = neighbours(low, high, tolerance)
    if held is not None and len(held):
        pairs = np.unique(np.concatenate([pairs, np.sort(held, axis=1)]), axis=0)
    abuts = touching(low, high, pairs, tolerance)
    values = np.concatenate([low, high])
    faces = np.stack([_merged(values[:, axis], pairs, tolerance) for axis in range(3)], axis=1)
    count = len(low)
    ends = np.concatenate([pairs, pairs[:, ::-1]])
    ends = ends[np.lexsort((ends[:, 1], ends[:, 0]))]
    near = np.split(ends[:, 1], np.searchsorted(ends[:, 0], np.arange(1, count)))
    return Attached(low, high, pairs, abuts, faces, tuple(near), tolerance)


def _merged(values: Floats, pairs: Integers, tolerance: float) -> Integers:
    """(2n,) a number for each face along one axis, the same for those of neighbours that lie in
    one plane.
    """
    from scipy import sparse
    from scipy.sparse.csgraph import connected_components

    count = len(values) // 2
    i, j = pairs.T
    sets = [(i, j), (i + count, j + count), (i, j + count), (i + count, j)]
    own = np.arange(count)
    a = np.concatenate([own, *(one for one, _ in sets)])
    b = np.concatenate([own + count, *(other for _, other in sets)])
    same = np.abs(values[a] - values[b]) <= tolerance
    graph = sparse.coo_matrix((np.ones(same.sum()), (a[same], b[same])), (2 * count, 2 * count))
    return np.asarray(connected_components(graph, directed=False)[1], np.int64)


# ------------------------------------------------------------------------------- marking


@dataclass(slots=True, eq=False)
class Marking:
    """Equations along one axis while they are collected; known: which unknowns have theirs;
    extents: boxes that get another size, with that size.
    """

    attached: Attached
    axis: int
    known: NDArray[np.bool_]
    at: Floats
    terms: list[tuple[Term, ...]] = field(default_factory=list)
    values: list[float] = field(default_factory=list)
    kinds: list[Kind] = field(default_factory=list)
    extents: Mapping[int, float] = field(default_factory=dict)

    def note(self, kind: Kind, terms: Sequence[Term], value: float) -> None:
        """One equation."""
        self.terms.append(tuple(terms))
        self.values.append(value)
        self.kinds.append(kind)

    def ends(self, box: int) -> tuple[int, int]:
        """The unknowns of a box."""
        faces = self.attached.faces
        return int(faces[box, self.axis]), int(faces[box + len(self.attached), self.axis])

    def is_known(self, box: int) -> bool:
        low, high = self.ends(box)
        return bool(self.known[low] and self.known[high])

    def between(self, kind: Kind, unknown: int, breaks: Breaks) -> bool:
        """An unknown keeps its share between the faces beside it; no, if it is outside."""
        x = float(self.at[unknown])
        place = bisect.bisect_left(breaks, (x, -1))
        for near in breaks[max(place - 1, 0) : place + 1]:
            if abs(near[0] - x) <= self.attached.tolerance:
                self.note(kind, ((unknown, 1.0), (near[1], -1.0)), 0.0)
                break
        else:
            if not 0 < place < len(breaks):
                return False
            (p, first), (q, second) = breaks[place - 1], breaks[place]
            share = (x - p) / (q - p)
            terms = ((unknown, 1.0), (first, share - 1.0), (second, -share))
            self.note(kind, terms, 0.0)
        self.known[unknown] = True
        bisect.insort(breaks, (x, unknown))
        return True

    def offset(self, kind: Kind, unknown: int, other: int, box: int = -1) -> None:
        """An unknown keeps its distance from a known one; the faces of a box that gets another
        size get that.
        """
        apart = float(self.at[unknown] - self.at[other])
        if box in self.extents and {unknown, other} == set(self.ends(box)):
            apart = self.extents[box] * (1.0 if apart >= 0 else -1.0)
        self.note(kind, ((unknown, 1.0), (other, -1.0)), apart)
        self.known[unknown] = True


def mark(
    attached: Attached,
    axis: int,
    fixed: Integers,
    edited: Sequence[int],
    extents: Mapping[int, float] | None = None,
) -> Marking:
    """One equation for each unknown along an axis, breadth first from the edited boxes; `fixed`
    unknowns have theirs, `extents` are new sizes of some boxes.
    """
    count = int(attached.faces[:, axis].max()) + 1
    at = np.zeros(count)
    at[attached.faces[:, axis]] = np.concatenate([attached.low, attached.high])[:, axis]
    known = np.zeros(count, np.bool_)
    known[fixed] = True
    marking = Marking(attached, axis, known, at, extents=extents or {})
    order = _distances(attached, edited)
    boxes = np.lexsort((np.arange(len(attached)), order)).tolist()
    rank = {box: place for place, box in enumerate(boxes)}
    _spread(marking, boxes, rank)
    return marking


def _distances(attached: Attached, edited: Sequence[int]) -> Floats:
    """(n,) how many contacts each box is away from the edited ones, inf where nothing leads."""
    from scipy import sparse
    from scipy.sparse.csgraph import dijkstra

    count, (i, j) = len(attached), attached.pairs.T
    graph = sparse.coo_matrix((np.ones(len(i)), (i, j)), (count, count)).tocsr()
    found = dijkstra(graph, False, list(edited), unweighted=True, min_only=True)
    return np.asarray(found, np.float64)


def _spread(marking: Marking, boxes: list[int], rank: dict[int, int]) -> None:
    attached, known = marking.attached, marking.known
    done = np.zeros(len(attached), np.bool_)
    ready: deque[int] = deque()
    half: list[tuple[int, int]] = []

    def look(box: int) -> None:
        """Put a box where it is waited for."""
        if done[box]:
            return
        low, high = marking.ends(box)
        if known[low] and known[high]:
            done[box] = True
            ready.append(box)
        elif known[low] or known[high]:
            heapq.heappush(half, (rank[box], box))

    sharing = _sharing(attached, marking.axis)
    for box in boxes:
        look(box)
    waiting = deque(boxes)
    while True:
        if ready:
            box = ready.popleft()
            for unknown in _from(marking, box):
                for other in sharing[unknown]:
                    look(other)
            continue
        if half:
            _, box = heapq.heappop(half)
            if done[box] or marking.is_known(box):
                look(box)
                continue
            low, high = marking.ends(box)
            _margin(marking, box, *((high, low) if known[low] else (low, high)))
        else:
            while waiting and done[waiting[0]]:
                waiting.popleft()
            if not waiting:
                return
            box = waiting.popleft()
            _free(marking, box)
        for unknown in marking.ends(box):
            for each in sharing[unknown]:
                look(each)


def _sharing(attached: Attached, axis: int) -> list[list[int]]:
    """The boxes that have a face with each unknown."""
    count = len(attached)
    found: list[list[int]] = [[] for _ in range(int(attached.faces[:, axis].max()) + 1)]
    for place, unknown in enumerate(attached.faces[:, axis].tolist()):
        found[unknown].append(place % count)
    return found


def _from(marking: Marking, box: int) -> list[int]:
    """Equations for the faces of neighbours that lie within a box whose faces are known."""
    attached, at, known = marking.attached, marking.at, marking.known
    low, high = marking.ends(box)
    near = attached.near[box].tolist()
    begin, end = at[low] - attached.tolerance, at[high] + attached.tolerance
    breaks = {(float(at[low]), low), (float(at[high]), high)}
    wanted: list[tuple[int, int]] = []
    for other in near:
        for face in marking.ends(other):
            if begin <= at[face] <= end:
                if known[face]:
                    breaks.add((float(at[face]), face))
                else:
                    wanted.append((face, other))
    ordered, found = sorted(breaks), []
    for face, other in sorted(wanted, key=lambda each: float(at[each[0]])):
        if known[face]:
            continue
        first, last = marking.ends(other)
        if other in marking.extents and face == last and known[first]:
            marking.offset("size", last, first, other)
            bisect.insort(ordered, (float(at[last]), last))
            found.append(face)
        elif marking.between(_kind(attached, box, other), face, ordered):
            found.append(face)
    return found


def _kind(attached: Attached, i: int, j: int) -> Kind:
    """What attaches two neighbours."""
    a, b = (i, j) if i < j else (j, i)
    low, high, near = attached.low, attached.high, attached.tolerance
    abut = (np.abs(high[a] - low[b]) <= near) | (np.abs(high[b] - low[a]) <= near)
    return BY_AXES[int(abut.sum())]


def _margin(marking: Marking, box: int, unknown: int, other: int) -> None:
    """A face keeps its distance from the nearest face within its box that is known: that of a
    neighbour, or the box's own on the other side, and so its size.
    """
    attached, at = marking.attached, marking.at
    x, near = float(at[unknown]), float(at[other])
    kind: Kind = "size"
    if box in marking.extents:
        marking.offset(kind, unknown, other, box)
        return
    side = 1.0 if x >= near else -1.0
    for each in attached.near[box].tolist():
        for face in marking.ends(each):
            beyond = side * (at[face] - near) > attached.tolerance
            if marking.known[face] and beyond and side * (x - at[face]) >= 0:
                near, other, kind = float(at[face]), face, _kind(attached, box, each)
    marking.offset(kind, unknown, other)


def _free(marking: Marking, box: int) -> None:
    """A box neither of whose faces is known: it keeps its margins around neighbours that are known,
    or its place.
    """
    at, known = marking.at, marking.known
    low, high = marking.ends(box)
    faces = [
        face
        for other in marking.attached.near[box].tolist()
        for face in marking.ends(other)
        if known[face]
    ]
    if not faces:
        for face in dict.fromkeys((low, high)):
            marking.note("position", ((face, 1.0),), float(at[face]))
            known[face] = True
        return
    marking.offset("size", low, min(faces, key=lambda face: float(at[face])))
    if not known[high]:
        _margin(marking, box, high, low)


# ------------------------------------------------------------------------------- solving


@dataclass(slots=True, eq=False)
class Stretching:
    """One axis of a building, factored: solve it for as many edits of the same faces as wanted."""

    marking: Marking
    fixed: Integers
    factored: Factored

    @property
    def equations(self) -> int:
        """How many equations there are, fixed faces included."""
        return len(self.marking.terms) + len(self.fixed)

    def solve(self, values: Floats) -> tuple[Floats, Floats]:
        """(n,) low and (n,) high faces of all boxes for values (f,) of the fixed faces."""
        found = self.factored.solve(values, self.marking.at)
        faces = self.marking.attached.faces[:, self.marking.axis]
        count = len(self.marking.attached)
        return found[faces[:count]], found[faces[count:]]


def stretching(
    attached: Attached,
    axis: int,
    fixed: Integers,
    edited: Sequence[int],
    extents: Mapping[int, float] | None = None,
) -> Stretching:
    """Collect and factor the equations along an axis; fixed (f,): unknowns that edits move;
    extents: boxes that get another size there.
    """
    marking = mark(attached, axis, fixed, edited, extents)
    return Stretching(marking, fixed, factor(_collected(marking), fixed))


def _collected(marking: Marking) -> Equations:
    weights = [WEIGHTS[kind] for kind in marking.kinds]
    return equations(marking.terms, marking.values, weights, len(marking.at))


def settle(own: Stretching, values: Floats) -> tuple[Floats, Floats] | None:
    """Solve, and hold what would break: boxes that flip, neighbours that part, what stands within
    another and would leave it. None if that does not settle.
    """
    for _ in range(ROUNDS):
        low, high = own.solve(values)
        broken = _broken(own.marking, low, high)
        if not broken:
            return low, high
        for kind, terms, value in broken:
            own.marking.note(kind, terms, value)
        own.factored = factor(_collected(own.marking), own.fixed)
    low, high = own.solve(values)
    return None if _broken(own.marking, low, high) else (low, high)


def _broken(
    marking: Marking, low: Floats, high: Floats
) -> list[tuple[Kind, tuple[Term, ...], float]]:
    """Equations for what a solution breaks."""
    attached, axis, near = marking.attached, marking.axis, 10 * marking.attached.tolerance
    before, after = high - low, attached.high[:, axis] - attached.low[:, axis]
    found: list[tuple[Kind, tuple[Term, ...], float]] = []
    for box in np.flatnonzero(before < LEAST * after - near).tolist():
        a, b = marking.ends(box)
        if a != b:
            found.append(("order", ((b, 1.0), (a, -1.0)), 2 * LEAST * float(after[box])))
    for inner, outer in _left(attached, axis, low, high, near).tolist():
        for face in marking.ends(inner):
            found += _share(marking, face, outer)
    return found


def _left(attached: Attached, axis: int, low: Floats, high: Floats, near: float) -> Integers:
    """(b, 2) pairs that lay within each other, or met, along an axis and do so no more."""
    old_low, old_high = attached.low[:, axis], attached.high[:, axis]
    both = np.concatenate([attached.pairs, attached.pairs[:, ::-1]])
    i, j = both.T
    within = (old_low[j] <= old_low[i] + near) & (old_high[i] <= old_high[j] + near)
    left = within & ((low[i] < low[j] - near) | (high[i] > high[j] + near))
    met = (old_low[i] <= old_high[j] + near) & (old_low[j] <= old_high[i] + near)
    apart = met & (low[i] > high[j] + near)
    return np.asarray(both[left | apart])


def _share(marking: Marking, face: int, outer: int) -> list[tuple[Kind, tuple[Term, ...], float]]:
    """A face keeps its share of another box."""
    a, b = marking.ends(outer)
    at = marking.at
    extent = float(at[b] - at[a])
    if extent <= marking.attached.tolerance or face in (a, b):
        return []
    share = float(at[face] - at[a]) / extent
    return [("order", ((face, 1.0), (a, share - 1.0), (b, -share)), 0.0)]


def warped(attached: Attached, axis: int, old: Floats, new: Floats) -> tuple[Floats, Floats]:
    """What a map of the whole axis makes of all boxes that takes the faces `old` (f,) to `new`
    (f,), straight between and shifted beyond: it breaks nothing, wherever faces keep their order.
    """
    order = np.argsort(old, kind="stable")
    old, new = old[order], new[order]

    def mapped(x: Floats) -> Floats:
        inside = np.interp(x, old, new)
        beyond = np.where(x < old[0], x - old[0], np.where(x > old[-1], x - old[-1], 0.0))
        return np.asarray(inside + beyond)

    return mapped(attached.low[:, axis]), mapped(attached.high[:, axis])
