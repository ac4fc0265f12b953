"""Rule labelling (Demir and Aliaga 2016, section 3.3): which subtrees of a split tree are equal.

In goes a tree with its parts, out come labels: nodes with one label are the same subtree up to a
rigid motion or a mirror, and a frame says where each stands. Intermediate boxes take no part, so
that paths through them compare as equal (the paper's "don't care"). Nothing here looks for rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import (
    Frames,
    Integers,
    compose,
    identity,
    inverse,
    join,
    matrices,
)
from ipmlang.inverse.parts.observation import Parts
from ipmlang.inverse.split.distinct import numbered
from ipmlang.inverse.split.paper.tree import Tree

TURNED = 1e-5  # differences of directions that do not count
MOST = 2_000_000  # placements compared at once: beyond, subtrees are taken to differ


@dataclass(slots=True, eq=False)
class Labels:
    """label (n + 1,): of every node, those below the count of classes are leaves of that class, -1
    for the root; frames: of a label's coordinates, one a node, in the world; symmetry: of each
    label, the frames that map it onto itself.
    """

    label: Integers
    frames: Frames
    symmetry: list[Frames]


def labelled(tree: Tree, parts: Parts, small: float) -> Labels:
    """Label equal subtrees, leaves first: what the paper's level-order comparison of nodes with one
    label comes to, where a subtree that differs gets a label of its own.
    """
    children = tree.children()
    shape = np.concatenate([[-1], parts.shape])
    found = Labels(
        shape.copy(),
        join([identity(), parts.frames]),
        [each.symmetry for each in parts.classes],
    )
    height = _heights(tree)
    height[0] = 0  # nothing is equal to all of it
    for level in range(1, int(height.max(initial=0)) + 1):
        alike: dict[tuple[int, ...], list[int]] = {}
        for node in np.flatnonzero(height == level).tolist():
            within = sorted(found.label[children[node]].tolist())
            alike.setdefault((int(shape[node]), *within), []).append(node)
        for (kind, *_), nodes in alike.items():
            _label_alike(found, np.array(nodes), [children[n] for n in nodes], kind, small)
    return found


def _heights(tree: Tree) -> Integers:
    height = np.zeros(len(tree.parent), np.int64)
    for node in tree.order[:0:-1]:
        above = tree.parent[node]
        height[above] = max(height[above], height[node] + 1)
    return height


def _label_alike(
    found: Labels, nodes: Integers, below: Sequence[Integers], kind: int, small: float
) -> None:
    """Label nodes of one class with the same labels in them, by where those stand."""
    own = found.symmetry[kind]
    many = sum(len(found.symmetry[label]) for label in found.label[below[0]]) * len(own)
    if len(nodes) == 1 or many * len(nodes) > MOST:
        for node in nodes:
            found.label[node] = len(found.symmetry)
            found.symmetry.append(identity())
        return
    told = _told(found, nodes, np.stack(below), own, small)
    known: dict[bytes, int] = {}
    for place, node in enumerate(nodes.tolist()):
        names = [row.tobytes() for row in told[:, place]]
        best = min(names)
        equal = np.array([row for row, name in enumerate(names) if name == best])
        if best not in known:
            known[best] = len(found.symmetry)
            found.symmetry.append(compose(inverse(own[equal[:1]]), own[equal]))
        found.label[node] = known[best]
        turned = compose(found.frames[np.array([node])], own[equal[:1]])
        _put(found.frames, node, turned)


def _put(frames: Frames, row: int, to: Frames) -> None:
    frames.position[row], frames.rotation[row] = to.position[0], to.rotation[0]
    frames.hand[row], frames.scale[row] = to.hand[0], to.scale[0]


def _told(found: Labels, nodes: Integers, below: Integers, own: Frames, small: float) -> Integers:
    """(g, k, m) numbers that tell what stands where in each of k nodes with m children, seen from
    each of the g frames that the nodes' symmetry allows, sorted.

    A child may stand in any frame that its own symmetry allows: the least counts.
    """
    turns, count, members = len(own), len(nodes), below.shape[1]
    outer = compose(found.frames[np.tile(nodes, turns)], own[np.repeat(np.arange(turns), count)])
    inner = found.frames[np.tile(below.ravel(), turns)]
    relative = compose(inverse(outer)[np.repeat(np.arange(turns * count), members)], inner)
    label = np.tile(found.label[below.ravel()], turns)
    owner, allowed = _allowed(found, label)
    spots = matrices(compose(relative[owner], allowed)).reshape(-1, 12)
    columns = [
        numbered(spots[:, column], small if column % 4 == 3 else TURNED) for column in range(12)
    ]
    _, rank = np.unique(np.stack([label[owner], *columns], axis=1), axis=0, return_inverse=True)
    starts = np.concatenate([[0], np.flatnonzero(np.diff(owner)) + 1])
    least = np.minimum.reduceat(rank.reshape(-1), starts)
    return np.sort(least.reshape(turns, count, members), axis=2)


def _allowed(found: Labels, label: Integers) -> tuple[Integers, Frames]:
    """For each of n labels its symmetries, one after the other, and whose they are."""
    kinds, kind = np.unique(label, return_inverse=True)
    symmetries = [found.symmetry[each] for each in kinds.tolist()]
    sizes = np.array([len(each) for each in symmetries])
    starts = np.cumsum(sizes) - sizes
    owner = np.repeat(np.arange(len(label)), sizes[kind])
    first = np.cumsum(sizes[kind]) - sizes[kind]
    within = np.arange(len(owner)) - first[owner]
    return owner, join(symmetries)[starts[kind][owner] + within]


def rule_labels(tree: Tree, labels: Labels) -> frozenset[int]:
    """The labels that become rules: subtrees that repeat. The bottom-up phase of the paper: where
    all that has a label stands once in a parent of one other label, the parent is the rule.
    """
    label = labels.label
    inner = np.zeros(len(label), np.bool_)
    inner[tree.parent[1:]] = True
    repeated = np.bincount(label[1:][inner[1:]], minlength=len(labels.symmetry))
    above: dict[int, set[int]] = {}
    for node in np.flatnonzero(inner)[1:].tolist():
        above.setdefault(int(label[node]), set()).add(int(label[tree.parent[node]]))
    kept = set()
    for each, parents in above.items():
        (one,) = parents if len(parents) == 1 else (-1,)
        bubbled = one >= 0 and repeated[one] == repeated[each]
        if repeated[each] > 1 and not bubbled:
            kept.add(each)
    return frozenset(kept)
