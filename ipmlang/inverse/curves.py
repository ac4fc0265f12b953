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
from ipmlang.formats.drawing import DrawnElement, Style
from ipmlang.inverse.coats import declarations
from ipmlang.inverse.grammar_file import Written, spaced
from ipmlang.inverse.lsystem.frames import Complexes, Frames
from ipmlang.inverse.moves import call
from ipmlang.inverse.naming import capital
from ipmlang.inverse.pages import MOST_DECIMALS, Page, folded
from ipmlang.inverse.placements import places, unplaced
from ipmlang.inverse.recursion import Recursion
from ipmlang.inverse.recursion.counted_grammar import counted_rules
from ipmlang.inverse.recursion.growing import Growing, fold_growing
from ipmlang.inverse.recursive_file import FILLED, NO_STYLE
from ipmlang.inverse.stretches import PATH, POLYGON, is_regular, is_turtles

MOST_ASSETS = 64  # a drawing of more shapes is no turtle's
FEWEST = 24  # lines of an outline that is worth a rule
PAYS = 0.5  # of the numbers of its points that a rule may take in tokens
HEAD = 16  # tokens besides
NEARLY = 1e-3  # of the last decimal: what placing an asset may move a point by


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
    """An asset that a turtle draws; on_page: where a line without a width is 1 wide; placed:
    whether it is drawn as it lies on the page, with so many decimals if its points were rounded.
    """

    name: str
    drawn: Recursion | Growing
    braces: str
    style: Style
    numbers: int
    on_page: bool
    placed: bool = False
    decimals: int | None = None


def with_curves(written: Written, page: Page, tried: bool) -> Curved | None:
    """The grammar with its curves as rules, None where it has none. tried: what is drawn once is
    known to have none.
    """
    named = [each for each in written.grammar.items if isinstance(each, ast.Asset)]
    if not 0 < sum(len(each.names) for each in named) <= MOST_ASSETS:
        return None
    on_page = any(isinstance(each, ast.Canvas) for each in written.grammar.items)
    where = places(written.grammar)
    found = [
        _curve(name, each, page, on_page, where.get(name), tried)
        if written.uses.get(name, 0) == 1
        else _curve(name, each, page, on_page, None, False)
        for name, each in written.assets().items()
    ]
    curves = _of_one_rounding([each for each in found if each is not None])
    angle = _angle(written.grammar, curves)
    taken = _taken(written.grammar)
    ruled = {each.name: _rules(each, angle, taken) for each in curves}
    ruled = {each.name: ruled[each.name] for each in curves if _pays(each, ruled[each.name])}
    if not ruled:
        return None
    curves = [each for each in curves if each.name in ruled]
    grammar = unplaced(written.grammar, {each.name for each in curves if each.placed})
    grammar = _replaced(grammar, ruled, angle)
    grammar = _rounded(grammar, {each.decimals for each in curves} - {None})
    numbers = sum(each.numbers for each in curves)
    rules = sum(len({rule.head.name for rule in each}) for each in ruled.values())
    elements = sum(written.uses.get(name, 0) for name in ruled)
    return Curved(grammar, written.parts(frozenset(ruled)), numbers, rules, elements)


def _of_one_rounding(curves: list[_Curve]) -> list[_Curve]:
    """Without those whose points were rounded otherwise than the first one's that were."""
    known = next((each.decimals for each in curves if each.decimals is not None), None)
    return [each for each in curves if each.decimals in (None, known)]


def _curve(
    name: str,
    element: DrawnElement,
    page: Page,
    on_page: bool,
    place: Frames | None,
    tried: bool,
) -> _Curve | None:
    """What a turtle does to draw an asset, y up, if it is one outline of many lines, or lines with
    gaps between them. place: (1,) where it stands on the page, None where at several; tried: it is
    no recursion.
    """
    outline, style = element.outline, element.style
    if outline is None or len(outline.kind) < FEWEST or not is_turtles(outline, style):
        return None
    start, end = outline.coords[:, :2, 0].T - 1j * outline.coords[:, :2, 1].T
    there = None if place is None else _on_page(np.stack([start, end]), place)
    placed = there is not None and page.decimals(there.ravel()) is not None
    if there is not None and placed:
        start, end = there
    else:
        page = replace(page, bounded=False)
    closed, single = bool(outline.closed[0]), len(outline.closed) == 1
    drawn, decimals = _drawn(page, start, end, closed, single, tried)
    if drawn is None:
        return None
    braces, numbers = POLYGON if closed else PATH, 2 * (len(start) + 1)
    return _Curve(name, drawn, braces, style, numbers, on_page, placed, decimals)


def _drawn(
    page: Page, start: Complexes, end: Complexes, closed: bool, single: bool, tried: bool
) -> tuple[Recursion | Growing | None, int | None]:
    """What draws segments of one outline, of `single` or many parts, and its decimals."""
    if single and not closed:
        for decimals in dict.fromkeys([None, page.decimals(np.concatenate([start, end]))]):
            growing = fold_growing(start, end, tolerance=page.exact, decimals=decimals)
            if growing is not None:
                return growing, decimals
    if tried or not is_regular(start, end):
        return None, None
    recursion, decimals = folded(page, start, end, closed=closed, repeats=single)
    return (None, None) if recursion is None or recursion.alternatives else (recursion, decimals)


def _on_page(points: Complexes, place: Frames) -> Complexes:
    """Points of an asset where it stands, with the decimals that all of them nearly have."""
    local = points.real * place.handedness + 1j * points.imag
    there = place.position + place.factor * local
    for decimals in range(MOST_DECIMALS):
        rounded = np.round(there, decimals)
        if np.abs(there - rounded).max() <= NEARLY * 10.0**-decimals:
            return np.asarray(rounded, np.complex128)
    return np.asarray(there, np.complex128)


def _angle(grammar: ast.Grammar, curves: list[_Curve]) -> float:
    """The angle of the turtle, where the file has none yet."""
    if any(isinstance(each, ast.Turtle) for each in grammar.items):
        return 0.0
    known = (each.drawn for each in curves)
    return next((each.angle for each in known if isinstance(each, Recursion)), 0.0)


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
    match curve.drawn:
        case Growing() as growing:
            rules: tuple[ast.Rule, ...] = ()
            way, body = growing.way(), growing.body()
        case Recursion() as recursion:
            names = _names(curve.name, recursion, taken)
            rules, way, body = counted_rules(recursion, names, angle)
    drawn = ast.Block(curve.braces, (), (ast.Part(None, body),))
    first = ast.Rule(ast.Head(curve.name), (ast.Bracket((*_pen(curve), *way, drawn)),))
    return (first, *rules)


def _names(name: str, recursion: Recursion, taken: set[str]) -> dict[str, str]:
    """Names of the rules of a curve by those of its recursion's symbols."""
    names = {}
    for number, symbol in enumerate(recursion.rules):
        wish = capital(name) + ("" if number == 0 else chr(ord("A") + number))
        while wish in taken:
            wish += "_"
        taken.add(wish)
        names[symbol] = wish
    return names


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


def _rounded(grammar: ast.Grammar, decimals: set[int | None]) -> ast.Grammar:
    """The grammar whose page rounds points to these decimals, one number at most."""
    if not decimals:
        return grammar
    items = [
        replace(each, decimals=max(decimals, key=lambda told: told or 0))
        if isinstance(each, ast.Canvas) and each.decimals is None
        else each
        for each in grammar.items
    ]
    return replace(grammar, items=tuple(items))
