"""Split grammars derived shape by shape: slow, recursive, plain numbers and 4x4 matrices.

In goes the syntax tree of a grammar, out come its terminals in derivation order: symbol, key, frame
as a matrix, size. Written from what the language means, over trees: the engine's IR, its arithmetic
on columns and its order of work are not used. Only the hash of keys is shared. Shapes are boxes and
rectangles that fill their scopes; what the tests' generator does not write is not here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ipmlang.compiler import ast
from ipmlang.runtime import keys
from tests.engine.scope_numbers import (
    AXES,
    FUNCTIONS,
    OPERATORS,
    Matrix,
    faces,
    moved,
    turned,
    whole,
    with_axes,
)
from tests.engine.scope_sites import Sites
from tests.engine.split_oracle import Group, Part, pieces

Key = tuple[int, int]
GUARDS, CHANCES, STAYING = 0x10000000, 0x20000000, keys.CHOICE_SITE


@dataclass(frozen=True)
class Shape:
    """Where a body is: the scope, the scope it began with, which piece of its split it is, the
    values of attributes, and how far it has moved and turned since a copy began.
    """

    frame: Matrix
    size: tuple[float, float, float]
    base: tuple[Matrix, tuple[float, float, float]]
    piece: tuple[float, float]
    values: dict[str, float]
    walked: Matrix = field(default_factory=lambda: np.eye(4))


@dataclass(frozen=True)
class Drawn:
    """A terminal."""

    symbol: str
    key: int
    frame: Matrix
    size: tuple[float, float, float]


@dataclass(frozen=True)
class Place:
    """What stays the same in one body: its rule's sites, its key, the generation of its children;
    and what changes with copies.
    """

    sites: dict[int, int]
    key: Key
    generation: int
    names: dict[str, float]
    copies: tuple[int, ...] = ()


class NoProductionError(Exception):
    """No production applies."""


def selects(label: ast.Expr | None, words: set[str], number: int) -> bool:
    """Whether a part's label takes a face."""
    match label:
        case ast.Name(word) | ast.Text(word):
            return word in words
        case ast.Number(value):
            return value == number
        case ast.Unary("not", inner):
            return not selects(inner, words, number)
        case ast.Binary("and", left, right):
            return selects(left, words, number) and selects(right, words, number)
        case ast.Binary("or", left, right):
            return selects(left, words, number) or selects(right, words, number)
        case _:
            raise AssertionError(label)


# ------------------------------------------------------------------------- derivation


