"""The alphabet that inference builds: terminals, groups of symbols, sequences of one symbol.

Every definition knows what it expands to (terminals with frames, in paint order) and which frames
map it onto itself, so that groups of groups are treated like single elements. An arrangement is the
string that is rewritten: symbols with world frames, in paint order. Nothing here searches.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import (
    NONE,
    ORIGIN,
    Complexes,
    Floats,
    Frames,
    compose,
    frames,
    identity,
    inverse,
    join,
)
from ipmlang.inverse.lsystem.patterns import Pattern
from ipmlang.inverse.lsystem.symmetry import Symmetry
from ipmlang.inverse.recursion.branching import Branching
from ipmlang.inverse.recursion.twigs import grow

if TYPE_CHECKING:
    from ipmlang.inverse.lattices.formula import LatticeRule

Integers = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Definition:
    """One symbol.

    parts: (m,) member symbols in paint order; places: (m,) their frames in this symbol's frame.
    A terminal has no parts. pattern: how the places follow from an index (sequences only); family:
    the first symbol with the same part and pattern, whatever its count (sequences only, else -1);
    at, arm: (size,) position and factor of the leaf frames;
    leaves: (size,) terminals it expands to; leaf_frames: (size,) their frames here; stabiliser:
    (k,) frames that keep all of it, identity first; free: any rotation about the origin does too;
    radius: largest distance of what it draws from its origin; effect: the class of the effect that
    wraps it, -1 for none; branching, lattice: the
    structure that its parts are the nodes of; anchored: that
    effect lies somewhere, at this symbol's frame; marks: how many of the leaves are such effects,
    which draw nothing themselves.
    """

    parts: Integers
    places: Frames
    leaves: Integers
    leaf_frames: Frames
    stabiliser: Frames
    free: bool
    radius: float
    at: Complexes
    arm: Complexes
    pattern: Pattern | None = None
    branching: Branching | None = None
    lattice: LatticeRule | None = None
    family: int = -1
    effect: int = -1
    anchored: bool = False
    marks: int = 0

    @property
    def terminal(self) -> bool:
        """Draws an asset."""
        return len(self.parts) == 0

    @property
    def size(self) -> int:
        """How many rows it takes up of what was seen."""
        return len(self.leaves)

    @property
    def drawn(self) -> int:
        """How many elements it draws."""
        return len(self.leaves) - self.marks


@dataclass(slots=True, eq=False)
class Alphabet:
    """All definitions, by symbol number; terminals come first. tolerance: how far, in units, an
    expansion may be from what was observed.
    """

    tolerance: float
    definitions: list[Definition] = field(default_factory=list)
    _radii: Floats = field(default_factory=lambda: np.zeros(0))
    _frees: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, np.bool_))
    _keeping: Integers = field(default_factory=lambda: np.zeros(0, np.int64))

    @property
    def radii(self) -> Floats:
        """(n,) radius of each symbol."""
        new = self.definitions[len(self._radii) :]
        if new:
            self._radii = np.append(self._radii, [each.radius for each in new])
        return self._radii

    @property
    def frees(self) -> NDArray[np.bool_]:
        """(n,) which symbols are free."""
        new = self.definitions[len(self._frees) :]
        if new:
            self._frees = np.append(self._frees, np.array([each.free for each in new], np.bool_))
        return self._frees

    @property
    def keeping(self) -> Integers:
        """(n,) how many frames keep each symbol."""
        new = self.definitions[len(self._keeping) :]
        if new:
            more = np.array([len(each.stabiliser) for each in new], np.int64)
            self._keeping = np.append(self._keeping, more)
        return self._keeping

    def __getitem__(self, symbol: int) -> Definition:
        return self.definitions[symbol]

    def __len__(self) -> int:
        return len(self.definitions)

    def add_terminal(self, symmetry: Symmetry, radius: float) -> int:
        """A new terminal; its number."""
        leaves = np.array([len(self)], np.int64)
        made = Definition(
            np.zeros(0, np.int64),
            NONE,
            leaves,
            ORIGIN,
            symmetry.stabiliser,
            symmetry.order == 0,
            radius,
            np.zeros(1, np.complex128),
            np.ones(1, np.complex128),
        )
        self.definitions.append(made)
        return len(self) - 1

    def add_group(self, parts: Integers, places: Frames, effect: int = -1, mark: int = -1) -> int:
        """A new group of symbols (m,) at places (m,), wrapped in an effect of some class; its
        number. mark: the terminal that stands for the effect where it lies somewhere.
        """
        made = replace(self._composed(parts, places), effect=effect)
        self.definitions.append(made if mark < 0 else self._marked(made, mark))
        return len(self) - 1

    def _marked(self, group: Definition, mark: int) -> Definition:
        """A group whose effect is its first leaf, so that it is compared with what was seen."""
        own = self[mark]
        keeps = group.stabiliser
        if len(keeps) > 1:  # the identity always keeps everything
            keeps = keeps[self._keeps(mark, ORIGIN, keeps)]
        return replace(
            group,
            leaves=np.concatenate([own.leaves, group.leaves]),
            leaf_frames=join([own.leaf_frames, group.leaf_frames]),
            at=np.concatenate([own.at, group.at]),
            arm=np.concatenate([own.arm, group.arm]),
            stabiliser=keeps,
            free=own.free and group.free,
            radius=max(own.radius, group.radius),
            anchored=True,
            marks=group.marks + 1,
        )

    def add_sequence(self, part: int, count: int, pattern: Pattern, family: int) -> int:
        """A new sequence of `count` copies; its number. family -1: the first of its kind."""
        places = pattern.places(count)
        made = self._composed(np.full(count, part, np.int64), places)
        family = len(self) if family < 0 else family
        self.definitions.append(replace(made, pattern=pattern, family=family))
        return len(self) - 1

    def add_tree(self, part: int, branching: Branching) -> int:
        """A new branching structure of copies of `part`; its number."""
        grown = grow(identity(1), list(branching.twigs), branching.depth, len(branching.order))
        assert grown is not None
        places = grown.frames[grown.preorder()]
        symbol = self.add_group(np.full(len(places), part, np.int64), places)
        self.definitions[symbol] = replace(self.definitions[symbol], branching=branching)
        return symbol

    def add_lattice(self, rule: LatticeRule, places: Frames) -> int:
        """A lattice of copies at places (m,), by node; its number. It has no symmetry."""
        inner = self[rule.part]
        every = compose(places[:, None], inner.leaf_frames)
        placed = every.flat()
        radius = float(np.max(np.abs(places.position) + places.scale * inner.radius))
        self.definitions.append(
            Definition(
                np.full(len(places), rule.part, np.int64),
                places,
                np.tile(inner.leaves, len(places)),
                placed,
                identity(1),
                False,
                radius,
                placed.position,
                placed.factor,
                lattice=rule,
            )
        )
        return len(self) - 1

    def rewrite(self, symbol: int, parts: Integers, places: Frames) -> None:
        """Say otherwise what a group is made of: other parts that expand to the same."""
        known = self.definitions[symbol]
        self.definitions[symbol] = replace(known, parts=parts, places=places)

    def sort(self) -> Integers:
        """Number symbols so that each is made of earlier ones; (n,) new number of each old one."""
        order: list[int] = []
        known = np.zeros(len(self), np.bool_)
        waiting = list(range(len(self) - 1, -1, -1))
        while waiting:
            symbol = waiting.pop()
            open_parts = np.unique(self[symbol].parts[~known[self[symbol].parts]]).tolist()
            if known[symbol]:
                continue
            if open_parts:
                waiting += [symbol, *open_parts]
            else:
                known[symbol] = True
                order.append(symbol)
        number = np.argsort(np.array(order, np.int64))
        self.definitions = [
            replace(
                each,
                parts=number[each.parts],
                leaves=number[each.leaves],
                family=int(number[each.family]) if each.family >= 0 else -1,
            )
            for each in (self.definitions[symbol] for symbol in order)
        ]
        self._radii, self._frees = self._radii[:0], self._frees[:0]
        self._keeping = self._keeping[:0]
        return number

    def alike(self, part: int, one: Frames, other: Frames) -> NDArray[np.bool_]:
        """(k,) whether a symbol looks the same at both of two frames, row by row."""
        moved = compose(other, inverse(one))
        rows = [slice(k, k + 1) for k in range(len(one))]
        return np.array([self._keeps(part, one[row], moved[row])[0] for row in rows], np.bool_)

    def _composed(self, parts: Integers, places: Frames) -> Definition:
        known = [self[int(part)] for part in parts]
        leaves = np.concatenate([each.leaves for each in known])
        if len(leaves) == len(parts):
            placed = compose(places, join([each.leaf_frames for each in known]))
        else:
            placed = join(
                [compose(places[k : k + 1], each.leaf_frames) for k, each in enumerate(known)]
            )
        reach = [each.radius for each in known]
        radius = float(np.max(np.abs(places.position) + places.scale * np.array(reach)))
        keeps, free = self._stabiliser(parts, places)
        at, arm = placed.position, placed.factor
        marks = sum(each.marks for each in known)
        return Definition(parts, places, leaves, placed, keeps, free, radius, at, arm, marks=marks)

    def _stabiliser(self, parts: Integers, places: Frames) -> tuple[Frames, bool]:
        """Frames that keep every member where it is, and whether all rotations do."""
        first = self[int(parts[0])]
        if len(first.stabiliser) == 1 and not first.free:
            return ORIGIN, False
        lead = compose(places[:1], first.stabiliser)
        candidates = compose(lead, inverse(places[:1]))
        if first.free:
            candidates = self._of_free(parts, places)
        keep = np.ones(len(candidates), np.bool_)
        for part, index in zip(parts.tolist(), range(len(parts)), strict=True):
            if keep.sum() == 1:  # the identity always keeps everything
                break
            keep &= self._keeps(int(part), places[index : index + 1], candidates)
        still = bool(np.all(np.abs(places.position) <= self.tolerance))
        free = still and all(self[int(part)].free for part in parts)
        return candidates[keep], free

    def _of_free(self, parts: Integers, places: Frames) -> Frames:
        """Candidates for a group that begins with a circle: mirrors in the line to the first member
        off its centre, or what the first member keeps that is no circle.
        """
        away = np.abs(places.position - places.position[0]) > self.tolerance
        bound = np.array([not self[int(part)].free for part in parts])
        which = int(np.argmax(away | bound)) if (away | bound).any() else 0
        to = places.position[0]
        if away[which]:
            axis = np.angle(places.position[which] - to, deg=True)
            turn = np.array([0.0, 2 * axis + 180.0])
            hand = np.array([1, -1], np.int8)
            about = frames(np.zeros(2, np.complex128), turn, 1.0, hand)
        else:
            place = places[which : which + 1]
            about = compose(compose(place, self[int(parts[which])].stabiliser), inverse(place))
            return about
        there = frames(np.array([to]))
        return compose(compose(there, about), inverse(there))

    def _keeps(self, part: int, place: Frames, candidates: Frames) -> NDArray[np.bool_]:
        """(k,) which candidates map the member at `place` onto itself."""
        back = compose(compose(inverse(place), candidates), place)
        definition = self[part]
        reach = float(place.scale[0])
        near = np.abs(back.position) * reach <= self.tolerance
        if definition.free:
            return near
        known = definition.stabiliser
        shift = np.abs(back.position[:, None] - known.position)
        turn = np.abs(back.factor[:, None] - known.factor) * definition.radius
        same = back.handedness[:, None] == known.handedness
        return np.asarray((same & ((shift + turn) * reach <= self.tolerance)).any(axis=1))


@dataclass(slots=True, eq=False)
class Arrangement:
    """Symbols placed in paint order, n of them.

    symbol: (n,); placed: (n,) world frames; start: (n,) first element each covers, which run to the
    next one's start; wrap: (n,) number of the effects around it, which no group may mix.
    """

    symbol: Integers
    placed: Frames
    start: Integers
    wrap: Integers

    def __len__(self) -> int:
        return len(self.symbol)

    def __getitem__(self, rows: NDArray[np.bool_] | Integers) -> Arrangement:
        return Arrangement(self.symbol[rows], self.placed[rows], self.start[rows], self.wrap[rows])


def joined(parts: list[Arrangement]) -> Arrangement:
    """One arrangement after the other."""
    return Arrangement(
        np.concatenate([each.symbol for each in parts]),
        join([each.placed for each in parts]),
        np.concatenate([each.start for each in parts]),
        np.concatenate([each.wrap for each in parts]),
    )


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What expansions are compared with, a row for each element in paint order.

    terminal: (n,); at, arm, hand: (n, k) the k equivalent frames of each, as position and factor
    (complex) and handedness, 0 where there are fewer; free: (n,) any turn is equivalent; radius:
    (n,) extent of the representative, units at scale 1.
    """

    terminal: Integers
    at: Complexes
    arm: Complexes
    hand: Integers
    free: NDArray[np.bool_]
    radius: Floats


