"""The greedy search for rules (sections 5.3 to 5.6 of the paper, one description length for all).

Takes the string of all elements; finds the sequence or the pair of symbols whose rule saves most
tokens, puts a new symbol in place of every occurrence, and goes on until no rule pays. So groups of
groups are found. Every occurrence is compared with the elements it stands for before it is
replaced. Simplifying and printing come later.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.clusters import cluster, members
from ipmlang.inverse.lsystem.frames import Frames, frames, join, replaced, wrap
from ipmlang.inverse.lsystem.patterns import Pattern
from ipmlang.inverse.lsystem.sequences import Run, find_runs
from ipmlang.inverse.lsystem.spaces import Pairs, pair_spaces
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers, Seen, misses
from ipmlang.inverse.score import COUNTED, HEAD, placement_tokens, sequence_tokens

ROUNDS = 400  # a bound that no drawing should reach: each round makes the string shorter
SHARE = 0.5  # a round takes candidates that save at least this share of the best one


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A rule that could be made. gain: tokens it would save if all occurrences were free.

    A pair has rows of its first symbols, their leads and the step; runs of one pattern have `runs`.
    """

    gain: float
    order: int
    rows: Integers
    lead: Frames
    step: Frames | None = None
    runs: tuple[Run, ...] = ()


@dataclass(slots=True, eq=False)
class Search:
    """The state of one search: the alphabet grows, the string gets shorter."""

    alphabet: Alphabet
    seen: Seen
    string: Arrangement
    progress: Callable[[str], None] | None = None

    def run(self) -> Arrangement:
        """Replace until nothing pays; the string that is left becomes the axiom."""
        for number in range(ROUNDS):
            if self.progress is not None:
                self.progress(f"round {number + 1}: {len(self.string)} symbols left")
            if not self._round():
                break
        return self.string

    def _round(self) -> bool:
        candidates = self._pairs() + self._sequences()
        if not candidates:
            return False
        best = max(candidate.gain for candidate in candidates)
        chosen = [each for each in candidates if each.gain >= max(1.0, SHARE * best)]
        chosen.sort(key=lambda each: (-each.gain, each.order))
        edit = _Edit(self.string)
        for candidate in chosen:
            if candidate.runs:
                self._take_runs(candidate, edit)
            else:
                self._take_pair(candidate, edit)
        if not edit.changed:
            return self._retry(candidates, chosen)
        self.string = edit.result()
        return True

    def _retry(self, candidates: list[Candidate], tried: list[Candidate]) -> bool:
        """The best ones all failed their comparison: try the others before giving up."""
        failed = {id(each) for each in tried}
        edit = _Edit(self.string)
        for candidate in sorted(candidates, key=lambda each: (-each.gain, each.order)):
            if id(candidate) not in failed and candidate.gain >= 1.0:
                if candidate.runs:
                    self._take_runs(candidate, edit)
                else:
                    self._take_pair(candidate, edit)
        if edit.changed:
            self.string = edit.result()
        return edit.changed

    # ------------------------------------------------------------------ pairs

    def _pairs(self) -> list[Candidate]:
        pairs = pair_spaces(self.alphabet, self.string)
        if not len(pairs.first):
            return []
        values, slack = pairs.values(self.alphabet, self.string)
        labels = cluster(pairs.spaces, values, slack)
        cost = placement_tokens(self.string.placed, self.alphabet.tolerance)
        found = []
        for rows in members(labels, 2):
            rows = _apart(pairs.first, rows)
            if len(rows) < 2:
                continue
            step = _middle(pairs, rows)
            first = pairs.first[rows]
            saved = cost[first] + cost[first + 1]
            left = placement_tokens(pairs.lead[rows], self.alphabet.tolerance)
            rule = HEAD + 1 + int(placement_tokens(step, self.alphabet.tolerance)[0])
            gain = float((saved - left).sum() - rule)
            if gain >= 1.0:
                found.append(Candidate(gain, int(first[0]), first, pairs.lead[rows], step))
        return found

    def _take_pair(self, candidate: Candidate, edit: _Edit) -> None:
        assert candidate.step is not None
        clear = edit.clear(candidate.rows, 2)
        rows, lead = candidate.rows[clear], candidate.lead[clear]
        if len(rows) < 2 or candidate.gain * len(rows) < 0.5 * candidate.gain * len(clear):
            return
        parts = self.string.symbol[[int(rows[0]), int(rows[0]) + 1]]
        places = join([frames(np.zeros(1, np.complex128)), candidate.step])
        symbol = self.alphabet.add_group(parts, places)
        good = self._exact(symbol, lead, self.string.start[rows])
        if good.sum() < 2:
            return
        edit.replace(rows[good], np.full(int(good.sum()), 2), symbol, lead[good])

    def _exact(self, symbol: int, lead: Frames, start: Integers) -> NDArray[np.bool_]:
        worst = misses(self.alphabet, self.seen, symbol, lead, start)
        return np.asarray(worst <= self.alphabet.tolerance)

    # -------------------------------------------------------------- sequences

    def _sequences(self) -> list[Candidate]:
        runs = find_runs(self.alphabet, self.string)
        if not runs:
            return []
        labels = self._run_clusters(runs)
        cost = placement_tokens(self.string.placed, self.alphabet.tolerance)
        total = np.concatenate([[0], np.cumsum(cost)])
        found = []
        for rows in members(labels, 1):
            same = [runs[row] for row in rows.tolist()]
            counted = COUNTED if len({run.count for run in same}) > 1 else 0
            saved = sum(int(total[run.first + run.count] - total[run.first]) for run in same)
            left = int(
                placement_tokens(join([run.lead for run in same]), self.alphabet.tolerance).sum()
            )
            rule = HEAD + counted + sequence_tokens(same[0].pattern)
            gain = float(saved - left - counted * len(same) - rule)
            if gain >= 1.0:
                firsts = np.array([run.first for run in same], np.int64)
                lead = join([run.lead for run in same])
                found.append(Candidate(gain, int(firsts[0]), firsts, lead, None, tuple(same)))
        return found

    def _run_clusters(self, runs: list[Run]) -> Integers:
        """Runs of one symbol with equal patterns are one cluster."""
        symbol = self.string.symbol[[run.first for run in runs]]
        lists: dict[tuple[float, ...], int] = {}
        kinds = [self._kind(run.pattern, lists) for run in runs]
        values = np.array([(*run.pattern.base, *run.pattern.delta) for run in runs])
        scale = np.concatenate([run.lead.scale for run in runs])
        count = np.array([run.count for run in runs])
        reach = np.array([self.alphabet[int(each)].radius for each in symbol])
        room = self.alphabet.tolerance / (scale * count)
        arm = np.maximum(np.maximum(reach, np.abs(values[:, 1])), self.alphabet.tolerance)
        turn = np.rad2deg(room / arm)
        even = np.array([run.pattern.kind == "even" for run in runs])
        slack = np.stack([np.where(even, room, turn), room, np.where(even, turn, room / arm),
                          np.where(even, room / arm, turn)], axis=1)  # fmt: skip
        labels = symbol * (8 * len(runs) + 8) + np.array(kinds, np.int64)
        return cluster(labels, values, np.concatenate([slack, slack / count[:, None]], axis=1))

    def _kind(self, pattern: Pattern, lists: dict[tuple[float, ...], int]) -> int:
        """Equal for patterns that may be one: those of one kind, or with one list of steps."""
        if pattern.kind == "listed":
            grid = 4 * self.alphabet.tolerance
            key = tuple(round(step / grid) for step in pattern.steps)
            return 8 * lists.setdefault(key, len(lists) + 1)
        return 2 * (pattern.kind == "turtle") + pattern.mirrored + 4 * pattern.constant

    def _take_runs(self, candidate: Candidate, edit: _Edit) -> None:
        family = -1
        pattern = _shared_pattern([run.pattern for run in candidate.runs])
        known: dict[int, int] = {}
        for run in candidate.runs:
            part = int(self.string.symbol[run.first])
            if not edit.clear(np.array([run.first]), run.count)[0]:
                continue
            if run.count not in known:
                symbol = self.alphabet.add_sequence(part, run.count, pattern, family)
                family = symbol if family < 0 else family
                known[run.count] = symbol
            symbol = known[run.count]
            start = self.string.start[[run.first]]
            if self._exact(symbol, run.lead, start)[0]:
                edit.replace(np.array([run.first]), np.array([run.count]), symbol, run.lead)


