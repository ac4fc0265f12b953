"""Values for a program's attributes: what the caller gives, checked, and defaults for the rest.

In go a program, a seed and given values by name, out come the program (its texts extended by new
ones) and one number an attribute. Every wrong name, type and range is reported, not just the first.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, fail, nearest
from ipmlang.runtime import keys
from ipmlang.runtime.code import NO_DATA, Column, compile_values

Given = int | float | bool | str
PHRASES = {
    "int": "a whole number",
    "float": "a number",
    "bool": "true or false",
    "string": "a text",
}


def bind(
    program: ir.Program, given: Mapping[str, Given] | None, seed: int
) -> tuple[ir.Program, tuple[float, ...]]:
    """The program with its attributes' values for one run. Raises IpmError with all that is wrong.

    A default is evaluated once, with the root key of the seed, over the attributes before it.
    """
    given = given or {}
    names = [each.name for each in program.attrs if not each.hidden]
    problems = [_unknown(name, names) for name in given if name not in names]
    strings = {text: number for number, text in enumerate(program.strings)}
    values: list[float] = []
    for attr in program.attrs:
        value = given.get(attr.name)
        problem = None if value is None else _mistyped(attr, value)
        if problem is not None:
            problems.append(problem)
            value = None
        if value is None:
            number = _default(program, attr, values, seed)
        elif isinstance(value, str):
            number = float(strings.setdefault(value, len(strings)))
        else:
            number = float(value)
        problem = _outside(attr, number, list(strings))
        if problem is not None and not (attr.name in given and value is None):
            problems.append(problem)
        values.append(number)
    if problems:
        raise IpmError(problems)
    program = replace(program, strings=tuple(strings))
    if program.varied:
        program = replace(program, attrs=_fixed(program.attrs, given, values))
    return _settled(program, values, seed), tuple(values)


def _fixed(
    attrs: Sequence[ir.Attribute], given: Mapping[str, Given], values: Sequence[float]
) -> tuple[ir.Attribute, ...]:
    """Attributes whose given values are their defaults."""
    return tuple(
        replace(attr, default=((ir.Instruction("const", 0, const=value),), 0), registers=1)
        if attr.name in given
        else attr
        for attr, value in zip(attrs, values, strict=True)
    )


def varied(program: ir.Program, k0: keys.Words, k1: keys.Words) -> tuple[Column, ...]:
    """The axiom's parameters: for first shapes with the keys (k0, k1), each (n,), the attributes
    whose defaults are drawn, (n,) or one number. Raises IpmError for one out of range.
    """
    if not program.varied:
        return ()
    known: list[Column] = []
    for attr in program.attrs:
        code, register = attr.default
        batch, _ = compile_values(code, (register,))
        found = batch((), k0, k1, {}, known, NO_DATA)[0]  # type: ignore[arg-type]  # columns, too
        if np.isnan(found).any():
            raise fail("not-a-number", f"the default of `{attr.name}` is not a number")
        known.append(np.round(found) if attr.type == "int" else found)
    for number in program.varied:
        _refuse_outside(program.attrs[number], np.atleast_1d(known[number]), program.strings)
    return tuple(known[number] for number in program.varied)


def _refuse_outside(
    attr: ir.Attribute, values: NDArray[np.float64], strings: Sequence[str]
) -> None:
    """Raise what is wrong with the first value that is out of an attribute's range."""
    for value in np.unique(values).tolist():
        problem = _outside(attr, value, list(strings))
        if problem is not None:
            number = int(np.argmax(values == value)) + 1
            message = f"for first shape {number}, {problem.message}"
            raise IpmError([replace(problem, message=message)])


def evaluated(
    code: Sequence[ir.Instruction], outputs: Sequence[int], attrs: Sequence[float], seed: int
) -> tuple[float, ...]:
    """Numbers over the attributes of a run, with the seed's root key."""
    _, single = compile_values(tuple(code), tuple(outputs))
    return single((), *keys.root(seed), {}, attrs, NO_DATA)


