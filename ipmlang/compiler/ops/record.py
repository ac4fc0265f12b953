"""What one operation, function or setting of the language is: a record, and nothing else.

The checker, the lowering, the formatter, the reference and the tests read records; adding an
operation is adding a record to one of the tables of this package.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

ValueType: TypeAlias = Literal[
    "number", "int", "bool", "string", "color", "vector", "asset", "symbol", "context", "any"
]
Family: TypeAlias = Literal["turtle", "pen", "scope", "split", "solid", "docking", "marching"]
NOT_GIVEN = -sys.float_info.max  # an argument that was left out: a number that no model needs
Effect: TypeAlias = Literal["motion", "pen", "draw", "scope", "structure"]


@dataclass(frozen=True, slots=True)
class Param:
    """One parameter: name, type, whether it may be left out, only by name, or repeated at the end.

    `above`: a literal must be greater than this. `words`: the texts or bare words it may be.
    `suffixes`: it names a file beside the grammar, of one of these kinds.
    """

    name: str
    type: ValueType = "number"
    optional: bool = False
    named: bool = False
    many: bool = False
    above: float | None = None
    words: tuple[str, ...] = ()
    suffixes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Step:
    """One IR instruction of an operation's meaning. Each arg is a parameter's name (optionally
    negated: `-angle`), or a number; a parameter that was left out takes `defaults` of the record.
    The op `body` stands for the parts in braces (`polygon { … }`).
    """

    op: str
    args: tuple[str | float, ...] = ()
    const: str | None = None


@dataclass(frozen=True, slots=True)
class Operation:
    """An operation of a successor.

    `forms`: parameter lists it accepts, tried in order (most have one). `defaults`: what an omitted
    parameter takes: a number, or a turtle setting's name (`angle`, `step`, `width`).
    `meaning`: IR steps per form, same order as `forms`; empty when no executor runs it yet.
    `labels`: None when it takes no braces, else the labels its parts may bear ("*": any number,
    "*123": a number of these digits, "#": any name, '""': any text, "": parts without label).
    `bare`: the braces may be left out. `spreads`: what follows it in its bracket is done for each
    of the parts that it makes. `axes`: words that may follow the name (split x).
    `effect`: motion and pen leak out of a rule, scope ends with the body.
    `leaves_plane`: it can leave z = 0 (makes a program 3-D).
    `examples` must parse and check as a successor; `refused` must give at least one error.
    """

    name: str
    family: Family
    effect: Effect
    doc: str
    forms: tuple[tuple[Param, ...], ...] = ((),)
    synonyms: tuple[str, ...] = ()
    defaults: tuple[tuple[str, str | float], ...] = ()
    meaning: tuple[tuple[Step, ...], ...] = ()
    labels: tuple[str, ...] | None = None
    bare: bool = False
    spreads: bool = False
    axes: tuple[str, ...] = ()
    leaves_plane: bool = False
    examples: tuple[str, ...] = ()
    refused: tuple[str, ...] = ()


Batch: TypeAlias = "NDArray[np.float64]"
Passing: TypeAlias = Literal["plain", "zeros", "range", "pairs", "choice"]


@dataclass(frozen=True, slots=True)
class Function:
    """A pure function of expressions, arithmetic and comparison included (`+` has name `add`).

    `batch` maps f64 arrays (or scalars) to an array, `single` Python floats to a float, with the
    same bits. `result` is its type. `exact`: the same on every back end, so it may feed a guard.
    `random`: it draws, and takes the uniform of its call site as a hidden first argument.
    `passing`: how a machine whose calls have a fixed number of arguments calls it: as it is
    written, with 0 for what is left out, with a range that [0, 1) stands for, two arguments at a
    time, or as a choice among any number of values.
    """

    name: str
    doc: str
    params: tuple[Param, ...]
    result: ValueType
    batch: Callable[..., Batch]
    single: Callable[..., float]
    exact: bool = True
    random: bool = False
    passing: Passing = "plain"
    examples: tuple[str, ...] = ()
    refused: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Query:
    """A function or a dotted name (`params` is None) that asks about where a shape stands:
    `inside(Wall)`, `split.index`. It has no body of its own: executors answer it. `family` says
    which operations it goes with; `ready`: some executor answers it.
    """

    name: str
    doc: str
    result: ValueType
    family: Family
    params: tuple[Param, ...] | None = None
    ready: bool = False
    examples: tuple[str, ...] = ()
    refused: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SettingRecord:
    """One word of a `turtle` or `limit` item. `default` is what holds without it, None: nothing;
    `words` are the bare words it may be; `above` as in Param.
    """

    item: Literal["turtle", "limit"]
    name: str
    type: ValueType
    doc: str
    default: float | str | None = None
    words: tuple[str, ...] = ()
    above: float | None = None
