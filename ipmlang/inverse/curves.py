"""Assets that are the curves of turtles, as rules: a snowflake that a drawing shows five times.

Takes a written grammar whose terminals stand in a parts file; gives the same with a rule for each
terminal that is one long outline and that a recursion or a repeat draws in fewer tokens than its
points have numbers. Bounds come before work. Nothing here proves that the whole is still right.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ipmlang.compiler import ast
from ipmlang.compiler.tokens import count_tokens
from ipmlang.formats.drawing import LINE, DrawnElement, Style
from ipmlang.inverse.coats import declarations
from ipmlang.inverse.grammar_file import Written, spaced
from ipmlang.inverse.moves import call
from ipmlang.inverse.naming import capital
from ipmlang.inverse.recursion import Recursion, fold, fold_repeats
from ipmlang.inverse.recursion.counted_grammar import counted_rules
from ipmlang.inverse.recursive_file import FILLED, NO_STYLE
from ipmlang.inverse.stretches import PATH, POLYGON, is_regular

MOST_ASSETS = 64  # a drawing of more shapes is no turtle's
FEWEST = 24  # lines of an outline that is worth a rule
PAYS = 0.5  # of the numbers of its points that a rule may take in tokens
HEAD = 16  # tokens besides


@dataclass(frozen=True, slots=True, eq=False)
class Curved:
    """The grammar and its parts; numbers: of the points that its rules stand for; rules: how many
    there are more; elements: how many they draw.
    """

    grammar: ast.Grammar
    parts: str
    numbers: int
    rules: int
    elements: int


@dataclass(frozen=True, slots=True, eq=False)
class _Curve:
    """An asset that a turtle draws; on_page: where a line without a width is 1 wide."""

    name: str
    recursion: Recursion
    braces: str
    style: Style
    numbers: int
    on_page: bool


def with_curves(written: Written, tolerance: float, tried: bool) -> Curved | None:
    """The grammar with its curves as rules, None where it has none. tolerance: units; tried: what
    is drawn once is known to have none.
    """
    named = [each for each in written.grammar.items if isinstance(each, ast.Asset)]
    if not 0 < sum(len(each.names) for each in named) <= MOST_ASSETS:
        return None
    on_page = any(isinstance(each, ast.Canvas) for each in written.grammar.items)
    found = [
        _curve(name, each, tolerance, on_page)
        for name, each in written.assets().items()
        if not tried or written.uses.get(name, 0) != 1
    ]
    curves = [each for each in found if each is not None]
    angle = _angle(written.grammar, curves)
    taken = _taken(written.grammar)
    ruled = {each.name: _rules(each, angle, taken) for each in curves}
    ruled = {each.name: ruled[each.name] for each in curves if _pays(each, ruled[each.name])}
    if not ruled:
        return None
    grammar = _replaced(written.grammar, ruled, angle)
    numbers = sum(each.numbers for each in curves if each.name in ruled)
    rules = sum(len({rule.head.name for rule in each}) for each in ruled.values())
    elements = sum(written.uses.get(name, 0) for name in ruled)
    return Curved(grammar, written.parts(frozenset(ruled)), numbers, rules, elements)


def _curve(name: str, element: DrawnElement, tolerance: float, on_page: bool) -> _Curve | None:
    """What a turtle does to draw an asset, y up, if it is one outline of many lines."""
    outline, style = element.outline, element.style
    if outline is None or len(outline.kind) < FEWEST or len(outline.closed) != 1:
        return None
    plain = isinstance(style.fill, str) and isinstance(style.stroke, str)
    if not plain or style.stroke_matrix is not None or style.effects:
        return None
    if (outline.kind != LINE).any():
        return None
    start, end = outline.coords[:, :2, 0].T - 1j * outline.coords[:, :2, 1].T
    if not is_regular(start, end):
        return None
    points = np.concatenate([start, end])
    share = tolerance / max(1e-300, abs(complex(np.ptp(points.real), np.ptp(points.imag))))
    closed = bool(outline.closed[0])
    recursion = fold(start, end, tolerance=share) or fold_repeats(
        start, end, closed=closed, tolerance=share
    )
    if recursion is None or recursion.alternatives:
        return None
    braces = POLYGON if closed else PATH
    return _Curve(name, recursion, braces, style, 2 * (len(start) + 1), on_page)


def _angle(grammar: ast.Grammar, curves: list[_Curve]) -> float:
    """The angle of the turtle, where the file has none yet."""
    if any(isinstance(each, ast.Turtle) for each in grammar.items):
        return 0.0
    return next((each.recursion.angle for each in curves), 0.0)


def _taken(grammar: ast.Grammar) -> set[str]:
    found: set[str] = set()
    for item in grammar.items:
        match item:
            case ast.Asset():
                found |= set(item.names)
            case ast.Rule():
                found.add(item.head.name)
            case ast.Table() | ast.Attr():
                found.add(item.name)
            case _:
                pass
    return found


def _rules(curve: _Curve, angle: float, taken: set[str]) -> tuple[ast.Rule, ...]:
    """`curve --> [pen at(…) path { Curve(5) }]`, and the rules of what stands in it."""
    names = {}
    for number, symbol in enumerate(curve.recursion.rules):
        wish = capital(curve.name) + ("" if number == 0 else chr(ord("A") + number))
        while wish in taken:
            wish += "_"
        taken.add(wish)
        names[symbol] = wish
    rules, way, body = counted_rules(curve.recursion, names, angle)
    pen = _pen(curve)
    drawn = ast.Block(curve.braces, (), (ast.Part(None, body),))
    first = ast.Rule(ast.Head(curve.name), (ast.Bracket((*pen, *way, drawn)),))
    return (first, *rules)


def _pen(curve: _Curve) -> tuple[ast.Element, ...]:
    base = FILLED if curve.braces == POLYGON else NO_STYLE
    if curve.braces == PATH and curve.on_page:
        base = replace(base, stroke_width=1.0)
    said = declarations(base, curve.style)
    return (call("css", ast.Text(said)),) if said else ()


def _pays(curve: _Curve, rules: tuple[ast.Rule, ...]) -> bool:
    return count_tokens(ast.Grammar(rules)) <= PAYS * curve.numbers + HEAD


def _replaced(
    grammar: ast.Grammar, ruled: dict[str, tuple[ast.Rule, ...]], angle: float
) -> ast.Grammar:
    """The grammar with rules before its start in place of assets."""
    items: list[ast.Item] = []
    for item in grammar.items:
        match item:
            case ast.Asset():
                left = tuple(name for name in item.names if name not in ruled)
                items += [replace(item, names=left)] if left else []
            case ast.Start():
                more = [rule for rules in ruled.values() for rule in rules]
                fresh = not any(isinstance(each, ast.Rule) for each in items)
                items += [spaced(rule, first=fresh and k == 0) for k, rule in enumerate(more)]
                items.append(item)
            case _:
                items.append(item)
    if angle:
        place = next(k for k, each in enumerate(items) if isinstance(each, ast.Rule | ast.Start))
        items.insert(place, ast.Turtle((ast.Setting("angle", ast.Number(angle)),)))
    return replace(grammar, items=tuple(items))
