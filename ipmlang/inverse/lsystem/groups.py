"""Runs of elements under one group effect as symbols, so that a clipped thing is a thing like any.

In go the string of all terminals and the effects around each; out comes a string of symbols that
mixes no effects: every maximal run under one effect is a group symbol, innermost effects first, and
equal runs are one symbol. What a group holds stands behind the main string, once, as a stretch of
its own, so that a search finds rules inside of groups and shares them. No rule is looked for here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import Floats, Frames, compose, frames, inverse, join, replaced
from ipmlang.inverse.lsystem.symbols import (
    Alphabet,
    Arrangement,
    Integers,
    Seen,
    joined,
    misses,
    see,
)
from ipmlang.inverse.lsystem.symmetry import Symmetry

Scalar = TypeVar("Scalar", bound=np.generic)


@dataclass(frozen=True, slots=True, eq=False)
class Kind:
    """One class of effects: whether it lies somewhere, the distance from its origin at which a
    wrong turn of it shows as much as elsewhere, and the frames that keep it.
    """

    anchored: bool
    radius: float
    symmetry: Symmetry


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """A maximal run of elements `first` .. `last` under one effect: its class, the frame of it, the
    number of the run around (-1: none) and how many there are. start: the row of its first leaf.
    """

    kind: int
    placed: Frames
    parent: int
    depth: int
    first: int
    last: int
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class Grouped:
    """A string in which no run mixes effects.

    bodies: for each stretch behind the main one, by its `wrap`, the group's symbol and the world
    frame of the copy that stands there. element: (m,) the element of each row of `seen`, which has
    a row for every effect that lies somewhere, before what is in it.
    """

    alphabet: Alphabet
    string: Arrangement
    seen: Seen
    bodies: Mapping[int, tuple[int, Frames]]
    element: Integers


def group_runs(
    alphabet: Alphabet,
    string: Arrangement,
    seen: Seen,
    stacks: Sequence[Sequence[tuple[str, int, Frames]]],
    kinds: Sequence[Kind],
    shared: bool,
) -> Grouped:
    """Group the elements of a string of terminals, all of them in its main stretch.

    seen: the elements as they are; stacks: the effects around each of them, outermost first: a name
    that differs between neighbours that are not in one group, the class, the frame. Unless `shared`
    every run becomes a symbol of its own, and no bodies stand behind the string.
    """
    marked = Alphabet(alphabet.tolerance, list(alphabet.definitions))
    marks = [
        marked.add_terminal(kind.symmetry, kind.radius) if kind.anchored else -1 for kind in kinds
    ]
    runs, inner = _runs(stacks, marks)
    seen, element, start = _with_marks(marked, seen, runs, marks)
    work = Arrangement(string.symbol, string.placed, start, inner + 1)
    collapse = _Collapse(marked, seen, runs, marks, shared)
    for depth in range(max((run.depth for run in runs), default=-1), -1, -1):
        work = collapse.level(work, depth)
    everything = joined([work, *collapse.bodies]) if shared else work
    return Grouped(marked, everything, seen, collapse.leads, element)


def _runs(
    stacks: Sequence[Sequence[tuple[str, int, Frames]]], marks: Sequence[int]
) -> tuple[list[Run], Integers]:
    """All runs, those around before those inside; (n,) the innermost run of each element or -1."""
    found: list[Run] = []
    inner = np.full(len(stacks), -1, np.int64)
    names: list[str] = []
    numbers: list[int] = []
    marked = 0
    for element, stack in enumerate(stacks):
        same = 0
        while same < min(len(names), len(stack)) and names[same] == stack[same][0]:
            same += 1
        for number in numbers[same:]:
            found[number] = replace(found[number], last=element)
        del names[same:], numbers[same:]
        for name, kind, placed in stack[same:]:
            parent = numbers[-1] if numbers else -1
            start = element + marked
            marked += marks[kind] >= 0
            numbers.append(len(found))
            names.append(name)
            found.append(Run(kind, placed, parent, len(numbers) - 1, element, element, start))
        inner[element] = numbers[-1] if numbers else -1
    for number in numbers:
        found[number] = replace(found[number], last=len(stacks))
    return found, inner


def _with_marks(
    alphabet: Alphabet, seen: Seen, runs: Sequence[Run], marks: Sequence[int]
) -> tuple[Seen, Integers, Integers]:
    """What was seen, effects that lie somewhere among the elements; the element of each row, and
    the row of each element.
    """
    count = len(seen.terminal)
    marking = [run for run in runs if marks[run.kind] >= 0]
    before = np.array([run.first for run in marking], np.int64)
    row = np.arange(count) + np.searchsorted(before, np.arange(count), side="right")
    own = np.array([run.start for run in marking], np.int64)
    element = np.empty(count + len(marking), np.int64)
    element[row], element[own] = np.arange(count), before
    if not marking:
        return seen, element, row
    numbers = np.array([marks[run.kind] for run in marking], np.int64)
    known, which = np.unique(numbers, return_inverse=True)
    small = Alphabet(alphabet.tolerance, [alphabet[number] for number in known.tolist()])
    effects = see(small, which.reshape(-1), join([run.placed for run in marking]))
    order = np.empty(count + len(marking), np.int64)
    order[row], order[own] = np.arange(count), count + np.arange(len(marking))
    return _merged(seen, replace(effects, terminal=numbers), order), element, row


def _merged(one: Seen, other: Seen, order: Integers) -> Seen:
    """Rows of both, in an order of the rows of one followed by those of the other."""
    width = max(one.at.shape[1], other.at.shape[1])

    def wide(first: NDArray[Scalar], second: NDArray[Scalar]) -> NDArray[Scalar]:
        padded = [np.pad(each, ((0, 0), (0, width - each.shape[1]))) for each in (first, second)]
        return np.concatenate(padded)[order]

    return Seen(
        np.concatenate([one.terminal, other.terminal])[order],
        wide(one.at, other.at),
        wide(one.arm, other.arm),
        wide(one.hand, other.hand),
        np.concatenate([one.free, other.free])[order],
        np.concatenate([one.radius, other.radius])[order],
    )


@dataclass(slots=True, eq=False)
class _Collapse:
    """Makes symbols of runs. leads: by the number of the stretch in `bodies`."""

    alphabet: Alphabet
    seen: Seen
    runs: Sequence[Run]
    marks: Sequence[int]
    shared: bool
    bodies: list[Arrangement] = field(default_factory=list)
    leads: dict[int, tuple[int, Frames]] = field(default_factory=dict)

    def level(self, string: Arrangement, depth: int) -> Arrangement:
        """The string with the runs of one depth collapsed; deeper ones are so already."""
        depths = np.array([-1, *(run.depth for run in self.runs)])
        begins = np.flatnonzero(np.diff(string.wrap, prepend=-1))
        bounds = np.append(begins, len(string))
        segments = [
            (int(string.wrap[first]) - 1, first, last)
            for first, last in pairwise(bounds.tolist())
            if depths[string.wrap[first]] == depth
        ]
        symbol, wrap = string.symbol.copy(), string.wrap.copy()
        start = string.start.copy()
        keep = np.ones(len(string), np.bool_)
        rows: list[int] = []
        leads: list[Frames] = []
        for equal in self._buckets(string, segments):
            for (number, first, last), made, lead in self._symbols(string, equal):
                symbol[first], wrap[first] = made, self.runs[number].parent + 1
                start[first] = self.runs[number].start
                keep[first + 1 : last] = False
                rows.append(first)
                leads.append(lead)
        placed = replaced(string.placed, np.array(rows, np.int64), join(leads))
        return Arrangement(symbol, placed, start, wrap)[keep]

    def _buckets(self, string: Arrangement, segments: list[Segment]) -> list[list[Segment]]:
        """Segments of one class with the same terminals."""
        found: dict[tuple[int, bytes], list[Segment]] = {}
        for segment in segments:
            number, first, last = segment
            parts = string.symbol[first:last].tolist()
            leaves = np.concatenate([self.alphabet[part].leaves for part in parts])
            found.setdefault((self.runs[number].kind, leaves.tobytes()), []).append(segment)
        if self.shared:
            return list(found.values())
        return [[segment] for equal in found.values() for segment in equal]

    def _symbols(
        self, string: Arrangement, segments: list[Segment]
    ) -> list[tuple[Segment, int, Frames]]:
        """A symbol and a frame for each segment; segments that are equal get one symbol."""
        made: list[tuple[Segment, int, Frames]] = []
        waiting = segments
        while waiting:
            symbol, lead = self._define(string, waiting[0])
            made.append((waiting[0], symbol, lead))
            others = waiting[1:]
            if not others:
                break
            starts = np.array([self.runs[number].start for number, _, _ in others], np.int64)
            placed, error = self._laid(symbol, lead, waiting[0], others, starts)
            equal = error <= self.alphabet.tolerance
            made += [
                (segment, symbol, placed[row : row + 1])
                for row, segment in enumerate(others)
                if equal[row]
            ]
            waiting = [segment for row, segment in enumerate(others) if not equal[row]]
        return made

    def _define(self, string: Arrangement, segment: Segment) -> tuple[int, Frames]:
        """The symbol of a segment, and the frame in which it stands there."""
        number, first, last = segment
        run = self.runs[number]
        mark = self.marks[run.kind]
        inside = string[np.arange(first, last)]
        lead = run.placed if mark >= 0 else frames(inside.placed.position[:1])
        places = compose(inverse(lead), inside.placed)
        symbol = self.alphabet.add_group(inside.symbol, places, run.kind, mark)
        if self.shared:
            stretch = len(self.runs) + 1 + len(self.bodies)
            own = np.full(last - first, stretch, np.int64)
            self.bodies.append(replace(inside, wrap=own))
            self.leads[stretch] = (symbol, lead)
        return symbol, lead

    def _laid(
        self, symbol: int, lead: Frames, model: Segment, others: list[Segment], starts: Integers
    ) -> tuple[Frames, Floats]:
        """The frames that lay a symbol over segments, and what they miss."""
        run = self.runs[model[0]]
        best, error = join([lead] * len(others)), np.full(len(others), np.inf)
        for step in self._steps(symbol, run.start, starts):
            tried = compose(step, lead)
            missed = misses(self.alphabet, self.seen, symbol, tried, starts)
            better = np.flatnonzero(missed < error)
            error[better] = missed[better]
            best = replaced(best, better, tried[better])
        return best, error

    def _steps(self, symbol: int, model: int, starts: Integers) -> list[Frames]:
        """Maps from the copy at row `model` to those at rows `starts` (k,) that may lay it over
        them: by what has fewest symmetries in it, and by the effect, which may be larger.
        """
        definition = self.alphabet[symbol]
        leaves = definition.leaves
        known = [self.alphabet[int(leaf)] for leaf in leaves]
        which = min(range(len(known)), key=lambda k: (known[k].free, len(known[k].stabiliser)))
        if known[which].free:
            return self._round_steps(model, starts, which, len(leaves))
        steps: list[Frames] = []
        for leaf in dict.fromkeys([0, which] if definition.anchored else [which]):
            rows = np.concatenate([[model], starts]) + leaf
            count = len(known[leaf].stabiliser)
            every = [_placed(self.seen, rows, option) for option in range(count)]
            steps += [compose(each[1:], inverse(every[0][:1])) for each in every]
        return steps

    def _round_steps(self, model: int, starts: Integers, which: int, size: int) -> list[Frames]:
        """The same where every leaf is a circle: by one of them and the one farthest from it."""
        rows = np.concatenate([[model], starts])
        here = self.seen.at[rows + which, 0]
        away = self.seen.at[model + np.arange(size), 0] - here[0]
        far = int(np.argmax(np.abs(away)))
        grown = np.abs(self.seen.arm[rows + which, 0])
        if abs(away[far]) <= self.alphabet.tolerance:
            options = [frames(here, 0.0, grown)]
        else:
            turn = np.angle(self.seen.at[rows + far, 0] - here, deg=True)
            mirrored = np.where(np.arange(len(rows)) == 0, 1, -1).astype(np.int8)
            options = [
                frames(here, turn, grown),
                frames(here, np.where(mirrored > 0, turn, turn + 180.0), grown, mirrored),
            ]
        return [compose(each[1:], inverse(each[:1])) for each in options]


Segment = tuple[int, int, int]  # the number of a run, and its rows in the string


def _placed(seen: Seen, rows: NDArray[np.int64], option: int) -> Frames:
    """One of the equivalent frames of each row; the first where there are fewer."""
    which = np.where(seen.hand[rows, option] != 0, option, 0)
    arm = seen.arm[rows, which]
    hand = seen.hand[rows, which].astype(np.int8)
    return frames(seen.at[rows, which], np.angle(arm, deg=True), np.abs(arm), hand)
