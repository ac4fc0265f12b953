"""Rare corners by which parts are laid on each other.

Takes model parts; gives for each one corner that few others are like, finds the corners of other
parts that may be the same one, and the maps that each of these makes. All is about the parts'
centres, in batches; nothing is proved here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.distinct import distinct_numbers
from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.parts.copies import Copies, Truths
from ipmlang.inverse.parts.invariants import mixed

_MIRRORED = [0, 2, 1, 4, 3]  # lengths of a corner as those of its mirror image


@dataclass(frozen=True, slots=True, eq=False)
class Anchors:
    """A rare corner of each of m models. lengths (m, 1, 5): what it is known by; look (m, 1): its
    hash; axes (m, 3, 3): what it and the corner after it give, as columns; slack (m,): how far off
    maps made from it may be; firm (m,): False where all corners lie in one line through the centre.
    """

    lengths: Floats
    look: NDArray[np.uint64]
    axes: Floats
    slack: Floats
    firm: Truths
    tolerance: float

    @classmethod
    def of(cls, models: Copies, lengths: Floats, tolerance: float) -> Anchors:
        """The rarest corner of each model among those that stand well apart from the centre, by the
        lengths of its corners.
        """
        row = np.arange(len(models))
        points = models.points[row[:, None], models.corners]
        ahead = points[row[:, None], models.after]
        lever = _lever(points, ahead)
        widest, reach = lever.max(axis=1), lengths[:, :, 0].max(axis=1)
        unit = np.maximum(64 * tolerance, 1e-6 * reach)[:, None, None]
        often = _how_often(np.rint(lengths / unit), models.look)
        wide = lever / np.maximum(widest, 1e-300)[:, None]
        # Of equally rare ones the widest, of these the first.
        cost = np.where(wide >= 0.3, often - 0.5 * np.round(wide, 3), np.inf)
        best = np.argmin(cost, axis=1)
        at, beyond = points[row, best], ahead[row, best]
        far = np.sqrt(np.maximum((at**2).sum(axis=1), (beyond**2).sum(axis=1)))
        slack = 4 * tolerance * reach * far / np.maximum(lever[row, best], 1e-300)
        firm = widest > np.maximum(1e-9 * reach, tolerance) * reach
        axes = _axes(at, beyond, np.ones(len(row)))
        known, look = lengths[row, best][:, None], models.look[row, best][:, None]
        return cls(known, look, axes, slack, firm, tolerance)

    def candidates(self, copies: Copies, lengths: Floats) -> tuple[Integers, Integers, Truths]:
        """Row and corner of all that may be the anchor of their model (or of the one there is), and
        whether faces run as the model's do; by rows, those that do first.
        """
        close = 4 * self.tolerance
        seen = (copies.look == self.look) & self.firm[:, None]
        plain = (np.abs(lengths - self.lengths) <= close).all(axis=2) & seen
        mirrored = (np.abs(lengths[:, :, _MIRRORED] - self.lengths) <= close).all(axis=2) & seen
        (row, corner), (other_row, other_corner) = np.nonzero(plain), np.nonzero(mirrored)
        forward = np.arange(len(row) + len(other_row)) < len(row)
        row, corner = np.append(row, other_row), np.append(corner, other_corner)
        order = np.lexsort([corner, ~forward, row])
        return row[order], corner[order], forward[order]

    def maps(self, copies: Copies, row: Integers, corner: Integers, forward: Truths) -> Floats:
        """The maps (q, 3, 3) that bring anchors to corners of rows."""
        beyond = np.where(forward, copies.after[row, corner], copies.before[row, corner])
        points = copies.points[row, copies.corners[row, corner]]
        ahead = copies.points[row, copies.corners[row, beyond]]
        own = self.axes[row] if len(self.axes) > 1 else self.axes
        return _axes(points, ahead, np.where(forward, 1.0, -1.0)) @ own.transpose(0, 2, 1)


def _lever(points: Floats, ahead: Floats) -> Floats:
    """The lengths (k, c) of cross products: what a corner and the next one span with the centre."""
    product = np.einsum("kci,kci->kc", points, ahead)
    square = np.einsum("kci,kci->kc", points, points) * np.einsum("kci,kci->kc", ahead, ahead)
    return np.asarray(np.sqrt(np.maximum(square - product**2, 0.0)))


def corner_lengths(copies: Copies) -> Floats:
    """What corners (k, c, 5) are known by: how far from the centre they and their neighbours are,
    and from these.
    """
    row = np.arange(len(copies))[:, None]
    points = copies.points[row, copies.corners]
    ahead = points[row, copies.after] - points
    far = np.sqrt(np.einsum("kci,kci->kc", points, points))
    edge = np.sqrt(np.einsum("kci,kci->kc", ahead, ahead))
    after, before = copies.after, copies.before
    columns = (far, edge, edge[row, before], far[row, after], far[row, before])
    return np.stack(columns, axis=2)


def _how_often(lengths: Floats, look: NDArray[np.uint64]) -> Integers:
    """How many corners of its part are like each (k, c), its mirror images among them."""
    columns = np.moveaxis(lengths.astype(np.int64).view(np.uint64), 2, 0)
    far, ahead, behind, next_far, last_far = columns
    # What stands before and after a corner counts alike.
    sides = mixed(mixed(ahead) ^ next_far) + mixed(mixed(behind) ^ last_far)
    part = mixed(np.arange(len(look), dtype=np.uint64))[:, None]
    hashed = mixed(mixed(far) + mixed(sides) ^ look) + part
    _, kind = distinct_numbers(hashed.reshape(-1))
    return np.asarray(np.bincount(kind)[kind].reshape(look.shape))


def _axes(first: Floats, second: Floats, sign: Floats) -> Floats:
    """Unit axes (q, 3, 3), as columns: along the first, toward the second, and across."""
    x = first / np.maximum(np.linalg.norm(first, axis=1, keepdims=True), 1e-300)
    y = second - np.einsum("qi,qi->q", x, second)[:, None] * x
    y = y / np.maximum(np.linalg.norm(y, axis=1, keepdims=True), 1e-300)
    return np.stack([x, y, np.cross(x, y) * sign[:, None]], axis=2)
