"""Rules that only name another rule: what a search leaves of a group when a row took its members.

Takes a book; whatever repeats or places such a group repeats or places its only member. What is
drawn stays the same. Groups under an effect, and those whose frame a structure binds, are left.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ipmlang.inverse.lsystem.frames import Frames
from ipmlang.inverse.simplify import AXIOM, Body, Book, regauge

STILL = 1e-12  # units or ratio


def drop_aliases(book: Book) -> None:
    """Write the only member of a group in the group's place."""
    structures = {each.part for each in book.trees.values()}
    structures |= {each.part for each in book.lattices.values()}
    for rule in sorted(book.bodies):
        body = book.bodies[rule]
        bound = rule == AXIOM or rule in book.effects or rule in book.anchored
        if bound or len(body.parts) != 1 or int(body.places.handedness[0]) < 0:
            continue
        if not _is_still(body.places):
            if rule in structures:
                continue
            regauge(book, rule, body.places)
        _rename(book, rule, int(body.parts[0]))


def _is_still(place: Frames) -> bool:
    """Whether a place (1,) is where its symbol stands by itself."""
    off = abs(complex(place.position[0])) + abs(complex(place.factor[0]) - 1)
    return off <= STILL


def _rename(book: Book, rule: int, part: int) -> None:
    """Whatever names a rule names a part; the rule goes."""
    del book.bodies[rule]
    for name, body in book.bodies.items():
        if rule in body.rows:
            parts = np.where(body.parts == rule, part, body.parts)
            book.bodies[name] = Body(parts, body.places)
    for loop in book.loops.values():
        loop.part = part if loop.part == rule else loop.part
    for name, tree in book.trees.items():
        book.trees[name] = replace(tree, part=part) if tree.part == rule else tree
    for name, lattice in book.lattices.items():
        book.lattices[name] = replace(lattice, part=part) if lattice.part == rule else lattice
