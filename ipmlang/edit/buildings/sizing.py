"""Rules that draw parts at one size: what is stretched alike everywhere is said once, in numbers.

In go parts of a tree and how large they shall be, out come symbols of rules whose places and sizes
are numbers, as inference prints them. A part that is needed in many sizes has one rule instead, in
shares of its scope (`forms.py`), and so has one of solids: assets have a size of their own in their
files, which tells later edits how much they are stretched. Nothing is decided about where.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field, replace

import numpy as np

from ipmlang.compiler import ast
from ipmlang.edit.buildings.forms import Forms
from ipmlang.edit.buildings.measuring import SQUARE, Unit
from ipmlang.edit.buildings.regularity import Part
from ipmlang.edit.buildings.rows import Room
from ipmlang.edit.buildings.stretched_assets import WORD, WORDS
from ipmlang.edit.symbols import Asked, Elements
from ipmlang.inverse.frames import Floats, Frames, compose, from_matrices, moved_to
from ipmlang.inverse.numbers import shortest
from ipmlang.inverse.split.wording import Vector, bracket, call

MOST = 3  # sizes of a part with a rule each; one that comes in more is said in shares
STAYS = 1e-3  # of how near touches, that a face may be off and has not moved
ALIKE = 0.1  # of how near touches, by which sizes may differ that are the same
TURNED = 1e-4  # by which axes may differ that are the same
EXACT = 1e-7  # of a factor, that it is off by at most, so that the same one does for many parts
FLIPS = [np.array(each, float) for each in (
    (1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1), (-1, 1, 1), (1, -1, 1), (1, 1, -1),
    (-1, -1, -1),
)]  # fmt: skip
"""What turns or mirrors a part and keeps its axes: turns first."""


@dataclass(frozen=True, slots=True, eq=False)
class Content:
    """What tells parts of one name apart: where the corners (k, 3) of their terminals are from the
    lowest, and the axes (3m, 3) of these, as rows.
    """

    corners: Floats
    axes: Floats

    def flipped(self, signs: Floats) -> Content:
        """The same turned or mirrored, by the signs (3,) of its axes."""
        corners = self.corners * signs
        return Content(corners - corners.min(axis=0), self.axes * signs)

    def is_like(self, other: Content, near: float) -> bool:
        """Whether two are one, to what touches."""
        if self.corners.shape != other.corners.shape:
            return False
        off = np.abs(self.corners - other.corners).max(initial=0.0)
        return bool(off <= near / 4 and np.abs(self.axes - other.axes).max(initial=0.0) <= TURNED)


@dataclass(frozen=True, slots=True, eq=False)
class Sized:
    """A symbol that draws a part at one size (3,): what is in the part, the symbol's name, and
    where (3,) it goes from the low corner.
    """

    size: Floats
    content: Content
    name: str
    origin: Floats


@dataclass(slots=True, eq=False)
class Sizing:
    """The rules of one tree's parts, by what tells these apart."""

    forms: Forms
    near: float
    known: dict[object, list[Sized]] = field(default_factory=dict)

    def placed(
        self, unit: Unit, around: int, size: Floats, frame: Frames, base: Frames
    ) -> tuple[Frames, Elements]:
        """A frame, and what draws a part in it (3,) large along the axes of `base`, so that its low
        corner is the origin of `frame`; `around` is the shape whose body it stands in.
        """
        forms = self.forms
        fitted = forms.measured.fills(unit) and forms.measured.is_square(unit, base)
        found = None if fitted else self._symbol(unit, size, base)
        if found is None:
            return frame, forms.fitted(unit, around, self._numbers(size), base)
        own, name = found
        return compose(frame, own), (*forms.pens(unit, around), ast.Module(name))

    def row(
        self, unit: Unit, around: int, size: Floats, natural: Floats, repeated: tuple[int, ...],
        base: Frames,
    ) -> Elements:  # fmt: skip
        """The same for a part that stands as often as it fits along some axes, about as large as
        `natural` (3,): in a scope, so that a later edit changes how often.
        """
        name = self.forms.row_rule(unit, natural, repeated, base)
        scope = call("size", *self._numbers(size))
        return (*self.forms.pens(unit, around), scope, ast.Module(name))

    def _numbers(self, size: Floats) -> Vector:
        return Room(self.near).precision.vector(size)

    def _like(
        self, known: Sequence[Sized], size: Floats, content: Content
    ) -> tuple[Frames, str] | None:
        """The symbol that draws a part, if there is one, and its frame: as large, and with the same
        in it, turned or mirrored.
        """
        large = [each for each in known if np.abs(each.size - size).max() <= ALIKE * self.near]
        for signs in FLIPS if large else ():
            flipped = content.flipped(signs)
            for each in large:
                if each.content.is_like(flipped, self.near):
                    return _flip(signs, size, each.origin), each.name
        return None

    def _symbol(self, unit: Unit, size: Floats, base: Frames) -> tuple[Frames, str] | None:
        """The symbol for a part of a size, and its frame; None where it comes in too many sizes,
        or is not of assets.
        """
        forms = self.forms
        symbol = forms.measured.name(unit)
        if not forms.measured.is_of_assets(unit):
            return None
        labels = tuple([forms.tree.terminals.labels[row] for row in forms.measured.rows(unit)])
        content = self._content(unit, base)
        known = self.known.setdefault((unit[0], symbol, labels), [])
        found = self._like(known, size, content)
        if found is not None:
            return found
        alike = (each.content.is_like(content, self.near) for each in known)
        if len(known) >= MOST and sum(alike) >= MOST:
            return None
        name, origin = self._made(unit, size, base)
        known.append(Sized(size, content, name, origin))
        return moved_to(origin), name

    def _made(self, unit: Unit, size: Floats, base: Frames) -> tuple[str, Floats]:
        """A new symbol for a part of a size, and where (3,) it goes from the low corner."""
        forms = self.forms
        symbol = forms.measured.name(unit)
        if unit[0] == "terminal":
            found = self._stretched(unit, size, base)
            if found is not None:
                return found
            owner = forms.measured.owner(unit)
            body = forms.fitted(unit, owner, self._numbers(size), base)
            body = body[len(forms.pens(unit, owner)) :]
            origin = np.zeros(3)
        else:
            body, origin = self._body(unit[1], size, base)
        bare = WORDS.sub("", symbol.rpartition(".")[2])
        name = forms.new_name(f"{bare}{WORD}")
        forms.rules[name] = (symbol, body)
        (forms.variants if unit[0] == "shape" else forms.brief).add(name)
        return name, origin

    def _stretched(self, unit: Unit, size: Floats, base: Frames) -> tuple[str, Floats] | None:
        """The asset of a terminal, stretched; None where it is none of the grammar's own."""
        forms, tree = self.forms, self.forms.tree
        row = unit[1]
        if forms.measured.is_square(unit, base):
            source = tree.drawn_assets[row]
            low, high = forms.measured.box(unit)
        else:
            source = forms.bake(row, base).name
            around = forms.measured.maps(base)
            at = around.into @ forms.measured.frame(unit).position[0] + around.origin
            low, high = (each - at for each in forms.measured.box_in(unit, base))
        before = forms.stretched.factors(source)
        if before is None:
            return None
        more = ratios(high - low, size, STAYS * self.near) * before
        reach = np.maximum(np.abs(low), np.abs(high)) / before
        found = [self._factor(*each) for each in zip(more.tolist(), reach.tolist(), strict=True)]
        x, y, z = np.where(high > low, found, before).tolist()
        name = forms.stretched.name(source, (x, y, z))
        return name, -low / before * (x, y, z)

    def _factor(self, value: float, reach: float) -> float:
        """A factor as it is printed, of what reaches so far in its file."""
        error = Room(self.near).precision.ratio(reach)
        known = self.forms.stretched.near(value, error)
        return shortest(value, min(error, EXACT)) if known is None else known

    def _content(self, unit: Unit, base: Frames) -> Content:
        measured = self.forms.measured
        own = measured.frame(unit) if measured.is_square(unit, base) else base
        local = measured.points(unit, own)
        return Content(local - local.min(axis=0), measured.axes(unit, own))

    def _body(self, row: int, size: Floats, base: Frames) -> tuple[Elements, Floats]:
        """A body that draws a shape at a size, and where (3,) its origin is from the low corner."""
        measured = self.forms.measured
        unit: Unit = ("shape", row)
        low, high = measured.box_in(unit, base)
        ratio = ratios(high - low, size, STAYS * self.near)
        into = measured.maps(base)
        origin = into.into @ measured.frame(unit).position[0] + into.origin
        parts: list[Part] = []
        for each in measured.inside(row, base, np.flatnonzero(ratio != 1).tolist()):
            place = (each.corner - origin) * ratio
            own = each.frame
            grown = each.size * own_ratios(each.turned, ratio)
            if each.square and np.abs(grown - each.size).max() <= STAYS * self.near:
                moved = own.position + (place - each.corner)
                frame = Frames(moved, own.rotation, own.hand, own.scale)
                parts.append((frame, self.forms.plain(each.unit, row)))
                continue
            frame = Frames(place[None], own.rotation, own.hand, own.scale)
            axes = self.forms.measured.frame(each.unit) if each.square else base
            parts.append(self.placed(each.unit, row, grown / own.scale[0], frame, axes))
        return self.forms.laid(self.forms.tree.names[row], parts, self.near), (origin - low) * ratio


