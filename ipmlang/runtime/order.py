"""Where everything stands in the order of the derivation, found once at the end.

In go the records of all applications: for each batch of shapes the slots of its body, in order,
with what was drawn or made there; out comes the row of every drawn thing. Shapes are weighed from
the last record to the first, places handed down from the first to the last: no loop goes over
shapes but that of a trace.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Numbers: TypeAlias = NDArray[np.int64]
Weights: TypeAlias = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """Drawings `start` .. `start + count`, one for each row of the batch (or for `rows`)."""

    start: int
    count: int
    rows: Numbers | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Made:
    """Shapes `start` .. `start + count`, as above."""

    start: int
    count: int
    rows: Numbers | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Copies:
    """Copies of inner slots: row r of them belongs to row owner[r] of the batch around."""

    counts: Numbers
    owner: Numbers
    slots: Sequence[Slot]


Slot: TypeAlias = Drawn | Made | Copies


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """One batch of shapes (their numbers) that took one production."""

    shapes: NDArray[np.int32]
    slots: Sequence[Slot]


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """Shapes derived one by one: `first` .. `last` were made, and for each application its shape
    and its items, a shape's number or ~drawing.
    """

    first: int
    last: int
    steps: list[tuple[int, tuple[int, ...]]]


class Order:
    """The records of a derivation, in the order of the applications; `open` is the one that is
    still being written, if any. The first shapes, `first` of them, are what the axiom is applied
    to.
    """

    def __init__(self) -> None:
        self.records: list[Record | Trace] = []
        self.first = 1
        self.open: Trace | None = None

    def places(self, shapes: int, drawings: int) -> NDArray[np.int32]:
        """The row (drawings,) of each drawing; those of the first shapes follow each other."""
        weights = np.zeros(shapes, np.int32)
        for record in reversed(self.records):
            if isinstance(record, Trace):
                _weigh_trace(record, weights)
            else:
                weights[record.shapes] = _weigh(record.slots, len(record.shapes), weights)
        begins = np.zeros(shapes, np.int32)
        begins[1 : self.first] = np.cumsum(weights[: self.first - 1])
        places = np.empty(drawings, np.int32)
        for record in self.records:
            if isinstance(record, Trace):
                _lay_trace(record, weights, begins, places)
            else:
                _lay(record.slots, begins[record.shapes], weights, begins, places)
        return places


def ranked(records: Sequence[Record], ranks: Numbers, shapes: int, drawings: int) -> Numbers:
    """Numbers (shapes,) that rise from left to right among what one generation made: `records` are
    all of its applications, `ranks` such numbers of its own shapes.
    """
    weights = np.ones(shapes, np.int32)
    total = np.zeros(shapes, np.int32)
    for record in records:
        total[record.shapes] = _weigh(record.slots, len(record.shapes), weights)
    own = np.concatenate([record.shapes for record in records])
    own = own[np.argsort(ranks[own], kind="stable")]
    begins = np.zeros(shapes, np.int32)
    begins[own] = np.cumsum(total[own]) - total[own]
    made = np.zeros(shapes, np.int32)
    made[: len(ranks)] = ranks
    places = np.zeros(drawings, np.int32)
    for record in records:
        _lay(record.slots, begins[record.shapes], weights, made, places)
    return made.astype(np.int64)


def _weigh(slots: Sequence[Slot], count: int, weights: Weights) -> Weights:
    """How many drawings each row of a batch becomes."""
    total = np.zeros(count, np.int32)
    for slot in slots:
        if isinstance(slot, Copies) and count == 1:
            total += _weigh(slot.slots, len(slot.owner), weights).sum(dtype=np.int32)
            continue
        if isinstance(slot, Copies):
            total += _sums(_weigh(slot.slots, len(slot.owner), weights), slot.counts)
            continue
        weight = 1 if isinstance(slot, Drawn) else weights[slot.start : slot.start + slot.count]
        if slot.rows is None:
            total += weight
        else:
            total[slot.rows] += weight
    return total


def _sums(values: Weights, counts: Numbers) -> Weights:
    before = np.append(0, np.cumsum(values, dtype=np.int64))
    ends = np.cumsum(counts)
    sums: Weights = (before[ends] - before[ends - counts]).astype(np.int32)
    return sums


def _lay(
    slots: Sequence[Slot], begin: Weights, weights: Weights, begins: Weights, places: Weights
) -> None:
    """Give the slots of a batch their places; `begin` (n,) is where each row starts."""
    for slot in slots:
        if isinstance(slot, Copies) and len(begin) == 1:
            inner = _weigh(slot.slots, len(slot.owner), weights)
            after = begin[0] + np.cumsum(inner, dtype=np.int32)
            _lay(slot.slots, after - inner, weights, begins, places)
            begin = after[-1:] if len(after) else begin
            continue
        if isinstance(slot, Copies):
            inner = _weigh(slot.slots, len(slot.owner), weights)
            before = np.append(0, np.cumsum(inner, dtype=np.int64))
            ends = np.cumsum(slot.counts)
            offset = before[:-1] - before[ends - slot.counts][slot.owner]
            own = (begin[slot.owner] + offset).astype(np.int32)
            _lay(slot.slots, own, weights, begins, places)
            begin = begin + (before[ends] - before[ends - slot.counts]).astype(np.int32)
            continue
        span = slice(slot.start, slot.start + slot.count)
        (places if isinstance(slot, Drawn) else begins)[span] = (
            begin if slot.rows is None else begin[slot.rows]
        )
        weight = 1 if isinstance(slot, Drawn) else weights[span]
        if slot.rows is None:
            begin = begin + weight
        else:
            begin = begin.copy()
            begin[slot.rows] += weight


def _weigh_trace(trace: Trace, weights: Weights) -> None:
    base = trace.first
    own = weights[base : trace.last].tolist()
    for shape, items in reversed(trace.steps):
        total = 0
        for item in items:
            total += 1 if item < 0 else own[item - base]
        if shape >= base:
            own[shape - base] = total
        else:
            weights[shape] = total
    weights[base : trace.last] = own


def _lay_trace(trace: Trace, weights: Weights, begins: Weights, places: Weights) -> None:
    base = trace.first
    weight = weights[base : trace.last].tolist()
    begin = begins[base : trace.last].tolist()
    drawings, rows = [], []
    for shape, items in trace.steps:
        place = begin[shape - base] if shape >= base else int(begins[shape])
        for item in items:
            if item < 0:
                drawings.append(~item)
                rows.append(place)
                place += 1
            else:
                begin[item - base] = place
                place += weight[item - base]
    begins[base : trace.last] = begin
    places[np.array(drawings, np.int64)] = rows
