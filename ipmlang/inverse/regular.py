"""The grammar that options ask for: the exact one, or, with a tolerance, the best within it.

A larger tolerance finds more rules but takes small shapes for noise, so several are tried. Takes a
drawing and options; gives a proven grammar. Nothing here searches itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.formats.drawing import Drawing
from ipmlang.inverse.attempt import Made, best_grammar
from ipmlang.inverse.observation import observe
from ipmlang.inverse.options import USUAL, Options
from ipmlang.inverse.tolerances import noises

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


def _bounds(drawing: Drawing, options: Options) -> tuple[float, ...]:
    if options.within is not None:
        return tuple(max(part * options.within, 1e-6) for part in PARTS)
    return noises(observe(drawing, similarity=options.similarity))


def _tokens(made: Made) -> int:
    return count_text_tokens(format_grammar(made.grammar)) + made.report.tokens
