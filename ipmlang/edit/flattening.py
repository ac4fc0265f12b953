"""A non-terminal made a terminal: what its rule draws becomes an asset in a file of its own.

Takes drafts and gives drafts. Each use is replaced by the asset, followed by the motion that the
rule makes where something after it sees that. Parameters: one asset for each set of arguments.
"""

from __future__ import annotations

import re
from dataclasses import replace

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import Diagnostic, fail
from ipmlang.compiler.nodes import nodes
from ipmlang.compiler.parse import parse_item
from ipmlang.edit.additions import with_made_asset
from ipmlang.edit.arithmetic import literal
from ipmlang.edit.draft import Draft
from ipmlang.edit.replacing import (
    Symbol,
    check_rule,
    replaced,
    rules,
    runs_by_steps,
    terminals,
)
from ipmlang.edit.selection import NOTHING
from ipmlang.edit.symbols import Elements, free_name
from ipmlang.edit.trial import Frame, Trial, try_part
from ipmlang.formats.svg.parts import write_parts
from ipmlang.inverse.naming import word


def symbol(text: str) -> Symbol:
    """`Window` or `Window(2)`. Raises IpmError for what is no symbol.

    >>> symbol("Window").args, len(symbol("Window(2, 3)").args)
    (None, 2)
    """
    item = parse_item(f"start {text}").item
    match item:
        case ast.Start(axiom=(ast.Module(name=name, args=args),)) if "\n" not in text:
            return Symbol(name, args or None)
        case _:
            hint = "write the name of a rule, with arguments if it has any: Window(2)"
            raise fail("bad-command", f"`{text}` is no symbol", hint=hint)


def flatten(draft: Draft, wanted: Symbol, *, seed: int = 0) -> Draft:
    r"""The uses of a rule's symbol replaced by an asset of what it draws, derived with a seed.

    Raises IpmError if there is no such rule, its arguments are computed, or it leaves the plane.

    >>> from ipmlang.edit.draft import read_text
    >>> two = read_text('ipm 1\nTwo --> F(4) F(4)\nstart Two Two')
    >>> print(flatten(two, symbol("Two")).text, end="")
    ipm 1
    asset two in "two.parts.svg"
    start two at(8, 0) two
    """
    check_rule(draft.grammar, wanted)
    if runs_by_steps(draft.grammar):
        hint = "name what to put there with --by, or flatten a grammar that ends by itself"
        message = "this grammar takes a fixed number of steps, so a rule has no drawing of its own"
        raise fail("bad-command", message, hint=hint)
    for each in _variants(draft.grammar, wanted):
        draft = _flattened(draft, each, seed)
    return draft


def _variants(grammar: ast.Grammar, wanted: Symbol) -> list[Symbol]:
    """The symbol with each set of arguments that it is used with outside its own rules."""
    if wanted.args is not None:
        return [wanted]
    found: dict[tuple[ast.Argument, ...], None] = {}
    for item in grammar.items:
        if isinstance(item, ast.Rule) and item.head.name == wanted.name:
            continue
        for node in nodes(item):
            if isinstance(node, ast.Module) and node.name == wanted.name:
                found[node.args] = None
    known = terminals(grammar) | rules(grammar)
    computed = [args for args in found if not all(_is_known(a.value, known) for a in args)]
    if computed:
        hint = f"flatten one set of arguments: --rule '{wanted.name}(3)'"
        raise fail("bad-command", f"`{wanted.name}` is used with computed arguments", hint=hint)
    return [Symbol(wanted.name, args) for args in found]


def _is_known(value: ast.Expr, symbols: set[str]) -> bool:
    """Whether an argument is a number as it is written, or the name of a symbol."""
    return isinstance(value, ast.Number) or (isinstance(value, ast.Name) and value.id in symbols)


def _flattened(draft: Draft, each: Symbol, seed: int) -> Draft:
    args = each.args or ()
    trial = try_part(draft, (ast.Module(each.name, args),), seed)
    if not trial.drawing.elements:
        raise fail(NOTHING, f"`{each.name}` draws nothing that could become an asset")
    values = [_spelled(a.value) for a in args]
    plain = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", each.name)
    wish = "_".join([word(plain) or "part", *values])
    name = free_name(draft.grammar, wish)
    text = write_parts({name: trial.drawing.elements}, element_effects=trial.drawing.effects)
    draft, name = with_made_asset(draft, name, text.encode("utf-8"))
    move = motion(trial.end)
    asset = ast.Module(name)
    draft = replaced(
        draft, each, lambda last: (asset,) if last else (asset, *move), f"the asset {name}"
    )
    return replace(draft, notes=(*draft.notes, *_notes(each, trial)))


def _spelled(value: ast.Expr) -> str:
    """An argument as a part of a name."""
    match value:
        case ast.Number(number):
            return f"{number:g}"
        case ast.Name(name):
            return word(name)
        case _:
            return ""


def motion(end: Frame) -> Elements:
    """The operations that lead from the start to a frame.

    >>> [each.name for each in motion(Frame(0, 0, 0, 1, False))]
    []
    """
    if end.is_start:
        return ()
    values = [end.x, end.y, end.angle, end.scale]
    rounded = [literal(float(f"{each:.12g}") if abs(each) > 1e-9 else 0.0) for each in values]
    if rounded[3].value == 1:
        rounded.pop()
        if rounded[2].value == 0:
            rounded.pop()
    at = ast.Module("at", tuple(ast.Argument(each) for each in rounded))
    return (at, ast.Module("mirror")) if end.mirrored else (at,)


def _notes(each: Symbol, trial: Trial) -> list[Diagnostic]:
    """What the asset does not do that the rule did."""
    found = []
    if trial.sets_pen:
        found.append(f"`{each.name}` also left its pen to what follows; its asset does not")
    if trial.layered:
        found.append(f"`{each.name}` painted in layers; its asset is painted as one")
    notes = [Diagnostic("flattened", text, severity="warning") for text in found]
    if trial.width is not None:
        message = "lines that set no width are drawn by the size of all that is left to draw"
        hint = f"to keep the width that they had, write: turtle width {trial.width:g}"
        notes.append(Diagnostic("flattened", message, severity="warning", hint=hint))
    return notes
