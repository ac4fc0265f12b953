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
from ipmlang.runtime.code import Batched, Data, Names, compile_values, expression, needed, source
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
    data: Data,
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
            count = _held(guard, [column[:-1] for column in columns], attrs, data)
            if count < rows or rows == limit:
                break
            rows = min(rows * 8, limit)
        last = tuple(float(column[count]) for column in columns)
        words0, words1, k0, k1 = following(count, k0, k1)
        return [column[:count] for column in columns], words0, words1, last, k0, k1

    return walk


def _changes(
    production: ir.Production, tail: ir.Instruction, attrs: tuple[float, ...]
) -> list[Change] | None:
    """What a step does to each parameter, None where that is more than one sum or product, or
    where the guard draws.
    """
    assert production.guard is not None
    if any(each.op == "uniform" for each in production.guard[0]):
        return None
    code = {each.out: each for each in production.body if each.out >= 0}
    changes = [_change(code, register, place, attrs) for place, register in enumerate(tail.args)]
    return None if None in changes else [each for each in changes if each is not None]


def _change(
    code: Mapping[int, ir.Instruction], register: int, place: int, attrs: tuple[float, ...]
) -> Change | None:
    each = code[register]
    if _is_parameter(each, place):
        return "keep", 0.0
    if each.op != "call" or each.const not in ("add", "sub", "mul"):
        return None
    first, second = (code[arg] for arg in each.args)
    if _is_parameter(second, place) and each.const != "sub":
        first, second = second, first
    number = _number(second, attrs)
    if not _is_parameter(first, place) or number is None:
        return None
    return (
        ("multiply", number)
        if each.const == "mul"
        else (
            "add",
            -number if each.const == "sub" else number,
        )
    )


def _is_parameter(each: ir.Instruction, place: int) -> bool:
    return each.op == "param" and each.const == place


def _number(each: ir.Instruction, attrs: tuple[float, ...]) -> float | None:
    match each.op:
        case "const":
            return float(str(each.const))
        case "attr":
            return attrs[int(str(each.const))]
        case _:
            return None


def _run(first: float, change: Change, count: int) -> NDArray[np.float64]:
    """A parameter in `count` rows, one operation after the other: the bits of a loop."""
    kind, number = change
    column = np.full(count, number if kind != "keep" else first)
    column[0] = first
    if kind == "keep":
        return column
    return np.add.accumulate(column) if kind == "add" else np.multiply.accumulate(column)


def _held(
    guard: Batched,
    columns: Sequence[NDArray[np.float64]],
    attrs: tuple[float, ...],
    data: Data,
) -> int:
    """In how many rows, from the first on, the guard holds."""
    nothing = np.zeros(0, np.uint32)
    truth = np.asarray(guard(columns, nothing, nothing, {}, attrs, data)[0])
    holds = np.broadcast_to((truth != 0) & (truth == truth), (len(columns[0]),))
    return len(holds) if holds.all() else int(np.argmin(holds))


def _key_loop(site: int) -> tuple[list[str], list[str], str]:
    """The source of the loop over keys alone."""
    lines = [
        "a0, a1 = [0] * count, [0] * count",
        "for row in range(count):",
        "    a0[row] = k0",
        "    a1[row] = k1",
        *(f"    {line}" for line in _next_key(site)),
    ]
    return lines, ["count", "k0", "k1"], "a0, a1, k0, k1"


def _loop(
    production: ir.Production,
    tail: ir.Instruction,
    attrs: tuple[float, ...],
    space: Mapping[str, object],
) -> Walk:
    """The loop of any chain: guard, parameters and key, all in place."""
    assert production.guard is not None
    count = production.parameters
    guard, taken = _inline(production.guard[0], (production.guard[1],), attrs, "g")
    values, following = _inline(production.body, tail.args, attrs, "v")
    params = [f"p{number}" for number in range(count)]
    names = "".join(f"{name}, " for name in params)
    updated = "".join(f"{source(value)}, " for value in following)
    lines = [
        *(f"q{number} = []" for number in range(count)),
        "a0, a1 = [], []",
        *(f"note{number} = q{number}.append" for number in range(count)),
        "note_k0, note_k1 = a0.append, a1.append",
        "for _ in range(limit):",
        *(f"    {line}" for line in guard),
        f"    if not {source(taken[0])} or {source(taken[0])} != {source(taken[0])}:",
        "        break",
        *(f"    note{number}(p{number})" for number in range(count)),
        "    note_k0(k0)",
        "    note_k1(k1)",
        *(f"    {line}" for line in values),
        *([f"    {names}= {updated}"] if count else []),
        *(f"    {line}" for line in _next_key(tail.site)),
    ]
    columns = "".join(f"q{number}, " for number in range(count))
    result = f"[{columns}], a0, a1, ({names}), k0, k1"
    return cast("Walk", function(lines, ["limit", "k0", "k1", *params], result, space))


def _inline(
    instructions: tuple[ir.Instruction, ...],
    outputs: tuple[int, ...],
    attrs: tuple[float, ...],
    prefix: str,
) -> tuple[list[str], list[str | float]]:
    """Source of values in place of a call."""
    write = Source(prefix)
    names = Names(lambda i: f"p{i}", lambda i: attrs[i], lambda i: "", "k0, k1")
    wanted = needed(instructions, outputs)
    values: dict[int, str | float] = {}
    for each in instructions:
        if each.out in wanted:
            args = [values[arg] for arg in each.args]
            found = _quick(each, args) or expression(each, args, names)
            values[each.out] = write.let(found) if isinstance(found, str) else found
    return write.lines, [values[register] for register in outputs]


def _quick(each: ir.Instruction, args: list[str | float]) -> str | None:
    """A comparison that is decided without a call unless its sides are close."""
    name = str(each.const)
    if each.op != "call" or name not in ("lt", "gt") or not any(isinstance(a, str) for a in args):
        return None
    low, high = [source(arg) for arg in (args if name == "lt" else args[::-1])]
    if "0.0" in (low, high):  # nothing but 0 itself is close to 0
        return f"({low} < {high} or f_lt({low}, {high}))"
    return f"({high} - {low} > 1e-9 * (abs({low}) + abs({high})) or f_lt({low}, {high}))"


def _next_key(site: int) -> list[str]:
    """pcg3d of (k0, k1, site), in place: the third word is the same for all rows."""
    third = (site * 1664525 + 1013904223) & keys.MASK
    return [
        "k1 = k1 * 1664525 + 1013904223",
        f"k0 = (k0 * 1664525 + 1013904223 + k1 * {third}) & {keys.MASK}",
        f"k1 = (k1 + {third} * k0) & {keys.MASK}",
        f"k2 = ({third} + k0 * k1) & {keys.MASK}",
        "k1 ^= k1 >> 16",
        "k2 ^= k2 >> 16",
        f"k0 = ((k0 ^ (k0 >> 16)) + k1 * k2) & {keys.MASK}",
        f"k1 = (k1 + k2 * k0) & {keys.MASK}",
    ]
