"""What a grammar would no longer say if some of its elements were drawn by another rule.

Takes the string that a search left and what its grammar weighs; says for any elements what each of
them would spare. A placement in a rule is spared only where all that it draws goes, in every copy
of the rule: one of many leaves that a motif draws spares nothing. Nothing here searches.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import Floats
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Definition, Integers
from ipmlang.inverse.score import (
    DIGITS,
    HEAD,
    LOOP,
    placement_tokens,
    sequence_tokens,
    tree_tokens,
)

LEAST = 0.02  # of the weight of a grammar


@dataclass(frozen=True, slots=True, eq=False)
class Said:
    """All stretches of elements that something said draws, item by item.

    begin: (i,) the first stretch of each item; item, start, size: (s,) of each stretch its item,
    its first element and how many they are; share: (s,) what it weighs of its item, for each
    element; count: elements in all; least: what others must spare in all to be worth a search;
    needed: the same of others that are painted in another order.
    """

    begin: Integers
    item: Integers
    start: Integers
    size: Integers
    share: Floats
    count: int
    least: float
    needed: float

    def spared(self, gone: NDArray[np.bool_]) -> Floats:
        """(n,) what each element (n,) would spare if all of those that are `gone` were."""
        before = np.concatenate([[0], np.cumsum(gone)])
        end = self.start + self.size
        whole = before[end] - before[self.start] == self.size
        every = np.logical_and.reduceat(whole, self.begin)
        share = np.where(every[self.item], self.share, 0.0)
        change = np.bincount(self.start, share, self.count + 1)
        change -= np.bincount(end, share, self.count + 1)
        return np.asarray(np.cumsum(change)[:-1])


def layers_weight(count: int) -> float:
    """What a table weighs that says in which layer each of so many elements is painted."""
    digits = np.floor(np.log10(np.maximum(np.arange(count), 0.1))) + 1
    return float(np.maximum(digits / DIGITS, 0.5).sum())


def said(alphabet: Alphabet, string: Arrangement, count: int, weight: float, needed: float) -> Said:
    """What a string (n,) of so many elements says, which weighs so much in all."""
    starts, sizes, tokens = (list(each) for each in zip(*_items(alphabet, string), strict=True))
    often = np.array([len(each) for each in starts], np.int64)
    size, weights = np.array(sizes, np.int64), np.array(tokens, np.float64)
    item = np.repeat(np.arange(len(often)), often)
    share = weights * weight / max(float(weights.sum()), 1.0) / (often * size)
    begin, start = np.cumsum(often) - often, np.concatenate(starts)
    least = LEAST * weight
    return Said(begin, item, start, size[item], share[item], count, least, max(least, needed))


def _items(alphabet: Alphabet, string: Arrangement) -> Iterator[tuple[Integers, int, float]]:
    """Of each placement and rule where the elements begin that its copies draw, how many each
    draws, and its tokens.
    """
    sizes = np.array([each.size for each in alphabet.definitions], np.int64)
    cost = placement_tokens(string.placed, alphabet.tolerance)
    alone = zip(string.start.tolist(), string.symbol.tolist(), cost.tolist(), strict=True)
    for start, symbol, tokens in alone:
        yield np.array([start], np.int64), int(sizes[symbol]), float(tokens)
    drawn: dict[int, list[Integers]] = {}
    for symbol in np.unique(string.symbol).tolist():
        drawn[symbol] = [string.start[string.symbol == symbol]]
    # Symbols are made of earlier ones.
    for symbol in range(len(alphabet) - 1, -1, -1):
        definition = alphabet[symbol]
        if symbol not in drawn or definition.terminal:
            continue
        starts = np.concatenate(drawn[symbol])
        yield starts, definition.size, _rule_tokens(definition)
        inside = sizes[definition.parts]
        first = starts[:, None] + (np.cumsum(inside) - inside) + int(definition.anchored)
        for part in np.unique(definition.parts).tolist():
            drawn.setdefault(part, []).append(first[:, definition.parts == part].ravel())
        if not _repeats(definition):
            placed = placement_tokens(definition.places, alphabet.tolerance)
            for k, tokens in enumerate(placed.tolist()):
                yield first[:, k], int(inside[k]), float(tokens)


def _repeats(definition: Definition) -> bool:
    """Whether places follow from a rule."""
    structures = (definition.pattern, definition.branching, definition.lattice)
    return any(each is not None for each in structures)


def _rule_tokens(definition: Definition) -> float:
    """Tokens of a rule without the placements in it."""
    if definition.pattern is not None:
        return float(HEAD + sequence_tokens(definition.pattern))
    if definition.branching is not None:
        return float(tree_tokens(definition.branching))
    return float(HEAD if definition.lattice is None else HEAD + 2 * LOOP)
