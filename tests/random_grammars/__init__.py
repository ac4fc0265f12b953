"""Random well-formed grammars of the whole language: `grammar(number)` is a function of its number.

Each ends, makes at most some thousand shapes, and hangs no decision on inexact numbers, so that
every executor has to make the same of it. Families take turns: turtles in the plane and in space,
turtles that thread, rules with contexts, scopes, and scopes in which turtles stand. In one of some
numbers may arise that are none: these may end with an error.
"""

from __future__ import annotations

from pathlib import Path
from random import Random

from tests.random_grammars.contexts import Contexts
from tests.random_grammars.scopes import Scopes
from tests.random_grammars.turtles import Turtles

RISKY, RISK = 9, 0.15  # in one of so many grammars so many conditions may hang on NaN
FOLDER = Path(__file__).resolve().parent  # where the assets that grammars name lie


def grammar(number: int) -> str:
    """The text of a grammar; `FOLDER` is where it would lie."""
    draw = Random(f"grammar {number}")
    risk = RISK if number % RISKY == 0 else 0.0
    match number % 8:
        case 0:
            return Turtles(draw, risk=risk).grammar()
        case 1:
            return Turtles(draw, space=True, risk=risk).grammar()
        case 2 if number % 3 == 0:
            return Contexts(draw, risk=risk).grammar()
        case 2:
            space = draw.random() < 0.5
            return Turtles(draw, space=space, threads=True, risk=risk).grammar()
        case 3:
            threads = draw.random() < 0.4
            turtles = Turtles(draw, 60, space=True, threads=threads, scoped=True, risk=risk)
            turtles.lines.append("ipm 1")
            turtles.prepare()
            turtles.declare()
            turtles.plant(2, 60)
            return Scopes(draw, risk=risk).grammar(turtles)
        case _:
            return Scopes(draw, risk=risk).grammar()
