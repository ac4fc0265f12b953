"""Rules under construction: the shortest way to say what stands in a box, as copies or as splits.

In go contents with the size of their scope, out come numbers of symbols; equal contents give one
symbol. A symbol's cost is that of all symbols that it needs, each counted once, less a bonus for
cells that repeat, which people read and edit more easily than rows. Nothing is dropped here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TypeAlias, TypeGuard

import numpy as np

from ipmlang.inverse.frames import Floats, Frames, Integers, join
from ipmlang.inverse.split.changing import moved, named_symbols
from ipmlang.inverse.split.cost import ASSET, item_tokens, placement_tokens, rule_tokens
from ipmlang.inverse.split.facades.cells import Span, spans
from ipmlang.inverse.split.facades.contents import Contents, same, sorted_rows
from ipmlang.inverse.split.facades.guillotine import Groups, Run, runs, side_by_side, ways
from ipmlang.inverse.split.paper.subdivisions import lattices
from ipmlang.inverse.split.scheme import (
    Array,
    Cell,
    Direction,
    Item,
    Octant,
    Place,
    Ring,
    Rule,
    Split,
    Symbol,
    Terminal,
)

BONUS = 8  # tokens that a split may cost more where cells repeat, and has to save where none do
MOST = 2500  # contents weighed in one rule, and in all
SIZED = 8  # tokens of `size(x, y, z)`, which what is cut and stands in no cell needs
MOST_BARE = 8  # cells of a split of which none repeat
EXACT = 0.5  # of what does not count: as near a symbol has to be to stand in a cell as it is


Corner: TypeAlias = tuple[float, ...]
Home: TypeAlias = tuple[int, Corner]


@dataclass(frozen=True, slots=True, eq=False)
class _Cutting:
    """Contents in a scope, about to be cut along an axis between groups; bare: how many splits
    around it have no cells that repeat.
    """

    inside: Contents
    size: Floats
    axis: int
    groups: Groups
    bare: int


@dataclass(slots=True, eq=False)
class Building:
    """small: units that do not count. made: symbols, each before those that place it; new: their
    numbers for symbols of the scheme that is rewritten; items: of the rule that is rewritten,
    with new symbols; free: symbols that cost nothing here, as others need them anyway.
    """

    small: float
    made: list[Symbol] = field(default_factory=list)
    new: dict[int, int] = field(default_factory=dict)
    items: tuple[Place | Array | Ring, ...] = ()
    free: frozenset[int] = frozenset()
    _cost: list[int] = field(default_factory=list)
    _homes: list[dict[Home, int]] = field(default_factory=list)
    _below: list[frozenset[int]] = field(default_factory=list)
    _known: dict[bytes, list[tuple[Corner, Contents, Floats, int]]] = field(default_factory=dict)
    _wraps: dict[tuple[int | None, int, int], list[tuple[int, float, Floats]]] = field(
        default_factory=dict
    )
    _cuts: dict[tuple[int, bytes], list[tuple[Groups, list[Run]]]] = field(default_factory=dict)
    _left: int = MOST

    # -------------------------------------------------------------- symbols

    def add(self, symbol: Symbol) -> int:
        """A new symbol."""
        named = named_symbols(symbol)
        self.made.append(symbol)
        number = len(self.made) - 1
        self._cost.append(self._own_cost(symbol))
        self._homes.append(dict(self._at_home(symbol)))
        self._below.append(frozenset({number}).union(*(self._below[each] for each in named)))
        return number

    def _own_cost(self, symbol: Symbol) -> int:
        if isinstance(symbol, Terminal):
            return ASSET
        free = [item for item in symbol.items if not isinstance(item, Split | Octant)]
        sized = {item.symbol for item in free if is_cut(self.made[item.symbol])}
        own = rule_tokens(symbol, self.small) + SIZED * len(sized)
        return own - sum(map(bonus, symbol.items))

    def cost(self, number: int) -> int:
        """Of a symbol and all that it needs and that is not free, where each terminal is at home in
        the place where most of its copies stand in their rules.
        """
        needed = self._below[number] - self.free
        saved: dict[int, dict[Home, int]] = {}
        for each in needed:
            for home, tokens in self._homes[each].items():
                own = saved.setdefault(home[0], {})
                own[home] = own.get(home, 0) + tokens
        at_home = sum(max(own.values()) for own in saved.values())
        return sum(self._cost[each] for each in needed) - at_home

    def _at_home(self, symbol: Symbol) -> Iterator[tuple[Home, int]]:
        """Where terminals stand alone in a rule, and the tokens which that takes."""
        single = [
            item
            for item in (symbol.items if isinstance(symbol, Rule) else ())
            if isinstance(item, Place) and len(item.frames) == 1
            if isinstance(self.made[item.symbol], Terminal)
        ]
        if single:
            frames = join([item.frames for item in single])
            tokens = placement_tokens(frames, self.small) - 1
            place = np.round(frames.position / (16 * self.small))
            for item, own, at in zip(single, tokens.tolist(), place.tolist(), strict=True):
                if own:
                    yield (item.symbol, tuple(at)), own

    def below(self, number: int) -> frozenset[int]:
        """All symbols that a symbol needs, with itself."""
        return self._below[number]

    # -------------------------------------------------------------- contents

    def build(self, inside: Contents, size: Floats, bare: int = 0) -> int:
        """The symbol for contents in a scope of this size; bare: how many splits around it have no
        cells that repeat.
        """
        inside = sorted_rows(inside, self.small)
        known = self._known.setdefault(inside.kind.tobytes(), [])
        here = tuple(inside.frames.position[0].tolist())
        for first, other, extent, number in known:
            if any(abs(a - b) > self.small for a, b in zip(here, first, strict=True)):
                continue  # most differ in their first row already
            fits = np.abs(extent - size).max() <= self.small or not is_cut(self.made[number])
            if fits and same(inside, other, self.small):
                return number
        options = [self._plain(inside, size)]
        if self._left > 0 and 1 < len(inside) <= MOST:
            self._left -= 1
            options += self._splits(inside, size, bare)
        number = min(options, key=self.cost)
        known.append((here, inside, size, number))
        return number

    def _plain(self, inside: Contents, size: Floats) -> int:
        """Contents as copies and rows; a single symbol that fills the scope is itself."""
        if len(inside) == 1:
            number = self.new[int(inside.symbol[0])]
            if self._fills(inside.frames, number, size):
                return number
        return self.add(Rule("", size, tuple(self.placed(inside))))

    def _fills(self, frames: Frames, number: int, size: Floats) -> bool:
        """Whether a symbol can stand in a scope of this size as it is."""
        symbol = self.made[number]
        at_home = np.abs(frames.position).max() <= EXACT * self.small
        upright = frames.rotation[0, 0] == 1.0 and frames.hand[0] > 0 and frames.scale[0] == 1.0
        own = not is_cut(symbol) or np.abs(symbol.size - size).max() <= self.small
        return bool(at_home and upright and own)

    def placed(self, inside: Contents) -> Iterator[Item]:
        """Contents as the items that they came from where all of those are there, else as rows
        where there are any.
        """
        loose = np.ones(len(inside), np.bool_)
        for number in np.unique(inside.item[inside.item >= 0]).tolist():
            here = inside.item == number
            item = self.items[number]
            if here.sum() == _count(item):
                loose &= ~here
                yield moved(item, inside.offset)
        rest = loose.nonzero()[0]
        kinds: dict[int, list[int]] = {}
        for row, kind in zip(rest.tolist(), inside.kind[rest].tolist(), strict=True):
            kinds.setdefault(kind, []).append(row)
        for _, rows in sorted(kinds.items()):
            alike = inside.frames[np.array(rows)]
            yield from self._rows(self.new[int(inside.symbol[rows[0]])], alike)

    def _rows(self, symbol: int, alike: Frames) -> Iterator[Item]:
        if len(alike) < 3:
            yield Place(symbol, alike)
            return
        found, rest = lattices(alike.position, self.small)
        single = [rest]
        for lattice in found:
            directions = tuple(map(Direction, lattice.counts, lattice.steps))
            array = Array(symbol, alike[lattice.rows[:1]], directions)
            place = Place(symbol, alike[lattice.rows])
            if item_tokens(array, self.small) < item_tokens(place, self.small):
                yield array
            else:
                single.append(lattice.rows)
        rows = np.sort(np.concatenate(single))
        if len(rows):
            yield Place(symbol, alike[rows])

    # -------------------------------------------------------------- splits

    def _splits(self, inside: Contents, size: Floats, bare: int) -> list[int]:
        found = []
        for axis in (2, 0, 1):  # of ways that cost the same, floors of bays
            for groups, chosen in self.cuts(inside, axis):
                if all(run.count == 1 for run in chosen) and (bare or len(chosen) > MOST_BARE):
                    continue
                cutting = _Cutting(inside, size, axis, groups, bare)
                for each in ways(chosen):
                    laid = spans(groups, each, float(size[axis]), self.small)
                    if laid is not None:
                        found.append(self._split(cutting, laid))
        return found

    def cuts(self, inside: Contents, axis: int) -> list[tuple[Groups, list[Run]]]:
        """The ways to cut sorted contents along an axis, each with its runs of groups."""
        columns = (inside.kind, inside.low, inside.high, inside.frames.position)
        key = (axis, b"".join(column.tobytes() for column in columns))
        if key not in self._cuts:
            self._cuts[key] = [
                (groups, runs(inside, groups, axis, self.small))
                for groups in side_by_side(inside, axis, self.small)
            ]
        return self._cuts[key]

    def _split(self, cutting: _Cutting, laid: list[Span]) -> int:
        if any(span.count > 1 for span in laid):
            cutting = replace(cutting, bare=0)
        else:
            cutting = replace(cutting, bare=cutting.bare + 1)
        cells = tuple(self._cell(cutting, span) for span in laid)
        split = Split(cutting.axis, self._settled(cells, cutting.size, cutting.axis))
        behind = cutting.inside[cutting.groups.backdrop]
        items = tuple(self.placed(behind)) if len(behind) else ()
        return self.add(Rule("", cutting.size, (*items, split)))

    def _cell(self, cutting: _Cutting, span: Span) -> Cell:
        if span.empty:
            return Cell(span.length, None, elastic=span.elastic)
        rows: Integers = np.concatenate(cutting.groups.rows[span.first : span.last])
        along = np.eye(3)[cutting.axis]
        own = np.where(along > 0, span.length, cutting.size)
        inside = cutting.inside[rows].moved(-span.low * along)
        symbol = self.build(inside, own, cutting.bare)
        return Cell(span.length, symbol, span.count, span.elastic)

    def _settled(self, cells: tuple[Cell, ...], size: Floats, axis: int) -> tuple[Cell, ...]:
        """Cells that come out as they are: what repeats shares a length by the length of a cell,
        so that counts which differ need scopes of their own.
        """
        counts = {cell.count for cell in cells if cell.count > 1}
        if len(counts) < 2:
            return cells
        return tuple(cell if cell.count == 1 else self._wrapped(cell, size, axis) for cell in cells)

    def _wrapped(self, cell: Cell, size: Floats, axis: int) -> Cell:
        whole = cell.length * cell.count
        own = np.where(np.arange(3) == axis, whole, size)
        for number, length, extent in self._wraps.get((cell.symbol, axis, cell.count), ()):
            if max(abs(length - cell.length), np.abs(extent - own).max()) <= self.small:
                return Cell(whole, number, elastic=True)
        number = self.add(Rule("", own, (Split(axis, (cell,)),)))
        known = self._wraps.setdefault((cell.symbol, axis, cell.count), [])
        known.append((number, cell.length, own))
        return Cell(whole, number, elastic=True)


def repeats(item: Item) -> TypeGuard[Split]:
    """Whether an item is a split with cells that repeat."""
    return isinstance(item, Split) and any(cell.count > 1 for cell in item.cells)


def bonus(item: Item) -> int:
    """What an item may cost more than another that draws the same."""
    if not isinstance(item, Split):
        return 0
    most = max(cell.count for cell in item.cells)
    return -BONUS if most == 1 else BONUS * (most > 2)


def is_cut(symbol: Symbol) -> bool:
    """Whether the size of a symbol's scope matters to what it draws."""
    items = symbol.items if isinstance(symbol, Rule) else ()
    return any(isinstance(item, Split | Octant) for item in items)


def _count(item: Place | Array | Ring) -> int:
    match item:
        case Place():
            return len(item.frames)
        case Array():
            whole = np.prod([direction.count for direction in item.directions])
            return int(whole) - len(item.holes)
        case Ring():
            return item.count - len(item.holes)
