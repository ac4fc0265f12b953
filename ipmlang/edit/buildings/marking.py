"""The seven attachments between the boxes of a building, as equations for where their faces go.

In go boxes and the faces that an edit moves, out come equations. After section 4.1 of Demir et al.
2016: ground, corner, edge, plane, volume, size, position; axes are independent. Faces that coincide
are one unknown already. Boxes are marked breadth first from the edited ones: each unknown gets one
equation. Overlaps are kept as shares between the nearest faces that are known, which keeps order
too. Nothing is solved here.
"""

from __future__ import annotations

import bisect
import heapq
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np

from ipmlang.edit.buildings.adjacency import Attached, Floats, Integers
from ipmlang.edit.buildings.solving import Term

Kind: TypeAlias = Literal["corner", "edge", "plane", "volume", "size", "position", "order"]
Breaks: TypeAlias = list[tuple[float, int]]
BY_AXES: tuple[Kind, ...] = ("volume", "plane", "edge", "corner")  # that a pair abuts along


@dataclass(slots=True, eq=False)
class Marking:
    """Equations along one axis while they are collected; faces: the two unknowns of each box; at:
    where each unknown is now; known: which have an equation; fresh: of these the last ones; across:
    the unknowns that lie across a box that gets another size, and how far they shall be away; tied:
    those that hang on another one by that, and have no equation of their own.
    """

    attached: Attached
    axis: int
    faces: list[tuple[int, int]]
    at: list[float]
    known: list[bool]
    terms: list[tuple[Term, ...]] = field(default_factory=list)
    values: list[float] = field(default_factory=list)
    kinds: list[Kind] = field(default_factory=list)
    fresh: list[int] = field(default_factory=list)
    across: dict[int, list[tuple[int, float]]] = field(default_factory=dict)
    tied: dict[int, tuple[int, float]] = field(default_factory=dict)

    def know(self, unknown: int) -> None:
        """An unknown has its equation; what lies across a box that gets a size hangs on it."""
        self.known[unknown] = True
        self.fresh.append(unknown)
        for other, apart in self.across.get(unknown, ()):
            if not self.known[other]:
                self.tied[other] = unknown, apart
                self.know(other)

    def note(self, kind: Kind, terms: Sequence[Term], value: float) -> None:
        """One equation."""
        self.terms.append(tuple(terms))
        self.values.append(value)
        self.kinds.append(kind)

    def root(self, unknown: int) -> tuple[int, float]:
        """What an unknown hangs on in the end, and how far it is from that."""
        apart = 0.0
        while unknown in self.tied:
            unknown, more = self.tied[unknown]
            apart += more
        return unknown, apart

    def is_beside(self, face: int, other: int) -> bool:
        """Whether a box between two unknowns begins or ends, with the second one, where a box does
        that gets another size, and lies outside of that.
        """
        ends = [self.at[each] for each, _ in self.across.get(other, ())]
        x = self.at[other]
        return bool(ends) and all((end - x) * (self.at[face] - x) < 0 for end in ends)

    def between(self, kind: Kind, unknown: int, breaks: Breaks) -> None:
        """An unknown keeps its share between the faces beside it, unless it is outside."""
        x = self.at[unknown]
        place = bisect.bisect_left(breaks, (x, -1))
        for near in breaks[max(place - 1, 0) : place + 1]:
            if abs(near[0] - x) <= self.attached.tolerance:
                self.note(kind, ((unknown, 1.0), (near[1], -1.0)), x - near[0])
                break
        else:
            if not 0 < place < len(breaks):
                return
            (p, first), (q, second) = breaks[place - 1], breaks[place]
            share = (x - p) / (q - p)
            terms = ((unknown, 1.0), (first, share - 1.0), (second, -share))
            self.note(kind, terms, 0.0)
        begin = len(self.fresh)
        self.know(unknown)
        for each in self.fresh[begin:]:
            if breaks[0][0] <= self.at[each] <= breaks[-1][0]:
                bisect.insort(breaks, (self.at[each], each))

    def offset(self, kind: Kind, unknown: int, other: int) -> None:
        """An unknown keeps its distance from a known one."""
        apart = self.at[unknown] - self.at[other]
        self.note(kind, ((unknown, 1.0), (other, -1.0)), apart)
        self.know(unknown)


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
    numbers, count = attached.faces[:, axis], len(attached)
    at = np.zeros(int(numbers.max()) + 1)
    at[numbers] = np.concatenate([attached.low, attached.high])[:, axis] - attached.off[:, axis]
    known = [False] * len(at)
    faces = list(zip(numbers[:count].tolist(), numbers[count:].tolist(), strict=True))
    marking = Marking(attached, axis, faces, at.tolist(), known)
    for box, size in (extents or {}).items():
        low, high = faces[box]
        if low != high:
            marking.across.setdefault(low, []).append((high, size))
            marking.across.setdefault(high, []).append((low, -size))
    for face in fixed.tolist():
        known[face] = True
    for face in fixed.tolist():
        marking.know(face)
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
    known, faces = marking.known, marking.faces
    done = [False] * len(faces)
    ready: deque[int] = deque()
    half: list[tuple[int, int]] = []

    def look(box: int) -> None:
        """Put a box where it is waited for."""
        if done[box]:
            return
        low, high = faces[box]
        if known[low] and known[high]:
            done[box] = True
            ready.append(box)
        elif known[low] or known[high]:
            heapq.heappush(half, (rank[box], box))

    sharing = _sharing(marking)
    for box in boxes:
        look(box)
    waiting = deque(boxes)
    while True:
        if ready:
            _from(marking, ready.popleft())
        elif half:
            _, box = heapq.heappop(half)
            low, high = faces[box]
            if done[box] or (known[low] and known[high]):
                look(box)
                continue
            inside = _to_be_resized(marking, box)
            if inside is not None:
                _free(marking, inside)
                look(inside)
                heapq.heappush(half, (rank[box], box))
            else:
                _margin(marking, box, *((high, low) if known[low] else (low, high)))
        else:
            while waiting and done[waiting[0]]:
                waiting.popleft()
            if not waiting:
                return
            box = waiting.popleft()
            _free(marking, box)
            look(box)
        for unknown in marking.fresh:
            for each in sharing[unknown]:
                look(each)
        marking.fresh.clear()


