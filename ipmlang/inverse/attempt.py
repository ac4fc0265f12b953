"""The search for a grammar that is both shorter and right: propose, print, prove, fall back.

Takes a drawing; gives the shortest proven grammar of three attempts: the rules found, the same with
every digit, and one placement per element. Nothing is written to where the user works.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.compiler.format import format_grammar
from ipmlang.formats.drawing import Drawing
from ipmlang.inverse.boards import Block, Formulas, with_boards, with_figures, with_labels
from ipmlang.inverse.coats import merged_styles
from ipmlang.inverse.compare import Comparison
from ipmlang.inverse.counts import Counts, counts_of, gridded
from ipmlang.inverse.curves import with_curves
from ipmlang.inverse.deviations import rule_errors
from ipmlang.inverse.explanation import Explanation, explain, printed_names
from ipmlang.inverse.folding import MOST_ROWS, rules_drawn
from ipmlang.inverse.grammar_file import (
    Subject,
    Written,
    symbol_names,
    write_grammar,
)
from ipmlang.inverse.options import USUAL, Options
from ipmlang.inverse.pages import Page
from ipmlang.inverse.prove import prove
from ipmlang.inverse.recursive_file import write_recursion
from ipmlang.inverse.report import Report, RuleError
from ipmlang.inverse.simplify import AXIOM, Book, make_book
from ipmlang.inverse.stretches import are_few
from ipmlang.inverse.terminals import grouped, with_stretched_lines
from ipmlang.inverse.tolerances import relaxed, seen
from ipmlang.inverse.unrounded import Unrounded, seen_before
from ipmlang.inverse.ways import (
    MOST_SCATTERED,
    Found,
    Goal,
    Memories,
    Way,
    beside_blocks,
    searched,
    searched_regular,
    ways_to_see,
    with_runs,
)

LEAST_REGULAR = 0.3  # of the flat tokens: what is shorter needs no other look
ROW = 2  # tokens that a row of a table counts for beyond those it takes: rules can be changed
LEFT = 4  # placements of one symbol that a lattice could say
TWINS = 3  # elements of several symbols placed twice that a group could say
AS_SHORT = 1.01  # times as many tokens rules with parameters may take that spare fewer tables
NOISE_TOKENS = 1.5  # times as many tokens a regular grammar with residuals may have
SHORT = 0.1  # of the flat tokens: a recursion that no other rules will beat
MOST = 0.9  # of the elements in irregular blocks make these all that there is to say
FEW = 600  # elements for which a second look costs hardly any time


@dataclass(frozen=True, slots=True, eq=False)
class Made:
    """A proven grammar; the report's `tokens` counts only what stands in tables of the parts."""

    grammar: ast.Grammar
    parts: str
    report: Report
    explanation: Explanation | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """A file that could be the answer, in a word how it was found, what it takes in tokens, and for
    how many more it counts, since a person would rather maintain something else; for less, where it
    says the points of outlines that the other files keep among the parts; final: nothing shorter is
    to be expected.
    """

    name: str
    write: Callable[[], Written]
    counts: Counts
    tokens: int
    more: float = 0.0
    final: bool = False

    @property
    def spared(self) -> float:
        """Numbers of terminals that need not be kept."""
        return max(0.0, -self.more)


@dataclass(slots=True, eq=False)
class _Blocks:
    """Files with blocks of the drawing seen without rules, the boards in them, and the formulas of
    these, which are those of most boards beside rules.
    """

    attempts: list[Attempt] = field(default_factory=list)
    boards: list[Block] = field(default_factory=list)
    formulas: Formulas = field(default_factory=dict)


