"""From states at several levels to one body: what each element follows, and the brackets.

Each element begins where the body begins or where an earlier element ends, or a hop away from it
that draws nothing; which one is the same at every level. That makes a tree, and the tree is written
with the fewest brackets. Of several possible places the one that pops least is taken. In come
states, out come commands.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from ipmlang.inverse.recursion.program import Body, Branch, Command, Grow, Turn
from ipmlang.inverse.recursion.states import State

Write = Callable[[int], Command]
"""The command of an element, counted from 0."""


Leap = Callable[["Hop"], list[Command]]
"""The commands of a hop along the turtle's heading."""


@dataclass(frozen=True, slots=True)
class Hop:
    """A move before an element. heading: in the body's frame, of length 1; length: steps of a copy
    that has none left, which grow `growth`-fold with each.
    """

    heading: complex
    length: float
    growth: int


@dataclass(frozen=True, slots=True, eq=False)
class Level:
    """The same body with `power` steps left for its elements: their states relative to the body's
    frame, and what a point may be off there.
    """

    states: list[State]
    slack: float
    power: int


@dataclass(frozen=True, slots=True)
class Tree:
    """parent: (m,) for each element 0 if it begins at the start, else the number (from 1) of the
    element at whose end it does; hops: (m,) the moves from there.
    """

    parent: tuple[int, ...]
    hops: tuple[Hop | None, ...]

    def children(self, node: int) -> list[int]:
        """The elements that begin at a node, numbers from 1."""
        return [index + 1 for index, parent in enumerate(self.parent) if parent == node]

    def path(self, node: int) -> list[int]:
        """The nodes from the start to a node."""
        nodes = [node]
        while nodes[-1]:
            nodes.append(self.parent[nodes[-1] - 1])
        return nodes[::-1]


def attach(levels: list[Level], hopping: bool) -> Tree | None:
    """The tree, None where some element begins nowhere. hopping: moves are allowed."""
    parents: list[int] = []
    hops: list[Hop | None] = []
    spine = [0]
    for index in range(len(levels[0].states)):
        near = [(node, _hop(levels, node, index)) for node in reversed(spine)]
        reached = [pair for pair in near if pair[1] is not None]
        here = [pair for pair in reached if pair[1] == HERE]
        reached = here or reached if hopping else here
        if not reached:
            return None
        # What a file's axiom hops to is reached from its start: where its symbols end says nothing.
        node, hop = reached[0] if here or len(levels) > 1 else reached[-1]
        parents.append(node)
        hops.append(None if hop == HERE else hop)
        spine = [*spine[: spine.index(node) + 1], index + 1]
    return Tree(tuple(parents), tuple(hops))


HERE = Hop(1 + 0j, 0.0, 1)
FASTEST_HOP = 12


def _hop(levels: list[Level], node: int, index: int) -> Hop | None:
    """From the end of a node to the start of an element, the same at all levels; None if none is.
    HERE if there is nothing between.
    """
    gaps = [
        level.states[index].at - (level.states[node - 1].exit_at if node else 0) for level in levels
    ]
    if all(abs(gap) <= level.slack for gap, level in zip(gaps, levels, strict=True)):
        return HERE
    if any(abs(gap) <= 2 * level.slack for gap, level in zip(gaps, levels, strict=True)):
        return None
    heading = gaps[0] / abs(gaps[0])
    for growth in range(1, FASTEST_HOP + 1 if len(levels) > 1 else 2):
        length = abs(gaps[0]) / growth ** levels[0].power
        if all(
            abs(gap - heading * length * growth**level.power) <= 2 * level.slack
            for gap, level in zip(gaps, levels, strict=True)
        ):
            return Hop(heading, length, growth)
    return None


def commands(
    tree: Tree, states: list[State], leaves: int | None, write: Write, leap: Leap
) -> Body | None:
    """The body. leaves: the node at which the turtle leaves it with the factor it began with, None
    if nobody follows; None is returned if something is drawn after that node's branch closed.
    """
    count = len(states)
    last_path = tree.path(count)
    if leaves is not None and leaves not in last_path:
        return None
    return tuple(_from(tree, states, 0, leaves, write, leap))


def _from(
    tree: Tree, states: list[State], node: int, leaves: int | None, write: Write, leap: Leap
) -> list[Command]:
    """What stands after a node."""
    body: list[Command] = []
    children = tree.children(node)
    factor = states[node - 1].exit_factor if node else 1 + 0j
    for child in children:
        inner = [
            *_approached(factor, states[child - 1].factor, tree.hops[child - 1], leap),
            write(child - 1),
            *_from(tree, states, child, leaves, write, leap),
        ]
        if child == children[-1] and leaves != node:
            body += inner
        else:
            body.append(Branch(tuple(inner)))
    if node == leaves:
        body += _turned(factor, 1 + 0j)
    return body


def _approached(before: complex, after: complex, hop: Hop | None, leap: Leap) -> list[Command]:
    """The commands between two elements."""
    if hop is None:
        return _turned(before, after)
    along = hop.heading * abs(before)
    return [*_turned(before, along), *leap(hop), *_turned(along, after)]


def _turned(before: complex, after: complex) -> list[Command]:
    """The turn and the change of scale between two factors."""
    made: list[Command] = []
    ratio = after / before
    angle = math.degrees(math.atan2(ratio.imag, ratio.real))
    if abs(angle) > 1e-4:
        made.append(Turn(angle if angle > -179.9999 else 180.0))
    if abs(abs(ratio) - 1) > 1e-6:
        made.append(Grow(abs(ratio)))
    return made
