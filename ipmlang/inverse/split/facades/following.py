"""What follows its scope: walls behind windows, cornices over bays.

In go schemes with splits, out come the same with terminals that span a scope stretched to it, where
the scope is what a person changes to get more floors or bays. At the first size nothing is drawn
otherwise.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ipmlang.inverse.frames import Floats, Frames, identity
from ipmlang.inverse.split.changing import on_symbols
from ipmlang.inverse.split.cost import scheme_tokens
from ipmlang.inverse.split.facades.homes import at_home
from ipmlang.inverse.split.growing import Axes, growing, in_other_scopes
from ipmlang.inverse.split.scheme import Item, Place, Rule, Scheme, Split, Symbol, Terminal

SPANNED = 0.9  # of the cells that repeat in a scope, by what follows it
ATTRIBUTE = 16  # tokens of `attr rows : int = 4 in 1.. "…"` and of a scope that is so long


@dataclass(frozen=True, slots=True, eq=False)
class _Offer:
    """A terminal that may follow its scope: in which rule, item and cell (-1: none), how it then
    stands, how large it is, and whether the scope changes by a count that has to be an attribute.
    """

    spot: tuple[int, int, int]
    place: Place
    volume: float
    counted: bool


def following(scheme: Scheme, small: float, most: int) -> Scheme:
    """The scheme with the largest spanning terminals stretched to their scopes, for no more than
    `most` tokens.
    """
    groups = _groups(scheme)
    if not groups:
        return scheme
    least = _tokens(scheme, small)
    chosen: dict[tuple[int, int, int], Place] = {}
    for group in groups:
        with_them = chosen | {each.spot: each.place for each in group}
        own = ATTRIBUTE if group[0].counted else 0
        if _tokens(_stretched(scheme, with_them), small) + own <= least + most:
            chosen, most = with_them, most - own
    return _stretched(scheme, chosen) if chosen else scheme


def _groups(scheme: Scheme) -> list[list[_Offer]]:
    """Offers that are taken together: those whose scope changes by a count follow all or none. The
    largest first.
    """
    groups: dict[tuple[int, ...], list[_Offer]] = {}
    for offer in sorted(_offers(scheme), key=lambda each: (-each.volume, each.spot)):
        groups.setdefault(offer.spot[:1] if offer.counted else offer.spot, []).append(offer)
    return list(groups.values())


def _tokens(scheme: Scheme, small: float) -> int:
    """Of a scheme as it is printed: what fills its scope is at home there and nowhere else."""
    return scheme_tokens(at_home(scheme, small)[0], small)


def _offers(scheme: Scheme) -> Iterator[_Offer]:
    grows, elsewhere = growing(scheme), in_other_scopes(scheme)
    for number, symbol in enumerate(scheme.symbols):
        if not isinstance(symbol, Rule) or number in elsewhere:
            continue
        axes, counted, ranges = grows.axes[number], grows.counted[number], grows.ranges[number]
        for order, item in enumerate(symbol.items):
            for cell, scope, changing, frames, inner in _upright(symbol, item, axes):
                terminal = scheme.symbols[inner]
                if isinstance(terminal, Terminal):
                    margins = _margins(terminal, frames, scope, changing, ranges)
                    follows = np.isfinite(margins)
                    if follows.any(axis=1).all():
                        stretch = np.repeat(terminal.size[None], len(frames), axis=0)
                        place = Place(inner, frames, stretch, margins)
                        volume = float(np.prod(terminal.size + 1e-3 * terminal.size.max()))
                        by_count = bool((follows & counted).any())
                        yield _Offer((number, order, cell), place, volume, by_count)


def _upright(rule: Rule, item: Item, axes: Axes) -> Iterator[tuple[int, Floats, Axes, Frames, int]]:
    """What an item places upright: in which cell, in what scope, along which axes that scope
    changes, where, and which symbol.
    """
    if isinstance(item, Place) and item.stretch is None:
        frames = item.frames
        turned = (frames.rotation[:, 0] != 1.0) | (frames.hand < 0) | (frames.scale != 1.0)
        if not turned.any():
            yield -1, rule.size, axes, frames, item.symbol
    if isinstance(item, Split):
        along = np.arange(3) == item.axis
        for order, cell in enumerate(item.cells):
            if cell.symbol is not None:
                scope = np.where(along, cell.length, rule.size)
                own = np.where(along, cell.elastic and cell.count == 1, axes)
                yield order, scope, own, identity(), cell.symbol


def _margins(
    terminal: Terminal, frames: Frames, scope: Floats, axes: Axes, ranges: Floats
) -> Floats:
    """(n, 3) by how much a terminal is less than the scope along axes where it spans what repeats
    (2, 3); not a number where it does not or where the scope stays as it is.
    """
    low, high = frames.position, frames.position + terminal.size
    whole = np.stack([np.zeros(3), scope])
    repeated = np.where(np.isfinite(ranges), ranges, whole)
    slack = (1 - SPANNED) * (repeated[1] - repeated[0])
    spans = (low <= repeated[0] + slack) & (high >= repeated[1] - slack)
    beside = np.maximum(-low, high - scope)
    near = beside <= (1 - SPANNED) * scope
    return np.where(axes & spans & near & (scope > 0), scope - terminal.size, np.nan)


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
