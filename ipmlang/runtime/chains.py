"""Chains: rules that make themselves last, walked at once instead of generation by generation.

In go a production such as `P(m) : m > 0 --> A T P(m - 1)`, out comes a function that walks it from
one shape: parameters and keys of every row, the same bits as one application after the other.
Where a step only adds to or multiplies its parameters, numpy accumulates them and only the keys,
which are a sequence of hashes, take a loop. Nothing is drawn here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.runtime import keys
from ipmlang.runtime.algebra import Source
from ipmlang.runtime.code import Batched, Names, compile_values, expression, needed, source
from ipmlang.runtime.primitives import function

Columns: TypeAlias = Sequence["NDArray[np.float64] | list[float]"]
# the parameters and both key words of all rows, and of what the last one becomes
Walked: TypeAlias = tuple[Columns, list[int], list[int], tuple[float, ...], int, int]
Walk: TypeAlias = Callable[..., Walked]  # (limit, k0, k1, *params)
Keys: TypeAlias = Callable[[int, int, int], tuple[list[int], list[int], int, int]]
Drawing: TypeAlias = Callable[..., tuple[tuple[object, ...], tuple[object, ...]]]
Change: TypeAlias = tuple[str, float]  # add, multiply or keep, and by how much

FIRST = 64  # rows that are tried first


@dataclass(frozen=True, slots=True)
class Chain:
    """A production whose tail makes its own symbol again.

    `walk(limit, k0, k1, *params)` follows it while it is taken, `limit` steps at most. `body` draws
    all rows at once and returns their slots and the state after the last.
    """

    production: int
    walk: Walk
    body: Drawing


def tail_of(production: ir.Production, symbol: int) -> ir.Instruction | None:
    """The last module of a body, where it makes the body's own symbol again and only a guard
    decides whether it does.
    """
    if production.chance is not None or production.guard is None:
        return None
    for each in reversed(production.body):
        if each.op == "module":
            return each if each.const == symbol else None
        if each.op == "repeat":
            return None
    return None


def walk_of(
    production: ir.Production,
    tail: ir.Instruction,
    attrs: tuple[float, ...],
    space: Mapping[str, object],
) -> Walk:
    """The function that walks a chain."""
    changes = _changes(production, tail, attrs)
    if changes is None or not changes:
        return _loop(production, tail, attrs, space)
    assert production.guard is not None
    guard, _ = compile_values(production.guard[0], (production.guard[1],))
    following = cast("Keys", function(*_key_loop(tail.site), space))

    def walk(limit: int, k0: int, k1: int, *params: float) -> Walked:
        rows = min(FIRST, limit)
        while True:
            columns = [_run(*pair, rows + 1) for pair in zip(params, changes, strict=True)]
            count = _held(guard, [column[:-1] for column in columns], attrs)
            if count < rows or rows == limit:
                break
            rows = min(rows * 8, limit)
        last = tuple(float(column[count]) for column in columns)
        return [column[:count] for column in columns], *following(count, k0, k1)[:2], last, *(
            following.ended(count)  # type: ignore[attr-defined]
        )

    return walk


