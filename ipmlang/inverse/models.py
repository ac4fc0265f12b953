"""From a model to the grammar that a person would have written: observe, search, print, prove.

Takes a path; gives a grammar, its parts file and a report. What is found is derived and compared
with the file before it is returned: where a rule or a rounding is at fault, more digits and plainer
schemes are tried. Nothing is written.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import fail
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.formats import FormatError
from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh_types import Mesh, moved
from ipmlang.formats.numbers import decimals_for
from ipmlang.inverse.drawings import unreadable
from ipmlang.inverse.found import Found
from ipmlang.inverse.frames import Frames, canonical, compose, identity, inverse, matrices
from ipmlang.inverse.naming import capital, word
from ipmlang.inverse.options import Options
from ipmlang.inverse.parts.observation import Parts
from ipmlang.inverse.report import Report, counted
from ipmlang.inverse.split.changing import without_wraps
from ipmlang.inverse.split.comparison import Difference
from ipmlang.inverse.split.cost import ASSET, SHAPE, scheme_tokens
from ipmlang.inverse.split.explained import count_explained
from ipmlang.inverse.split.facades.homes import at_home
from ipmlang.inverse.split.measuring import reaches
from ipmlang.inverse.split.parts_file import PartsFile, parts_name, write_parts
from ipmlang.inverse.split.placing import Precision, placed_tokens
from ipmlang.inverse.split.printing.grammar import print_scheme
from ipmlang.inverse.split.proof import prove
from ipmlang.inverse.split.rows import risen
from ipmlang.inverse.split.scheme import Place, Rule, Scheme, Terminal
from ipmlang.inverse.split.search.assembly import flat

LIMIT = 1e-6  # share of the diagonal that any corner may be off
ALIKE = 0.7  # share of the limit that equal parts may differ by; the rest is for rounding
NOTHING = 1e-7  # share of the diagonal that does not count
ROUNDINGS = (0.15, 0.03, 0.0003)  # shares of the limit that a number may be rounded by, in turn
HOPE = 2.0  # times a rounding that an error beyond the limit may be due to it
LISTED, ROW = 12, 2  # tokens that a table, and a row of it, count for beyond those they take
MOST_AT_HOME = 20  # tokens of a placement that a terminal's own coordinates may save
Up = Literal["auto", "y", "z"]


@dataclass(frozen=True, slots=True, eq=False)
class _Goal:
    """What is to be given back. limit: share of the diagonal that it may be off; axiom: a wish;
    most: tokens of one placement per part, which no grammar may be longer than; said: what was
    printed already.
    """

    parts: Parts
    source: Mesh
    limit: float
    stem: str
    axiom: str
    most: int = sys.maxsize
    said: dict[tuple[Scheme, float, bool], _Said] = field(default_factory=dict)


def grammar_of_model(
    path: Path, stem: str, is_flat: bool, up: Up, say: Callable[[str], None], options: Options
) -> Found:
    """The shortest proven grammar of a model. IpmError where there is nothing to infer from."""
    limit = LIMIT if options.within is None else max(options.within, LIMIT)
    parts, source = observed(path, up, limit)
    _check_parts(path, parts)
    say(f"looking for rules among {len(parts.shape)} components")
    goal = _Goal(parts, source, limit, stem, capital(word(path.stem)) or "Building")
    plain = flat(parts)
    goal = replace(goal, most=_tokens_singly(goal, plain))
    schemes = iter([plain]) if is_flat else _searched(goal, plain, options)
    say("comparing with the model")
    for scheme in schemes:
        for rounding in ROUNDINGS:
            grammar, file = _written(goal, scheme, rounding, is_flat)
            text = format_grammar(grammar)
            if scheme is not plain and count_text_tokens(text) > goal.most:
                break
            difference = prove(source, text, file, stem, limit * parts.diagonal)
            if difference.none:
                told = _said(goal, scheme, rounding, is_flat)
                report = _report(goal, scheme, difference, options, told)
                report = replace(report, tokens_flat=goal.most)
                return Found(grammar, file.content, file.suffix, report)
            if difference.error > (1 + HOPE * rounding) * limit * parts.diagonal:
                break
    raise fail(
        "not-proven",
        f"no grammar was found that gives {path.name} back within {limit:g} of its diagonal",
        hint="--within 1e-5 allows more",
    )


def _searched(goal: _Goal, plain: Scheme, options: Options) -> Iterator[Scheme]:
    """The schemes that options ask for, in the order in which they are tried: the best first, then
    what takes fewer liberties or says less.
    """
    parts = goal.parts
    small = NOTHING * parts.diagonal
    if options.paper:
        from ipmlang.inverse.split.paper.raw_form import raw_form

        yield raw_form(parts, small)
        yield plain
        return
    from ipmlang.inverse.split.facades.splitting import as_splits
    from ipmlang.inverse.split.pairing import paired

    for found in _found_by_search(goal, small):
        if _shorter(goal, found, plain, small):
            joined = paired(found, small)
            split = as_splits(joined, small)
            if split is not joined:
                yield paired(split, small)
            yield joined
    yield plain


def _found_by_search(goal: _Goal, small: float) -> Iterator[Scheme]:
    """The schemes of a search; where shapes stand in several sizes or materials, the first of
    another search, in which they are one shape, before or after the first.
    """
    from ipmlang.inverse.parts.scaling import as_one
    from ipmlang.inverse.split.dressing import dressed
    from ipmlang.inverse.split.search.drafts import Limits
    from ipmlang.inverse.split.search.patterns import Memory
    from ipmlang.inverse.split.search.resizing import in_other_materials, promising
    from ipmlang.inverse.split.search.shortest import schemes
    from ipmlang.inverse.split.separating import separated

    parts, bound = goal.parts, goal.limit * goal.parts.diagonal
    memories: dict[float, Memory] = {}
    found = schemes(parts, bound, memories=memories)
    first = [risen(next(found))]
    likely = promising(parts, bound)
    if likely:
        resized = next(schemes(as_one(parts, likely), bound, memories=memories))
        first.append(risen(separated(resized, parts, small)))
    first.sort(key=lambda each: _length(goal, each))
    colors = in_other_materials(parts, bound)
    if colors:
        bare = next(schemes(as_one(parts, colors), bound, memories=memories))
        worn = dressed(bare, parts, colors, Limits(bound, small), Memory())
        if worn is not None and _text(goal, risen(worn)) < min(_text(goal, x) for x in first):
            first.insert(0, risen(worn))
    yield from first
    yield from map(risen, found)


def _shorter(goal: _Goal, found: Scheme, plain: Scheme, small: float) -> bool:
    """Whether a scheme is shorter than the plain one when both are printed; where it is by far,
    the plain one is not printed.
    """
    at_least = scheme_tokens(plain, small) - MOST_AT_HOME * len(goal.parts.classes)
    if 2 * scheme_tokens(found, small) < at_least:
        return True
    length = _length(goal, found)
    return length < at_least or length < _length(goal, plain)


def _length(goal: _Goal, scheme: Scheme) -> int:
    """The tokens of a scheme's text, but for those that all have, and more for what tables list and
    for shapes: of two that are about as long, the one that explains more is the better one.
    """
    said = _said(goal, scheme, ROUNDINGS[0], False)
    listed = [len(item.rows) for item in said.items if isinstance(item, ast.Table)]
    shapes = (ASSET + SHAPE) * len(said.terminals)
    return said.tokens + LISTED * len(listed) + ROW * sum(listed) + shapes


def _text(goal: _Goal, scheme: Scheme) -> int:
    """The tokens of a scheme's text, but for those that all have."""
    return _said(goal, scheme, ROUNDINGS[0], False).tokens


