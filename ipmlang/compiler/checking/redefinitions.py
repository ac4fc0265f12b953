"""Styles, and what items put in the place of definitions of imports and styles.

In go the items of one file and those of all files, out come diagnostics: for styles that are not
there or extend themselves, for names that lead nowhere, for what does not fit what it replaces.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from ipmlang.compiler import ast
from ipmlang.compiler.checked import ValueEntry
from ipmlang.compiler.checking.environment import values_of
from ipmlang.compiler.checking.expressions import arguments, article, constant
from ipmlang.compiler.checking.groups import Group
from ipmlang.compiler.diagnostics import Diagnostic, nearest
from ipmlang.compiler.load import import_name
from ipmlang.compiler.ops import OPERATIONS
from ipmlang.compiler.styles import names_of, styles_of
from ipmlang.compiler.types import PHRASES, fits

REPLACEABLE = (
    ast.Rule, ast.Asset, ast.Table, ast.Field, ast.Attr, ast.Const, ast.Function,
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Target:
    """What a name of an item leads to: a file's group, and the name there."""

    group: Group
    owner: str
    name: str


def check_styles(group: Group, groups: Sequence[Group]) -> Iterator[Diagnostic]:
    """All about one file's styles and redefinitions."""
    by_file = {id(each.environment): each for each in groups}
    yield from _styles(group)
    for index, item in enumerate(group.file.grammar.items):
        if isinstance(item, ast.Import) and item.style is not None:
            yield from _imported(group, index, item, item.style)
        for name in names_of(item):
            if "." in name:
                yield from _redefinition(group, index, item, name, by_file)


# ------------------------------------------------------------------------------ styles


def _styles(group: Group) -> Iterator[Diagnostic]:
    styles = styles_of(group.file.grammar)
    first: dict[str, int] = {}
    for index, item in group.environment.others:
        if not isinstance(item, ast.Style):
            continue
        if item.name in group.environment.imports:
            message = f"an import is called `{item.name}` already"
            yield group.diagnostic(index, item.span, "duplicate-name", message)
        elif item.name in first:
            before = group.file.grammar.items[first[item.name]].span
            yield group.diagnostic(
                index,
                item.span,
                "duplicate-name",
                f"`{item.name}` is defined twice",
                other=(first[item.name], before, "defined here first"),
            )
        earlier = set(first)
        first.setdefault(item.name, index)
        if item.parent is not None and item.parent not in styles:
            message = f"no style is called `{item.parent}`"
            found = group.diagnostic(index, item.span, "unknown-style", message)
            yield replace(found, suggestions=nearest(item.parent, styles))
        trail = [item.name]
        while (parent := styles[trail[-1]].parent) in styles and parent not in trail:
            trail.append(str(parent))
        if parent == item.name and earlier.isdisjoint(trail):
            circle = " > ".join([*trail, item.name])
            message = f"`{item.name}` extends itself: {circle}"
            yield group.diagnostic(index, item.span, "endless-definition", message)


def _imported(group: Group, index: int, item: ast.Import, style: str) -> Iterator[Diagnostic]:
    other = group.environment.imports.get(item.alias or import_name(item.path))
    if other is not None and style not in other.styles:
        message = f'"{item.path}" has no style `{style}`'
        found = group.diagnostic(index, item.span, "unknown-style", message)
        yield replace(found, suggestions=nearest(style, other.styles))


# ----------------------------------------------------------------------- redefinitions


def _redefinition(
    group: Group, index: int, item: ast.Item, name: str, by_file: dict[int, Group]
) -> Iterator[Diagnostic]:
    environment, owner, rest = group.environment, "", name
    while "." in rest:
        first, _, rest = rest.partition(".")
        if first in environment.broken:
            return
        if first not in environment.styles and first not in environment.imports:
            known = (*environment.imports, *environment.styles)
            message = f"no import or style is called `{first}`"
            found = group.diagnostic(index, _name_span(group, index), "unknown-symbol", message)
            yield replace(found, suggestions=nearest(first, known))
            return
        owner = f"{owner}.{first}" if owner else first
        environment = environment.imports.get(first, environment)
    if rest in environment.broken:
        return
    target = _Target(by_file[id(environment)], owner, rest)
    if isinstance(item, ast.Rule):
        yield from _rule(group, index, item, target)
    elif not isinstance(item, REPLACEABLE):
        message = f"{_kind(item)} of an import or style cannot be replaced"
        yield group.diagnostic(index, _name_span(group, index), "wrong-kind", message)
    else:
        yield from _value(group, index, item, target)


def _rule(group: Group, index: int, rule: ast.Rule, target: _Target) -> Iterator[Diagnostic]:
    """A rule takes the place of rules with as many parameters, of an asset, or of a terminal."""
    known = _symbols(target)
    arity, span = len(rule.head.parameters), rule.head.span
    arities = known.get(target.name)
    if arities is None and target.name in OPERATIONS:
        return
    if arities is None:
        message = f"`{target.owner}` has no symbol called `{target.name}` to replace"
        found = group.diagnostic(index, span, "nothing-to-replace", message)
        close = nearest(target.name, known)
        yield replace(found, suggestions=tuple(f"{target.owner}.{each}" for each in close))
    elif arity not in arities:
        taken = " or ".join(arguments((each, each)) for each in sorted(arities))
        message = f"`{target.name}` of `{target.owner}` takes {taken}, this rule {arity or 'none'}"
        yield group.diagnostic(index, span, "wrong-arguments", message)
    else:
        yield from _given(group, index, rule, target)


