"""A whole grammar file and its parts: names, assets, attributes, tables, rules, start, in order.

Takes rules, terminals and the observation; gives the syntax tree and the text of the parts file.
What the rules say is made in `build`. Nothing here searches or writes to disk.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from ipmlang.compiler import ast
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.places import SHAPE
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.formats.drawing import DrawnElement, Effect
from ipmlang.formats.svg import table_xml
from ipmlang.inverse.build import Builder, Painted
from ipmlang.inverse.coats import merged_styles
from ipmlang.inverse.folding import Folded, fold
from ipmlang.inverse.gridded_tables import NO_GRIDS, with_grids
from ipmlang.inverse.joined_tables import join_tables
from ipmlang.inverse.lsystem.patterns import Pattern
from ipmlang.inverse.lsystem.symbols import Integers
from ipmlang.inverse.naming import (
    Names,
    capital,
    own_hint,
    shape_word,
    shared_groups,
    shared_hint,
)
from ipmlang.inverse.numbers import number as literal
from ipmlang.inverse.observation import Observation
from ipmlang.inverse.panels import NO_PANELS, Panels, panels_of, with_panels
from ipmlang.inverse.reach import measure
from ipmlang.inverse.rest import rest_table
from ipmlang.inverse.schedules import with_schedules
from ipmlang.inverse.score import DIGITS, INLINE_ROWS
from ipmlang.inverse.simplify import AXIOM, Book
from ipmlang.inverse.terminals import Instanced, Terminal, asset_elements
from ipmlang.inverse.terminals_file import terminals_file
from ipmlang.inverse.walks import with_walks
from ipmlang.inverse.wording import arrangement, plain_row

_STRING = re.compile(r'"(?:[^"\\\n]|\\[^\n])*"|//[^\n]*')
_NUMBER = re.compile(r"(?<![\w.])[0-9]+(?:\.[0-9]+)?")
_SIGN = re.compile(r"(?:[(,]|^)\s*-(?=[0-9])", re.MULTILINE)  # a part of its number
GRID = 2e-7  # of the diagonal: what a place on a grid may be off
SHARE = 1e-8  # of the diagonal: what one rounded number may move a point by
ROUNDED = 1e-3  # of the usual error of points that are rounded once they are drawn


class Parts(Protocol):
    """Prints the parts file."""

    def __call__(self, but: frozenset[str] = frozenset()) -> str:
        """The text of it, without some assets."""


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """What a book says before tables and rules with parameters are looked for in it: names that are
    given, those of symbols, the effects by their ids, what stands on a grid, who printed it and the
    attributes and boards that this made, the rules, the tables of their places, the paint order.
    """

    names: Names
    named: dict[int, str]
    effects: dict[str, tuple[str | None, Effect]]
    panels: Panels
    builder: Builder
    rules: list[ast.Rule]
    placed: list[ast.Table]
    order: list[ast.Table]


@dataclass(frozen=True, eq=False)
class Written:
    """The tree, what prints the parts file, how many cells that file's tables have, and what these
    weigh, see `weight`; how many tokens tables of many things spare; folded: what rules with
    parameters changed; gridded: the tables that stand on grids, and how many cells these have;
    assets: what the terminals show, y down, and uses: how many elements each draws; draft: what it
    was made from.
    """

    grammar: ast.Grammar
    parts: Parts
    table_tokens: int
    table_weight: float
    spared: float = 0.0
    folded: Folded | None = None
    gridded: tuple[frozenset[str], int] = (frozenset(), 0)
    assets: Callable[[], Mapping[str, DrawnElement]] = dict
    uses: Mapping[str, int] = field(default_factory=dict)
    draft: Draft | None = None

    @property
    def tokens(self) -> int:
        """Tokens of the text and cells of the stored tables."""
        return count_text_tokens(self.text) + self.table_tokens

    @property
    def ruled(self) -> float:
        """Tokens without tables of many things, by which rules compete: such a table is what is
        left for those that nothing explains, and no reason to explain less.
        """
        return self.tokens + self.spared

    @property
    def rows(self) -> int:
        """Rows of the tables in the text that say where one thing stands."""
        tables = (each for each in self.grammar.items if isinstance(each, ast.Table))
        placing = (each for each in tables if each.name not in self.gridded[0])
        return sum(len(each.rows) for each in placing if SHAPE not in each.columns)

    @property
    def named(self) -> int:
        """Tokens of the attributes."""
        given = tuple(each for each in self.grammar.items if isinstance(each, ast.Attr))
        return count_text_tokens(format_grammar(ast.Grammar(given)))

    @property
    def weight(self) -> float:
        """As `ruled`, but a number weighs by its digits: what decides between ways to say the same.

        Attributes do not count: that a number can be changed by its name is no fault of a rule.
        """
        said = tuple(each for each in self.grammar.items if not isinstance(each, ast.Attr))
        text = format_grammar(replace(self.grammar, items=said))
        bare = _STRING.sub("", text)
        extra = sum(digits_weight(each) - 1 for each in _NUMBER.findall(bare))
        extra -= len(_SIGN.findall(bare))
        return count_text_tokens(text) + extra + self.table_weight + self.spared

    @cached_property
    def text(self) -> str:
        """The grammar as it is written; laying it out takes time, so it is done once."""
        return format_grammar(self.grammar)


def digits_weight(number: str) -> float:
    """What a number weighs beside a token of 1: two thirds of its digits, at least a half.

    >>> digits_weight("3"), digits_weight("129.57")
    (0.6666666666666666, 3.3333333333333335)
    """
    return max(0.5, len(number.replace(".", "").lstrip("0")) / DIGITS)


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """What a file is made from: `share` of the diagonal bounds the rounding of its numbers; folded:
    whether rules that differ in numbers alone become one.
    """

    observed: Observation
    instanced: Instanced
    stem: str
    share: float = SHARE
    use_tables: bool = True
    folded: bool = False


def drafted(book: Book, subject: Subject) -> Draft:
    """What a book says as it is, whether rules are folded or not."""
    names = Names()
    axiom = names.give("Drawing")
    terminals = subject.instanced.terminals
    painted = merged_styles(book, terminals)
    off = GRID * subject.observed.diagonal
    panels = panels_of(book, off) if subject.use_tables else NO_PANELS
    named = _names(book, subject, names, painted, panels.groups)
    effects, shown_effects = _effects(book, subject, names)
    alphabet = subject.instanced.alphabet
    radius = {k: float(alphabet[k].radius) for k in (*range(len(terminals)), *book.anchored)}
    reach = measure(book, radius, subject.share * subject.observed.diagonal)
    builder = Builder(book, reach, named, effects, names, axiom, painted, subject.use_tables)
    rules, placed = join_tables(builder.rules(), builder.tables)
    order = rest_table(book, names, subject.share * subject.observed.diagonal)
    return Draft(names, named, shown_effects, panels, builder, rules, placed, order)


def write_grammar(book: Book, subject: Subject, known: Draft | None = None) -> Written:
    """The grammar of a book of rules; known: its draft for the same subject, folded or not."""
    draft = known or drafted(book, subject)
    names, named, builder, order = draft.names.copy(), draft.named, draft.builder, draft.order
    rules, placed, panels = draft.rules, draft.placed, draft.panels
    terminals = subject.instanced.terminals
    off = GRID * subject.observed.diagonal
    folded, grids = None, NO_GRIDS
    spared: dict[str, float] = {}
    even: dict[str, int] = {}
    if subject.folded:
        taken = {named[k] for k in (*range(len(terminals)), *panels.groups) if k in named}
        taken |= {each.name for each in (*placed, *order)}
        taken |= {each.name for each in builder.attributes}
        folded = fold(rules, builder.reach.error, taken)
        rules = list(folded.rules)
    if subject.use_tables:
        given = [named[group] for group in panels.groups]
        rules, shown_panels = with_panels(rules, panels, given, names, off)
        things = frozenset(named.values()) | {rule.head.name for rule in rules}
        schedules = with_schedules(rules, things, names, off)
        spared, even = schedules.spared, schedules.even
        grids = with_grids(schedules.rules, [*placed, *schedules.tables], off)
        rules, placed = grids.rules, [*shown_panels, *grids.tables]
    boards = [each.table for each in builder.boards if each.table is not None]
    tables, stored, cells = stored_tables([*placed, *boards, *order], subject)
    items: list[ast.Item] = [ast.Version(1), *canvas(subject.observed)]
    assets = [number for number in named if number < len(terminals)]
    if assets:
        items.append(ast.Asset(tuple(named[k] for k in assets), parts_file(subject), True))
    items += tables
    items += [ast.Residual(each.name) for each in order]
    items += builder.attributes
    if subject.use_tables:
        staying = {name for number, name in named.items() if number not in book.repeats()}
        staying |= {rule.head.name for rule in rules} - set(named.values())
        rules = [with_walks(rule, staying) for rule in rules]
    rules, begin = _started(rules)
    items += [spaced(rule, first=k == 0) for k, rule in enumerate(rules)]
    items.append(ast.Start(begin))

    def shown() -> dict[str, DrawnElement]:
        drawn = asset_elements([(terminals[k], book.assets.get(k)) for k in assets])
        return {named[k]: each for k, each in zip(assets, drawn, strict=True)}

    def parts(but: frozenset[str] = frozenset()) -> str:
        kept = {named[k]: (k, book.assets.get(k)) for k in assets if named[k] not in but}
        fine = 1.0 if subject.observed.decimals is None else ROUNDED
        diagonal = fine * subject.observed.diagonal
        return terminals_file(subject.instanced, diagonal, kept, draft.effects, stored)

    often = np.bincount(subject.instanced.string.symbol, minlength=len(terminals))
    uses = {named[k]: int(often[k]) for k in assets}
    left = sum(tokens for name, tokens in spared.items() if name not in grids.names)
    on_boards = sum(each.stop - each.start for each in book.boards.values())
    gridded = frozenset({*grids.names, *even, *(each.name for each in boards)})
    in_cells = grids.cells + on_boards + sum(even.values())
    grammar = ast.Grammar(tuple(items))
    said = gridded, in_cells
    return Written(grammar, parts, *cells, left, folded, said, shown, uses, draft)


def _started(rules: list[ast.Rule]) -> tuple[list[ast.Rule], tuple[ast.Element, ...]]:
    """The rules and what to start with: the first rule, or what alone stands in it."""
    match rules[0].body:
        case (ast.Bracket((*moves, ast.Module() as only)),) if len(rules) > 1:
            return rules[1:], (*moves, only)
        case (ast.Module() as only,) if len(rules) > 1:
            return rules[1:], (only,)
    return rules, (ast.Module(rules[0].head.name),)


def spaced(rule: ast.Rule, first: bool) -> ast.Rule:
    """A rule, with a blank line before the first one."""
    return replace(rule, blank_before=first)


def parts_file(subject: Subject) -> str:
    """The name of the file with terminals and tables."""
    return f"{subject.stem}.parts.svg"


def canvas(observed: Observation, decimals: int | None = None) -> list[ast.Item]:
    """The page of the drawing, if it has one; decimals: of the points of what is drawn, where the
    observation does not know them.
    """
    if observed.box is None:
        return []
    decimals = decimals if observed.decimals is None else observed.decimals
    box = tuple(literal(value) for value in observed.box)
    return [ast.Canvas(box, observed.drawing.width, observed.drawing.height, decimals)]


def _effects(
    book: Book, subject: Subject, names: Names
) -> tuple[dict[int, str], dict[str, tuple[str | None, Effect]]]:
    """The reference of each group's effect, and the effects by their ids in the parts file."""
    named: dict[int, str] = {}
    shown: dict[str, tuple[str | None, Effect]] = {}
    for number in dict.fromkeys(book.effects[rule] for rule in sorted(book.effects)):
        kind = subject.instanced.effects[number]
        named[number] = names.give(kind.word)
        shown[named[number]] = (None, kind.effect)
    references = {
        rule: f"{parts_file(subject)}#{named[number]}" for rule, number in book.effects.items()
    }
    return references, shown


