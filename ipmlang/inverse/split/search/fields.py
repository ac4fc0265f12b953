"""Fields: the rows of a draft made ready for two questions, what stands there and what is near.

Built once for a draft, on k-d trees; answers are rows of its table. Lookups compare whole frames
modulo the symmetry of the symbol. Nothing here decides what is worth a rule.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ipmlang.inverse.frames import Floats, Integers, matrices
from ipmlang.inverse.split.search.drafts import Draft, boxes, points
from ipmlang.inverse.split.snapping import Flags, members

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

AROUND = 12  # nearest rows by their centers
TOUCHING = 16  # rows whose boxes touch, at most
FEW = 400  # boxes that are all compared with each other
SAME = 4  # rows that may share a center


@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """points: (n, 4, 3) probes; matrix: (n, 3, 4) of each row; tree: of centers and what must be
    equal, as numbers that are `apart`; begin (n + 1,), near: the neighbours of row i are
    near[begin[i]:begin[i + 1]]; images: of all figures that have as many, `round` says how many
    each has and `number` which are its own.
    """

    draft: Draft
    points: Floats
    matrix: Floats
    tree: cKDTree
    apart: float
    begin: Integers
    near: Integers
    images: dict[int, Floats]
    round: Integers
    number: Integers

    def around(self, rows: Integers) -> Integers:
        """Rows near to any of these, in order, these left out."""
        count = self.begin[rows + 1] - self.begin[rows]
        first = np.repeat(self.begin[rows] - np.cumsum(count) + count, count)
        near = np.zeros(len(self.draft), np.bool_)
        near[self.near[first + np.arange(len(first))]] = True
        near[rows] = False
        return np.nonzero(near)[0]


def field_of(draft: Draft, neighbours: bool = True) -> Field:
    """The field of a draft; neighbours: whether it will be asked what is near."""
    from scipy.spatial import cKDTree

    placed = points(draft)
    extent = float(np.ptp(placed.reshape(-1, 3), axis=0).max()) if len(placed) else 1.0
    apart = 4 * extent + 1.0
    key = draft.body * len(draft.figures) + draft.symbol
    tree = cKDTree(np.concatenate([placed[:, 0], apart * key[:, None]], axis=1))
    begin, near = np.zeros(len(draft) + 1, np.int64), np.zeros(0, np.int64)
    if neighbours:
        begin, near = _neighbours(draft, placed[:, 0], apart)
    matrix = matrices(draft.frames)
    return Field(draft, placed, matrix, tree, apart, begin, near, *_images(draft))


def look_up(
    field: Field, wanted: Floats, symbol: Integers, body: Integers, error: float
) -> Integers:
    """(p,) the rows that stand as probes (p, 4, 3) say, -1 where none does."""
    found = np.full(len(wanted), -1, np.int64)
    if len(wanted) == 0:
        return found
    ask, row = _near(field, wanted[:, 0], body * len(field.draft.figures) + symbol, error)
    good = agree(field, row, wanted[ask], error)
    found[ask[good][::-1]] = row[good][::-1]  # the nearest is written last
    return found


def look_up_moved(
    field: Field, rows: Integers, motion: Floats, body: Integers, error: float
) -> Integers:
    """(x, a) the rows that stand where motions (a, 3, 4), each into a body (a,), take rows (x,), -1
    where none does.
    """
    count, ways = len(rows), len(motion)
    found = np.full(count * ways, -1, np.int64)
    if found.size == 0:
        return found.reshape(count, ways)
    turn, move = motion[:, :, :3], motion[:, :, 3]
    center = field.points[rows, 0] @ turn.reshape(-1, 3).T + move.reshape(-1)
    symbol = field.draft.symbol[rows]
    key = body[None] * len(field.draft.figures) + symbol[:, None]
    ask, row = _near(field, center.reshape(-1, 3), key.reshape(-1), error)
    way = ask % ways
    wanted = field.points[rows[ask // ways]] @ turn[way].transpose(0, 2, 1) + move[way, None]
    good = agree(field, row, wanted, error)
    found[ask[good][::-1]] = row[good][::-1]
    return found.reshape(count, ways)


def _near(field: Field, center: Floats, key: Integers, error: float) -> tuple[Integers, Integers]:
    """Which of p centers have a row of their key close by, and which row: the nearest first."""
    spots = np.concatenate([center, field.apart * key[:, None]], axis=1)
    near = np.asarray(field.tree.query(spots, k=SAME, distance_upper_bound=error)[1])
    ask, rank = np.nonzero(near < len(field.draft))
    return ask, near[ask, rank]


def agree(field: Field, rows: Integers, wanted: Floats, error: float) -> Flags:
    """(p,) whether rows stand as probes (p, 4, 3) say, up to their symbols' symmetry."""
    away = field.points[rows] - wanted
    good = np.asarray(np.sqrt(np.einsum("pkj,pkj->pk", away, away)).max(axis=1) <= error)
    turned = np.flatnonzero(~good)  # most stand as they are
    if len(turned):
        good[turned] = standing(field, rows[turned], wanted[turned])[0] <= error
    return good