def _tokens_singly(goal: _Goal, plain: Scheme) -> int:
    """Tokens of the plain scheme with every placement written out: one is, the others counted."""
    parts, rule = goal.parts, plain.symbols[plain.axiom]
    assert isinstance(rule, Rule)
    precision = Precision(ROUNDINGS[0] * goal.limit * parts.diagonal)
    places = [item for item in rule.items if isinstance(item, Place)]
    reach = reaches(replace(plain, symbols=plain.symbols[:-1])).tolist()
    tokens = [placed_tokens(item.frames, precision, reach[item.symbol]) for item in places]
    first = replace(rule, items=(replace(places[0], frames=places[0].frames[:1]),))
    shorter = replace(plain, symbols=(*plain.symbols[:-1], first))
    one = _newly_said(goal, shorter, ROUNDINGS[0], one_by_one=True)
    return _all_tokens(goal, one) + sum(int(each.sum()) for each in tokens) - int(tokens[0][0])


def _tokens(items: Sequence[ast.Item]) -> int:
    return count_text_tokens(format_grammar(ast.Grammar(tuple(items))))


def _all_tokens(goal: _Goal, said: _Said) -> int:
    """With what all grammars of models begin with."""
    return _tokens(_head(goal, said, ".obj")) + said.tokens


def observed(path: Path, up: Up, limit: float) -> tuple[Parts, Mesh]:
    """The parts of a model in its own axes, and all its faces as they were read, z up."""
    from ipmlang.inverse.parts import observe_with_faces

    try:
        return observe_with_faces(
            path, up=up, within=ALIKE * limit, same_triangles=True, own_axes=True
        )
    except FormatError as error:
        raise unreadable(path, error) from error