def _symbols(target: _Target) -> dict[str, set[int]]:
    """The symbols of a file with their numbers of arguments, those that nothing defines too."""
    found: dict[str, set[int]] = {}
    for name, entry in target.group.environment.symbols.items():
        arities = entry.arities | entry.interpreted
        found.setdefault(name, set()).update({0} if entry.kind == "asset" else arities)
    for findings in target.group.findings:
        for name, arity in findings.terminals:
            found.setdefault(name, set()).add(arity)
    return found


def _given(group: Group, index: int, rule: ast.Rule, target: _Target) -> Iterator[Diagnostic]:
    """What the calls of the replaced rule give must be what this one asks for."""
    asked = group.findings[index].parameters
    key = (target.name, len(rule.head.parameters))
    for findings in target.group.findings:
        for site in findings.calls.get(key, ()):
            for (name, kind), given in zip(asked, site.types, strict=False):
                if not fits(given, kind):
                    yield group.diagnostic(
                        index,
                        rule.head.span,
                        "wrong-type",
                        f"`{name}` of this rule must be {PHRASES[kind]}, and where "
                        f"`{target.name}` is called it is {PHRASES[given]}",
                    )
                    return


def _value(group: Group, index: int, item: ast.Item, target: _Target) -> Iterator[Diagnostic]:
    """A value takes the place of a value of its kind; an asset also that of a symbol."""
    before = target.group.environment.value(target.name)
    if isinstance(item, ast.Asset) and 0 in _symbols(target).get(target.name, ()):
        return
    if before is None:
        known = list(target.group.environment.values)
        message = f"`{target.owner}` has nothing called `{target.name}` to replace"
        found = group.diagnostic(index, _name_span(group, index), "nothing-to-replace", message)
        close = nearest(target.name, known)
        yield replace(found, suggestions=tuple(f"{target.owner}.{each}" for each in close))
    elif before.kind != _kind(item):
        kinds = f"is {article(before.kind)}, and this is {article(_kind(item))}"
        message = f"`{target.name}` of `{target.owner}` {kinds}"
        yield group.diagnostic(index, _name_span(group, index), "wrong-kind", message)
    else:
        yield from _unlike(group, index, item, target, before)


def _unlike(
    group: Group, index: int, item: ast.Item, target: _Target, before: ValueEntry
) -> Iterator[Diagnostic]:
    """A value of another type, a function of other parameters, a default out of range."""
    what = f"`{target.name}` of `{target.owner}`"
    found = group.findings[index].result
    original = target.group.file.grammar.items[before.item]
    if isinstance(item, ast.Function) and len(item.parameters) != len(before.parameters):
        number = len(before.parameters)
        message = f"{what} takes {arguments((number, number))}, here it has {len(item.parameters)}"
        yield group.diagnostic(index, _name_span(group, index), "wrong-arguments", message)
    elif isinstance(item, ast.Table):
        missing = [each for each in before.columns or () if each not in item.columns]
        if missing and item.reference is None:
            message = f"{what} has a column `{missing[0]}`, and this table has none"
            yield group.diagnostic(index, _name_span(group, index), "no-such-column", message)
    elif isinstance(item, ast.Field):
        yield from _other_context(group, index, item, original, what)
    elif not fits(found, before.type):
        message = f"{what} is {PHRASES[before.type]}, and this is {PHRASES[found]}"
        yield group.diagnostic(index, item.span, "wrong-type", message)
    elif isinstance(item, ast.Attr) and isinstance(original, ast.Attr) and item.allowed is None:
        yield from _out_of_range(group, index, item, original, what)


def _other_context(
    group: Group, index: int, item: ast.Field, original: ast.Item, what: str
) -> Iterator[Diagnostic]:
    """What is asked of a context must have an answer of the same kind in the one in its place."""
    assert isinstance(original, ast.Field)
    message = ""
    if (item.kind == "vector") != (original.kind == "vector"):
        kinds = (original.kind, item.kind)
        first, second = ("a vector field" if each == "vector" else "no vector" for each in kinds)
        message = f"{what} is {first}, and this is {second}"
    elif original.place is not None and item.place is None:
        message = f"{what} lies over a part of the ground, and this does not"
    if message:
        yield group.diagnostic(index, _name_span(group, index), "wrong-kind", message)


def _out_of_range(
    group: Group, index: int, item: ast.Attr, original: ast.Attr, what: str
) -> Iterator[Diagnostic]:
    value, allowed, told = constant(item.default), original.allowed, ""
    if isinstance(allowed, ast.Range) and value is not None:
        low = None if allowed.low is None else constant(allowed.low)
        high = None if allowed.high is None else constant(allowed.high)
        if low is not None and value < low:
            told = f"is at least {low:g}, and this is {value:g}"
        elif high is not None and value > high:
            told = f"is at most {high:g}, and this is {value:g}"
    elif isinstance(allowed, ast.Choices) and isinstance(item.default, ast.Number | ast.Text):
        told = "" if item.default in allowed.values else "has choices, and this is none of them"
    if told:
        hint = "give this one a range of its own: in …"
        yield group.diagnostic(
            index, item.default.span, "out-of-range", f"{what} {told}", hint=hint
        )


def _kind(item: ast.Item) -> str:
    return next(entry.kind for _, entry in values_of(item, 0))


def _name_span(group: Group, index: int) -> ast.Span:
    """The head of a rule; of another item what stands before its `=`."""
    item = group.file.grammar.items[index]
    if isinstance(item, ast.Rule):
        return item.head.span
    begin = group.file.grammar.offsets[index]
    end = group.file.source.text.find("=", begin + item.span.start, begin + item.span.end)
    return item.span if end < 0 else ast.Span(item.span.start, end - begin - 1)
