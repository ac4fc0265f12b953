"""Python source for value instructions: one function for batches, one for single shapes.

In go straight-line value instructions and the registers that are wanted, out come two functions
that give the same bits. Constants fold, code that nothing wants is left out. Children, turtles and
loops over shapes are not here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.ops import FUNCTIONS
from ipmlang.runtime import keys
from ipmlang.runtime.keys import Words
from ipmlang.runtime.sampling import Context, fetch, fetch_single

Column: TypeAlias = "float | NDArray[np.float64]"
Tables: TypeAlias = Sequence[Sequence[NDArray[np.float64]]]


@dataclass(frozen=True, slots=True, eq=False)
class Data:
    """What code reads besides its registers: tables by column, and contexts."""

    tables: Tables = ()
    contexts: Sequence[Context] = ()


NO_DATA = Data()  # of code that runs before there are shapes
Batched: TypeAlias = Callable[
    [Sequence[Column], Words, Words, Mapping[int, Words], Sequence[float], Data],
    tuple[Column, ...],
]
Single: TypeAlias = Callable[
    [Sequence[float], int, int, Mapping[int, int], Sequence[float], Data], tuple[float, ...]
]

SOUND = frozenset({"param", "index", "uniform", "count"})  # the numbers that these give are finite
INFIX = {"add": "+", "sub": "-", "mul": "*"}  # the same bits in numpy and in Python


def doubtful(code: Iterable[ir.Instruction]) -> frozenset[int]:
    """The registers that straight-line code writes and whose numbers may not be finite."""
    return frozenset(
        each.out
        for each in code
        if each.op in ir.VALUE_OPS and each.op not in SOUND
        and not (each.op == "const" and math.isfinite(float(str(each.const))))
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Names:
    """What generated source calls things: a parameter, an attribute, a copy's number."""

    param: Callable[[int], str]
    attr: Callable[[int], str | float]
    index: Callable[[int], str]
    keys: str  # the arguments of `uniform` before the site
    copies: str = ""  # and after it: the numbers of the copies
    table: Callable[[int], str] = "data.tables[{}]".format  # its columns


def expression(each: ir.Instruction, args: Sequence[str | float], names: Names) -> str | float:
    """The source, or the known number, of one value instruction whose arguments are known."""
    match each.op:
        case "const":
            return float(str(each.const))
        case "param":
            return names.param(int(str(each.const)))
        case "attr":
            return names.attr(int(str(each.const)))
        case "index":
            return f"as_number({names.index(int(str(each.const)))})"
        case "row":
            assert isinstance(each.const, tuple)
            table, column = each.const
            return f"cell({names.table(int(str(table)))}[{column}], {args[0]!s})"
        case "fetch":
            assert isinstance(each.const, tuple)
            context, channel = each.const
            x, y = (source(arg) for arg in args)
            return f"fetch(data.contexts[{context}], {channel}, {x}, {y})"
        case "uniform":
            return f"uniform({names.keys}, {each.site}{names.copies})"
        case _:
            return called(str(each.const), args)


def called(name: str, args: Sequence[str | float]) -> str | float:
    """A call of a pure function."""
    if all(isinstance(arg, float) for arg in args):
        return float(FUNCTIONS[name].single(*args))
    shown = [source(arg) for arg in args]
    if name in INFIX:
        return f"({shown[0]} {INFIX[name]} {shown[1]})"
    return f"f_{name}({', '.join(shown)})"


def source(operand: str | float) -> str:
    """An operand as source: numbers that source cannot spell get names."""
    if isinstance(operand, str):
        return operand
    if operand != operand:
        return "nan"
    if operand in (np.inf, -np.inf):
        return "inf" if operand > 0 else "(-inf)"
    return repr(operand) if operand >= 0 else f"({operand!r})"


def needed(instructions: Sequence[ir.Instruction], outputs: Iterable[int]) -> set[int]:
    """The registers that the outputs depend on."""
    wanted = set(outputs)
    for each in reversed(instructions):
        if each.out in wanted:
            wanted.update(each.args)
    return wanted


def cell_of(column: NDArray[np.float64], index: Column) -> Column:
    """A table's cells; a row beyond the last is the last."""
    cells = column.take(np.asarray(index).astype(np.int64), mode="clip")
    return cells if cells.ndim else float(cells)


def as_number(index: Words | int) -> Column:
    """A copy's number as a number of the language."""
    return index.astype(np.float64) if isinstance(index, np.ndarray) else float(index)


def namespace(single: bool) -> dict[str, object]:
    """The names that generated source uses."""
    functions = {
        f"f_{name}": record.single if single else record.batch for name, record in FUNCTIONS.items()
    }
    uniform = keys.uniform_single if single else keys.uniform
    return {
        **functions,
        "uniform": uniform,
        "cell": cell_of,
        "fetch": fetch_single if single else fetch,
        "as_number": as_number,
        "nan": float("nan"),
        "inf": float("inf"),
    }


@lru_cache(maxsize=4096)
def compile_values(
    instructions: tuple[ir.Instruction, ...], outputs: tuple[int, ...]
) -> tuple[Batched, Single]:
    """Functions of (params, key words, copy numbers by repeat, attrs, data) to the outputs.

    The batched one takes (n,) columns or numbers and keeps numbers that are the same for all.
    """
    names = Names(
        lambda i: f"params[{i}]",
        lambda i: f"attrs[{i}]",
        lambda i: f"index[{i}]",
        "k0, k1",
        ", *index.values()",
    )
    wanted = needed(instructions, outputs)
    values: dict[int, str | float] = {}
    lines = ["def values(params, k0, k1, index, attrs, data):"]
    for each in instructions:
        if each.out not in wanted:
            continue
        found = expression(each, [values[arg] for arg in each.args], names)
        if isinstance(found, str):
            lines.append(f"    r{each.out} = {found}")
            found = f"r{each.out}"
        values[each.out] = found
    results = "".join(f"{source(values[register])}, " for register in outputs)
    lines.append(f"    return ({results})")
    code = compile("\n".join(lines), "<values>", "exec")
    made = []
    for single in (False, True):
        space = namespace(single)
        exec(code, space)
        made.append(space["values"])
    batch, one = made
    return batch, one  # type: ignore[return-value]