def _settled(program: ir.Program, values: list[float], seed: int) -> ir.Program:
    """The program with the settings that its attributes decide."""
    if program.contexts:
        contexts = tuple(_laid(each, values, seed) for each in program.contexts)
        program = replace(program, contexts=contexts)
    late = program.late
    if late is None:
        return program
    wanted = (*(late.tropism or ()), *(register for _, register in late.limits))
    found = list(compile_values(late.code, wanted)[1]((), *keys.root(seed), {}, values, NO_DATA))
    if late.tropism is not None:
        x, y, z, elasticity = found[:4]
        del found[:4]
        if not math.isfinite(x + y + z + elasticity):
            raise fail("not-a-number", "a number of the `tropism` is not finite")
        program = replace(program, tropism=(x, y, z, elasticity))
    limits = {
        name: _limit(name, value) for (name, _), value in zip(late.limits, found, strict=True)
    }
    return replace(program, limits=replace(program.limits, **limits))


def _laid(context: ir.ContextFile, values: list[float], seed: int) -> ir.ContextFile:
    """A context with the rectangle that it covers."""
    place = context.place
    if context.late is not None:
        left, bottom, width, height = evaluated(*context.late, values, seed)
        place = (left, bottom, width, height)
    assert place is not None
    if math.isfinite(sum(place)) and min(place[2:]) > 0:
        return replace(context, place=place)
    numbers = ", ".join(f"{each:g}" for each in place)
    raise fail(
        "out-of-range",
        f"the context `{context.name}` would lie over ({numbers})",
        hint="left, bottom, width and height: width and height must be above 0",
        source=context.source,
        start=context.start,
        end=context.end,
    )


def _limit(name: str, value: float) -> int:
    if not 1 <= value < math.inf:
        raise fail("out-of-range", f"`limit {name}` is {value:g}, but must be 1 or more")
    return int(value)


def _default(program: ir.Program, attr: ir.Attribute, before: list[float], seed: int) -> float:
    code, register = attr.default
    _, single = compile_values(code, (register,))
    k0, k1 = keys.root(seed)
    value = float(single((), k0, k1, {}, before, NO_DATA)[0])
    if math.isnan(value):
        raise fail("not-a-number", f"the default of `{attr.name}` is not a number", hint=attr.doc)
    return float(round(value)) if attr.type == "int" and math.isfinite(value) else value


def _unknown(name: str, names: list[str]) -> Diagnostic:
    known = ", ".join(f"`{each}`" for each in names[:8])
    return Diagnostic(
        "unknown-attribute",
        f"there is no attribute `{name}`",
        expected=f"one of {known}{' …' if len(names) > 8 else ''}" if names else None,
        suggestions=nearest(name, names),
        hint=None if names else "this grammar has no `attr` that could be set",
    )


def _mistyped(attr: ir.Attribute, value: Given) -> Diagnostic | None:
    number = not isinstance(value, bool | str) and math.isfinite(value)
    match attr.type:
        case "string":
            fits = isinstance(value, str)
        case "bool":
            fits = isinstance(value, bool)
        case "int":
            fits = number and value == int(value)
        case "float":
            fits = number
    if fits:
        return None
    return Diagnostic(
        "wrong-attribute-type",
        f"`{attr.name}` is {PHRASES[attr.type]}, not {value!r}",
        expected=PHRASES[attr.type],
        hint=attr.doc,
    )


def _outside(attr: ir.Attribute, number: float, strings: list[str]) -> Diagnostic | None:
    """What is wrong with the value of an attribute that has a range."""
    if attr.choices:
        shown = strings[int(number)] if attr.type == "string" else number
        if shown in attr.choices:
            return None
        allowed = ", ".join(str(each) for each in attr.choices)
        return _out(attr, f"`{attr.name}` is {shown!s}, which is none of {allowed}")
    low = -math.inf if attr.low is None else attr.low
    high = math.inf if attr.high is None else attr.high
    if attr.type == "string" or low <= number <= high:
        return None
    if attr.low is not None and attr.high is not None:
        bounds = f"from {low:g} to {high:g}"
    else:
        bounds = f"at least {low:g}" if attr.low is not None else f"at most {high:g}"
    return _out(attr, f"`{attr.name}` is {number:g}, but must be {bounds}")


def _out(attr: ir.Attribute, message: str) -> Diagnostic:
    return Diagnostic("attribute-out-of-range", message, hint=attr.doc)