class Oracle:
    """One derivation of a grammar."""

    def __init__(self, grammar: ast.Grammar, seed: int) -> None:
        self.rules: dict[tuple[str, int], list[ast.Rule]] = {}
        self.values: dict[str, float] = {}
        self.sites: dict[int, dict[int, int]] = {}
        self.drawn: list[Drawn] = []
        for item in grammar.items:
            match item:
                case ast.Rule():
                    name = (item.head.name, len(item.head.parameters))
                    self.rules.setdefault(name, []).append(item)
                case ast.Attr():
                    assert isinstance(item.default, ast.Number)
                    self.values[item.name] = item.default.value
                case ast.Start():
                    self.start = item
        self.steps: int | None = None
        if isinstance(self.start.steps, ast.Number):
            self.steps = int(self.start.steps.value)
        self.seed = seed

    def run(self) -> list[Drawn]:
        """All terminals."""
        assert self.start.place is not None and self.start.place.kind == "box"
        x, y, z = (self.plain(each) for each in self.start.place.args)
        frame, size = np.eye(4), (x, y, z)
        shape = Shape(frame, size, (frame, size), (0.0, 1.0), self.values)
        place = Place(self.sites_of(self.start), keys.root(self.seed), 0, {})
        self.body(self.start.axiom, shape, place)
        return self.drawn

    def plain(self, expr: ast.Expr) -> float:
        assert isinstance(expr, ast.Number)
        return expr.value

    def sites_of(self, item: ast.Rule | ast.Start) -> dict[int, int]:
        """The sites of a rule's guard, chance and body."""
        if id(item) not in self.sites:
            found: dict[int, int] = {}
            if isinstance(item, ast.Rule):
                for first, expr in (
                    (GUARDS, item.guard),
                    (CHANCES, item.chance.value if item.chance else None),
                ):
                    if expr is not None and not isinstance(expr, ast.Otherwise):
                        own = Sites(first)
                        own.value(expr)
                        found.update(own.found)
            body = Sites()
            body.body(item.body if isinstance(item, ast.Rule) else item.axiom)
            self.sites[id(item)] = {**found, **body.found}
        return self.sites[id(item)]

    # ------------------------------------------------------------------------ shapes

    def shape(self, name: str, args: list[float], key: Key, shape: Shape, generation: int) -> None:
        """Rewrite one shape, or draw it."""
        own = self.rules.get((name, len(args)))
        if own is None:
            self.drawn.append(Drawn(name, key[0] << 32 | key[1], shape.frame, shape.size))
            return
        if self.steps is not None and generation >= self.steps:
            return  # it has rules, but no meaning
        rule = self.choose(own, args, key, shape)
        if rule is None:
            if self.steps is None:
                raise NoProductionError(name)
            self.shape(name, args, keys.child_single(*key, STAYING), shape, generation + 1)
            return
        names = dict(zip((each.name for each in rule.head.parameters), args, strict=True))
        place = Place(self.sites_of(rule), key, generation + 1, names)
        self.body(rule.body, replace(shape, base=(shape.frame, shape.size)), place)

    def choose(
        self, rules: list[ast.Rule], args: list[float], key: Key, shape: Shape
    ) -> ast.Rule | None:
        """Which rule a shape takes."""
        holding = []
        for rule in rules:
            names = dict(zip((each.name for each in rule.head.parameters), args, strict=True))
            place = Place(self.sites_of(rule), key, 0, names)
            guard = rule.guard
            if guard is None or isinstance(guard, ast.Otherwise) or self.value(guard, shape, place):
                chance = rule.chance and self.value(rule.chance.value, shape, place)
                holding.append((rule, chance))
        weights = sum(
            chance or 0.0
            for rule, chance in holding
            if rule.chance and rule.chance.kind == "weight"
        )
        drawn, total = keys.choice_single(*key), 0.0
        for rule, chance in holding:
            if rule.chance is None:
                return rule
            assert chance is not None
            total += chance / (100 if rule.chance.kind == "percent" else weights)
            if drawn < total:
                return rule
        return None

    # ------------------------------------------------------------------------- bodies

    def body(self, elements: Sequence[ast.Element], shape: Shape, place: Place) -> Shape:
        """Walk a body; the shape after it."""
        values = shape.values
        for each in elements:
            match each:
                case ast.Module():
                    shape = self.module(each, shape, place)
                case ast.Bracket():
                    self.body(each.body, shape, place)
                case ast.Assign():
                    value = self.value(each.value, shape, place)
                    shape = replace(shape, values={**shape.values, each.name: value})
                case ast.Local():
                    value = self.value(each.value, shape, place)
                    place = replace(place, names={**place.names, each.name: value})
                case ast.Repeat():
                    shape = self.repeat(each, shape, place)
                case ast.Split():
                    self.split(each, shape, place)
                case ast.Block():
                    self.comp(each, shape, place)
                case _:
                    raise AssertionError(each)
        return replace(shape, values=values)

    def module(self, module: ast.Module, shape: Shape, place: Place) -> Shape:
        args = [
            0.0 if _is_word(each.value) else self.value(each.value, shape, place)
            for each in module.args
        ]
        words = [each.value.id for each in module.args if isinstance(each.value, ast.Name)]
        match module.name:
            case "nil":
                return shape
            case "translate":
                return stepped(shape, moved(np.eye(4), *args))
            case "rotate":
                turn = np.eye(4)
                for axis, angle in zip("xyz", args, strict=True):
                    turn = turned(turn, axis, angle)
                return stepped(shape, turn)
            case "size":
                return replace(shape, size=(args[0], args[1], args[2]))
            case "center":
                return replace(shape, frame=centered(shape, words[0]))
            case "mirrorScope":
                axis = AXES[words[0]]
                flip, step = np.eye(4), [0.0, 0.0, 0.0]
                flip[axis, axis], step[axis] = -1.0, shape.size[axis]
                return replace(shape, frame=moved(shape.frame, *step) @ flip)
        site = place.sites[id(module)]
        key = keys.child_single(*place.key, site, *place.copies)
        self.shape(module.name, args, key, shape, place.generation)
        return shape

    def repeat(self, repeat: ast.Repeat, shape: Shape, place: Place) -> Shape:
        """Copies one after the other: where one moves to, the next begins. Its size and what it
        makes of its geometry are its own.
        """
        assert isinstance(repeat.head, ast.Count)
        count = whole(self.value(repeat.head.limit, shape, place), math.ceil)
        holes = {self.value(each, shape, place) for each in repeat.holes}
        for copy in range(max(int(count), 0)):
            names = {**place.names, repeat.head.variable: float(copy)}
            own = replace(place, names=names, copies=(*place.copies, copy))
            before = len(self.drawn)
            after = self.body(repeat.body, replace(shape, walked=np.eye(4)), own)
            if copy in holes:
                del self.drawn[before:]
            if repeat.steps and copy < len(repeat.steps):
                step = self.plain(repeat.steps[copy])
                after = stepped(after, moved(np.eye(4), step, 0.0, 0.0))
            shape = stepped(shape, after.walked)
        return shape

    def split(self, split: ast.Split, shape: Shape, place: Place) -> None:
        axis = AXES[split.axis]
        length = shape.size[axis]

        def known(parts: Sequence[ast.SplitPart | ast.SplitGroup]) -> list[Part | Group]:
            return [
                Part(each.size.kind, max(self.value(each.size.value, shape, place), 0.0), each)
                if isinstance(each, ast.SplitPart)
                else Group(known(each.parts), each.mode)
                for each in parts
            ]

        found = pieces(known(split.parts), length)
        for number, (part, copies, low, size) in enumerate(found):
            assert isinstance(part.source, ast.SplitPart)
            step, own_size = [0.0, 0.0, 0.0], list(shape.size)
            step[axis], own_size[axis] = low, size
            frame = moved(shape.frame, *step)
            sized = (own_size[0], own_size[1], own_size[2])
            own = replace(
                shape,
                frame=frame,
                size=sized,
                base=(frame, sized),
                piece=(float(number), float(len(found))),
            )
            self.body(part.source.body, own, replace(place, copies=(*place.copies, *copies)))

    def comp(self, block: ast.Block, shape: Shape, place: Place) -> None:
        free = list(enumerate(faces(shape.size)))
        for part in block.parts:
            taken = [each for each in free if selects(part.label, each[1][0], each[0])]
            free = [each for each in free if not selects(part.label, each[1][0], each[0])]
            for copy, (_, (_, corner, axes, size)) in enumerate(taken):
                frame = with_axes(shape.frame, corner, axes)
                sized = (size[0], size[1], size[2])
                own = replace(
                    shape,
                    frame=frame,
                    size=sized,
                    base=(frame, sized),
                    piece=(float(copy), float(len(taken))),
                )
                self.body(part.body, own, replace(place, copies=(*place.copies, copy)))

    # ------------------------------------------------------------------------- values

    def value(self, expr: ast.Expr, shape: Shape, place: Place) -> float:
        """The number of an expression."""
        match expr:
            case ast.Number():
                return expr.value
            case ast.Name(name):
                return self.named(name, shape, place)
            case ast.Unary(op, inner):
                found = self.value(inner, shape, place)
                return -found if op == "-" else float(not found)
            case ast.Binary(op, left, right):
                return OPERATORS[op](
                    self.value(left, shape, place), self.value(right, shape, place)
                )
            case ast.If(condition, value, other):
                chosen = value if self.value(condition, shape, place) else other
                return self.value(chosen, shape, place)
            case ast.Call(name, args):
                given = [self.value(each.value, shape, place) for each in args]
                if name in FUNCTIONS:
                    return float(FUNCTIONS[name](*given))
                site = place.sites[id(expr)]
                return drawn(name, keys.uniform_single(*place.key, site, *place.copies), given)
            case _:
                raise AssertionError(expr)

    def named(self, name: str, shape: Shape, place: Place) -> float:
        if name in place.names:
            return place.names[name]
        first, _, last = name.partition(".")
        if first == "scope":
            if last in AXES:
                return float(shape.frame[AXES[last], 3])
            return shape.size[AXES[last[1:]]]
        if first == "split":
            return shape.piece[0 if last == "index" else 1]
        return shape.values[name]


