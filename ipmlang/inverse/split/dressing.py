"""Schemes found for forms, dressed: each copy in the material that it has in the model.

In goes a scheme in which one terminal stands for all shapes of a form; out comes one with a
terminal for each shape, and a rule for each way in which a rule's parts are made. Rules that differ
in nothing else become one again when they are printed. What is drawn does not change.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ipmlang.inverse.frames import Frames, Integers, identity
from ipmlang.inverse.parts.observation import Likeness, Parts
from ipmlang.inverse.parts.scaling import as_one
from ipmlang.inverse.split.changing import needed
from ipmlang.inverse.split.expansion import placements
from ipmlang.inverse.split.scheme import Array, Item, Place, Ring, Rule, Scheme, Symbol, Terminal
from ipmlang.inverse.split.search.assembly import matched
from ipmlang.inverse.split.search.drafts import Limits
from ipmlang.inverse.split.search.figures import Figure, figure, of_class
from ipmlang.inverse.split.search.patterns import Memory, arranged


def dressed(
    scheme: Scheme, parts: Parts, likenesses: Sequence[Likeness], limits: Limits, memory: Memory
) -> Scheme | None:
    """The scheme of `parts` that a scheme is in which one class stands for all of its form; None
    where it is not known which copy is which part. likenesses: of classes in other materials.
    """
    rows = matched(as_one(parts, likenesses), scheme)[0]
    if len(np.unique(rows)) < len(parts.shape):
        return None
    forms = {each.of: _Dress(each.of, identity()) for each in likenesses}
    forms |= {each.shape: _Dress(each.of, each.frame) for each in likenesses}
    making = _Making(scheme, parts, forms, limits, memory, _sizes(scheme))
    making.made(scheme.axiom, parts.shape[rows])
    return Scheme(needed(making.symbols, len(making.symbols) - 1)[0], scheme.frame)


@dataclass(frozen=True, slots=True, eq=False)
class _Dress:
    """A class is `form` in another material: its own coordinates = pose(those of the form)."""

    form: int
    pose: Frames


def _sizes(scheme: Scheme) -> list[int]:
    """How many terminals each symbol draws."""
    sizes: list[int] = []
    for symbol in scheme.symbols:
        items = symbol.items if isinstance(symbol, Rule) else ()
        drawn = [sizes[inner] * len(own) for item in items for inner, own in placements(item)]
        sizes.append(1 if isinstance(symbol, Terminal) else sum(drawn))
    return sizes


@dataclass(slots=True, eq=False)
class _Making:
    """forms: of the classes that have other materials elsewhere; sizes: how many terminals each
    symbol of the scheme draws; symbols: those made so far; known:
    their numbers by the symbol that they were and the classes of what it draws.
    """

    scheme: Scheme
    parts: Parts
    forms: dict[int, _Dress]
    limits: Limits
    memory: Memory
    sizes: list[int]
    symbols: list[Symbol] = field(default_factory=list)
    known: dict[tuple[int, bytes], int] = field(default_factory=dict)

    def made(self, number: int, classes: Integers) -> int:
        """The symbol that draws what one of the scheme does, with terminals of these classes
        (n,), in the order of expansion.
        """
        key = number, classes.tobytes()
        if key not in self.known:
            symbol = self._made(number, classes)
            self.symbols.append(symbol)
            self.known[key] = len(self.symbols) - 1
        return self.known[key]

    def _made(self, number: int, classes: Integers) -> Symbol:
        symbol = self.scheme.symbols[number]
        if isinstance(symbol, Terminal):
            return self._terminal(symbol, int(classes[0]))
        items: list[Item] = []
        begin = 0
        for item in symbol.items:
            assert isinstance(item, Place | Array | Ring)
            frames = placements(item)[0][1]
            end = begin + len(frames) * self.sizes[item.symbol]
            items += self._items(item, frames, classes[begin:end].reshape(len(frames), -1))
            begin = end
        return replace(symbol, items=tuple(items))

    def _terminal(self, form: Terminal, part: int) -> Terminal:
        dress = self.forms.get(part)
        if dress is None:
            return form
        name = self.parts.classes[part].name
        return replace(form, name=name, part=part, form=dress.form, pose=dress.pose)

    def _items(self, item: Place | Array | Ring, frames: Frames, classes: Integers) -> list[Item]:
        """The items for copies in these frames (k,) that draw terminals of these classes (k, n)."""
        groups: dict[bytes, list[int]] = {}
        for row, own in enumerate(classes):
            groups.setdefault(own.tobytes(), []).append(row)
        found: list[Item] = []
        for rows in groups.values():
            symbol = self.made(item.symbol, classes[rows[0]])
            if len(groups) == 1:
                return [replace(item, symbol=symbol)]
            own_frames = frames[np.array(rows)]
            shape = self._figure(symbol)
            found += arranged(shape, own_frames, symbol, self.limits, self.memory).items
        return found

    def _figure(self, number: int) -> Figure:
        symbol = self.symbols[number]
        if isinstance(symbol, Terminal):
            form = symbol.part if symbol.form < 0 else symbol.form
            return of_class(self.parts.classes[form])
        return figure(np.zeros(3), symbol.size, identity())
