"""From the sides that a wavefront drew to one face for each line, proved to be right.

In go nodes and sides (line, from node, to node); out come closed rings of nodes. A face is good
if its ring is closed, lies in its line's moving plane, runs counter-clockwise and never crosses
itself; since every inner side is used once in each direction, good faces tile the polygon. It
never mends a face: what is not good raises `BrokenError`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.skeleton_lines import BrokenError, Lines
from ipmlang.geometry.skeleton_wavefront import Wavefront
from ipmlang.geometry.solid import Floats

SLACK = 4e-10  # how far from its planes a node may be, in units of the polygon's size


def traced(front: Wavefront, bases: int) -> list[list[list[int]]]:
    """The rings of nodes of each line's face: its outline, then what it runs all around.

    The outlines of the first `bases` lines begin with the line's own edge.
    """
    on: list[dict[int, int]] = [{} for _ in front.lines.dx]
    for line, start, end in front.sides:
        start, end = front.same_node(start), front.same_node(end)
        if start == end:
            continue
        if start in on[line]:
            raise BrokenError("a face meets itself")
        on[line][start] = end
    first = {line: front.same_node(start) for line, start, _ in front.sides[:bases]}
    return [_rings(sides, first.get(line)) for line, sides in enumerate(on)]


def _rings(sides: dict[int, int], first: int | None) -> list[list[int]]:
    """Closed rings of all sides, which are used up."""
    found: list[list[int]] = []
    while sides:
        start = next(iter(sides)) if first is None or found else first
        ring = [start]
        while (node := sides.pop(ring[-1], -1)) != start:
            if node < 0:
                raise BrokenError("a face does not close")
            ring.append(node)
        found.append(ring)
    return found


def prove(lines: Lines, nodes: Floats, faces: dict[int, list[list[int]]]) -> None:
    """Raise BrokenError unless each line's face is good; nodes (n, 3) are x, y and time."""
    rings = [ring for face in faces.values() for ring in face]
    own = np.repeat(np.array(list(faces), np.intp), [len(face) for face in faces.values()])
    first = own != np.concatenate([[-1], own[:-1]])
    counts = [len(ring) for ring in rings]
    if not all(faces.values()) or min(counts) < 3:
        raise BrokenError("a face is missing")
    corners = np.array([node for ring in rings for node in ring], np.intp)
    line = np.repeat(own, counts)
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
    doubtful = (_turning_back(moves, starts) | ~first) & (lines.table[3, own] > 0)
    area = np.add.reduceat(along * away[after] - away * along[after], starts[:-1]) / 2
    if area[first].min() < -SLACK or (area[~first] > SLACK).any():
        raise BrokenError("a face is turned over")
    points = np.stack([along, away], axis=1)
    parts = [points[starts[ring] : starts[ring + 1]] for ring in np.flatnonzero(doubtful)]
    if _any_crosses_itself(parts):
        raise BrokenError("a face crosses itself")


def _turning_back(moves: Floats, starts: NDArray[np.intp]) -> NDArray[np.bool_]:
    """For each ring that starts with its base, whether the rest of it ever turns back."""
    wrong = moves > SLACK
    wrong[starts[:-1]] = moves[starts[:-1]] < -SLACK
    return np.logical_or.reduceat(wrong, starts[:-1])


def _any_crosses_itself(rings: list[Floats]) -> bool:
    """Whether two sides of one of the rings (n, 2) cross by more than the slack."""
    sizes: dict[int, list[Floats]] = {}
    for ring in rings:
        if len(ring) > 3:
            sizes.setdefault(len(ring).bit_length(), []).append(ring)
    return any(_crosses(_padded(alike)) for alike in sizes.values())


def _padded(rings: list[Floats]) -> Floats:
    """Rings of unequal length as (r, n, 2): their last points repeat."""
    longest = max(len(ring) for ring in rings)
    within = np.minimum(np.arange(longest), np.array([[len(ring) - 1] for ring in rings]))
    firsts = np.cumsum([0, *(len(ring) for ring in rings[:-1])])
    return np.asarray(np.concatenate(rings)[firsts[:, None] + within])


def _crosses(rings: Floats) -> bool:
    """Whether two sides of one of the rings (r, n, 2) lie on both sides of each other."""
    x, y = rings[..., 0], rings[..., 1]
    dx, dy = np.roll(x, -1, axis=1) - x, np.roll(y, -1, axis=1) - y
    length = np.maximum(np.hypot(dx, dy), SLACK)
    dx, dy = (dx / length)[..., None], (dy / length)[..., None]
    one = dx * (y[:, None] - y[..., None]) - dy * (x[:, None] - x[..., None])
    other = np.roll(one, -1, axis=2)
    parts = (np.minimum(one, other) < -SLACK) & (np.maximum(one, other) > SLACK)
    return bool((parts & parts.transpose(0, 2, 1)).any())
