"""A book of folded rules as rules of a grammar, in the order in which they are first named.

Takes a book; gives syntax trees, with names for new rules and their parameters. Nothing here
decides which rules there are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set

from ipmlang.compiler import ast
from ipmlang.compiler.tokens import is_free_name
from ipmlang.inverse.folding.book import Book, modules
from ipmlang.inverse.folding.progressions import VARIABLES, with_repeats
from ipmlang.inverse.folding.rows import element_tokens, is_symbol
from ipmlang.inverse.folding.templates import HEAD, Rounding

NAMELESS = "Motif"


def printed(book: Book, given: Rounding, taken: Set[str]) -> tuple[ast.Rule, ...]:
    """The rules of a book, the axiom first."""
    named = book.renamed(_names(book, taken))
    made: dict[str, tuple[ast.Rule, ...]] = dict(named.fixed)
    for name, rows in named.plain.items():
        made[name] = (ast.Rule(ast.Head(name), with_repeats(rows, given, named.leaving)),)
    for name, template in named.templates.items():
        own = parameters(template.words, {*taken, *made})
        head = ast.Head(name, tuple(map(ast.Parameter, own)))
        made[name] = (ast.Rule(head, _shared(template.body(own, named.leaving), named.leaving)),)
    return tuple(rule for name in _order(named.axiom, made) for rule in made[name])


def printed_tokens(rules: Sequence[ast.Rule]) -> int:
    """Tokens of rules without guards."""
    heads = sum(HEAD + 2 * bool(rule.head.parameters) + len(rule.head.parameters) for rule in rules)
    return heads + sum(element_tokens(each) for rule in rules for each in rule.body)


def parameters(labels: Sequence[str], taken: Set[str]) -> list[str]:
    """A name for each parameter.

    >>> parameters(["x", "y", "x"], {"y"})
    ['x', 'y_2', 'x_2']
    """
    made: list[str] = []
    for label in labels:
        made.append(_free(label, {*taken, *made, *VARIABLES}))
    return made


def _free(wish: str, taken: Set[str]) -> str:
    name, number = wish, 1
    while name in taken or not is_free_name(name):
        number += 1
        name = f"{wish}_{number}"
    return name


def _names(book: Book, taken: Set[str]) -> dict[str, str]:
    """A name for each rule that has none."""
    known = {*taken, *(name for name in (*book.plain, *book.fixed, *book.templates))}
    made: dict[str, str] = {}
    for name, wish in book.wishes.items():
        if name in known:
            stem = wish.rstrip("0123456789").rstrip("_") if "_" in wish else wish
            made[name] = _free(stem or NAMELESS, known)
            known.add(made[name])
    return made


def _order(axiom: str, rules: Mapping[str, tuple[ast.Rule, ...]]) -> list[str]:
    order = [axiom]
    known = {axiom}
    for name in order:
        for rule in rules[name]:
            for part in modules(rule.body):
                if part in rules and part not in known:
                    known.add(part)
                    order.append(part)
    return order


def _shared(body: Sequence[ast.Element], leaving: Set[str]) -> tuple[ast.Element, ...]:
    """What stands at one place in one bracket: `[at(x, y) A B]`."""
    made: list[ast.Element] = []
    for each in body:
        before = made[-1] if made else None
        match before, each:
            case ast.Bracket((place, *things)), ast.Bracket((other, ast.Module() as thing)) if (
                place == other and things and all(_stays(known, leaving) for known in things)
            ):
                made[-1] = ast.Bracket((place, *things, thing))
            case _:
                made.append(each)
    return tuple(made)


def _stays(thing: ast.Element, leaving: Set[str]) -> bool:
    """Whether it is a symbol that leaves the turtle where it was."""
    return isinstance(thing, ast.Module) and is_symbol(thing) and thing.name not in leaving
