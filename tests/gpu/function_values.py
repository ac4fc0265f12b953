"""A compute shader that calls functions of the language on columns of numbers, and such columns:
special values, and random ones near which two executors may part.

In go a device and f64 columns, out come f64 columns. Knows no program and no turtle.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime.gpu.functions import ARGUMENTS, Call, calls, source

if TYPE_CHECKING:
    import moderngl

    from ipmlang.runtime.gpu.device import Device

Column: TypeAlias = NDArray[np.float64]

GROUP = 64
MAIN = """
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Given { double given[]; };
layout(std430, binding = 1) writeonly buffer Found { double found[]; };
uniform uint rows;
uniform uint number;

void main() {
    uint row = gl_GlobalInvocationID.x;
    if (row >= rows) return;
    double a[ARGUMENTS];
    for (uint place = 0u; place < uint(ARGUMENTS); ++place) a[place] = given[place * rows + row];
    found[row] = function_of(number, a);
}
"""

SPECIAL = (
    *(np.nan, np.inf, 0.0, 0.5, 1.0, 1.5, 2.5, 3.0, 7.0, 0.1 * 3, 0.3, 3 * 3.2, 9.6, 3.2),
    *(2.9999999999, 3.0000000001, 1 - 2.0**-53, 1 + 2.0**-52, 1 + 1e-9, 4.5 - 1e-12),
    *(30.0, 45.0, 90.0, 180.0, 270.0, 360.0, 90.0 * 2**60, np.pi, 709.7, 745.0, 1e-9, 1e15),
    *(2.0**31, 2.0**52, 2.0**52 + 1, 2.0**53 + 2, 2.0**64, 1e300, 1.7976931348623157e308),
    *(1e-300, 2.2250738585072014e-308, 1e-310, 5e-324),
)
"""Each is meant with both signs."""

DRAWS = (0.0, 2.0**-24, 0.25, 0.5, 0.75, 1 - 2.0**-24, 1 / 3 // 2**-24 * 2**-24)


class Functions:
    """The functions of the language on a device. `before`: GLSL that goes before all."""

    def __init__(self, card: Device, before: str = "") -> None:
        self.card = card
        self.shader = card.compile(f"#version 430\n{before}\n{source()}\n{MAIN}", "functions")

    def __call__(self, name: str, *columns: Column) -> Column:
        """The value of a call, a row each: all calls of the machine that it takes, in turn."""
        results: list[Column] = []
        for call in calls(name, range(len(columns))):
            results.append(self._called(call, columns, results))
        return results[-1]

    def _called(self, call: Call, columns: Sequence[Column], results: Sequence[Column]) -> Column:
        given = np.zeros((ARGUMENTS, len(columns[0])))
        for place, (kind, value) in enumerate(call.args):
            if kind == "number":
                given[place] = value
            else:
                given[place] = (columns if kind == "register" else results)[int(value)]
        return self._run(call.function, given)

    def _run(self, number: int, given: Column) -> Column:
        rows = given.shape[1]
        self.shader["rows"], self.shader["number"] = rows, number
        return run(self.card, self.shader, given, rows, 1)


def run(
    card: Device, shader: moderngl.ComputeShader, given: NDArray[np.generic], rows: int, width: int
) -> Column:
    """What a shader of one invocation a row makes of a buffer, (rows * width,)."""
    filled, target = card.buffer(given.tobytes()), card.buffer(8 * rows * width)
    filled.bind(0)
    target.bind(1)
    card.dispatch(shader, -(-rows // GROUP), "functions")
    found = target.array(np.float64)
    filled.release()
    target.release()
    return found


def specials(count: int, *, draws: bool) -> list[Column]:
    """Special values in all combinations, for two of `count` columns, with some for a third;
    further ones take what these have, turned round. The first are draws if wanted.
    """
    both = [sign * value for value in SPECIAL for sign in (1.0, -1.0)]
    axes = [DRAWS if draws else both, both, [*both[:6], 2.5, 9.6, -1e300, 5e-324]][:count]
    columns = list(np.array(list(product(*axes)), np.float64).T)
    while len(columns) < count:
        columns.append(np.roll(columns[-1], 17 * len(columns)))
    return columns


def randoms(count: int, rows: int, *, draws: bool) -> list[Column]:
    """Random columns: any bits at all, numbers people write, and near multiples of one another."""
    random = np.random.default_rng(count)
    columns = [_any(random, rows)]
    for _ in range(count - 1):
        near = _near(random, columns[0])
        columns.append(np.where(random.random(rows) < 0.5, near, _any(random, rows)))
    random.shuffle(columns)
    if draws:
        columns[0] = random.integers(0, 2**24, rows) * 2.0**-24
    return columns


def hard_quotients() -> list[Column]:
    """Dividends and divisors whose quotients are as near as can be to half way between two numbers:
    with 53-bit whole A, B and odd N of 54 bits, A * 2^53 = N * B + c for a small c, so that A / B
    is c / (2 * B) ulp away.
    """
    found = []
    for divisor in range(2**52 + 1, 2**53, 2**45 + 2**20 + 6):
        for rest in (-3, -1, 1, 3):
            half_way = -rest * pow(divisor, -1, 2**53) % 2**53 + 2**53
            dividend = (half_way * divisor + rest) >> 53
            if dividend < 2**53:
                found.append((dividend, divisor))
    return list(np.array(found, np.float64).T)


def hard_roots() -> Column:
    """Numbers from 2 to 4 whose roots are as near as can be to half way between two numbers: with
    53-bit whole S, they are S * S + S + c for a small c, and a multiple of 2^53.
    """
    found = []
    for rest in range(-200, 202, 2):
        for root in (0, 1):  # of S * S + S + c modulo 2, lifted to 2^53 a bit at a time
            for bit in range(1, 53):
                root += ((root * root + root + rest) >> bit & 1) << bit
            if root * root >= 2**105:
                found.append((root * root + root + rest) >> 53)
    return np.array(found, np.float64) * 2.0**-51


def _any(random: np.random.Generator, rows: int) -> Column:
    bits = random.integers(0, 2**64, rows, dtype=np.uint64).view(np.float64)
    spread = random.standard_normal(rows) * 10.0 ** random.integers(-3, 4, rows)
    written = random.integers(-1000, 1000, rows) / random.choice([1, 2, 4, 10, 100], rows)
    return np.choose(random.integers(0, 3, rows), [bits, spread, written])


def _near(random: np.random.Generator, other: Column) -> Column:
    """Multiples and parts of a column, half tiles among them: exact, off by ulps, and on either
    side of what snaps.
    """
    n = random.integers(1, 50, len(other)).astype(np.float64)
    with np.errstate(all="ignore"):
        half_tile = (other / n + other / (n + 1)) / 2
        base = np.choose(
            random.integers(0, 4, len(other)), [other, other * n, other / n, half_tile]
        )
        off = random.choice([0.0, 1e-16, 3e-16, 0.999999e-9, 1e-9, 1.000001e-9], len(other))
        return base * (1 + off * random.choice([-1, 1], len(other)))
