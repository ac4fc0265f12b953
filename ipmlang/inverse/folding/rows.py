"""The elements of a body as rows: what stands there, apart from the numbers that say where.

Reads printed elements into rows and prints rows again, with expressions in the place of numbers
where somebody has them. Counts tokens as `compiler.tokens` does. Nothing here compares or searches.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from ipmlang.compiler import ast
from ipmlang.compiler.ops import OPERATIONS
from ipmlang.inverse.lsystem.frames import Frames
from ipmlang.inverse.moves import call

STILL = (0.0, 0.0, 0.0, 1.0)  # x, y, angle and scale of what is not moved
TURTLE = ("+", "-", "*")  # what leads to a place without `at`
LABELS = ("x", "y", "angle", "scale")

Frame: TypeAlias = "tuple[float, float, float, float]"
Kind: TypeAlias = "tuple[object, ...]"
Words: TypeAlias = "tuple[int, float | None]"  # tokens of an expression, and its value if it is one


@dataclass(frozen=True, eq=False)
class Row:
    """One element: `[at(x, y, angle, scale) mirror effect("…") A(args)]`.

    frame: units, degrees, factor; pens: operations with no number in them; name, args: the symbol,
    "" for a bracket of rows; symbols: those that it is given, before its args; inner: these; other:
    an element that is taken as it is; origin: the rule that it stood in before that was written
    out.
    """

    frame: Frame = STILL
    hand: int = 1
    pens: tuple[ast.Module, ...] = ()
    name: str = ""
    args: tuple[float, ...] = ()
    inner: tuple[Row, ...] = ()
    other: ast.Element | None = None
    origin: str = ""
    symbols: tuple[str, ...] = ()

    @cached_property
    def kind(self) -> Kind:
        """What it is without its numbers; rows of one kind can be one row with parameters."""
        inner = tuple(row.kind for row in self.inner)
        return (self.hand, self.pens, self.name, self.symbols, len(self.args), inner, self.other)

    @cached_property
    def form(self) -> Kind:
        """What it is without its numbers and the symbols that may be parameters."""
        inner = tuple(row.form for row in self.inner)
        name = "" if self.names and not self.symbols else self.name
        count = len(self.symbols), len(self.args)
        return (self.hand, self.pens, name, *count, inner, self.other)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The symbols in it that may be parameters: those without arguments, and those given."""
        if self.symbols or self.args or self.other is not None:
            return self.symbols
        own = (self.name,) if self.name else ()
        return (*own, *(name for row in self.inner for name in row.names))

    @cached_property
    def every(self) -> tuple[Row, ...]:
        """The row and those in it."""
        return (self, *(row for each in self.inner for row in each.every))

    @cached_property
    def named(self) -> tuple[str, ...]:
        """The names that stand in it."""
        if self.other is not None:
            return tuple(modules((self.other,)))
        if self.inner:
            return tuple(name for row in self.inner for name in row.named)
        return (self.name, *self.symbols)

    @cached_property
    def numbers(self) -> tuple[float, ...]:
        """All its numbers: frame, arguments, those of inner rows."""
        inner = (value for row in self.inner for value in row.numbers)
        return (*self.frame, *self.args, *inner)

    @cached_property
    def tokens(self) -> int:
        """What it takes in print, as if all rules left the turtle where it was."""
        if self.other is not None:
            return element_tokens(self.other)
        return row_tokens(self, ((1 + (each < 0), each) for each in self.numbers))

    @cached_property
    def least(self) -> int:
        """What it takes wherever it stands."""
        if self.other is not None:
            return self.tokens
        inner = sum(row.least for row in self.inner)
        given = 3 * bool(self.args) + len(self.symbols)
        return 1 + inner + sum(map(element_tokens, self.pens)) + given

    @property
    def turning(self) -> bool:
        """Whether it only moves one row further, as what turns about a point is."""
        return not self.pens and len(self.inner) == 1 and self.inner[0].placed

    @property
    def bare(self) -> int:
        """What its symbol takes."""
        given = len(self.symbols) + len(self.args)
        return 1 + (2 + given if given else 0)

    @property
    def placed(self) -> bool:
        """Whether it has a place of its own."""
        return self.other is None


def rows_of(body: Sequence[ast.Element]) -> tuple[Row, ...]:
    """The rows of a body, whatever is in it."""
    return tuple(_row(each) for each in body)


