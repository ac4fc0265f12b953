"""Whether an edit tore a building apart: judged on what is drawn before and after.

In go two derivation trees, out comes nothing, or an error that names what came apart. Parts have no
identity across an edit, so kinds are judged: what always touched something of a kind must still.
"""

from __future__ import annotations

import re

import numpy as np

from ipmlang.compiler.diagnostics import fail
from ipmlang.edit.buildings.contacts import gaps, neighbours, touching
from ipmlang.edit.buildings.tree import Tree
from ipmlang.inverse.frames import Floats

MADE = re.compile(
    r"(_baked|_fitted|_sized)(_\d+)?"
)  # in the label of a terminal that was stretched
NEAR = 1e-6  # of the diagonal
ROUNDED = 0.5  # of a wanted change, that a whole may be off by; of parts, that may stay
FAR = 0.1  # of a change, from which on a part is meant to move, and does


def check_sound(before: Tree, after: Tree, near: float) -> None:
    """Raises IpmError if anything has no size, or hangs in the air that did not."""
    loose = came_apart(before, after, near) | parted(before, after, near)
    if loose:
        named = ", ".join(f"`{name}`" for name in sorted(loose)[:6])
        raise fail(
            "comes-apart",
            f"this would tear the building apart: {named} would touch nothing that it touched",
            hint="select more of the building, or a smaller change",
        )


def came_apart(before: Tree, after: Tree, near: float) -> set[str]:
    """The labels of terminals all of which touched others, of which some touch neither one of these
    kinds now, nor their own.
    """
    touched = _touched(before, near)
    now = _touched(after, 4 * near)
    all_touch = {label: set.union(*kinds) for label, kinds in touched.items() if all(kinds)}
    return {
        label
        for label, kinds in now.items()
        if label in all_touch and not all(each & (all_touch[label] | {label}) for each in kinds)
    }


def parted(before: Tree, after: Tree, near: float) -> set[str]:
    """The labels of terminals that touched and do not, where both have the same terminals in the
    same order.
    """
    if kinds_of(before) != kinds_of(after):
        return set()
    pairs = before.neighbours(near)
    low, high = after.boxes(np.eye(3))
    far = max(near, NEAR * float(np.linalg.norm(high.max(axis=0) - low.min(axis=0))))
    broken = pairs[gaps(low, high, pairs) > 2 * far]
    return {before.terminals.labels[row] for row in np.unique(broken).tolist()}


def kinds_of(tree: Tree) -> list[str]:
    """The labels of all terminals, those that were stretched as what they were made of."""
    return [MADE.sub("", label).lower() for label in tree.terminals.labels]


def _touched(tree: Tree, near: float) -> dict[str, list[set[str]]]:
    """For each label, the labels that each of its terminals touches."""
    labels = kinds_of(tree)
    found: list[set[str]] = [set() for _ in labels]
    for i, j in tree.neighbours(near).tolist():
        found[i].add(labels[j])
        found[j].add(labels[i])
    gathered: dict[str, list[set[str]]] = {}
    for label, own in zip(labels, found, strict=True):
        gathered.setdefault(label, []).append(own)
    return gathered


def runs_into(before: Tree, after: Tree, near: float) -> bool:
    """Whether terminals that are in both and abutted now stand in each other."""
    one, other = before.scene.instances.key, after.scene.instances.key
    _, mine, theirs = np.intersect1d(one, other, return_indices=True)
    low, high = (each[mine] for each in before.boxes(np.eye(3)))
    pairs = neighbours(low, high, near)
    abut = touching(low, high, pairs, near)
    pairs = pairs[abut.any(axis=1)]
    low, high = (each[theirs] for each in after.boxes(np.eye(3)))
    i, j = pairs.T
    depth = np.minimum(high[i], high[j]) - np.maximum(low[i], low[j])
    return bool(((depth > 10 * near).all(axis=1)).any())


def out_of_line(before: Tree, after: Tree, near: float) -> bool:
    """Whether faces of neighbours that lay in one plane do not, where both trees have the same
    terminals: one part was changed, and what belongs to it did not follow.
    """
    one, other = before.scene.instances.key, after.scene.instances.key
    common, mine, theirs = np.intersect1d(one, other, return_indices=True)
    if not len(common) == len(one) == len(other):
        return False
    low, high = (each[mine] for each in before.boxes(np.eye(3)))
    i, j = neighbours(low, high, near).T
    low_after, high_after = (each[theirs] for each in after.boxes(np.eye(3)))
    return any(
        bool(((np.abs(a[i] - b[j]) <= near) & (np.abs(c[i] - d[j]) > 4 * near)).any())
        for a, b, c, d in (
            (low, low, low_after, low_after),
            (high, high, high_after, high_after),
            (low, high, low_after, high_after),
            (high, low, high_after, low_after),
        )
    )


def follows(before: Tree, after: Tree, axes: Floats, axis: int, wanted: float) -> bool:
    """Whether a building that shall become so much larger along an axis, of (3, 3) rows, does so on
    the whole, and not just the scope that it was given, or one part of many: counts may round, and
    some parts keep their places.
    """
    low, high = (each[:, axis] for each in before.boxes(axes))
    low_after, high_after = (each[:, axis] for each in after.boxes(axes))
    begin, span = float(low.min()), float(high.max() - low.min())
    if abs(float(high_after.max() - low_after.min()) - span - wanted) > ROUNDED * abs(wanted):
        return False
    if len(low) != len(low_after):
        return set(kinds_of(before)) <= set(kinds_of(after))
    share = (np.concatenate([low, high]) - begin) / span * wanted
    moved = np.concatenate([low_after - low, high_after - high]) - (low_after.min() - begin)
    far = np.abs(share) > FAR * abs(wanted)
    return bool(np.mean((np.abs(moved) > FAR * np.abs(share))[far]) >= ROUNDED)
