"""The wavefront of a polygon: how it starts, and one step of it.

In go regions (an outline and its holes as linked corners); out come the nodes and the sides of
faces that the corners draw while they move. A step moves a region to its next moment of contact,
takes all contacts of that moment together and links what is left anew, so that many meetings at
one point are no special case. It never decides whether a result is good: see `skeleton_faces`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import atan2, inf

from ipmlang.geometry.skeleton_contacts import Contacts, next_contacts
from ipmlang.geometry.skeleton_lines import (
    BrokenError,
    Corner,
    Lines,
    OpenError,
    Region,
    regions_of,
)

PARALLEL = 1e-12  # sines below this are those of parallel lines
CLEAR = 1e-3  # lines that cross at a greater sine give a good point


@dataclass(slots=True)
class Piece:
    """What is left of a segment between two places of contact, by the corners' numbers."""

    start: int
    end: int
    line: int


@dataclass(slots=True)
class Places:
    """Which corners of a region come together, and where corners cut segments."""

    parent: dict[int, int] = field(default_factory=dict)
    cuts: dict[int, list[tuple[float, int]]] = field(default_factory=dict)

    def root(self, corner: int) -> int:
        while (above := self.parent.get(corner, corner)) != corner:
            corner = above
        return corner

    def touch(self, corner: int) -> None:
        self.parent.setdefault(corner, corner)

    def join(self, one: int, other: int) -> None:
        self.touch(one)
        self.touch(other)
        self.parent[self.root(one)] = self.root(other)

    def groups(self) -> dict[int, list[int]]:
        found: dict[int, list[int]] = {}
        for corner in self.parent:
            found.setdefault(self.root(corner), []).append(corner)
        return found