def see(alphabet: Alphabet, terminal: Integers, placed: Frames) -> Seen:
    """The observed elements (n,) of an alphabet that has only terminals yet."""
    keeps = join([each.stabiliser for each in alphabet.definitions])
    counts = np.array([len(each.stabiliser) for each in alphabet.definitions], np.int64)
    first = np.cumsum(counts) - counts
    shape = (len(terminal), int(counts.max(initial=1)))
    at, arm = np.zeros(shape, np.complex128), np.zeros(shape, np.complex128)
    hand = np.zeros(shape, np.int64)
    for count in np.unique(counts[terminal]).tolist():
        rows = np.flatnonzero(counts[terminal] == count)
        every = compose(
            placed[rows][:, None], keeps[first[terminal[rows]][:, None] + np.arange(count)]
        )
        at[rows, :count], arm[rows, :count] = every.position, every.factor
        hand[rows, :count] = every.handedness
    free = np.array([each.free for each in alphabet.definitions], np.bool_)
    radius = np.array([each.radius for each in alphabet.definitions])
    return Seen(terminal, at, arm, hand, free[terminal], radius[terminal])


def misses(alphabet: Alphabet, seen: Seen, symbol: int, placed: Frames, start: Integers) -> Floats:
    """(k,) bound on the distance, in units, between `symbol` at k frames and the elements observed
    from `start` on; infinite where other terminals stand there.
    """
    definition = alphabet[symbol]
    rows = start[:, None] + np.arange(definition.size)
    outside = rows[:, -1] >= len(seen.terminal)
    rows = np.minimum(rows, len(seen.terminal) - 1)
    wrong = (seen.terminal[rows] != definition.leaves).any(axis=1) | outside
    turned = placed.handedness[:, None] < 0
    factor = placed.factor[:, None]
    at = np.where(turned, -definition.at.conj(), definition.at) * factor
    at += placed.position[:, None]
    arm = np.where(turned, definition.arm.conj(), definition.arm) * factor
    hand = placed.handedness[:, None] * definition.leaf_frames.handedness
    radius = seen.radius[rows]
    gap = np.abs(at[..., None] - seen.at[rows]) + radius[..., None] * np.abs(
        arm[..., None] - seen.arm[rows]
    )
    best = np.where(seen.hand[rows] == hand[..., None], gap, np.inf).min(axis=-1)
    grown = np.abs(np.abs(arm) - np.abs(seen.arm[rows, 0]))
    round_gap = np.abs(at - seen.at[rows, 0]) + radius * grown
    worst = np.where(seen.free[rows], round_gap, best).max(axis=1)
    return np.where(wrong, np.inf, worst)
