"""Rules that are said where they are used: cells and rows whose rule would be a name and no more.

Takes a scheme; gives the rules whose bodies stand in the one repeat or cell that uses them, as a
person writes `{ ~3: Post Plate }*`. A rule whose name says something, or whose body is long, keeps
its line. Nothing is printed here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from ipmlang.inverse.split.cost import HEAD, rule_tokens
from ipmlang.inverse.split.scheme import Array, Item, Place, Ring, Rule, Scheme, Split

LONGEST = 18  # tokens of a body that is read at a glance
NESTED = 24  # tokens of rows within rows of one thing


def inlined(scheme: Scheme, small: float) -> frozenset[int]:
    """The rules that are not told by name; small: units that are printed as nothing."""
    users = _users(scheme)
    chosen: set[int] = set()
    length: dict[int, int] = {}
    for number, symbol in enumerate(scheme.symbols[:-1]):
        if not isinstance(symbol, Rule):
            continue
        own = rule_tokens(symbol, small) - HEAD
        inner = [each for item in symbol.items for each in _placed(item) if each in chosen]
        length[number] = own + sum(length[each] - 1 for each in inner)
        if len(users[number]) != 1 or isinstance(users[number][0], Place) or symbol.note:
            continue
        lattice = _is_lattice(symbol.items)
        if (lattice or not symbol.name) and length[number] <= (NESTED if lattice else LONGEST):
            chosen.add(number)
    return frozenset(chosen)


def _users(scheme: Scheme) -> dict[int, list[Item]]:
    """For each symbol the items that place it, once for each cell."""
    users: dict[int, list[Item]] = {number: [] for number in range(len(scheme.symbols))}
    for symbol in scheme.symbols:
        for item in symbol.items if isinstance(symbol, Rule) else ():
            for each, often in Counter(_placed(item)).items():
                users[each] += [item] * often
    return users


def _placed(item: Item) -> list[int]:
    if isinstance(item, Split):
        return [cell.symbol for cell in item.cells if cell.symbol is not None]
    return [item.symbol]


def _is_lattice(items: Sequence[Item]) -> bool:
    """Whether all there is is one thing again and again."""
    if len(items) != 1:
        return False
    item = items[0]
    if isinstance(item, Split):
        return len(item.cells) == 1 and item.cells[0].count > 1
    return isinstance(item, Array | Ring)