class Wavefront:
    """Moving lines and all that they have drawn so far.

    nodes: x, y and time of each; sides: (line, from node, to node), counter-clockwise around the
    face of the line; `same` gives the node that a node turned out to be.
    """

    def __init__(self, lines: Lines, reach: float) -> None:
        self.lines = lines
        self.reach = reach
        self.nodes: list[tuple[float, float, float]] = []
        self.sides: list[tuple[int, int, int]] = []
        self.same: dict[int, int] = {}

    def start(self, rings: Iterable[Sequence[tuple[float, float, int]]]) -> list[Region]:
        """The regions of rings of (x, y, the line that begins there), interiors to the left."""
        corners: list[Corner] = []
        for ring in rings:
            first = len(self.nodes)
            self.nodes.extend((x, y, 0.0) for x, y, _ in ring)
            chains = [
                self._corners(first + k, ring[k - 1][2], ring[k][2]) for k in range(len(ring))
            ]
            for k, (_, _, line) in enumerate(ring):
                follow = (k + 1) % len(ring)
                self.sides.append((line, first + k, first + follow))
                _link(chains[k][-1], chains[follow][0])
            corners.extend(corner for chain in chains for corner in chain)
        return regions_of(self.lines, 0.0, corners)

    def step(self, region: Region, limit: float) -> list[Region] | None:
        """What a region becomes at its next contacts, or None where they are after the limit."""
        uneven = next((corner for corner in region.corners if corner.uneven), None)
        if uneven is not None:
            return self._overtake(region, uneven)
        contacts = next_contacts(self.lines, region.corners, region.time, self.reach)
        if contacts is None and limit == inf:
            raise OpenError("the wavefront never closes")
        if contacts is None or contacts.time > limit:
            return None
        places = self._places(region.corners, contacts)
        pieces, dead = _pieces(region.corners, places)
        for piece in dead:
            places.touch(piece.start)
            places.touch(piece.end)
        nodes = self._close(region.corners, places, contacts.time)
        for piece in dead:
            start, end = nodes[places.root(piece.start)], nodes[places.root(piece.end)]
            self.sides.append((piece.line, end, start))
        return self._linked(contacts.time, region.corners, places, pieces, nodes)

    def _overtake(self, region: Region, uneven: Corner) -> list[Region]:
        """The faster of two lines that have come to lie in one goes on for both.

        Its plane holds the slower one's segment, whose face ends there (Biedl et al. leave the
        choice open; this one never leaves a part of the polygon without a line that moves).
        """
        speed = self.lines.speed
        forward = speed[uneven.before] > speed[uneven.after]
        start, end = (uneven, uneven.on) if forward else (uneven.back, uneven)
        slow, fast = (uneven.after, uneven.before) if forward else (uneven.before, uneven.after)
        places = Places()
        places.touch(start.number)
        places.touch(end.number)
        pieces, _ = _pieces(region.corners, places)
        nodes = self._close(region.corners, places, region.time)
        one, other = nodes[start.number], nodes[end.number]
        self.sides.append((slow, other, one))
        self.sides.append((fast, one, other))
        for piece in pieces:
            if (piece.start, piece.end) == (start.number, end.number):
                piece.line = fast
        return self._linked(region.time, region.corners, places, pieces, nodes)

    def _linked(
        self,
        time: float,
        corners: list[Corner],
        places: Places,
        pieces: list[Piece],
        nodes: dict[int, int],
    ) -> list[Region]:
        """The regions of the corners that no contact touched and of new ones between pieces."""
        made = self._link_anew(corners, pieces, nodes)
        alive = [corner for k, corner in enumerate(corners) if k not in places.parent]
        return regions_of(self.lines, time, _without_straight(alive + made))

    def _places(self, corners: list[Corner], contacts: Contacts) -> Places:
        places = Places()
        for one, other in contacts.pairs:
            places.join(one, other)
        for corner, segment, along, length in contacts.touches:
            if along <= self.reach:
                places.join(corner, segment)
            elif along >= length - self.reach:
                places.join(corner, corners[segment].on.number)
            else:
                places.touch(corner)
                places.cuts.setdefault(segment, []).append((along, corner))
        return places

    def _close(self, corners: list[Corner], places: Places, time: float) -> dict[int, int]:
        """A node for each group of corners, and the sides that its corners have drawn."""
        cutting: dict[int, list[int]] = {}
        for segment, cuts in places.cuts.items():
            for _, cutter in cuts:
                cutting.setdefault(places.root(cutter), []).append(corners[segment].after)
        nodes: dict[int, int] = {}
        for root, members in places.groups().items():
            group = [corners[k] for k in members]
            node = nodes[root] = self._node(group, cutting.get(root, []), time)
            for corner in group:
                self.sides.append((corner.before, corner.node, node))
                self.sides.append((corner.after, node, corner.node))
        return nodes

    def _node(self, group: list[Corner], cut: list[int], time: float) -> int:
        """A new node where a group of corners meets, or the one where they began just now."""
        x, y = self._meeting(group, cut, time)
        near = 4 * self.reach
        born = {
            corner.node
            for corner in group
            if abs(corner.x - x) + abs(corner.y - y) <= near and time - corner.time <= near
        }
        if not born:
            self.nodes.append((x, y, time))
            return len(self.nodes) - 1
        node, *others = sorted(self.same_node(each) for each in born)
        for other in others:
            if other != node:
                self.same[other] = node
        return node

    def same_node(self, node: int) -> int:
        """The node that stands for a node."""
        while node in self.same:
            node = self.same[node]
        return node

    def _meeting(self, group: list[Corner], cut: list[int], time: float) -> tuple[float, float]:
        """Where a group of corners meets: of its lines, the two that cross most clearly say."""
        own = sorted({*cut, *(c.before for c in group), *(c.after for c in group)})
        best, first, second = 0.0, 0, 0
        for at, one in enumerate(own):
            for other in own[at + 1 :]:
                if (sine := abs(self.lines.sine(one, other))) > best:
                    best, first, second = sine, one, other
            if best > 0.5:
                break
        if best > CLEAR:
            return self.lines.crossing(first, second, time)
        slow = min(group, key=lambda corner: corner.vx**2 + corner.vy**2)
        wait = time - slow.time
        return slow.x + wait * slow.vx, slow.y + wait * slow.vy

    def _link_anew(
        self, corners: list[Corner], pieces: list[Piece], nodes: dict[int, int]
    ) -> list[Corner]:
        """New corners where pieces meet at nodes; the pieces then link their ends."""
        arriving: dict[int, list[int]] = {root: [] for root in nodes}
        leaving: dict[int, list[int]] = {root: [] for root in nodes}
        for number, piece in enumerate(pieces):
            if piece.end in arriving:
                arriving[piece.end].append(number)
            if piece.start in leaving:
                leaving[piece.start].append(number)
        starts: dict[int, Corner] = {}
        ends: dict[int, Corner] = {}
        made: list[Corner] = []
        for root, node in nodes.items():
            for into, out in self._wedges(pieces, arriving[root], leaving[root]):
                chain = self._corners(node, pieces[into].line, pieces[out].line)
                ends[into], starts[out] = chain[0], chain[-1]
                made.extend(chain)
        for number, piece in enumerate(pieces):
            _link(
                starts.get(number) or corners[piece.start], ends.get(number) or corners[piece.end]
            )
        return made

    def _wedges(
        self, pieces: list[Piece], arriving: list[int], leaving: list[int]
    ) -> list[tuple[int, int]]:
        """Pairs of an arriving and a leaving piece with nothing but interior between them."""
        if len(arriving) != len(leaving):
            raise BrokenError("a place of contact has loose ends")
        if len(arriving) < 2:
            return list(zip(arriving, leaving, strict=True))
        lines = self.lines
        around = [(atan2(lines.dy[line := pieces[k].line], lines.dx[line]), 0, k) for k in leaving]
        around += [
            (atan2(-lines.dy[line := pieces[k].line], -lines.dx[line]), 1, k) for k in arriving
        ]
        around.sort()
        if any(around[k - 1][1] == around[k][1] for k in range(len(around))):
            raise BrokenError("interiors overlap at a place of contact")
        return [
            (around[(k + 1) % len(around)][2], piece)
            for k, (_, comes, piece) in enumerate(around)
            if not comes
        ]

    def _corners(self, node: int, before: int, after: int) -> list[Corner]:
        """The corner between two lines; where edges in one line part in speed, two and a wall."""
        x, y, time = self.nodes[node]
        lines = self.lines
        if before == after:
            return [Corner(node, before, after, x, y, time, 0.0, 0.0)]
        if (
            abs(lines.sine(before, after)) < PARALLEL
            and lines.cosine(before, after) > 0
            and lines.speed[before] != lines.speed[after]
        ):
            if time > 0:
                return [Corner(node, before, after, x, y, time, 0.0, 0.0, uneven=True)]
            ahead = 1.0 if lines.speed[after] > lines.speed[before] else -1.0
            wall = lines.add(-ahead * lines.dy[before], ahead * lines.dx[before], x, y, 0.0)
            chain = self._corners(node, before, wall) + self._corners(node, wall, after)
            _link(*chain)
            return chain
        velocity = lines.velocity(before, after)
        if velocity is None:
            raise BrokenError("a spike without width")
        return [Corner(node, before, after, x, y, time, *velocity)]


