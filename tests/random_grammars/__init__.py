"""Random well-formed grammars of the whole language: `grammar(number)` is a function of its number.

Each ends, makes at most some thousand shapes, and hangs no decision on inexact numbers, so that
every executor has to make the same of it. Families take turns: turtles in the plane and in space,
turtles that thread, rules with contexts, scopes, and scopes in which turtles stand.
"""

from __future__ import annotations

from pathlib import Path
from random import Random

from tests.random_grammars.contexts import Contexts
from tests.random_grammars.scopes import Scopes
from tests.random_grammars.turtles import Turtles

FOLDER = Path(__file__).resolve().parent  # where the assets that grammars name lie


def grammar(number: int) -> str:
    """The text of a grammar; `FOLDER` is where it would lie."""
    draw = Random(f"grammar {number}")
    match number % 8:
        case 0:
            return Turtles(draw).grammar()
        case 1:
            return Turtles(draw, space=True).grammar()
        case 2 if number % 3 == 0:
            return Contexts(draw).grammar()
        case 2:
            return Turtles(draw, space=draw.random() < 0.5, threads=True).grammar()
        case 3:
            turtles = Turtles(draw, 60, space=True, threads=draw.random() < 0.4, scoped=True)
            turtles.lines.append("ipm 1")
            turtles.prepare()
            turtles.declare()
            turtles.plant(2, 60)
            return Scopes(draw).grammar(turtles)
        case _:
            return Scopes(draw).grammar()
