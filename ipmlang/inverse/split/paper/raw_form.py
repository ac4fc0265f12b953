"""The split tree of the 2016 paper as a scheme: its grammar exportation (section 3.3).

In go parts, out comes a scheme of point splits, rules for equal subtrees and subdivisions. It is
one way to say what a model is made of, rarely the shortest; nothing here compares it with others.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from ipmlang.inverse.frames import (
    Floats,
    Frames,
    Integers,
    compose,
    inverse,
    join,
    linear,
    moved_to,
)
from ipmlang.inverse.parts.observation import Parts
from ipmlang.inverse.split.distinct import numbered
from ipmlang.inverse.split.paper.labelling import TURNED, Labels, labelled, rule_labels
from ipmlang.inverse.split.paper.subdivisions import Lattice, lattices
from ipmlang.inverse.split.paper.tree import Tree, point_splits, split_tree
from ipmlang.inverse.split.scheme import (
    Array,
    Direction,
    Item,
    Octant,
    Place,
    Rule,
    Scheme,
    Symbol,
    Terminal,
)


def raw_form(parts: Parts, small: float) -> Scheme:
    """The paper's grammar of a model; small: units that do not count."""
    tree = split_tree(parts.low, parts.high, small)
    return _Exported(parts, tree, labelled(tree, parts, small), small).scheme()


@dataclass(frozen=True, slots=True, eq=False)
class _Use:
    """A symbol in the box of a node; frame: one row, from its coordinates to the world."""

    symbol: int
    node: int
    frame: Frames


@dataclass(slots=True, eq=False)
class _Exported:
    """The symbols so far, each declared before it is used."""

    parts: Parts
    tree: Tree
    labels: Labels
    small: float
    symbols: list[Symbol] = field(default_factory=list)
    terminals: dict[int, int] = field(default_factory=dict)
    rules: dict[int, tuple[int, Frames]] = field(default_factory=dict)  # symbol; label to rule

    def scheme(self) -> Scheme:
        """Everything, the root last."""
        below, roots = self.tree.children(), rule_labels(self.tree, self.labels)
        for node in self.tree.order[:0:-1].tolist():  # the smallest first, so that none is missing
            if int(self.labels.label[node]) in roots:
                self._declare(node, below)
        size = self.tree.high[0] - self.tree.low[0]
        items = tuple(self._items(0, below))
        self.symbols.append(Rule("", size, items))
        return Scheme(tuple(self.symbols), moved_to(self.tree.low[:1]))

    def _declare(self, node: int, below: list[Integers]) -> None:
        label = int(self.labels.label[node])
        if label in self.rules:
            return
        size = self.tree.high[node] - self.tree.low[node]
        items = tuple(self._items(node, below))
        here = moved_to(self.tree.low[[node]])
        self.rules[label] = (len(self.symbols), compose(inverse(self._frame(node)), here))
        self.symbols.append(Rule("", size, items))

    def _frame(self, node: int) -> Frames:
        return self.labels.frames[np.array([node])]

    def _items(self, base: int, below: list[Integers]) -> Iterator[Item]:
        """What stands in a node, in coordinates that begin at its corner."""
        uses = self._uses(base, below)
        here = inverse(moved_to(self.tree.low[[base]]))
        for use in uses:
            if use.node == base:
                yield Place(use.symbol, compose(here, use.frame))
        others = [use for use in uses if use.node != base]
        for alike in self._alike(others):
            places = np.concatenate([use.frame.position for use in alike])
            found, rest = lattices(places, self.small)
            for lattice in found:
                yield self._pattern(base, [alike[row] for row in lattice.rows], lattice)
            for row in rest.tolist():
                yield self._octant(base, alike[row])

    def _uses(self, base: int, below: list[Integers]) -> list[_Use]:
        """Symbols that stand in a node: rules where subtrees repeat, else what is in the subtree,
        so that boxes which are but on the way are cut through.
        """
        found: list[_Use] = []
        waiting = [base]
        while waiting:
            node = waiting.pop()
            rule = self.rules.get(int(self.labels.label[node]))
            if rule is not None:
                found.append(_Use(rule[0], node, compose(self._frame(node), rule[1])))
                continue
            if node:
                frame = self.parts.frames[np.array([node - 1])]
                found.append(_Use(self._terminal(int(self.parts.shape[node - 1])), node, frame))
            waiting.extend(below[node][::-1].tolist())
        return found

    def _terminal(self, shape: int) -> int:
        if shape not in self.terminals:
            kind = self.parts.classes[shape]
            self.terminals[shape] = len(self.symbols)
            self.symbols.append(Terminal(kind.name, kind.size, shape))
        return self.terminals[shape]

    def _alike(self, uses: list[_Use]) -> list[list[_Use]]:
        """Uses of one symbol that stand alike, in the order in which they come."""
        if not uses:
            return []
        turned = linear(join([use.frame for use in uses])).reshape(-1, 9)
        kinds = np.stack([numbered(turned[:, column], TURNED) for column in range(9)], axis=1)
        groups: dict[tuple[int, ...], list[_Use]] = {}
        for use, kind in zip(uses, kinds.tolist(), strict=True):
            groups.setdefault((use.symbol, *kind), []).append(use)
        return list(groups.values())

    def _octant(self, base: int, use: _Use) -> Octant:
        box = self.tree.low[use.node], self.tree.high[use.node]
        return self._taken(base, use, box, (1, 1, 1))

    def _pattern(self, base: int, uses: list[_Use], lattice: Lattice) -> Item:
        """Cells that fill a box where there is room for them, else a row along any directions."""
        first, counts, size = uses[0], np.ones(3, np.int64), np.zeros(3)
        for count, step in zip(lattice.counts, lattice.steps, strict=True):
            axis = int(np.argmax(np.abs(step)))
            counts[axis], size[axis] = count, count * step[axis]
        low = self.tree.low[first.node]
        high = np.where(counts > 1, low + size, self.tree.high[first.node])
        over = np.where(counts > 1, np.maximum(high - self.tree.high[base], 0.0), 0.0)
        low, high = low - over, high - over  # what is empty in a cell may lie before its contents
        straight = np.count_nonzero(lattice.steps) == len(lattice.counts)
        inside = bool((low >= self.tree.low[base] - self.small).all())
        if straight and inside and bool((size >= 0).all()):
            x, y, z = counts.tolist()
            return self._taken(base, first, (low, high), (x, y, z))
        here = inverse(moved_to(self.tree.low[[base]]))
        directions = tuple(map(Direction, lattice.counts, lattice.steps))
        return Array(first.symbol, compose(here, first.frame), directions)

    def _taken(
        self, base: int, use: _Use, box: tuple[Floats, Floats], counts: tuple[int, int, int]
    ) -> Octant:
        outer = self.tree.low[base], self.tree.high[base]
        taken = point_splits(outer, box, self.small)
        inner = compose(inverse(moved_to(taken.low)), use.frame)
        return Octant(use.symbol, taken.cuts, taken.size, inner, counts)
