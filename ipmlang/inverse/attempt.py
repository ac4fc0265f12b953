"""The search for a grammar that is both shorter and right: propose, print, prove, fall back.

Takes a drawing; gives the shortest proven grammar of three attempts: the rules found, the same with
every digit, and one placement per element. Nothing is written to where the user works.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.formats.drawing import Drawing
from ipmlang.inverse.compare import Comparison
from ipmlang.inverse.grammar_file import Subject, Written, occurrences, write_grammar
from ipmlang.inverse.lsystem.rules import Search
from ipmlang.inverse.lsystem.symbols import Arrangement
from ipmlang.inverse.observation import Observation, observe
from ipmlang.inverse.prove import prove
from ipmlang.inverse.recursive_file import write_recursion
from ipmlang.inverse.report import Report
from ipmlang.inverse.simplify import AXIOM, Book, drop_poor_rules, make_book, recentre
from ipmlang.inverse.terminals import Instanced, grouped, instances
from ipmlang.inverse.upright import make_upright

LIMIT = 1e-6  # of the diagonal: what every element must be given back within


@dataclass(frozen=True, slots=True, eq=False)
class Made:
    """A proven grammar; the report's `tokens` counts only what stands in tables of the parts."""

    grammar: ast.Grammar
    parts: str
    report: Report


@dataclass(frozen=True, slots=True)
class Counts:
    """Rules, those used twice or more, and the share of elements under them."""

    rules: int
    twice: int
    explained: float


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """A file that could be the answer, and what it would take in tokens."""

    write: Callable[[], Written]
    counts: Counts
    tokens: int


def best_grammar(drawing: Drawing, stem: str, flat: bool, say: Callable[[str], None]) -> Made:
    """The shortest grammar that draws the drawing again."""
    say("looking for equal shapes")
    observed = observe(drawing)
    ways = instances(observed)
    alone = grouped(observed, ways[0], shared=False)
    plain = Subject(observed, alone, stem, use_tables=False)
    flat_book = make_book(alone.alphabet, alone.string)
    flat_file = write_grammar(flat_book, plain)
    flat_tokens = _tokens(flat_file)
    attempts: list[Attempt] = []
    if not flat:
        say("looking for recursion")
        attempts += _recursive(replace(plain, use_tables=True))
        say("looking for rules")
        every = [_searched(observed, way, stem, say) for way in ways]
        book, found, shown = min(every, key=lambda each: _tokens(each[2]))
        exact = replace(found, share=1e-12)
        counts = _counts(book, len(observed))
        attempts.append(Attempt(lambda: shown, counts, _tokens(shown)))
        attempts.append(Attempt(lambda: write_grammar(book, exact), counts, _tokens(shown)))
        attempts.sort(key=lambda each: each.tokens)
        attempts = [each for each in attempts if each.tokens <= flat_tokens]
    none = _counts(flat_book, len(observed))
    finest = replace(plain, share=1e-15)
    attempts.append(Attempt(lambda: flat_file, none, flat_tokens))
    attempts.append(Attempt(lambda: write_grammar(flat_book, finest), none, flat_tokens))
    say("deriving what was found")
    return _first_right(drawing, observed, attempts, stem, flat_tokens)


def _recursive(subject: Subject) -> list[Attempt]:
    """The file of a recursion that draws the drawing's lines, if there is one."""
    found = write_recursion(subject)
    if found is None:
        return []
    written, rules = found
    return [Attempt(lambda: written, Counts(rules, rules, 1.0), _tokens(written))]


def _searched(
    observed: Observation, way: Instanced, stem: str, say: Callable[[str], None]
) -> tuple[Book, Subject, Written]:
    """What is found when the drawing is seen in one way."""
    instanced = grouped(observed, way, shared=True)
    book, string = _found(instanced, say)
    subject = Subject(observed, replace(instanced, string=string), stem)
    return book, subject, write_grammar(book, subject)


def _found(instanced: Instanced, say: Callable[[str], None]) -> tuple[Book, Arrangement]:
    """The simplified rules, and the string that is left."""
    bodies = dict(instanced.bodies)
    search = Search(instanced.alphabet, instanced.seen, instanced.string, say, bodies)
    string = search.run()
    book = make_book(instanced.alphabet, string)
    drop_poor_rules(book)
    make_upright(book, instanced.alphabet)
    recentre(book)
    return book, string


def _tokens(written: Written) -> int:
    return count_text_tokens(format_grammar(written.grammar)) + written.table_tokens


def _first_right(
    drawing: Drawing,
    observed: Observation,
    attempts: list[Attempt],
    stem: str,
    flat_tokens: int,
) -> Made:
    """The first attempt whose derivation agrees with the drawing."""
    wrong: Comparison | None = None
    for attempt in attempts:
        written = attempt.write()
        parts = written.parts()
        try:
            comparison = prove(drawing, format_grammar(written.grammar), parts, stem)
        except IpmError:
            if attempt is attempts[-1]:
                raise
            continue
        if comparison.agrees(LIMIT):
            report = _report(observed, attempt.counts, written, comparison, flat_tokens)
            return Made(written.grammar, parts, report)
        wrong = comparison
    assert wrong is not None
    raise fail(
        "not-given-back",
        f"no grammar draws this again within {LIMIT:g} of its diagonal: {wrong.missing} elements "
        f"missing, {wrong.style_differences} styled otherwise, error {wrong.max_error:.1e}",
        hint="this is a fault of ipmlang; please report the drawing",
    )


def _explained(book: Book, rule: int) -> int:
    """How many elements of a body are drawn by rules, those of groups written out in it too."""
    inlined = book.inlined()
    total = 0
    for part in book.bodies[rule].parts.tolist():
        if part in inlined:
            total += _explained(book, part)
        elif part in book.bodies or part in book.family:
            total += int(book.size[part])
    return total


def _counts(book: Book, elements: int) -> Counts:
    drawn = occurrences(book)
    written = book.inlined() | {AXIOM}
    rules = [rule for rule in (*book.bodies, *book.loops) if rule not in written]
    explained = _explained(book, AXIOM) / max(1, elements)
    return Counts(len(rules), sum(drawn[rule] > 1 for rule in rules), explained)


def _report(
    observed: Observation,
    counts: Counts,
    written: Written,
    comparison: Comparison,
    flat_tokens: int,
) -> Report:
    return Report(
        method="lsystem",
        elements=len(observed),
        explained=counts.explained,
        rules=counts.rules,
        rules_twice=counts.twice,
        max_error=comparison.max_error,
        tokens=written.table_tokens,
        tokens_flat=flat_tokens,
        source_bytes=0,
        grammar_bytes=0,
        parts_bytes=0,
        seconds=0.0,
    )
