"""Bodies of the functions that give the same bits everywhere: arithmetic, comparison, rounding.

Each comes twice, for f64 arrays and for Python floats, with the same result bit for bit; neither
warns, and what has no value is NaN. Comparisons snap: a and b are equal when
|a - b| <= 1e-9 * max(|a|, |b|), so that 3 * 3.2 is not greater than 9.6. Truth values are 1.0 and
0.0, and NaN where a NaN is compared; `and`, `or` and `not` are those of Kleene's strong logic
(*Introduction to Metamathematics*, 1952, section 64): false with anything is false, true or
anything is true, and what hangs on a NaN is NaN.
"""

from __future__ import annotations

import math
from functools import partial, reduce

import numpy as np
from numpy.typing import NDArray

Batch = NDArray[np.float64]
SNAP = 1e-9
quiet = partial(np.errstate, all="ignore")
nan = math.nan


def add(a: Batch, b: Batch) -> Batch:
    """The sum of a and b."""
    with quiet():
        return np.add(a, b)


def add_one(a: float, b: float) -> float:
    """The sum of a and b."""
    return a + b


def sub(a: Batch, b: Batch) -> Batch:
    """The difference of a and b."""
    with quiet():
        return np.subtract(a, b)


def sub_one(a: float, b: float) -> float:
    """The difference of a and b."""
    return a - b


def mul(a: Batch, b: Batch) -> Batch:
    """The product of a and b."""
    with quiet():
        return np.multiply(a, b)


def mul_one(a: float, b: float) -> float:
    """The product of a and b."""
    return a * b


def div(a: Batch, b: Batch) -> Batch:
    """The quotient of a and b; by zero: infinite, or NaN for 0 / 0."""
    with quiet():
        return np.divide(a, b)


def div_one(a: float, b: float) -> float:
    """The quotient of a and b; by zero: infinite, or NaN for 0 / 0."""
    if b:
        return a / b
    if a == 0 or a != a:
        return nan
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


def neg(a: Batch) -> Batch:
    """The negative of a."""
    return np.negative(a)


def neg_one(a: float) -> float:
    """The negative of a."""
    return -a


def _same(a: Batch, b: Batch) -> NDArray[np.bool_]:
    return _snapped(a, b)[0]


def _snapped(a: Batch, b: Batch) -> tuple[NDArray[np.bool_], bool]:
    """Which a and b are equal, snapped, and whether all gaps are finite: then none is NaN."""
    gap = np.abs(np.subtract(a, b))
    near: NDArray[np.bool_] = gap <= SNAP * np.maximum(np.abs(a), np.abs(b))
    finite = gap < np.inf
    if finite.all():
        return near, True
    return (np.asarray(a) == b) | (near & finite), False


def _same_one(a: float, b: float) -> bool:
    gap = abs(a - b)
    return a == b or (gap <= SNAP * max(abs(a), abs(b)) and gap < math.inf)


def has_nan(*columns: Batch | float) -> bool:
    """Whether a NaN is among numbers: the least of them is NaN then, one pass without a column."""
    return any(
        column != column
        if isinstance(column, float)
        else math.isnan(np.minimum.reduce(column, axis=None, initial=np.inf))
        for column in columns
    )


def _compared(found: NDArray[np.bool_], sure: bool, a: Batch, b: Batch) -> Batch:
    """The truth values of a comparison; NaN beside a NaN, unless there is none for `sure`."""
    truth = found.astype(np.float64)
    return truth if sure else np.where(np.isnan(a) | np.isnan(b), nan, truth)


def eq(a: Batch, b: Batch) -> Batch:
    """Whether a and b are equal, snapped."""
    with quiet():
        same, sure = _snapped(a, b)
        return _compared(same, sure, a, b)


def eq_one(a: float, b: float) -> float:
    """Whether a and b are equal, snapped."""
    return nan if a != a or b != b else float(_same_one(a, b))


def ne(a: Batch, b: Batch) -> Batch:
    """Whether a and b differ, snapped."""
    with quiet():
        same, sure = _snapped(a, b)
        return _compared(~same, sure, a, b)


def ne_one(a: float, b: float) -> float:
    """Whether a and b differ, snapped."""
    return nan if a != a or b != b else float(not _same_one(a, b))


def lt(a: Batch, b: Batch) -> Batch:
    """Whether a is less than b and not equal to it, snapped."""
    with quiet():
        same, sure = _snapped(a, b)
        return _compared(np.less(a, b) & ~same, sure, a, b)


def lt_one(a: float, b: float) -> float:
    """Whether a is less than b and not equal to it, snapped."""
    if a < b:
        return float(not _same_one(a, b))
    return 0.0 if a >= b else nan


def le(a: Batch, b: Batch) -> Batch:
    """Whether a is less than b or equal to it, snapped."""
    with quiet():
        same, sure = _snapped(a, b)
        return _compared(np.less(a, b) | same, sure, a, b)


