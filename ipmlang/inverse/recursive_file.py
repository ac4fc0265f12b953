"""The grammar file of a drawing whose lines are what a recursion's turtle draws.

Takes an observation; where a recursion explains one stretch of its lines, or the lines of one path
or polygon, gives the file: the recursion's rules, a pen, and the elements before and after the
stretch as they are. Styles that follow no rule stand in a residual table. Nothing here proves or
writes to disk.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ast
from ipmlang.formats.drawing import DrawnElement, Style
from ipmlang.inverse.build import Builder
from ipmlang.inverse.coats import declarations
from ipmlang.inverse.grammar_file import (
    Subject,
    Written,
    canvas,
    parts_file,
    spaced,
    stored_tables,
)
from ipmlang.inverse.moves import call
from ipmlang.inverse.naming import Names, own_hint, shape_word
from ipmlang.inverse.observation import Observation
from ipmlang.inverse.pages import Page, folded
from ipmlang.inverse.reach import measure
from ipmlang.inverse.recursion import Recursion, as_grammar
from ipmlang.inverse.recursion.program import Again, Body
from ipmlang.inverse.simplify import AXIOM, make_book
from ipmlang.inverse.stretches import POLYGON, Stretch, stretches
from ipmlang.inverse.terminals import asset_elements
from ipmlang.inverse.terminals_file import terminals_file

RESIDUAL = "Looks"
FILLED = Style(fill="#808080", stroke_width=1.0)  # that of a turtle's polygon
NO_STYLE = Style(fill="none", stroke="#000000", stroke_width=math.nan)  # that of a drawn segment
Integers = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Recursive:
    """The file, how many rules it has, and for how many numbers of terminals they stand."""

    written: Written
    rules: int
    numbers: int


def write_recursion(subject: Subject) -> Recursive | None:
    """The file of the first stretch that a recursion draws, or None where none is found.

    subject: an arrangement without rules.
    """
    observed = subject.observed
    for stretch in stretches(observed):
        recursion, decimals = _folded(observed, stretch)
        if recursion is not None:
            written = _written(subject, recursion, stretch, decimals)
            return Recursive(written, _rules(recursion), stretch.numbers)
    return None


def _folded(observed: Observation, stretch: Stretch) -> tuple[Recursion | None, int | None]:
    """The recursion that draws a stretch, and the decimals that its points were rounded to: rules
    if there are any, else, of an outline, repeats.
    """
    page = Page(observed.diagonal, observed.flip, observed.box is not None)
    outline = bool(stretch.braces)
    return folded(
        page,
        stretch.start,
        stretch.end,
        styles=None if outline else observed.style[stretch.rows].astype(np.int64),
        closed=stretch.braces == POLYGON,
        repeats=outline,
    )


def _rules(recursion: Recursion) -> int:
    """How many rules and repeats there are."""
    several = sum(len(each) for each in recursion.alternatives.values())
    return len(recursion.rules) + several + _repeats(recursion.start)


def _repeats(body: Body) -> int:
    return sum(1 + _repeats(each.body) for each in body if isinstance(each, Again))


def _written(subject: Subject, found: Recursion, stretch: Stretch, decimals: int | None) -> Written:
    observed, names, rows = subject.observed, Names(), stretch.rows
    given = _Others(subject, names, set(rows.tolist()))
    taken = frozenset(given.named.values())
    items = list(as_grammar(found, taken, _pens(observed, found)))
    start = items[-1]
    assert isinstance(start, ast.Start)
    first, last = int(rows[0]), int(rows[-1])
    residual = [] if stretch.braces else _residual(observed, found, rows, names)
    style = observed.styles[int(observed.style[first])]
    if residual and residual[0].columns == ("stroke",):
        style = replace(style, stroke=NO_STYLE.stroke)
    alone = observed.box is not None and len(rows) == len(observed)
    width, pen = (1.0, ()) if found.styles else _pen(style, alone, stretch.braces)
    drawn = (*pen, *_braced(start.axiom, stretch.braces))
    axiom = (
        *given.placed(range(first)),
        ast.Bracket(drawn),
        *given.placed(range(last + 1, len(observed))),
    )
    tables, stored, cells = stored_tables(residual, subject)
    made: list[ast.Item] = [ast.Version(1), *canvas(observed, decimals)]
    if given.named:
        made.append(ast.Asset(tuple(given.named.values()), parts_file(subject), True))
    made += [*tables, *_turtle(items, width), *(ast.Residual(each.name) for each in residual)]
    rules = [each for each in items if isinstance(each, ast.Rule)]
    made += [spaced(rule, first=k == 0) for k, rule in enumerate(rules)]
    made.append(replace(start, axiom=drawn if len(axiom) == 1 else axiom))

    def shown() -> dict[str, DrawnElement]:
        terminals = subject.instanced.terminals
        drawn = asset_elements([(terminals[k], None) for k in given.named])
        return dict(zip(given.named.values(), drawn, strict=True))

    def parts(but: frozenset[str] = frozenset()) -> str:
        kept = {name: (k, None) for k, name in given.named.items() if name not in but}
        return terminals_file(subject.instanced, observed.diagonal, kept, {}, stored)

    return Written(ast.Grammar(tuple(made)), parts, *cells, assets=shown, uses=given.uses)


def _turtle(items: Sequence[ast.Item], width: float) -> list[ast.Turtle]:
    """The turtle's settings, and the width of its pen where that is not 1."""
    told = [each for item in items if isinstance(item, ast.Turtle) for each in item.settings]
    if width != 1:
        told.append(ast.Setting("width", ast.Number(width)))
    return [ast.Turtle(tuple(told))] if told else []


