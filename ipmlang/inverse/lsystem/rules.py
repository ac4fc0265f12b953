"""The greedy search for rules (sections 5.3 to 5.6 of the paper, one description length for all).

Takes the string of all elements; finds the sequence or the pair of symbols whose rule saves most
tokens, puts a new symbol in place of every occurrence, and goes on until no rule pays. So groups of
groups are found. Every occurrence is compared with the elements it stands for before it is
replaced. Simplifying and printing come later.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.clusters import cluster, members
from ipmlang.inverse.lsystem.frames import (
    Frames,
    compose,
    frames,
    identity,
    inverse,
    join,
    replaced,
    wrap,
)
from ipmlang.inverse.lsystem.motifs import Motif, find_motifs, motif_leads, relative_places
from ipmlang.inverse.lsystem.patterns import Pattern
from ipmlang.inverse.lsystem.sequences import Run, find_runs
from ipmlang.inverse.lsystem.spaces import Pairs, pair_spaces
from ipmlang.inverse.lsystem.symbols import (
    Alphabet,
    Arrangement,
    Integers,
    Seen,
    joined,
    misses,
)
from ipmlang.inverse.score import COUNTED, HEAD, placement_tokens, sequence_tokens

ROUNDS = 400  # a bound that no drawing should reach: each round makes the string shorter
SHARE = 0.5  # a round takes candidates that save at least this share of the best one


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A rule that could be made. gain: tokens it would save if all occurrences were free.

    A pair has rows of its first symbols, their leads and the step; a longer stretch is a `motif`;
    runs of one pattern have `runs`.
    """

    gain: float
    order: int
    rows: Integers
    lead: Frames
    step: Frames | None = None
    runs: tuple[Run, ...] = ()
    motif: Motif | None = None


