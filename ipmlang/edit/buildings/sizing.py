"""Rules that draw parts at one size: what is stretched alike everywhere is said once, in numbers.

In go parts of a tree and how large they shall be, out come symbols of rules whose places and sizes
are numbers, as inference prints them. A part that is needed in many sizes has one rule instead, in
shares of its scope (`forms.py`), and so has one of solids: assets have a size of their own in their
files, which tells later edits how much they are stretched. Nothing is decided about where.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field, replace

import numpy as np

from ipmlang.compiler import ast
from ipmlang.edit.buildings.forms import Forms
from ipmlang.edit.buildings.measuring import SQUARE, Unit
from ipmlang.edit.buildings.regularity import Part
from ipmlang.edit.buildings.rows import Room
from ipmlang.edit.symbols import Asked, Elements
from ipmlang.inverse.frames import Floats, Frames
from ipmlang.inverse.split.wording import Vector, bracket, call

MOST = 3  # sizes of a part with a rule each; one that comes in more is said in shares
STAYS = 1e-3  # of how near touches, that a face may be off and has not moved
ALIKE = 0.1  # of how near touches, by which sizes may differ that are the same
SIZED = "_sized"  # what the name of such a rule ends with


@dataclass(frozen=True, slots=True, eq=False)
class Sized:
    """A rule that draws a part at one size (3,): what is in the part, and the rule's name."""

    size: Floats
    content: Floats
    name: str


@dataclass(slots=True, eq=False)
class Sizing:
    """The rules of one tree's parts, by what tells these apart."""

    forms: Forms
    near: float
    known: dict[object, list[Sized]] = field(default_factory=dict)

    def said(self, unit: Unit, around: int, size: Floats, base: Frames) -> Elements:
        """What draws a part (3,) large, whose low corner is the origin, in the axes of a frame;
        `around` is the shape whose body it stands in.
        """
        forms = self.forms
        pens = forms.pens(unit, around)
        fitted = forms.measured.fills(unit) and forms.measured.is_square(unit, base)
        found = None if fitted else self._rule(unit, size, base)
        if found is None:
            return forms.fitted(unit, around, self._numbers(size), base)
        return (*pens, ast.Module(found))

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

    def _like(self, known: Sequence[Sized], size: Floats, content: Floats) -> str | None:
        for each in known:
            if each.content.shape != content.shape:
                continue
            inside = np.abs(each.content - content).max(initial=0.0)
            if inside <= self.near and np.abs(each.size - size).max() <= ALIKE * self.near:
                return each.name
        return None

    def _rule(self, unit: Unit, size: Floats, base: Frames) -> str | None:
        """The rule for a part of a size; None where it comes in too many, or is not of assets."""
        forms = self.forms
        symbol = forms.measured.name(unit)
        if not forms.measured.is_of_assets(unit):
            return None
        labels, content = self._content(unit, base)
        known = self.known.setdefault((unit[0], symbol, labels), [])
        found = self._like(known, size, content)
        if found is not None or len(known) >= MOST:
            return found
        if unit[0] == "terminal":
            owner = forms.measured.owner(unit)
            body = forms.fitted(unit, owner, self._numbers(size), base)
            body = body[len(forms.pens(unit, owner)) :]
        else:
            body = self._body(unit[1], size, base)
        bare = re.sub(rf"{SIZED}(_\d+)?$", "", symbol.rpartition(".")[2])
        name = forms.new_name(f"{bare}{SIZED}")
        forms.rules[name] = (symbol, body)
        (forms.variants if unit[0] == "shape" else forms.brief).add(name)
        known.append(Sized(size, content, name))
        return name

    def _content(self, unit: Unit, base: Frames) -> tuple[tuple[str, ...], Floats]:
        """What tells parts of one name apart: the labels of their terminals, and where the corners
        (8m, 3) of these are from their lowest, in the axes of a frame.
        """
        measured, labels = self.forms.measured, self.forms.tree.terminals.labels
        own = measured.frame(unit) if measured.is_square(unit, base) else base
        local = measured.points(unit, own)
        return tuple([labels[row] for row in measured.rows(unit)]), local - local.min(axis=0)

    def _body(self, row: int, size: Floats, base: Frames) -> Elements:
        low, high = self.forms.measured.box_in(("shape", row), base)
        ratio = ratios(high - low, size, STAYS * self.near)
        parts: list[Part] = []
        for each in self.forms.measured.inside(row, base, np.flatnonzero(ratio != 1).tolist()):
            place = (each.corner - low) * ratio
            own = each.frame
            grown = each.size * own_ratios(each.turned, ratio)
            if each.square and np.abs(grown - each.size).max() <= STAYS * self.near:
                moved = own.position + (place - each.corner)
                frame = Frames(moved, own.rotation, own.hand, own.scale)
                parts.append((frame, self.forms.plain(each.unit, row)))
                continue
            frame = Frames(place[None], own.rotation, own.hand, np.ones(1))
            axes = self.forms.measured.frame(each.unit) if each.square else base
            parts.append((frame, self.said(each.unit, row, grown, axes)))
        return self.forms.laid(row, parts, self.near)


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
