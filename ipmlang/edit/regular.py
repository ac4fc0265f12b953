"""Grammars without the offsets that tables give: `repeat(i < n) with r in T { … }`, `residual T`.

Takes drafts and gives drafts. Columns that move, turn or scale count as offsets and become nothing;
a repeat or a residual that asks its table for anything else, paint say, keeps it for that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from ipmlang.compiler import ast
from ipmlang.compiler.format import format_expression
from ipmlang.compiler.nodes import mapped
from ipmlang.edit.arithmetic import number_of
from ipmlang.edit.draft import Change, Draft, with_items
from ipmlang.edit.places import places, with_changes
from ipmlang.edit.symbols import (
    Elements,
    defined_names,
    needed_names,
    used_names,
    with_modules,
    without_names,
)

OFFSETS = frozenset({"x", "y", "z", "angle", "scale"})


def without_offsets(draft: Draft) -> Draft:
    """The draft with every repeat regular, and with nothing moved after the derivation."""
    return without_residual(without_row_offsets(draft))


def without_residual(draft: Draft) -> Draft:
    """The draft without its residual, or with what that says of paint alone.

    >>> from ipmlang.edit.draft import read_text
    >>> text = '''ipm 1
    ... table T(x, color) = (0.1, "red"), (0, "blue")
    ... residual T
    ... start F(4) F(4)
    ... '''
    >>> print(without_residual(read_text(text)).text.splitlines()[1:4])
    ['table T(color) =', '    "red" "blue"', 'residual T']
    """
    names = {item.table for item in draft.grammar.items if isinstance(item, ast.Residual)}
    for number, item in enumerate(draft.grammar.items):
        if not (isinstance(item, ast.Table) and item.name in names):
            continue
        table, added = _painted(draft, item)
        told = [Change(f"residual {item.name}", "offsets", "none")]
        if table is not None:
            draft = with_items(draft, {number: table}, told)
            return replace(draft, added={**draft.added, **added})
        kept = [each for each in draft.grammar.items if not isinstance(each, ast.Residual)]
        grammar = replace(draft.grammar, items=tuple(kept))
        gone = needed_names(draft.grammar) - needed_names(grammar)
        grammar = without_names(grammar, gone & {item.name})
        return replace(draft, grammar=grammar, changes=(*draft.changes, *told))
    return draft


def _painted(draft: Draft, table: ast.Table) -> tuple[ast.Table | None, dict[str, bytes]]:
    """A residual's table without its offsets, in a file of its own if it was in one; None if
    nothing is left.
    """
    if table.reference is None:
        kept = _paint(table.columns)
        columns = tuple(table.columns[k] for k in kept)
        rows = tuple(tuple(row[k] for k in kept) for row in table.rows)
        return (replace(table, columns=columns, rows=rows) if kept else None), {}
    from ipmlang.formats.svg import read_table, table_xml

    file, _, node = table.reference.partition("#")
    found = read_table(draft.folder / file, node)
    kept = _paint(found.columns)
    if not kept:
        return None, {}
    rows_kept = [[row[k] for k in kept] for row in found.rows]
    xml = table_xml(node, [found.columns[k] for k in kept], rows_kept)
    text = f'<svg xmlns="http://www.w3.org/2000/svg"><metadata>\n{xml}\n</metadata></svg>\n'
    name = f"{table.name.lower()}.parts.svg"
    return replace(table, reference=f"{name}#{node}"), {name: text.encode("utf-8")}


def _paint(columns: Sequence[str]) -> list[int]:
    """Which columns of a residual say more than offsets, and of what."""
    kept = [k for k, name in enumerate(columns) if name not in OFFSETS]
    return kept if any(columns[k] != "of" for k in kept) else []


def without_row_offsets(draft: Draft) -> Draft:
    """The draft with every `repeat … with` regular.

    >>> from ipmlang.edit.draft import read_text
    >>> text = '''ipm 1
    ... table T(x, y) = (0.1, 0), (0, -0.2)
    ... Row --> repeat(i < 2) with r in T { [at(r.x, r.y) A] f(13 + r.x) }
    ... start Row
    ... '''
    >>> print(without_row_offsets(read_text(text)).text, end="")
    ipm 1
    Row --> repeat(i < 2) { [A] f(13) }
    start Row
    """
    before = needed_names(draft.grammar)
    changes: list[Change] = []

    def change(node: object) -> object:
        if not isinstance(node, ast.Repeat) or node.rows is None:
            return node
        made = _regular(node, node.rows.variable)
        if made != node:
            changes.append(Change(f"repeat with {node.rows.table}", "offsets", "none"))
        return made

    grammar = mapped(draft.grammar, change)
    gone = (before - needed_names(grammar)) & {
        name
        for item in grammar.items
        if isinstance(item, ast.Table)
        for name in defined_names(item)
    }
    grammar = without_names(grammar, gone)
    return replace(draft, grammar=grammar, changes=(*draft.changes, *changes))


def _regular(repeat: ast.Repeat, row: str) -> ast.Repeat:
    """The repeat with the columns of `row` neutral in all that moves."""
    alone = ast.Grammar((ast.Start(repeat.body),))
    made: dict[int, ast.Expr] = {}
    for number, (place, expr) in enumerate(places(alone)):
        if place.motion and row in used_names(expr):
            neutral = 1.0 if place.kind == "scale" else 0.0
            made[number] = mapped(expr, partial(_folded, row, neutral))
    start = with_changes(alone, made).items[0]
    assert isinstance(start, ast.Start)
    body = _without_idle(start.axiom)
    rows = repeat.rows if row in used_names(body) else None
    return replace(repeat, body=body, rows=rows)


def _folded(row: str, neutral: float, node: object) -> object:
    """A column as a number, and sums and products of that number computed."""
    match node:
        case ast.Name(id=name) if name.startswith(f"{row}."):
            return ast.Number(neutral)
        case ast.Binary("+" | "-", left, ast.Number(0)):
            return left
        case ast.Binary("+", ast.Number(0), right):
            return right
        case ast.Binary("*", left, ast.Number(1)) | ast.Binary("*", ast.Number(1), left):
            return left
        case _:
            return node


def _without_idle(body: Elements) -> Elements:
    """Without operations that now do nothing: `at(0, 0)`, `f(0)`, `+(0)`, `*(1)`."""
    return tuple(
        replace(each, body=_without_idle(each.body))
        if isinstance(each, ast.Bracket | ast.Repeat)
        else each
        for each in body
        if not (isinstance(each, ast.Module) and _is_idle(each))
    )


def _is_idle(module: ast.Module) -> bool:
    alone = ast.Grammar((ast.Start((module,)),))
    found = places(alone)
    return bool(found) and all(
        place.motion and number_of(expr) == (1.0 if place.kind == "scale" else 0.0)
        for place, expr in found
    )


# ------------------------------------------------------------------------- even steps


def with_even_steps(draft: Draft) -> Draft:
    r"""The draft with `f(13)` in place of `steps (13, 13, 13)`, where nothing sees that the turtle
    then goes one step further at the end.

    >>> from ipmlang.edit.draft import read_text
    >>> text = 'ipm 1\nRow --> repeat(i < 3) steps (13, 13) { [A] }\nstart [Row] [Row]'
    >>> print(with_even_steps(read_text(text)).text.splitlines()[1])
    Row --> repeat(i < 3) { [A] f(13) }
    """
    seen = _seen_behind(draft.grammar)
    items: dict[int, ast.Item] = {}
    changes: list[Change] = []
    for number, item in enumerate(draft.grammar.items):
        if not isinstance(item, ast.Rule) or item.head.name in seen or not item.body:
            continue
        *first, last = item.body
        step = _even_step(last)
        if step is None or not isinstance(last, ast.Repeat):
            continue
        move = ast.Module("f", (ast.Argument(step),))
        even = replace(last, steps=(), body=(*last.body, move))
        items[number] = replace(item, body=(*first, even))
        changes.append(
            Change(f"{item.head.name}: repeat", "steps", f"f({format_expression(step)})")
        )
    return with_items(draft, items, changes)


def _seen_behind(grammar: ast.Grammar) -> set[str]:
    """The symbols behind which something may see where the turtle was left."""
    seen: set[str] = set()

    def note(module: ast.Module, last: bool) -> Elements:
        if not last:
            seen.add(module.name)
        return (module,)

    with_modules(grammar, note)
    return seen


def _even_step(element: ast.Element) -> ast.Number | None:
    """The step of a repeat whose steps are all the same."""
    if not isinstance(element, ast.Repeat) or not isinstance(element.head, ast.Count):
        return None
    steps = element.steps
    whole = number_of(element.head.limit) == len(steps) + 1
    if not steps or not whole or any(each != steps[0] for each in steps):
        return None
    return steps[0] if isinstance(steps[0], ast.Number) else None
