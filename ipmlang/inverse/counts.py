"""How much of a drawing rules explain: how many there are, and what share of elements they draw.

Takes a book of rules and what is written of it; gives numbers for reports and for choosing among
grammars. Nothing here prints or proves.
"""

from __future__ import annotations

from dataclasses import dataclass

from ipmlang.inverse.grammar_file import Written, occurrences
from ipmlang.inverse.simplify import AXIOM, Book


@dataclass(frozen=True, slots=True)
class Counts:
    """Rules, those used twice or more, and the share of elements under them."""

    rules: int
    twice: int
    explained: float


def _drawn_by_rules(book: Book, rule: int) -> int:
    """How many elements of a body are drawn by rules, those of groups written out in it too."""
    total, waiting = 0, [rule]
    inlined, structures = book.inlined(), set(book.rules())
    while waiting:
        for part, rows in book.bodies[waiting.pop()].rows.items():
            if part in inlined:
                waiting += [part] * len(rows)
            elif part in structures or part in book.family:
                total += int(book.size[part]) * len(rows)
    return total


def counts_of(book: Book, elements: int) -> Counts:
    """Of the rules that a book has, those written out where they stand left aside."""
    drawn = occurrences(book)
    written = book.inlined() | {AXIOM}
    rules = [rule for rule in book.rules() if rule not in written]
    explained = _drawn_by_rules(book, AXIOM) / max(1, elements)
    return Counts(len(rules), sum(drawn[rule] > 1 for rule in rules), explained)


def gridded(counts: Counts, written: Written, elements: int) -> Counts:
    """With tables on grids as rules, whose cells are elements at least."""
    grids, cells = written.gridded
    explained = min(1.0, counts.explained + cells / max(1, elements))
    return Counts(counts.rules + len(grids), counts.twice, explained)
