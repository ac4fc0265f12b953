"""What rules leave of a drawing as the one table of a residual: in which layer each element is
painted, and how far it is from where rules have it.

Takes a book of rules; gives the table, if there is something to say: of each element, or of those
alone that are not painted where they are drawn, or not where rules have them. What a lattice leaves
of its own members stands in a table of its own, and nothing here decides which rules there are.
"""

from __future__ import annotations

from bisect import bisect_left

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ast
from ipmlang.inverse.lsystem.symbols import Integers
from ipmlang.inverse.naming import Names
from ipmlang.inverse.numbers import number
from ipmlang.inverse.simplify import AXIOM, Book


def rest_table(book: Book, names: Names, error: float) -> list[ast.Table]:
    """The layer of each element where rules draw them in another order than they are painted, and
    how far each is from where they have it, for what has no table of its own; error: units.
    """
    order = book.paint_order()
    columns: dict[str, list[float]] = {}
    if order is not None:
        columns["layer"] = order.astype(np.float64).tolist()
    if book.shift:
        count = int(book.extent[book.bodies[AXIOM].parts].sum())
        ranks = np.arange(count) if order is None else order
        shift = np.array([book.shift.get(rank, 0j) for rank in ranks.tolist()])
        columns |= {"x": shift.real.tolist(), "y": shift.imag.tolist()}
    if not columns:
        return []
    rooms = {"of": 0.0, "layer": 0.0, "x": error, "y": error}
    columns = _of_some(columns, error)
    cells = [[number(value, rooms[name]) for value in values] for name, values in columns.items()]
    rows = tuple(zip(*cells, strict=True))
    return [ast.Table(names.give("Rest" if book.shift else "Order"), None, tuple(columns), rows)]


def _of_some(columns: dict[str, list[float]], error: float) -> dict[str, list[float]]:
    """Without the rows that say nothing, numbered by what they are of, where that is shorter."""
    every = {name: np.array(values) for name, values in columns.items()}
    told = np.zeros(len(next(iter(every.values()))), np.bool_)
    for name, values in every.items():
        told |= _overtaken(values.astype(np.int64)) if name == "layer" else np.abs(values) > error
    rows = np.flatnonzero(told)
    if not len(rows) or len(rows) * (len(columns) + 1) >= len(told) * len(columns):
        return columns
    some = {name: values[rows].tolist() for name, values in every.items()}
    return {"of": rows.astype(np.float64).tolist(), **some}


def _overtaken(order: Integers) -> NDArray[np.bool_]:
    """(n,) those beside the most ranks that rise from one to the next: the rest follows from these.

    >>> _overtaken(np.array([0, 4, 1, 2, 3])).tolist()
    [False, True, False, False, False]
    """
    ends: list[int] = []  # the least rank that so many rising ones can end with
    place = np.empty(len(order), np.int64)
    for k, rank in enumerate(order.tolist()):
        place[k] = bisect_left(ends, rank)
        ends[place[k] : place[k] + 1] = [rank]
    kept = np.ones(len(order), np.bool_)
    wanted, least = len(ends) - 1, len(order)
    for k in range(len(order) - 1, -1, -1):
        if wanted >= 0 and place[k] == wanted and order[k] < least:
            kept[k], wanted, least = False, wanted - 1, int(order[k])
    return kept