def best_grammar(
    drawing: Drawing,
    stem: str,
    flat: bool,
    say: Callable[[str], None],
    options: Options = USUAL,
    before: Unrounded | None = None,
) -> Made:
    """The shortest grammar that draws the drawing again. before: the drawing before its points were
    rounded, in which rules are looked for.
    """
    say("looking for equal shapes")
    observed, given = seen(drawing, options) if before is None else seen_before(before, options)
    goal = Goal(drawing, observed, stem, options, given)
    ways = ways_to_see(goal)
    alone = grouped(observed, ways[0], shared=False)
    plain = Subject(observed, alone, stem, given.rounding, use_tables=False)
    flat_book = make_book(alone.alphabet, alone.string)
    flat_file = write_grammar(flat_book, plain)
    flat_tokens, none = flat_file.tokens, counts_of(flat_book, len(observed))
    if options.similarity < 1:
        goal = _ideal(goal, flat_file)
    attempts: list[Attempt] = []
    found: Found | None = None
    if not flat:
        say("looking for recursion")
        attempts += _recursive(replace(plain, use_tables=True))
        exact = options.mode == "exact" and not (options.paper or attempts)
        lines = bool(attempts)
        known = _blocks(plain) if exact else _Blocks()
        blocks = known.attempts
        clear = len(observed) > FEW or any(each.final for each in blocks)
        if clear and not (options.explain or options.paper):
            made = _clearly(goal, [*attempts, *blocks], flat_tokens)
            if made is not None:
                return made
        say("looking for rules")
        # Where a recursion draws everything, no other way to see its lines is worth the time.
        seen_so, memory = with_runs(goal, ways[:1] if lines else ways), Memories()
        tried = [searched(goal, way, say, memory) for way in seen_so]
        found = min(tried, key=lambda each: each.written.ruled)
        folded = [] if options.paper else _folded(found, len(observed))
        shortest = min([found.written.ruled, *(each.tokens + each.more for each in folded)])
        enough = LEAST_REGULAR if len(observed) > FEW else LEAST_REGULAR / 2
        irregular = shortest > enough * flat_tokens and _may_be_regular(found.book)
        if irregular and len(observed) <= MOST_SCATTERED and not attempts:
            say("looking for lattices")
            again = [searched_regular(goal, way, say, memory) for way in seen_so]
            bent = [each for each in again if each is not None and _bends_order(each.book)]
            regular = _better(found, bent, options.symmetrize)
            if regular is not found:
                folded = [each for each in folded if _beats(each, regular, options.symmetrize)]
                found, folded = regular, [*folded, *_folded(regular, len(observed))]
        if blocks and not options.symmetrize:
            blocks += _beside_boards(goal, known, plain, seen_so[0])
        asked = options.paper or options.symmetrize
        attempts += blocks + folded + _written_out(found, len(observed))
        if not (_bends_order(found.book) or asked):
            # Few rules among many loose placements may cost more than they save: tables say less.
            tabled = write_grammar(flat_book, replace(plain, use_tables=True))
            attempts.append(_tables(tabled, len(observed), found.written.named))
        attempts.sort(key=lambda each: each.tokens + each.more)
        # The paper's pairs, and rows that noise and paint order make long, are what was asked for.
        if not (asked or _weighs_less(found, flat_file)):
            attempts = [each for each in attempts if each.tokens <= flat_tokens + each.spared]
    finest = replace(plain, share=1e-15)
    attempts.append(Attempt("flat", lambda: flat_file, none, flat_tokens))
    attempts.append(Attempt("flat", lambda: write_grammar(flat_book, finest), none, flat_tokens))
    say("deriving what was found")
    return _first_right(goal, attempts, found, flat_tokens)


def _may_be_regular(book: Book) -> bool:
    """Whether the axiom places one symbol so often that a lattice could say it, a sequence of any
    length being one, or so much of several symbols twice that a group could.
    """
    parts = book.bodies[AXIOM].parts.tolist()
    often = Counter(book.family.get(part, part) for part in parts)
    if max(often.values(), default=0) >= LEFT:
        return True
    twice = {part for part in parts if often[book.family.get(part, part)] > 1}
    drawn = {book.family.get(part, part): int(book.extent[part]) for part in twice}
    return len(drawn) > 1 and sum(drawn.values()) >= TWINS


def _better(found: Found, regular: list[Found], symmetrize: bool) -> Found:
    """What is found, or the best of what begins with lattices: by the weight of its numbers, since
    residuals have few digits, but never for many more tokens; where what is regular is asked for,
    by what rules explain.
    """
    most = NOISE_TOKENS * found.written.ruled + 40
    better = [found, *(each for each in regular if each.written.ruled <= most)]
    elements = len(found.subject.observed)
    ruled = {id(each): counts_of(each.book, elements).explained for each in better}
    if symmetrize:
        return min(better, key=lambda each: (-round(ruled[id(each)], 2), each.written.weight))
    return min(better, key=lambda each: each.written.weight)


def _weighs_less(found: Found, flat: Written) -> bool:
    """Whether lattices with residuals of few digits say less than placements of many, though in no
    fewer numbers.
    """
    return _bends_order(found.book) and found.written.weight <= flat.weight


def _bends_order(book: Book) -> bool:
    """Whether rules explain what noise and the paint order hide, at the price of a table."""
    return bool(book.lattices or book.scattered)


def _ideal(goal: Goal, flat: Written) -> Goal:
    """With as much room for the proof as similar shapes need, each left in its place."""
    given = goal.given
    alone = prove(goal.drawing, flat.text, flat.parts(), goal.stem, 2 * given.proof)
    proof = max(given.proof, alone.max_error * (1 + 1e-6) + relaxed(goal.options.within or 0).proof)
    return replace(goal, given=replace(given, proof=proof))


