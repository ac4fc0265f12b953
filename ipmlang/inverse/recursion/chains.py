"""Chains of copies that go on by one step: the branches of a structure, one at a time.

From a root the near copies are tried as the first link; what repeats that step, the same each time
or evenly changing, is followed as far as it goes. A round shape has no heading: how it turns from
link to link is told by the second one. In comes what stands where, out come chains with their
steps; all are followed at once, and nothing is put together here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import Floats, Frames, compose, frames, join, wrap
from ipmlang.inverse.recursion.nodes import Nodes, between
from ipmlang.inverse.recursion.strokes import Integers
from ipmlang.inverse.recursion.twigs import SCALE, SPIN, TURN, frames_of, steps_of

NEAR = 20
COMPARABLE = 0.3
LONGEST = 40
MOST_CHAINS = 40
MOST_LINKS = 256
MOST_EACH = 16  # frames of one copy, all triples of which are tried at once
ROOM = 1.01  # times the tolerance: rounding must not rule out what is there


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """step: (4,) numbers of the first step; change: (4,) theirs from one step to the next; hand: of
    each link as seen from the one before; length: links; element: the copy after the root.
    """

    step: Floats
    change: Floats
    hand: int
    length: int
    element: int


Near: TypeAlias = Callable[[Nodes, int], Integers]  # the copies that may come after one


@dataclass(frozen=True, slots=True, eq=False)
class _Links:
    """frames (m,) of copies after the root, and which copies (m,) they are."""

    frames: Frames
    copy: Integers


def find_chains(nodes: Nodes, start: Frames, root: int, linear: bool) -> list[Chain]:
    """Chains from the copy `root`, seen in the frame `start`: at least two equal steps or three
    evenly changing ones, the longest first.
    """
    return _chains(nodes, start, root, linear, _neighbours, False)


def first_chains(nodes: Nodes, start: Frames, root: int, linear: bool) -> list[Chain]:
    """The same whose every link is the copy after the one before."""
    return _chains(nodes, start, root, linear, _next, True)


def may_begin(nodes: Nodes, roots: Integers, linear: bool) -> NDArray[np.bool_]:
    """(r,) from which copies `first_chains` may find any: the copies after each are asked by
    themselves, all roots at once.
    """
    links = 3 if linear else 2
    there = roots + links < nodes.count
    roots = roots[there]
    if nodes.free or nodes.each > MOST_EACH or not len(roots):
        return there
    start = nodes.every[roots * nodes.each][:, None]
    one, two = (_copies(nodes, roots + ahead) for ahead in (1, 2))
    step = between(start, one)
    if linear:
        beyond, good = _third(step, between(one[:, :, None], two[:, None]), two[:, None])
    else:
        beyond, good = compose(one, step)[:, :, None], np.ones((1, 1, 1), np.bool_)
    last = _copies(nodes, roots + links)[:, None, None]
    beyond = beyond[..., None]
    bound = ROOM * nodes.tolerance
    near = good[..., None] & (np.abs(beyond.position - last.position) <= bound)
    near &= np.abs(beyond.factor - last.factor) * nodes.radius <= bound
    near &= beyond.handedness == last.handedness
    there[there] = near.any(axis=(1, 2, 3))
    return there


def _copies(nodes: Nodes, copies: Integers) -> Frames:
    """(r, k) all frames of some copies (r,)."""
    return nodes.every[copies[:, None] * nodes.each + np.arange(nodes.each)]


def _third(step: Frames, after: Frames, second: Frames) -> tuple[Frames, NDArray[np.bool_]]:
    """(r, k, k) where a third link ends, if steps (r, k) change to those after (r, k, k) as much as
    these change again, and which of them go on; second: (r, 1, k) where the second link ends.
    """
    first = steps_of(step.flat()).reshape(*step.x.shape, 1, 4)
    change = steps_of(after.flat()).reshape(*after.x.shape, 4) - first
    change[..., [TURN, SPIN]] = wrap(change[..., [TURN, SPIN]])
    third = first + 2 * change
    hand = np.broadcast_to(step.handedness[..., None], after.x.shape)
    good = (after.handedness == hand) & (third[..., SCALE] > 0)
    made = _frames_of(third.reshape(-1, 4), hand.ravel().astype(np.int64))
    shape = after.x.shape
    columns = (made.x, made.y, made.angle, made.scale)
    x, y, angle, scale = (each.reshape(shape) for each in columns)
    return compose(second, Frames(x, y, angle, scale, made.handedness.reshape(shape))), good


def _chains(
    nodes: Nodes, start: Frames, root: int, linear: bool, near: Near, painted: bool
) -> list[Chain]:
    first = near(nodes, root)
    links = _round_links(nodes, start, root, first) if nodes.free else _links(nodes, first)
    if not len(links.copy):
        return []
    steps = between(start[np.zeros(len(links.copy), np.int64)], links.frames)
    numbers, hand = steps_of(steps), steps.handedness.astype(np.int64)
    change = np.zeros_like(numbers)
    if linear:
        which, change = _changes(nodes, root, links, numbers, hand, near)
        numbers, hand = numbers[which], hand[which]
        links = _Links(links.frames[which], links.copy[which])
    length = _lengths(nodes, start, numbers, change, hand, root if painted else None)
    good = np.flatnonzero(length >= (3 if linear else 2))
    order = np.lexsort((links.copy[good], -hand[good], -length[good]))
    return [
        Chain(numbers[row], change[row], int(hand[row]), int(length[row]), int(links.copy[row]))
        for row in good[order][:MOST_CHAINS].tolist()
    ]


def _next(nodes: Nodes, copy: int) -> Integers:
    """The copy after one, none after the last."""
    return np.arange(copy + 1, min(copy + 2, nodes.count))


def _neighbours(nodes: Nodes, copy: int) -> Integers:
    """The nearest other copies of a comparable size, and the largest of them."""
    own = nodes.own
    size = own.scale / own.scale[copy]
    alike = np.flatnonzero((size > COMPARABLE) & (size < 1 / COMPARABLE))
    away = np.abs(own.position[alike] - own.position[copy])
    away[alike == copy] = np.inf
    order = np.argsort(away, kind="stable")[: len(alike) - 1]
    large = order[np.argsort(-np.round(own.scale[alike[order]], 9), kind="stable")]
    chosen = np.unique(np.concatenate([order[:NEAR], large[:NEAR]]))
    return np.asarray(alike[chosen], np.int64)


def _alike(nodes: Nodes, copy: int, size: float) -> Integers:
    """The nearest other copies of this scale."""
    own = nodes.own
    alike = np.flatnonzero(np.abs(own.scale - size) * nodes.radius <= 2 * nodes.tolerance)
    alike = alike[alike != copy]
    away = np.abs(own.position[alike] - own.position[copy])
    return np.asarray(alike[np.argsort(away, kind="stable")[:NEAR]], np.int64)


def _links(nodes: Nodes, near: Integers) -> _Links:
    """The copies near the root in all their frames."""
    rows = (near[:, None] * nodes.each + np.arange(nodes.each)).ravel()[:MOST_LINKS]
    return _Links(nodes.every[rows], rows // nodes.each)


def _round_links(nodes: Nodes, start: Frames, root: int, near: Integers) -> _Links:
    """The same for round shapes, in the frames that lead to each possible second link."""
    made: list[Frames] = []
    copies: list[int] = []
    for copy in near.tolist():
        place = nodes.every[copy : copy + 1]
        came = place.position[0] - start.position[0]
        after = _alike(nodes, copy, float(place.scale[0] ** 2 / start.scale[0]))
        away = nodes.every.position[after] - place.position[0]
        away = away[(after != root) & (np.abs(away) > nodes.tolerance)]
        if abs(came) <= nodes.tolerance or not len(away):
            continue
        turn = np.angle(away / came, deg=True)
        at = np.full(len(away), place.position[0])
        made.append(frames(at, start.angle[0] + turn, place.scale[0]))
        copies += [copy] * len(away)
    if not made:
        return _Links(nodes.every[:0], np.zeros(0, np.int64))
    return _Links(join(made), np.array(copies, np.int64))


def _changes(
    nodes: Nodes, root: int, links: _Links, numbers: Floats, hand: Integers, near: Near
) -> tuple[Integers, Floats]:
    """Which links have a second one whose step changes so that a third is there, and the change."""
    which, changes = [np.zeros(0, np.int64)], [np.zeros((0, 4))]
    for copy in np.unique(links.copy).tolist():
        mine = np.flatnonzero(links.copy == copy)
        after = near(nodes, copy)
        after = after[after != root]
        rows = (after[:, None] * nodes.each + np.arange(nodes.each)).ravel()[:MOST_LINKS]
        first, second = (each.ravel() for each in np.meshgrid(mine, rows, indexing="ij"))
        step = between(links.frames[first], nodes.every[second])
        change = steps_of(step) - numbers[first]
        change[:, [TURN, SPIN]] = wrap(change[:, [TURN, SPIN]])
        third = numbers[first] + 2 * change
        good = (step.handedness == hand[first]) & (third[:, SCALE] > 0)
        first, second, change, third = first[good], second[good], change[good], third[good]
        beyond = compose(nodes.every[second], _frames_of(third, hand[first]))
        there = nodes.at(beyond).max(axis=1, initial=-1) >= 0
        which.append(first[there])
        changes.append(change[there])
    return np.concatenate(which), np.concatenate(changes)


def _frames_of(steps: Floats, hand: Integers) -> Frames:
    made = frames_of(steps, 1)
    return Frames(made.x, made.y, made.angle, made.scale, hand.astype(np.int8))


def _lengths(
    nodes: Nodes,
    start: Frames,
    steps: Floats,
    change: Floats,
    hand: Integers,
    root: int | None,
) -> Integers:
    """(m,) how many links of each chain are there; root: the copy that they follow one by one,
    None where they are anywhere.
    """
    length = np.zeros(len(steps), np.int64)
    alive = np.arange(len(steps))
    now = start[np.zeros(len(steps), np.int64)]
    while len(alive) and length.max() < LONGEST:
        numbers = steps[alive] + change[alive] * length[alive, None]
        now = compose(now, _frames_of(numbers, hand[alive]))
        copies = nodes.at(now) // nodes.each
        if root is None:
            there = copies.max(axis=1) >= 0
        else:
            there = (copies == root + 1 + length.max()).any(axis=1)
        there &= numbers[:, SCALE] > 0
        alive, now = alive[there], now[np.flatnonzero(there)]
        length[alive] += 1
    return length