def _sharing(marking: Marking) -> list[list[int]]:
    """The boxes that have a face with each unknown."""
    found: list[list[int]] = [[] for _ in marking.at]
    for box, (low, high) in enumerate(marking.faces):
        found[low].append(box)
        if high != low:
            found[high].append(box)
    return found


def _from(marking: Marking, box: int) -> None:
    """Equations for the faces of neighbours that lie within a box whose faces are known: they keep
    their shares of it, those that get another size their distance from its low face, and what
    begins or ends with those its size.
    """
    at, known, tolerance = marking.at, marking.known, marking.attached.tolerance
    low, high = marking.faces[box]
    begin, end = at[low] - tolerance, at[high] + tolerance
    breaks = {(at[low], low), (at[high], high)}
    wanted: list[tuple[float, int, int, int]] = []
    for other, abut in marking.attached.near[box]:
        for face in marking.faces[other]:
            if begin <= at[face] <= end:
                if known[face]:
                    breaks.add((at[face], face))
                else:
                    wanted.append((at[face], face, other, abut))
    wanted.sort()
    for _, face, _, abut in wanted:
        if face in marking.across and not known[face]:
            marking.offset(BY_AXES[abut], face, low)
    breaks |= {(place, face) for place, face, *_ in wanted if known[face]}
    ordered = sorted(breaks)
    for _, face, other, abut in wanted:
        if known[face]:
            continue
        first, last = marking.faces[other]
        across = last if face == first else first
        if known[across] and marking.is_beside(face, across):
            marking.offset("size", face, across)
            bisect.insort(ordered, (at[face], face))
        else:
            marking.between(BY_AXES[abut], face, ordered)


def _to_be_resized(marking: Marking, box: int) -> int | None:
    """A neighbour within a box that gets another size and is not known yet: the box is as large as
    that lets it.
    """
    at, tolerance = marking.at, marking.attached.tolerance
    begin, end = (at[face] for face in marking.faces[box])
    for other, _ in marking.attached.near[box]:
        low, high = marking.faces[other]
        within = begin - tolerance <= at[low] and at[high] <= end + tolerance
        if within and low in marking.across and not (marking.known[low] or marking.known[high]):
            return other
    return None


def _margin(marking: Marking, box: int, unknown: int, other: int) -> None:
    """A face keeps its distance from the nearest face within its box that is known: that of a
    neighbour, or the box's own on the other side, and so its size.
    """
    at, tolerance = marking.at, marking.attached.tolerance
    x, near = at[unknown], at[other]
    kind: Kind = "size"
    side = 1.0 if x >= near else -1.0
    for each, abut in marking.attached.near[box]:
        for face in marking.faces[each]:
            beyond = side * (at[face] - near) > tolerance
            if marking.known[face] and beyond and side * (x - at[face]) >= 0:
                near, other, kind = at[face], face, BY_AXES[abut]
    marking.offset(kind, unknown, other)


def _free(marking: Marking, box: int) -> None:
    """A box neither of whose faces is known: it keeps its margins around neighbours that are known,
    or its place, and gets the size that it is to have.
    """
    at, known = marking.at, marking.known
    low, high = marking.faces[box]
    faces = [
        face
        for other, _ in marking.attached.near[box]
        for face in marking.faces[other]
        if known[face]
    ]
    if not faces:
        for face in dict.fromkeys((low, high)):
            if not known[face]:
                marking.note("position", ((face, 1.0),), at[face])
                marking.know(face)
        return
    marking.offset("size", low, min(faces, key=lambda face: at[face]))
    if not known[high]:
        _margin(marking, box, high, low)
