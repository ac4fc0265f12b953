"""Which production each shape of a symbol takes: guards, percentages, weights, contexts.

In go the batch of all shapes of one symbol and its productions in source order; out come, for each
production that is taken, the rows that take it with what their contexts matched. One 24-bit draw a
shape decides; nothing here rewrites.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.compiler.ops.exact import has_nan
from ipmlang.runtime import keys
from ipmlang.runtime.scan import Real, Whole
from ipmlang.runtime.values import Batch, Flags, Value, spread

# production, rows to try -> which of them match, and what the left and the right context captured
Match = Callable[[ir.Production, Whole], tuple[Flags, tuple[Value, ...], tuple[Value, ...]]]


class ShapeError(Exception):
    """An error at one row of a batch; who knows the way there adds it."""

    def __init__(self, error: IpmError, row: int = 0) -> None:
        super().__init__(error, row)
        self.error = error
        self.row = row


OVER = 1 + 1e-9  # percentages of true conditions may add up to this


@dataclass(slots=True, eq=False)
class Taken:
    """The rows (m,) that take a production, and their batch: parameters as it numbers them."""

    production: int
    rows: Whole
    batch: Batch


class Choice:
    """One symbol's shapes while their productions are walked as written."""

    def __init__(self, batch: Batch, numbers: Sequence[int], match: Match | None) -> None:
        self._batch = batch
        self._productions = [
            (number, batch.bound.program.productions[number]) for number in numbers
        ]
        self._match = match
        self._open = np.arange(batch.count)  # not yet taken by a production without a chance
        self._taken = np.full(batch.count, -1, np.int64)
        self._sum: Real | None = None
        self._draw: Real | None = None
        self._weights: dict[int, tuple[Whole, Real]] = {}
        self._tried: dict[int, Taken] = {}

    def walk(self) -> tuple[list[Taken], Whole]:
        """What is taken, and the rows for which nothing is."""
        self.draw()
        return self.result()

    def draw(self) -> None:
        """Walk the productions for every row."""
        for number, production in self._productions:
            if not len(self._open):
                break
            self._try(number, production)
        if self._sum is not None and (self._sum > OVER).any():
            raise self._over()

    def result(self) -> tuple[list[Taken], Whole]:
        """The same as `walk`, once it was drawn."""
        return list(self._results()), np.flatnonzero(self._taken < 0)

    def _results(self) -> list[Taken]:
        results = []
        for number, tried in self._tried.items():
            hit = self._taken[tried.rows] == number
            if hit.all():
                results.append(tried)
            elif hit.any():
                chosen = np.flatnonzero(hit)
                results.append(Taken(number, tried.rows[chosen], tried.batch.take(chosen)))
        return results

    def _try(self, number: int, production: ir.Production) -> None:
        if production.chance is None:
            rows = self._eligible(number, production).rows
            self._taken[rows[self._taken[rows] < 0]] = number
            self._open = self._left(rows)
            return
        rows, share = self._share(number, production)
        if self._sum is None:
            self._sum = np.zeros(self._batch.count)
            self._draw = keys.choice(self._batch.k0, self._batch.k1)
        assert self._draw is not None
        self._sum[rows] += share
        hit = rows[(self._taken[rows] < 0) & (self._draw[rows] < self._sum[rows])]
        self._taken[hit] = number

    def _left(self, rows: Whole) -> Whole:
        """The open rows without those for which a production without a chance ended the walk."""
        if len(rows) == len(self._open):
            return self._open[:0]
        ended = np.zeros(self._batch.count, np.bool_)
        ended[rows] = True
        return self._open[~ended[self._open]]

    def _share(self, number: int, production: ir.Production) -> tuple[Whole, Real]:
        """The rows for which a production with a chance may be taken, and how likely it is."""
        assert production.chance is not None
        if production.chance[0] == "percent":
            tried = self._eligible(number, production)
            return tried.rows, self._amount(tried, production) / 100
        if number not in self._weights:
            self._weigh()
        return self._weights[number]

    def _weigh(self) -> None:
        """Shares of all weighted productions: weights over the sum of those that may be taken."""
        total = np.zeros(self._batch.count)
        found = []
        for number, production in self._productions:
            if production.chance is not None and production.chance[0] == "weight":
                tried = self._eligible(number, production)
                weight = self._amount(tried, production)
                total[tried.rows] += weight
                found.append((number, tried.rows, weight))
        for number, rows, weight in found:
            below = total[rows]
            share = np.divide(weight, below, out=np.zeros_like(weight), where=below > 0)
            self._weights[number] = (rows, share)

    def _amount(self, tried: Taken, production: ir.Production) -> Real:
        assert production.chance is not None
        _, instructions, register = production.chance
        tried.batch.evaluate(instructions)
        amount = tried.batch.column(register)
        wrong = np.flatnonzero(~((amount >= 0) & (amount < np.inf)))
        if len(wrong):
            error = out_of_range(tried.batch.bound.program, production, float(amount[wrong[0]]))
            raise ShapeError(error, int(tried.rows[wrong[0]]))
        return np.array(amount)

    def _eligible(self, number: int, production: ir.Production) -> Taken:
        """The open rows whose context matches and whose guard holds."""
        rows = self._open
        batch = self._batch if len(rows) == self._batch.count else self._batch.take(rows)
        if self._match is not None and (production.left or production.right):
            matched, left, right = self._match(production, rows)
            kept = np.flatnonzero(matched)
            rows, batch = rows[kept], batch.take(kept)
            chosen = [tuple(spread(value, kept) for value in side) for side in (left, right)]
            batch.params = (*chosen[0], *batch.params, *chosen[1])
        elif batch is self._batch:
            batch = fresh(batch)
        if production.guard is not None and not production.otherwise:
            instructions, register = production.guard
            batch.evaluate(instructions)
            holds = self._holds(production, rows, batch.column(register))
            if not holds.all():
                kept = np.flatnonzero(holds)
                rows, batch = rows[kept], batch.take(kept)
        self._tried[number] = Taken(number, rows, batch)
        return self._tried[number]

    def _holds(self, production: ir.Production, rows: Whole, truth: Real) -> Flags:
        """For which rows a guard holds. NaN is an error, unless answers are yet to come."""
        holds: Flags = truth != 0
        if not has_nan(truth):
            return holds
        scope = self._batch.scope
        if scope is not None and scope.measures.first_pass:
            return holds & ~np.isnan(truth)
        wrong = np.flatnonzero(np.isnan(truth))
        error = no_truth(self._batch.bound.program, production, len(wrong))
        raise ShapeError(error, int(rows[wrong[0]]))

    def _over(self) -> ShapeError:
        assert self._sum is not None
        row = int(np.argmax(self._sum))
        name = module(self._batch, self._productions[0][1].symbol, row)
        return ShapeError(over(name, float(self._sum[row])), row)