def drawn(name: str, u: float, given: list[float]) -> float:
    """What a random function makes of a draw."""
    if name == "irand":
        low, high = given
        return low + math.floor(u * (high - low + 1))
    if name == "pick":
        return given[int(u * len(given))]
    low, high = {0: (0.0, 1.0), 1: (0.0, *given[:1]), 2: tuple(given)}[len(given)]
    return low + u * (high - low)


def stepped(shape: Shape, step: Matrix) -> Shape:
    """The shape after a motion in its own frame."""
    return replace(shape, frame=shape.frame @ step, walked=shape.walked @ step)


def centered(shape: Shape, axes: str) -> Matrix:
    """The frame that puts the middle of a scope at that of the scope its body began with."""
    frame, size = shape.base
    target = moved(frame, *(each / 2 for each in size))[:, 3]
    own = moved(shape.frame, *(each / 2 for each in shape.size))[:, 3]
    apart = np.linalg.inv(shape.frame[:3, :3]) @ (target - own)[:3]
    return moved(
        shape.frame, *(by if axis in axes else 0.0 for axis, by in zip("xyz", apart, strict=True))
    )


def _is_word(expr: ast.Expr) -> bool:
    return isinstance(expr, ast.Name) and expr.id in ("x", "y", "z", "xy", "xz", "yz", "xyz")
