"""The attachments of a building solved along an axis: where all faces go when some are moved.

In go boxes and the faces that an edit moves, out come all boxes (section 4.1 of Demir et al. 2016).
Equations are added to the marked ones only where a solution would break a relation: boxes that
flip, neighbours that part, what would leave what it stands in. The grammar is not known here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.edit.buildings.adjacency import Attached, Floats, Integers, attach
from ipmlang.edit.buildings.marking import Kind, Marking, mark
from ipmlang.edit.buildings.solving import Equations, Factored, Term, equations, factor

# volumes weigh less: a different overlap inside is hardly seen (section 4.1)
WEIGHTS: dict[Kind, float] = {
    "corner": 1.0, "edge": 1.0, "plane": 1.0, "volume": 0.3, "size": 0.5, "position": 0.2,
    "order": 100.0,
}  # fmt: skip
ROUNDS = 12  # of equations added where relations broke
LEAST = 0.02  # of its size that a box keeps at least


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
        """(n,) low and (n,) high faces of all boxes for values (f,) of the fixed unknowns."""
        found = self.factored.solve(values, np.array(self.marking.at))
        for unknown in self.marking.tied:
            root, apart = self.marking.root(unknown)
            found[unknown] = found[root] + apart
        attached, axis = self.marking.attached, self.marking.axis
        places = found[attached.faces[:, axis]] + attached.off[:, axis]
        return places[: len(attached)], places[len(attached) :]


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
    """The equations, in what unknowns hang on where they hang on others."""
    weights = [WEIGHTS[kind] for kind in marking.kinds]
    terms, values = marking.terms, marking.values
    if marking.tied:
        roots = [[(*marking.root(each), factor) for each, factor in own] for own in terms]
        values = [
            value - sum(apart * factor for _, apart, factor in own)
            for value, own in zip(values, roots, strict=True)
        ]
        terms = [tuple((root, factor) for root, _, factor in own) for own in roots]
    return equations(terms, values, weights, len(marking.at))


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
        a, b = marking.faces[box]
        if a != b:
            found.append(("order", ((b, 1.0), (a, -1.0)), 2 * LEAST * float(after[box])))
    for inner, outer in _left(attached, axis, low, high, near).tolist():
        for face, at in zip(marking.faces[inner], (low[inner], high[inner]), strict=True):
            stays = low[outer] - near <= at <= high[outer] + near
            if face not in marking.across or not stays:  # one that gets a size keeps it
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
    a, b = marking.faces[outer]
    at = marking.at
    extent = at[b] - at[a]
    if extent <= marking.attached.tolerance or face in (a, b):
        return []
    share = (at[face] - at[a]) / extent
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


__all__ = ["Attached", "attach", "mark", "settle", "stretching", "warped"]
