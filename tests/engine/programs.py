"""Programs for tests, built by hand from the oracle's plain data: no parser, no lowering."""

from __future__ import annotations

from ipmlang.compiler import ir
from tests import oracle_strings as oracle

Code = tuple[tuple[ir.Instruction, ...], int]


class _Writer:
    """Instructions of one production, and the next free register and site."""

    def __init__(self) -> None:
        self.register = 0
        self.site = 0

    def value(self, expr: oracle.Expr, out: list[ir.Instruction]) -> int:
        args: tuple[int, ...] = ()
        if not isinstance(expr, tuple):
            op, const, site = "const", float(expr), -1
        elif expr[0] == "p":
            op, const, site = "param", expr[1], -1
        elif expr[0] == "index":
            op, const, site = "index", expr[1], -1
        elif expr[0] == "uniform":
            op, const, site = "uniform", None, expr[1]
        else:
            args = tuple(self.value(each, out) for each in expr[1:])
            op, const, site = "call", expr[0], -1
        self.register += 1
        out.append(ir.Instruction(op, self.register, args, const, site))
        return self.register

    def code(self, expr: oracle.Expr) -> Code:
        out: list[ir.Instruction] = []
        register = self.value(expr, out)
        return tuple(out), register

    def body(
        self, elements: list[oracle.Element], number: dict[str, int]
    ) -> tuple[ir.Instruction, ...]:
        out: list[ir.Instruction] = []
        for element in elements:
            match element[0]:
                case "[":
                    out.append(ir.Instruction("open"))
                case "]":
                    out.append(ir.Instruction("close"))
                case "repeat":
                    _, repeat, count, inner, holes = element
                    args = tuple(self.value(each, out) for each in (count, *holes))
                    body = self.body(inner, number)
                    out.append(ir.Instruction("repeat", -1, args, repeat, body=body))
                case name:
                    args = tuple(self.value(each, out) for each in element[1:])
                    out.append(ir.Instruction("module", -1, args, number[name], self.site))
                    self.site += 1
        return tuple(out)


def _do(op: str, *args: float | int, const: object = None) -> tuple[ir.Instruction, ...]:
    """A meaning: one instruction on parameters ("p0" is the first) or numbers."""
    code: list[ir.Instruction] = []
    for register, value in enumerate(args):
        if isinstance(value, int):
            code.append(ir.Instruction("param", register, const=value))
        else:
            code.append(ir.Instruction("const", register, const=value))
    return (*code, ir.Instruction(op, args=tuple(range(len(args))), const=const))


def _negative(axis: str) -> tuple[ir.Instruction, ...]:
    return (
        ir.Instruction("param", 0, const=0),
        ir.Instruction("call", 1, (0,), "neg"),
        ir.Instruction("rotate", args=(1,), const=axis),
    )


MEANINGS: dict[str, tuple[ir.Instruction, ...]] = {
    "F": _do("segment", 0),
    "f": _do("move", 0, 0.0, 0.0),
    "+": _do("rotate", 0, const="z"),
    "-": _negative("z"),
    "&": _do("rotate", 0, const="y"),
    "^": _negative("y"),
    "\\": _negative("x"),
    "/": _do("rotate", 0, const="x"),
    "at": _do("move", 0, 1, 0.0),
    "*": _do("scale", 0),
    "mirror": _do("mirror"),
    "$": _do("level"),
    "!": _do("pen", 0, const=("width", None)),
    "layer": _do("layer", 0),
    "{": _do("polygon_open"),
    "}": _do("polygon_close"),
    "path{": _do("path_open"),
    "}path": _do("path_close"),
    "vertex": _do("vertex"),
    "cut": _do("cut"),
    "asset": _do("emit", const=-1),
}


def program(system: oracle.System, **fields: object) -> ir.Program:
    """The IR of a system of the oracle."""
    names = list(system.arity)
    number = {name: i for i, name in enumerate(names)}
    productions = [_production(rule, number, system) for rule in system.rules]
    symbols = []
    for name in names:
        own = [i for i, rule in enumerate(system.rules) if rule.head == name]
        symbols.append(
            ir.Symbol(
                name,
                system.arity[name],
                tuple(i for i in own if not system.rules[i].interpret),
                tuple(i for i in own if system.rules[i].interpret),
                MEANINGS.get(name),
                8,
                True,
            )
        )
    writer = _Writer()
    axiom = ir.Production(-1, writer.body(system.axiom, number), writer.register + 1)
    steps = None if system.steps is None else _Writer().code(system.steps)
    return ir.Program(
        tuple(symbols),
        tuple(productions),
        axiom,
        steps=steps,
        threaded=True,
        flat=system.planar,
        tropism=system.tropism,
        ignore=frozenset(number[name] for name in system.ignore),
        **fields,  # type: ignore[arg-type]
    )


def _production(rule: oracle.Rule, number: dict[str, int], system: oracle.System) -> ir.Production:
    writer = _Writer()
    guard = None if rule.guard is None else writer.code(rule.guard)
    chance = None
    if rule.chance is not None:
        code, register = writer.code(rule.chance[1])
        chance = (rule.chance[0], code, register)
    return ir.Production(
        number[rule.head],
        writer.body(rule.body, number),
        writer.register + 1,
        guard=guard,
        chance=chance,  # type: ignore[arg-type]
        left=_patterns(rule.left, number, system),
        right=_patterns(rule.right, number, system),
        path="test.ipm",
        line=1,
    )


def _patterns(names: list, number: dict[str, int], system: oracle.System) -> tuple[ir.Pattern, ...]:
    return tuple(
        ir.Pattern(-1, branch=_patterns(name, number, system))
        if isinstance(name, list)
        else ir.Pattern(
            -1 if name == "*" else number[name], 0 if name == "*" else system.arity[name]
        )
        for name in names
    )
