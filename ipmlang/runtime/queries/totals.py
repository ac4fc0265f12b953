"""Answers about what shapes of earlier phases made: how many, which one, how much, and shares.

In go the rows of a derivation and those that ask, out come numbers. Competitors stand in the order
of their keys, which the seed decides, so that answers depend neither on the order of derivation nor
on how shapes are batched.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.runtime.queries.marks import LABELLED, NAMED, REPORTING, Floats, Kind, Marks, Numbers

LABELS: tuple[Kind, ...] = (NAMED, LABELLED)
REPORTS: tuple[Kind, ...] = (REPORTING,)


@dataclass(frozen=True, slots=True, eq=False)
class Ranked:
    """The competitors of one label, ordered by what they stand in and then by key: their rows, the
    groups (n,) ascending, their numbers in the group, and the running sums of their values in it.
    """

    rows: Numbers
    group: Numbers
    rank: Numbers
    sums: Floats

    def ends(self, group: Numbers) -> Numbers:
        """Where the last of each group stands, -1 for a group without any."""
        end = np.searchsorted(self.group, group, side="right") - 1
        return np.where(self.group[np.maximum(end, 0)] == group, end, -1) if len(self.rows) else (
            np.full(len(group), -1)
        )  # fmt: skip


class Totals:
    """What one phase may ask of the ones before it."""

    def __init__(self, marks: Marks, phase: float) -> None:
        self._marks = marks
        self._phase = phase
        self._known: dict[tuple[bool, int, int], Ranked] = {}

    def answer(
        self, name: str, rows: Numbers, label: Numbers, whole: Floats, within: Numbers
    ) -> Floats:
        """Answers (n,) to a query of rows (n,) about a label or key (n,), dealing out `whole` (n,),
        in what is labelled `within` (n,), -1: anywhere.
        """
        found = np.zeros(len(rows))
        pairs = np.unique(np.stack([label, within], axis=1), axis=0)
        for own, around in pairs.tolist():
            asked = np.flatnonzero((label == own) & (within == around))
            found[asked] = self._answer(name, rows[asked], own, whole[asked], around)
        return found

    def _answer(self, name: str, rows: Numbers, label: int, whole: Floats, within: int) -> Floats:
        reports = name in ("total", "share")
        ranked = self._ranked(reports, label, within)
        group = self._groups(rows, within)
        end = ranked.ends(group)
        known = (end >= 0) & (group >= 0)
        if name == "count":
            return np.where(known, ranked.rank[end] + 1.0, 0.0) if len(ranked.rows) else _none(rows)
        if name == "total":
            return np.where(known, ranked.sums[end], 0.0) if len(ranked.rows) else _none(rows)
        place = self._places(rows, ranked, label, REPORTS if reports else LABELS)
        if name == "rank":
            return np.where(place >= 0, ranked.rank[place], -1.0) if len(ranked.rows) else (
                _none(rows) - 1.0
            )  # fmt: skip
        return _shared(ranked, place, whole)

    def _ranked(self, reports: bool, label: int, within: int) -> Ranked:
        key = (reports, label, within)
        if key not in self._known:
            self._known[key] = self._rank(REPORTS if reports else LABELS, label, within)
        return self._known[key]

    def _rank(self, kinds: tuple[Kind, ...], label: int, within: int) -> Ranked:
        marks = self._marks
        earlier = (marks.phase < self._phase) & (marks.label == label)
        rows = np.flatnonzero(earlier & np.isin(marks.kind, kinds))
        group = self._groups(rows, within)
        order = np.lexsort((marks.key[rows], group))
        rows, group = rows[order], group[order]
        first = np.searchsorted(group, group)
        sums = np.cumsum(marks.value[rows])
        for begin in np.unique(first).tolist():  # a group at a time: its sums are its own alone
            end = int(np.searchsorted(group, group[begin], side="right"))
            sums[begin:end] = np.cumsum(marks.value[rows[begin:end]])
        return Ranked(rows, group, np.arange(len(rows)) - first, sums)

    def _groups(self, rows: Numbers, within: int) -> Numbers:
        """What each row competes in: the nearest row of a label around it, or 0 for all."""
        if within < 0:
            return np.zeros(len(rows), np.int64)
        label = np.full(len(rows), within)
        return self._marks.nearest(rows, LABELS, label)

    def _places(
        self, rows: Numbers, ranked: Ranked, label: int, kinds: tuple[Kind, ...]
    ) -> Numbers:
        """Where the competitor that each row is, or descends from, stands; -1 for none."""
        own = self._marks.nearest(rows, kinds, np.full(len(rows), label))
        if not len(ranked.rows):
            return np.full(len(rows), -1)
        by_row = np.argsort(ranked.rows)
        at = np.minimum(np.searchsorted(ranked.rows, own, sorter=by_row), len(by_row) - 1)
        place = by_row[at]
        return np.where((own >= 0) & (ranked.rows[place] == own), place, -1)


def _none(rows: Numbers) -> Floats:
    return np.zeros(len(rows))


def _shared(ranked: Ranked, place: Numbers, whole: Floats) -> Floats:
    """Parts of whole numbers: the running sums, scaled to the whole and rounded, differ by them."""
    if not len(ranked.rows):
        return _none(place)
    total = ranked.sums[ranked.ends(ranked.group[place])]
    upto = ranked.sums[place]
    before = np.where(ranked.rank[place] > 0, ranked.sums[np.maximum(place - 1, 0)], 0.0)
    whole = np.round(whole)
    scale = np.divide(whole, total, out=np.zeros_like(whole), where=total != 0)
    last = np.where(upto == total, whole, np.round(upto * scale))
    found = last - np.where(before == total, whole, np.round(before * scale))
    return np.where(place >= 0, found, 0.0)