def _braced(body: tuple[ast.Element, ...], braces: str) -> tuple[ast.Element, ...]:
    """A body whose lines are one outline, if there are braces: the way to it stands before."""
    if not braces:
        return body
    way = next((k for k, each in enumerate(body) if not _is_way(each)), len(body))
    return (*body[:way], ast.Block(braces, (), (ast.Part(None, body[way:]),)))


def _is_way(element: ast.Element) -> bool:
    return isinstance(element, ast.Module) and element.name in ("at", "+", "-")


def _pen(style: Style, alone: bool, braces: str) -> tuple[float, tuple[ast.Element, ...]]:
    """The turtle's width and what else sets the pen; alone: whether there is nothing but segments,
    which are 1 wide by themselves, so that a width of the turtle is theirs only.

    A segment or a path has a colour and a width, and no fill; what declares more says all of it at
    once, as a polygon does.
    """
    if braces == POLYGON:
        said = declarations(FILLED, style)
        return 1.0, (call("css", ast.Text(said)),) if said else ()
    told = replace(NO_STYLE, stroke=style.stroke, stroke_width=style.stroke_width)
    single = float(str(np.float32(style.stroke_width)))
    if style != told or not alone or single != style.stroke_width:
        return 1.0, (_declared(style),)
    colored = style.stroke != NO_STYLE.stroke
    return single, (call("color", ast.Text(str(style.stroke))),) if colored else ()


def _declared(style: Style) -> ast.Module:
    return call("css", ast.Text(declarations(NO_STYLE, style)))


def _pens(observed: Observation, found: Recursion) -> dict[int, tuple[ast.Element, ...]]:
    return {number: (_declared(observed.styles[number]),) for number in set(found.styles.values())}


def _residual(
    observed: Observation, found: Recursion, rows: Integers, names: Names
) -> list[ast.Table]:
    """What each element declares in place of the pen, where styles follow no rule."""
    styles = observed.style[rows]
    known = [observed.styles[number] for number in np.unique(styles).tolist()]
    if found.styles or len(known) < 2:
        return []
    column = "stroke" if len({replace(each, stroke="none") for each in known}) == 1 else "css"
    texts = [""] * len(observed)
    for row, style in zip(rows.tolist(), styles.tolist(), strict=True):
        own = observed.styles[style]
        texts[row] = str(own.stroke) if column == "stroke" else declarations(NO_STYLE, own)
    cells = tuple((ast.Text(text),) for text in texts)
    return [ast.Table(names.give(RESIDUAL), None, (column,), cells)]


class _Others:
    """The elements that no recursion draws, one asset for each terminal; drawn: the other rows."""

    def __init__(self, subject: Subject, names: Names, drawn: set[int]) -> None:
        instanced, observed = subject.instanced, subject.observed
        self.string = instanced.string
        book = make_book(instanced.alphabet, instanced.string)
        terminals = instanced.terminals
        rest = [k for row, k in enumerate(self.string.symbol.tolist()) if row not in drawn]
        used = sorted(set(rest))
        self.named: dict[int, str] = {}
        for number in used:
            terminal = terminals[number]
            word = shape_word(terminal.shape.kind, terminal.shape.outline, terminal.fragment)
            hint = own_hint(observed.sources[terminal.row], 0)
            self.named[number] = names.give(hint or word)
        often = Counter(rest)
        self.uses = {self.named[k]: often[k] for k in used}
        radius = {k: float(instanced.alphabet[k].radius) for k in range(len(terminals))}
        reach = measure(book, radius, subject.share * observed.diagonal)
        self.builder = Builder(book, reach, self.named, {}, names, "", {}, use_tables=False)

    def placed(self, rows: range) -> Iterator[ast.Element]:
        """Placements of these rows."""
        own = slice(rows.start, rows.stop)
        parts, places = self.string.symbol[own].tolist(), self.string.placed[own].rows()
        for part, place in zip(parts, places, strict=True):
            yield from self.builder.placed(AXIOM, part, place, alone=False)
