"""Symbols replaced: a terminal or a non-terminal by another asset, symbol, or grammar's axiom.

Takes drafts and gives drafts. What is no longer needed goes with what was replaced: rules, assets
and tables that only it used. Whatever takes a symbol's place stands in the same frame.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, fail, nearest
from ipmlang.compiler.load import SUFFIX
from ipmlang.compiler.nodes import nodes
from ipmlang.compiler.ops import OPERATIONS
from ipmlang.edit.additions import found_file, with_asset, with_import
from ipmlang.edit.arithmetic import literal
from ipmlang.edit.axioms import adapted, axiom_of
from ipmlang.edit.draft import Change, Draft, read
from ipmlang.edit.selection import NOTHING
from ipmlang.edit.symbols import (
    Elements,
    defined_names,
    free_name,
    needed_names,
    placed_names,
    used_names,
    with_given,
    with_modules,
    with_shapes,
    without_names,
)
from ipmlang.edit.trial import box_of, try_part
from ipmlang.inverse.naming import capital


@dataclass(frozen=True, slots=True)
class Symbol:
    """A symbol to replace; with arguments only where it stands with just these."""

    name: str
    args: tuple[ast.Argument, ...] | None = None

    def matches(self, module: ast.Module) -> bool:
        """Whether a module of the grammar is meant."""
        return module.name == self.name and self.args in (None, module.args)


def replace_terminal(
    draft: Draft, terminal: str, by: str, *, scale: float | None = None, fit: bool = False
) -> Draft:
    r"""A terminal replaced `by` a symbol of the grammar, an asset (`flower.svg#f1`) or the axiom of
    another grammar (`other.ipm`); scaled, or fitted into the box of what stood there.

    Raises IpmError where there is no such terminal, file or symbol.

    >>> from ipmlang.edit.draft import read_text
    >>> tree = read_text('ipm 1\nTree --> F(4) [+ Leaf] Leaf\nLeaf --> F(1)\nstart Tree Bud')
    >>> print(replace_terminal(tree, "Bud", "Leaf", scale=2).text.splitlines()[-1])
    start Tree *(2) Leaf
    """
    symbols = terminals(draft.grammar)
    if terminal not in symbols:
        raise _no_symbol("terminal", terminal, symbols, rules(draft.grammar), "flatten --rule")
    return substitute(draft, Symbol(terminal), by, scale=scale, fit=fit)


def replace_rule(
    draft: Draft, symbol: Symbol, by: str, *, scale: float | None = None, fit: bool = False
) -> Draft:
    """A non-terminal replaced in the same way; its rules go."""
    check_rule(draft.grammar, symbol)
    return substitute(draft, symbol, by, scale=scale, fit=fit)


def substitute(draft: Draft, symbol: Symbol, by: str, *, scale: float | None, fit: bool) -> Draft:
    """Every use of a symbol replaced by what `by` names, scaled or fitted."""
    if scale is not None and (fit or not 0 < scale < math.inf):
        hint = "give a scale above 0, or --fit, not both"
        raise fail("bad-command", "this scale cannot be", hint=hint)
    if symbol.name in _expansion(draft.grammar, by):
        message = f"`{by}` is made of `{symbol.name}`, so this would never end"
        raise fail("bad-command", message, hint="flatten it first, and put that there")
    before = draft
    draft, part, moves = _part(draft, by)
    first: Elements = ()
    if fit:
        first = _fitting(before, draft, symbol, part)
    elif scale is not None and scale != 1:
        first = (_module("*", scale),)
    made = (*first, *part)
    often = sum(symbol.matches(each) for each in _modules(draft.grammar)) > 1
    # A row of a table and a call give a symbol by its name, so that more than one needs a rule.
    named = not symbol.args and _is_named(draft.grammar, symbol.name)
    if len(made) > 1 and (named or (often and not runs_by_steps(draft.grammar))):
        draft, name = _with_rule(draft, by, (ast.Bracket(made),))
        made, first, moves = (ast.Module(name),), (), False
    bare = not first and not moves
    return replaced(draft, symbol, lambda last: made if last or bare else (ast.Bracket(made),), by)


def replaced(draft: Draft, symbol: Symbol, made: Callable[[bool], Elements], by: str) -> Draft:
    """Every use of a symbol replaced by elements, and what only it needed dropped. `made` is told
    whether nothing sees the state that they leave behind.
    """
    count = 0

    def make(module: ast.Module, last: bool) -> Elements:
        nonlocal count
        if not symbol.matches(module):
            return (module,)
        count += 1
        first, *rest = made(last)
        return (replace(first, comments=module.comments + first.comments), *rest)

    before = needed_names(draft.grammar) | {symbol.name}
    for change, alone in ((with_shapes, True), (with_given, False)):
        if not symbol.args and change(draft.grammar, symbol.name, symbol.name)[1]:
            draft, name = _name_of(draft, made(alone), symbol.name)
            grammar, more = change(draft.grammar, symbol.name, name)
            draft, count = replace(draft, grammar=grammar), count + more
    grammar = with_modules(draft.grammar, make)
    if count == 0:
        hint = "a name without arguments stands for all of its uses"
        raise fail(NOTHING, f"`{symbol.name}` is used nowhere in this way", hint=hint)
    defined = {name for item in grammar.items for name in defined_names(item)}
    gone = (before - needed_names(grammar)) & defined
    told = [Change(symbol.name, f"{count} use{'s' * (count != 1)}", by)]
    if gone:
        told.append(Change("no longer needed", ", ".join(sorted(gone)), "left out"))
    grammar = without_names(grammar, gone)
    return replace(draft, grammar=grammar, changes=(*draft.changes, *told))


def _is_named(grammar: ast.Grammar, name: str) -> bool:
    """Whether rows of tables place a symbol, or rules are given it."""
    return any(change(grammar, name, name)[1] for change in (with_shapes, with_given))


def _name_of(draft: Draft, made: Elements, wish: str) -> tuple[Draft, str]:
    """A name for elements where only a name can stand: their own, or that of a rule of them."""
    match made:
        case (ast.Module(name, ()),):
            return draft, name
        case _:
            return _with_rule(draft, wish, made)


# ------------------------------------------------------------------------ what is there


def rules(grammar: ast.Grammar) -> set[str]:
    """The names of all rules."""
    return {item.head.name for item in grammar.items if isinstance(item, ast.Rule)}


def terminals(grammar: ast.Grammar) -> set[str]:
    """Symbols that no rule rewrites: assets, and names that nothing defines."""
    assets = {n for item in grammar.items if isinstance(item, ast.Asset) for n in item.names}
    used = placed_names(grammar) - OPERATIONS.keys()
    dotted = {name for name in used if "." in name}
    return (assets | used) - rules(grammar) - dotted


def check_rule(grammar: ast.Grammar, symbol: Symbol) -> None:
    """Raises IpmError if no rule rewrites a symbol."""
    if symbol.name not in rules(grammar):
        raise _no_symbol("rule", symbol.name, rules(grammar), terminals(grammar), "replace")


def _no_symbol(what: str, name: str, known: set[str], others: set[str], elsewhere: str) -> IpmError:
    hint = f"`ipmlang edit {elsewhere}` is for `{name}`" if name in others else None
    message = f"this grammar has no {what} `{name}`"
    return IpmError([Diagnostic(NOTHING, message, suggestions=nearest(name, known), hint=hint)])


def runs_by_steps(grammar: ast.Grammar) -> bool:
    """Whether the derivation takes a fixed number of steps."""
    return any(isinstance(item, ast.Start) and item.steps is not None for item in grammar.items)


def _modules(grammar: ast.Grammar) -> list[ast.Module]:
    return [node for node in nodes(grammar) if isinstance(node, ast.Module)]


# ------------------------------------------------------------------- what comes instead


def _expansion(grammar: ast.Grammar, name: str) -> set[str]:
    """The symbols that a rule leads to, its own included; none for what is no rule."""
    found: set[str] = set()
    waiting = {name} & rules(grammar)
    while waiting:
        found |= waiting
        used = {
            each for item in grammar.items if _heads(item, *waiting) for each in used_names(item)
        }
        waiting = used - found
    return found


def _heads(item: ast.Item, *names: str) -> bool:
    return isinstance(item, ast.Rule) and item.head.name in names


def _part(draft: Draft, by: str) -> tuple[Draft, Elements, bool]:
    """What `by` names, brought into the grammar where it is not there, and whether it can leave
    the turtle somewhere else.
    """
    if by in terminals(draft.grammar):
        return draft, (ast.Module(by),), False
    if by in rules(draft.grammar):
        return draft, (ast.Module(by),), True
    file = by.partition("#")[0]
    if "." not in file:
        known = terminals(draft.grammar) | rules(draft.grammar)
        hint = "name a symbol of the grammar, a file such as flower.svg#f1, or another grammar"
        message = f"there is no symbol `{by}`"
        raise IpmError([Diagnostic(NOTHING, message, suggestions=nearest(by, known), hint=hint)])
    if not file.endswith(SUFFIX):
        draft, name = with_asset(draft, by)
        return draft, (ast.Module(name),), False
    if runs_by_steps(draft.grammar):
        raise fail("bad-command", f"{draft.path.name} takes a fixed number of steps, which leaves "
                   "none for another grammar",
                   hint=f"draw that first: ipmlang run {file} -o part.svg, and take the drawing"
                   )  # fmt: skip
    other = read(found_file(draft, file), allow_outside=draft.allow_outside)
    draft, alias = with_import(draft, other, adapted(other, draft.grammar))
    return draft, axiom_of(other, alias, draft.grammar), True


def _with_rule(draft: Draft, wish: str, body: Elements) -> tuple[Draft, str]:
    """A new rule behind the last one."""
    stem = Path(wish.partition("#")[2] or wish.partition("#")[0]).stem
    name = free_name(draft.grammar, capital(stem) or "Part")
    items = draft.grammar.items
    place = max(k for k, item in enumerate(items) if not isinstance(item, ast.Start)) + 1
    made = (*items[:place], ast.Rule(ast.Head(name), body), *items[place:])
    return replace(draft, grammar=replace(draft.grammar, items=made)), name


def _fitting(before: Draft, after: Draft, symbol: Symbol, part: Elements) -> Elements:
    """Where the new part has to stand, and how large, to fill the box of the old one."""
    old_part: Elements = (ast.Module(symbol.name, symbol.args or ()),)
    old = box_of(try_part(before, old_part).drawing)
    new = box_of(try_part(after, part).drawing)
    if old is None or new is None or max(new[2:]) == 0 or max(old[2:]) == 0:
        hint = "give a scale instead: --scale 1"
        raise fail("bad-command", "there is nothing to measure, so nothing to fit", hint=hint)
    size = max(old[2:]) / max(new[2:])
    x = old[0] + old[2] / 2 - size * (new[0] + new[2] / 2)
    y = -(old[1] + old[3] / 2) + size * (new[1] + new[3] / 2)
    return (_module("at", *(float(f"{each:.6g}") for each in (x, y, 0.0, size))),)


def _module(name: str, *values: float) -> ast.Module:
    return ast.Module(name, tuple(ast.Argument(literal(each)) for each in values))