def stored_tables(
    tables: Sequence[ast.Table], subject: Subject
) -> tuple[list[ast.Item], list[str], tuple[int, float]]:
    """Short tables and those that name symbols stand in the grammar, long ones in the parts file:
    how many cells these have, and what they weigh.
    """
    items: list[ast.Item] = []
    stored: list[str] = []
    cells, weight = 0, 0.0
    for table in tables:
        if len(table.rows) <= INLINE_ROWS or SHAPE in table.columns:
            items.append(table)
            continue
        rows = [[_value(cell) for cell in row] for row in table.rows]
        stored.append(table_xml(table.name, table.columns, rows))
        items.append(ast.Table(table.name, f"{parts_file(subject)}#{table.name}"))
        cells += sum(len(row) for row in rows)
        weight += sum(_cell_weight(cell) for row in rows for cell in row)
    return items, stored, (cells, weight)


def _cell_weight(cell: float | str) -> float:
    return 1.0 if isinstance(cell, str) else digits_weight(f"{abs(cell):.15g}")


def _value(cell: ast.Expr) -> float | str:
    match cell:
        case ast.Text(text):
            return text
        case ast.Number(value):
            return value
        case _:
            raise TypeError(f"a cell is a number or a text, not {cell}")


# ------------------------------------------------------------------------- names


