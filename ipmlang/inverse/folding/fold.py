"""Folds rules: stretches of rows that differ in numbers or symbols become one rule with parameters.

Takes printed rules; tries from several levels of detail, the largest rules written out or not, and
gives the shortest result by tokens. Nothing here fits numbers or prints rows.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.folding.book import Book, Covered, Stretch, read_book
from ipmlang.inverse.folding.candidates import FORM, KIND, Alike, candidates
from ipmlang.inverse.folding.fits import HEAD, Rounding
from ipmlang.inverse.folding.printing import PrintedTokens, printed, printed_tokens
from ipmlang.inverse.folding.progressions import RepeatTokens
from ipmlang.inverse.folding.rows import Row
from ipmlang.inverse.folding.templates import Template, best_template, rounding

# Stretches, kept so that no other row gets the number of theirs, the tokens that a template had to
# save, and the best that does.
Fitted: TypeAlias = "tuple[list[tuple[Row, ...]], int, tuple[Template, int] | None]"

LEAST = 6  # tokens that a rule must save
ROUNDS = 24  # in each of which rules are found that do not meet
ALIKE = 0.5  # of what the best rule of a round saves another one must save
TRIED = 24  # candidates of a round that are looked at closely
LEVELS = 6  # sizes above which rules are written out first
NAMED = 3  # levels at which symbols may be parameters, too: those that save most without
NEAR = 0.03  # of all tokens, by which such a level may be worse than the best one
MOST_ROWS = 3000  # rows among which stretches are looked for


@dataclass(frozen=True, slots=True)
class Folded:
    """Rules that draw the same, the axiom first; spared: tokens that they take less; loose: how
    many more terminals stand in the axiom itself; passed: rows that are too many to be folded.
    """

    rules: tuple[ast.Rule, ...]
    spared: int = 0
    loose: int = 0
    passed: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """What books of one folding have in common. fits: by how many stretches there are, and by the
    rows that are in them; names: of templates, so that stretches of calls of them are the same too.
    """

    fits: dict[tuple[int, ...], Fitted] = field(default_factory=dict)
    names: dict[int, str] = field(default_factory=dict)

    def name(self, template: Template, book: Book) -> str:
        """What the rule of a template is called in a book until it is printed."""
        name = self.names.setdefault(id(template), f"<{len(self.names)}>")
        while name in book.plain or name in book.templates:
            name += "'"
        return name


def fold(rules: Sequence[ast.Rule], error: float, taken: Set[str]) -> Folded:
    """The shortest of what folding finds; error: units, what a number may be off; taken: names
    that rules and parameters may not have.
    """
    given, known = rounding(error), Known()
    first = read_book(rules, given)
    if first.length() > MOST_ROWS:
        return Folded(tuple(rules), passed=first.length())
    before, loose = printed_tokens(rules), first.loose()
    counted = PrintedTokens(RepeatTokens(first.known, first.leaving))
    best: tuple[int, Book | None] = 0, None

    def folded(book: Book, alike: Sequence[Alike]) -> int:
        nonlocal best
        _merge(book, given, known, before - best[0], alike)
        spared = before - counted.of(book)
        best = max(best, (spared, book), key=_spared)
        return spared

    found: list[tuple[int, Book]] = []
    for book in _levels(first):
        if book.length() > MOST_ROWS:
            break
        found.append((folded(book.copy(), (KIND,)), book))
    found.sort(key=lambda each: -each[0])
    for spared, book in found[:NAMED]:
        near = spared >= found[0][0] - NEAR * before
        if near and any(each.given.count for _, each in _best(book, given, known, (FORM,))):
            folded(book, (KIND, FORM))
    spared, made = best
    if made is None:
        return Folded(tuple(rules))
    return Folded(printed(made, given, taken), spared, made.loose() - loose)


def _spared(found: tuple[int, Book | None]) -> int:
    return found[0]


def _levels(book: Book) -> Iterator[Book]:
    """The book as it is, then with its largest rules written out, then smaller ones too."""
    yield book.copy()
    sizes = _sizes(book)
    sizes = {name: size for name, size in sizes.items() if not book.stays(name)}
    distinct = sorted(set(sizes.values()), reverse=True)
    steps = np.unique(np.linspace(0, len(distinct) - 1, LEVELS).astype(int)) if distinct else ()
    for step in steps:
        level = book.copy()
        large = [name for name, size in sizes.items() if size >= distinct[step]]
        level.write_out(large)
        yield level


def _sizes(book: Book) -> dict[str, int]:
    """How many terminals and fixed rules each plain rule draws."""
    sizes: dict[str, int] = {}
    for name in book.inmost_first():
        sizes[name] = sum(sizes.get(part, 1) * often for part, often in book.parts_of(name).items())
    return sizes


def _merge(
    book: Book, given: Rounding, known: Known, least: int, alike: Sequence[Alike] = (KIND,)
) -> None:
    """Put the stretches that save most into rules, round by round, as long as there is hope to come
    below the least tokens known: most is saved in the first rounds.
    """
    for done in range(ROUNDS):
        if done and book.tokens() > least * (1 + 1 / (1 + done)):
            break
        found = _best(book, given, known, alike)
        put: dict[Stretch, Row] = {}
        touched: set[str] = set()
        for stretches, template in found:
            name = known.name(template, book)
            wish = _wish(book, stretches, template)
            put |= zip(stretches, template.call_rows(name), strict=True)
            touched |= {name, *(each.rule for each in stretches)}
            touched |= {row.name for row in template.rows}
            book.add(name, template, wish)
        if not found:
            break
        book.put(put)
        _write_out_poor(book, touched)


def _best(
    book: Book, given: Rounding, known: Known, alike: Sequence[Alike]
) -> list[tuple[list[Stretch], Template]]:
    """The stretches that save most as one rule, and others that save hardly less elsewhere."""

    def fitted(stretches: list[Stretch], needed: int) -> tuple[Template, int] | None:
        rows = [book.rows_at(each) for each in stretches]
        return _fitted(rows, given, known, needed, book.leaving)

    found: list[_Saving] = []
    best, waiting = _Best(), list[tuple[int, list[Stretch], _Best]]()
    tried = [each for same in alike for each in candidates(book, TRIED, same)]
    tried.sort(key=lambda each: -each[0])
    for order, (bound, stretches) in enumerate(tried):
        if bound < best.most * ALIKE:
            break
        # What meets the best one is out, unless it is better itself, or something else is.
        meets = best.covered.meets(stretches)
        made = fitted(stretches, max(best.needed, best.saved if meets else 0))
        if made is not None:
            found.append(_Saving(-made[1], order, stretches, made[0]))
            best = best if made[1] <= best.saved else _Best(made[1], stretches)
        elif meets:
            waiting.append((order, stretches, best))
    for order, stretches, former in waiting:
        made = fitted(stretches, best.needed) if former is not best else None
        if made is not None:
            found.append(_Saving(-made[1], order, stretches, made[0]))
    return _apart(found, best)


@dataclass(frozen=True, order=True, slots=True)
class _Saving:
    """Tokens that some stretches cost as one rule, less than nothing; order: in which they were
    tried.
    """

    cost: int
    order: int
    stretches: list[Stretch] = field(compare=False)
    template: Template = field(compare=False)


class _Best:
    """What saves most so far."""

    def __init__(self, saved: int = 0, stretches: Sequence[Stretch] = ()) -> None:
        self.saved, self.covered = saved, Covered()
        self.covered.add(stretches)

    @property
    def most(self) -> float:
        """What it saves, or is thought to at least."""
        return max(self.saved, LEAST / ALIKE)

    @property
    def needed(self) -> int:
        """Tokens that something else must save."""
        return max(LEAST, math.ceil(self.most * ALIKE))


def _apart(found: list[_Saving], best: _Best) -> list[tuple[list[Stretch], Template]]:
    """Those that save enough and do not meet one that saves more."""
    chosen: list[tuple[list[Stretch], Template]] = []
    covered = Covered()
    for each in sorted(found):
        if -each.cost >= best.most * ALIKE and not covered.meets(each.stretches):
            chosen.append((each.stretches, each.template))
            covered.add(each.stretches)
    return chosen


def _fitted(
    stretches: list[tuple[Row, ...]],
    given: Rounding,
    known: Known,
    needed: int,
    leaving: Set[str],
) -> tuple[Template, int] | None:
    """The template of some stretches that saves the tokens needed, looked for once."""
    key = (len(stretches), *(id(row) for rows in stretches for row in rows))
    _, least, found = known.fits.get(key, (stretches, needed + 1, None))
    if found is None and needed < least:
        found = best_template(stretches, given, needed, leaving)
        known.fits[key] = stretches, needed, found
    return found if found is not None and found[1] >= needed else None


def _wish(book: Book, stretches: Sequence[Stretch], template: Template) -> str:
    """A name for the rule of these stretches: of the rule that most of it stood in before."""
    first = stretches[0]
    if len(book.plain[first.rule]) == first.count and not first.path and first.rule != book.axiom:
        return book.wishes.get(first.rule, first.rule)
    origins = Counter(row.origin for row in template.rows if row.origin)
    most = origins.most_common(1)[0][0] if origins else ""
    return book.wishes.get(most, most)


def _write_out_poor(book: Book, names: Set[str]) -> None:
    """Write out those of some rules that no longer save enough."""
    calls = book.calls()
    for name in [name for name in book.inmost_first() if name in names]:
        if name in book.plain and _excess(book, name, calls.of(name)) > -LEAST:
            book.write_out([name])
            calls = book.calls()


def _excess(book: Book, name: str, calls: Sequence[Row] | None) -> int:
    """Tokens that a rule adds to those of what it says where it is called."""
    rows = book.plain[name]
    if calls is None or book.stays(name):
        return -LEAST
    cost = HEAD + sum(row.tokens for row in (*calls, *rows))
    if len(calls) * len(rows) >= cost + LEAST:
        return -LEAST
    return cost - sum(row.tokens for own in book.known.written_out(calls, rows) for row in own)
