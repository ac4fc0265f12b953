"""Sparse least squares with hard values: one factorisation a topology, a cheap solve an edit.

In go equations over numbered unknowns, out come their values. Unknowns that an edit fixes are
eliminated, not weighted. What the equations mean is not known here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy import sparse

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
REGULAR = 1e-13  # what keeps an unknown that nothing speaks of where it was


@dataclass(frozen=True, slots=True, eq=False)
class Equations:
    """m equations, sums of coefficients times unknowns equal to a value, with weights.

    row, column, coefficient (k,): the terms; value (m,); weight (m,) > 0; count: of unknowns.
    """

    row: Integers
    column: Integers
    coefficient: Floats
    value: Floats
    weight: Floats
    count: int


Term = tuple[int, float]


def equations(
    terms: Sequence[Sequence[Term]], values: Sequence[float], weights: Sequence[float], count: int
) -> Equations:
    """Equations from their terms (unknown, coefficient)."""
    flat = [(row, *term) for row, own in enumerate(terms) for term in own]
    table = np.array(flat, np.float64).reshape(-1, 3)
    row, column = table[:, 0].astype(np.int64), table[:, 1].astype(np.int64)
    return Equations(
        row, column, table[:, 2], np.array(values, float), np.array(weights, float), count
    )


@dataclass(frozen=True, slots=True, eq=False)
class Factored:
    """Equations ready to be solved for any values of the `fixed` unknowns."""

    own: Equations
    fixed: Integers
    free: Integers
    rest: tuple[sparse.csr_matrix, sparse.csr_matrix]  # those of free and of fixed unknowns
    solver: Callable[[Floats], Floats] | None

    def solve(self, values: Floats, start: Floats) -> Floats:
        """(count,) the unknowns that fit best; values (f,) of the fixed ones, start (count,):
        where they are now.
        """
        found = start.astype(np.float64).copy()
        found[self.fixed] = values
        if self.solver is None:
            return found
        free, fixed = self.rest
        weight = self.own.weight
        target = self.own.value - fixed @ values
        x: Floats = found[self.free]
        for _ in range(2):  # the second round takes back what rounding cost the first
            x = x + self.solver(np.asarray(free.T @ (weight * (target - free @ x))))
        found[self.free] = x
        return found


def _columns(own: Equations, chosen: Integers) -> sparse.csr_matrix:
    """The coefficients of some unknowns."""
    from scipy import sparse

    place = np.full(own.count, -1)
    place[chosen] = np.arange(len(chosen))
    column = place[own.column]
    used = column >= 0
    cells = own.coefficient[used], (own.row[used], column[used])
    return sparse.csr_matrix(cells, (len(own.value), len(chosen)))


def factor(own: Equations, fixed: Integers) -> Factored:
    """Prepare equations whose unknowns `fixed` (f,) will be given."""
    from scipy import sparse
    from scipy.sparse.linalg import splu

    free = np.setdiff1d(np.arange(own.count), fixed)
    a, b = (_columns(own, chosen) for chosen in (free, fixed))
    if not len(free):
        return Factored(own, fixed, free, (a, b), None)
    weight = np.repeat(own.weight, np.diff(a.indptr))
    heavy = sparse.csr_matrix((a.data * weight, a.indices, a.indptr), a.shape)
    normal = (heavy.T @ a + REGULAR * sparse.eye(len(free), format="csc")).tocsc()
    options = {"SymmetricMode": True}
    solver = splu(normal, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    return Factored(own, fixed, free, (a, b), solver.solve)
