"""The functions of expressions: one record each, operators included, and the constants.

An operator is the function named in `OPERATORS`. The bodies stand in `exact.py` and `inexact.py`;
nothing here computes. Random functions take the uniform of their call site as a hidden first
argument of their bodies.
"""

from __future__ import annotations

from collections.abc import Callable

from ipmlang.compiler.ops import exact, inexact
from ipmlang.compiler.ops.record import Function, Param, ValueType

OPERATORS = {
    "+": "add",
    "-": "sub",
    "*": "mul",
    "/": "div",
    "<": "lt",
    "<=": "le",
    ">": "gt",
    ">=": "ge",
    "==": "eq",
    "!=": "ne",
    "and": "and",
    "or": "or",
}
PREFIXES = {"-": "neg", "not": "not"}
CONSTANTS = {"pi": (3.141592653589793, "Half the circumference of the unit circle.")}

_A_B = (Param("a"), Param("b"))
_ANY_TWO = (Param("a", "any"), Param("b", "any"))
_TRUTHS = (Param("a", "bool"), Param("b", "bool"))
_ONE = (Param("a"),)


def _operator(
    name: str,
    sign: str,
    doc: str,
    batch: Callable[..., exact.Batch],
    single: Callable[..., float],
    params: tuple[Param, ...] = _A_B,
    result: ValueType = "number",
) -> Function:
    left, right = ("true", "false") if result == "bool" and params == _TRUTHS else ("2", "3")
    examples = (f"{left} {sign} {right}",)
    refused = () if params == _ANY_TWO else (f'{left} {sign} "a"',)
    return Function(name, doc, params, result, batch, single, examples=examples, refused=refused)


ARITHMETIC = (
    _operator("add", "+", "The sum.", exact.add, exact.add_one),
    _operator("sub", "-", "The difference.", exact.sub, exact.sub_one),
    _operator("mul", "*", "The product.", exact.mul, exact.mul_one),
    _operator("div", "/", "The quotient.", exact.div, exact.div_one),
    Function("neg", "The negative.", _ONE, "number", exact.neg, exact.neg_one,
             examples=("-3",), refused=('-"a"',)),
)  # fmt: skip

COMPARISON = (
    _operator("lt", "<", "Less, snapped.", exact.lt, exact.lt_one, result="bool"),
    _operator("le", "<=", "Less or equal, snapped.", exact.le, exact.le_one, result="bool"),
    _operator("gt", ">", "Greater, snapped.", exact.gt, exact.gt_one, result="bool"),
    _operator("ge", ">=", "Greater or equal, snapped.", exact.ge, exact.ge_one, result="bool"),
    _operator("eq", "==", "Equal, snapped: numbers within 1e-9 of the larger one.",
              exact.eq, exact.eq_one, _ANY_TWO, "bool"),
    _operator("ne", "!=", "Not equal, snapped.", exact.ne, exact.ne_one, _ANY_TWO, "bool"),
    _operator("and", "and", "Both hold; false and anything is false.",
              exact.both, exact.both_one, _TRUTHS, "bool"),
    _operator("or", "or", "One holds, or both; true or anything is true.",
              exact.either, exact.either_one, _TRUTHS, "bool"),
    Function("not", "It does not hold.", (Param("a", "bool"),), "bool",
             exact.negation, exact.negation_one, examples=("not true",), refused=("not 3",)),
    Function("select", "`if condition then value else other` is this function.",
             (Param("condition", "bool"), Param("value", "any"), Param("other", "any")), "any",
             exact.select, exact.select_one,
             examples=("if 2 > 1 then 3 else 4", "select(true, 1, 2)"),
             refused=("if 1 then 2 else 3", 'if true then 1 else "a"')),
)  # fmt: skip


def _rounding(
    name: str, doc: str, batch: Callable[..., exact.Batch], single: Callable[..., float]
) -> Function:
    return Function(name, doc, _ONE, "int", batch, single,
                    examples=(f"{name}(2.5)",), refused=(f"{name}()", f'{name}("2")'))  # fmt: skip


