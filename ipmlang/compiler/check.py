"""From loaded files to `Checked`: every error of every file, each at its place.

Each item is checked by itself and remembered together with what it looked up; after an edit only
items that changed, or that looked up something that changed, are checked again. What items say
together is checked anew each time, in time linear in their number. Nothing is read or written here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache as remember
from typing import TypeAlias

from ipmlang.compiler import ast, collector
from ipmlang.compiler.checked import (
    Checked,
    NotReady,
    SymbolEntry,
    SymbolUse,
    ValueEntry,
)
from ipmlang.compiler.checking.endless import (
    Edges,
    check_endless,
    check_values,
    edges_of,
    endless,
    endless_in_styles,
)
from ipmlang.compiler.checking.environment import Environment, declare
from ipmlang.compiler.checking.findings import Findings, Key
from ipmlang.compiler.checking.groups import Group, check_groups
from ipmlang.compiler.checking.items import check_item, entry_of
from ipmlang.compiler.checking.nearby import glued, near_misses
from ipmlang.compiler.checking.queries import check_asked, given_by
from ipmlang.compiler.checking.redefinitions import check_styles
from ipmlang.compiler.checking.taking import Taken, check_symbols, given_terminals, taken_by
from ipmlang.compiler.diagnostics import Diagnostic, Label
from ipmlang.compiler.load import Loaded
from ipmlang.compiler.ops import OPERATIONS

_Names: TypeAlias = tuple[
    Mapping[str, ValueEntry], Mapping[str, SymbolEntry], frozenset[str], bool, list[int]
]


@dataclass(slots=True, eq=False)
class Cache:
    """What checking remembers: findings by item (kept alive, so that its identity stays its own),
    the names around them, and the last graph of calls. It holds items of the last two checks: of
    what an edit makes, and of what it begins with again.
    """

    findings: dict[int, tuple[ast.Item, Findings]] = field(default_factory=dict)
    before: dict[int, tuple[ast.Item, Findings]] = field(default_factory=dict)
    names: dict[str, list[_Names]] = field(default_factory=dict)
    graph: tuple[Edges, frozenset[Key]] = ((), frozenset())


@remember
def shared_cache() -> Cache:
    """The cache of this process, which is what checking takes when none is given."""
    return Cache()


def check(loaded: Loaded, cache: Cache | None = None) -> Checked:
    """Check a grammar: all that is wrong is in the diagnostics, nothing is raised."""
    with collector.held():
        return _check(loaded, cache or shared_cache())


def _check(loaded: Loaded, cache: Cache) -> Checked:
    groups = _groups(loaded, cache)
    given = given_by(groups)
    taken = taken_by(groups)
    diagnostics: list[Diagnostic] = []
    for number, group in enumerate(groups):
        found = [*group.file.problems, *_item_troubles(group)]
        found += check_groups(group, main=number == 0)
        found += check_symbols(group, taken)
        found += check_values(group)
        found += check_asked(group, given)
        found += check_styles(group, groups)
        found += _near_misses(group, taken)
        if number == 0:
            found += _endless(group, cache)
        diagnostics += sorted(found, key=lambda each: (each.start, each.end))
    return Checked(
        loaded,
        {
            group.file.prefix + name: entry
            for group in groups
            for name, entry in group.environment.values.items()
        },
        {(use.name, use.arity): use for group in groups for use in _symbols(group, taken)},
        tuple(_not_ready(groups)),
        tuple(diagnostics),
    )


# ------------------------------------------------------------------- findings by item


def _groups(loaded: Loaded, cache: Cache) -> list[Group]:
    environments = {id(file): Environment(file, entry_of) for file in loaded.files}
    for file in loaded.files:
        environment = environments[id(file)]
        environment.imports = {
            name: environments[id(other)] for name, other in file.imports.items()
        }
        declare(environment)
    kept: dict[int, tuple[ast.Item, Findings]] = {}
    names: dict[str, list[_Names]] = {}
    groups = []
    for file in loaded.files:
        environment = environments[id(file)]
        around = _names_around(environment)
        names[file.source.path] = around
        same = cache.names.get(file.source.path) == around
        findings = [_findings(environment, item, cache, kept, same) for item in file.grammar.items]
        groups.append(Group(file, findings, environment))
    cache.before, cache.findings, cache.names = cache.findings, kept, names
    return groups


def _names_around(environment: Environment) -> list[_Names]:
    """All that an item of a file can look up: the names of the files it reaches, and which items
    define their values.
    """
    reached = [environment]
    for each in reached:
        reached += [other for other in each.imports.values() if other not in reached]
    return [
        (
            dict(each.values),
            each.symbols,
            frozenset(each.imports) | each.styles,
            each.steps,
            [id(item) for _, item in each.others],
        )
        for each in reached
    ]


def _findings(
    environment: Environment,
    item: ast.Item,
    cache: Cache,
    kept: dict[int, tuple[ast.Item, Findings]],
    same: bool,
) -> Findings:
    number = id(item)
    known = kept.get(number) or cache.findings.get(number) or cache.before.get(number)
    if known is not None and known[0] is item and _holds(environment, known[1], same):
        kept[id(item)] = known
        return known[1]
    found = check_item(environment, item)
    kept[id(item)] = (item, found)
    return found


def _holds(environment: Environment, findings: Findings, same: bool) -> bool:
    """Whether all that was looked up for an item still has the same answer. When the `same` names
    stand around it, only files can have changed.
    """
    if same:
        questions = [("reference", name) for name in findings.references]
        return all(environment.answer(*each) == findings.answers[each] for each in questions)
    for (kind, name), answer in findings.answers.items():
        now = environment.answer(kind, name)
        if now is not answer and now != answer:
            return False
    return True


def _item_troubles(group: Group) -> Iterator[Diagnostic]:
    source = group.file.source
    for index, findings in enumerate(group.findings):
        offset = group.file.grammar.offsets[index] if findings.troubles else 0
        for trouble in findings.troubles:
            labels = tuple(
                Label(offset + label.start, offset + label.end, label.message)
                for label in trouble.labels
            )
            yield replace(
                trouble,
                source=source,
                start=offset + trouble.start,
                end=offset + trouble.end,
                labels=labels,
            )


def _not_ready(groups: list[Group]) -> Iterator[NotReady]:
    for group in groups:
        for index, findings in enumerate(group.findings):
            for name, span in findings.not_ready:
                offset = group.file.grammar.offsets[index]
                yield NotReady(name, group.file.source, offset + span.start, offset + span.end)


# ----------------------------------------------------------------------- all together


def _near_misses(group: Group, taken: Taken) -> Iterator[Diagnostic]:
    """Warnings for terminals whose name is one letter off a known one, or several run together."""
    places: dict[str, tuple[int, ast.Span]] = {}
    for index, findings in enumerate(group.findings):
        for (name, _), span in findings.terminals.items():
            places.setdefault(name, (index, span))
    for (name, _), place in given_terminals(group, taken).items():
        places.setdefault(name, place)
    known = {*group.environment.symbols, *OPERATIONS} if places else set()
    for name, other in near_misses(places, known).items():
        index, span = places[name]
        kind = "the operation" if other in OPERATIONS else "the symbol"
        found = group.diagnostic(
            index,
            ast.Span(span.start, span.start + len(name)),
            "near-miss",
            f"no rule or asset is called `{name}`, it draws itself; "
            f"{kind} `{other}` is one letter away",
            warning=True,
        )
        yield replace(found, suggestions=(other,))
    for name, written in glued(places, known).items():
        index, span = places[name]
        found = group.diagnostic(
            index,
            ast.Span(span.start, span.start + len(name)),
            "near-miss",
            f"no rule or asset is called `{name}`, it draws itself; "
            "symbols next to each other need blanks",
            warning=True,
        )
        yield replace(found, suggestions=(written,))


def _endless(group: Group, cache: Cache) -> Iterator[Diagnostic]:
    if group.environment.steps:
        return
    edges = edges_of(group)
    if cache.graph[0] != edges:
        cache.graph = (edges, endless(edges))
    if cache.graph[1]:
        first = {
            (name, arity): places[0]
            for (name, arity, interpret), places in group.environment.rules.items()
            if not interpret
        }
        yield from check_endless(group, cache.graph[1], first)
    yield from endless_in_styles(group, cache.graph[1])


def _symbols(group: Group, taken: Taken) -> Iterator[SymbolUse]:
    prefix = group.file.prefix
    for name, entry in group.environment.symbols.items():
        arities = (entry.arities | entry.interpreted) if entry.kind != "asset" else {0}
        for arity in arities:
            yield SymbolUse(prefix + name, arity, entry.kind)
    told: set[Key] = set()
    for findings in group.findings:
        for key in findings.terminals.keys() - told:
            told.add(key)
            yield SymbolUse(prefix + key[0], key[1], "terminal")
    for key in given_terminals(group, taken).keys() - told:
        yield SymbolUse(prefix + key[0], key[1], "terminal")
