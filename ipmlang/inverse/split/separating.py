"""Scaled copies that nothing gains from are shapes of their own again.

Takes a scheme in which terminals stand for scaled copies of their shape too; gives one in which
those copies that no growing row and no scaled rule draws are terminals of their own, where that is
shorter. What is drawn does not change.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.frames import Floats, Frames, Integers, compose, inverse
from ipmlang.inverse.parts.observation import Likeness, Parts
from ipmlang.inverse.split.changing import needed
from ipmlang.inverse.split.cost import ASSET, SHAPE, item_tokens
from ipmlang.inverse.split.expansion import placements
from ipmlang.inverse.split.scheme import Array, Item, Place, Rule, Scheme, Symbol, Terminal

SAME = 1e-5  # share by which scales may differ that are one


def separated(scheme: Scheme, parts: Parts, small: float) -> Scheme:
    """The scheme with terminals of their own for scaled copies where that is shorter; parts: as
    they were before some stood for others; small: units that are printed as nothing.
    """
    symbols = list(scheme.symbols)
    drawn = _drawn(symbols)
    for each in parts.likenesses:
        terminal = next((k for k, it in enumerate(symbols) if _draws(it, each.of)), None)
        if terminal is not None:
            found = _without(symbols, drawn, terminal, each, parts, small)
            if found is not None:
                symbols, drawn = found, _drawn(found)
    return Scheme(needed(symbols, len(symbols) - 1)[0], scheme.frame)


def used_likenesses(scheme: Scheme, parts: Parts) -> tuple[Likeness, ...]:
    """The likenesses that a scheme makes use of."""
    own = {each.part for each in scheme.symbols if isinstance(each, Terminal)}
    return tuple(each for each in parts.likenesses if each.shape not in own)


def _draws(symbol: Symbol, part: int) -> bool:
    return isinstance(symbol, Terminal) and symbol.part == part


@dataclass(frozen=True, slots=True, eq=False)
class _Use:
    """Item `item` of rule `rule` places a terminal; copies (n,): which of its placements are copies
    of the size that is asked for.
    """

    rule: int
    item: int
    copies: NDArray[np.bool_]


def _without(
    symbols: list[Symbol],
    drawn: _Drawn,
    terminal: int,
    like: Likeness,
    parts: Parts,
    small: float,
) -> list[Symbol] | None:
    """The symbols with a terminal for these copies, None where it is not shorter or cannot be."""
    uses = _uses(symbols, drawn, terminal, float(like.frame.scale[0]))
    if uses is None or sum(int(use.copies.sum()) for use in uses) != len(
        parts.classes[like.shape].members
    ):
        return None
    own = [_items(symbols, use, like) for use in uses]
    old = [_item(symbols, use.rule, use.item) for use in uses]
    kept = [item for one, _ in own for item in one]
    made = [item for _, other in own for item in other]
    if _tokens(kept, small) + _tokens(made, small) + ASSET + SHAPE >= _tokens(old, small):
        return None
    return _rebuilt(symbols, terminal, like, parts, uses, own)


@dataclass(frozen=True, slots=True, eq=False)
class _Drawn:
    """For each symbol: sizes (k,) in which it is drawn, equal ones once; places: the rules and
    their items that place it, with the scales (n,) of the copies there.
    """

    sizes: list[Floats]
    places: list[list[tuple[int, int, Floats]]]


def _drawn(symbols: Sequence[Symbol]) -> _Drawn:
    """How symbols are drawn, from the axiom down."""
    sizes: list[list[float]] = [[] for _ in symbols]
    places: list[list[tuple[int, int, Floats]]] = [[] for _ in symbols]
    sizes[-1] = [1.0]
    for number in range(len(symbols) - 1, -1, -1):
        symbol = symbols[number]
        own = np.unique(np.round(sizes[number], 6))
        for place, item in enumerate(symbol.items if isinstance(symbol, Rule) else ()):
            for inner, frames in placements(item):
                places[inner].append((number, place, frames.scale))
                scale = np.unique(np.round(frames.scale, 9))
                sizes[inner] += (own[:, None] * scale[None]).ravel().tolist()
    return _Drawn([np.unique(np.round(each, 6)) for each in sizes], places)


def _uses(
    symbols: Sequence[Symbol], drawn: _Drawn, terminal: int, factor: float
) -> list[_Use] | None:
    """The items that place a terminal; None where one draws copies of this size that may not
    have a terminal of their own: in growing rows, and in rules that are drawn in several sizes.
    """
    uses = []
    for number, place, scale in sorted(drawn.places[terminal], key=lambda each: each[:2]):
        item = _item(symbols, number, place)
        every = scale[None] * drawn.sizes[number][:, None]
        copies = np.abs(every / factor - 1) < SAME
        if copies.any() and (len(every) > 1 or not isinstance(item, Place | Array)):
            return None
        if isinstance(item, Array) and copies.any() and not copies.all():
            return None
        uses.append(_Use(number, place, np.asarray(copies.any(axis=0))))
    return uses


def _item(symbols: Sequence[Symbol], rule: int, place: int) -> Item:
    symbol = symbols[rule]
    assert isinstance(symbol, Rule)
    return symbol.items[place]


def _items(
    symbols: Sequence[Symbol], use: _Use, like: Likeness
) -> tuple[list[Item], list[Place | Array]]:
    """What stays of an item, and what of it draws the copies, with symbol -1."""
    item = _item(symbols, use.rule, use.item)
    if not use.copies.any():
        return [item], []
    back = inverse(like.frame)
    if isinstance(item, Array):
        return [], [replace(item, symbol=-1, first=_plain(compose(item.first, back)))]
    assert isinstance(item, Place)
    rest = _rows(item, np.flatnonzero(~use.copies))
    own = _rows(item, np.flatnonzero(use.copies))
    moved = replace(own, symbol=-1, frames=_plain(compose(own.frames, back)))
    return ([rest] if len(rest.frames) else []), [moved]


def _rows(place: Place, rows: Integers) -> Place:
    return replace(place, frames=place.frames[rows])


def _plain(frames: Frames) -> Frames:
    """Frames whose scale is exactly 1 where it nearly is."""
    near = np.abs(frames.scale - 1) < SAME
    return replace(frames, scale=np.where(near, 1.0, frames.scale))


def _tokens(items: Sequence[Item], small: float) -> int:
    """Of all items of a terminal; one that stands once alone is drawn where it is."""
    alone = len(items) == 1 and isinstance(items[0], Place) and len(items[0].frames) == 1
    return 1 if alone else sum(item_tokens(item, small) for item in items)


def _rebuilt(
    symbols: Sequence[Symbol],
    terminal: int,
    like: Likeness,
    parts: Parts,
    uses: Sequence[_Use],
    own: Sequence[tuple[list[Item], list[Place | Array]]],
) -> list[Symbol]:
    """The symbols with one more terminal, first of all, and what it draws taken from the other."""
    from ipmlang.inverse.split.changing import on_symbols

    shape = parts.classes[like.shape]
    new: list[Symbol] = [Terminal(shape.name, np.asarray(shape.size, np.float64), like.shape)]
    numbers = {-1: 0} | {old: old + 1 for old in range(len(symbols))}
    instead = {(use.rule, use.item): each for use, each in zip(uses, own, strict=True)}
    for number, symbol in enumerate(symbols):
        if isinstance(symbol, Rule):
            items: list[Item] = []
            for place, item in enumerate(symbol.items):
                kept, made = instead.get((number, place), ([item], []))
                items += [on_symbols(each, numbers) for each in (*kept, *made)]
            symbol = replace(symbol, items=tuple(items))
        new.append(symbol)
    return new
