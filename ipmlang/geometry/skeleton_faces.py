"""From the sides that a wavefront drew to one face for each line, proved to be right.

In go nodes and sides (line, from node, to node); out come closed rings of nodes. A face is good
if its ring is closed, lies in its line's moving plane, runs counter-clockwise and never crosses
itself; since every inner side is used once in each direction, good faces tile the polygon. It
never mends a face: what is not good raises `BrokenError`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.skeleton_contacts import Lines
from ipmlang.geometry.skeleton_wavefront import BrokenError, Wavefront
from ipmlang.geometry.solid import Floats

SLACK = 4e-10  # how far from its planes a node may be, in units of the polygon's size


def traced(front: Wavefront, bases: int) -> list[list[int]]:
    """The ring of nodes of each line's face; of the first `bases` lines it begins at the base."""
    on: list[dict[int, int]] = [{} for _ in front.lines.dx]
    for line, start, end in front.sides:
        start, end = front.same_node(start), front.same_node(end)
        if start == end:
            continue
        if start in on[line]:
            raise BrokenError("a face meets itself")
        on[line][start] = end
    first = {line: front.same_node(start) for line, start, _ in front.sides[:bases]}
    return [_ring(sides, first.get(line)) for line, sides in enumerate(on)]


def _ring(sides: dict[int, int], first: int | None) -> list[int]:
    if not sides:
        return []
    start = next(iter(sides)) if first is None else first
    ring = [start]
    while (node := sides.get(ring[-1], -1)) != start:
        if node < 0 or len(ring) > len(sides):
            raise BrokenError("a face does not close")
        ring.append(node)
    if len(ring) != len(sides):
        raise BrokenError("a face has loose sides")
    return ring


def prove(lines: Lines, nodes: Floats, rings: list[list[int]], own: list[int]) -> None:
    """Raise BrokenError unless each ring is a good face of its own line.

    nodes (n, 3) are x, y and time.
    """
    counts = [len(ring) for ring in rings]
    if not counts or min(counts) < 3:
        raise BrokenError("a face is missing")
    corners = np.array([node for ring in rings for node in ring], np.intp)
    line = np.repeat(np.array(own, np.intp), counts)
    starts = np.cumsum([0, *counts])
    dx, dy, offset, speed = lines.table[:, line]
    x, y, time = nodes[corners].T
    away = y * dx - x * dy - offset
    if not (np.abs(away - speed * time).max() <= SLACK and time.min() >= -SLACK):
        raise BrokenError("a node is off its planes")
    along = x * dx + y * dy
    after = np.arange(1, len(corners) + 1)
    after[starts[1:] - 1] = starts[:-1]
    moves = along[after] - along
    doubtful = np.flatnonzero(_turning_back(moves, starts) & (lines.table[3, own] > 0))
    area = np.add.reduceat(along * away[after] - away * along[after], starts[:-1]) / 2
    if area.min() < -SLACK:
        raise BrokenError("a face is turned over")
    for face in doubtful:
        part = slice(starts[face], starts[face + 1])
        if crosses_itself(np.stack([along[part], away[part]], axis=1)):
            raise BrokenError("a face crosses itself")


def _turning_back(moves: Floats, starts: NDArray[np.intp]) -> NDArray[np.bool_]:
    """For each ring that starts with its base, whether the rest of it ever turns back."""
    wrong = moves > SLACK
    wrong[starts[:-1]] = moves[starts[:-1]] < -SLACK
    return np.logical_or.reduceat(wrong, starts[:-1])


def crosses_itself(ring: Floats, slack: float = SLACK) -> bool:
    """Whether sides of a ring (n, 2) that are not neighbours cross by more than the slack."""
    a, b = ring, np.roll(ring, -1, axis=0)
    d = b - a
    length = np.maximum(np.hypot(d[:, 0], d[:, 1]), slack)
    d = d / length[:, None]

    def side(points: Floats) -> Floats:
        gap = points[None] - a[:, None]
        return np.asarray(d[:, None, 0] * gap[..., 1] - d[:, None, 1] * gap[..., 0])

    one, other = side(a), side(b)
    parts = (np.minimum(one, other) < -slack) & (np.maximum(one, other) > slack)
    return bool((parts & parts.T).any())