def le_one(a: float, b: float) -> float:
    """Whether a is less than b or equal to it, snapped."""
    if a > b:
        return float(_same_one(a, b))
    return 1.0 if a <= b else nan


def gt(a: Batch, b: Batch) -> Batch:
    """Whether a is greater than b, snapped."""
    return lt(b, a)


def gt_one(a: float, b: float) -> float:
    """Whether a is greater than b, snapped."""
    return lt_one(b, a)


def ge(a: Batch, b: Batch) -> Batch:
    """Whether a is greater than b or equal to it, snapped."""
    return le(b, a)


def ge_one(a: float, b: float) -> float:
    """Whether a is greater than b or equal to it, snapped."""
    return le_one(b, a)


def both(a: Batch, b: Batch) -> Batch:
    """Whether a and b both hold; NaN where that hangs on a NaN."""
    found = np.not_equal(a, 0) & np.not_equal(b, 0)
    truth = found.astype(np.float64)
    return np.where(found & (np.isnan(a) | np.isnan(b)), nan, truth) if has_nan(a, b) else truth


def both_one(a: float, b: float) -> float:
    """Whether a and b both hold; NaN where that hangs on a NaN."""
    if a == 0 or b == 0:
        return 0.0
    return 1.0 if a == a and b == b else nan


def either(a: Batch, b: Batch) -> Batch:
    """Whether a or b holds; NaN where that hangs on a NaN."""
    if has_nan(a, b):
        return negation(both(negation(a), negation(b)))
    return (np.not_equal(a, 0) | np.not_equal(b, 0)).astype(np.float64)


def either_one(a: float, b: float) -> float:
    """Whether a or b holds; NaN where that hangs on a NaN."""
    if (a != 0 and a == a) or (b != 0 and b == b):
        return 1.0
    return 0.0 if a == 0 and b == 0 else nan


def negation(a: Batch) -> Batch:
    """Whether a does not hold; NaN for NaN."""
    truth = np.equal(a, 0).astype(np.float64)
    return np.where(np.isnan(a), nan, truth) if has_nan(a) else truth


def negation_one(a: float) -> float:
    """Whether a does not hold; NaN for NaN."""
    return float(a == 0) if a == a else nan


def select(condition: Batch, value: Batch, other: Batch) -> Batch:
    """`value` where the condition holds, else `other`; NaN where the condition is."""
    found = np.where(np.not_equal(condition, 0), value, other)
    return np.where(np.isnan(condition), nan, found) if has_nan(condition) else found


def select_one(condition: float, value: float, other: float) -> float:
    """`value` where the condition holds, else `other`; NaN where the condition is."""
    if condition == condition:
        return value if condition != 0 else other
    return nan


def least(*values: Batch) -> Batch:
    """The least of its arguments; NaN if one is."""
    return reduce(np.minimum, values) + 0.0  # + 0.0: the sign of a zero is not left to chance


def least_one(*values: float) -> float:
    """The least of its arguments; NaN if one is."""
    return nan if any(value != value for value in values) else min(values) + 0.0


def greatest(*values: Batch) -> Batch:
    """The greatest of its arguments; NaN if one is."""
    return reduce(np.maximum, values) + 0.0


def greatest_one(*values: float) -> float:
    """The greatest of its arguments; NaN if one is."""
    return nan if any(value != value for value in values) else max(values) + 0.0


def absolute(a: Batch) -> Batch:
    """The distance from 0."""
    return np.abs(a)


def absolute_one(a: float) -> float:
    """The distance from 0."""
    return abs(a)


def sign(a: Batch) -> Batch:
    """-1, 0 or 1."""
    with quiet():
        return np.sign(a) + 0.0


def sign_one(a: float) -> float:
    """-1, 0 or 1."""
    return a if a != a else float((a > 0) - (a < 0))


def clamp(a: Batch, low: Batch, high: Batch) -> Batch:
    """a, or the bound that it passes."""
    return np.minimum(np.maximum(a, low), high) + 0.0


def clamp_one(a: float, low: float, high: float) -> float:
    """a, or the bound that it passes."""
    return least_one(greatest_one(a, low), high)


def lerp(a: Batch, b: Batch, t: Batch) -> Batch:
    """a at t = 0, b at t = 1, on a straight line."""
    with quiet():
        return np.add(a, np.multiply(np.subtract(b, a), t))


def lerp_one(a: float, b: float, t: float) -> float:
    """a at t = 0, b at t = 1, on a straight line."""
    return a + (b - a) * t


def floor(a: Batch) -> Batch:
    """The greatest whole number not above a; 2.9999999999 snapped to 3 first."""
    with quiet():
        near = np.rint(a)
        return np.where(_same(a, near), near, np.floor(a)) + 0.0