def _beats(attempt: Attempt, regular: Found, symmetrize: bool) -> bool:
    """Whether rules with parameters weigh less than what begins with lattices."""
    return not symmetrize and attempt.write().weight < regular.written.weight


def _written_out(found: Found, elements: int) -> list[Attempt]:
    """The rules as they are printed, and with every digit."""
    book, exact = found.book, replace(found.subject, share=1e-12)
    tokens = found.written.tokens
    counts = gridded(counts_of(book, elements), found.written, elements)
    return [
        Attempt("rules", lambda: found.written, counts, tokens, found.written.spared),
        Attempt("rules", lambda: write_grammar(book, exact), counts, tokens, found.written.spared),
    ]


def _folded(found: Found, elements: int) -> list[Attempt]:
    """The rules with parameters, where that is shorter."""
    subject = replace(found.subject, folded=True)
    written = write_grammar(found.book, subject, found.written.draft)
    if written.folded is not None and written.folded.passed:
        found.journal.note(
            f"rules with parameters were not looked for among {written.folded.passed:,} "
            f"placements, which are more than {MOST_ROWS:,}"
        )
    if written.folded is None or written.ruled >= found.written.ruled:
        return []
    if written.tokens > AS_SHORT * found.written.tokens:
        return []
    counts = counts_of(found.book, elements)
    drawn = rules_drawn(written.folded.rules).values()
    explained = counts.explained - written.folded.loose / max(1, elements)
    own = Counts(len(drawn), sum(often > 1 for often in drawn), explained)
    return [Attempt("rules", lambda: written, own, written.tokens, written.spared)]


def _tables(written: Written, elements: int, named: int) -> Attempt:
    """Tables alone; what stands on grids is explained by them, but not shorter for naming nothing;
    named: tokens of the attributes that rules have.
    """
    counts = gridded(Counts(0, 0, 0.0), written, elements)
    more = written.spared + ROW * written.rows + (named if written.gridded[0] else 0)
    return Attempt("tables", lambda: written, counts, written.tokens, more)


def _recursive(subject: Subject) -> list[Attempt]:
    """The file of a recursion that draws the drawing's lines, if there is one. What it draws of
    outlines need not stand in the parts file: the numbers of their points are spared.
    """
    found = write_recursion(subject)
    if found is None:
        return []
    written, counts = found.written, Counts(found.rules, found.rules, 1.0)
    return [Attempt("recursion", lambda: written, counts, written.tokens, -found.numbers)]


def _blocks(plain: Subject) -> _Blocks:
    """The files with things of all sizes on grids, and with figures of all lengths, if there are
    such.
    """
    observed, made = plain.observed, _Blocks()
    book = make_book(plain.instanced.alphabet, plain.instanced.string)
    made.boards = _boards(book, plain, made.formulas)
    if made.boards:
        made.attempts.append(_of_blocks("boards", book, made.boards, plain))
    stretched = with_stretched_lines(observed)
    if stretched is None:
        return made
    lines = replace(plain, instanced=grouped(observed, stretched, shared=False))
    book = make_book(lines.instanced.alphabet, lines.instanced.string)
    figures = with_figures(book, stretched.terminals, observed.diagonal)
    if figures:
        made.attempts.append(_of_blocks("figures", book, figures, lines))
    return made


def _boards(book: Book, subject: Subject, known: Formulas) -> list[Block]:
    """Labelled things, and things of all sizes on grids, in the axiom of a book; known: as for
    `with_boards`.
    """
    terminals, diagonal = subject.instanced.terminals, subject.observed.diagonal
    bound = set(merged_styles(book, terminals))
    labelled = with_labels(book, len(terminals), bound | book.inlined(), diagonal)
    bound |= {part for each in labelled for part in each.symbols}
    return [*labelled, *with_boards(book, terminals, bound, diagonal, known)]


def _beside_boards(goal: Goal, known: _Blocks, plain: Subject, way: Way) -> list[Attempt]:
    """The file with things of all sizes on grids, and rules for what stands beside these, if there
    are both.
    """
    whole = len(plain.instanced.string) == len(goal.observed)  # else rows are no elements
    made = beside_blocks(goal, way, known.boards) if known.boards and whole else None
    if made is None:
        return []
    book, subject = made
    counts = counts_of(book, len(goal.observed))
    blocks = _boards(book, subject, known.formulas)
    if len(blocks) < len(known.boards):  # a rule has bound what stands on one
        return []
    attempt = _of_blocks("boards", book, blocks, subject)
    both = Counts(
        counts.rules + attempt.counts.rules,
        counts.twice + attempt.counts.twice,
        counts.explained + attempt.counts.explained,
    )
    return [replace(attempt, counts=both)]


