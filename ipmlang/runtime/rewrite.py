"""One parallel step of rewriting: the successors of all shapes of a symbol, batched by production.

In go batches of shapes, out come blocks: for each production taken, its rows and the modules of its
body as columns (constants stay constants, brackets have none). A block knows how many modules each
row became and can say where each of them stands once its row has a place, so no string is copied
while it grows. Keys are path keys; nothing depends on the order of rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.runtime import keys
from ipmlang.runtime.choose import Choice, Match, ShapeError, Taken, fresh, module, told
from ipmlang.runtime.keys import Words
from ipmlang.runtime.replay import Recording, Replay
from ipmlang.runtime.scan import Whole
from ipmlang.runtime.values import Batch, Bound, Flags, Value, joined

# what becomes of a module for which no production is taken: an error; it stays, with a key of its
# own so that the draws of its next step are new; it stays as it is
Rest: TypeAlias = Literal["refuse", "again", "leave"]

WALK_BYTES = 120  # a module, until its row of the instance table stands
OPEN = -1  # `symbol` of an opening bracket
CLOSE = -2


def _stopped(kind: str, limit: int, what: str, reached: int) -> ShapeError:
    return ShapeError(
        fail(
            f"limit-{kind}",
            f"the derivation stopped at its limit of {limit:,} {what} would bring it to "
            f"{reached:,}",
            hint=f"a guard or `steps` ends the growth; `limit {kind}` raises the limit",
        )
    )


def no_words() -> Words:
    """The keys of modules that need none."""
    return np.zeros(0, np.uint32)


@dataclass(slots=True, eq=False)
class Modules:
    """`count` modules of one symbol, columns in any order.

    `params`: a number, or one a module; k0, k1 (count,) words of the keys, empty where nothing asks
    for them; `rule` the production that made them, a number or (count,); `silent` those that draw
    nothing. `leaves`: how many modules of the final string each becomes. `place`: their positions.
    """

    symbol: int
    count: int
    params: tuple[Value, ...] = ()
    k0: Words = field(default_factory=no_words)
    k1: Words = field(default_factory=no_words)
    rule: int | NDArray[np.int32] = -1
    silent: Flags | None = None
    leaves: Whole | int = 1
    place: Whole = field(default_factory=lambda: np.zeros(0, np.int64))


@dataclass(slots=True, eq=False)
class Copies:
    """A repeat in a body: row r of `items` belongs to row owner[r] of the body around it. `leaves`:
    (r,) how many modules of the final string each of these rows becomes, as last counted.
    """

    owner: Whole
    counts: Whole
    items: list[Item]
    leaves: Whole | None = None


Item: TypeAlias = Modules | Copies


@dataclass(slots=True, eq=False)
class Block:
    """The successors of those shapes of a batch (`rows`) that took one production."""

    rows: Whole
    items: list[Item]


class Budget:
    """What a derivation has made so far, against its limits; asked before anything is allocated."""

    def __init__(self, limits: ir.Limits) -> None:
        self.limits = limits
        self.shapes = 0
        self.ruled = 1  # the start, and modules that rules may rewrite
        self.bytes = 0

    def take(self, program: ir.Program, production: ir.Production, shapes: int, size: int) -> None:
        """Note `shapes` more modules of `size` bytes in all, or stop with the rule that grew."""
        self.shapes += shapes
        self.bytes += size
        name = told(program, production)
        if self.shapes > self.limits.shapes:
            raise _stopped("shapes", self.limits.shapes, f"shapes: {name}", self.shapes)
        if self.bytes > self.limits.memory:
            raise _stopped("memory", self.limits.memory, f"bytes: {name}", self.bytes)

    def note(self, count: int, silent: Flags | None) -> None:
        """Note modules whose symbols have rules, without those that draw nothing."""
        self.ruled += count if silent is None else count - int(np.count_nonzero(silent))

    def walk(self, length: int) -> None:
        """Ask for what a turtle needs that walks `length` modules."""
        size = length * WALK_BYTES
        if size > self.limits.memory:
            raise fail(
                "limit-memory",
                f"to draw the {length:,} modules of the last string takes about {size:,} bytes, "
                f"more than the limit of {self.limits.memory:,}",
                hint="fewer steps make it smaller; `limit memory` raises the limit",
            )


class Rewriter:
    """A bound program, ready to rewrite batches of its symbols. `draws`: where the choices of
    productions come from, or are noted.
    """

    def __init__(
        self, bound: Bound, budget: Budget, draws: Replay | Recording | None = None
    ) -> None:
        self.bound = bound
        self.draws = draws
        self.program = bound.program
        self.budget = budget
        self.keyed = [_needs_keys(symbol) for symbol in self.program.symbols]
        self._ruled = [bool(own.productions or own.interpretation) for own in self.program.symbols]

    def axiom(self, seed: int) -> Block:
        """The axiom's modules, from the seed's root key."""
        k0, k1 = (np.array([word], np.uint32) for word in keys.root(seed))
        batch = Batch(self.bound, 1, (), k0, k1)
        return Block(np.zeros(1, np.int64), self._body(-1, self.program.axiom, batch))

    def step(
        self,
        batch: Batch,
        symbol: int,
        numbers: tuple[int, ...],
        match: Match | None,
        rest: Rest,
        place: Whole,
    ) -> list[Block]:
        """Blocks that cover every shape of the batch; `rest` says what becomes of a module for
        which no production is taken. `place` orders the shapes where draws are noted or known.
        """
        taken, left = self._choose(batch, numbers, match, place)
        blocks = [Block(each.rows, self._successor(each)) for each in taken]
        if not len(left):
            return blocks
        if rest == "refuse":
            raise ShapeError(self._none(batch, symbol, left), int(left[0]))
        kept = batch.take(left)
        self.budget.note(kept.count, kept.silent)
        return [*blocks, Block(left, [_stayed(kept, symbol, rest)])]

    def _none(self, batch: Batch, symbol: int, left: Whole) -> IpmError:
        more = f", nor of {len(left) - 1:,} more" if len(left) > 1 else ""
        return fail(
            "no-production",
            f"no production of {module(batch, symbol, int(left[0]))} applies{more}",
            hint=f"write `{self.program.symbols[symbol].name} : else --> nil` to end silently",
        )

    def _successor(self, taken: Taken) -> list[Item]:
        production = self.program.productions[taken.production]
        try:
            return self._body(taken.production, production, taken.batch)
        except ShapeError as found:
            raise ShapeError(found.error, int(taken.rows[found.row])) from found

    def _choose(
        self, batch: Batch, numbers: tuple[int, ...], match: Match | None, place: Whole
    ) -> tuple[list[Taken], Whole]:
        first = self.program.productions[numbers[0]]
        free = first.chance is None and first.guard is None
        if free and not first.left and not first.right:
            every = np.arange(batch.count)
            return [Taken(numbers[0], every, fresh(batch))], every[:0]
        if self.draws is not None:
            return self.draws.choose(batch, numbers, match, place)
        return Choice(batch, numbers, match).walk()

    def _body(self, number: int, production: ir.Production, batch: Batch) -> list[Item]:
        size = sum(self._bytes(each) for each in production.body)
        shapes = sum(each.op in ("module", "open", "close") for each in production.body)
        self.budget.take(self.program, production, shapes * batch.count, size * batch.count)
        return self._items(number, production, production.body, batch)

    def _items(
        self, number: int, production: ir.Production, body: Sequence[ir.Instruction], batch: Batch
    ) -> list[Item]:
        items: list[Item] = []
        for each in body:
            if each.op == "module":
                items.append(self._module(number, production, each, batch))
            elif each.op == "open" or each.op == "close":
                items.append(Modules(OPEN if each.op == "open" else CLOSE, batch.count))
            elif each.op == "repeat":
                items.append(self._copies(number, production, each, batch))
            else:
                batch.evaluate((each,))
        return items

    def _module(
        self, number: int, production: ir.Production, each: ir.Instruction, batch: Batch
    ) -> Modules:
        assert isinstance(each.const, int)
        params = tuple(batch.get(register) for register in each.args)
        for value in params:
            known = isfinite(value) if isinstance(value, float) else np.isfinite(value).all()
            if not known and batch.count:
                name = self.program.symbols[each.const].name
                raise self._not_finite(production, f"an argument of {name} is not a", value)
        k0 = k1 = no_words()
        if self.keyed[each.const]:
            k0, k1 = keys.child(batch.k0, batch.k1, each.site, *batch.numbers())
        if self._ruled[each.const]:
            self.budget.note(batch.count, batch.silent)
        return Modules(each.const, batch.count, params, k0, k1, number, batch.silent)

    def _copies(
        self, number: int, production: ir.Production, each: ir.Instruction, batch: Batch
    ) -> Copies:
        assert isinstance(each.const, int)
        limit = batch.column(each.args[0])
        if not np.isfinite(limit).all():
            raise self._not_finite(production, "the count of a repeat is no", limit)
        for hole in (batch.get(register) for register in each.args[1:]):
            if batch.count and not np.isfinite(hole).all():
                raise self._not_finite(production, "an argument of except is not a", hole)
        counts = copies_of(limit)
        total = int(min(counts.sum(), 2**62))
        size = sum(self._bytes(inner) for inner in each.body)
        shapes = sum(inner.op in ("module", "open", "close") for inner in each.body)
        self.budget.take(self.program, production, shapes * total, (size + 24) * total)
        whole = counts.astype(np.int64)
        inner = batch.repeated(each.const, whole, each.args[1:])
        assert inner.owner is not None
        try:
            items = self._items(number, production, each.body, inner)
        except ShapeError as found:
            raise ShapeError(found.error, int(inner.owner[found.row])) from found
        return Copies(inner.owner, whole, items)

    def _not_finite(self, production: ir.Production, what: str, value: Value) -> ShapeError:
        """The error of a number that is none, at the first row that has one."""
        error = fail("not-a-number", f"{told(self.program, production)}: {what} finite number")
        return ShapeError(error, int(np.argmin(np.isfinite(np.atleast_1d(value)))))

    def _bytes(self, each: ir.Instruction) -> int:
        """What one row of an instruction may cost until the string is laid out."""
        if each.op != "module" or not isinstance(each.const, int):
            return 8
        return 16 + 8 * len(each.args) + 24 * self.keyed[each.const]


def copies_of(limits: NDArray[np.float64]) -> NDArray[np.float64]:
    """How many i = 0, 1, 2, … lie below each limit, where equal means equal up to 1e-9 of it."""
    return np.maximum(np.ceil(limits - 1e-9 * np.maximum(1, np.abs(limits))), 0)


def _stayed(batch: Batch, symbol: int, rest: Rest) -> Modules:
    k0, k1 = batch.k0, batch.k1
    if rest == "again":
        k0, k1 = keys.child(k0, k1, keys.CHOICE_SITE)
    return Modules(symbol, batch.count, batch.params, k0, k1, -1, batch.silent)


def _needs_keys(symbol: ir.Symbol) -> bool:
    drawing = {"segment", "emit", "polygon_close", "path_close", "uniform"}
    return bool(
        symbol.productions
        or symbol.interpretation
        or any(each.op in drawing for each in symbol.meaning or ())
    )


def leaves(items: Sequence[Item], count: int) -> Whole:
    """How many modules of the final string each row of a body becomes, (count,)."""
    total = np.zeros(count, np.int64)
    alike = 0
    for item in items:
        own = item.leaves if isinstance(item, Modules) else _copied(item)
        if isinstance(own, int):
            alike += own
        else:
            total += own
    return total + alike


def _copied(item: Copies) -> Whole:
    item.leaves = leaves(item.items, len(item.owner))
    sums, ends = _sums(item.leaves), np.cumsum(item.counts)
    inside: Whole = sums[ends] - sums[ends - item.counts]
    return inside


def _sums(counts: Whole) -> Whole:
    """The sums of so many first counts, from none to all."""
    made = np.zeros(len(counts) + 1, np.int64)
    np.cumsum(counts, out=made[1:])
    return made


def lay(items: Sequence[Item], start: Whole) -> None:
    """Give the modules of a body their places; each row's first one stands at `start` (n,). What
    each row becomes is what `leaves` counted last.
    """
    for item in items:
        if isinstance(item, Modules):
            item.place = start
            start = start + item.leaves
        else:
            if item.leaves is None:
                item.leaves = leaves(item.items, len(item.owner))
            before, ends = _sums(item.leaves), np.cumsum(item.counts)
            first = before[ends - item.counts]
            lay(item.items, (start - first)[item.owner] + before[:-1])
            start = start + before[ends] - first


def modules(items: Sequence[Item]) -> list[Modules]:
    """All modules of a body, those in repeats too."""
    found: list[Modules] = []
    for item in items:
        found += [item] if isinstance(item, Modules) else modules(item.items)
    return found


def _joined_rules(parts: Sequence[Modules], counts: Sequence[int]) -> NDArray[np.int32]:
    rules = [part.rule for part in parts]
    if not any(isinstance(rule, np.ndarray) for rule in rules):
        return np.repeat(np.array(rules, np.int32), counts)
    columns = [np.broadcast_to(rule, (count,)) for rule, count in zip(rules, counts, strict=True)]
    return np.concatenate(columns, dtype=np.int32)


def merged(parts: Sequence[Modules]) -> Modules:
    """Modules of one symbol from several bodies as one; `leaves` is not carried over."""
    if len(parts) == 1:
        return replace(parts[0])
    counts = [part.count for part in parts]
    columns = zip(*(part.params for part in parts), strict=True)
    silent: Flags | None = None
    if any(part.silent is not None for part in parts):
        silent = np.concatenate(
            [np.zeros(p.count, np.bool_) if p.silent is None else p.silent for p in parts]
        )
    return Modules(
        parts[0].symbol,
        sum(counts),
        tuple(joined(column, counts) for column in columns),
        np.concatenate([part.k0 for part in parts]),
        np.concatenate([part.k1 for part in parts]),
        _joined_rules(parts, counts),
        silent,
        place=np.concatenate([part.place for part in parts]),
    )
