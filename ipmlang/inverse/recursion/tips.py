"""What stands at the ends of a branching structure where it is another shape than along it.

In come a branching of one symbol and the copies of another; out comes the same branching one level
deeper, whose last level is that other symbol (the paper's r4 with B), with the elements of both in
the order of derivation. All ends must be there, in one place relative to the node.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ipmlang.inverse.lsystem.frames import Frames, compose
from ipmlang.inverse.recursion.branching import Branching
from ipmlang.inverse.recursion.nodes import Nodes, between, make_nodes
from ipmlang.inverse.recursion.strokes import Integers
from ipmlang.inverse.recursion.twigs import Twig, grow

NEAR = 12


@dataclass(frozen=True, slots=True, eq=False)
class Tipped:
    """branching: one level deeper, its order that of the nodes along it; place: (1,) frame of the
    other symbol relative to an end; tips: (k,) its copies in the order of derivation; is_tip: (n,)
    for all that is drawn in the order of derivation, whether it is one of them.
    """

    branching: Branching
    place: Frames
    tips: Integers
    is_tip: Integers


def find_tips(
    branching: Branching,
    placed: Frames,
    stabiliser: Frames,
    *,
    free: bool = False,
    radius: float = 1.0,
    tolerance: float,
) -> Tipped | None:
    """The branching with copies `placed` (n,) of another symbol at its ends, None if they are not
    there. Arguments as in `find_branching`. Branches must all take 1 from m.
    """
    deeper = [_deeper(twig) for twig in branching.twigs]
    depth = branching.depth + 1
    grown = grow(branching.root, deeper, depth, len(branching.order) + len(placed))
    if grown is None or any(twig.less != 1 for twig in deeper):
        return None
    order = grown.preorder()
    is_tip = grown.depth[order] == 0
    ends = grown.frames[order][is_tip]
    nodes = make_nodes(placed, stabiliser, free, radius, tolerance)
    for place in _places(nodes, ends):
        found = nodes.match(compose(ends, place[np.zeros(len(ends), np.int64)]))
        if found is not None:
            made = replace(branching, twigs=tuple(deeper), depth=depth)
            return Tipped(made, place, found, is_tip.astype(np.int64))
    return None


def _deeper(twig: Twig) -> Twig:
    """The same numbers where every m is larger by one."""
    return Twig(twig.first - twig.slope, twig.slope, twig.hand, twig.less)


def _places(nodes: Nodes, ends: Frames) -> list[Frames]:
    """Frames of the copies nearest to the first end, relative to it."""
    away = np.abs(nodes.own.position - ends.position[0])
    near = np.argsort(away, kind="stable")[:NEAR]
    rows = (near[:, None] * nodes.each + np.arange(nodes.each)).ravel()
    seen = nodes.every[rows]
    relative = between(ends[np.zeros(len(rows), np.int64)], seen)
    return [relative[row : row + 1] for row in range(len(rows))]
