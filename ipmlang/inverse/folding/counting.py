"""How often the rules of a printed grammar are drawn.

Takes rules, the axiom first; counts calls, those in repeats as often as these say. Nothing here
derives a grammar.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TypeAlias

from ipmlang.compiler import ast

Placed: TypeAlias = Mapping[tuple[str, int], int]

SEVERAL = 2  # copies of a repeat whose count is no plain number


def rules_drawn(rules: Sequence[ast.Rule]) -> Counter[str]:
    """How often each rule but the axiom is drawn; what calls itself counts once for each call.

    >>> from ipmlang.compiler.parse import parse_item
    >>> text = "A --> B(C, 2) C", "B(s, n) --> s repeat(i < 3) { [s] }", "C --> leaf"
    >>> rules_drawn([parse_item(each).item for each in text])["C"]
    5
    """
    bodies: dict[str, list[ast.Element]] = {}
    for rule in rules:
        bodies.setdefault(rule.head.name, []).extend(rule.body)
    placed = _placed(rules)
    named = {name: _named(body, bodies, placed) for name, body in bodies.items()}
    drawn = Counter({rules[0].head.name: 1})
    for name in _callers_first(rules[0].head.name, named):
        for part, often in named[name].items():
            drawn[part] += often * (drawn[name] if part != name else 1)
    del drawn[rules[0].head.name]
    return drawn


def _placed(rules: Sequence[ast.Rule]) -> Placed:
    """How often each rule places the symbol that it is given as each argument."""
    found: dict[tuple[str, int], int] = {}
    for rule in rules:
        names = {each.name: None for each in rule.head.parameters}
        own = _named(rule.body, names, {}) if names else Counter[str]()
        for place, name in enumerate(names):
            key = (rule.head.name, place)
            found[key] = found.get(key, 0) + own[name]
    return found


def _callers_first(axiom: str, named: Mapping[str, Counter[str]]) -> list[str]:
    order: dict[str, None] = {}
    begun: set[str] = set()

    def visit(name: str) -> None:
        if name not in begun:
            begun.add(name)
            for part in named[name]:
                visit(part)
            order[name] = None

    visit(axiom)
    return list(reversed(order))


def _named(
    body: Sequence[ast.Element], rules: Mapping[str, object], placed: Placed
) -> Counter[str]:
    """How often a body calls each rule, or gives it to one that places it."""
    found: Counter[str] = Counter()
    for each in body:
        match each:
            case ast.Module(name, args):
                found[name] += name in rules
                for place, arg in enumerate(args):
                    if isinstance(arg.value, ast.Name) and arg.value.id in rules:
                        found[arg.value.id] += placed.get((name, place), 0)
            case ast.Bracket(inner):
                found += _named(inner, rules, placed)
            case ast.Repeat(head, inner):
                limit = head.limit if isinstance(head, ast.Count) else None
                often = int(limit.value) if isinstance(limit, ast.Number) else SEVERAL
                for name, times in _named(inner, rules, placed).items():
                    found[name] += often * times
    return +found
