"""Every record of the table of functions, on the GPU and in numpy: the same bits where it is exact,
else within a stated distance, on special values and on random ones.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable

import numpy as np
import pytest
from gpu.function_values import (
    Column,
    Functions,
    hard_quotients,
    hard_roots,
    randoms,
    run,
    specials,
)
from numpy.typing import NDArray

from ipmlang.compiler.ops import FUNCTIONS
from ipmlang.compiler.ops.record import Function
from ipmlang.runtime import keys
from ipmlang.runtime.gpu.device import Device
from ipmlang.runtime.gpu.functions import ARGUMENTS, FUNCTION_NUMBERS, arity, calls, source

ROWS = 10_000

ULPS = {
    **dict.fromkeys(("sin", "cos", "pow", "exp", "log"), 5),
    **dict.fromkeys(("tan", "asin", "acos", "atan", "atan2"), 6),
    "noise": 0,
    "gauss": 8,
}
"""How far an inexact function may be from numpy, in ulp. The GPU's own are within 2 of the true
value everywhere; numpy's vector code is allowed 4 on some processors. Of `gauss` it is counted in
ulp of |mean| + 6 deviations: its sum may cancel.
"""


@pytest.fixture
def functions(card: Device) -> Functions:
    """The functions of the language on whatever computes here; compiled once."""
    return Functions(card)


def lengths(record: Function) -> tuple[int, ...]:
    """How many arguments to try: none that may be left out, all, and for lists up to 33."""
    least = sum(not (param.optional or param.many) for param in record.params)
    most = len(record.params)
    many = (most, most + 2, 7, 33) if any(param.many for param in record.params) else ()
    return tuple(sorted({*range(least, most + 1), *many}))


CASES = [(name, count) for name, record in FUNCTIONS.items() for count in lengths(record)]


def compared(functions: Functions, name: str, columns: list[Column]) -> None:
    """Asserts that both give the same, and says for which numbers they do not."""
    record = FUNCTIONS[name]
    found = functions(name, *columns)
    with np.errstate(all="ignore"):
        wanted = np.broadcast_to(np.asarray(record.batch(*columns), np.float64), found.shape)
        if record.exact:
            wrong = ~same_bits(found, wanted)
        else:
            wrong = ~(distance(name, found, wanted, columns) <= ULPS[name])
    shown = [
        f"{name}({', '.join(repr(float(column[row])) for column in columns)}): "
        f"{float(found[row])!r} on the GPU, {float(wanted[row])!r} in numpy"
        for row in np.flatnonzero(wrong)[:5]
    ]
    assert not shown, "\n".join([f"{int(wrong.sum())} of {len(wrong)} differ", *shown])


def same_bits(a: Column, b: Column) -> NDArray[np.bool_]:
    """Equal bit for bit, the sign of zero included; every NaN is like another."""
    same: NDArray[np.bool_] = (bits(a) == bits(b)) | (np.isnan(a) & np.isnan(b))
    return same


def bits(a: Column) -> NDArray[np.int64]:
    return np.ascontiguousarray(a).view(np.int64)


def distance(name: str, a: Column, b: Column, columns: list[Column]) -> Column:
    """How far a and b are apart, in ulp of b; infinite where only one of them is a number."""
    size = np.abs(b)
    if name == "gauss":
        size = np.abs(columns[1]) + 6 * np.abs(columns[2])
    gap = np.abs(a - b) / np.spacing(np.minimum(size, 1.7e308))
    return np.where(same_bits(a, b), 0.0, np.where(np.isnan(gap), np.inf, gap))


def test_every_record_has_a_body() -> None:
    heads = re.findall(r"^double function_(\w+)\(([^)]*)\)", source(), re.MULTILINE)
    bodies = {name: parameters.count("double") for name, parameters in heads}
    bodies.pop("of")
    assert bodies == {name: arity(name) for name in FUNCTIONS}
    assert list(FUNCTION_NUMBERS.values()) == list(range(len(FUNCTIONS)))


@pytest.mark.parametrize(("name", "count"), CASES)
def test_calls_take_what_the_function_takes(name: str, count: int) -> None:
    """Each call has as many arguments as the body, and each register of the IR is read."""
    given = range(count + FUNCTIONS[name].random)
    laid_out = calls(name, given)
    assert {len(call.args) for call in laid_out} == {arity(name)}
    assert arity(name) <= ARGUMENTS
    arguments = [argument for call in laid_out for argument in call.args]
    assert {value for kind, value in arguments if kind == "register"} == set(given)
    assert sum(kind == "result" for kind, _ in arguments) >= len(laid_out) - 1


@pytest.mark.parametrize(("name", "count"), CASES)
def test_special_values(functions: Functions, name: str, count: int) -> None:
    random = FUNCTIONS[name].random
    compared(functions, name, specials(count + random, draws=random))


@pytest.mark.parametrize(("name", "count"), CASES)
def test_random_values(functions: Functions, name: str, count: int) -> None:
    random = FUNCTIONS[name].random
    compared(functions, name, randoms(count + random, ROWS, draws=random))


def test_quarters_of_a_turn_are_exact(functions: Functions) -> None:
    turns = np.concatenate([np.arange(-40.0, 41.0), np.arange(1.0, 8.0) * 2.0**50]) * 90.0
    for name in ("sin", "cos", "tan"):
        with np.errstate(all="ignore"):
            assert same_bits(functions(name, turns), FUNCTIONS[name].batch(turns)).all()


def test_powers_that_are_whole_are_exact(functions: Functions) -> None:
    base, exponent = (part.ravel() for part in np.meshgrid(np.arange(-9.0, 10), np.arange(16.0)))
    assert np.array_equal(functions("pow", base, exponent), base**exponent)


LIBRARY: dict[str, tuple[Callable[[float], float], float, float]] = {
    "sin": (lambda a: math.sin(math.radians(a)), -45, 45),
    "cos": (lambda a: math.cos(math.radians(a)), -45, 45),
    "asin": (lambda a: math.degrees(math.asin(a)), -1, 1),
    "acos": (lambda a: math.degrees(math.acos(a)), -1, 1),
    "atan": (lambda a: math.degrees(math.atan(a)), -9, 9),
    "exp": (math.exp, -700, 700),
    "log": (math.log, 0, 5),
}


@pytest.mark.parametrize("name", LIBRARY)
def test_elementary_functions_are_near_the_c_library(functions: Functions, name: str) -> None:
    """A second witness, within 3 ulp: numpy has vector code of its own for these."""
    single, low, high = LIBRARY[name]
    a = np.random.default_rng(7).uniform(low, high, ROWS)
    wanted = np.array([single(value) for value in a.tolist()])
    assert distance(name, functions(name, a), wanted, []).max() <= 3


def skewed(ulps: float) -> str:
    """GLSL whose first guesses at quotients and roots are off by this much, up and down."""
    sign = "(uint(gl_GlobalInvocationID.x) % 2u == 0u ? 1.0lf : -1.0lf)"
    off = f"(1.0lf + {ulps * 2.0**-52!r}lf * {sign})"
    quotient, root = f"((a) / (b) * {off})", f"(sqrt(a) * {off})"
    return f"#define FIRST_QUOTIENT(a, b) {quotient}\n#define FIRST_ROOT(a) {root}\n"


@pytest.mark.parametrize("ulps", [0.0, 1.0, 3.0])
def test_quotients_and_roots_are_right_on_drivers_that_are_not(card: Device, ulps: float) -> None:
    """GLSL lets quotients and roots be off by some ulps, as many drivers are."""
    functions = Functions(card, skewed(ulps)) if ulps else Functions(card)
    compared(functions, "div", [np.repeat(column, 2) for column in hard_quotients()])
    compared(functions, "sqrt", [np.repeat(hard_roots(), 2)])
    random = np.random.default_rng(3)
    for name, count in (("div", 2), ("sqrt", 1), ("mod", 2), ("tiles", 2)):
        columns = [random.lognormal(0, 9, ROWS) for _ in range(count)]
        compared(functions, name, columns)
        compared(functions, name, [np.round(column, 1) for column in columns])


DRAW = """
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Given { uvec4 given[]; };
layout(std430, binding = 1) writeonly buffer Found { dvec4 found[]; };

void main() {
    uint row = gl_GlobalInvocationID.x;
    if (row >= given.length()) return;
    uvec4 words = given[row];
    uvec2 child = mixed(mixed(words.xy, words.z), words.w);
    double copied = draw_of(mixed(mixed(words.xy, words.z ^ SIGN_BIT), words.w));
    found[row] = dvec4(
        from_word(child.x), from_word(child.y), uniform_of(words.xy, words.z), copied
    );
}
"""


def test_keys_and_draws_have_the_same_bits(card: Device) -> None:
    words = np.random.default_rng(5).integers(0, 2**32, (ROWS, 4), dtype=np.uint32)
    k0, k1, site, index = (words[:, column] for column in range(4))
    shader = card.compile(f"#version 430\n{source()}\n{DRAW}", "draws")
    found = run(card, shader, words, ROWS, 4).reshape(ROWS, 4).T
    for row in range(0, ROWS, 100):
        key = (int(k0[row]), int(k1[row]))
        at, copy = int(site[row]), int(index[row])
        assert tuple(found[:2, row]) == keys.child_single(*key, at, copy)
        assert found[2, row] == keys.uniform_single(*key, at)
        assert found[3, row] == keys.uniform_single(*key, at, copy)
