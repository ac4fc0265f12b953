"""How far what each rule draws is from what was read: the error of a regular grammar, rule by rule.

Takes the alphabet and string of a search with what was observed; gives the largest distance for
each rule, over all places where it is drawn. Nothing here changes a rule.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipmlang.inverse.lsystem.frames import Frames, compose, join
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers, Seen, misses
from ipmlang.inverse.report import RuleError


def rule_errors(
    alphabet: Alphabet,
    seen: Seen,
    string: Arrangement,
    names: Mapping[int, str],
    diagonal: float,
) -> tuple[RuleError, ...]:
    """Largest errors by rule, worst first; names: of the symbols that have a rule, several of one
    family under one name.
    """
    found: dict[str, RuleError] = {}
    for symbol, placed, start in _occurrences(alphabet, string):
        name = names.get(symbol)
        if name is None or alphabet[symbol].terminal:
            continue
        worst = float(misses(alphabet, seen, symbol, placed, start).max()) / diagonal
        if not np.isfinite(worst):  # members that are painted among others
            continue
        known = found.get(name, RuleError(name, 0.0, 0))
        drawn = known.elements + alphabet[symbol].drawn * len(start)
        found[name] = RuleError(name, max(worst, known.error), drawn)
    return tuple(sorted(found.values(), key=lambda each: (-each.error, each.rule)))


def _occurrences(alphabet: Alphabet, string: Arrangement) -> list[tuple[int, Frames, Integers]]:
    """Every symbol with all frames (k,) in which it is drawn and the first elements (k,) there,
    from large to small: symbols are made of earlier ones.
    """
    waiting: dict[int, list[tuple[Frames, Integers]]] = {}
    for symbol in np.unique(string.symbol).tolist():
        rows = np.flatnonzero(string.symbol == symbol)
        waiting.setdefault(symbol, []).append((string.placed[rows], string.start[rows]))
    found = []
    for symbol in range(len(alphabet) - 1, -1, -1):
        if symbol not in waiting:
            continue
        placed = join([each for each, _ in waiting[symbol]])
        start = np.concatenate([each for _, each in waiting[symbol]])
        found.append((symbol, placed, start))
        definition = alphabet[symbol]
        row = int(definition.anchored)
        for index, part in enumerate(definition.parts.tolist()):
            inside = compose(placed, definition.places[index : index + 1])
            waiting.setdefault(part, []).append((inside, start + row))
            row += alphabet[part].size
    return found