def floor_one(a: float) -> float:
    """The greatest whole number not above a; 2.9999999999 snapped to 3 first."""
    if not math.isfinite(a):
        return a
    near = float(round(a))
    return (near if _same_one(a, near) else float(math.floor(a))) + 0.0


def ceil(a: Batch) -> Batch:
    """The least whole number not below a; 3.0000000001 snapped to 3 first."""
    return -floor(np.negative(a)) + 0.0


def ceil_one(a: float) -> float:
    """The least whole number not below a; 3.0000000001 snapped to 3 first."""
    return -floor_one(-a) + 0.0


def nearest_whole(a: Batch) -> Batch:
    """The nearest whole number, halves away from zero."""
    with quiet():
        return np.copysign(floor(np.abs(a) + 0.5), a) + 0.0


def nearest_whole_one(a: float) -> float:
    """The nearest whole number, halves away from zero."""
    return math.copysign(floor_one(abs(a) + 0.5), a) + 0.0


def mod(a: Batch, b: Batch) -> Batch:
    """What a leaves when divided by b, with the sign of b; 0 where a snaps to a multiple of b."""
    with quiet():
        whole = np.multiply(np.rint(np.divide(a, b)), b)
        return np.where(_same(a, whole) & np.isfinite(a), 0.0, np.mod(a, b)) + 0.0


def mod_one(a: float, b: float) -> float:
    """What a leaves when divided by b, with the sign of b; 0 where a snaps to a multiple of b."""
    if b == 0 or not (math.isfinite(a) and b == b):
        return nan
    if math.isinf(b):
        return (a if a == 0 or (a > 0) == (b > 0) else b) + 0.0
    quotient = a / b
    if not math.isfinite(quotient):
        return a % b + 0.0
    return 0.0 if _same_one(a, round(quotient) * b) else a % b + 0.0


def tiles(length: Batch, size: Batch) -> Batch:
    """The n for which length / n is nearest to size, at least 1; 0 where either is 0 or less.

    It drops from n + 1 to n at size = (length / n + length / (n + 1)) / 2.
    """
    with quiet():
        length, size = np.asarray(length, np.float64), np.asarray(size, np.float64)
        least = np.maximum(floor(np.divide(length, size)), 1.0)
        middle = (length / least + length / (least + 1.0)) / 2
        found = least + (np.less(size, middle) & ~_same(size, middle))
        return np.where((length > 0) & (size > 0), found, 0.0 * (length + size))


def tiles_one(length: float, size: float) -> float:
    """The n for which length / n is nearest to size."""
    return float(tiles(np.array(length), np.array(size)))


def root(a: Batch) -> Batch:
    """The square root; NaN below 0."""
    with quiet():
        return np.sqrt(a)


def root_one(a: float) -> float:
    """The square root; NaN below 0."""
    return math.sqrt(a) if a >= 0 else nan


def between(u: Batch, *bounds: Batch) -> Batch:
    """u in [0, 1) stretched to [0, 1), [0, b) or [a, b)."""
    if not bounds:
        return np.asarray(u, dtype=np.float64)
    low, high = (0.0, bounds[0]) if len(bounds) == 1 else bounds
    with quiet():
        return np.add(low, np.multiply(np.subtract(high, low), u))


def between_one(u: float, *bounds: float) -> float:
    """u in [0, 1) stretched to [0, 1), [0, b) or [a, b)."""
    if not bounds:
        return u
    low, high = (0.0, bounds[0]) if len(bounds) == 1 else bounds
    return low + (high - low) * u


def whole_between(u: Batch, low: Batch, high: Batch) -> Batch:
    """A whole number from low to high, both possible; NaN when high is below low."""
    with quiet():
        first, last = ceil(low), floor(high)
        drawn = first + np.floor(u * (last - first + 1.0))
        known = (last >= first) & (last - first < np.inf)
        return np.where(known, np.minimum(drawn, last), nan)


def whole_between_one(u: float, low: float, high: float) -> float:
    """A whole number from low to high, both possible; NaN when high is below low."""
    first, last = ceil_one(low), floor_one(high)
    if not (last >= first and math.isfinite(last - first)):
        return nan
    return min(first + math.floor(u * (last - first + 1.0)), last)


def pick(u: Batch, *values: Batch) -> Batch:
    """One of the values, each as likely as the others."""
    chosen = np.floor(np.multiply(u, len(values))).astype(np.intp)
    columns = np.broadcast_arrays(chosen, *values)
    return np.choose(columns[0], columns[1:]) if len(values) <= 31 else _take(columns)


def _take(columns: tuple[NDArray[np.generic], ...]) -> Batch:
    table = np.stack([np.asarray(column, dtype=np.float64) for column in columns[1:]])
    taken: Batch = np.take_along_axis(table, columns[0].astype(np.intp)[None], axis=0)[0]
    return taken


def pick_one(u: float, *values: float) -> float:
    """One of the values, each as likely as the others."""
    return values[math.floor(u * len(values))]