def _check_parts(path: Path, parts: Parts) -> None:
    """Refuse what has no components to tell apart: there is nothing that a split could say."""
    if len(parts.shape) == 1:
        raise fail(
            "one-piece",
            f"{path.name} is one connected piece of {counted(parts.triangles, 'triangle')}: there "
            "are no components that a grammar could place",
            hint="what repeats within a surface is found by docking, which is not there yet",
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Said:
    """A scheme as items of a grammar, with the meshes of its terminals by name; rules: how many
    there are besides the axiom's; tokens: of the items; families: symbols that are one rule.
    """

    items: tuple[ast.Item, ...]
    terminals: dict[str, Mesh]
    rules: int
    tokens: int
    families: tuple[tuple[int, ...], ...] = ()


def _said(goal: _Goal, scheme: Scheme, rounding: float, one_by_one: bool) -> _Said:
    """The rules of a scheme, which are printed once for each rounding."""
    key = (scheme, rounding, one_by_one)
    if key not in goal.said:
        goal.said[key] = _newly_said(goal, *key)
    return goal.said[key]


def _newly_said(goal: _Goal, scheme: Scheme, rounding: float, one_by_one: bool) -> _Said:
    parts, room = goal.parts, rounding * goal.limit
    homes: dict[int, Frames] = {}
    if not one_by_one:
        scheme, homes = at_home(scheme, NOTHING * parts.diagonal)
        scheme = without_wraps(scheme, NOTHING * parts.diagonal)
    scheme = replace(scheme, frame=compose(_askew(parts.turn), scheme.frame))
    meshes = {
        number: _at_home(_drawn(parts, symbol), homes.get(number))
        for number, symbol in enumerate(scheme.symbols)
        if isinstance(symbol, Terminal)
    }

    def said(lift: bool) -> _Said:
        precision = Precision(room * parts.diagonal)
        printed = print_scheme(scheme, goal.axiom, precision, one_by_one, lift)
        terminals = {printed.names[number]: mesh for number, mesh in meshes.items()}
        length = _tokens(printed.items)
        return _Said(printed.items, terminals, printed.rules, length, printed.families)

    with_counts = said(lift=True)
    return said(lift=False) if _all_tokens(goal, with_counts) > goal.most else with_counts


def _askew(degrees: float) -> Frames:
    """One frame that turns about the vertical."""
    half = np.radians(degrees) / 2
    turn = np.array([[np.cos(half), 0.0, 0.0, np.sin(half)]])
    return replace(identity(), rotation=canonical(turn))


def _drawn(parts: Parts, terminal: Terminal) -> Mesh:
    """The faces of a terminal in its own coordinates."""
    return moved(parts.classes[terminal.part].mesh, matrices(inverse(terminal.pose))[0])


def _at_home(mesh: Mesh, home: Frames | None) -> Mesh:
    return mesh if home is None else moved(mesh, matrices(home)[0])


def _written(
    goal: _Goal, scheme: Scheme, rounding: float, one_by_one: bool
) -> tuple[ast.Grammar, PartsFile]:
    """The grammar of a scheme and the file of its terminals."""
    said = _said(goal, scheme, rounding, one_by_one)
    room = rounding * goal.limit
    file = write_parts(said.terminals, decimals_for(goal.parts.diagonal, 4 * room))
    return _grammar(goal, said, file.suffix), file


def _grammar(goal: _Goal, said: _Said, suffix: str) -> ast.Grammar:
    """What was said, after what all grammars of models begin with."""
    return ast.Grammar((*_head(goal, said, suffix), *said.items))


def _head(goal: _Goal, said: _Said, suffix: str) -> tuple[ast.Item, ...]:
    """What all grammars of models begin with."""
    asset = ast.Asset(tuple(said.terminals), parts_name(goal.stem, suffix), True)
    axes = (ast.Axes("y-up"),) if goal.parts.up == "y-up" else ()
    return (ast.Version(1), *axes, asset)


def _report(
    goal: _Goal, scheme: Scheme, difference: Difference, options: Options, told: _Said
) -> Report:
    """The report without what is counted in the text; told: what is printed."""
    from ipmlang.inverse.parts.scaling import as_one
    from ipmlang.inverse.split.separating import used_likenesses

    parts = goal.parts
    sized = as_one(parts, used_likenesses(scheme, parts))
    counts = count_explained(scheme, sized, told.families)
    return Report(
        method="split",
        elements=len(parts.shape),
        explained=counts.explained,
        rules=told.rules,
        rules_twice=min(counts.twice, told.rules),
        max_error=difference.error / parts.diagonal,
        tokens=0,
        tokens_flat=0,
        source_bytes=parts.source_bytes,
        grammar_bytes=0,
        parts_bytes=0,
        seconds=0.0,
        notes=tuple(_told(note) for note in parts.notes),
        mode="exact" if options.within is None else "within",
        limit=goal.limit,
        labels=len(parts.classes),
        repeated=counts.repeated,
        explained_repeated=counts.explained_repeated,
        terminals=len({each.part for each in scheme.symbols if isinstance(each, Terminal)}),
        triangles=parts.triangles,
    )


def _told(note: Note) -> str:
    return note.message + (f" ({note.count} times)" if note.count > 1 else "")
