"""A recursion as rules that count their steps down, to stand among other rules.

In come a proven `Recursion` without alternatives, a name and the turtle's angle in that file; out
come its rules, with the steps that are left as their parameter, and the elements that start it.
`as_grammar` says the same for a file of its own. Nothing here draws or searches.
"""

from __future__ import annotations

from dataclasses import replace

from ipmlang.compiler import ast
from ipmlang.inverse.numbers import shortest
from ipmlang.inverse.recursion.grammar import Writer
from ipmlang.inverse.recursion.program import Recursion

LEFT = "n"
DIGIT = 1e-10  # of a length: what may be off


def counted_rules(
    recursion: Recursion, names: dict[str, str], angle: float
) -> tuple[tuple[ast.Rule, ...], tuple[ast.Element, ...], tuple[ast.Element, ...]]:
    """The rules, the way to where the turtle begins, and what it does there.

    names: of the symbols, by those of the recursion; angle: of the turtle's `+`, 0 if another than
    the recursion's, which then says every angle.
    """
    own = replace(recursion, angle=recursion.angle if angle == recursion.angle else 0.0)
    scaled = bool(own.rules)  # a step is the frame's scale where rules say it more than once
    if scaled:
        own = replace(own, step=1.0)
    less = ast.Binary("-", ast.Name(LEFT), ast.Number(1.0))
    body = Writer(own, names, less, told=not scaled)
    rules = []
    for name, commands in own.rules.items():
        head = ast.Head(names[name], (ast.Parameter(LEFT),))
        guard = ast.Binary(">", ast.Name(LEFT), ast.Number(0.0))
        last = "F" if name in own.drawn else "f" if name in own.moved else "nil"
        rules.append(ast.Rule(head, body.body(commands), guard=guard))
        rules.append(ast.Rule(head, (ast.Module(last),), guard=ast.Otherwise()))
    start = replace(body, counted=ast.Number(float(own.steps))).body(own.start)
    return tuple(rules), _way(recursion, scaled), start


def _way(recursion: Recursion, scaled: bool) -> tuple[ast.Element, ...]:
    """`at(x, y, heading, step)`, what says nothing left out."""
    values = [recursion.at.real, recursion.at.imag, recursion.heading]
    if scaled and recursion.step != 1:
        values.append(shortest(recursion.step, DIGIT * recursion.step))
    elif recursion.heading == 0:
        values.pop()
    if len(values) == 2 and not any(values):
        return ()
    return (ast.Module("at", tuple(ast.Argument(ast.Number(value + 0.0)) for value in values)),)
