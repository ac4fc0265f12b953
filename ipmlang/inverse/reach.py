"""How far numbers carry: the scale under which each rule is drawn, the extent of each symbol.

Takes a book of rules; gives what the printer needs to know how many digits a number deserves.
Nothing here rounds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.lsystem.frames import identity
from ipmlang.inverse.recursion.branching import Branching
from ipmlang.inverse.recursion.twigs import grow
from ipmlang.inverse.simplify import AXIOM, Book


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """How far numbers carry. error: units, what one rounding may move a point by; gain: the largest
    scale under which each rule is drawn; radius: the extent of each symbol in its own units.
    """

    error: float
    gain: dict[int, float]
    radius: dict[int, float]


def measure(book: Book, radius: dict[int, float], error: float) -> Reach:
    """How far each rule's numbers carry, from the axiom down and from the terminals up. radius: of
    terminals, and of groups whose effect reaches further than what they draw.
    """
    extent: dict[int, float] = {}

    def reach_of(symbol: int) -> float:
        if symbol in extent:
            return extent[symbol]
        if symbol in book.family:
            loop = book.loops[book.family[symbol]]
            places = loop.pattern.places(book.count[symbol])
            inner = reach_of(loop.part)
            value = float(np.max(np.abs(places.position) + places.scale * inner))
        elif symbol in book.bodies:
            body = book.bodies[symbol]
            inner_radius = np.array([reach_of(part) for part in body.parts.tolist()])
            value = float(np.max(np.abs(body.places.position) + body.places.scale * inner_radius))
            value = max(value, radius.get(symbol, 0.0))
        else:
            moved = book.assets.get(symbol)
            value = radius[symbol]
            if moved is not None:
                value = value * float(moved.scale[0]) + abs(complex(moved.position[0]))
        extent[symbol] = value
        return value

    gain, structures = {AXIOM: 1.0}, set(book.rules())
    waiting = [AXIOM]
    while waiting:
        rule = waiting.pop(0)
        for part, scale in _inside(book, rule):
            reach_of(part)
            key = book.family.get(part, part)
            if scale * gain[rule] > gain.get(key, 0.0) * (1 + 1e-9):
                gain[key] = scale * gain[rule]
                if key in structures:
                    waiting.append(key)
    return Reach(error, gain, extent)


def _inside(book: Book, rule: int) -> list[tuple[int, float]]:
    """Symbols named by a rule, with the largest scale each stands under."""
    if rule in book.lattices:
        lattice = book.lattices[rule]
        return [(lattice.part, float(lattice.formula.frames().scale.max()))]
    if rule in book.trees:
        tree = book.trees[rule]
        return [(tree.part, _largest(tree.branching))]
    if rule in book.loops:
        loop = book.loops[rule]
        counts = [book.count[part] for part, own in book.family.items() if own == rule]
        places = loop.pattern.places(max(counts))
        return [(loop.part, float(places.scale.max()))]
    body = book.bodies[rule]
    largest: dict[int, float] = {}
    for part, scale in zip(body.parts.tolist(), body.places.scale.tolist(), strict=True):
        largest[part] = max(scale, largest.get(part, 0.0))
    return list(largest.items())


def _largest(branching: Branching) -> float:
    """The largest scale of a node in the frame of the root."""
    grown = grow(identity(1), list(branching.twigs), branching.depth, len(branching.order))
    return 1.0 if grown is None else float(grown.frames.scale.max())
