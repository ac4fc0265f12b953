"""How a person's edit of a text is judged: tokens that changed, and whether a building holds.

In go texts and derivation trees from before and after, out comes what is wrong, nothing where all
holds. Parts have no identity across an edit, so kinds are judged, by the labels of the text.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator

import numpy as np

from ipmlang.edit.buildings.contacts import neighbours
from ipmlang.edit.buildings.tree import Tree
from ipmlang.edit.buildings.units import tolerance
from ipmlang.inverse.frames import linear

TOKEN = re.compile(r'"[^"]*"|[A-Za-z_][\w.]*|\d+\.?\d*|\S')
MADE = re.compile(r"Fitted(_\d+)?$")  # a label of a terminal that fills its scope


def token_changes(before: str, after: str) -> int:
    """How many tokens of a text a person changed, put in or took out."""
    one, other = TOKEN.findall(before), TOKEN.findall(after)
    if len(one) == len(other):
        return sum(a != b for a, b in zip(one, other, strict=True))
    found = difflib.SequenceMatcher(None, one, other, autojunk=False).get_opcodes()
    return sum(max(b - a, d - c) for kind, a, b, c, d in found if kind != "equal")


def pieces(tree: Tree, near: float) -> int:
    """Into how many parts that do not touch a building falls."""
    from scipy import sparse
    from scipy.sparse.csgraph import connected_components

    low, high = tree.boxes(np.eye(3))
    pairs = neighbours(low, high, near)
    count = len(low)
    graph = sparse.coo_matrix((np.ones(len(pairs)), pairs.T), (count, count))
    return int(connected_components(graph, directed=False)[0])


def let_go(before: Tree, after: Tree) -> set[str]:
    """`A B` for all kinds A of which every one touched a B before, and of which one touches none
    now, while there are still any; touching: within 1e-6 of the diagonal.
    """
    held = _held(before, tolerance(before))
    now = _held(after, tolerance(after))
    return {
        f"{label} {other}"
        for label, kinds in held.items()
        for other in set.intersection(*kinds)
        if other in now and not all(other in each for each in now.get(label, []))
    }


def _held(tree: Tree, near: float) -> dict[str, list[set[str]]]:
    """For each label, the labels that each of its terminals touches."""
    found: dict[str, list[set[str]]] = {}
    for label, kinds in _touched(tree, near):
        found.setdefault(label, []).append(kinds)
    return found


def _touched(tree: Tree, near: float) -> Iterator[tuple[str, set[str]]]:
    labels = [MADE.sub("", label) for label in tree.terminals.labels]
    kinds: list[set[str]] = [set() for _ in labels]
    for i, j in neighbours(*tree.boxes(own_axes(tree)), near).tolist():
        kinds[i].add(labels[j])
        kinds[j].add(labels[i])
    return zip(labels, kinds, strict=True)


def own_axes(tree: Tree) -> np.ndarray:
    """(3, 3) the axes along which most terminals are turned about the vertical, as rows."""
    turned = linear(tree.terminals.frames)
    upright = np.round(np.abs(turned[:, 2, 2]), 6) == 1.0
    heading = np.arctan2(turned[upright, 1, 0], turned[upright, 0, 0])
    angle, count = np.unique(np.round(np.mod(heading, np.pi / 2), 6), return_counts=True)
    turn = float(angle[np.argmax(count)]) if len(angle) else 0.0
    return np.array([[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
