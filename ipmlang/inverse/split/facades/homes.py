"""Terminals in the coordinates of what they belong to, so that a rule need not say where they are.

Takes a scheme; gives the same one with terminals that were moved to where one of their copies
stands, if that is shorter: `Window --> frame pane sill`. Where a terminal has to fill a scope it
stays in its own box. Nothing is searched, and nothing is drawn elsewhere than before.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ipmlang.inverse.frames import Frames, Integers, around, compose, inverse, join
from ipmlang.inverse.split.cost import (
    ANCHOR,
    item_tokens,
    placement_tokens,
    scheme_tokens,
    tokens_from,
)
from ipmlang.inverse.split.listing import every_token
from ipmlang.inverse.split.scheme import (
    Array,
    Item,
    Octant,
    Place,
    Ring,
    Rule,
    Scheme,
    Split,
    Symbol,
    Terminal,
)
from ipmlang.inverse.split.turning import first_around, in_axes, tidy

TRIED = 8  # copies of a terminal that it may be moved to


def at_home(scheme: Scheme, small: float) -> tuple[Scheme, dict[int, Frames]]:
    """The scheme with moved terminals, and for each of them by number where its box now stands in
    its own coordinates, one row: for printing, as `expand` knows nothing of homes. small: units
    that are printed as nothing.
    """
    best = _at_home(scheme, small)
    for way in in_axes(scheme):
        found = _at_home(way, small)
        if scheme_tokens(found[0], small) < scheme_tokens(best[0], small):
            best = found
    return best


def _at_home(scheme: Scheme, small: float) -> tuple[Scheme, dict[int, Frames]]:
    """Terminals of one form are at home in one place: what only differs in them reads alike."""
    homes: dict[int, Frames] = {}
    items = _free_items(scheme)
    forms: dict[tuple[int, int], list[int]] = {}
    for number in items:
        symbol = scheme.symbols[number]
        assert isinstance(symbol, Terminal)
        key = (symbol.form, 0) if symbol.form >= 0 else (-1, number)
        forms.setdefault(key, []).append(number)
    for numbers in forms.values():
        home = _home([item for number in numbers for item in items[number]], small)
        if home is not None:
            homes |= dict.fromkeys(numbers, home)
    symbols = tuple(_moved(symbol, number, homes) for number, symbol in enumerate(scheme.symbols))
    return replace(scheme, symbols=symbols), homes


def _free_items(scheme: Scheme) -> dict[int, list[Place | Array | Ring]]:
    """The items that place each terminal, of those that never fill a scope."""
    free: dict[int, list[Place | Array | Ring]] = {
        number: [] for number, symbol in enumerate(scheme.symbols) if isinstance(symbol, Terminal)
    }
    for symbol in scheme.symbols:
        for item in symbol.items if isinstance(symbol, Rule) else ():
            for number in _filling(item):
                free.pop(number, None)
            if isinstance(item, Place | Array | Ring) and item.symbol in free:
                free[item.symbol].append(item)
    return free


def _filling(item: Item) -> list[int]:
    """The symbols to which an item gives a scope."""
    match item:
        case Split():
            return [cell.symbol for cell in item.cells if cell.symbol is not None]
        case Octant():
            return [item.symbol]
        case Place() if item.stretch is not None:
            return [item.symbol]
        case _:
            return []


def _home(items: list[Place | Array | Ring], small: float) -> Frames | None:
    """Where the terminal of these items is best at home; None: where it is."""
    around_axes = [first_around(item) for item in items if isinstance(item, Ring)]
    every = join([*around_axes, *(item.frames for item in items if isinstance(item, Place))])
    costly = np.flatnonzero(placement_tokens(every, small) > 1)[:TRIED]
    homes = every[costly[np.abs(every.scale[costly] - 1) <= 1e-12]]
    if not len(homes):
        return None
    if len(every) == len(items) == 1 and isinstance(items[0], Place) and not items[0].anchors:
        return homes  # it stands once: at home it takes one token
    tokens = np.sum([_tokens_from(item, homes, small) for item in items], axis=0)
    best = int(np.argmin(tokens))
    stay = sum(item_tokens(item, small) for item in items)
    return homes[best : best + 1] if tokens[best] < stay else None


def _tokens_from(item: Place | Array | Ring, homes: Frames, small: float) -> Integers:
    """(h,) tokens of an item for a terminal that was moved to one of these frames."""
    back = inverse(homes)
    if not isinstance(item, Place):
        return tokens_from(item, tidy(compose(item.first, back)), small)
    count, many = len(item.frames), len(homes)
    own = item.frames[np.arange(count * many) % count]
    moved = tidy(compose(own, back[np.repeat(np.arange(many), count)]))
    alone = placement_tokens(moved, small) + ANCHOR * len(item.anchors)
    return every_token(moved, alone, small, many)


def _seen_from(item: Place | Array | Ring, home: Frames) -> Place | Array | Ring:
    """The item for a terminal that was moved."""
    back = inverse(home)
    if isinstance(item, Place):
        return replace(item, frames=tidy(compose(item.frames, back)))
    return replace(item, first=tidy(compose(item.first, back)))


def _moved(symbol: Symbol, number: int, homes: dict[int, Frames]) -> Symbol:
    if isinstance(symbol, Terminal):
        if number not in homes:
            return symbol
        low, high = around(homes[number], np.zeros(3), symbol.size)
        return replace(symbol, size=high[0] - low[0], low=low[0])
    items = tuple(
        _seen_from(item, homes[item.symbol])
        if isinstance(item, Place | Array | Ring) and item.symbol in homes
        else item
        for item in symbol.items
    )
    return replace(symbol, items=items)
