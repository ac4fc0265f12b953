"""What several items say together: definitions, the rules of one symbol, the start and the version.

In go the items of one file with their findings, out come diagnostics with places in the file. Each
function here takes one look over all items and is linear in their number.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass

from ipmlang.compiler import ast
from ipmlang.compiler.checking.environment import Environment, values_of
from ipmlang.compiler.checking.expressions import constant
from ipmlang.compiler.checking.findings import Findings, Key
from ipmlang.compiler.diagnostics import Diagnostic, Label
from ipmlang.compiler.load import File
from ipmlang.compiler.ops.record import ValueType
from ipmlang.compiler.types import PHRASES, fits


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """A file's items with their findings."""

    file: File
    findings: Sequence[Findings]
    environment: Environment

    def diagnostic(
        self,
        index: int,
        span: ast.Span,
        code: str,
        message: str,
        *,
        warning: bool = False,
        hint: str | None = None,
        other: tuple[int, ast.Span, str] | None = None,
    ) -> Diagnostic:
        """A diagnostic at a place of an item; `other` is a place of another item."""
        offsets = self.file.grammar.offsets
        labels: tuple[Label, ...] = ()
        if other is not None:
            labels = (
                Label(
                    offsets[other[0]] + other[1].start, offsets[other[0]] + other[1].end, other[2]
                ),
            )
        return Diagnostic(
            code,
            message,
            "warning" if warning else "error",
            self.file.source,
            offsets[index] + span.start,
            offsets[index] + span.end,
            hint=hint,
            labels=labels,
        )


def check_groups(group: Group, main: bool) -> Iterator[Diagnostic]:
    """All that the items of a file say together."""
    yield from _definitions(group)
    yield from _versions(group)
    if main:
        yield from _starts(group)
    for places in group.environment.rules.values():
        if len(places) > 1:
            yield from _alternatives(group, places)
    yield from _argument_types(group)


# ------------------------------------------------------------------------ definitions


def _definitions(group: Group) -> Iterator[Diagnostic]:
    first: dict[str, int] = {}
    for index, item in group.environment.others:
        for name, _ in values_of(item, index):
            if name in first:
                yield _twice(group, index, first[name], name)
            first.setdefault(name, index)
    for (name, _, _), places in group.environment.rules.items():
        entry = group.environment.values.get(name)
        if entry is not None and entry.kind == "asset":
            yield group.diagnostic(
                places[0],
                _head(group, places[0]),
                "duplicate-name",
                f"`{name}` is an asset, and cannot have rules too",
                other=(first[name], _place(group, first[name]), "the asset"),
            )


def _twice(group: Group, index: int, first: int, name: str) -> Diagnostic:
    return group.diagnostic(
        index,
        _place(group, index),
        "duplicate-name",
        f"`{name}` is defined twice",
        other=(first, _place(group, first), "defined here first"),
    )


def _place(group: Group, index: int) -> ast.Span:
    """The first line of an item."""
    span = group.file.grammar.items[index].span
    begin = group.file.grammar.offsets[index]
    end = group.file.source.text.find("\n", begin + span.start, begin + span.end)
    return span if end < 0 else ast.Span(span.start, end - begin)


def _head(group: Group, index: int) -> ast.Span:
    rule = group.file.grammar.items[index]
    assert isinstance(rule, ast.Rule)
    return rule.head.span


def _versions(group: Group) -> Iterator[Diagnostic]:
    items = group.file.grammar.items
    versions = [
        (index, item) for index, item in group.environment.others if isinstance(item, ast.Version)
    ]
    for index, item in versions:
        if index > 0:
            twice = isinstance(items[0], ast.Version)
            message = (
                "the language version is given twice"
                if twice
                else ("the language version must stand first")
            )
            yield group.diagnostic(index, item.span, "misplaced-version", message)
    if items and not versions:
        yield group.diagnostic(
            0,
            _place(group, 0),
            "no-version",
            "this file does not say its language version",
            warning=True,
            hint="write `ipm 1` as the first line",
        )


def _starts(group: Group) -> Iterator[Diagnostic]:
    yield from _seconds(group, ast.Residual, "residual")
    starts = yield from _seconds(group, ast.Start, "start")
    if not starts and not group.file.problems:
        end = len(group.file.source.text.rstrip())
        yield Diagnostic(
            "no-start",
            "nothing says where to start",
            "error",
            group.file.source,
            end,
            end,
            hint="add a line such as: start Fence",
        )


def _seconds(
    group: Group, kind: type[ast.Item], word: str
) -> Generator[Diagnostic, None, list[int]]:
    """All items of a kind of which there is one, an error at each but the first."""
    found = [index for index, item in group.environment.others if isinstance(item, kind)]
    for index in found[1:]:
        yield group.diagnostic(
            index,
            _place(group, index),
            f"two-{word}s",
            f"a grammar has one `{word}`, this is another",
            other=(found[0], _place(group, found[0]), "the first"),
        )
    return found


