"""What a derivation has made so far, against its limits, and the way to where it stands.

Bodies and batches report what they are about to make before they allocate it; past a limit the
error names the rule that grew, the counts, and a trail such as `Lot > Floor[3] > Tile[7]`.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import Diagnostic, IpmError
from ipmlang.runtime.choose import told
from ipmlang.runtime.order import Copies, Made, Order, Record, Slot

SHAPE_BYTES = 130  # of a shape that waits
DRAWING_BYTES = 300  # of a drawing, until the instance table stands
UNITS = {
    "shapes": "shapes",
    "steps": "steps",
    "depth": "generations, one below the other",
    "memory": "bytes of memory",
}


@dataclass(frozen=True, slots=True)
class Bounds:
    """How much a derivation may still make: shapes, shapes and drawings together, generations in
    all, bytes of memory.
    """

    shapes: int
    drawn: int
    generations: int
    memory: int


LONGEST = 8  # names in a trail, at each end


class Counted:
    """Counts of one derivation."""

    def __init__(self, program: ir.Program, limits: ir.Limits) -> None:
        self._program = program
        self._limits = limits
        self.shapes = 1
        self.strung = 0  # modules of strings, which nobody numbers
        self._drawings = 0
        self.rule = -1
        self.now: NDArray[np.int32] = np.zeros(1, np.int32)
        self._one = 0
        self.trail: Trail | None = None

    def at(self, rule: int, shapes: NDArray[np.int32]) -> None:
        """Note which rule is about to be applied to which shapes."""
        self.rule = rule
        self.now = shapes

    def one(self, shape: int) -> None:
        """The same for one shape whose rule is still to be chosen."""
        self._one = shape
        self.now = np.zeros(0, np.int32)

    def make(self, count: int) -> int:
        """Count new shapes; the number of the first."""
        start = self.shapes
        self.shapes += count
        if self.shapes + self.strung > self._limits.shapes:
            self._stop("shapes", self._limits.shapes, self.shapes + self.strung)
        self._remember()
        return start

    def draw(self, count: int) -> None:
        """Count drawings."""
        self._drawings += count
        if self._drawings + self.shapes > 2 * self._limits.shapes:
            self._stop("shapes", self._limits.shapes, self._drawings)
        self._remember()

    def copy(self, count: float) -> None:
        """Check copies that are about to be made."""
        if self.shapes + count > self._limits.shapes:
            self._stop("shapes", self._limits.shapes, int(min(self.shapes + count, 2**62)))

    def deep(self, depth: int, rule: int) -> None:
        """Check how many generations there are, one below the other."""
        bound, kind = min((self._limits.steps, "steps"), (self._limits.depth, "depth"))
        if depth > bound:
            self.rule = rule
            self._stop(kind, bound, depth)

    def left(self, depth: int) -> ir.Limits:
        """The limits of what is derived below a generation."""
        used = self.shapes * SHAPE_BYTES + self._drawings * DRAWING_BYTES
        return replace(
            self._limits,
            shapes=max(self._limits.shapes - self.shapes - self.strung, 0),
            steps=max(self._limits.steps - depth, 0),
            depth=max(self._limits.depth - depth, 0),
            memory=max(self._limits.memory - used, 0),
        )

    def bounds(self) -> Bounds:
        """What may still be made at once before one of these limits is reached."""
        limits = self._limits
        used = self.shapes * SHAPE_BYTES + self._drawings * DRAWING_BYTES
        return Bounds(
            max(limits.shapes - self.shapes - self.strung, 0),
            max(2 * limits.shapes - self.shapes - self._drawings, 0),
            min(limits.steps, limits.depth),
            max(limits.memory - used, 0),
        )

    def room(self, depth: int) -> int:
        """How many generations may still follow, and one more."""
        left = min(self._limits.steps, self._limits.depth) - depth
        return max(0, min(left, self._limits.shapes - self.shapes)) + 1

    def error(
        self,
        code: str,
        message: str,
        *,
        hint: str | None = None,
        shape: int | None = None,
        row: int = 0,
        around: Sequence[NDArray[np.int64]] = (),
    ) -> IpmError:
        """An error at a shape, or at the rule that is applied now and a row of its batch, or of
        copies: `around` are the rows that these belong to, from the innermost ones outward.
        """
        for owner in around:
            row = int(owner[min(row, len(owner) - 1)]) if len(owner) else 0
        if shape is None:
            shape = int(self.now[min(row, len(self.now) - 1)]) if len(self.now) else self._one
            rule = self._program.axiom if self.rule < 0 else self._program.productions[self.rule]
            message = f"{told(self._program, rule)}: {message}"
        trail = None if self.trail is None else self.trail.to(shape)
        return IpmError([Diagnostic(code, message, hint=hint, trail=trail)])

    def traced(self, error: IpmError, shape: int) -> IpmError:
        """An error that was raised at a shape, with the way there."""
        trail = None if self.trail is None else self.trail.to(shape)
        return IpmError([replace(each, trail=trail) for each in error.diagnostics])

    def _remember(self) -> None:
        needed = self.shapes * SHAPE_BYTES + self._drawings * DRAWING_BYTES
        if needed > self._limits.memory:
            self._stop("memory", self._limits.memory, needed)

    def _stop(self, kind: str, limit: int, reached: int) -> None:
        unit = UNITS[kind]
        raise self.error(
            f"limit-{kind}",
            f"the derivation stopped at its limit of {limit:,} {unit}: this would bring it to "
            f"{reached:,}",
            hint=f"a guard or `steps` ends the growth; `limit {kind}` raises the limit",
        )


def joined_way(parts: Sequence[str]) -> str:
    """The names on a way, shortened in the middle."""
    if len(parts) > 2 * LONGEST:
        parts = [*parts[:LONGEST], "…", *parts[-LONGEST:]]
    return " > ".join(parts)


Around = tuple[tuple[Copies, ...], Record]


@dataclass(frozen=True, slots=True, eq=False)
class Trail:
    """The way from the axiom to a shape. `names`: where in the numbers each name begins."""

    order: Order
    names: Callable[[], list[tuple[int, str]]]

    def to(self, shape: int) -> str:
        """`start > Lot > Floor[3] > Tile[7]`, shortened in the middle."""
        begins = [begin for begin, _ in self.names()]
        parents = _Parents(self.order)
        parts: list[str] = []
        first = self.order.first
        while shape >= first:
            name = self.names()[bisect_right(begins, shape) - 1][1]
            shape, copy = parents.of(shape)
            parts.append(name if copy is None else f"{name}[{copy}]")
        parts.append("start" if first == 1 else f"start[{shape}]")
        return joined_way(parts[::-1])


class _Parents:
    """Who made each shape, found when an error asks for it."""

    def __init__(self, order: Order) -> None:
        self._traced: dict[int, int] = {}
        self._made: list[tuple[int, Made, Around]] = []
        open_trace = () if order.open is None else (order.open,)
        for record in (*order.records, *open_trace):
            if isinstance(record, Record):
                self._note(record.slots, ((), record))
            else:
                self._traced.update(
                    (item, parent) for parent, items in record.steps for item in items if item > 0
                )
        self._made.sort(key=lambda each: each[0])
        self._begins = [begin for begin, _, _ in self._made]

    def of(self, shape: int) -> tuple[int, int | None]:
        """The shape that made a shape, and the number of its copy in a repeat."""
        if shape in self._traced:
            return self._traced[shape], None
        place = bisect_right(self._begins, shape) - 1
        if place < 0 or shape >= self._begins[place] + self._made[place][1].count:
            return 0, None
        begin, made, (copies, record) = self._made[place]
        row = int(shape - begin if made.rows is None else made.rows[shape - begin])
        copy = None
        for each in reversed(copies):
            owner = int(each.owner[row])
            copy = row - int(np.searchsorted(each.owner, owner)) if copy is None else copy
            row = owner
        return int(record.shapes[row]), copy

    def _note(self, slots: Sequence[Slot], around: Around) -> None:
        for slot in slots:
            if isinstance(slot, Copies):
                self._note(slot.slots, ((*around[0], slot), around[1]))
            elif isinstance(slot, Made) and slot.count:
                self._made.append((slot.start, slot, around))
