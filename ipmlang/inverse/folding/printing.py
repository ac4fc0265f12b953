"""A book of folded rules as rules of a grammar, in the order in which they are first named.

Takes a book; gives syntax trees, with names for new rules and their parameters. Nothing here
decides which rules there are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field

from ipmlang.compiler import ast
from ipmlang.compiler.tokens import is_free_name
from ipmlang.inverse.folding.book import Book
from ipmlang.inverse.folding.fits import HEAD, Rounding
from ipmlang.inverse.folding.progressions import VARIABLES, RepeatTokens, with_repeats
from ipmlang.inverse.folding.rows import element_tokens, is_symbol, modules
from ipmlang.inverse.folding.templates import Template

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


@dataclass(frozen=True, slots=True, eq=False)
class PrintedTokens:
    """Tokens that books take in print, for books that have most of their rules in common."""

    repeats: RepeatTokens
    _templates: dict[int, tuple[Template, int]] = field(default_factory=dict)

    def of(self, book: Book) -> int:
        """Of the rules that are drawn, as `printed` prints them."""
        return sum(self._of_rule(book, name) for name in _drawn(book))

    def _of_rule(self, book: Book, name: str) -> int:
        if name in book.plain:
            return HEAD + self.repeats.of(book.plain[name])
        if name in book.templates:
            return self._of_template(book.templates[name])
        return printed_tokens(book.fixed[name])

    def _of_template(self, template: Template) -> int:
        found = self._templates.get(id(template))
        if found is None:
            words, leaving = template.words, self.repeats.leaving
            body = _shared(template.body(words, leaving), leaving)
            head = HEAD + (2 + len(words) if words else 0)
            found = template, head + sum(map(element_tokens, body))
            self._templates[id(template)] = found
        return found[1]


def _drawn(book: Book) -> list[str]:
    """The rules that the axiom names, and those that these name."""
    order, known = [book.axiom], {book.axiom}
    rules = book.plain.keys() | book.templates.keys() | book.fixed.keys()
    for name in order:
        more = rules & book.parts_of(name).keys() - known
        known |= more
        order += more
    return order


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
