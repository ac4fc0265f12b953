"""What follows its scope: walls behind windows, cornices over bays.

In go schemes with splits, out come the same with terminals that span a scope stretched to it, where
the scope is what a person changes to get more floors or bays. At the first size nothing is drawn
otherwise.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.frames import Floats, Frames, identity
from ipmlang.inverse.split.changing import on_symbols
from ipmlang.inverse.split.cost import HEAD, item_tokens
from ipmlang.inverse.split.measuring import in_cells
from ipmlang.inverse.split.scheme import Item, Place, Rule, Scheme, Split, Symbol, Terminal

FEWEST = 3  # cells that repeat so often are what a person would have more or fewer of
SPANNED = 0.9  # of the cells that repeat in a scope, by what follows it
ALIKE = 1e-9  # of their size, that scopes may differ by and are the same
Axes = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class _Offer:
    """A terminal that may follow its scope: in which rule, item and cell (-1: none), how it then
    stands, and how large it is.
    """

    spot: tuple[int, int, int]
    place: Place
    volume: float


def following(scheme: Scheme, small: float, most: int) -> Scheme:
    """The scheme with the largest spanning terminals stretched to their scopes, for no more than
    `most` tokens.
    """
    chosen: dict[tuple[int, int, int], Place] = {}
    for offer in sorted(_offers(scheme), key=lambda each: (-each.volume, each.spot)):
        wrapped = HEAD + 1 if offer.spot[2] >= 0 else 0
        tokens = item_tokens(offer.place, small) - 1 + wrapped
        if tokens <= most:
            most -= tokens
            chosen[offer.spot] = offer.place
    return _stretched(scheme, chosen) if chosen else scheme


def _offers(scheme: Scheme) -> Iterator[_Offer]:
    changing, elsewhere = changing_axes(scheme), in_other_scopes(scheme)
    ranges = repeated_ranges(scheme)
    for number, symbol in enumerate(scheme.symbols):
        if not isinstance(symbol, Rule) or number in elsewhere:
            continue
        for order, item in enumerate(symbol.items):
            for cell, scope, axes, frames, inner in _alone(symbol, item, changing[number]):
                terminal = scheme.symbols[inner]
                if isinstance(terminal, Terminal):
                    whole = np.stack([np.zeros(3), scope])
                    span = np.where(np.isfinite(ranges[number]), ranges[number], whole)
                    margins = _margins(terminal, frames, scope, axes, span)
                    place = Place(inner, frames, terminal.size[None], margins[None])
                    if np.isfinite(margins).any():
                        volume = float(np.prod(terminal.size + 1e-3 * terminal.size.max()))
                        yield _Offer((number, order, cell), place, volume)


def in_other_scopes(scheme: Scheme) -> set[int]:
    """Symbols that stand in cells whose size is not theirs."""
    found = set()
    for symbol in scheme.symbols:
        for split, along in _splits(symbol):
            for cell in split.cells:
                if cell.symbol is not None:
                    scope = np.where(along, cell.length, symbol.size)
                    own = scheme.symbols[cell.symbol].size
                    if np.abs(scope - own).max() > ALIKE * np.abs(own).max():
                        found.add(cell.symbol)
    return found


def _alone(rule: Rule, item: Item, axes: Axes) -> Iterator[tuple[int, Floats, Axes, Frames, int]]:
    """What an item places once, upright: in which cell, in what scope, along which axes that scope
    changes, where, and which symbol.
    """
    if isinstance(item, Place) and item.stretch is None and len(item.frames) == 1:
        frames = item.frames
        if frames.rotation[0, 0] == 1.0 and frames.hand[0] > 0 and frames.scale[0] == 1.0:
            yield -1, rule.size, axes, frames, item.symbol
    if isinstance(item, Split):
        along = np.arange(3) == item.axis
        for order, cell in enumerate(item.cells):
            if cell.symbol is not None:
                scope = np.where(along, cell.length, rule.size)
                own = np.where(along, cell.elastic and cell.count == 1, axes)
                yield order, scope, own, identity(), cell.symbol


def _margins(
    terminal: Terminal, frames: Frames, scope: Floats, axes: Axes, repeated: Floats
) -> Floats:
    """By how much a terminal is less than the scope along axes where it spans the cells that
    repeat (2, 3); not a number where it does not or where the scope stays as it is.
    """
    low, high = frames.position[0], frames.position[0] + terminal.size
    slack = (1 - SPANNED) * (repeated[1] - repeated[0])
    spans = (low <= repeated[0] + slack) & (high >= repeated[1] - slack)
    beside = np.maximum(-low, high - scope)
    near = beside <= (1 - SPANNED) * scope
    return np.where(axes & spans & near & (scope > 0), scope - terminal.size, np.nan)


def repeated_ranges(scheme: Scheme) -> list[Floats]:
    """(2, 3) for each symbol, from where to where cells repeat in it along each axis, in its
    coordinates; infinite where none do.
    """
    found: list[Floats] = []
    for symbol in scheme.symbols:
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for split, along in _splits(symbol):
            at = 0.0
            for cell in split.cells:
                begin, at = at, at + cell.length * cell.count
                if cell.count >= FEWEST:
                    low = np.where(along, np.minimum(low, begin), low)
                    high = np.where(along, np.maximum(high, at), high)
                if cell.symbol is not None:
                    inner = found[cell.symbol]
                    low = np.where(along, low, np.minimum(low, inner[0]))
                    high = np.where(along, high, np.maximum(high, inner[1]))
        found.append(np.stack([low, high]))
    return found


def changing_axes(scheme: Scheme) -> list[Axes]:
    """(3,) for each symbol, along which axes its scope is what a person changes to have more or
    fewer of the cells that repeat in it, or follows one that is.
    """
    grown = [np.zeros(3, np.bool_) for _ in scheme.symbols]
    for number, symbol in enumerate(scheme.symbols):
        for split, along in _splits(symbol):
            for cell in split.cells:
                grown[number] |= along & (cell.count >= FEWEST)
                if cell.symbol is not None:
                    grown[number] |= ~along & grown[cell.symbol]
    for number in in_cells(scheme) - _placed_freely(scheme):
        grown[number] = np.zeros(3, np.bool_)
    for number in range(scheme.axiom, -1, -1):
        for split, along in _splits(scheme.symbols[number]):
            for cell in split.cells:
                if cell.symbol is not None:
                    grown[cell.symbol] = grown[cell.symbol] | (~along & grown[number])
    return grown


def _placed_freely(scheme: Scheme) -> set[int]:
    """The symbols that stand somewhere with a scope of their own."""
    return {
        item.symbol
        for symbol in scheme.symbols
        for item in (symbol.items if isinstance(symbol, Rule) else ())
        if not isinstance(item, Split)
    }


def _splits(symbol: Symbol) -> Iterator[tuple[Split, Axes]]:
    for item in symbol.items if isinstance(symbol, Rule) else ():
        if isinstance(item, Split):
            yield item, np.arange(3) == item.axis


def _stretched(scheme: Scheme, chosen: dict[tuple[int, int, int], Place]) -> Scheme:
    """The scheme with these stretched; what stands in a cell as it is gets a rule for that."""
    made: list[Symbol] = []
    numbers: dict[int, int] = {}
    for number, symbol in enumerate(scheme.symbols):
        if isinstance(symbol, Rule):
            items = []
            for order, item in enumerate(symbol.items):
                place = chosen.get((number, order, -1))
                item = on_symbols(item if place is None else place, numbers)
                if isinstance(item, Split):
                    item = _wrapped(made, symbol, item, numbers, chosen, (number, order))
                items.append(item)
            symbol = replace(symbol, items=tuple(items))
        numbers[number] = len(made)
        made.append(symbol)
    return replace(scheme, symbols=tuple(made))


def _wrapped(
    made: list[Symbol],
    rule: Rule,
    split: Split,
    numbers: Mapping[int, int],
    chosen: Mapping[tuple[int, int, int], Place],
    spot: tuple[int, int],
) -> Split:
    cells = list(split.cells)
    for order, cell in enumerate(cells):
        place = chosen.get((*spot, order))
        if place is not None:
            scope = np.where(np.arange(3) == split.axis, cell.length, rule.size)
            made.append(Rule("", scope, (on_symbols(place, numbers),)))
            cells[order] = replace(cell, symbol=len(made) - 1)
    return replace(split, cells=tuple(cells))
