"""Which parameters of rules are symbols: those that a body places, or passes on to one that is.

In go rules as they are written, out come the parameters that each places and those that it hands
on, and from these which are symbols. A name may be a parameter in one place of a body and something
else in another, where a repeat or a local name hides it. Nothing is looked up or reported here.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from ipmlang.compiler import ast

Node = TypeVar("Node", bound=Hashable)
Key = TypeVar("Key", bound=Hashable)


@dataclass(frozen=True, slots=True)
class Passed:
    """A parameter that stands alone as an argument: its number, and what it is an argument of."""

    parameter: int
    name: str
    arity: int
    argument: int
    span: ast.Span


@dataclass(slots=True)
class Passing:
    """The parameters that the body of one rule places, each with its first place, and those that
    it passes on.
    """

    placed: dict[int, ast.Span] = field(default_factory=dict)
    passed: list[Passed] = field(default_factory=list)


def passing(rule: ast.Rule) -> Passing:
    """What a rule does with its parameters as symbols.

    >>> from ipmlang.compiler.parse import parse_item
    >>> found = passing(parse_item("Row(s, n) --> s Row(s, n - 1)").item)
    >>> sorted(found.placed), [(each.parameter, each.argument) for each in found.passed]
    ([0], [(0, 0)])
    """
    found = Passing()
    names = {each.name: number for number, each in enumerate(rule.head.parameters)}
    if names:
        _look(found, rule.body, names)
    return found


def context_modules(head: ast.Head) -> Iterator[ast.ContextModule]:
    """The modules on both sides of a head, in the order of the text."""
    for context in (head.left, head.right):
        waiting = [] if context is None else list(reversed(context.modules))
        while waiting:
            each = waiting.pop()
            if isinstance(each, ast.ContextModule):
                yield each
            else:
                waiting += reversed(each.modules)


def leaves(expr: ast.Expr) -> Iterator[ast.Expr]:
    """What an argument may be: each outcome of a choice, else the argument itself."""
    if isinstance(expr, ast.If):
        yield from leaves(expr.value)
        yield from leaves(expr.other)
    else:
        yield expr


def symbols_taken(
    rules: Iterable[tuple[Key, Passing, Callable[[str, int], Key]]],
) -> dict[Key, frozenset[int]]:
    """Which parameters of which rules are symbols. In go the key of each rule, what it does with
    its parameters, and which key a name with so many arguments has where the rule stands.

    >>> from ipmlang.compiler.parse import parse_item
    >>> rules = (parse_item(text).item for text in ("Row(s, n) --> s", "Hall(a, s) --> Row(s, a)"))
    >>> keyed = [((one.head.name, 2), passing(one), lambda name, arity: (name, arity))
    ...          for one in rules]
    >>> sorted((name, sorted(numbers)) for (name, _), numbers in symbols_taken(keyed).items())
    [('Hall', [1]), ('Row', [0])]
    """
    placed: list[tuple[Key, int]] = []
    passed: list[tuple[tuple[Key, int], tuple[Key, int]]] = []
    for own, found, called in rules:
        placed += ((own, number) for number in found.placed)
        passed += (
            ((own, each.parameter), (called(each.name, each.arity), each.argument))
            for each in found.passed
        )
    taken: dict[Key, frozenset[int]] = {}
    for own, number in symbols_among(placed, passed) if placed else ():
        taken[own] = taken.get(own, frozenset()) | {number}
    return taken


def symbols_among(placed: Iterable[Node], passed: Iterable[tuple[Node, Node]]) -> frozenset[Node]:
    """The parameters that are symbols: those placed, and all that are passed on to one of them.

    >>> sorted(symbols_among(["c"], [("a", "b"), ("b", "c"), ("d", "a"), ("c", "e")]))
    ['a', 'b', 'c', 'd']
    """
    givers: dict[Node, list[Node]] = {}
    for giver, taker in passed:
        givers.setdefault(taker, []).append(giver)
    found: set[Node] = set()
    waiting = list(placed)
    while waiting:
        node = waiting.pop()
        if node not in found:
            found.add(node)
            waiting += givers.get(node, ())
    return frozenset(found)


def _look(found: Passing, body: Iterable[ast.Element], names: Mapping[str, int]) -> None:
    for element in body:
        match element:
            case ast.Module():
                _module(found, element, names)
            case ast.Local(name=name) if name in names:
                names = _without(names, name)
            case ast.Bracket(body=inner):
                _look(found, inner, names)
            case ast.Repeat(head=head, rows=rows, body=inner):
                own = _without(names, head.variable)
                _look(found, inner, own if rows is None else _without(own, rows.variable))
            case ast.Split(parts=parts):
                _parts(found, parts, names)
            case ast.Block(parts=pieces) | ast.Each(parts=pieces):
                for piece in pieces:
                    _look(found, piece.body, names)
            case _:
                pass


def _parts(
    found: Passing, parts: Iterable[ast.SplitPart | ast.SplitGroup], names: Mapping[str, int]
) -> None:
    for part in parts:
        if isinstance(part, ast.SplitGroup):
            _parts(found, part.parts, names)
        else:
            _look(found, part.body, names)


def _module(found: Passing, module: ast.Module, names: Mapping[str, int]) -> None:
    if not module.args:
        if module.name in names:
            found.placed.setdefault(names[module.name], module.span)
        return
    for place, argument in enumerate(module.args):
        for leaf in leaves(argument.value):
            if isinstance(leaf, ast.Name) and leaf.id in names:
                found.passed.append(
                    Passed(names[leaf.id], module.name, len(module.args), place, leaf.span)
                )


def _without(names: Mapping[str, int], name: str) -> Mapping[str, int]:
    return {key: value for key, value in names.items() if key != name} if name in names else names
