"""Parameters set to other values: attributes, constants, turtle settings, and numbers of rules.

Takes drafts and gives drafts. A value is a number, a truth, a text, or an expression written as in
a grammar. What stands elsewhere in the grammar stays as it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TypeAlias

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, fail, nearest
from ipmlang.compiler.format import format_expression
from ipmlang.compiler.parse import parse_item
from ipmlang.edit.arithmetic import number_of, scaled
from ipmlang.edit.draft import Change, Draft, with_items, with_parameters
from ipmlang.edit.selection import Selection, select

Value: TypeAlias = "int | float | bool | str | ast.Expr"
SETTING = "turtle."
_LITERALS = {
    "int": (ast.Number,), "float": (ast.Number,), "bool": (ast.Truth,), "string": (ast.Text,),
}  # fmt: skip
_PHRASES = {
    "int": "a whole number", "float": "a number", "bool": "true or false", "string": "a text",
}  # fmt: skip


def set_values(draft: Draft, values: Mapping[str, Value]) -> Draft:
    r"""Other values for attributes, constants, and turtle settings (`turtle.angle`), by name.

    Raises IpmError for names that there are not, and for values that do not fit.

    >>> from ipmlang.edit.draft import read_text
    >>> text = 'ipm 1\nattr n : int = 4 in 1..99\nconst w = 2\nstart repeat(i < n) { F(w) }'
    >>> row = read_text(text)
    >>> print(set_values(row, {"n": 7, "w": "2 * n"}).text.splitlines()[1:3])
    ['attr n : int = 7 in 1..99', 'const w = 2 * n']
    """
    problems: list[Diagnostic] = []
    for name, value in values.items():
        try:
            draft = _set(draft, name, value)
        except IpmError as error:
            problems += error.diagnostics
    if problems:
        raise IpmError(problems)
    return draft


def change(
    draft: Draft, selection: Selection, *, to: Value | None = None, factor: float | None = None
) -> Draft:
    r"""The selected parameters of rules set `to` a value, or multiplied by `factor`.

    >>> from ipmlang.edit.draft import read_text
    >>> row = read_text('ipm 1\nRow --> repeat(i < 3) { [F] f(13 + 2 * i) }\nstart Row')
    >>> change(row, Selection("Row", "f"), factor=0.5).changes[0].after
    '0.5 * (13 + 2 * i)'
    """
    if (to is None) == (factor is None):
        raise fail("bad-command", "say either what to set parameters to, or a factor")
    found = select(draft.grammar, selection, lambda place: to is not None or place.kind != "text")
    if to is not None:
        made = dict.fromkeys(found, expression(to))
    else:
        made = {number: scaled(expr, factor or 0.0) for number, (_, expr) in found.items()}
    return with_parameters(draft, found, made)


def expression(value: Value, *, text: bool = False) -> ast.Expr:
    """A value as a tree; a `text` that is not quoted is a text. Raises IpmError where it is none.

    >>> expression("rand(1, 2)").name, expression("brick", text=True)
    ('rand', Text(value='brick', span=Span(start=0, end=0)))
    """
    match value:
        case bool():
            return ast.Truth(value)
        case int() | float():
            return ast.Number(float(value))
        case str() if text and not value.startswith('"'):
            return ast.Text(value)
        case str():
            return _parsed(value)
        case _:
            return value


def _parsed(text: str) -> ast.Expr:
    parsed = parse_item(f"const value = {text}")
    if not isinstance(parsed.item, ast.Const) or "\n" in text:
        hint = "write a number, an expression as in a rule, or a text in quotes"
        raise fail("bad-command", f"`{text}` is no value", hint=hint)
    return parsed.item.value


def _set(draft: Draft, name: str, value: Value) -> Draft:
    if name.startswith(SETTING):
        return _set_turtle(draft, name.removeprefix(SETTING), value)
    for number, item in enumerate(draft.grammar.items):
        match item:
            case ast.Attr(name=found, default=before) if found == name:
                texts = item.type == "string" or isinstance(before, ast.Text)
                after = expression(value, text=texts)
                _check_fits(item, after)
                changed: ast.Item = replace(item, default=after)
            case ast.Const(name=found, value=before) if found == name:
                after = expression(value, text=isinstance(before, ast.Text))
                changed = replace(item, value=after)
            case _:
                continue
        done = [Change(name, format_expression(before), format_expression(after))]
        return with_items(draft, {number: changed}, done if after != before else [])
    raise no_such_value(draft.grammar, name)


def _set_turtle(draft: Draft, key: str, value: Value) -> Draft:
    """A word of a `turtle` item; there is one already, or the first item makes room for it."""
    after = expression(value)
    for number, item in enumerate(draft.grammar.items):
        if not isinstance(item, ast.Turtle):
            continue
        for place, setting in enumerate(item.settings):
            if setting.key == key:
                settings = list(item.settings)
                settings[place] = replace(setting, value=after)
                before = format_expression(setting.value)
                done = [Change(SETTING + key, before, format_expression(after))]
                return with_items(draft, {number: replace(item, settings=tuple(settings))}, done)
    raise no_such_value(draft.grammar, SETTING + key)


def no_such_value(grammar: ast.Grammar, name: str) -> IpmError:
    """The error for a name that is no attribute, constant or setting."""
    known = settable(grammar)
    listed = ", ".join(f"`{each}`" for each in known[:12])
    return IpmError(
        [
            Diagnostic(
                "unknown-attribute",
                f"this grammar has no attribute or constant `{name}`",
                expected=f"{listed}{' …' if len(known) > 12 else ''}" if known else None,
                suggestions=nearest(name, known),
                hint=None if known else "numbers of rules are set with --rule, --operation, --to",
            )
        ]
    )


def settable(grammar: ast.Grammar) -> list[str]:
    """What `set_values` knows, in the order of the text."""
    found: list[str] = []
    for item in grammar.items:
        match item:
            case ast.Attr(name=name) | ast.Const(name=name):
                found.append(name)
            case ast.Turtle(settings=settings):
                found += [SETTING + each.key for each in settings]
            case _:
                pass
    return found


def _check_fits(attr: ast.Attr, after: ast.Expr) -> None:
    """Refuses a literal of another type or out of range; what is computed is the checker's."""
    if not isinstance(after, ast.Number | ast.Truth | ast.Text):
        return
    phrase = _PHRASES.get(attr.type or "", "")
    wanted = _LITERALS.get(attr.type or "")
    fits = wanted is None or isinstance(after, wanted)
    if fits and attr.type == "int":
        fits = isinstance(after, ast.Number) and after.value == round(after.value)
    shown = format_expression(after)
    if not fits:
        message = f"`{attr.name}` is {phrase}, not {shown}"
        raise fail("wrong-attribute-type", message, hint=attr.doc)
    if isinstance(attr.allowed, ast.Choices) and after not in attr.allowed.values:
        allowed = ", ".join(format_expression(each) for each in attr.allowed.values)
        message = f"`{attr.name}` is one of {allowed}, and {shown} is none of them"
        raise fail("attribute-out-of-range", message, hint=attr.doc)
    low, high = bounds(attr)
    value = number_of(after)
    if value is not None and not (low <= value <= high):
        allowed = f"in {'' if low == -_FAR else f'{low:g}'}..{'' if high == _FAR else f'{high:g}'}"
        message = f"`{attr.name}` is {allowed}, and {shown} is outside"
        raise fail("attribute-out-of-range", message, hint=attr.doc)


_FAR = float("inf")


def bounds(attr: ast.Attr) -> tuple[float, float]:
    """The range of an attribute as far as it is written in literals."""
    if not isinstance(attr.allowed, ast.Range):
        return -_FAR, _FAR
    low = None if attr.allowed.low is None else number_of(attr.allowed.low)
    high = None if attr.allowed.high is None else number_of(attr.allowed.high)
    return -_FAR if low is None else low, _FAR if high is None else high