def symbol_names(book: Book, subject: Subject) -> dict[int, str]:
    """What `write_grammar` calls each symbol, for whoever tells of them."""
    names = Names()
    names.give("Drawing")
    painted = merged_styles(book, subject.instanced.terminals)
    off = GRID * subject.observed.diagonal
    named = _names(book, subject, names, painted, panels_of(book, off).groups)
    named |= {part: named[own] for part, own in book.family.items() if own in named}
    return named | {part: named[each.base] for part, each in painted.items()}


def _names(
    book: Book,
    subject: Subject,
    names: Names,
    painted: Mapping[int, Painted],
    panels: Sequence[int],
) -> dict[int, str]:
    """A name for every symbol that is left: terminals first, then panels, then rules from small to
    large.
    """
    used = {painted[part].base if part in painted else part for part in book.uses()}
    rows = _first_rows(subject.instanced, book.scattered)
    sources = subject.observed.sources
    terminals = subject.instanced.terminals
    above = len(shared_groups(sources)) if len(sources) > 1 else 0
    shown = {k: each for k, each in enumerate(terminals) if k in used}
    hint = {number: own_hint(sources[each.row], above) for number, each in shown.items()}
    often = Counter(hint.values())
    named: dict[int, str] = {}
    for number, terminal in shown.items():
        own = bool(hint[number]) and often[hint[number]] == 1
        named[number] = names.give(hint[number] if own else _shape(terminal))
    written = book.inlined() | {AXIOM}
    rules = [rule for rule in book.rules() if rule not in written]
    for rule in (*panels, *sorted(rules)):
        if rule in book.lattices:
            lattice = book.lattices[rule]
            wish = _short(named[book.family.get(lattice.part, lattice.part)], capital(lattice.kind))
        elif rule in book.trees:
            part = book.trees[rule].part
            wish = _short(named[book.family.get(part, part)], "Tree")
        elif rule in book.loops:
            loop = book.loops[rule]
            inner = book.family.get(loop.part, loop.part)
            nested = inner in book.loops and book.loops[inner].pattern.kind == "even"
            wish = _loop_word(named[inner], loop.pattern, nested)
        else:
            row, size = rows[rule], subject.instanced.alphabet[rule].drawn
            effect = book.effects.get(rule, -1)
            word = capital(subject.instanced.effects[effect].word) if effect >= 0 else "Motif"
            wish = capital(shared_hint(sources[row : row + size], above)) or word
        named[rule] = names.give(wish)
    return named


