"""The lengths of the parts of a split: what is fixed, what floats, how often groups are repeated.

In go parts and a length, out come registers for where each part begins and how long it is, and a
call for each part of whoever places it; one repeat a group. No axis is known here, and no shape.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

from ipmlang.compiler import ast
from ipmlang.compiler.lower.expr import Code, Environment, Known, Operand

LEAST = 1e-9  # of the whole length: a part that is no longer makes no shape

Parts = Sequence["ast.SplitPart | ast.SplitGroup"]


@dataclass(frozen=True, slots=True)
class Ordinal:
    """Which piece of its split comes next, and how many there are; None where nobody asks."""

    next: Operand
    count: Operand


@dataclass(frozen=True, slots=True)
class Piece:
    """One part as it stands in its level: its size, or the period of its group, and of that how
    much is fixed and how much floats.
    """

    part: ast.SplitPart | ast.SplitGroup
    fixed: Operand
    floating: Operand
    floats: bool
    inner: tuple[Piece, ...] = ()


class Placing(Protocol):
    """What becomes of the parts of a split, once it is known where they begin."""

    def body(
        self,
        code: Code,
        part: ast.SplitPart,
        low: Operand,
        size: Operand,
        ordinal: Ordinal,
        names: Environment,
    ) -> None:
        """Append one part."""

    def number(self) -> int:
        """The number of a new repeat."""

    @property
    def counts(self) -> bool:
        """Whether anything asks which piece it is."""


def share(code: Code, parts: Parts, whole: Operand, placing: Placing, names: Environment) -> None:
    """Share a length out to the parts of a split."""
    level = _Level(placing, whole, names)
    level.write(code, level.pieces(code, parts), Known(0.0), whole, Known(0.0), None)


class _Level:
    """The parts between two braces: sizes are shared out here, once a level."""

    def __init__(self, placing: Placing, whole: Operand, names: Environment) -> None:
        self._placing = placing
        self._whole = whole
        self._names = names

    def pieces(self, code: Code, parts: Parts) -> tuple[Piece, ...]:
        """The sizes of the parts, as far as they do not depend on each other."""
        return tuple(self._piece(code, part) for part in parts)

    def _piece(self, code: Code, part: ast.SplitPart | ast.SplitGroup) -> Piece:
        if isinstance(part, ast.SplitPart):
            value = code.call("max", (code.value(part.size.value, self._names), Known(0.0)))
            if part.size.kind == "floating":
                return Piece(part, Known(0.0), value, True)
            if part.size.kind == "relative":
                value = code.call("mul", (value, self._whole))
            return Piece(part, value, Known(0.0), False)
        inner = self.pieces(code, part.parts)
        fixed = _total(code, [each.fixed for each in inner])
        floating = _total(code, [each.floating for each in inner])
        return Piece(part, fixed, floating, any(p.floats for p in inner), inner=inner)

    def write(
        self,
        code: Code,
        pieces: Sequence[Piece],
        begin: Operand,
        length: Operand,
        first: Operand,
        count: Operand | None,
    ) -> None:
        """Append the parts of a level that begins at `begin`; `first`: the number of its first
        piece; `count`: how many pieces the split has, None: this level's own.
        """
        repeats, factor = self._shares(code, pieces, length)
        sizes = [_sized(code, piece, factor) for piece in pieces]
        made = self._made(code, pieces, repeats, sizes, length)
        if count is None:
            count = _total(code, made)
        at: Operand = Known(0.0)
        for piece, times, size, number in zip(pieces, repeats, sizes, made, strict=True):
            room = _minus(code, length, at)
            where = _plus(code, begin, at)
            if times is None:
                size = code.call("min", (size, room))
                assert isinstance(piece.part, ast.SplitPart)
                ordinal = Ordinal(first, count)
                names = self._names
                self._placing.body(code, piece.part, where, size, ordinal, names)
            else:
                self._group(code, piece, times, size, where, room, first, count)
                size = _taken(code, piece, times, size, room)
            at = _plus(code, at, size)
            first = _plus(code, first, number)

    def _shares(
        self, code: Code, pieces: Sequence[Piece], length: Operand
    ) -> tuple[list[Operand | None], Operand]:
        """How often each group is repeated (None: a single part), and the factor of all floating
        sizes.
        """
        groups = [each for each in pieces if isinstance(each.part, ast.SplitGroup)]
        singles = [each for each in pieces if isinstance(each.part, ast.SplitPart)]
        taken = _total(code, [p.fixed for p in singles] + [p.floating for p in singles])
        room = _room(code, length, taken)
        periods = {id(each): code.call("add", (each.fixed, each.floating)) for each in groups}
        together = _total(code, periods.values())
        repeats: list[Operand | None] = []
        for each in pieces:
            if id(each) not in periods:
                repeats.append(None)
                continue
            period, share = periods[id(each)], room
            if len(groups) > 1:
                part = code.call("div", (period, together))
                share = code.call("mul", (room, part))
            repeats.append(_times(code, each, share, period))
        pairs = list(zip(pieces, repeats, strict=True))
        fixed = _total(code, [_all_of(code, each.fixed, times) for each, times in pairs])
        floats = _total(code, [_all_of(code, each.floating, times) for each, times in pairs])
        left = code.call("max", (_minus(code, length, fixed), Known(0.0)))
        if isinstance(floats, Known) and floats.value == 0:
            return repeats, Known(0.0)
        some = code.call("gt", (floats, Known(0.0)))
        return repeats, code.call("select", (some, code.call("div", (left, floats)), Known(0.0)))

    def _made(
        self,
        code: Code,
        pieces: Sequence[Piece],
        repeats: Sequence[Operand | None],
        sizes: Sequence[Operand],
        length: Operand,
    ) -> list[Operand]:
        """How many pieces each part makes in a level that is so long, all copies together; nobody
        asks: 0.
        """
        if not self._placing.counts:
            return [Known(0.0)] * len(pieces)
        made: list[Operand] = []
        at: Operand = Known(0.0)
        for piece, times, size in zip(pieces, repeats, sizes, strict=True):
            room = _minus(code, length, at)
            if times is None:
                size = code.call("min", (size, room))
                least = code.call("mul", (self._whole, Known(LEAST)))
                there = code.call("gt", (size, least))
                made.append(code.call("select", (there, Known(1.0), Known(0.0))))
            else:
                made.append(self._in_all(code, piece, times, size, room))
                size = _taken(code, piece, times, size, room)
            at = _plus(code, at, size)
        return made

    def _in_all(
        self, code: Code, piece: Piece, times: Operand, period: Operand, room: Operand
    ) -> Operand:
        """How many pieces the copies of a group make: of the last one, what there is room for."""
        whole = code.call("mul", (times, self._in_one(code, piece, period)))
        if not _overflows(piece):
            return whole
        fitting = code.call("floor", (code.call("div", (room, period)),))
        left = code.call("sub", (room, code.call("mul", (fitting, period))))
        some = code.call("mul", (fitting, self._in_one(code, piece, period)))
        cut = code.call("add", (some, self._in_one(code, piece, left)))
        all_fit = code.call("ge", (fitting, times))
        none = code.call("le", (period, Known(0.0)))
        return code.call("select", (code.call("or", (all_fit, none)), whole, cut))

    def _in_one(self, code: Code, piece: Piece, length: Operand) -> Operand:
        """How many pieces one copy of a group makes, which is `length` long."""
        repeats, factor = self._shares(code, piece.inner, length)
        sizes = [_sized(code, each, factor) for each in piece.inner]
        return _total(code, self._made(code, piece.inner, repeats, sizes, length))

    def _group(
        self,
        code: Code,
        piece: Piece,
        times: Operand,
        period: Operand,
        begin: Operand,
        room: Operand,
        first: Operand,
        count: Operand,
    ) -> None:
        """Append the copies of a group."""
        number = self._placing.number()
        inner = code.block()
        index = inner.load("index", number)
        before = inner.call("mul", (index, period))
        where = _plus(inner, begin, before)
        length: Operand = period
        if _overflows(piece):
            left = inner.call("min", (period, inner.call("sub", (room, before))))
            length = inner.call("select", (_over(code, times, period, room), left, period))
        if self._placing.counts:
            each = self._in_one(inner, piece, period)
            first = inner.call("add", (first, inner.call("mul", (index, each))))
        self.write(inner, piece.inner, where, length, first, count)
        code.repeat(number, (times,), inner, piece.part.span)


def _overflows(piece: Piece) -> bool:
    """Whether the copies of a group may need more room than there is: what is fixed does not give
    way, and `+` makes one copy more than fits.
    """
    return not (isinstance(piece.fixed, Known) and piece.fixed.value == 0)


def _over(code: Code, times: Operand, period: Operand, room: Operand) -> Operand:
    """Whether they do; by a last bit they do not."""
    return code.call("gt", (code.call("mul", (times, period)), room))


def _room(code: Code, length: Operand, taken: Operand) -> Operand:
    """What single parts leave for repeats: nothing where they leave only a last bit."""
    if isinstance(taken, Known) and taken.value == 0:
        return code.call("max", (length, Known(0.0)))
    left = code.call("sub", (length, taken))
    return code.call("select", (code.call("gt", (length, taken)), left, Known(0.0)))


def _taken(code: Code, piece: Piece, times: Operand, period: Operand, room: Operand) -> Operand:
    """The length that the copies of a group take."""
    size = code.call("mul", (times, period))
    if not _overflows(piece):
        return size
    return code.call("select", (_over(code, times, period, room), room, size))


def _cuts(piece: Piece) -> bool:
    """Whether a group's last copy may be cut."""
    return isinstance(piece.part, ast.SplitGroup) and piece.part.mode == "+" and not piece.floats