class _Edit:
    """Replacements in one string that do not overlap."""

    def __init__(self, string: Arrangement) -> None:
        self.string = string
        self.used = np.zeros(len(string) + 1, np.bool_)
        self.keep = np.ones(len(string), np.bool_)
        self.symbol = string.symbol.copy()
        self.changed = False
        self._new: list[tuple[Integers, Frames]] = []

    def clear(self, rows: Integers, count: int) -> NDArray[np.bool_]:
        """(k,) whether none of the `count` rows from each on is used yet."""
        free = np.ones(len(rows), np.bool_)
        if count > 2:
            return np.array([not self.used[row : row + count].any() for row in rows.tolist()])
        for offset in range(count):
            free &= ~self.used[rows + offset]
        return free

    def replace(self, rows: Integers, counts: Integers, symbol: int, lead: Frames) -> None:
        """Put one symbol in place of `counts` neighbours from each of `rows` on."""
        for row, count in zip(rows.tolist(), counts.tolist(), strict=True):
            self.used[row : row + count] = True
            self.keep[row + 1 : row + count] = False
        self.symbol[rows] = symbol
        self._new.append((rows, lead))
        self.changed = True

    def result(self) -> Arrangement:
        """The string after all replacements."""
        changed = self.string.placed
        rows = np.concatenate([each for each, _ in self._new])
        changed = replaced(changed, rows, join([lead for _, lead in self._new]))
        string = Arrangement(self.symbol, changed, self.string.start, self.string.wrap)
        return string[self.keep]


def _apart(first: Integers, rows: Integers) -> Integers:
    """Without rows whose pair overlaps the one taken before it, from left to right."""
    at = first[rows]
    if len(at) < 2 or not (np.diff(at) == 1).any():
        return rows
    new = np.concatenate([[True], np.diff(at) != 1])
    since = np.arange(len(at)) - np.maximum.accumulate(np.where(new, np.arange(len(at)), 0))
    return np.asarray(rows[since % 2 == 0])


def _middle(pairs: Pairs, rows: Integers) -> Frames:
    """The mean of equal steps."""
    step = pairs.step[rows]
    angle = step.angle[:1] + np.mean(wrap(step.angle - step.angle[0]))
    return frames(
        np.array([step.position.mean()]), angle, float(step.scale.mean()), step.handedness[:1]
    )


def _shared_pattern(patterns: list[Pattern]) -> Pattern:
    """The mean of equal patterns."""
    base = np.mean([each.base for each in patterns], axis=0).tolist()
    delta = np.mean([each.delta for each in patterns], axis=0).tolist()
    first = patterns[0]
    return Pattern(
        first.kind,
        (base[0], base[1], base[2], base[3]),
        (delta[0], delta[1], delta[2], delta[3]),
        first.mirrored,
        first.steps,
    )
