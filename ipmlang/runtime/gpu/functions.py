"""The pure functions of the language on the GPU: numbers for them, calls of them, their GLSL.

In goes the table of functions and, for a call in the IR, the registers of its arguments; out come
the calls of the machine that compute it, each with a fixed number of arguments, and the source
text with `function_of(number, a)`, which the machine includes. The bodies stand in numbers.glsl,
elementary.glsl and functions.glsl, as function_<name of the record>. Nothing here talks to a GPU.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Literal, TypeAlias, assert_never

from ipmlang.compiler.ops import FUNCTIONS, Function

SOURCES = ("numbers.glsl", "elementary.glsl", "functions.glsl")
FUNCTION_NUMBERS = {name: number for number, name in enumerate(FUNCTIONS)}
ARGUMENTS = 8
"""How many arguments a call has room for."""

_AT_ONCE = 4  # values that one call of `pick` chooses among

Argument: TypeAlias = "tuple[Literal['register', 'result'], int] | tuple[Literal['number'], float]"
"""A register of the IR, the result of an earlier call of the same list, or a number."""


@dataclass(frozen=True, slots=True)
class Call:
    """One call of the machine: the function's number and `arity(name)` arguments."""

    function: int
    args: tuple[Argument, ...]


def arity(name: str) -> int:
    """How many arguments the machine's calls of a function have, its uniform included."""
    record = FUNCTIONS[name]
    match record.passing:
        case "plain" | "zeros":
            return len(record.params) + record.random
        case "range":
            return 3
        case "pairs":
            return 2
        case "choice":
            return 4 + _AT_ONCE
    assert_never(record.passing)


def calls(name: str, registers: Sequence[int]) -> tuple[Call, ...]:
    """The calls for one call of the IR, whose value is the result of the last one.

    >>> [call.args for call in calls("min", (4, 5, 6))]
    [(('register', 4), ('register', 5)), (('result', 0), ('register', 6))]
    >>> [call.args for call in calls("rand", (4, 5))]
    [(('register', 4), ('number', 0.0), ('register', 5))]
    """
    number = FUNCTION_NUMBERS[name]
    given: list[Argument] = [("register", register) for register in registers]
    return tuple(Call(number, args) for args in _laid_out(FUNCTIONS[name], given))


def _laid_out(record: Function, given: list[Argument]) -> Iterable[tuple[Argument, ...]]:
    match record.passing:
        case "plain":
            return (tuple(given),)
        case "zeros":
            return (_filled(record, given),)
        case "range":
            return (_ranged(given),)
        case "pairs":
            return _paired(given)
        case "choice":
            return _chosen(given[0], given[1:])
    assert_never(record.passing)


def _filled(record: Function, given: list[Argument]) -> tuple[Argument, ...]:
    left_out: list[Argument] = [("number", 0.0)] * (arity(record.name) - len(given))
    return *given, *left_out


def _ranged(given: list[Argument]) -> tuple[Argument, ...]:
    """The uniform and its range: 0 to 1, 0 to a bound, or what is given."""
    if len(given) == 3:
        return tuple(given)
    high: Argument = given[1] if len(given) == 2 else ("number", 1.0)
    return given[0], ("number", 0.0), high


def _paired(given: list[Argument]) -> Iterator[tuple[Argument, ...]]:
    yield given[0], given[1]
    for done, argument in enumerate(given[2:]):
        yield ("result", done), argument


def _chosen(uniform: Argument, values: list[Argument]) -> Iterator[tuple[Argument, ...]]:
    """Some values at a time: uniform, how many in all, first one's number, else what, values."""
    other = values[-1]
    for done, start in enumerate(range(0, len(values), _AT_ONCE)):
        some = values[start : start + _AT_ONCE]
        some += [values[-1]] * (_AT_ONCE - len(some))
        yield uniform, ("number", len(values)), ("number", start), other, *some
        other = ("result", done)


@cache
def source() -> str:
    """GLSL 4.30 without a version line: all bodies, ARGUMENTS, a FUNCTION_<NAME> for each number,
    and `double function_of(uint number, double a[ARGUMENTS])`.
    """
    folder = files(__package__)
    texts = [(folder / name).read_text(encoding="utf-8") for name in SOURCES]
    numbers = [
        f"#define FUNCTION_{name.upper()} {number}u" for name, number in FUNCTION_NUMBERS.items()
    ]
    return "\n".join([f"#define ARGUMENTS {ARGUMENTS}", *numbers, *texts, _dispatch()])


def _dispatch() -> str:
    """The switch over all functions."""
    cases = []
    for name in FUNCTION_NUMBERS:
        arguments = ", ".join(f"a[{place}]" for place in range(arity(name)))
        cases.append(f"    case FUNCTION_{name.upper()}: return function_{name}({arguments});")
    head = "double function_of(uint number, double a[ARGUMENTS]) {\n    switch (number) {"
    return "\n".join([head, *cases, "    }", "    return no_number();", "}", ""])