# ----------------------------------------------------------------- rules of one symbol


def _alternatives(group: Group, places: Sequence[int]) -> Iterator[Diagnostic]:
    rules = [
        (index, rule)
        for index in places
        if isinstance(rule := group.file.grammar.items[index], ast.Rule)
    ]
    yield from _unreachable(group, rules)
    yield from _chances(group, rules)


_Rules = Sequence[tuple[int, ast.Rule]]


def _unreachable(group: Group, rules: _Rules) -> Iterator[Diagnostic]:
    """Alternatives after one that is always taken, for the same context."""
    always: dict[tuple[object, object], tuple[int, ast.Rule]] = {}
    for index, rule in rules:
        context = (rule.head.left, rule.head.right)
        taken = always.get(context) or always.get((None, None))
        if taken is not None:
            otherwise = isinstance(taken[1].guard, ast.Otherwise)
            why = "after `else`" if otherwise else "after one that is always taken"
            yield group.diagnostic(
                index,
                rule.head.span,
                "unreachable-rule",
                f"this rule for `{rule.head.name}` stands {why}, and is never reached",
                other=(taken[0], taken[1].head.span, "this one is taken"),
                hint="put the rule that is always taken last",
            )
        elif _is_always(rule):
            always[context] = (index, rule)


def _is_always(rule: ast.Rule) -> bool:
    if rule.chance is not None:
        percent = rule.chance.kind == "percent" and rule.guard is None
        return percent and constant(rule.chance.value) == 100.0
    match rule.guard:
        case None | ast.Otherwise():
            return True
        case ast.Truth(value):
            return value
        case _:
            return False


def _chances(group: Group, rules: _Rules) -> Iterator[Diagnostic]:
    kinds: dict[str, tuple[int, ast.Rule]] = {}
    total, over = 0.0, False
    for index, rule in rules:
        if rule.chance is None:
            continue
        kinds.setdefault(rule.chance.kind, (index, rule))
        if len(kinds) == 2 and kinds[rule.chance.kind][0] == index:
            first = next(iter(kinds.values()))
            assert first[1].chance is not None
            yield group.diagnostic(
                index,
                rule.chance.span,
                "mixed-chances",
                f"the rules for `{rule.head.name}` mix percentages and weights",
                other=(first[0], first[1].chance.span, "the other kind"),
                hint="use one kind for all rules of a symbol",
            )
        if (
            rule.chance.kind != "percent"
            or rule.guard is not None
            or rule.head.left
            or (rule.head.right)
        ):
            continue
        total += constant(rule.chance.value) or 0.0
        if total > 100.0 + 1e-9 and not over:
            over = True
            yield group.diagnostic(
                index,
                rule.chance.span,
                "over-100-percent",
                f"the percentages of `{rule.head.name}` sum to {total:g}",
                hint="they must not sum to more than 100",
            )


# ------------------------------------------------------------------ types of arguments


def _argument_types(group: Group) -> Iterator[Diagnostic]:
    """Arguments that cannot be what the body of a rule asks of its parameters."""
    asked = _asked(group)
    odd = asked.keys()
    for index, findings in enumerate(group.findings):
        if not findings.odd and (not odd or findings.calls.keys().isdisjoint(odd)):
            continue
        for key in sorted(findings.odd | (findings.calls.keys() & odd)):
            parameters = asked.get(key) or _parameters(group, key)
            for site in findings.calls[key]:
                for (name, kind), given in zip(parameters, site.types, strict=False):
                    if "symbol" in (kind, given):  # what takes symbols is not known here
                        continue
                    if not fits(given, kind):
                        yield group.diagnostic(
                            index,
                            site.span,
                            "wrong-type",
                            f"`{name}` of `{key[0]}` must be {PHRASES[kind]}, and this "
                            f"call gives {PHRASES[given]}",
                        )


_Parameters = tuple[tuple[str, ValueType], ...]


def _asked(group: Group) -> dict[Key, _Parameters]:
    """For each symbol one of whose parameters must be something else than a number, its parameters
    with the types asked of them.
    """
    found: dict[Key, _Parameters] = {}
    for index, findings in enumerate(group.findings):
        item = group.file.grammar.items[index] if findings.asks else None
        if isinstance(item, ast.Rule):
            key = (item.head.name, len(item.head.parameters))
            found[key] = _parameters(group, key)
    return found


def _parameters(group: Group, key: Key) -> _Parameters:
    """The parameters of a symbol with the types that its rules ask of them."""
    found: _Parameters = ()
    for interpret in (False, True):
        for index in group.environment.rules.get((*key, interpret), ()):
            later = group.findings[index].parameters
            found = (
                later
                if not found
                else tuple(
                    one if one[1] != "any" else other
                    for one, other in zip(found, later, strict=True)
                )
            )
    return found
