"""Parameters that vary with the seed: `f(13)` becomes `f(13 + rand(-1, 1))`.

Takes drafts and gives drafts. What was randomised before is randomised anew, not twice. Attributes
are drawn once a run, parameters of rules once for each place and copy that they are used for.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import fail
from ipmlang.compiler.format import format_expression
from ipmlang.compiler.nodes import mapped
from ipmlang.edit.arithmetic import added, literal, number_of, slope
from ipmlang.edit.draft import Change, Draft, with_items, with_parameters
from ipmlang.edit.parameters import bounds, no_such_value
from ipmlang.edit.places import Found, Place
from ipmlang.edit.selection import Selection, select

STEPS = "steps"


@dataclass(frozen=True, slots=True)
class Amount:
    """How far values may go, to both sides: in their own units, or a share of each value."""

    value: float
    is_share: bool = False


def amount(text: str) -> Amount:
    """`1.5` or `10%`. Raises IpmError for what is neither.

    >>> amount("10%"), amount("2")
    (Amount(value=0.1, is_share=True), Amount(value=2.0, is_share=False))
    """
    number = text.strip().removesuffix("%")
    try:
        value = float(number)
    except ValueError:
        value = -1.0
    if not (math.isfinite(value) and value >= 0):
        hint = "write how far values may go to both sides: --by 1.5, or --by 10%"
        raise fail("bad-command", f"`{text}` is no amount", hint=hint)
    share = text.strip().endswith("%")
    return Amount(value / 100 if share else value, share)


def randomise(draft: Draft, selection: Selection, by: Amount, *, whole: bool = False) -> Draft:
    r"""The selected parameters with `rand` around them; an empty selection means all that move,
    turn or scale, apart from coordinates. Counts stay whole, and others do if `whole` asks for it.

    Raises IpmError if nothing is selected, lengths and angles are to vary by one plain amount, or a
    scale could become 0.

    >>> from ipmlang.edit.draft import read_text
    >>> row = read_text('ipm 1\nRow --> repeat(i < 3) { [F] f(13) }\nstart Row')
    >>> [each.after for each in randomise(row, Selection(), amount("1")).changes]
    ['13 + rand(-1, 1)']
    """
    found = select(draft.grammar, selection, lambda place: _may_vary(place, selection))
    if not by.is_share:
        _check_units(found.values())
    made = {
        number: _varied(each, by, whole)
        for number, each in found.items()
        if each[0].parameter != STEPS
    }
    steps = [expr for place, expr in found.values() if place.parameter == STEPS]
    return _with_loose_steps(with_parameters(draft, found, made), steps, by)


def _with_loose_steps(draft: Draft, steps: Sequence[ast.Expr], by: Amount) -> Draft:
    """The draft with a random move behind each copy of the repeats that have these steps: the steps
    themselves must be known numbers.
    """
    chosen = {id(each) for each in steps}
    changes: list[Change] = []

    def loosen(node: object) -> object:
        if not isinstance(node, ast.Repeat) or chosen.isdisjoint(map(id, node.steps)):
            return node
        body = node.body[:-1] if _is_loose(node.body[-1:]) else node.body
        sizes = [abs(number_of(each) or 0.0) for each in node.steps]
        reach = by.value * sum(sizes) / len(sizes) if by.is_share else by.value
        extra = _drawn(ast.Number(0.0), -reach, reach, False)
        if number_of(extra) is None:
            body = (*body, ast.Module("f", (ast.Argument(extra),)))
            changes.append(Change("repeat steps", "", f"f({format_expression(extra)})"))
        return replace(node, body=body)

    grammar = mapped(draft.grammar, loosen)
    return replace(draft, grammar=grammar, changes=(*draft.changes, *changes))


def _is_loose(end: tuple[ast.Element, ...]) -> bool:
    """Whether a body ends in what an earlier call put there, or in what this one left of it."""
    match end:
        case (ast.Module("f", (ast.Argument(ast.Number(0)),)),):
            return True
        case (ast.Module("f", (ast.Argument(ast.Call("rand", args)),)),):
            return _are_ends(args) and _are_opposite(args)
        case _:
            return False


def _may_vary(place: Place, selection: Selection) -> bool:
    """Whether a selection means a place: without a word about operations only what moves, turns or
    scales; and without a word at all, no place that is given by coordinates.
    """
    if place.kind == "text" or place.operation == "row":
        return False
    if selection.operation is not None or selection.parameter is not None:
        return True
    placed = place.parameter in ("x", "y", "z")
    return place.motion and not (selection.is_empty and placed)


def randomise_values(draft: Draft, names: Sequence[str], by: Amount) -> Draft:
    r"""Attributes whose defaults are drawn around their values, within their ranges.

    >>> from ipmlang.edit.draft import read_text
    >>> row = read_text('ipm 1\nattr n : int = 4 in 1..9\nstart repeat(i < n) { F }')
    >>> randomise_values(row, ["n"], amount("5")).changes[0].after
    '4 + irand(-3, 5)'
    """
    items: dict[int, ast.Item] = {}
    changes: list[Change] = []
    for name in names:
        number, attr = _attribute(draft.grammar, name)
        after = _varied_default(attr, by)
        items[number] = replace(attr, default=after)
        if after != attr.default:
            before = format_expression(attr.default)
            changes.append(Change(name, before, format_expression(after)))
    return with_items(draft, items, changes)


def _attribute(grammar: ast.Grammar, name: str) -> tuple[int, ast.Attr]:
    for number, item in enumerate(grammar.items):
        if isinstance(item, ast.Attr) and item.name == name:
            if isinstance(item.default, ast.Text | ast.Truth):
                raise fail("bad-command", f"`{name}` is no number, so nothing lies around it")
            return number, item
        if isinstance(item, ast.Const) and item.name == name:
            hint = f"make it an attribute: attr {name} = {format_expression(item.value)}"
            raise fail("bad-command", f"`{name}` is a constant, which cannot vary", hint=hint)
    raise no_such_value(grammar, name)


def _varied_default(attr: ast.Attr, by: Amount) -> ast.Expr:
    base = _plain(attr.default)
    value = number_of(base)
    whole = attr.type == "int"
    if value is None:
        return _around(base, by, whole, None)
    reach = abs(value) * by.value if by.is_share else by.value
    low, high = bounds(attr)
    below, above = min(reach, value - low), min(reach, high - value)
    return _drawn(base, -max(below, 0.0), max(above, 0.0), whole)


def _varied(found: Found, by: Amount, whole: bool) -> ast.Expr:
    place, expr = found
    base = _plain(expr)
    whole = whole or place.kind == "count"
    value = number_of(base)
    if place.above is not None and not _stays_above(place.above, value, by):
        shown = format_expression(base)
        message = f"`{place.operation}` in `{place.rule}` must stay above {place.above:g}: "
        hint = "choose a smaller amount, or less than 100%"
        raise fail("bad-command", message + f"{shown} may not vary so far", hint=hint)
    if value is None:
        return _around(base, by, whole, place)
    reach = abs(value) * by.value if by.is_share else by.value
    return _drawn(base, -reach, reach, whole)


def _stays_above(bound: float, value: float | None, by: Amount) -> bool:
    if by.is_share:
        return by.value < 1
    return value is None or value - by.value > bound


def _drawn(base: ast.Expr, low: float, high: float, whole: bool) -> ast.Expr:
    """`base + rand(low, high)`; whole numbers go at least one up or down where they may."""
    if low == high == 0:
        return base
    if whole:
        low, high = -_at_least_one(-low), _at_least_one(high)
    ends = tuple(ast.Argument(literal(float(f"{end:.4g}"))) for end in (low, high))
    return added(base, ast.Call("irand" if whole else "rand", ends))


def _at_least_one(reach: float) -> float:
    return max(1.0, float(round(reach))) if reach > 0 else 0.0


def _around(base: ast.Expr, by: Amount, whole: bool, place: Place | None) -> ast.Expr:
    """Around what is computed. A share is one of the step from copy to copy, where there is one:
    `40 * i` becomes `40 * (i + rand(-0.1, 0.1))`.
    """
    if by.value == 0:
        return base
    if not by.is_share:
        return _drawn(base, -by.value, by.value, whole)
    for loop in reversed(place.loops if place is not None else ()):
        if slope(base, loop) is not None:
            return mapped(base, partial(_jittered, loop, by.value))
    product = _times(base, 1 - by.value, 1 + by.value)
    return ast.Call("round", (ast.Argument(product),)) if whole else product


def _jittered(loop: str, share: float, node: object) -> object:
    """A counter with up to a share of a step around it."""
    if not (isinstance(node, ast.Name) and node.id == loop):
        return node
    return _drawn(node, -share, share, False)


def _times(expr: ast.Expr, low: float, high: float) -> ast.Expr:
    ends = tuple(ast.Argument(literal(end)) for end in (low, high))
    return ast.Binary("*", expr, ast.Call("rand", ends))


def _plain(expr: ast.Expr) -> ast.Expr:
    """An expression without what an earlier call put around it."""
    match expr:
        case ast.Call("round", (ast.Argument(ast.Binary("*", base, ast.Call("rand")), None),)):
            return base
        case ast.Binary("+", base, ast.Call("rand" | "irand", args)) if _are_ends(args):
            return base
        case ast.Binary("*", base, ast.Call("rand", args)) if _are_ends(args):
            return base
        case ast.Call("rand" | "irand", args) if _are_ends(args) and _are_opposite(args):
            return ast.Number(0.0)
        case _:
            return mapped(expr, _plain_counter)


def _plain_counter(node: object) -> object:
    match node:
        case ast.Binary("+", ast.Name() as counter, ast.Call("rand", args)) if _are_ends(args):
            return counter
        case _:
            return node


def _are_ends(args: tuple[ast.Argument, ...]) -> bool:
    return len(args) == 2 and all(isinstance(each.value, ast.Number) for each in args)


def _are_opposite(args: tuple[ast.Argument, ...]) -> bool:
    low, high = (number_of(each.value) for each in args)
    return low is not None and high is not None and low == -high


def _check_units(found: Iterable[Found]) -> None:
    """Refuses one plain amount for lengths and angles, say, at once."""
    kinds = sorted({place.kind for place, _ in found} - {"number"})
    if len(kinds) > 1:
        names = f"{', '.join(f'{kind}s' for kind in kinds[:-1])} and {kinds[-1]}s"
        hint = "choose one kind with --operation or --parameter, or give a share: --by 10%"
        raise fail("bad-command", f"this would vary {names} by the same amount", hint=hint)