def _pieces(corners: list[Corner], places: Places) -> tuple[list[Piece], list[Piece]]:
    """What is left of the segments at places of contact; and the pieces that met their equals."""
    segments = set(places.cuts)
    for k in places.parent:
        segments.add(k)
        segments.add(corners[k].back.number)
    found: list[Piece] = []
    for k in sorted(segments):
        inner = [places.root(corner) for _, corner in sorted(places.cuts.get(k, ()))]
        chain = [places.root(k), *inner, places.root(corners[k].on.number)]
        found.extend(Piece(a, b, corners[k].after) for a, b in pairwise(chain) if a != b)
    waiting: dict[tuple[int, int], list[int]] = {}
    dead: set[int] = set()
    for number, piece in enumerate(found):
        opposite = waiting.get((piece.end, piece.start))
        if opposite:
            dead |= {number, opposite.pop()}
        else:
            waiting.setdefault((piece.start, piece.end), []).append(number)
    alive = [piece for number, piece in enumerate(found) if number not in dead]
    return alive, [found[number] for number in sorted(dead)]


def _link(one: Corner, other: Corner) -> None:
    one.on = other
    other.back = one


def _without_straight(corners: list[Corner]) -> list[Corner]:
    """The corners but those between a line and itself."""
    kept: list[Corner] = []
    for corner in corners:
        if corner.before == corner.after:
            _link(corner.back, corner.on)
        else:
            kept.append(corner)
    return kept