def _row(given: ast.Element) -> Row:
    """The row of one element; what is not understood is taken as it is."""
    match given:
        case ast.Module(name, args) if _is_thing(given):
            return Row(name=name, args=_values(args))
        case ast.Bracket((*moves, ast.Module() as thing)) if _is_thing(thing):
            start = _start(moves)
            if start is not None:
                return replace(start, name=thing.name, args=_values(thing.args))
    if isinstance(given, ast.Bracket):
        ahead = 0
        while ahead < len(given.body) and not _is_content(given.body[ahead]):
            ahead += 1
        start = _start(given.body[:ahead])
        if start is not None and start.pens and ahead < len(given.body):
            return replace(start, inner=rows_of(given.body[ahead:]))
    return Row(other=given)


def _is_content(given: ast.Element) -> bool:
    return not isinstance(given, ast.Module) or _is_thing(given)


def _is_thing(given: ast.Module) -> bool:
    """Whether it is a symbol whose arguments are numbers."""
    plain = all(isinstance(each.value, ast.Number) and not each.name for each in given.args)
    return plain and is_symbol(given)


def is_symbol(given: ast.Module) -> bool:
    """Whether it draws something, rather than moves the turtle or sets the pen."""
    return given.name not in OPERATIONS


def _values(args: Sequence[ast.Argument]) -> tuple[float, ...]:
    return tuple(each.value.value for each in args if isinstance(each.value, ast.Number))


def _start(moves: Sequence[ast.Element]) -> Row | None:
    """The place and pens that a bracket begins with, None if something else is among them."""
    frame, hand = list(STILL), 1
    pens: list[ast.Module] = []
    for move in moves:
        if not isinstance(move, ast.Module) or (hand < 0 and move.name in ("at", *TURTLE)):
            return None
        plain = all(isinstance(each.value, ast.Number) for each in move.args)
        values = _values(move.args)
        if move.name == "at" and plain and tuple(frame) == STILL and not pens:
            frame[: len(values)] = values
        elif move.name in TURTLE and plain and len(values) == 1 and not pens:
            if move.name == "*":
                frame[3] *= values[0]
            else:
                frame[2] += values[0] if move.name == "+" else -values[0]
        elif move.name == "mirror" and not pens:
            hand = -hand
        elif move.name in ("css", "effect"):
            pens.append(move)
        else:
            return None
    x, y, angle, scale = frame
    return Row((x, y, angle, scale), hand, tuple(pens))


def modules(body: Sequence[ast.Element]) -> Iterator[str]:
    """The names that stand in a body."""
    for each in body:
        match each:
            case ast.Module(name, args):
                yield name
                yield from (arg.value.id for arg in args if isinstance(arg.value, ast.Name))
            case ast.Bracket(inner) | ast.Repeat(_, inner):
                yield from modules(inner)


# ------------------------------------------------------------------------ places


def frames_of(rows: Sequence[Row]) -> Frames:
    """(n,) where the rows stand."""
    x, y, angle, scale = np.array([row.frame for row in rows], np.float64).reshape(-1, 4).T
    return Frames(x, y, angle, scale, np.array([row.hand for row in rows], np.int8))


def moved(rows: Sequence[Row], places: Frames) -> tuple[Row, ...]:
    """The rows at other places (n,)."""
    return tuple(
        Row(
            (x, y, angle, scale),
            hand,
            row.pens,
            row.name,
            row.args,
            row.inner,
            row.other,
            row.origin,
            row.symbols,
        )
        for row, (x, y, angle, scale, hand) in zip(rows, places.rows(), strict=True)
    )


def with_numbers(rows: Sequence[Row], numbers: Sequence[float]) -> tuple[Row, ...]:
    """The rows with other numbers, those of all rows one after the other."""
    values = iter(numbers)
    return tuple(_with(row, values) for row in rows)


def _with(row: Row, values: Iterator[float]) -> Row:
    x, y, angle, scale = (next(values) for _ in STILL)
    args = tuple(next(values) for _ in row.args)
    inner = tuple(_with(each, values) for each in row.inner)
    frame = (x, y, angle, scale)
    return Row(
        frame, row.hand, row.pens, row.name, args, inner, row.other, row.origin, row.symbols
    )  # fmt: skip


# ------------------------------------------------------------------------ printing


