"""A recursion as items of the language: turtle, rules, start.

In comes a proven `Recursion`; out come syntax trees that a file can hold, with readable names and
repeated turns instead of numbers where that is shorter. Nothing here draws or searches.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from ipmlang.compiler import ast
from ipmlang.compiler.tokens import count_tokens
from ipmlang.inverse.numbers import shortest
from ipmlang.inverse.recursion.program import (
    DRAW,
    Again,
    Body,
    Branch,
    Command,
    Done,
    Draw,
    Grow,
    Move,
    Recursion,
    Symbol,
    Turn,
)

UNTOLD = {"angle": 0.0, "step": 1.0}  # settings of the turtle that need not be written
DIGIT = 1e-10  # of a length: what a product of decimals may be off
COUNTERS = "ijk"  # of repeats in repeats
MOST_TURNS = 3  # so many equal turns are repeated, more are one turn by a number


Pens: TypeAlias = "Mapping[int, tuple[ast.Element, ...]]"


def as_grammar(
    recursion: Recursion, taken: frozenset[str] = frozenset(), pens: Pens | None = None
) -> tuple[ast.Item, ...]:
    """Turtle, rules, start.

    taken: names that stand for something else in the file; pens: what sets the pen to a style, by
    the numbers of `Recursion.styles`; without them, and where there is one style, no pen is set.
    """
    writer = Writer(recursion, _names(recursion, taken))
    settings = {"angle": recursion.angle, "step": recursion.step}
    told = [
        ast.Setting(key, ast.Number(value))
        for key, value in settings.items()
        if value != UNTOLD[key]
    ]
    start = ast.Start(
        (*_place(recursion), *writer.body(recursion.start)),
        steps=ast.Number(float(recursion.steps)) if recursion.steps else None,
        choices=_choices(recursion, writer.names),
    )
    meanings = _meanings(recursion, writer.names, pens or {})
    turtle = (ast.Turtle(tuple(told)),) if told else ()
    return (*turtle, *writer.rules(), *meanings, start)


def _meanings(recursion: Recursion, names: dict[str, str], pens: Pens) -> list[ast.Rule]:
    """What symbols draw that do not draw by their names, or with pens of their own."""
    several = len(set(recursion.styles.values())) > 1
    rules = []
    for name in sorted(recursion.drawn | recursion.moved, key=list(names).index):
        pen = pens.get(recursion.styles.get(name, 0), ()) if several else ()
        mark = "f" if name in recursion.moved else "F"
        if pen or names[name] != mark:
            body = (*pen, ast.Module(mark))
            rules.append(ast.Rule(ast.Head(names[name]), body, interpret=True))
    pen = pens.get(recursion.styles.get(DRAW, 0), ()) if several else ()
    if pen and _has(Draw, recursion.bodies):
        rules.append(ast.Rule(ast.Head("F"), (*pen, ast.Module("F")), interpret=True))
    return rules


def _choices(recursion: Recursion, names: dict[str, str]) -> str | None:
    """The draws as the language keeps them."""
    if not recursion.choices:
        return None
    from ipmlang.runtime.choices import Decisions, encode

    ((name, alternatives),) = recursion.alternatives.items()
    return encode([Decisions(names[name], len(alternatives), recursion.choices)])


def token_count(recursion: Recursion) -> int:
    """Tokens of the items."""
    return count_tokens(ast.Grammar(as_grammar(recursion)))


def _place(recursion: Recursion) -> tuple[ast.Module, ...]:
    """`at(x, y, heading)`, only a turn at the origin, or nothing."""
    values = [recursion.at.real, recursion.at.imag, recursion.heading]
    if not any(values):
        return ()
    if not any(values[:2]):
        turn = ast.Number(abs(recursion.heading))
        return (ast.Module("+" if recursion.heading > 0 else "-", (ast.Argument(turn),)),)
    told = values if recursion.heading else values[:2]
    return (ast.Module("at", tuple(ast.Argument(ast.Number(value + 0.0)) for value in told)),)


def _names(recursion: Recursion, taken: frozenset[str]) -> dict[str, str]:
    """Readable names, in the order of the rules. `F` for what is drawn by its own name, if that is
    no other command.
    """
    every = (*recursion.alternatives, *recursion.rules)
    copies = [name for name in every if name not in recursion.pieces]
    free_f = not _has(Draw, recursion.bodies)
    wanted = dict(zip(copies, "LRMS", strict=False)) if len(copies) > 1 else {}
    if len(copies) == 1:
        drawn = copies[0] in recursion.drawn
        wanted[copies[0]] = ("F" if free_f else "A") if drawn else "X"
        free_f = free_f and not drawn
    letters = iter((*("F" * free_f), *"GHIJKMNOP"))
    still = "g" if _has(Move, recursion.bodies) else "f"
    wanted |= {
        name: still if name in recursion.moved else next(letters)
        for name in every
        if name in recursion.pieces
    }
    return {name: _free(wish, taken) for name, wish in wanted.items()}


def _free(wish: str, taken: frozenset[str]) -> str:
    """The name, with a number where it is taken."""
    tries = [wish, *(f"{wish}{number}" for number in range(1, len(taken) + 2))]
    return next(name for name in tries if name in ("F", "f") or name not in taken)


def _has(kind: type[Draw] | type[Move], bodies: tuple[Body, ...]) -> bool:
    """Whether any body has such a command."""
    return any(
        isinstance(command, kind)
        or (isinstance(command, Branch | Again) and _has(kind, (command.body,)))
        for body in bodies
        for command in body
    )


@dataclass(frozen=True, slots=True)
class Writer:
    """Elements of bodies. names: of the symbols; counted: they take how many steps are left, the
    start its number, a body one less; told: every length is a number, and none the turtle's step.
    """

    recursion: Recursion
    names: dict[str, str]
    counted: ast.Expr | None = None
    told: bool = False

    def rules(self) -> list[ast.Rule]:
        """All productions, the ones that draw first."""
        made = [
            ast.Rule(
                ast.Head(self.names[name]),
                self.body(each.body),
                chance=ast.Chance("percent", ast.Number(float(each.percent))),
            )
            for name, several in self.recursion.alternatives.items()
            for each in several
        ]
        plain = self.recursion.rules.items()
        return made + [
            ast.Rule(ast.Head(self.names[name]), self.body(body)) for name, body in plain
        ]

    def body(self, body: Body, depth: int = 0) -> tuple[ast.Element, ...]:
        """The elements of a successor; `nil` if there are none. depth: repeats around it."""
        made = [each for command in body for each in self.command(command, depth)]
        return tuple(made) or (ast.Module("nil"),)

    def command(self, command: Command, depth: int = 0) -> list[ast.Element]:
        """The elements of one command."""
        match command:
            case Turn(angle):
                return self.turn(angle)
            case Grow(factor):
                return [_number("*", factor)]
            case Draw(length):
                return [self.stepped("F", length)]
            case Move(length):
                return [self.stepped("f", length)]
            case Symbol(name):
                left = () if self.counted is None else (ast.Argument(self.counted),)
                return [ast.Module(self.names[name], left)]
            case Branch(inner):
                return [ast.Bracket(self.body(inner, depth))]
            case Again(count, inner):
                head = ast.Count(COUNTERS[depth % len(COUNTERS)], ast.Number(float(count)))
                return [ast.Repeat(head, self.body(inner, depth + 1))]
            case Done():
                raise TypeError("a finished symbol stands in no rule")

    def turn(self, angle: float) -> list[ast.Element]:
        """The usual turn a few times, or one by a number."""
        usual = self.recursion.angle
        mark = "+" if angle > 0 else "-"
        times = abs(angle) / usual if usual else 0.0
        if times == round(times) and 1 <= times <= MOST_TURNS:
            return [ast.Module(mark)] * round(times)
        return [_number(mark, abs(angle))]

    def stepped(self, name: str, length: float) -> ast.Module:
        """A step, or a length of its own."""
        if length == 1 and not self.told:
            return ast.Module(name)
        value = length * self.recursion.step
        return _number(name, shortest(value, DIGIT * abs(value)))


def _number(name: str, value: float) -> ast.Module:
    return ast.Module(name, (ast.Argument(ast.Number(value)),))
