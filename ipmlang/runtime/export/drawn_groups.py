"""Groups of a flat scene as effects of a drawing, and the order in which everything is painted.

In go the groups that `effect` made, each with the frame it is anchored in; out come effects in the
drawing's coordinates, named so that two groups never run together. Each effect is read once.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import Effect
from ipmlang.formats.svg.transforms import multiply
from ipmlang.runtime.export.drawn_assets import effects_of
from ipmlang.runtime.export.placing import drawing_matrices
from ipmlang.runtime.scene import Groups

NOWHERE = np.iinfo(np.int64).max


def drawn_groups(groups: Groups, flip: float) -> tuple[list[tuple[str, ...]], dict[str, Effect]]:
    """For each group the names of the effects around its content, outermost first; and all effects
    that wrap something, by name.
    """
    read = [() if each is None else effects_of(each) for each in groups.effects]
    matrices = drawing_matrices(groups, np.arange(len(groups)), flip).tolist()
    used = _used(groups)
    effects: dict[str, Effect] = {}
    own: list[tuple[str, ...]] = []
    columns = (groups.effect.tolist(), matrices, used.tolist())
    for number, (effect, matrix, is_used) in enumerate(zip(*columns, strict=True)):
        wraps = read[effect] if is_used else ()
        own.append(tuple(f"{number} {name}" for name, _ in wraps))
        a, b, c, d, e, f = matrix
        for name, each in wraps:
            placed = multiply((a, b, c, d, e, f), each.matrix)
            effects[f"{number} {name}"] = replace(each, matrix=placed)
    stacks = [
        tuple(name for each in chain if each >= 0 for name in own[each])
        for chain in _chains(groups).tolist()
    ]
    return stacks, effects


def _used(groups: Groups) -> NDArray[np.bool_]:
    """Which groups have anything in them."""
    used = np.zeros(len(groups), np.bool_)
    around = np.unique(groups.of[groups.of >= 0])
    while len(around):
        used[around] = True
        around = np.unique(groups.parent[around])
        around = around[around >= 0]
    return used


def paint_order(layer: NDArray[np.float64], groups: Groups | None) -> NDArray[np.intp]:
    """The rows (n,) in the order of painting: by layer, equal layers as they were derived.

    A group is painted whole: it takes the layer that it began with, and layers inside it order
    what is in it. So a group is never split, as with the stacking contexts of style sheets.
    """
    if groups is None:
        return np.argsort(layer, kind="stable")
    chains = _chains(groups)
    first = _first_rows(groups)
    keys: list[NDArray[np.generic]] = []
    rows = np.arange(len(layer))
    for depth in range(chains.shape[1]):
        own = np.where(groups.of >= 0, chains[groups.of, depth], -1)
        inside = own >= 0
        keys.append(np.where(inside, groups.layer[own], layer))
        keys.append(np.where(inside, first[own], rows))
    keys += [layer, rows]
    return np.lexsort(keys[::-1])


def _chains(groups: Groups) -> NDArray[np.int64]:
    """(m, deepest) the groups around each group, outermost first, itself last; -1 beyond."""
    count = len(groups)
    columns = [np.arange(count)]
    while (columns[-1] >= 0).any():
        above = columns[-1]
        columns.append(np.where(above >= 0, groups.parent[above], -1))
    inner = np.stack(columns[:-1], axis=1)[:, ::-1]
    shift = (inner < 0).sum(axis=1)
    index = np.arange(inner.shape[1]) + shift[:, None]
    chains = np.take_along_axis(inner, np.minimum(index, inner.shape[1] - 1), axis=1)
    return np.where(index < inner.shape[1], chains, -1)


def _first_rows(groups: Groups) -> NDArray[np.int64]:
    """(m,) the first row inside each group."""
    first = np.full(len(groups), NOWHERE)
    own = groups.of
    rows = np.arange(len(own))
    while (own >= 0).any():
        np.minimum.at(first, own[own >= 0], rows[own >= 0])
        own = np.where(own >= 0, groups.parent[own], -1)
    return first