def element(row: Row, values: Sequence[ast.Expr], leaving: Set[str]) -> ast.Element:
    """The element of a row with these numbers; leaving: names of what moves the turtle, which
    needs a bracket.
    """
    return _element(row, iter(values), leaving)


def plain(row: Row, leaving: Set[str]) -> ast.Element:
    """The element of a row with its own numbers."""
    return element(row, [ast.Number(each + 0.0) for each in row.numbers], leaving)


def _element(row: Row, values: Iterator[ast.Expr], leaving: Set[str]) -> ast.Element:
    frame = [next(values) for _ in STILL]
    if row.other is not None:
        return row.other
    named = (ast.Argument(ast.Name(each)) for each in row.symbols)
    args = (*named, *(ast.Argument(next(values)) for _ in row.args))
    moves = (*_moves(frame), *(ast.Module("mirror") for _ in range(row.hand < 0)), *row.pens)
    if row.inner:
        inner = [_element(each, values, leaving) for each in row.inner]
        if row.turning and isinstance(inner[0], ast.Bracket):
            return ast.Bracket((*moves, *inner[0].body))
        return ast.Bracket((*moves, *inner))
    thing = ast.Module(row.name, args)
    return ast.Bracket((*moves, thing)) if moves or row.name in leaving else thing


def _moves(frame: Sequence[ast.Expr]) -> tuple[ast.Element, ...]:
    """`at(x, y, angle, scale)`, or turns alone, what is nothing left out."""
    x, y, angle, scale = frame
    turned, scaled = angle != ast.Number(0.0), scale != ast.Number(1.0)
    if x != ast.Number(0.0) or y != ast.Number(0.0):
        return (call("at", x, y, *([angle] if turned or scaled else []), *([scale] * scaled)),)
    made: list[ast.Element] = []
    if turned and isinstance(angle, ast.Number) and angle.value < 0:
        made.append(call("-", ast.Number(-angle.value)))
    elif turned:
        made.append(call("+", angle))
    return (*made, call("*", scale)) if scaled else tuple(made)


# ------------------------------------------------------------------------ tokens


def row_tokens(row: Row, words: Iterator[Words]) -> int:
    """Tokens of a row whose numbers take these words, as if all rules left the turtle alone."""
    (x, at_x), (y, at_y), (angle, turn), (scale, factor) = (next(words) for _ in STILL)
    if row.other is not None:
        return element_tokens(row.other)
    thing = 1 + len(row.symbols) + (2 if row.args or row.symbols else 0)
    thing += sum(next(words)[0] for _ in row.args)
    turned, scaled = turn != 0, factor != 1
    start = (row.hand < 0) + sum(map(element_tokens, row.pens))
    if at_x != 0 or at_y != 0:
        start += 3 + x + y + (angle if turned or scaled else 0) + scale * scaled
    else:
        start += (3 + (1 if turn is not None else angle)) * turned + (3 + scale) * scaled
    if row.inner:
        inner = sum(row_tokens(each, words) for each in row.inner)
        return 2 + start + inner - 2 * (row.turning and inner > row.inner[0].bare)
    return thing + start + 2 if start else thing


def element_tokens(given: ast.Element) -> int:
    """Tokens of an element as `compiler.tokens` counts them."""
    match given:
        case ast.Module(_, args):
            return 1 + (2 + sum(expr_tokens(each.value) for each in args) if args else 0)
        case ast.Bracket(body):
            return 2 + sum(map(element_tokens, body))
        case ast.Repeat(head, body):
            limit = 3 if isinstance(head, ast.Rows) else 2 + expr_tokens(head.limit)
            listed = sum(
                3 + sum(map(expr_tokens, each)) for each in (given.holes, given.steps) if each
            )
            return (
                5 + limit + listed + 4 * (given.rows is not None) + sum(map(element_tokens, body))
            )
        case _:
            return 1


def expr_tokens(given: ast.Expr) -> int:
    """Tokens of an expression; products of sums, which need brackets, do not come here."""
    match given:
        case ast.Number(value):
            return 1 + (value < 0)
        case ast.Unary(_, value):
            return 1 + expr_tokens(value)
        case ast.Binary(_, left, right):
            return 1 + expr_tokens(left) + expr_tokens(right)
        case ast.Call(_, args):
            return 3 + sum(expr_tokens(each.value) for each in args)
        case _:
            return 1