@dataclass(slots=True, eq=False)
class Search:
    """The state of one search: the alphabet grows, the string gets shorter.

    What a motif is made of is searched on: its first occurrence stands at the end of the string,
    under a `wrap` of its own, so that nothing mixes with it. bodies: the motif and its frame by
    that wrap.
    """

    alphabet: Alphabet
    seen: Seen
    string: Arrangement
    progress: Callable[[str], None] | None = None
    bodies: dict[int, tuple[int, Frames]] = field(default_factory=dict)

    def run(self) -> Arrangement:
        """Replace until nothing pays; the string that is left becomes the axiom."""
        for number in range(ROUNDS):
            if self.progress is not None:
                self.progress(f"round {number + 1}: {len(self.string)} symbols left")
            if not self._round():
                break
        for wrap_number, (symbol, lead) in self.bodies.items():
            rows = np.flatnonzero(self.string.wrap == wrap_number)
            places = compose(inverse(lead), self.string.placed[rows])
            self.alphabet.rewrite(symbol, self.string.symbol[rows], places)
        axiom = self.string[~np.isin(self.string.wrap, list(self.bodies))]
        return replace(axiom, symbol=self.alphabet.sort()[axiom.symbol])

    def _round(self) -> bool:
        pairs, steps, loose = self._labels()
        candidates = self._pairs(pairs, steps) + self._motifs(pairs, loose) + self._sequences()
        if not candidates:
            return False
        best = max(candidate.gain for candidate in candidates)
        chosen = [each for each in candidates if each.gain >= max(1.0, SHARE * best)]
        chosen.sort(key=lambda each: (-each.gain, each.order))
        edit = _Edit(self.string)
        for candidate in chosen:
            self._take(candidate, edit)
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
                self._take(candidate, edit)
        if edit.changed:
            self.string = edit.result()
        return edit.changed

    def _take(self, candidate: Candidate, edit: _Edit) -> None:
        if candidate.runs:
            self._take_runs(candidate, edit)
        elif candidate.motif is not None:
            self._take_motif(candidate.motif, edit)
        else:
            self._take_pair(candidate, edit)

    # ------------------------------------------------------------------ pairs

    def _labels(self) -> tuple[Pairs, Integers, Integers]:
        """The pairs of neighbours, with numbers that are equal for equal steps, and for steps that
        are equal as far as the first symbol's extent lets its direction be known.
        """
        pairs = pair_spaces(self.alphabet, self.string)
        values, slack = pairs.values(self.alphabet, self.string)
        loose = slack * pairs.leverage(self.alphabet, self.string)[:, None]
        return pairs, cluster(pairs.spaces, values, slack), cluster(pairs.spaces, values, loose)

    def _pairs(self, pairs: Pairs, labels: Integers) -> list[Candidate]:
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

    # ----------------------------------------------------------------- motifs

    def _motifs(self, pairs: Pairs, labels: Integers) -> list[Candidate]:
        steps = -1 - np.arange(max(0, len(self.string) - 1))
        steps[pairs.first] = labels
        return [
            Candidate(each.gain, int(each.rows[0]), each.rows, identity(0), motif=each)
            for each in find_motifs(self.string, steps, self.alphabet.tolerance)
        ]

    def _take_motif(self, motif: Motif, edit: _Edit) -> None:
        rows = motif.rows[edit.clear(motif.rows, motif.length)]
        if len(rows) < 2 or 2 * len(rows) < len(motif.rows):
            return
        motif = replace(motif, rows=rows)
        first = int(rows[0])
        inside = slice(first, first + motif.length)
        places = relative_places(self.string.placed, first, motif.length)
        symbol = self.alphabet.add_group(self.string.symbol[inside], places)

        def missed(lead: Frames, at: Integers) -> NDArray[np.float64]:
            return misses(self.alphabet, self.seen, symbol, lead, self.string.start[at])

        lead, error = motif_leads(self.alphabet, self.string, motif, missed)
        good = np.flatnonzero(error <= self.alphabet.tolerance)
        if len(good) * motif.gain < 0.5 * motif.gain * len(rows) or len(good) < 2:
            return
        edit.replace(rows[good], np.full(len(good), motif.length), symbol, lead[good])
        wrap_number = int(self.string.wrap.max(initial=0)) + 1 + len(edit.bodies)
        self.bodies[wrap_number] = (symbol, self.string.placed[first : first + 1])
        body = self.string[np.arange(first, first + motif.length)]
        edit.bodies.append(replace(body, wrap=np.full(motif.length, wrap_number, np.int64)))

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
        known: dict[tuple[object, ...], int] = {}
        kinds = [known.setdefault(self._kind(run.pattern), len(known)) for run in runs]
        values = np.array([run.pattern.numbers for run in runs])
        scale = np.concatenate([run.lead.scale for run in runs])
        count = np.array([run.count for run in runs])
        reach = np.array([self.alphabet[int(each)].radius for each in symbol])
        room = self.alphabet.tolerance / (scale * count)
        arm = np.maximum(np.maximum(reach, np.abs(values[:, 1])), self.alphabet.tolerance)
        turn, factor = np.rad2deg(room / arm), room / arm
        # The order of (x, y, angle, scale), (α, d, s, β) and (turn, radius, change, growth).
        sizes = {
            "even": (room, room, turn, factor),
            "turtle": (turn, room, factor, turn),
            "listed": (turn, room, room, room),
            "polar": (turn, room, room, factor),
        }
        kind = np.array([run.pattern.kind for run in runs])
        slack = np.zeros((len(runs), 4))
        for name, columns in sizes.items():
            slack[kind == name] = np.stack(columns, axis=1)[kind == name]
        further = np.where((kind == "polar")[:, None], count[:, None] * slack, slack)
        labels = symbol * (len(known) + 1) + np.array(kinds, np.int64)
        inside = np.stack([np.rad2deg(self.alphabet.tolerance / arm), room, room], axis=1)
        columns = [slack, further / count[:, None], inside]
        return cluster(labels, values, np.concatenate(columns, axis=1))

    def _kind(self, pattern: Pattern) -> tuple[object, ...]:
        """Equal for patterns that may be one: those of one kind, or with one list of steps."""
        grid = 4 * self.alphabet.tolerance
        return (*pattern.label, tuple(round(step / grid) for step in pattern.steps))

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
        self.bodies: list[Arrangement] = []
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
        """The string after all replacements, new bodies at its end."""
        changed = self.string.placed
        rows = np.concatenate([each for each, _ in self._new])
        changed = replaced(changed, rows, join([lead for _, lead in self._new]))
        string = Arrangement(self.symbol, changed, self.string.start, self.string.wrap)
        return joined([string[self.keep], *self.bodies])


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
    mean = np.mean([each.numbers for each in patterns], axis=0).tolist()
    return replace(
        patterns[0],
        base=(mean[0], mean[1], mean[2], mean[3]),
        delta=(mean[4], mean[5], mean[6], mean[7]),
        rest=mean[8],
        inner=complex(mean[9], mean[10]),
    )
