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
    where each unknown is now; known: which have an equation; extents: boxes that get another size,
    with that size.
    """

    attached: Attached
    axis: int
    faces: list[tuple[int, int]]
    at: list[float]
    known: list[bool]
    terms: list[tuple[Term, ...]] = field(default_factory=list)
    values: list[float] = field(default_factory=list)
    kinds: list[Kind] = field(default_factory=list)
    extents: Mapping[int, float] = field(default_factory=dict)

    def note(self, kind: Kind, terms: Sequence[Term], value: float) -> None:
        """One equation."""
        self.terms.append(tuple(terms))
        self.values.append(value)
        self.kinds.append(kind)

    def between(self, kind: Kind, unknown: int, breaks: Breaks) -> bool:
        """An unknown keeps its share between the faces beside it; no, if it is outside."""
        x = self.at[unknown]
        place = bisect.bisect_left(breaks, (x, -1))
        for near in breaks[max(place - 1, 0) : place + 1]:
            if abs(near[0] - x) <= self.attached.tolerance:
                self.note(kind, ((unknown, 1.0), (near[1], -1.0)), x - near[0])
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
        apart = self.at[unknown] - self.at[other]
        if box in self.extents and {unknown, other} == set(self.faces[box]):
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
    numbers, count = attached.faces[:, axis], len(attached)
    at = np.zeros(int(numbers.max()) + 1)
    at[numbers] = np.concatenate([attached.low, attached.high])[:, axis] - attached.off[:, axis]
    known = [False] * len(at)
    for face in fixed.tolist():
        known[face] = True
    faces = list(zip(numbers[:count].tolist(), numbers[count:].tolist(), strict=True))
    marking = Marking(attached, axis, faces, at.tolist(), known, extents=extents or {})
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
            box = ready.popleft()
            for unknown in _from(marking, box):
                for other in sharing[unknown]:
                    look(other)
            continue
        if half:
            _, box = heapq.heappop(half)
            low, high = faces[box]
            if done[box] or (known[low] and known[high]):
                look(box)
                continue
            _margin(marking, box, *((high, low) if known[low] else (low, high)))
        else:
            while waiting and done[waiting[0]]:
                waiting.popleft()
            if not waiting:
                return
            box = waiting.popleft()
            _free(marking, box)
        for unknown in marking.faces[box]:
            for each in sharing[unknown]:
                look(each)


def _sharing(marking: Marking) -> list[list[int]]:
    """The boxes that have a face with each unknown."""
    found: list[list[int]] = [[] for _ in marking.at]
    for box, (low, high) in enumerate(marking.faces):
        found[low].append(box)
        if high != low:
            found[high].append(box)
    return found


def _from(marking: Marking, box: int) -> list[int]:
    """Equations for the faces of neighbours that lie within a box whose faces are known."""
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
    if not wanted:
        return []
    ordered, found = sorted(breaks), []
    for place, face, other, abut in sorted(wanted):
        if known[face]:
            continue
        first, last = marking.faces[other]
        if other in marking.extents and face == last and known[first]:
            marking.offset("size", last, first, other)
            bisect.insort(ordered, (place, last))
            found.append(face)
        elif marking.between(BY_AXES[abut], face, ordered):
            found.append(face)
    return found


def _margin(marking: Marking, box: int, unknown: int, other: int) -> None:
    """A face keeps its distance from the nearest face within its box that is known: that of a
    neighbour, or the box's own on the other side, and so its size.
    """
    at, tolerance = marking.at, marking.attached.tolerance
    x, near = at[unknown], at[other]
    kind: Kind = "size"
    if box in marking.extents:
        marking.offset(kind, unknown, other, box)
        return
    side = 1.0 if x >= near else -1.0
    for each, abut in marking.attached.near[box]:
        for face in marking.faces[each]:
            beyond = side * (at[face] - near) > tolerance
            if marking.known[face] and beyond and side * (x - at[face]) >= 0:
                near, other, kind = at[face], face, BY_AXES[abut]
    marking.offset(kind, unknown, other)


def _free(marking: Marking, box: int) -> None:
    """A box neither of whose faces is known: it keeps its margins around neighbours that are known,
    or its place.
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
            marking.note("position", ((face, 1.0),), at[face])
            known[face] = True
        return
    marking.offset("size", low, min(faces, key=lambda face: at[face]))
    if not known[high]:
        _margin(marking, box, high, low)
