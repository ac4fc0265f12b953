"""Schemes as splits: bays in a floor, floors in a façade, a house of ground floor, floors and roof.

In goes a scheme, out comes one in which boxes side by side are cells of nested splits, equal cells
one rule, runs of equal cells elastic, so that floors and bays are one number to edit. Where that is
longer, what was there stays. What is drawn does not change.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ipmlang.inverse.frames import Floats, compose, moved_to
from ipmlang.inverse.split.changing import begun_at, copies, needed, owned
from ipmlang.inverse.split.cost import scheme_tokens
from ipmlang.inverse.split.expansion import expand
from ipmlang.inverse.split.facades.anchoring import anchored
from ipmlang.inverse.split.facades.building import Building, bonus, is_cut, repeats
from ipmlang.inverse.split.facades.contents import Contents, Kinds, contents, sorted_rows
from ipmlang.inverse.split.facades.following import following
from ipmlang.inverse.split.facades.homes import at_home
from ipmlang.inverse.split.facades.matching import matched
from ipmlang.inverse.split.growing import with_scopes
from ipmlang.inverse.split.measuring import extents
from ipmlang.inverse.split.scheme import Array, Item, Place, Ring, Rule, Scheme, Symbol, Terminal

FOLLOWING = 0.4  # of all tokens may be spent on walls which follow their scope
LEAST = 36  # tokens that may be spent on them in any grammar
DEEPEST = 2  # times that the rules within a rule are opened before it is cut
MOST = 2500  # rows of a rule that is cut
NAMES = {0: "Bay", 1: "Row", 2: "Floor"}  # of cells that repeat along an axis, for a person


def as_splits(scheme: Scheme, small: float) -> Scheme:
    """The scheme with splits where they read better and are not longer but for a small bonus;
    small: units that do not count.
    """
    rules = [symbol for symbol in scheme.symbols if isinstance(symbol, Rule)]
    if not all(copies(rule.items) for rule in rules):
        return scheme
    cut, saved = _cut(scheme, small)
    most = saved + max(int(scheme_tokens(cut, small) * FOLLOWING), LEAST)
    scoped = with_scopes(cut)
    found = following(scoped, small, most)
    if cut is scheme and found is scoped:
        return scheme
    found = anchored(found, small)
    return found if matched(expand(found), expand(scheme), 5 * small) else scheme


def _cut(scheme: Scheme, small: float) -> tuple[Scheme, int]:
    """The scheme with splits, and the tokens that they save; as it is where they save none."""
    found = _named(_Rewriting(scheme, small).scheme())
    if any(is_cut(symbol) for symbol in found.symbols):
        saved = _score(scheme, small) - _score(found, small)
        if saved > 0:
            return found, saved
    return scheme, 0


def _score(scheme: Scheme, small: float) -> int:
    rules = [symbol for symbol in scheme.symbols if isinstance(symbol, Rule)]
    printed, _ = at_home(scheme, small)
    return scheme_tokens(printed, small) - sum(bonus(item) for rule in rules for item in rule.items)


@dataclass(frozen=True, slots=True, eq=False)
class _Way:
    """A rule said in some way: its new number, and the corner of its old coordinates where its
    new ones begin.
    """

    number: int
    corner: Floats


class _Rewriting:
    """Rule by rule, the smallest first."""

    def __init__(self, scheme: Scheme, small: float) -> None:
        self._scheme = scheme
        self._small = small
        self._extents = extents(scheme)
        self._kinds = Kinds()
        self._building = Building(small)
        self._corner = np.zeros((len(scheme.symbols), 3))

    def scheme(self) -> Scheme:
        """All of it rewritten."""
        owns = owned(self._scheme)
        for number, symbol in enumerate(self._scheme.symbols):
            if isinstance(symbol, Terminal):
                self._building.new[number] = self._building.add(symbol)
                continue
            others = set(range(number)) - owns[number]
            kept = [self._building.below(self._building.new[each]) for each in others]
            self._building.free = frozenset().union(*kept)
            way = min(self._ways(symbol), key=lambda each: self._building.cost(each.number))
            self._take(number, symbol, way)
        axiom = self._scheme.axiom
        symbols, _ = needed(self._building.made, self._building.new[axiom])
        return Scheme(symbols, compose(self._scheme.frame, moved_to(self._corner[[axiom]])))

    def _take(self, number: int, symbol: Rule, way: _Way) -> None:
        made = self._building.made[way.number]
        if isinstance(made, Rule) and (symbol.name, symbol.note) != (made.name, made.note):
            named = replace(made, name=symbol.name, note=symbol.note)
            way = _Way(self._building.add(named), way.corner)
        self._building.new[number] = way.number
        self._corner[number] = way.corner

    def _ways(self, rule: Rule) -> Iterator[_Way]:
        """The rule as it is, and cut, with more or less of it opened and with room around it."""
        items = tuple(self._taken_over(item) for item in rule.items)
        self._building.items = items
        yield _Way(self._building.add(replace(rule, items=items)), np.zeros(3))
        sizes = set()
        for depth in range(DEEPEST + 1):
            inside = sorted_rows(self._contents(rule, depth), self._small)
            if len(inside) in sizes or not 1 < len(inside) <= MOST:
                continue
            sizes.add(len(inside))
            size = np.maximum(rule.size, 0.0)
            yield _Way(self._building.build(inside, size), np.zeros(3))
            room = self._room(inside, size)
            if room.any():
                yield _Way(self._building.build(inside, size + room), np.zeros(3))
                wide = inside.moved(room / 2)
                yield _Way(self._building.build(wide, size + room), -room / 2)

    def _taken_over(self, item: Item) -> Place | Array | Ring:
        assert isinstance(item, Place | Array | Ring)
        corner = self._corner[item.symbol]
        return begun_at(replace(item, symbol=self._building.new[item.symbol]), corner)

    def _contents(self, rule: Rule, depth: int) -> Contents:
        found = contents(self._scheme, rule, self._extents, depth, self._kinds)
        begun = moved_to(self._corner[found.symbol])
        return replace(found, frames=compose(found.frames, begun))

    def _room(self, inside: Contents, size: Floats) -> Floats:
        """(3,) what a scope lacks for the last cell of a row that reaches its ends."""
        room = np.zeros(3)
        for axis in range(3):
            for groups, found in self._building.cuts(inside, axis):
                stop = found[0].first + found[0].period
                if len(found) == 1 and found[0].count > 1:
                    slack = found[0].step - float(groups.high[:stop].max() - groups.low[0])
                    margins = float(groups.low[0]), float(size[axis] - groups.high[-1])
                    lacking = slack - 2 * min(margins)
                    room[axis] = max(room[axis], lacking)
        return np.where(room > self._small, room, 0.0)


def _named(scheme: Scheme) -> Scheme:
    """With names for the cells of a grid, where nothing names them: floors, and bays in them."""
    wish: dict[int, str] = {}
    repeated = [_repeated(symbol) for symbol in scheme.symbols]
    for cells in repeated:
        for number, axis in cells.items():
            inner = {other: turn for other, turn in repeated[number].items() if turn != axis}
            if inner:
                wish |= {other: NAMES[turn] for other, turn in inner.items()}
                wish[number] = NAMES[axis]
    return replace(scheme, symbols=tuple(
        replace(symbol, name=wish[number])
        if number in wish and isinstance(symbol, Rule) and not symbol.name
        else symbol
        for number, symbol in enumerate(scheme.symbols)
    ))  # fmt: skip


def _repeated(symbol: Symbol) -> dict[int, int]:
    """The symbols that repeat as cells of a symbol, and along which axis."""
    items = symbol.items if isinstance(symbol, Rule) else ()
    return {
        cell.symbol: item.axis
        for item in items
        if repeats(item)
        for cell in item.cells
        if cell.count > 1 and cell.symbol is not None
    }