def _shape(terminal: Terminal) -> str:
    return shape_word(terminal.shape.kind, terminal.shape.outline, terminal.fragment)


def _first_rows(instanced: Instanced, scattered: Mapping[int, Integers]) -> dict[int, int]:
    """The first element of the first copy of every symbol; scattered: by the first row of a copy,
    the rows of what it draws where these do not follow each other.
    """
    alphabet, string = instanced.alphabet, instanced.string
    known: dict[int, int] = {}
    waiting = [
        (symbol, scattered.get(row, np.arange(row, row + alphabet[symbol].size)))
        for symbol, row in zip(string.symbol.tolist(), string.start.tolist(), strict=True)
    ]
    waiting.reverse()
    while waiting:
        symbol, rows = waiting.pop()
        if symbol in known:
            continue
        known[symbol] = int(instanced.element[rows[0]])
        rows = rows[int(alphabet[symbol].anchored) :]
        for part in alphabet[symbol].parts.tolist():
            waiting.append((part, rows))
            rows = rows[alphabet[part].size :]
    return known


def _loop_word(part: str, pattern: Pattern, nested: bool) -> str:
    """`LeafRow`, `StarRing`, or `Grid` for a row of rows."""
    if nested and plain_row(pattern):
        return _short(part.removesuffix("Row").removesuffix("Column"), "Grid")
    return _short(part, capital(arrangement(pattern)))


def _short(part: str, kind: str) -> str:
    stem = capital(part)
    return stem + kind if len(stem) <= 20 else kind


def occurrences(book: Book) -> dict[int, int]:
    """How often each rule is drawn."""
    total: dict[int, int] = {AXIOM: 1}
    order = _topological(book)
    for rule in order:
        for part, count in _named_by(book, rule):
            key = book.family.get(part, part)
            total[key] = total.get(key, 0) + total.get(rule, 0) * count
    return total


def _named_by(book: Book, rule: int) -> list[tuple[int, int]]:
    if rule in book.lattices:
        lattice = book.lattices[rule]
        return [(lattice.part, len(lattice.rows))]
    if rule in book.trees:
        tree = book.trees[rule]
        return [(tree.part, len(tree.branching.order))]
    if rule in book.loops:
        counts = [book.count[part] for part, own in book.family.items() if own == rule]
        return [(book.loops[rule].part, max(counts))]
    return [(part, len(rows)) for part, rows in book.bodies[rule].rows.items()]


def _topological(book: Book) -> list[int]:
    """Rules before the rules that they name: symbols are numbered from the parts up."""
    rules = book.rules()
    return [AXIOM, *sorted(rules, reverse=True)]
