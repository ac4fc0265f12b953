"""A drawing seen in one way, and the search for rules in it.

Takes an observation; gives every way to see it as terminals, and for each the rules that a search
finds, simplified and printed. Searches of one drawing tell each other what they looked for: the
strings of those that begin with lattices, where there are none, are those that begin without.
Which of them is the answer is decided elsewhere, and nothing here is proven.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ipmlang.formats.drawing import Drawing
from ipmlang.inverse.aliases import drop_aliases
from ipmlang.inverse.baselines import settle_baselines
from ipmlang.inverse.boards import Block
from ipmlang.inverse.grammar_file import Subject, Written, write_grammar
from ipmlang.inverse.lattices.choice import with_lattices
from ipmlang.inverse.lattices.find import Memory
from ipmlang.inverse.lattices.spared import Said, layers_weight, said
from ipmlang.inverse.lsystem.curves import moved
from ipmlang.inverse.lsystem.fits import Fits
from ipmlang.inverse.lsystem.importance import Measure
from ipmlang.inverse.lsystem.journal import Journal
from ipmlang.inverse.lsystem.rules import Search
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers, joined
from ipmlang.inverse.lsystem.trees import TreeSearch
from ipmlang.inverse.observation import Observation
from ipmlang.inverse.options import Options
from ipmlang.inverse.scattered import Scattered, with_scattered
from ipmlang.inverse.shared_places import share_places
from ipmlang.inverse.simplify import Book, drop_poor_rules, make_book, recentre
from ipmlang.inverse.tapers import complete_tapers
from ipmlang.inverse.terminals import Instanced, grouped, instances
from ipmlang.inverse.tolerances import Tolerances
from ipmlang.inverse.upright import make_upright, settle_terminals

ROOM = 100.0  # tokens by which what groups and lattices spare may be thought too little
MOST_SCATTERED = 6000  # symbols among which lattices are looked for


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """What is to be given back, how exactly, and what a person asked for."""

    drawing: Drawing
    observed: Observation
    stem: str
    options: Options
    given: Tolerances


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """What a search found, and the file that says it."""

    book: Book
    subject: Subject
    written: Written
    journal: Journal


@dataclass(slots=True, eq=False)
class Way:
    """A way to see the drawing, runs under effects as symbols. left: the symbols and the string
    that a search without lattices left, once there was one; found: what it made of them; groups:
    the alphabet and the string with the groups in any order among them, once these were looked for.
    """

    instanced: Instanced
    left: tuple[Alphabet, Arrangement, Journal] | None = None
    found: Found | None = None
    groups: tuple[Alphabet, Arrangement, Scattered] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Memories:
    """What searches of one drawing tell each other: trees, patterns and lattices that were looked
    for.
    """

    trees: TreeSearch = field(default_factory=TreeSearch)
    fits: Fits = field(default_factory=Fits)
    lattices: Memory = field(default_factory=dict)


def ways_to_see(goal: Goal) -> list[Instanced]:
    """Every way to see the drawing as terminals, with the tolerance of the search."""
    ways = instances(goal.observed)
    for way in ways:
        way.alphabet.tolerance = goal.given.search * goal.observed.diagonal
    return ways


def with_runs(goal: Goal, ways: list[Instanced]) -> list[Way]:
    """The ways with the runs under each effect as symbols."""
    return [Way(grouped(goal.observed, way, shared=True)) for way in ways]


def searched(goal: Goal, way: Way, say: Callable[[str], None], known: Memories) -> Found:
    """What is found when the drawing is seen in one way."""
    instanced = _copied(way.instanced)
    string, journal = _run(goal, instanced, instanced.string, say, known)
    if not goal.options.explain:
        way.left = _copied(instanced).alphabet, string, journal
    string = _with_lattices(goal, instanced, string, journal, known, scattered=False)
    way.found = _printed(goal, instanced, string, journal)
    return way.found


def searched_regular(
    goal: Goal, way: Way, say: Callable[[str], None], known: Memories
) -> Found | None:
    """What is found with lattices before other rules, and with groups in any order; None where
    neither are.
    """
    instanced = _copied(way.instanced)
    # A table of the whole paint order pays only where lattices explain much: if they come first.
    scattered = not instanced.effects
    # Where somebody asks for what is regular it need not be short.
    rival = None if goal.options.symmetrize else _rival(way, scattered)
    regular = with_lattices(instanced.alphabet, instanced.string, scattered, known.lattices, rival)
    if len(instanced.alphabet) > len(way.instanced.alphabet) or way.left is None:
        string, journal = _run(goal, instanced, regular, say, known)
    elif rival is not None and rival.needed > rival.least:
        return None
    else:
        alphabet, string, journal = way.left
        instanced = _copied(replace(instanced, alphabet=alphabet))
    string = _with_lattices(goal, instanced, string, journal, known, scattered)
    made = []
    if any(each.lattice is not None for each in instanced.alphabet.definitions):
        made.append(_printed(goal, instanced, string, journal))
    if scattered and len(string) <= MOST_SCATTERED and not goal.options.paper:
        instanced, string, groups = _with_groups(way, instanced, string)
        if groups:
            made.append(_printed(goal, instanced, string, journal, groups))
    if goal.options.symmetrize:  # for what is regular, not what is short
        return made[-1] if made else None
    return min(made, key=lambda each: each.written.weight, default=None)


def beside_blocks(goal: Goal, way: Way, blocks: Sequence[Block]) -> tuple[Book, Subject] | None:
    """What a search found of all that stands in no block of the axiom, with the members of blocks
    one by one; None where nothing is left of it.
    """
    if way.left is None:
        return None
    alphabet, string, _ = way.left
    taken = np.zeros(len(way.instanced.seen.terminal), np.bool_)
    for block in blocks:
        taken[block.start : block.stop] = True
    before = np.concatenate([[0], np.cumsum(taken)])
    sizes = np.array([each.size for each in alphabet.definitions], np.int64)
    stop = string.start + sizes[string.symbol]
    kept = string[before[stop] == before[string.start]]
    alone = way.instanced.string
    left = alone[~np.isin(alone.start, _elements(kept, sizes))]
    if not (sizes[kept.symbol] > sizes[alone.symbol].max(initial=1)).any():
        return None
    mixed = joined([kept, left])
    mixed = mixed[np.argsort(mixed.start, kind="stable")]
    instanced = _copied(replace(way.instanced, alphabet=alphabet, string=mixed))
    book = _simplified(goal, instanced, mixed, Scattered())
    return book, Subject(goal.observed, instanced, goal.stem, goal.given.rounding)


def _elements(string: Arrangement, sizes: Integers) -> Integers:
    """The elements that a string draws; sizes: of every symbol."""
    often = sizes[string.symbol]
    first = np.repeat(string.start - (np.cumsum(often) - often), often)
    return np.asarray(first + np.arange(len(first)))


def _rival(way: Way, scattered: bool) -> Said | None:
    """What a search without lattices says. If another paint order takes a table of all elements,
    lattices must pay for what groups in any order do not.
    """
    if way.left is None or way.found is None:
        return None
    alphabet, string, _ = way.left
    count, weight = len(way.instanced.seen.terminal), way.found.written.weight
    needed = layers_weight(count) - ROOM
    if scattered:
        known = Alphabet(alphabet.tolerance, list(alphabet.definitions))
        grouped_string, groups = with_scattered(known, string)
        way.groups = known, grouped_string, groups
        needed = -1.0 if groups and not groups.layered else needed - groups.spared
    return said(alphabet, string, count, weight, needed)


def _with_groups(
    way: Way, instanced: Instanced, string: Arrangement
) -> tuple[Instanced, Arrangement, Scattered]:
    """What a search left with groups in any order, which are known where it left what one without
    lattices did.
    """
    if way.left is not None and way.groups is not None and string is way.left[1]:
        alphabet, string, groups = way.groups
        return replace(instanced, alphabet=alphabet), string, groups
    instanced = _copied(instanced)
    return instanced, *with_scattered(instanced.alphabet, string)


def _with_lattices(
    goal: Goal,
    instanced: Instanced,
    string: Arrangement,
    journal: Journal,
    known: Memories,
    scattered: bool,
) -> Arrangement:
    """The string that a search left, with lattices of what it found."""
    if len(string) > MOST_SCATTERED or goal.options.paper:
        return string
    made = with_lattices(instanced.alphabet, string, scattered, known.lattices)
    _noting(goal, instanced, string, journal).note_lattices(made)
    return made


def _printed(
    goal: Goal,
    instanced: Instanced,
    string: Arrangement,
    journal: Journal,
    groups: Scattered | None = None,
) -> Found:
    """A string that a search left, simplified and printed."""
    book = _simplified(goal, instanced, string, groups or Scattered())
    instanced = replace(instanced, string=string)
    subject = Subject(goal.observed, instanced, goal.stem, goal.given.rounding)
    return Found(book, subject, write_grammar(book, subject), journal)


def _copied(instanced: Instanced) -> Instanced:
    """With an alphabet that a search may add to."""
    alphabet = instanced.alphabet
    return replace(instanced, alphabet=Alphabet(alphabet.tolerance, list(alphabet.definitions)))


def _run(
    goal: Goal,
    instanced: Instanced,
    regular: Arrangement,
    say: Callable[[str], None],
    known: Memories,
) -> tuple[Arrangement, Journal]:
    """The string that a search leaves, and its journal; regular: what it begins with."""
    search = _noting(goal, instanced, instanced.string, Journal())
    search.progress, search.trees, search.fits = say, known.trees, known.fits
    search.note_lattices(regular)
    search.string = regular
    return search.run(), search.journal


def _noting(goal: Goal, instanced: Instanced, string: Arrangement, journal: Journal) -> Search:
    """A search of a string that notes in a journal what it finds."""
    search = Search(
        instanced.alphabet,
        instanced.seen,
        string,
        bodies=dict(instanced.bodies),
        options=goal.options,
        journal=journal,
    )
    search.measure = _measure(instanced, goal)
    return search


def _measure(instanced: Instanced, goal: Goal) -> Measure | None:
    """What measures clusters, where somebody asks for it."""
    if goal.options.weights.neutral and not (goal.options.explain or goal.options.paper):
        return None
    outlines = [
        None if each.shape.outline is None else moved(each.shape.outline, each.base)
        for each in instanced.terminals
    ]
    return Measure(outlines, goal.observed.diagonal)


def _simplified(goal: Goal, instanced: Instanced, string: Arrangement, groups: Scattered) -> Book:
    """The rules that the string needs, the poor ones written out."""
    book = make_book(instanced.alphabet, string)
    book.scattered, book.shift = dict(groups.ranks), {**goal.observed.shift, **groups.shift}
    if goal.options.paper:
        book.drop_unused()
    else:
        drop_poor_rules(book)
    complete_tapers(book, instanced.alphabet)
    make_upright(book, instanced.alphabet)
    recentre(book)
    drop_aliases(book)
    share_places(book, instanced.alphabet)
    settle_baselines(book, instanced.alphabet)
    settle_terminals(book, instanced.alphabet)
    return book
