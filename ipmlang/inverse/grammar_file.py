"""A whole grammar file and its parts: names, assets, attributes, tables, rules, start, in order.

Takes rules, terminals and the observation; gives the syntax tree and the text of the parts file.
What the rules say is made in `build`. Nothing here searches or writes to disk.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipmlang.compiler import ast
from ipmlang.formats.drawing import Effect
from ipmlang.formats.svg import table_xml
from ipmlang.formats.svg.parts import write_parts
from ipmlang.inverse.build import Builder, Wrap, measure
from ipmlang.inverse.lsystem.patterns import Pattern
from ipmlang.inverse.naming import Names, capital, own_hint, shape_word, shared_hint
from ipmlang.inverse.observation import Observation
from ipmlang.inverse.score import SMALL
from ipmlang.inverse.simplify import AXIOM, Book
from ipmlang.inverse.terminals import Instanced, asset_element, effect_in_parts

INLINE_ROWS = 24  # a longer table goes to the parts file
SHARE = 1e-8  # of the diagonal: what one rounded number may move a point by


@dataclass(frozen=True, slots=True, eq=False)
class Written:
    """The tree, the parts file, and how many tokens stand in the tables of the parts file."""

    grammar: ast.Grammar
    parts: str
    table_tokens: int


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """What a file is made from: `share` of the diagonal bounds the rounding of its numbers."""

    observed: Observation
    instanced: Instanced
    stem: str
    share: float = SHARE
    use_tables: bool = True


def write_grammar(book: Book, subject: Subject) -> Written:
    """The grammar of a book of rules."""
    names = Names()
    axiom = names.give("Drawing")
    named = _names(book, subject, names)
    wraps, stacks = _wraps(book, subject, names)
    terminals = [_terminal for _terminal in named if _is_asset(book, subject, _terminal)]
    radius = {k: each.shape.radius for k, each in enumerate(subject.instanced.terminals)}
    reach = measure(book, radius, subject.share * subject.observed.diagonal)
    builder = Builder(book, reach, named, wraps, names, axiom, subject.use_tables)
    rules = builder.rules()
    tables, stored, cells = _stored(builder.tables, subject)
    items: list[ast.Item] = [ast.Version(1)]
    items += _canvas(subject.observed)
    if terminals:
        items.append(ast.Asset(tuple(named[k] for k in terminals), _file(subject), True))
    items += tables
    items += builder.attributes
    items += [_spaced(rule, first=k == 0) for k, rule in enumerate(rules)]
    items.append(ast.Start((ast.Module(axiom),)))
    assets = {
        named[k]: [asset_element(subject.instanced.terminals[k], book.assets.get(k))]
        for k in terminals
    }
    return Written(
        ast.Grammar(tuple(items)),
        write_parts(assets, effects=stacks, tables=stored),
        cells,
    )


def _spaced(rule: ast.Rule, first: bool) -> ast.Rule:
    return replace(rule, blank_before=first)


def _file(subject: Subject) -> str:
    return f"{subject.stem}.parts.svg"


def _is_asset(book: Book, subject: Subject, symbol: int) -> bool:
    return symbol < len(subject.instanced.terminals) and symbol != AXIOM


def _canvas(observed: Observation) -> list[ast.Item]:
    if observed.box is None:
        return []
    box = tuple(_literal(value) for value in observed.box)
    return [ast.Canvas(box, observed.drawing.width, observed.drawing.height)]


def _literal(value: float) -> ast.Expr:
    literal = ast.Number(abs(value))
    return ast.Unary("-", literal) if value < 0 else literal


def _wraps(
    book: Book, subject: Subject, names: Names
) -> tuple[list[Wrap], dict[str, tuple[str | None, Effect]]]:
    """The reference of every stack of effects, and the effects by id with what they stand in."""
    wraps: list[Wrap] = []
    groups: dict[str, tuple[str | None, Effect]] = {}
    known: dict[tuple[str, ...], str] = {}
    used = set(book.wrap.tolist())
    observed = subject.observed
    for number, stack in enumerate(subject.instanced.effects):
        if not stack or number not in used:
            wraps.append(Wrap(()))
            continue
        for depth in range(1, len(stack) + 1):
            inner = stack[:depth]
            if inner not in known:
                known[inner] = names.give("group")
                outer = known.get(inner[:-1])
                effect = effect_in_parts(observed.drawing, inner[-1], observed.flip)
                groups[known[inner]] = (outer, effect)
        wraps.append(Wrap((f"{_file(subject)}#{known[stack]}",)))
    return wraps, groups


def _stored(
    tables: Sequence[ast.Table], subject: Subject
) -> tuple[list[ast.Item], list[str], int]:
    """Short tables stand in the grammar, long ones in the parts file; the tokens of the latter."""
    items: list[ast.Item] = []
    stored: list[str] = []
    cells = 0
    for table in tables:
        if len(table.rows) <= INLINE_ROWS:
            items.append(table)
            continue
        rows = [[_value(cell) for cell in row] for row in table.rows]
        stored.append(table_xml(table.name, table.columns, rows))
        items.append(ast.Table(table.name, f"{_file(subject)}#{table.name}"))
        cells += sum(2 + len(row) + sum(value < 0 for value in row) for row in rows)
    return items, stored, cells


def _value(cell: ast.Expr) -> float:
    match cell:
        case ast.Number(value):
            return value
        case ast.Unary("-", ast.Number(value)):
            return -value
        case _:
            raise TypeError(f"a table's cell is a number, not {cell}")


# ------------------------------------------------------------------------- names


def _names(book: Book, subject: Subject, names: Names) -> dict[int, str]:
    """A name for every symbol that is left: terminals first, then rules from small to large."""
    used = set(book.uses())
    rows = _first_rows(subject.instanced)
    sources = subject.observed.sources
    named: dict[int, str] = {}
    for number, terminal in enumerate(subject.instanced.terminals):
        if number in used:
            kind = terminal.fragment.kind if terminal.fragment is not None else None
            word = own_hint(sources[terminal.row : terminal.row + 1])
            shape = shape_word(terminal.shape.kind, terminal.shape.outline, kind)
            named[number] = names.give(word or shape)
    rules = [rule for rule in (*book.bodies, *book.loops) if rule != AXIOM]
    for rule in sorted(rules):
        if rule in book.loops:
            loop = book.loops[rule]
            inner = book.family.get(loop.part, loop.part)
            nested = inner in book.loops and book.loops[inner].pattern.kind == "even"
            wish = _loop_word(named[inner], loop.pattern, nested)
        else:
            size = subject.instanced.alphabet[rule].size
            row = rows[rule]
            wish = capital(shared_hint(sources[row : row + size])) or "Motif"
        named[rule] = names.give(wish)
    return named


def _first_rows(instanced: Instanced) -> dict[int, int]:
    """The first element of the first copy of every symbol."""
    alphabet, string = instanced.alphabet, instanced.string
    known: dict[int, int] = {}
    waiting = list(zip(string.symbol.tolist(), string.start.tolist(), strict=True))
    waiting.reverse()
    while waiting:
        symbol, row = waiting.pop()
        if symbol in known:
            continue
        known[symbol] = row
        for part in alphabet[symbol].parts.tolist():
            waiting.append((part, row))
            row += alphabet[part].size
    return known


def _loop_word(part: str, pattern: Pattern, nested: bool) -> str:
    """`LeafRow`, `StarRing`, or `Grid` for a row of rows."""
    x, y, angle, growth = pattern.base
    if pattern.kind == "even":
        upright = abs(angle) <= SMALL and abs(growth) <= SMALL
        if nested and upright:
            return _short(part.removesuffix("Row").removesuffix("Column"), "Grid")
        if abs(x) <= SMALL and abs(y) <= SMALL:
            return _short(part, "Stack")
        return _short(part, "Column" if abs(x) < abs(y) else "Row")
    if not pattern.constant or abs(pattern.base[2] - 1) > SMALL:
        return _short(part, "Spiral")
    return _short(part, "Zigzag" if pattern.mirrored else "Ring")


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
    if rule in book.loops:
        counts = [book.count[part] for part, own in book.family.items() if own == rule]
        return [(book.loops[rule].part, max(counts))]
    parts, often = np.unique(book.bodies[rule].parts, return_counts=True)
    return list(zip(parts.tolist(), often.tolist(), strict=True))


def _topological(book: Book) -> list[int]:
    """Rules before the rules that they name: symbols are numbered from the parts up."""
    rules = [rule for rule in (*book.bodies, *book.loops) if rule != AXIOM]
    return [AXIOM, *sorted(rules, reverse=True)]
