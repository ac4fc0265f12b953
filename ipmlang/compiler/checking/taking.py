"""Which rules take symbols, and the calls that give a symbol where a value is wanted or the other
way about.

In go the findings of all files, out come the parameters that are symbols and diagnostics with
places. A symbol that is given is an asset, a rule without parameters, or a terminal.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

from ipmlang.compiler import ast
from ipmlang.compiler.checking.environment import Environment, View
from ipmlang.compiler.checking.expressions import Scope, Slot, type_of
from ipmlang.compiler.checking.findings import CallSite, Findings, Key
from ipmlang.compiler.checking.groups import Group
from ipmlang.compiler.diagnostics import Diagnostic
from ipmlang.compiler.ops import OPERATIONS
from ipmlang.compiler.passing import Passing, context_modules, symbols_taken
from ipmlang.compiler.places import row_of
from ipmlang.compiler.types import PHRASES, fits

_Known: TypeAlias = tuple[int, str, int]  # an environment, a name in it, how many arguments
Taken: TypeAlias = Mapping[_Known, frozenset[int]]


def taken_by(groups: Sequence[Group]) -> Taken:
    """Which parameters of the rules of all files are symbols."""
    return symbols_taken(use for group in groups for use in _uses(group))


def _uses(group: Group) -> Iterator[tuple[_Known, Passing, Callable[[str, int], _Known]]]:
    """The rules of a file that have parameters, with what they do with them."""
    called = partial(_key, group.environment)
    for item, findings in zip(group.file.grammar.items, group.findings, strict=True):
        if isinstance(item, ast.Rule) and findings.passing is not None:
            yield called(item.head.name, len(item.head.parameters)), findings.passing, called


def _key(environment: Environment, name: str, arity: int) -> _Known:
    """A symbol as the file knows it that a dotted name leads to."""
    head, dot, rest = name.partition(".")
    while dot:
        if head not in environment.styles:
            if head not in environment.imports:
                break
            environment = environment.imports[head]
        name = rest
        head, dot, rest = name.partition(".")
    record = OPERATIONS.get(name)
    return id(environment), name if record is None else record.name, arity


@dataclass(frozen=True, slots=True)
class _Calls:
    """What is looked at: a file, and which parameters of which rules are symbols."""

    group: Group
    taken: Taken

    def of(self, key: Key) -> frozenset[int]:
        """Which arguments of a symbol, as this file calls it, are symbols."""
        return self.taken.get(_key(self.group.environment, *key), frozenset())


def check_symbols(group: Group, taken: Taken) -> Iterator[Diagnostic]:
    """Calls that give a symbol where a rule takes a value, or the other way about."""
    calls = _Calls(group, taken)
    for index, findings in enumerate(group.findings):
        if not taken and not findings.named:
            continue
        for key, sites in findings.calls.items():
            own = calls.of(key) if taken else frozenset()
            for site in sites:
                if site.named or own:
                    yield from _names(calls, index, key, own, site)
                    yield from _values(calls, index, key, own, site)
        item = group.file.grammar.items[index]
        if taken and isinstance(item, ast.Rule):
            yield from _parameters(calls, index, item, findings)


def given_terminals(group: Group, taken: Taken) -> Mapping[Key, tuple[int, ast.Span]]:
    """Terminals that stand only as arguments, each with the item and the place of one."""
    calls, found = _Calls(group, taken), {}
    for index, findings in enumerate(group.findings) if taken else ():
        for key in findings.named:
            own = calls.of(key)
            for site in findings.calls[key]:
                for place, name in site.named:
                    known = group.environment.symbol(name.id) is not None or row_of(name.id)
                    if place in own and not known:
                        found[name.id, 0] = (index, name.span)
    return found


def _names(
    calls: _Calls, index: int, key: Key, own: frozenset[int], site: CallSite
) -> Iterator[Diagnostic]:
    """Names that mean no value where a value is wanted, or that no rule can be given."""
    for place, name in site.named:
        if place not in own:
            yield _no_value(calls, index, name, key)
        elif (trouble := _wrong_symbol(calls.group, name)) is not None:
            message, hint = trouble
            yield calls.group.diagnostic(index, name.span, "wrong-symbol", message, hint=hint)


def _values(
    calls: _Calls, index: int, key: Key, own: frozenset[int], site: CallSite
) -> Iterator[Diagnostic]:
    """Values where a rule takes a symbol; parameters that are both are told of elsewhere."""
    found = calls.group.findings[index].passing
    passed = () if found is None else found.passed
    for place in sorted(own):
        handed = any(
            each.argument == place and site.span.start <= each.span.start < site.span.end
            for each in passed
        )
        if handed or fits(site.types[place], "symbol"):
            continue
        given = PHRASES[site.types[place]]
        yield calls.group.diagnostic(
            index,
            site.span,
            "wrong-type",
            f"argument {place + 1} of `{key[0]}` must be a symbol, and this call gives {given}",
            hint="a symbol is the name of an asset, of a rule without parameters, or of a terminal",
        )


def _valued(calls: _Calls, index: int, name: str, findings: Findings, number: int) -> Diagnostic:
    """A parameter that is a symbol, where its value is read."""
    assert findings.passing is not None
    placed = findings.passing.placed.get(number)
    for each in findings.passing.passed if placed is None else ():
        if each.parameter == number and each.argument in calls.of((each.name, each.arity)):
            placed = each.span
    return calls.group.diagnostic(
        index,
        findings.valued[name],
        "wrong-type",
        f"`{name}` is a symbol, and has no value that could stand here",
        other=None if placed is None else (index, placed, "here it is a symbol"),
    )


def _wrong_symbol(group: Group, name: ast.Name) -> tuple[str, str | None] | None:
    """Why a name is no symbol that can be given, and what helps; None where it is one."""
    entry = group.environment.symbol(name.id)
    if row_of(name.id):
        return None
    if entry is None and name.id in OPERATIONS:
        hint = f"make a rule of it and give that: Stroke --> {name.id}"
        return f"`{name.id}` is an operation, and only a symbol can be given to a rule", hint
    if entry is not None and entry.kind == "rule" and 0 not in entry.arities | entry.interpreted:
        hint = f"make a rule of it and give that: Part --> {name.id}(…)"
        return f"`{name.id}` takes arguments, and a symbol that is given to a rule has none", hint
    return None


def _no_value(calls: _Calls, index: int, name: ast.Name, key: Key) -> Diagnostic:
    """The name of a symbol, or of nothing at all, where a value is wanted."""
    group = calls.group
    if row_of(name.id):
        message = f"`{name.id}` is a symbol, and has no value"
        return group.diagnostic(index, name.span, "wrong-type", message)
    scope = Scope(View(group.environment, {}), Findings())
    item = group.file.grammar.items[index]
    if isinstance(item, ast.Rule):
        scope.locals.update((each.name, Slot()) for each in item.head.parameters)
    type_of(scope, name)
    trouble = scope.findings.troubles[0]
    rules = group.environment.rules.get((*key, False), ())
    rule = group.file.grammar.items[rules[0]] if rules else None
    known = group.environment.symbol(name.id) is not None and isinstance(rule, ast.Rule)
    hint = f"`{key[0]}` takes a symbol there once a rule of it places that parameter"
    found = group.diagnostic(
        index, name.span, trouble.code, trouble.message, hint=hint if known else None
    )
    return replace(found, suggestions=trouble.suggestions)


def _parameters(
    calls: _Calls, index: int, rule: ast.Rule, findings: Findings
) -> Iterator[Diagnostic]:
    """Symbols among the parameters of a rule that are read as values, or handed on as such, and
    neighbours that take symbols.
    """
    group = calls.group
    own = calls.of((rule.head.name, len(rule.head.parameters)))
    for number in sorted(own):
        name = rule.head.parameters[number].name
        if name in findings.valued:
            yield _valued(calls, index, name, findings, number)
    for each in () if findings.passing is None else findings.passing.passed:
        key = (each.name, each.arity)
        used = each.name in OPERATIONS and group.environment.symbol(each.name) is None
        if each.parameter in own and not used and each.argument not in calls.of(key):
            name = rule.head.parameters[each.parameter].name
            message = f"`{name}` is a symbol, and `{each.name}` takes a value here"
            yield group.diagnostic(index, each.span, "wrong-type", message)
    for module in context_modules(rule.head):
        if calls.of((module.name, len(module.parameters))):
            message = f"`{module.name}` is given symbols, and cannot be the context of a rule"
            yield group.diagnostic(index, module.span, "symbol-in-context", message)