def _of_blocks(name: str, book: Book, blocks: Sequence[Block], subject: Subject) -> Attempt:
    """The file of a book with blocks; final: where one is most of the drawing and no rule's."""
    elements = len(subject.observed)
    book.boards = {each.start: each for each in blocks}
    written = write_grammar(book, replace(subject, use_tables=True))
    explained = min(1.0, written.gridded[1] / max(1, elements))
    uneven = sum(each.stop - each.start for each in blocks if each.irregular)
    more = written.spared + ROW * written.rows
    counts = Counts(len(blocks), len(blocks), explained)
    return Attempt(name, lambda: written, counts, written.tokens, more, uneven > MOST * elements)


def _clearly(goal: Goal, attempts: list[Attempt], flat_tokens: int) -> Made | None:
    """A recursion so short, or blocks so irregular, that no other rules need to be looked for, if
    they are right.
    """
    most = SHORT * flat_tokens
    short = [each for each in attempts if each.final or each.tokens <= most + SHORT * each.spared]
    if not short:
        return None
    try:
        return _first_right(goal, short, None, flat_tokens)
    except IpmError:  # what is wrong is tried among the others, which say so
        return None


def _first_right(
    goal: Goal, attempts: list[Attempt], found: Found | None, flat_tokens: int
) -> Made:
    """The first attempt whose derivation agrees with the drawing."""
    wrong: Comparison | None = None
    limit = goal.given.proof
    for attempt in attempts:
        written = attempt.write()
        parts = written.parts()
        try:
            comparison = prove(goal.drawing, written.text, parts, goal.stem, limit)
        except IpmError:
            if attempt is attempts[-1]:
                raise
            continue
        if comparison.agrees(limit):
            flat = flat_tokens + round(attempt.spared)
            report = _report(goal, attempt, written, comparison, flat)
            if found is not None:
                report = replace(report, notes=found.journal.notes)
            if found is not None and attempt.name == "rules" and goal.options.mode != "exact":
                report = replace(report, rule_errors=_rule_errors(found))
            explained = None if found is None else _explanation(goal, found, attempts, attempt)
            made = Made(written.grammar, parts, report, explained)
            only_flat = found is None and attempt.name == "flat"
            tried = not any(each.name == "recursion" for each in attempts)
            return made if only_flat else _curved(goal, written, made, tried)
        wrong = comparison
    assert wrong is not None
    raise fail(
        "not-given-back",
        f"no grammar draws this again within {limit:g} of its diagonal: {wrong.missing} elements "
        f"missing, {wrong.style_differences} styled otherwise, error {wrong.max_error:.1e}",
        hint="this is a fault of ipmlang; please report the drawing",
    )


def _curved(goal: Goal, written: Written, made: Made, tried: bool) -> Made:
    """With rules for the assets that turtles drew, where these give the drawing back. tried: no
    recursion was found, so that in a small drawing there is none for what stands there once.
    """
    tried = tried and are_few(goal.observed)
    observed = goal.observed
    page = Page(observed.diagonal, observed.flip, observed.box is not None)
    curved = with_curves(written, page, tried)
    if curved is None:
        return made
    limit = goal.given.proof
    comparison = prove(goal.drawing, format_grammar(curved.grammar), curved.parts, goal.stem, limit)
    if not comparison.agrees(limit):
        return made
    more = curved.elements / max(1, len(goal.observed))
    report = replace(
        made.report,
        explained=min(1.0, made.report.explained + more),
        rules=made.report.rules + curved.rules,
        rules_twice=made.report.rules_twice + curved.rules,
        tokens_flat=made.report.tokens_flat + curved.numbers,
        max_error=comparison.max_error,
    )
    return replace(made, grammar=curved.grammar, parts=curved.parts, report=report)


def _rule_errors(found: Found) -> tuple[RuleError, ...]:
    instanced = found.subject.instanced
    names = symbol_names(found.book, found.subject)
    diagonal = found.subject.observed.diagonal
    return rule_errors(instanced.alphabet, instanced.seen, instanced.string, names, diagonal)


def _explanation(
    goal: Goal, found: Found, attempts: list[Attempt], chosen: Attempt
) -> Explanation | None:
    if not goal.options.explain:
        return None
    tokens = {each.name: each.tokens for each in attempts}
    given = symbol_names(found.book, found.subject)
    there = printed_names(chosen.write().grammar)  # folding and tables leave some rules out
    names = {symbol: name for symbol, name in given.items() if name in there}
    alphabet = found.subject.instanced.alphabet
    return explain(found.journal, alphabet, names, tuple(tokens.items()), chosen.name)


def _report(
    goal: Goal, attempt: Attempt, written: Written, comparison: Comparison, flat_tokens: int
) -> Report:
    counts = attempt.counts
    return Report(
        method="lsystem",
        elements=len(goal.observed),
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
        mode=goal.options.mode,
        limit=goal.given.proof,
    )