def over(name: str, total: float) -> IpmError:
    """The error of percentages that add up to more than 1."""
    return fail(
        "over-100-percent",
        f"the percentages of {name} add up to {total * 100:g}, but must not exceed 100",
        hint="guards that exclude each other, or smaller percentages, mend this",
    )


def out_of_range(program: ir.Program, production: ir.Production, amount: float) -> IpmError:
    """The error of a percentage or weight below 0, infinite or NaN."""
    weight = production.chance is not None and production.chance[0] == "weight"
    name = f"{told(program, production)}: its {'weight' if weight else 'percentage'}"
    if math.isnan(amount):
        return fail("not-a-number", f"{name} is not a number")
    return fail("out-of-range", f"{name} is {amount:g}, but must be a number from 0 on")


def no_truth(program: ir.Program, production: ir.Production, count: int = 1) -> IpmError:
    """The error of a guard that is NaN for so many shapes."""
    shapes = "" if count == 1 else f" for {count:,} shapes"
    return fail(
        "not-a-number",
        f"{told(program, production)}: its guard is neither true nor false{shapes}",
        hint="it hangs on what is not a number, such as 0 / 0 or the root of less than 0; "
        "`x > 0 and sqrt(x) < 2` is false where x is less than 0",
    )


def fresh(batch: Batch) -> Batch:
    """The same shapes with no registers."""
    return Batch(batch.bound, batch.count, batch.params, batch.k0, batch.k1, batch.silent,
                 scope=batch.scope)  # fmt: skip


def module(batch: Batch, symbol: int, row: int) -> str:
    """One shape as its grammar would write it: `A(3, 0.5)`."""
    own = batch.bound.program.symbols[symbol]
    written = batch.params[: own.arity - own.carried]
    values = [float(np.broadcast_to(value, (batch.count,))[row]) for value in written]
    return f"{own.name}({', '.join(f'{value:g}' for value in values)})" if values else own.name


def told(program: ir.Program, production: ir.Production) -> str:
    """A production as messages name it: `rule A (plant.ipm:7)`."""
    name = "start" if production.symbol < 0 else f"rule {program.symbols[production.symbol].name}"
    return f"{name} ({production.path}:{production.line})" if production.line else name
