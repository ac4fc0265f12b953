"""Drafts made into schemes: symbols in order, boxes from the vertices, items from the patterns.

Takes parts and a draft of them; gives a scheme whose rules all begin at the low corner of what they
draw. Also the flat scheme, and how far a scheme is from the parts it stands for.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipmlang.formats.distinct import distinct_rows
from ipmlang.inverse.frames import Floats, Frames, Integers, compose, moved_to, spread
from ipmlang.inverse.parts.observation import Parts
from ipmlang.inverse.split.changing import needed
from ipmlang.inverse.split.expansion import expand
from ipmlang.inverse.split.scheme import Item, Place, Rule, Scheme, Symbol, Terminal
from ipmlang.inverse.split.search.drafts import Draft, Limits
from ipmlang.inverse.split.search.figures import Figure, misses, of_class, probed, simplest
from ipmlang.inverse.split.search.patterns import Memory, arranged

CROWD = 400  # points above which only those on the outside are kept


def terminals(parts: Parts) -> tuple[Terminal, ...]:
    """One for each class, in order."""
    return tuple(
        Terminal(part.name, np.asarray(part.size, np.float64), index)
        for index, part in enumerate(parts.classes)
    )


def flat(parts: Parts) -> Scheme:
    """Every part by itself."""
    origin = parts.low.min(axis=0) if len(parts.low) else np.zeros(3)
    frames = compose(moved_to(-origin[None]), parts.frames)
    items = tuple(
        Place(index, simplest(of_class(part), frames[part.members], 1e-9 * parts.diagonal))
        for index, part in enumerate(parts.classes)
        if len(part.members)
    )
    size = parts.high.max(axis=0) - origin if len(parts.high) else np.zeros(3)
    return _scheme([*terminals(parts), Rule("", size, items)], moved_to(origin[None]))


def _scheme(symbols: Sequence[Symbol], frame: Frames) -> Scheme:
    """The scheme of the last symbol and all that it needs."""
    return Scheme(needed(symbols, len(symbols) - 1)[0], frame)


def assembled(parts: Parts, draft: Draft, origin: Floats, limits: Limits, memory: Memory) -> Scheme:
    """The scheme that a draft of parts, in coordinates that begin at `origin`, stands for."""
    order = _order(draft)
    number = {body: len(parts.classes) + index for index, body in enumerate(order)}
    outside: dict[int, Floats] = {
        index: _outside(part.mesh.vertices) for index, part in enumerate(parts.classes)
    }
    corner: dict[int, Floats] = {}
    symbols: list[Symbol] = list(terminals(parts))
    for body in order:
        rows = np.nonzero(draft.body == body)[0]
        frames = _moved(draft, rows, corner)
        cloud = _outside(_cloud(draft.symbol[rows], frames, outside))
        low = cloud.min(axis=0) if len(cloud) else np.zeros(3)
        symbol = draft.classes + body - 1
        if body > 0:
            corner[symbol], outside[symbol] = low, cloud - low
        else:
            corner[-1] = low
        frames = compose(moved_to(-low[None]), frames)
        items: list[Item] = []
        for each in np.unique(draft.symbol[rows]).tolist():
            own = frames[np.nonzero(draft.symbol[rows] == each)[0]]
            name = each if each < draft.classes else number[each - draft.classes + 1]
            shape = _cornered(draft.figures[each], corner.get(each))
            items += arranged(shape, own, name, limits, memory).items
        size = cloud.max(axis=0) - low if len(cloud) else np.zeros(3)
        symbols.append(Rule("", size, tuple(items)))
    return _scheme(symbols, moved_to((origin + corner[-1])[None]))


def _order(draft: Draft) -> list[int]:
    """Bodies that have rows, each before those that place it; the axiom last."""
    used: dict[int, set[int]] = {
        body: {
            symbol - draft.classes + 1
            for symbol in np.unique(draft.symbol[draft.body == body]).tolist()
            if symbol >= draft.classes
        }
        for body in [*np.unique(draft.body[draft.body > 0]).tolist(), 0]
    }
    order: list[int] = []
    while used:
        ready = min((body for body, needs in used.items() if needs <= set(order)), key=_late)
        order.append(ready)
        del used[ready]
    return order


def _late(body: int) -> tuple[bool, int]:
    return body == 0, body


def _moved(draft: Draft, rows: Integers, corner: dict[int, Floats]) -> Frames:
    """Frames of rows, now that some symbols begin elsewhere."""
    begin = np.zeros((len(rows), 3))
    for index, symbol in enumerate(draft.symbol[rows].tolist()):
        if symbol in corner:
            begin[index] = corner[symbol]
    return compose(draft.frames[rows], moved_to(begin))


def _cloud(symbol: Integers, frames: Frames, outside: dict[int, Floats]) -> Floats:
    found = [np.zeros((0, 3))]
    for each in np.unique(symbol).tolist():
        own = frames[np.nonzero(symbol == each)[0]]
        found.append(spread(own, outside[each]).reshape(-1, 3))
    return np.concatenate(found)


def _outside(points: Floats) -> Floats:
    """Points on the outside of all; enough of them for any box around them."""
    points = points[distinct_rows(points)[0]]
    if len(points) <= CROWD:
        return points
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(points[np.sort(ConvexHull(points).vertices)])
    except QhullError:
        return points


def _cornered(shape: Figure, low: Floats | None) -> Figure:
    """A figure in coordinates that begin at `low`."""
    if low is None:
        return shape
    back = moved_to(-low[None])
    symmetry = compose(compose(back, shape.symmetry), moved_to(low[None]))
    images = spread(symmetry, shape.probes - low)
    return Figure(shape.low - low, shape.high - low, shape.center - low, symmetry, images)


def largest_error(parts: Parts, scheme: Scheme) -> float:
    """Units that a part is off at most; infinite where one is missing or too many."""
    return float(errors(parts, scheme).max(initial=0.0))


def errors(parts: Parts, scheme: Scheme) -> Floats:
    """(n,) units that each part is off; infinite where one is missing or too many."""
    rows, error = matched(parts, scheme)
    found = np.full(len(parts.shape), np.inf)
    found[rows] = error
    return found


def matched(parts: Parts, scheme: Scheme) -> tuple[Integers, Floats]:
    """(n,) the part that each terminal drawn stands for, in the order of expansion, and units that
    it is off; none where there are more or fewer of a shape than the model has.
    """
    from scipy.spatial import cKDTree

    shape, frames = expand(scheme)
    rows, found = np.zeros(len(shape), np.int64), np.zeros(len(shape))
    none = rows[:0], found[:0]
    if len(shape) != len(parts.shape):
        return none
    for index, part in enumerate(parts.classes):
        drawn = np.nonzero(shape == index)[0]
        if len(drawn) != len(part.members):
            return none
        if not len(drawn):  # another class stands for it
            continue
        figure, own = of_class(part), frames[drawn]
        points = probed(figure, own)
        there = parts.frames[part.members]
        tree = cKDTree(spread(there, figure.center[None])[:, 0])
        near = np.asarray(tree.query(points[:, 0], k=min(4, len(own)))[1]).reshape(len(own), -1)
        error = np.stack([misses(figure, points, there[column])[0] for column in near.T], axis=1)
        best = np.argmin(error, axis=1)
        rows[drawn] = part.members[near[np.arange(len(own)), best]]
        found[drawn] = error.min(axis=1)
    return rows, found