NUMBERS = (
    Function("min", "The least of its arguments.", (*_A_B, Param("more", many=True)), "number",
             exact.least, exact.least_one, passing="pairs",
             examples=("min(1, 2)", "min(1, 2, 3)"), refused=("min(1)", 'min(1, "2")')),
    Function("max", "The greatest of its arguments.", (*_A_B, Param("more", many=True)), "number",
             exact.greatest, exact.greatest_one, passing="pairs",
             examples=("max(1, 2)", "max(1, 2, 3)"), refused=("max()", 'max(1, "2")')),
    Function("abs", "The distance from 0.", _ONE, "number", exact.absolute, exact.absolute_one,
             examples=("abs(-2)",), refused=("abs(1, 2)",)),
    Function("sign", "-1, 0 or 1.", _ONE, "int", exact.sign, exact.sign_one,
             examples=("sign(-2)",), refused=("sign()",)),
    _rounding("floor", "The greatest whole number not above it; floor(9.6 / 3.2) is 3, snapped.",
              exact.floor, exact.floor_one),
    _rounding("ceil", "The least whole number not below it, snapped.", exact.ceil, exact.ceil_one),
    _rounding("round", "The nearest whole number, halves away from zero.",
              exact.nearest_whole, exact.nearest_whole_one),
    Function("mod", "What a leaves when divided by b, with b's sign; 0 where a snaps to a "
                    "multiple.",
             _A_B, "number", exact.mod, exact.mod_one,
             examples=("mod(7, 3)",), refused=("mod(7)",)),
    Function("clamp", "`a`, or the bound that it passes.",
             (Param("a"), Param("low"), Param("high")), "number", exact.clamp, exact.clamp_one,
             examples=("clamp(7, 0, 5)",), refused=("clamp(7, 0)",)),
    Function("lerp", "`a` at t = 0, `b` at t = 1, on a straight line.",
             (*_A_B, Param("t")), "number", exact.lerp, exact.lerp_one,
             examples=("lerp(0, 10, 0.5)",), refused=("lerp(0, 10)",)),
    Function("tiles", "How many tiles of about `size` fill `length`: the n for which length / n is "
                      "nearest to it, at least 1; 0 where nothing is to fill.",
             (Param("length"), Param("size")), "int", exact.tiles, exact.tiles_one,
             examples=("tiles(8, 3)",), refused=("tiles(8)",)),
    Function("sqrt", "The square root.", _ONE, "number", exact.root, exact.root_one,
             examples=("sqrt(2)",), refused=("sqrt()",)),
)  # fmt: skip


def _inexact(
    name: str, doc: str, batch: Callable[..., exact.Batch], params: tuple[Param, ...] = _ONE
) -> Function:
    arguments = ", ".join("0.5" for _ in params)
    return Function(name, doc, params, "number", batch, inexact.one(batch), exact=False,
                    examples=(f"{name}({arguments})",), refused=(f"{name}()",))  # fmt: skip


INEXACT = (
    _inexact("sin", "The sine of an angle in degrees.", inexact.sine),
    _inexact("cos", "The cosine of an angle in degrees.", inexact.cosine),
    _inexact("tan", "The tangent of an angle in degrees.", inexact.tangent),
    _inexact("asin", "The angle, in degrees, whose sine it is.", inexact.arc_sine),
    _inexact("acos", "The angle, in degrees, whose cosine it is.", inexact.arc_cosine),
    _inexact("atan", "The angle, in degrees, whose tangent it is.", inexact.arc_tangent),
    _inexact("atan2", "The angle, in degrees, of the point (x, y).", inexact.direction,
             (Param("y"), Param("x"))),
    _inexact("pow", "`a` to the power of `b`.", inexact.power, _A_B),
    _inexact("exp", "e to the power of `a`.", inexact.exponential),
    _inexact("log", "The natural logarithm.", inexact.logarithm),
    Function("noise", "Smooth noise from -1 to 1 over the line, the plane or space; always the "
                      "same.",
             (Param("x"), Param("y", optional=True), Param("z", optional=True)), "number",
             inexact.noise, inexact.one(inexact.noise), exact=False, passing="zeros",
             examples=("noise(0.3)", "noise(0.3, 1.2)"), refused=("noise()",)),
)  # fmt: skip

RANDOM = (
    Function("rand", "A random number from 0 to 1, from 0 to `a`, or from `a` to `b`.",
             (Param("a", optional=True), Param("b", optional=True)), "number",
             exact.between, exact.between_one, random=True, passing="range",
             examples=("rand()", "rand(5)", "rand(-5, 5)"), refused=('rand("a")', "rand(1, 2, 3)")),
    Function("irand", "A random whole number from `low` to `high`, both possible.",
             (Param("low"), Param("high")), "int",
             exact.whole_between, exact.whole_between_one, random=True,
             examples=("irand(1, 6)",), refused=("irand(6)",)),
    Function("pick", "One of its arguments, each as likely as the others.",
             (Param("value", "any"), Param("more", "any", many=True)), "any",
             exact.pick, exact.pick_one, random=True, passing="choice",
             examples=("pick(1, 2, 3)", 'pick("a", "b") == "a"'), refused=("pick()",)),
    Function("gauss", "A normally distributed random number.",
             (Param("mean"), Param("deviation")), "number",
             inexact.normal, inexact.one(inexact.normal), exact=False, random=True,
             examples=("gauss(0, 1)",), refused=("gauss(0)",)),
)  # fmt: skip

TABLE = ARITHMETIC + COMPARISON + NUMBERS + INEXACT + RANDOM
