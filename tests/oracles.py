"""Slow oracles, obviously right: a program derived shape by shape with a turtle that walks.

In goes a program, out come rows in derivation order. Plain recursion over the IR, a rotation
matrix, one Python number at a time; shares with the executors only the functions' records and the
keys.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ipmlang.compiler import ir
from ipmlang.compiler.ops import FUNCTIONS
from ipmlang.runtime import keys

Key = tuple[int, int]


@dataclass(frozen=True)
class Turtle:
    """A frame and a pen."""

    position: np.ndarray
    rotation: np.ndarray  # 3x3, columns x, y, z
    scale: float = 1.0
    hand: float = 1.0
    layer: float = 0.0
    pen: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Row:
    """One drawn thing."""

    key: int
    symbol: int
    rule: int
    asset: int
    size: tuple[float, ...]
    turtle: Turtle


class Naive:
    """One derivation of a program without context."""

    def __init__(self, program: ir.Program, attrs: Sequence[float], steps: int | None) -> None:
        self.program = program
        self.attrs = attrs
        self.steps = steps
        self.rows: list[Row] = []

    def run(self, seed: int) -> list[Row]:
        """All rows."""
        upright = np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]])
        plain = np.eye(3) if self.program.flat or self.program.abop else upright
        pen = {} if self.program.pen_width is None else {"width": self.program.pen_width}
        turtle = Turtle(np.zeros(3), plain, pen=pen)
        axiom = self.program.axiom
        self.body(axiom.body, -1, keys.root(seed), (), turtle, 0, {}, (), True)
        return self.rows

    def module(
        self,
        symbol: int,
        args: Sequence[float],
        key: Key,
        rule: int,
        turtle: Turtle,
        generation: int | None,
        shown: bool,
    ) -> Turtle:
        """Expand one module; generation None: only its meaning counts."""
        own = self.program.symbols[symbol]
        live = generation is not None and (self.steps is None or generation < self.steps)
        if own.productions and live:
            taken = self.choose(own.productions, args, key)
            if taken is None:
                assert self.steps is not None, "no production applies"
                key = keys.child_single(*key, keys.CHOICE_SITE)
                return self.module(symbol, args, key, -1, turtle, generation + 1, shown)
            body = self.program.productions[taken].body
            return self.body(body, taken, key, args, turtle, generation + 1, {}, (), shown)
        if own.interpretation and generation is not None:
            taken = self.choose(own.interpretation, args, key)
            if taken is not None:
                body = self.program.productions[taken].body
                return self.body(body, taken, key, args, turtle, None, {}, (), shown)
        return self.act(own.meaning or (), symbol, args, key, rule, turtle, shown)

    def body(
        self,
        code: Sequence[ir.Instruction],
        rule: int,
        key: Key,
        params: Sequence[float],
        turtle: Turtle,
        generation: int | None,
        values: dict[int, float],
        copies: tuple[tuple[int, int], ...],
        shown: bool,
    ) -> Turtle:
        """Walk a body."""
        saved: list[Turtle] = []
        numbers = [number for _, number in copies]
        for each in code:
            args = [values[register] for register in each.args]
            if each.op == "open":
                saved.append(turtle)
            elif each.op == "close":
                turtle = saved.pop()
            elif each.op == "module":
                own = keys.child_single(*key, each.site, *numbers)
                turtle = self.module(each.const, args, own, rule, turtle, generation, shown)
            elif each.op == "repeat":
                for copy in range(math.ceil(args[0] - 1e-9)):
                    visible = shown and copy not in args[1:]
                    around = (*copies, (each.const, copy))
                    turtle = self.body(
                        each.body,
                        rule,
                        key,
                        params,
                        turtle,
                        generation,
                        dict(values),
                        around,
                        visible,
                    )
            else:
                values[each.out] = self.value(each, args, params, key, copies)
        return turtle

    def value(
        self,
        each: ir.Instruction,
        args: Sequence[float],
        params: Sequence[float],
        key: Key,
        copies: tuple[tuple[int, int], ...],
    ) -> float:
        """One value instruction."""
        match each.op:
            case "const":
                return float(each.const)
            case "param":
                return params[each.const]
            case "attr":
                return self.attrs[each.const]
            case "index":
                return float(dict(copies)[each.const])
            case "row":
                table, column = each.const
                return self.program.tables[table].rows[int(args[0])][column]
            case "uniform":
                return keys.uniform_single(*key, each.site, *(number for _, number in copies))
            case _:
                return FUNCTIONS[each.const].single(*args)

    def code(self, code: tuple, params: Sequence[float], key: Key) -> float:
        """The value of a guard or a chance."""
        instructions, register = code
        values: dict[int, float] = {}
        for each in instructions:
            args = [values[arg] for arg in each.args]
            values[each.out] = self.value(each, args, params, key, ())
        return values[register]

    def choose(self, numbers: Sequence[int], params: Sequence[float], key: Key) -> int | None:
        """Which production one shape takes, as LANGUAGE.md walks them."""
        drawn = keys.choice_single(*key)
        productions = [(number, self.program.productions[number]) for number in numbers]
        holding = [
            (number, each)
            for number, each in productions
            if each.guard is None or self.code(each.guard, params, key)
        ]
        weights = sum(
            self.code(each.chance[1:], params, key)
            for _, each in holding
            if each.chance and each.chance[0] == "weight"
        )
        total = 0.0
        for number, each in holding:
            if each.chance is None:
                return number
            amount = self.code(each.chance[1:], params, key)
            total += amount / 100 if each.chance[0] == "percent" else amount / weights
            if drawn < total:
                return number
        return None

    def act(
        self,
        code: Sequence[ir.Instruction],
        symbol: int,
        params: Sequence[float],
        key: Key,
        rule: int,
        turtle: Turtle,
        shown: bool,
    ) -> Turtle:
        """What a left-over module does."""
        values: dict[int, float] = {}
        for each in code:
            args = [values[register] for register in each.args]
            if each.op in ir.VALUE_OPS:
                values[each.out] = self.value(each, args, params, key, ())
                continue
            if each.op in ("segment", "emit") and shown:
                size = (args[0], 0.0, 0.0) if each.op == "segment" else (*args, 0.0, 0.0, 0.0)[:3]
                asset = -1 if each.op == "segment" else each.const
                packed = key[0] << 32 | key[1]
                self.rows.append(Row(packed, symbol, rule, asset, size, turtle))
            turtle = step(turtle, each, args)
        return turtle


def step(turtle: Turtle, each: ir.Instruction, args: Sequence[float]) -> Turtle:
    """The turtle after one instruction."""
    match each.op:
        case "move" | "segment":
            local = np.array([*args, 0.0, 0.0, 0.0][:3]) * (turtle.hand, 1, 1) * turtle.scale
            return replace(turtle, position=turtle.position + turtle.rotation @ local)
        case "rotate":
            sign = 1.0 if each.const == "x" else turtle.hand
            return replace(turtle, rotation=turtle.rotation @ about(each.const, sign * args[0]))
        case "orient":
            w, x, y, z = np.array(args) / np.linalg.norm(args)
            turn = quaternion_matrix(w, x, y * turtle.hand, z * turtle.hand)
            return replace(turtle, rotation=turtle.rotation @ turn)
        case "scale":
            return replace(turtle, scale=turtle.scale * args[0])
        case "mirror":
            return replace(turtle, hand=-turtle.hand)
        case "level":
            return levelled(turtle)
        case "layer":
            return replace(turtle, layer=turtle.layer + args[0])
        case "pen":
            pen = {**turtle.pen, each.const[0]: args[0]}
            if each.const[0] == "color":
                pen.pop("fill", None), pen.pop("stroke", None)
            return replace(turtle, pen=pen)
        case _:
            return turtle


def levelled(turtle: Turtle) -> Turtle:
    """Rolled about the heading until the left lies in the plane; the book's $."""
    heading = turtle.rotation[:, 0] * turtle.hand
    left = np.cross((0.0, 0.0, 1.0), heading)
    if np.linalg.norm(left) < 1e-12:
        return turtle
    left = left / np.linalg.norm(left)
    up = np.cross(heading, left)
    columns = (heading * turtle.hand, left * turtle.hand, up)
    rotation = np.stack(columns, axis=1)
    if turtle.hand < 0:
        rotation = np.stack(
            (turtle.rotation[:, 0], -left, np.cross(turtle.rotation[:, 0], -left)), 1
        )
    return replace(turtle, rotation=rotation)


def about(axis: str, degrees: float) -> np.ndarray:
    """A rotation about a local axis."""
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3)
    matrix[first, first] = matrix[second, second] = cosine
    matrix[second, first], matrix[first, second] = sine, -sine
    return matrix


def quaternion_matrix(w: float, x: float, y: float, z: float) -> np.ndarray:
    """The rotation of a unit quaternion."""
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
