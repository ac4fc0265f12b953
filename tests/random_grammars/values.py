"""Random expressions whose values are known to lie in an interval.

In go the names that can be read where an expression stands, with the least and the largest value
each can have; out comes text whose value lies between two bounds, so that nothing divides by zero,
no root is taken of less than nothing and no count explodes. Exact expressions use nothing whose
last bits depend on the machine: guards and counts are made of these alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from random import Random

NUMBERS = (0, 0.2, 0.5, 0.71, 1, 1, 1.13, 1.37, 2, 2, 2.29, 3, 3.17, 5, 7)
COLORS = ("#f00", "#2a6f4e", "teal", "#fa0", "gold")


@dataclass(frozen=True, slots=True)
class Value:
    """A text with the interval of its value; `kind` is number, truth or text."""

    text: str
    low: float = 0.0
    high: float = 1.0
    exact: bool = True
    kind: str = "number"


@dataclass(frozen=True, slots=True)
class Function:
    """A function of the grammar: its parameters take what lies in `taken`."""

    name: str
    arity: int
    result: Value


TAKEN = (0.1, 5.0)
Names = Sequence[Value]


class Values:
    """Expressions from one source of chance. `risk`: how many conditions may hang on NaN."""

    def __init__(self, draw: Random, risk: float = 0.0) -> None:
        self.draw = draw
        self.risk = risk
        self.functions: list[Function] = []

    def number(
        self, low: float, high: float, names: Names = (), exact: bool = False, fixed: bool = False
    ) -> str:
        """An expression between two bounds; a fixed one draws no random number."""
        for _ in range(3):
            found = self._value(names, 0 if self.draw.random() < 0.5 else 1, exact, fixed)
            if low <= found.low and found.high <= high:
                return found.text
            if self.draw.random() < 0.5:
                return f"clamp({found.text}, {_shown(low)}, {_shown(high)})"
        return _shown(round(self.draw.uniform(low, high), self.draw.choice((0, 1, 2))) or high)

    def whole(self, low: int, high: int, names: Names = (), fixed: bool = False) -> str:
        """A whole number from `low` to `high`, exact."""
        draw = self.draw
        kind = draw.random()
        if kind < 0.5:
            return str(draw.randint(low, high))
        if kind < 0.65 and not fixed:
            return f"irand({low}, {high})"
        inner = self._value(names, 1, exact=True, fixed=fixed).text
        rounding = draw.choice(("round", "floor", "ceil"))
        return f"clamp({rounding}({inner}), {low}, {high})"

    def text(self, names: Names, choices: Sequence[str] = COLORS) -> str:
        """A text: a name that stands for one, or one of the choices."""
        known = [each.text for each in names if each.kind == "text"]
        if known and choices is COLORS and self.draw.random() < 0.5:
            return self.draw.choice(known)
        return f'"{self.draw.choice(choices)}"'

    def condition(self, names: Names, depth: int = 0) -> str:
        """A truth value that comes out alike on every machine."""
        draw = self.draw
        if self.risk and draw.random() < self.risk:
            return self.risky(names, depth)
        truths = [each.text for each in names if each.kind == "truth"]
        texts = [each.text for each in names if each.kind == "text"]
        kind = draw.random()
        if kind < 0.15 and depth < 2:
            sides = [self.condition(names, depth + 1) for _ in range(2)]
            return f"({draw.choice((' and ', ' or ')).join(sides)})"
        if kind < 0.22 and depth < 2:
            return f"not ({self.condition(names, depth + 1)})"
        if kind < 0.35 and truths:
            return draw.choice(truths)
        if kind < 0.42 and texts:
            return f'{draw.choice(texts)} {draw.choice(("==", "!="))} "#f00"'
        one = self._value(names, 1, exact=True, fixed=False)
        if draw.random() < 0.6:
            middle = _shown(round(draw.uniform(one.low, one.high), 2))
            return f"{one.text} {draw.choice(('<', '<=', '>', '>='))} {middle}"
        other = self._value(names, 2, exact=True, fixed=False)
        return f"{one.text} {draw.choice(('<', '<=', '>', '>=', '==', '!='))} {other.text}"

    def risky(self, names: Names, depth: int = 0) -> str:
        """A condition that may hang on a number that is none, or only seem to."""
        known = [each for each in names if each.kind == "number" and each.exact]
        one = self.draw.choice([*known, Value("irand(0, 2)", 0, 2)])
        low = _shown(round(self.draw.uniform(one.low, one.high)))
        rest = f"({one.text} - {low})"
        none = self.draw.choice((f"sqrt{rest}", f"mod(1, {rest})", f"{rest} / {rest}"))
        asked = f"{none} {self.draw.choice(('<', '<=', '>', '>=', '==', '!='))} 0.9"
        other = self.condition(names, 2) if depth < 2 else "true"
        return self.draw.choice((
            asked, f"not ({asked})", f"({rest} > 0 and {asked})", f"({rest} <= 0 or {asked})",
            f"({other} and {asked})", f"({asked} or {other})",
            f"(if {asked} then {other} else true)",
        ))  # fmt: skip

    # ------------------------------------------------------------------------- parts

    def _value(self, names: Names, depth: int, exact: bool, fixed: bool) -> Value:
        draw = self.draw
        known = [each for each in names if each.kind == "number" and (each.exact or not exact)]
        kind = draw.random()
        if known and kind < 0.45:
            return draw.choice(known)
        if depth >= 2 or kind < 0.6:
            number = draw.choice(NUMBERS)
            return Value(_shown(number), number, number)
        if kind < 0.72 and not fixed:
            return self._drawn(exact)
        makers: list[Callable[[Value, Value], Value]] = [
            self._arithmetic, self._arithmetic, self._piecewise, self._rounded,
        ]  # fmt: skip
        if not exact:
            makers.append(self._inexact)
        if self.functions:
            makers.append(self._called)
        sides = [self._value(names, depth + 1, exact, fixed) for _ in range(2)]
        maker = draw.choice(makers)
        made = self._chosen(names, *sides) if draw.random() < 0.08 else maker(*sides)
        made = replace(made, exact=made.exact and all(each.exact for each in sides))
        return made if made.exact or not exact else sides[0]

    def _drawn(self, exact: bool) -> Value:
        draw = self.draw
        low, high = sorted((draw.choice(NUMBERS), draw.choice(NUMBERS)))
        match draw.randrange(4 if exact else 5):
            case 0:
                return Value("rand()", 0, 1)
            case 1:
                return Value(f"rand({_shown(low)}, {_shown(high)})", low, high)
            case 2:
                return Value(f"irand({int(low)}, {int(high) + 1})", int(low), int(high) + 1)
            case 3:
                return Value(f"pick({_shown(low)}, {_shown(high)}, 1.9)", min(low, 1.9),
                             max(high, 1.9))  # fmt: skip
            case _:
                return Value(f"gauss({_shown(high)}, 0.1)", high - 1, high + 1, exact=False)

    def _arithmetic(self, one: Value, other: Value) -> Value:
        op = self.draw.choice("+-*/")
        if op == "/" and other.low <= 0.1:
            op = "*"
        ends = [_apply(op, a, b) for a in (one.low, one.high) for b in (other.low, other.high)]
        return Value(f"({one.text} {op} {other.text})", min(ends), max(ends))

    def _piecewise(self, one: Value, other: Value) -> Value:
        low, high = min(one.low, other.low), max(one.high, other.high)
        match self.draw.randrange(5):
            case 0:
                return Value(f"min({one.text}, {other.text})", low, min(one.high, other.high))
            case 1:
                return Value(f"max({one.text}, {other.text})", max(one.low, other.low), high)
            case 2:
                return Value(f"lerp({one.text}, {other.text}, 0.3)", low, high)
            case 3:
                return Value(f"clamp({one.text}, 0.2, 2.7)", 0.2, 2.7)
            case _:
                far = max(abs(one.low), abs(one.high))
                return Value(f"abs({one.text})", 0, far)

    def _rounded(self, one: Value, other: Value) -> Value:
        low, high = math.floor(one.low), math.ceil(one.high)
        match self.draw.randrange(5):
            case 0:
                return Value(f"{self.draw.choice(('floor', 'ceil', 'round'))}({one.text})",
                             low, high)  # fmt: skip
            case 1 if other.low > 0.1:
                return Value(f"mod({one.text}, {other.text})", 0, other.high)
            case 2 if other.low > 0.1 and one.low >= 0:
                most = math.ceil(one.high / other.low) + 1
                return Value(f"tiles({one.text}, {other.text})", 0, most)
            case 3 if one.low >= 0:
                return Value(f"sqrt({one.text})", 0, max(1.0, one.high))
            case _:
                return Value(f"sign({one.text})", -1, 1)

    def _inexact(self, one: Value, other: Value) -> Value:
        match self.draw.randrange(6):
            case 0:
                turn = self.draw.choice(("sin", "cos"))
                return Value(f"{turn}(37 * {one.text})", -1, 1, exact=False)
            case 1:
                return Value(f"atan2({one.text}, {other.text} + 9.3)", -180, 180, exact=False)
            case 2 if one.low >= 0 and one.high < 50:
                return Value(f"pow({one.text} + 0.3, 0.7)", 0, 20, exact=False)
            case 3 if one.high < 20:
                return Value(f"exp(-abs({one.text}))", 0, 1, exact=False)
            case 4 if one.low >= 0 and one.high < 1000:
                return Value(f"log({one.text} + 1)", 0, 7, exact=False)
            case _:
                return Value(f"noise({one.text}, {other.text})", -1, 1, exact=False)

    def _called(self, one: Value, other: Value) -> Value:
        function = self.draw.choice(self.functions)
        given = [_within(each) for each in (one, other)][: function.arity]
        return replace(function.result, text=f"{function.name}({', '.join(given)})")

    def _chosen(self, names: Names, one: Value, other: Value) -> Value:
        condition = self.condition(names, 2)
        return Value(
            f"(if {condition} then {one.text} else {other.text})",
            min(one.low, other.low),
            max(one.high, other.high),
        )


def _within(value: Value) -> str:
    low, high = TAKEN
    if low <= value.low and value.high <= high:
        return value.text
    return f"clamp({value.text}, {low}, {high})"


def _apply(op: str, one: float, other: float) -> float:
    match op:
        case "+":
            return one + other
        case "-":
            return one - other
        case "*":
            return one * other
        case _:
            return one / other


def _shown(number: float) -> str:
    text = f"{number:g}"
    return text if number >= 0 else f"({text})"
