"""Splits and parts in braces to code: slabs of the scope, and pieces by selector.

In go a `split` or a block such as `comp { … }`, out come instructions: one slab a part, across an
axis of the scope or along a texture coordinate, or notes of all parts whose cuts then snap to
lines. That a part which does not fit makes no shape is the slab's doing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from ipmlang.compiler import ast, ir
from ipmlang.compiler.lower.expr import Code, Environment, Known, Operand
from ipmlang.compiler.lower.operands import operands
from ipmlang.compiler.lower.shares import Ordinal, share
from ipmlang.compiler.ops import OPERATIONS

AXES = {"x": 0, "y": 1, "z": 2, "area": 3}  # `area`: along x, measured in area
EXTENTS = {"x": "sx", "y": "sy", "z": "sz"}

# what writes the body of one part: code, elements, names
Write = Callable[[Code, Sequence[ast.Element], Environment], None]


@dataclass(frozen=True, slots=True)
class Splitting:
    """Writes splits. `numbers` gives a number to each repeat; `indices`: the attributes that hold
    `split.index` and `split.count`, None where nothing reads them.
    """

    write: Write
    numbers: Callable[[], int]
    indices: tuple[int, int] | None

    def split(self, code: Code, split: ast.Split, names: Environment) -> None:
        """Append a split."""
        if split.args:
            self._snapped(code, split, names)
        elif split.axis in ("u", "v"):
            unwrapped = _Unwrapped(self, code, split.axis)
            share(code, split.parts, unwrapped.whole, unwrapped, names)
        else:
            slabs = _Slabs(self, AXES[split.axis])
            share(code, split.parts, _whole(code, split.axis), slabs, names)

    def _snapped(self, code: Code, split: ast.Split, names: Environment) -> None:
        """Append a split whose cuts move: notes of its pieces, and what becomes of them then."""
        args = operands(code, OPERATIONS["split"], split.args, names)
        noting = _Noting(self, self.numbers(), code.own())
        share(code, split.parts, _whole(code, split.axis), noting, names)
        outer = code.block()
        for place, (part, own) in enumerate(noting.parts):
            inner = outer.block()
            if self.indices is not None:
                index = inner.load("index", noting.split)
                self.told(inner, Ordinal(index, inner.load("count", noting.split)))
            self.write(inner, part.body, own)
            outer.structure("part", (), place, inner, part.span)
        const = (AXES[split.axis], noting.split, code.site())
        code.structure("snapped", args, const, outer, split.span)

    def told(self, code: Code, ordinal: Ordinal) -> None:
        """Tell what follows which piece it is."""
        if self.indices is not None:
            code.changed[self.indices[0]] = ordinal.next
            code.changed[self.indices[1]] = ordinal.count

    def part(self, code: Code, part: ast.SplitPart, ordinal: Ordinal, names: Environment) -> Code:
        """The body of one part."""
        inner = code.block()
        self.told(inner, ordinal)
        self.write(inner, part.body, names)
        return inner


def _whole(code: Code, axis: str) -> Operand:
    """What a split along an axis shares out."""
    return code.measure("area") if axis == "area" else code.state(EXTENTS[axis])


@dataclass(frozen=True, slots=True)
class _Slabs:
    """Parts are slabs across an axis of the scope."""

    splitting: Splitting
    axis: int

    def body(
        self,
        code: Code,
        part: ast.SplitPart,
        low: Operand,
        size: Operand,
        ordinal: Ordinal,
        names: Environment,
    ) -> None:
        """Append one part: a slab with the part's body."""
        inner = self.splitting.part(code, part, ordinal, names)
        code.structure("slab", (low, size), self.axis, inner, part.span)

    def number(self) -> int:
        """The number of a new repeat."""
        return self.splitting.numbers()

    @property
    def counts(self) -> bool:
        """Whether anything asks which piece it is."""
        return self.splitting.indices is not None


class _Unwrapped:
    """Parts are slabs along a texture coordinate: their sizes are in images, those of slabs in
    lengths of the axis that the coordinate runs along, perhaps backward, or in images, too, where
    it runs aslant. `whole`: of the shape, in images.
    """

    def __init__(self, splitting: Splitting, code: Code, coordinate: str) -> None:
        self._splitting = splitting
        self._coordinate = coordinate
        self._axis = code.measure(f"{coordinate} axis")
        step = code.measure(f"{coordinate} step")
        self._per_length = code.call("abs", (step,))
        self._back = code.call("lt", (step, Known(0.0)))
        extent = code.measure(f"{coordinate} length")
        for number, name in enumerate(EXTENTS.values()):
            here = code.call("eq", (self._axis, Known(float(number))))
            extent = code.call("select", (here, code.state(name), extent))
        self._extent = extent
        self.whole = code.call("mul", (self._extent, self._per_length))

    def body(
        self,
        code: Code,
        part: ast.SplitPart,
        low: Operand,
        size: Operand,
        ordinal: Ordinal,
        names: Environment,
    ) -> None:
        """Append one part: a slab with the part's body."""
        inner = self._splitting.part(code, part, ordinal, names)
        before = code.call("div", (low, self._per_length))
        length = code.call("div", (size, self._per_length))
        behind = code.call("sub", (self._extent, code.call("add", (before, length))))
        begin = code.call("select", (self._back, behind, before))
        args = (begin, length, self._axis)
        code.structure("slab_along", args, self._coordinate, inner, part.span)

    def number(self) -> int:
        """The number of a new repeat."""
        return self._splitting.numbers()

    @property
    def counts(self) -> bool:
        """Whether anything asks which piece it is."""
        return self._splitting.indices is not None


@dataclass(frozen=True, slots=True)
class _Noting:
    """Notes where the pieces of a split begin: its number, and the register that tells shapes
    apart. Lines that it snaps to then move the cuts between them. `parts`: what was noted.
    """

    splitting: Splitting
    split: int
    shape: Operand
    parts: list[tuple[ast.SplitPart, Environment]] = field(default_factory=list)
    counts: bool = False

    def body(
        self,
        code: Code,
        part: ast.SplitPart,
        low: Operand,
        size: Operand,
        ordinal: Ordinal,
        names: Environment,
    ) -> None:
        """Append a note of one part; what is not absolute gives way."""
        const = (self.split, len(self.parts), part.size.kind != "absolute")
        code.act("piece", (self.shape, low, size), const)
        self.parts.append((part, names))

    def number(self) -> int:
        """The number of a new repeat."""
        return self.splitting.numbers()


# ----------------------------------------------------------------------- parts by label


def selector(label: ast.Expr | None) -> ir.Const:
    """What a part's label selects, as nested tuples that executors read."""
    match label:
        case None:
            return ("all",)
        case ast.Name(name):
            return ("word", name)
        case ast.Text(value):
            return ("word", value)
        case ast.Number(value):
            return ("index", int(value))
        case ast.Unary("not", value):
            return ("not", selector(value))
        case ast.Binary("and" | "or" as op, left, right):
            return (op, selector(left), selector(right))
        case _:
            raise AssertionError("the checker has seen to it")
