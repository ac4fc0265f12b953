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
from ipmlang.inverse.report import Report
from ipmlang.inverse.simplify import AXIOM, Book, drop_poor_rules, make_book, recentre
from ipmlang.inverse.terminals import Instanced, instance
from ipmlang.inverse.upright import make_upright

LIMIT = 1e-6  # of the diagonal: what every element must be given back within


@dataclass(frozen=True, slots=True, eq=False)
class Made:
    """A proven grammar; the report's `tokens` counts only what stands in tables of the parts."""

    grammar: ast.Grammar
    parts: str
    report: Report


def best_grammar(drawing: Drawing, stem: str, flat: bool, say: Callable[[str], None]) -> Made:
    """The shortest grammar that draws the drawing again."""
    say("looking for equal shapes")
    observed = observe(drawing)
    instanced = instance(observed)
    plain = Subject(observed, instanced, stem, use_tables=False)
    flat_book = make_book(instanced.alphabet, instanced.string)
    flat_file = write_grammar(flat_book, plain)
    flat_tokens = _tokens(flat_file)
    attempts: list[tuple[Book, Callable[[], Written]]] = []
    if not flat:
        say("looking for rules")
        book, string = _found(instanced, say)
        found = Subject(observed, replace(instanced, string=string), stem)
        shown = write_grammar(book, found)
        if _tokens(shown) <= flat_tokens:
            exact = replace(found, share=1e-12)
            attempts = [(book, lambda: shown), (book, lambda: write_grammar(book, exact))]
    attempts += [
        (flat_book, lambda: flat_file),
        (flat_book, lambda: write_grammar(
            flat_book, Subject(observed, instanced, stem, 1e-15, False))),
    ]  # fmt: skip
    say("deriving what was found")
    return _first_right(drawing, observed, attempts, stem, flat_tokens)


def _found(instanced: Instanced, say: Callable[[str], None]) -> tuple[Book, Arrangement]:
    """The simplified rules, and the string that is left."""
    search = Search(instanced.alphabet, instanced.seen, instanced.string, say)
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
    attempts: list[tuple[Book, Callable[[], Written]]],
    stem: str,
    flat_tokens: int,
) -> Made:
    """The first attempt whose derivation agrees with the drawing."""
    wrong: Comparison | None = None
    for book, write in attempts:
        written = write()
        parts = written.parts()
        try:
            comparison = prove(drawing, format_grammar(written.grammar), parts, stem)
        except IpmError:
            if write is attempts[-1][1]:
                raise
            continue
        if comparison.agrees(LIMIT):
            report = _report(observed, book, written, comparison, flat_tokens)
            return Made(written.grammar, parts, report)
        wrong = comparison
    assert wrong is not None
    raise fail(
        "not-given-back",
        f"no grammar draws this again within {LIMIT:g} of its diagonal: {wrong.missing} elements "
        f"missing, {wrong.style_differences} styled otherwise, error {wrong.max_error:.1e}",
        hint="this is a fault of ipmlang; please report the drawing",
    )


def _report(
    observed: Observation,
    book: Book,
    written: Written,
    comparison: Comparison,
    flat_tokens: int,
) -> Report:
    drawn = occurrences(book)
    rules = [rule for rule in (*book.bodies, *book.loops) if rule != AXIOM]
    axiom = book.bodies[AXIOM].parts
    under = [part for part in axiom.tolist() if part in book.bodies or part in book.family]
    explained = int(book.size[under].sum()) / max(1, len(observed)) if under else 0.0
    return Report(
        method="lsystem",
        elements=len(observed),
        explained=explained,
        rules=len(rules),
        rules_twice=sum(drawn[rule] > 1 for rule in rules),
        max_error=comparison.max_error,
        tokens=written.table_tokens,
        tokens_flat=flat_tokens,
        source_bytes=0,
        grammar_bytes=0,
        parts_bytes=0,
        seconds=0.0,
    )