def standing(field: Field, rows: Integers, wanted: Floats) -> tuple[Floats, Floats]:
    """(p,) how far probes (p, 4, 3) are from those of rows, and (p, 4, 3) these, under the symmetry
    of their symbols that brings them nearest.
    """
    off, there = np.zeros(len(rows)), np.zeros((len(rows), 4, 3))
    symbol = field.draft.symbol[rows]
    many, number = field.round[symbol], field.number[symbol]
    for each, images in field.images.items():
        own = np.nonzero(many == each)[0]
        step = max(1, 200_000 // each)
        for begin in range(0, len(own), step):
            some = own[begin : begin + step]
            matrix = field.matrix[rows[some]]
            off[some], there[some] = _nearest_image(images[number[some]], matrix, wanted[some])
    return off, there


def _nearest_image(images: Floats, matrix: Floats, wanted: Floats) -> tuple[Floats, Floats]:
    """(n,) how far probes at (n, 4, 3) are from the nearest of images (n, s, 4, 3) under maps
    (n, 3, 4), and (n, 4, 3) that one.
    """
    count, many = images.shape[:2]
    outer = images.reshape(-1, 4 * many, 3) @ matrix[:, :, :3].transpose(0, 2, 1)
    outer += matrix[:, None, :, 3]
    outer = outer.reshape(-1, many, 4, 3)
    away = outer - wanted[:, None]
    square = np.einsum("nskj,nskj->nsk", away, away).max(axis=2)
    best = square.argmin(axis=1)
    row = np.arange(count)
    return np.sqrt(square[row, best]), outer[row, best]


def _images(draft: Draft) -> tuple[dict[int, Floats], Integers, Integers]:
    """The images of all figures by how many they have; for each figure that number, and its place
    there.
    """
    many = np.array([len(shape.symmetry) for shape in draft.figures], np.int64)
    number = np.zeros(len(many), np.int64)
    images = {}
    for each in np.unique(many).tolist():
        own = np.nonzero(many == each)[0]
        number[own] = np.arange(len(own))
        images[each] = np.stack([draft.figures[index].images for index in own.tolist()])
    return images, many, number


def _neighbours(draft: Draft, center: Floats, apart: float) -> tuple[Integers, Integers]:
    """Rows of the same body that touch or are nearest, in both directions."""
    from scipy.spatial import cKDTree

    count = len(draft)
    if count < 2:
        return np.zeros(count + 1, np.int64), np.zeros(0, np.int64)
    spots = np.concatenate([center, apart * draft.body[:, None]], axis=1)
    near = np.asarray(cKDTree(spots).query(spots, k=min(AROUND + 1, count))[1])
    first = np.repeat(np.arange(count), near.shape[1])
    second = near.ravel()
    touch = _touching(draft, center)
    first, second = np.concatenate([first, touch[0]]), np.concatenate([second, touch[1]])
    inside = (first != second) & (draft.body[first] == draft.body[second])
    first, second = first[inside], second[inside]
    both = np.unique(np.concatenate([first * count + second, second * count + first]))
    return np.searchsorted(both, np.arange(count + 1) * count), both % count


def _touching(draft: Draft, center: Floats) -> tuple[Integers, Integers]:
    """Pairs of rows whose boxes meet; of each row the nearest few, by their centers."""
    low, high = boxes(draft)
    slack = 1e-3 * float(np.ptp(center, axis=0).max() + 1e-9)
    pairs = [(np.zeros(0, np.int64), np.zeros(0, np.int64))]
    for rows in members(draft.body, draft.bodies):
        if len(rows) < 2:
            continue
        one, two = _meeting(low[rows], high[rows], slack)
        one, two = rows[one], rows[two]
        pairs.append(_nearest(one, two, np.linalg.norm(center[one] - center[two], axis=1)))
    return (
        np.concatenate([pair[0] for pair in pairs]),
        np.concatenate([pair[1] for pair in pairs]),
    )


def _meeting(low: Floats, high: Floats, slack: float) -> tuple[Integers, Integers]:
    """Pairs of boxes that meet, or nearly, in both directions."""
    wide = np.array([slack, slack, 0.0])
    begin, end = low - wide, high + wide
    if len(low) <= FEW:
        apart = (begin[:, None] > end[None] + (slack - wide)).any(axis=2)
        one, two = np.nonzero(~(apart | apart.T))
    else:
        import shapely

        flat = shapely.box(*begin[:, :2].T, *end[:, :2].T)
        one, two = shapely.STRtree(flat).query(flat)
        meets = (low[one, 2] <= high[two, 2] + slack) & (low[two, 2] <= high[one, 2] + slack)
        one, two = one[meets], two[meets]
    return one[one != two], two[one != two]


def _nearest(one: Integers, two: Integers, distance: Floats) -> tuple[Integers, Integers]:
    """Of every row in `one` the pairs with the smallest distances."""
    order = np.lexsort((two, np.round(distance, 9), one))
    one, two = one[order], two[order]
    rank = np.arange(len(one)) - np.searchsorted(one, one)
    return one[rank < TOUCHING], two[rank < TOUCHING]
