"""Along which axes scopes grow: where a person changes a size or a count to have more of something.

In go schemes with splits and rows, out come for every symbol the axes along which its scope changes
and from where to where something repeats in it. What then follows is decided elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.frames import Floats
from ipmlang.inverse.split.measuring import extents, in_cells
from ipmlang.inverse.split.rows import FEWEST, Row, rows
from ipmlang.inverse.split.scheme import Item, Place, Rule, Scheme, Split, Symbol

ALIKE = 1e-9  # of their size, that scopes may differ by and are the same
Axes = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Growing:
    """For each symbol: axes (3,) along which its scope is what a person changes to have more or
    fewer of the cells that repeat in it, or follows one that is; counted (3,): those along which
    that is so by the count of a row, not by cells. ranges: (2, 3) from where to where something
    repeats in it along each axis, in its coordinates, infinite where nothing does.
    """

    axes: list[Axes]
    counted: list[Axes]
    ranges: list[Floats]


def growing(scheme: Scheme) -> Growing:
    """How the scopes of a scheme grow. Cells go before rows, where both repeat along an axis."""
    boxes = extents(scheme)
    every = [tuple(rows(symbol, boxes)) for symbol in scheme.symbols]
    none: list[tuple[Row, ...]] = [() for _ in scheme.symbols]
    by_cells, by_all = _axes(scheme, none), _axes(scheme, every)
    counted = [both & ~cells for both, cells in zip(by_all, by_cells, strict=True)]
    ranges = [
        np.where(cells, of_cells, of_all)
        for cells, of_cells, of_all in zip(
            by_cells, _ranges(scheme, none), _ranges(scheme, every), strict=True
        )
    ]
    return Growing(by_all, counted, ranges)


def _ranges(scheme: Scheme, along_rows: list[tuple[Row, ...]]) -> list[Floats]:
    found: list[Floats] = []
    for symbol, own in zip(scheme.symbols, along_rows, strict=True):
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for row in own:
            low[row.axis] = min(low[row.axis], row.low)
            high[row.axis] = max(high[row.axis], row.high)
        for split, along in splits(symbol):
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


def _axes(scheme: Scheme, along_rows: list[tuple[Row, ...]]) -> list[Axes]:
    grown = [np.zeros(3, np.bool_) for _ in scheme.symbols]
    for number, symbol in enumerate(scheme.symbols):
        for row in along_rows[number]:
            grown[number][row.axis] = True
        for split, along in splits(symbol):
            for cell in split.cells:
                grown[number] = grown[number] | (along & (cell.count >= FEWEST))
                if cell.symbol is not None:
                    grown[number] = grown[number] | (~along & grown[cell.symbol])
    for number in in_cells(scheme) - placed_freely(scheme):
        grown[number] = np.zeros(3, np.bool_)
    for number in range(scheme.axiom, -1, -1):
        for split, along in splits(scheme.symbols[number]):
            for cell in split.cells:
                if cell.symbol is not None:
                    grown[cell.symbol] = grown[cell.symbol] | (~along & grown[number])
    return grown


def in_other_scopes(scheme: Scheme) -> set[int]:
    """Symbols that stand in cells whose size is not theirs."""
    return {
        number
        for number, scopes in _cell_scopes(scheme).items()
        if not all(_alike(scope, scheme.symbols[number].size) for scope in scopes)
    }


def with_scopes(scheme: Scheme) -> Scheme:
    """The scheme with rules as large as the cells in which they stand, where those are all alike
    and nothing in the rules hangs on their size.
    """
    free = placed_freely(scheme)
    symbols = list(scheme.symbols)
    for number, scopes in _cell_scopes(scheme).items():
        rule = symbols[number]
        if number in free or not isinstance(rule, Rule) or any(splits(rule)):
            continue
        if all(_alike(scope, scopes[0]) for scope in scopes):
            symbols[number] = replace(rule, size=scopes[0])
    return replace(scheme, symbols=tuple(symbols))


def _cell_scopes(scheme: Scheme) -> dict[int, list[Floats]]:
    """The sizes of all cells in which each symbol stands."""
    found: dict[int, list[Floats]] = {}
    for symbol in scheme.symbols:
        for split, along in splits(symbol):
            for cell in split.cells:
                if cell.symbol is not None:
                    scope = np.where(along, cell.length, symbol.size)
                    found.setdefault(cell.symbol, []).append(scope)
    return found


def _alike(scope: Floats, own: Floats) -> bool:
    return bool(np.abs(scope - own).max() <= ALIKE * np.abs(own).max())


def placed_freely(scheme: Scheme) -> set[int]:
    """The symbols that stand somewhere with a scope of their own."""
    return {
        item.symbol
        for symbol in scheme.symbols
        for item in (symbol.items if isinstance(symbol, Rule) else ())
        if not isinstance(item, Split)
    }


def splits(symbol: Symbol) -> Iterator[tuple[Split, Axes]]:
    """The splits of a rule, and which axis each is along."""
    for item in symbol.items if isinstance(symbol, Rule) else ():
        if isinstance(item, Split):
            yield item, np.arange(3) == item.axis


def follows(item: Item, axis: int) -> bool:
    """Whether an item is stretched along an axis with its scope, or anchored to its far end."""
    if not isinstance(item, Place):
        return False
    stretched = item.margins is not None and bool(np.isfinite(item.margins[:, axis]).any())
    return stretched or axis in item.anchors
