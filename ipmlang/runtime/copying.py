"""What a body of copies asks for: counts, owners, and the states that copies find.

In go columns of a batch and of its copies, out come columns; frames of copies that follow each
other are found by segmented scans. Nothing is drawn or made here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.runtime import scan
from ipmlang.runtime.code import Column
from ipmlang.runtime.fields import UNSET
from ipmlang.runtime.keys import Words
from ipmlang.runtime.limits import Counted
from ipmlang.runtime.rewrite import copies_of
from ipmlang.runtime.runs import Standing

Numbers = NDArray[np.int64]
Around = tuple[Numbers, ...]  # the rows that copies belong to, from the innermost ones outward
Pair = tuple[NDArray[np.float64], NDArray[np.float64]]


class Copying:
    """The part of a run that repeats use."""

    def __init__(self, program: ir.Program, counted: Counted) -> None:
        self.program = program
        self.counted = counted

    def factor(self, value: Column, around: Around = ()) -> None:
        """A scale's factor must be above 0."""
        fits = np.atleast_1d(value) > 0
        if not fits.all():
            message = "`*` needs a factor above 0"
            row = int(np.argmin(fits))
            raise self.counted.error("scale-not-positive", message, row=row, around=around)

    def finite(
        self,
        value: Column,
        name: str,
        count: int = 1,
        shown: Numbers | None = None,
        around: Around = (),
    ) -> None:
        """An argument of an operation must be a finite number, in so many rows, or those shown."""
        if math.isfinite(np.minimum.reduce(value, axis=None, initial=0.0)) and math.isfinite(
            np.maximum.reduce(value, axis=None, initial=0.0)
        ):
            return
        wrong = np.flatnonzero(~np.isfinite(np.broadcast_to(value, (count,))))
        if shown is not None:
            wrong = np.intersect1d(wrong, shown)
        if len(wrong):
            message = f"an argument of {name} is not a finite number"
            row = int(wrong[0])
            raise self.counted.error("not-a-number", message, row=row, around=around)

    def counts(
        self, limit: Column, count: int, shown: Numbers | None = None, around: Around = ()
    ) -> Numbers:
        """How many copies each row of a batch makes, (count,); a row that is not shown makes none
        where its limit is no number.
        """
        limits = np.broadcast_to(np.asarray(limit, np.float64), (count,))
        if shown is not None:
            limits = np.where(self.mask(shown, count) | np.isfinite(limits), limits, 0.0)
        known = np.isfinite(limits)
        if not known.all():
            message = "the count of a repeat is no finite number"
            row = int(np.argmin(known))
            raise self.counted.error("not-a-number", message, row=row, around=around)
        found = copies_of(limits)
        self.counted.copy(float(found.sum()))
        return found.astype(np.int64)

    def copies(self, counts: Numbers) -> tuple[Numbers, Words]:
        """The row that each copy belongs to, and its number there."""
        owner = np.repeat(np.arange(len(counts)), counts)
        begins = np.cumsum(counts) - counts
        return owner, (np.arange(len(owner)) - begins[owner]).astype(np.uint32)

    def standing(self, rows: Standing, count: int) -> tuple[Numbers, Words, Numbers]:
        """The copies of runs of rows in a batch, as `Standing.copies` says them."""
        for each in rows.reached:
            self.counted.copy(float(each * count))
        return rows.copies(count)

    def mask(self, rows: Numbers, count: int) -> NDArray[np.bool_]:
        """Which rows are among those."""
        found = np.zeros(count, np.bool_)
        found[rows] = True
        return found

    def walk(
        self, counts: Numbers, count: int, state: Mapping[str, Column], step: Mapping[str, Column]
    ) -> tuple[dict[str, Column], dict[str, Column]]:
        """The frames that the copies find, and those after the last copy of each row.

        `state` has the frames of the rows before, `step` what each copy does to its own.
        """
        names = list(state)
        before = {name: _full(state[name], len(counts)) for name in names}
        own = {name: _full(step[name], count) for name in names}
        ones = (np.ones(len(counts)), np.ones(count))
        scale, factor = before.get("scale", ones[0]), own.get("scale", ones[1])
        if self.program.flat:
            start = (before["x"], before["y"], before["angle"], scale)
            steps = (own["x"], own["y"], own["angle"], factor)
            after = dict(
                zip(
                    ("x", "y", "angle", "scale"),
                    scan.planar_chain(*steps, counts, start),
                    strict=True,
                )
            )
        else:
            found = scan.chain(_frames(own, factor), _frames(before, scale), counts)
            columns = (*found.position.T, *found.rotation.T, found.scale)
            after = dict(zip((*"xyzwijk", "scale"), columns, strict=True))
        return self._both(names, counts, before, after)

    def total(self, counts: Numbers, count: int, state: Column, step: Column) -> Pair:
        """What copies add up to: before each copy, and after the last."""
        before = _full(state, len(counts))
        after = scan.running_sum(_full(step, count), counts, before)
        return _split(counts, before, after)

    def last(self, counts: Numbers, count: int, state: Column, step: Column) -> Pair:
        """What the last copy that sets a field has set, before each copy and at the end."""
        before, own = _full(state, len(counts)), _full(step, count)
        setting = np.where(own != UNSET, np.arange(count), -1)
        if (setting < 0).any():
            owner = np.repeat(np.arange(len(counts)), counts)
            setting = np.maximum.accumulate(setting)
            here = setting >= (np.cumsum(counts) - counts)[owner]
            own = np.where(here, own[setting], before[owner])
        return _split(counts, before, own)

    def _both(
        self,
        names: list[str],
        counts: Numbers,
        before: Mapping[str, NDArray[np.float64]],
        after: Mapping[str, NDArray[np.float64]],
    ) -> tuple[dict[str, Column], dict[str, Column]]:
        pairs = {name: _split(counts, before[name], after[name]) for name in names}
        return (
            {name: pair[0] for name, pair in pairs.items()},
            {name: pair[1] for name, pair in pairs.items()},
        )


def _full(value: Column, count: int) -> NDArray[np.float64]:
    return np.broadcast_to(np.asarray(value, np.float64), (count,))


def _split(counts: Numbers, before: NDArray[np.float64], after: NDArray[np.float64]) -> Pair:
    """States before each copy, and after the last copy of each row."""
    found = scan.shifted(after, counts, before)
    ended = before.copy()
    made = counts > 0
    ended[made] = after[(np.cumsum(counts) - 1)[made]]
    return found, ended


def _frames(columns: Mapping[str, NDArray[np.float64]], scale: NDArray[np.float64]) -> scan.Frames:
    position = np.stack([columns[name] for name in "xyz"], axis=1)
    return scan.Frames(position, np.stack([columns[name] for name in "wijk"], axis=1), scale)
