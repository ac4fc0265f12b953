"""What rules leave of a drawing as the one table of a residual: in which layer each element is
painted, and how far it is from where rules have it.

Takes a book of rules; gives the table, if there is something to say. What a lattice leaves of its
own members stands in a table of its own, and nothing here decides which rules there are.
"""

from __future__ import annotations

import numpy as np

from ipmlang.compiler import ast
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
    rooms = {"layer": 0.0, "x": error, "y": error}
    cells = [[number(value, rooms[name]) for value in values] for name, values in columns.items()]
    rows = tuple(zip(*cells, strict=True))
    return [ast.Table(names.give("Rest" if book.shift else "Order"), None, tuple(columns), rows)]