def _flip(signs: Floats, size: Floats, origin: Floats) -> Frames:
    """The frame of what goes to a place in a box of a size, of which some axes are turned round."""
    if (signs > 0).all():
        return moved_to(origin)
    corner = np.where(signs < 0, size, 0.0) + signs * origin
    return from_matrices(np.concatenate([np.diag(signs), corner[:, None]], axis=1)[None])


def ratios(before: Floats, after: Floats, same: float) -> Floats:
    """How many times as large sizes are; 1 where there is no extent, or no more than `same` lies
    between them.
    """
    stays = (np.abs(after - before) <= same) | (before <= 0)
    return np.asarray(np.where(stays, 1.0, after / np.where(stays, 1.0, before)))


def own_ratios(turned: Floats, ratio: Floats) -> Floats:
    """(3,) how many times as large something is along its axes, of which turned (3, 3) has the
    columns without signs, where it is so many times as large (3,) along those around; 1 along an
    axis that stands askew in them.
    """
    axis = turned.argmax(axis=0)
    return np.asarray(np.where(turned.max(axis=0) > 1 - SQUARE, ratio[axis], 1.0))


def inlined(
    bodies: Mapping[str, Elements], brief: Set[str], tables: Sequence[ast.Table], asked: Asked
) -> dict[str, Elements]:
    """Bodies by name, of which the brief ones stand where they are used, if that is in one place
    only; tables may use them, too.
    """
    uses = Counter(name for body in bodies.values() for name in asked.every(body))
    listed = {name for table in tables for name in asked.every(table)}
    single = {name: bodies[name] for name in brief - listed if uses[name] == 1}
    return {
        name: body if single.keys().isdisjoint(asked.every(body)) else _put_in(body, single)
        for name, body in bodies.items()
        if name not in single
    }


def _put_in(body: Elements, single: Mapping[str, Elements], bracketed: bool = False) -> Elements:
    """A body with symbols replaced by what they stand for; bracketed: its scope ends with it."""
    made: list[ast.Element] = []
    for each in body:
        if isinstance(each, ast.Module) and each.name in single:
            last = bracketed and each is body[-1]
            made += single[each.name] if last else (bracket(single[each.name]),)
        elif isinstance(each, ast.Bracket | ast.Repeat):
            inner = _put_in(each.body, single, isinstance(each, ast.Bracket))
            made.append(replace(each, body=inner))
        else:
            made.append(each)
    return tuple(made)
