"""Branching structures of equal elements, drawn in any order: the rules r3 and r4 of the paper.

In come the frames of one symbol's copies (2010 paper, section 5.2); out comes the recursion
R(m) --> A [T1 R(m - d1)] [T2 R(m - d2)] …, with any number of branches, each with its own decrease
and with angles, lengths and scales that may change evenly with m, the root's frame, and the
elements in the order in which the rule draws them. Only what stands where the rule says counts;
other copies are left alone. Chains that repeat one step are looked for among near neighbours, never
among all pairs. Where the copies must follow each other as the rule draws them, the first branch
begins with the copy after the root, which most stretches of copies tell at once.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, islice, product

import numpy as np

from ipmlang.inverse.lsystem.frames import Frames, frames
from ipmlang.inverse.recursion.chains import Chain, find_chains, first_chains, may_begin
from ipmlang.inverse.recursion.nodes import Nodes, make_nodes
from ipmlang.inverse.recursion.strokes import Integers
from ipmlang.inverse.recursion.twigs import (
    SPIN,
    Grown,
    Twig,
    fitted,
    grow,
    node_counts,
    rounded,
)

MOST_ROOTS = 6
MOST_PAIRS = 300
MOST_BRANCHES = 8
FEWEST_NODES = 7
MOST_DECREASE = 4


@dataclass(frozen=True, slots=True, eq=False)
class Branching:
    """twigs: the branches in drawing order; depth: m of the root; root: (1,) its frame; order: (n,)
    elements in the order in which the rule draws them; error: the largest distance, units.
    """

    twigs: tuple[Twig, ...]
    depth: int
    root: Frames
    order: Integers
    error: float


def find_branching(
    placed: Frames,
    stabiliser: Frames,
    *,
    free: bool = False,
    radius: float = 1.0,
    tolerance: float,
    seconds: float = 3.0,
    painted: bool = False,
) -> Branching | None:
    """The branching structure with most elements, None if there is none.

    placed: (n,) frames of the copies; stabiliser: (k,) frames that keep the shape, identity first;
    free: any rotation does too; radius: of the shape at scale 1; tolerance: units;
    seconds: of processor time, after which the best so far is given; painted: only structures whose
    copies follow each other in the order in which the rule draws them.
    """
    if len(placed) < FEWEST_NODES:
        return None
    deadline = time.process_time() + seconds
    nodes = make_nodes(placed, stabiliser, free, radius, tolerance)
    best: Branching | None = None
    roots = np.array(_roots(placed), np.int64)
    kinds = (False, True) if not free else (False,)
    may = {each: may_begin(nodes, roots, each) if painted else roots >= 0 for each in kinds}
    for number, root in enumerate(roots.tolist()):
        for linear in (each for each in kinds if may[each][number]):
            found = _from_root(nodes, root, linear, painted, deadline)
            if found is not None and (best is None or len(found.order) > len(best.order)):
                best = found
            if found is not None:
                break
        done = best is not None and 2 * len(best.order) > len(placed)
        if done or time.process_time() > deadline:
            break
    return best


def _roots(placed: Frames) -> list[int]:
    """Likely roots: the largest, the first drawn, the last."""
    size = np.argsort(-placed.scale, kind="stable")[:MOST_ROOTS].tolist()
    if np.ptp(placed.scale) <= 1e-6 * float(placed.scale.max()):
        size = []
    return list(dict.fromkeys([*size[:1], 0, *size, len(placed) - 1]))[:MOST_ROOTS]


def _from_root(
    nodes: Nodes, root: int, linear: bool, painted: bool, deadline: float
) -> Branching | None:
    """The largest structure that begins at an element."""
    own = root * nodes.each
    start = nodes.every[own : own + 1]
    first = first_chains(nodes, start, root, linear) if painted else []
    if painted and (not first or root + FEWEST_NODES > nodes.count):
        return None
    chains = find_chains(nodes, start, root, linear)
    best: Branching | None = None
    for pair in islice(_pairs(first, chains, root, nodes.count), MOST_PAIRS):
        found = _extended(nodes, start, pair, chains, root if painted else None)
        if found is not None and (best is None or len(found.order) > len(best.order)):
            best = found
        full = best is not None and len(best.order) == nodes.count
        if full or time.process_time() > deadline:
            break
    return best


def _pairs(first: list[Chain], chains: list[Chain], root: int, count: int) -> Iterator[list[Chain]]:
    """Two branches of one structure; the first ones are given where the order is."""
    if not first:
        every = combinations(chains, 2)
        yield from ([*pair] for pair in every if pair[0].element != pair[1].element)
        return
    for pair in product(first, chains):
        if _in_order([*pair], root, count):
            yield [*pair]


def _in_order(used: list[Chain], root: int, count: int) -> bool:
    """Whether each of these branches begins after all that those before it draw. More branches only
    draw more before.
    """
    depth = max(chain.length for chain in used)
    for decreases in _decreases(used, depth):
        sizes = node_counts(decreases, depth)
        after = root + 1
        for chain, less in zip(used, decreases, strict=True):
            if chain.element < after:
                return False
            after += sizes[depth - less]
        return after <= count
    return False


def _extended(
    nodes: Nodes, start: Frames, used: list[Chain], chains: list[Chain], root: int | None
) -> Branching | None:
    """The chains as branches of one structure, with all that fit besides; root: the copy that all
    others follow in their order, None for any order.
    """
    found = _proven(nodes, start, used)
    if found is None:
        return None
    for chain in chains:
        fits = all(chain.element != each.element for each in used)
        if fits and len(used) < MOST_BRANCHES:
            every = sorted([*used, chain], key=lambda each: each.element)
            if root is not None and not _in_order(every, root, nodes.count):
                continue
            more = _proven(nodes, start, every)
            if more is not None and len(more.order) > len(found.order):
                found, used = more, every
    return found if root is None or (np.diff(found.order) == 1).all() else None


def _proven(nodes: Nodes, start: Frames, used: list[Chain]) -> Branching | None:
    """The structure of these chains if all of it is there."""
    used = sorted(used, key=lambda each: each.element)
    depth = max(chain.length for chain in used)
    for decreases in _decreases(used, depth):
        twigs = [
            Twig(chain.step + chain.change * (depth / less), -chain.change / less, chain.hand, less)
            for chain, less in zip(used, decreases, strict=True)
        ]
        grown = grow(start, twigs, depth, nodes.count)
        if grown is None or len(grown.frames) < FEWEST_NODES:
            continue
        found = nodes.match(grown.frames)
        if found is not None:
            if nodes.free:
                start, twigs = _facing(start, twigs)
                grown = grow(start, twigs, depth, nodes.count) or grown
            return _finished(nodes, start, twigs, depth, grown, found)
    return None


def _facing(root: Frames, twigs: list[Twig]) -> tuple[Frames, list[Twig]]:
    """The same structure of round shapes whose first branch faces the way it goes."""
    spin = twigs[0].first[SPIN]
    turned = [
        Twig(twig.first + np.array([spin, 0, 0, -spin]), twig.slope, twig.hand, twig.less)
        for twig in twigs
    ]
    return frames(root.position, root.angle - spin, root.scale, root.handedness), turned


def _decreases(used: list[Chain], depth: int) -> list[tuple[int, ...]]:
    """What the branches may take from m, so that each goes on as often as its chain."""
    options = [
        [less for less in range(1, MOST_DECREASE + 1) if depth // less == chain.length]
        for chain in used
    ]
    if not all(options):
        return []
    return [tuple(each[0] for each in options)]


def _finished(
    nodes: Nodes, root: Frames, twigs: list[Twig], depth: int, grown: Grown, found: Integers
) -> Branching:
    """With parameters fitted to all pairs and rounded as far as the proof allows."""
    seen = nodes.facing(found, grown.frames)
    better = fitted(twigs, grown, seen, depth)
    for steps in (better, twigs):
        for places in range(12):
            short = [rounded(twig, places) for twig in steps]
            again = grow(root, short, depth, nodes.count)
            if again is None:
                continue
            error = nodes.largest_gap(again.frames, found)
            if error <= nodes.tolerance:
                return Branching(tuple(short), depth, root, found[grown.preorder()], error)
    error = nodes.largest_gap(grown.frames, found)
    return Branching(tuple(twigs), depth, root, found[grown.preorder()], error)
