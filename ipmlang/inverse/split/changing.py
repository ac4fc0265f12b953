"""Items of a scheme moved, put on other symbols, or taken over into another scheme.

In go items, out come items that draw the same elsewhere. Nothing here weighs or searches.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import assert_never

import numpy as np

from ipmlang.inverse.frames import Floats, compose, moved_to
from ipmlang.inverse.split.expansion import placements
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


def copies(items: Sequence[Item]) -> bool:
    """Whether items are copies, rows and rings alone: what can stand anywhere."""
    return all(isinstance(each, Place | Array | Ring) for each in items)


def moved(item: Place | Array | Ring, by: Floats) -> Place | Array | Ring:
    """An item moved as it is by (3,)."""
    match item:
        case Place():
            return replace(item, frames=compose(moved_to(by), item.frames))
        case Array():
            return replace(item, first=compose(moved_to(by), item.first))
        case Ring():
            first = compose(moved_to(by), item.first)
            return replace(item, first=first, center=item.center + by)
        case _:
            assert_never(item)


def begun_at(item: Place | Array | Ring, corner: Floats) -> Place | Array | Ring:
    """The item for a symbol whose coordinates now begin at `corner` (3,) of those it had."""
    if not corner.any():
        return item
    match item:
        case Place():
            return replace(item, frames=compose(item.frames, moved_to(corner)))
        case Array() | Ring():
            return replace(item, first=compose(item.first, moved_to(corner)))
        case _:
            assert_never(item)


def on_symbols(item: Item, numbers: Mapping[int, int]) -> Item:
    """The item with symbols numbered otherwise."""
    match item:
        case Place() | Array() | Ring() | Octant():
            return replace(item, symbol=numbers[item.symbol])
        case Split():
            return replace(item, cells=tuple(
                cell if cell.symbol is None else replace(cell, symbol=numbers[cell.symbol])
                for cell in item.cells
            ))  # fmt: skip
        case _:
            assert_never(item)


def named_symbols(symbol: Symbol) -> set[int]:
    """The symbols that a symbol's items place."""
    if not isinstance(symbol, Rule):
        return set()
    return {each for item in symbol.items for each in _named(item)}


def _named(item: Item) -> list[int]:
    if isinstance(item, Split):
        return [cell.symbol for cell in item.cells if cell.symbol is not None]
    return [item.symbol]


def needed(symbols: Sequence[Symbol], axiom: int) -> tuple[tuple[Symbol, ...], dict[int, int]]:
    """The symbols that the axiom needs, each before those that place it, and their new numbers."""
    seen, waiting = {axiom}, [axiom]
    while waiting:
        new = named_symbols(symbols[waiting.pop()]) - seen
        seen |= new
        waiting += sorted(new)
    numbers = {old: new for new, old in enumerate(sorted(seen))}
    kept: list[Symbol] = []
    for old in sorted(seen):
        symbol = symbols[old]
        if isinstance(symbol, Rule):
            items = tuple(on_symbols(item, numbers) for item in symbol.items)
            symbol = replace(symbol, items=items)
        kept.append(symbol)
    return tuple(kept), numbers


def top_down(scheme: Scheme) -> list[int]:
    """The rules as people write them: each where it is first named, the axiom first."""
    found: dict[int, None] = {}
    waiting = [scheme.axiom]
    while waiting:
        number = waiting.pop()
        symbol = scheme.symbols[number]
        if number in found or isinstance(symbol, Terminal):
            continue
        found[number] = None
        named = [each for item in symbol.items for each, _ in placements(item)]
        waiting += reversed(list(dict.fromkeys(named)))
    return list(found)


def without_wraps(scheme: Scheme, small: float) -> Scheme:
    """The scheme with terminals in cells as they are, where a rule does nothing but place one at
    its origin, or no further from it than `small`. Such rules stay among the symbols, and nothing
    needs them.
    """
    alone = {
        number: item.symbol
        for number, symbol in enumerate(scheme.symbols)
        if isinstance(symbol, Rule) and len(symbol.items) == 1
        for item in symbol.items
        if isinstance(item, Place) and _is_bare(item, small)
        if isinstance(scheme.symbols[item.symbol], Terminal)
    }
    numbers = {number: alone.get(number, number) for number in range(len(scheme.symbols))}
    symbols = tuple(
        replace(symbol, items=tuple(
            on_symbols(item, numbers) if isinstance(item, Split) else item
            for item in symbol.items
        ))
        if isinstance(symbol, Rule)
        else symbol
        for symbol in scheme.symbols
    )  # fmt: skip
    return replace(scheme, symbols=symbols)


def _is_bare(place: Place, small: float) -> bool:
    frames = place.frames
    upright = len(frames) == 1 and frames.rotation[0, 0] == 1.0 and frames.hand[0] > 0
    at_origin = upright and frames.scale[0] == 1.0 and np.abs(frames.position).max() <= small
    return bool(at_origin and place.stretch is None)


def owned(scheme: Scheme) -> list[set[int]]:
    """Of each symbol those that are placed in it or below it, and nowhere else."""
    users: list[set[int]] = [set() for _ in scheme.symbols]
    for number, symbol in enumerate(scheme.symbols):
        for each in named_symbols(symbol):
            users[each].add(number)
    own: list[set[int]] = []
    for number in range(len(scheme.symbols)):
        inside = {number}
        for below in range(number - 1, -1, -1):
            if users[below] and users[below] <= inside:
                inside.add(below)
        own.append(inside - {number})
    return own