def _times(code: Code, piece: Piece, room: Operand, period: Operand) -> Operand:
    """How many copies of a group fit: floating ones are stretched, so the nearest number; of fixed
    ones whole ones alone, and with `+` a cut one.
    """
    if piece.floats:
        return code.call("tiles", (room, period))
    rounded = "ceil" if _cuts(piece) else "floor"
    found = code.call(rounded, (code.call("div", (room, period)),))
    none = code.call("le", (period, Known(0.0)))  # not so of a size that is no number: that is told
    return code.call("select", (none, Known(0.0), found))


def _sized(code: Code, piece: Piece, factor: Operand) -> Operand:
    return _plus(code, piece.fixed, _times_factor(code, piece.floating, factor))


def _times_factor(code: Code, size: Operand, factor: Operand) -> Operand:
    if isinstance(size, Known) and size.value in (0.0, 1.0):
        return factor if size.value else size
    return code.call("mul", (factor, size))


def _minus(code: Code, a: Operand, b: Operand) -> Operand:
    return a if isinstance(b, Known) and b.value == 0 else code.call("sub", (a, b))


def _all_of(code: Code, size: Operand, times: Operand | None) -> Operand:
    return size if times is None else code.call("mul", (times, size))


def _total(code: Code, sizes: Iterable[Operand | None]) -> Operand:
    """A sum; zeros that are known add nothing."""
    total: Operand = Known(0.0)
    for size in sizes:
        if size is not None:
            total = _plus(code, total, size)
    return total


def _plus(code: Code, a: Operand, b: Operand) -> Operand:
    """a + b, where a zero that is known adds nothing."""
    if isinstance(a, Known) and a.value == 0:
        return b
    if isinstance(b, Known) and b.value == 0:
        return a
    return code.call("add", (a, b))
