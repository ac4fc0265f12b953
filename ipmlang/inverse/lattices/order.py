"""In which order the members of a lattice are painted: along it, line by line, or anyhow.

Takes paint ranks and nodes; gives a kind and a constant stride. Nothing here moves anything.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np

from ipmlang.inverse.lattices.cloud import Integers

OrderKind: TypeAlias = Literal[
    "contiguous",
    "linear",
    "rising",
    "row-major",
    "column-major",
    "boustrophedon",
    "column-boustrophedon",
    "arbitrary",
]


def along(rank: Integers, index: Integers) -> tuple[OrderKind, int]:
    """Order and stride of members (m,) by one index; stride 0: not constant.

    >>> along(np.array([7, 5, 3]), np.array([2, 1, 0]))
    ('linear', 2)
    """
    stride = _stride(rank[np.argsort(index)])
    if stride is None:
        return "arbitrary", 0
    if stride == 1:
        return "contiguous", 1
    return ("linear", stride) if stride else ("rising", 0)


def across(rank: Integers, index: Integers) -> tuple[OrderKind, int]:
    """Order and stride of members by their nodes (m, 2): row-major has i run fastest.

    >>> across(np.arange(4), np.array([[0, 0], [1, 0], [0, 1], [1, 1]]))
    ('row-major', 1)
    """
    i, j = index.T
    zigzag_i, zigzag_j = np.where(j % 2, -i, i), np.where(i % 2, -j, j)
    kinds: list[tuple[OrderKind, Integers, Integers]] = [
        ("row-major", i, j),
        ("column-major", j, i),
        ("boustrophedon", zigzag_i, j),
        ("column-boustrophedon", zigzag_j, i),
    ]
    for kind, fast, slow in kinds:
        stride = _stride(rank[np.lexsort((fast, slow))])
        if stride is not None:
            return kind, stride
    return "arbitrary", 0


def _stride(rank: Integers) -> int | None:
    """The constant difference of rising ranks, 0 if not constant; None if they do not rise."""
    steps = np.diff(rank)
    if (steps <= 0).any():
        return None
    return int(steps[0]) if len(steps) and (steps == steps[0]).all() else 0
