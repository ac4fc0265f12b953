"""What a derivation has made so far, against its limits, and the way to where it stands.

Bodies and batches report what they are about to make before they allocate it; past a limit the
error names the rule that grew, the counts, and a trail such as `Lot > Floor[3] > Tile[7]`.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import Diagnostic, IpmError
from ipmlang.runtime.choose import told
from ipmlang.runtime.order import Copies, Made, Order, Record, Slot

SHAPE_BYTES = 130  # of a shape that waits
DRAWING_BYTES = 300  # of a drawing, until the instance table stands
LONGEST = 8  # names in a trail, at each end


class Counted:
    """Counts of one derivation."""

    def __init__(self, program: ir.Program, limits: ir.Limits) -> None:
        self._program = program
        self._limits = limits
        self.shapes = 1
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
        if self.shapes > self._limits.shapes:
            self._stop("shapes", self._limits.shapes, self.shapes, "shapes")
        self._remember()
        return start

    def draw(self, count: int) -> None:
        """Count drawings."""
        self._drawings += count
        if self._drawings + self.shapes > 2 * self._limits.shapes:
            self._stop("shapes", self._limits.shapes, self._drawings, "drawings")
        self._remember()

    def copy(self, count: float) -> None:
        """Check copies that are about to be made."""
        if self.shapes + count > self._limits.shapes:
            self._stop("shapes", self._limits.shapes, int(min(self.shapes + count, 2**62)), "shapes")

    def deep(self, depth: int, rule: int) -> None:
        """Check how many generations there are, one below the other."""
        bound, kind = min((self._limits.steps, "steps"), (self._limits.depth, "depth"))
        if depth > bound:
            self.rule = rule
            self._stop(kind, bound, depth, "steps" if kind == "steps" else "generations deep")

    def room(self, depth: int) -> int:
        """How many generations may still follow, and one more."""
        left = min(self._limits.steps, self._limits.depth) - depth
        return max(0, min(left, self._limits.shapes - self.shapes)) + 1

    def error(
        self, code: str, message: str, *, hint: str | None = None, shape: int | None = None
    ) -> IpmError:
        """An error at the rule that is applied now, or at a shape."""
        if shape is None:
            shape = int(self.now[0]) if len(self.now) else self._one
            rule = self._program.axiom if self.rule < 0 else self._program.productions[self.rule]
            message = f"{told(self._program, rule)}: {message}"
        trail = None if self.trail is None else self.trail.to(shape)
        return IpmError([Diagnostic(code, message, hint=hint, trail=trail)])

    def _remember(self) -> None:
        needed = self.shapes * SHAPE_BYTES + self._drawings * DRAWING_BYTES
        if needed > self._limits.memory:
            self._stop("memory", self._limits.memory, needed, "bytes")

    def _stop(self, kind: str, limit: int, reached: int, unit: str) -> None:
        raise self.error(
            f"limit-{kind}",
            f"the derivation stopped at its limit of {limit:,} {kind}: it would come to "
            f"{reached:,} {unit}",
            hint=f"a guard or `steps` ends the growth; `limit {kind}` raises the limit",
        )


@dataclass(frozen=True, slots=True, eq=False)
class Trail:
    """The way from the axiom to a shape. `names`: where in the numbers each name begins."""

    order: Order
    names: Callable[[], list[tuple[int, str]]]

    def to(self, shape: int) -> str:
        """`start > Lot > Floor[3] > Tile[7]`, shortened in the middle."""
        begins = [begin for begin, _ in self.names()]
        parts: list[str] = []
        while shape > 0 and len(parts) < 10_000:
            name = self.names()[bisect_right(begins, shape) - 1][1]
            shape, copy = self._parent(shape)
            parts.append(name if copy is None else f"{name}[{copy}]")
        parts.append("start")
        parts.reverse()
        if len(parts) > 2 * LONGEST:
            parts = [*parts[:LONGEST], "…", *parts[-LONGEST:]]
        return " > ".join(parts)

    def _parent(self, shape: int) -> tuple[int, int | None]:
        for record in self.order.records:
            if isinstance(record, Record):
                found = _find(record.slots, shape)
                if found is not None:
                    return int(record.shapes[found[0]]), found[1]
            elif record.first <= shape < record.last:
                for parent, items in record.steps:
                    if shape in items:
                        return parent, None
        return 0, None


def _find(slots: Sequence[Slot], shape: int) -> tuple[int, int | None] | None:
    """The row that made a shape, and the number of its copy."""
    for slot in slots:
        if isinstance(slot, Made) and slot.start <= shape < slot.start + slot.count:
            row = shape - slot.start
            return int(row if slot.rows is None else slot.rows[row]), None
        if isinstance(slot, Copies):
            found = _find(slot.slots, shape)
            if found is not None:
                owner = int(slot.owner[found[0]])
                first = int(np.searchsorted(slot.owner, owner))
                return owner, found[0] - first
    return None
