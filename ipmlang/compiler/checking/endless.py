"""What can never end: values that need themselves, and symbols that no derivation finishes.

In go the findings of a file's items, out come circles of names and symbols. A symbol can end when
one of its alternatives makes only symbols that can end; what a `repeat`, a `split` or parts may
leave out does not count. Linear in the number of calls.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TypeAlias

from ipmlang.compiler import ast
from ipmlang.compiler.checking.findings import Key
from ipmlang.compiler.checking.groups import Group
from ipmlang.compiler.diagnostics import Diagnostic
from ipmlang.compiler.styles import lineage, styles_of

Edges: TypeAlias = Sequence[tuple[Key, tuple[tuple[Key, bool], ...]]]


def check_values(group: Group) -> Iterator[Diagnostic]:
    """Attributes, constants and functions that are defined by themselves."""
    reads = {
        item.name: (index, tuple(group.findings[index].reads))
        for index, item in group.environment.others
        if isinstance(item, ast.Attr | ast.Const | ast.Function)
    }
    done: set[str] = set()
    for name in reads:
        trail: dict[str, None] = {}
        waiting = [iter((name,))]
        while waiting:
            following = next(waiting[-1], None)
            if following is None:
                waiting.pop()
                if trail:
                    done.add(trail.popitem()[0])
            elif following in trail:
                names = list(trail)
                circle = " > ".join([*names[names.index(following) :], following])
                index = reads[names[-1]][0]
                yield group.diagnostic(
                    index,
                    group.findings[index].reads[following],
                    "endless-definition",
                    f"`{following}` is defined by itself: {circle}",
                )
            elif following in reads and following not in done:
                trail[following] = None
                waiting.append(iter(reads[following][1]))


def endless(edges: Edges) -> frozenset[Key]:
    """The symbols that no derivation finishes.

    `edges` has one entry an alternative: its symbol, and what it calls, each with whether it is
    called for certain.
    """
    needs = [
        {key for key, certain in calls if certain} for _, calls in edges
    ]  # what an alternative still waits for
    symbols = {symbol for symbol, _ in edges}
    waiting: dict[Key, list[int]] = {}
    ready: list[int] = []
    for number, need in enumerate(needs):
        need &= symbols
        for key in need:
            waiting.setdefault(key, []).append(number)
        if not need:
            ready.append(number)
    ending: set[Key] = set()
    while ready:
        symbol = edges[ready.pop()][0]
        if symbol in ending:
            continue
        ending.add(symbol)
        for number in waiting.get(symbol, ()):
            needs[number].discard(symbol)
            if not needs[number]:
                ready.append(number)
    return frozenset(symbols - ending)


def edges_of(group: Group) -> Edges:
    """The alternatives of a file's symbols, those of operations' names included."""
    return tuple(
        ((name, arity), group.findings[index].edges)
        for (name, arity, interpret), places in group.environment.rules.items()
        if not interpret
        for index in places
    )


def check_endless(
    group: Group,
    found: frozenset[Key],
    edges: Mapping[Key, int],
    where: str = "",
    hint: str = "add a guard and an `else` rule, or a number of `steps`",
) -> Iterator[Diagnostic]:
    """A warning for each circle of symbols that cannot end, at its first rule in the text."""
    told: set[Key] = set()
    for key in sorted(found, key=lambda each: edges[each]):
        circle = _circle(group, key, found, edges)
        if told.isdisjoint(circle):
            index = edges[circle[0]]
            item = group.file.grammar.items[index]
            assert isinstance(item, ast.Rule)
            names = " > ".join(name for name, _ in [*circle, circle[0]])
            yield group.diagnostic(
                index,
                item.head.span,
                "never-ends",
                f"a derivation of `{circle[0][0]}` never ends{where}: {names}",
                warning=True,
                hint=hint,
            )
        told |= set(circle)


def endless_in_styles(group: Group, known: frozenset[Key]) -> Iterator[Diagnostic]:
    """Circles that a style closes: a rule that makes what it stands for is one."""
    styles = styles_of(group.file.grammar)
    own: dict[str, dict[Key, Sequence[int]]] = {}
    for (name, arity, interpret), places in group.environment.rules.items():
        style, _, rest = name.rpartition(".")
        if not interpret and (not style or style in styles):
            own.setdefault(style, {})[rest, arity] = places
    for style in styles:
        rules = dict(own.get("", {}))
        for each in lineage(styles, style):
            rules |= own.get(each, {})
        edges = [
            (key, group.findings[index].edges) for key, all_ in rules.items() for index in all_
        ]
        first = {key: places[0] for key, places in rules.items()}
        found = endless(edges) - known if style in own else frozenset()
        where = f" in the style `{style}`"
        hint = "there, a name is that of the style: give the rule that both need another name"
        yield from check_endless(group, found, first, where, hint)


def _circle(group: Group, key: Key, found: frozenset[Key], edges: Mapping[Key, int]) -> list[Key]:
    """Follow calls that cannot end from a symbol until one comes again."""
    trail = {key: None}
    while True:
        calls = group.findings[edges[key]].edges
        key = next(each for each, certain in calls if certain and each in found)
        if key in trail:
            names = list(trail)
            return names[names.index(key) :]
        trail[key] = None
