"""The grammar that options ask for: the exact one, or, with a tolerance, the best within it.

A larger tolerance finds more rules but takes small shapes for noise, so several are tried. Takes a
drawing and options; gives a proven grammar. Nothing here searches itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.formats.drawing import Drawing
from ipmlang.inverse.attempt import Made, best_grammar
from ipmlang.inverse.observation import observe
from ipmlang.inverse.options import USUAL, Options
from ipmlang.inverse.tolerances import noises
from ipmlang.inverse.unrounded import unrounded

PARTS = (0.25, 1.0)  # of a tolerance that was asked for


def grammar_of(
    drawing: Drawing,
    stem: str,
    flat: bool,
    say: Callable[[str], None],
    options: Options = USUAL,
) -> Made:
    """The grammar as exact as the options ask for: the shortest, or the most regular."""
    exact = replace(options, within=None, symmetrize=False)
    made = best_grammar(drawing, stem, flat, say, exact)
    if not flat and exact.mode == "exact" and not (options.paper or options.explain):
        made = _of_rounded(drawing, stem, say, exact, made)
    if options.within is None and not options.symmetrize:
        return made
    found = [replace(made, report=replace(made.report, mode=options.mode))]
    for within in () if flat else _bounds(drawing, options):
        say(f"looking for what is regular within {within:.1e}")
        try:
            found.append(best_grammar(drawing, stem, flat, say, replace(options, within=within)))
        except IpmError:  # what a tolerance has spoilt is left to the others
            continue
    if options.symmetrize:  # what is regular, not what is short
        return min(found, key=lambda each: (-round(each.report.explained, 2), _tokens(each)))
    return min(found, key=_tokens)


def _of_rounded(
    drawing: Drawing, stem: str, say: Callable[[str], None], options: Options, made: Made
) -> Made:
    """The grammar of the drawing before its program rounded it, on a page that rounds it again, if
    that is shorter than what was made of it as it is.
    """
    before = unrounded(drawing)
    if before is None:
        return made
    say("looking for what was rounded")
    try:
        found = best_grammar(drawing, stem, False, say, options, before)
    except IpmError:  # of a few points nothing says how they were rounded
        return made
    if _tokens(found) >= _tokens(made) or _size(found) > _size(made):
        return made
    report = replace(found.report, tokens_flat=made.report.tokens_flat, limit=made.report.limit)
    return replace(found, report=report)


def _size(made: Made) -> int:
    """Characters of both files; attributes do not count, as that a number can be changed by its
    name is no fault of a rule.
    """
    said = tuple(each for each in made.grammar.items if not isinstance(each, ast.Attr))
    return len(format_grammar(replace(made.grammar, items=said))) + len(made.parts)


def _bounds(drawing: Drawing, options: Options) -> tuple[float, ...]:
    if options.within is not None:
        return tuple(max(part * options.within, 1e-6) for part in PARTS)
    return noises(observe(drawing, similarity=options.similarity))


def _tokens(made: Made) -> int:
    return count_text_tokens(format_grammar(made.grammar)) + made.report.tokens
