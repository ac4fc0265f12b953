"""How often the rules of a printed grammar are drawn.

Takes rules, the axiom first; counts calls, those in repeats as often as these say. Nothing here
derives a grammar.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from ipmlang.compiler import ast

SEVERAL = 2  # copies of a repeat whose count is no plain number


def rules_drawn(rules: Sequence[ast.Rule]) -> Counter[str]:
    """How often each rule but the axiom is drawn; what calls itself counts once for each call."""
    bodies: dict[str, list[ast.Element]] = {}
    for rule in rules:
        bodies.setdefault(rule.head.name, []).extend(rule.body)
    named = {name: _named(body, bodies) for name, body in bodies.items()}
    drawn = Counter({rules[0].head.name: 1})
    for name in _callers_first(rules[0].head.name, named):
        for part, often in named[name].items():
            drawn[part] += often * (drawn[name] if part != name else 1)
    del drawn[rules[0].head.name]
    return drawn


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


def _named(body: Sequence[ast.Element], rules: Mapping[str, object]) -> Counter[str]:
    """How often a body calls each rule."""
    found: Counter[str] = Counter()
    for each in body:
        match each:
            case ast.Module(name):
                found[name] += name in rules
            case ast.Bracket(inner):
                found += _named(inner, rules)
            case ast.Repeat(head, inner):
                limit = head.limit if isinstance(head, ast.Count) else None
                often = int(limit.value) if isinstance(limit, ast.Number) else SEVERAL
                for name, times in _named(inner, rules).items():
                    found[name] += often * times
    return +found
