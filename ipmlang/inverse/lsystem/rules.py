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

from ipmlang.inverse.lsystem.candidates import Candidate
from ipmlang.inverse.lsystem.clusters import cluster, members
from ipmlang.inverse.lsystem.edits import Edit
from ipmlang.inverse.lsystem.fits import Fits
from ipmlang.inverse.lsystem.frames import (
    Frames,
    compose,
    frames,
    identity,
    inverse,
    join,
)
from ipmlang.inverse.lsystem.importance import Measure
from ipmlang.inverse.lsystem.journal import Journal, Outcome
from ipmlang.inverse.lsystem.motifs import Motif, find_motifs, motif_leads, relative_places
from ipmlang.inverse.lsystem.neighbours import pair_candidates
from ipmlang.inverse.lsystem.patterns import Pattern
from ipmlang.inverse.lsystem.sequences import Run, find_runs
from ipmlang.inverse.lsystem.spaces import Pairs, Steps, pair_spaces
from ipmlang.inverse.lsystem.symbols import (
    Alphabet,
    Arrangement,
    Integers,
    Seen,
    misses,
)
from ipmlang.inverse.lsystem.trees import Tree, TreeSearch
from ipmlang.inverse.options import Options
from ipmlang.inverse.score import (
    COUNTED,
    HEAD,
    LOOP,
    TREE,
    Tabled,
    placement_tokens,
    sequence_tokens,
    tabled,
    tree_tokens,
)

NESTED = 4  # tokens saved where a row of rows is written as one rule
ROUNDS = 400  # a bound that no drawing should reach: each round makes the string shorter
MANY = 1e6  # tokens that no rule saves: a gain over this only decides between equal ones
SHARE = 0.5  # a round takes candidates that save at least this share of the best one


@dataclass(slots=True, eq=False)
class Search:
    """The state of one search: the alphabet grows, the string gets shorter.

    What a motif is made of is searched on: its first occurrence stands at the end of the string,
    under a `wrap` of its own, so that nothing mixes with it. bodies: the motif and its frame by
    that wrap. measure: of the terms that options ask for; journal: what was tried.
    """

    alphabet: Alphabet
    seen: Seen
    string: Arrangement
    progress: Callable[[str], None] | None = None
    bodies: dict[int, tuple[int, Frames]] = field(default_factory=dict)
    options: Options = field(default_factory=Options)
    measure: Measure | None = None
    journal: Journal = field(default_factory=Journal)
    trees: TreeSearch = field(default_factory=TreeSearch)
    fits: Fits = field(default_factory=Fits)
    steps: Steps = field(default_factory=Steps)

    def run(self) -> Arrangement:
        """Replace until nothing pays; the string that is left becomes the axiom."""
        for number in range(ROUNDS):
            if self.progress is not None:
                self.progress(f"round {number + 1}: {len(self.string)} symbols left")
            if not self._round() and not (self.options.paper and self._pair_up()):
                break
        for wrap_number, (symbol, lead) in self.bodies.items():
            rows = np.flatnonzero(self.string.wrap == wrap_number)
            places = compose(inverse(lead), self.string.placed[rows])
            self.alphabet.rewrite(symbol, self.string.symbol[rows], places)
        axiom = self.string[~np.isin(self.string.wrap, list(self.bodies))]
        numbers = self.alphabet.sort()
        self.journal.renumber(numbers)
        return replace(axiom, symbol=numbers[axiom.symbol])

    def _round(self) -> bool:
        pairs, steps, loose = self._labels()
        # What a table could hold is cheap: a few pairs in it by chance are not worth a rule.
        cost = self._tabled()
        found = pair_candidates(pairs, steps, cost, self.alphabet.tolerance, 1.0)
        least = SHARE * max((each.gain for each in found), default=0.0)
        if self.measure is None and least > 1.0:
            # What saves less would not be taken yet, and later it may be gone.
            chosen, _ = _ranked(found + self._larger(pairs, loose, cost, least))
            if self._try(chosen, []):
                return True
            chosen, others = _ranked(found + self._larger(pairs, loose, cost, 1.0))
            return self._try(others, [])
        weighed = self._weighed(found + self._larger(pairs, loose, cost, 1.0))
        chosen, others = _ranked(weighed)
        # Where the best ones all fail their comparison, the others are tried before giving up.
        return self._try(chosen, weighed) or self._try(others, [])

    def _larger(self, pairs: Pairs, loose: Integers, cost: Tabled, least: float) -> list[Candidate]:
        """Motifs, sequences and trees, all of them that save so much."""
        found = self._motifs(pairs, loose, cost, least) + self._sequences(cost, least)
        return found + self._trees(cost, least)

    def _weighed(self, candidates: list[Candidate]) -> list[Candidate]:
        """With their terms, where somebody asks for these."""
        weights = self.options.weights
        if self.measure is None or (weights.neutral and not self.options.explain):
            return candidates
        clusters = [each.cluster() for each in candidates]
        terms = self.measure.terms(self.alphabet, self.string, clusters)
        return [
            replace(each, terms=known, multiplier=known.multiplier(weights))
            for each, known in zip(candidates, terms, strict=True)
        ]

    def _try(self, chosen: list[Candidate], weighed: list[Candidate]) -> bool:
        """Take what can be taken, in this order; all that was weighed is noted."""
        edit = Edit(self.string)
        outcomes = {id(each): self._take(each, edit) for each in chosen}
        if self.options.explain and (chosen or weighed):
            self._note(weighed or chosen, outcomes)
        if edit.changed:
            self.string = edit.result()
        return edit.changed

    def _note(self, weighed: list[Candidate], outcomes: dict[int, tuple[Outcome, int]]) -> None:
        trials = [
            each.trial(self.string, each.terms, *outcomes.get(id(each), ("not tried", -1)))
            for each in weighed
            if each.terms is not None
        ]
        self.journal.add(len(self.string), trials)

    def note_lattices(self, after: Arrangement) -> None:
        """Note the lattices that another string has in place of members of this one."""
        rules = {each: self.alphabet[each].lattice for each in after.symbol.tolist()}
        made = {each: rule for each, rule in rules.items() if rule is not None}
        known = set(self.string.symbol.tolist())
        if not self.options.explain or self.measure is None:
            return
        cost = placement_tokens(self.string.placed, self.alphabet.tolerance)
        trials = []
        for symbol, rule in made.items():
            if symbol in known:
                continue
            gain = float(cost[rule.rows].sum() - LOOP - 2 * len(rule.holes))
            candidate = Candidate(gain, int(rule.rows.min()), rule.rows, rule.formula.lead)
            terms = self.measure.terms(self.alphabet, self.string, [candidate.cluster()])
            trials.append(candidate.trial(self.string, terms[0], "taken", symbol))
        if trials:
            self.journal.add(len(self.string), trials)

    def _pair_up(self) -> bool:
        """Join neighbours for which no rule pays, the most important first: the paper goes on until
        one symbol is left (Figure 8b). Equation 5 alone ranks them.
        """
        assert self.measure is not None
        pairs, steps, _ = self._labels()
        cost, small = self._tabled(), self.alphabet.tolerance
        candidates = pair_candidates(pairs, steps, cost, small, -np.inf) + self._lone_pairs()
        clusters = [each.cluster() for each in candidates]
        terms = self.measure.terms(self.alphabet, self.string, clusters)
        weights = self.options.weights
        ranked = [
            (-known.importance(weights), each.order, replace(each, terms=known))
            for each, known in zip(candidates, terms, strict=True)
        ]
        ranked.sort(key=lambda each: each[:2])
        chosen = [each for _, _, each in ranked]
        return self._try(chosen, chosen)

    def _take(self, candidate: Candidate, edit: Edit) -> tuple[Outcome, int]:
        """What became of a candidate, and its new symbol."""
        if candidate.runs:
            outcome = self._take_runs(candidate, edit)
        elif candidate.tree is not None:
            outcome = self._take_tree(candidate.tree, edit)
        elif candidate.motif is not None:
            outcome = self._take_motif(candidate.motif, edit)
        else:
            outcome = self._take_pair(candidate, edit)
        return outcome, len(self.alphabet) - 1 if outcome == "taken" else -1

    # ------------------------------------------------------------------ pairs

    def _labels(self) -> tuple[Pairs, Integers, Integers]:
        """The pairs of neighbours, with numbers that are equal for equal steps, and for steps that
        are equal as far as the first symbol's extent lets its direction be known.
        """
        pairs = pair_spaces(self.alphabet, self.string, self.steps)
        values, slack = pairs.values(self.alphabet, self.string)
        loose = slack * pairs.leverage(self.alphabet, self.string)[:, None]
        return pairs, cluster(pairs.spaces, values, slack), cluster(pairs.spaces, values, loose)

    def _tabled(self) -> Tabled:
        """What the string takes if no more rules are made: a table holds one symbol and hand."""
        string = self.string
        kinds = (string.symbol, string.wrap, string.placed.handedness)
        other = np.any([np.diff(each) != 0 for each in kinds], axis=0)
        return tabled(string.placed, other, self.alphabet.tolerance)

    def _lone_pairs(self) -> list[Candidate]:
        """Every two neighbours, whatever their step."""
        first = np.flatnonzero(self.string.wrap[1:] == self.string.wrap[:-1])
        cost = placement_tokens(self.string.placed, self.alphabet.tolerance)
        lead = self.string.placed[first]
        step = compose(inverse(lead), self.string.placed[first + 1])
        rule = HEAD + 1 + placement_tokens(step, self.alphabet.tolerance)
        gain = cost[first + 1] - rule
        return [
            Candidate(float(gain[k]), row, first[k : k + 1], lead[k : k + 1], step[k : k + 1])
            for k, row in enumerate(first.tolist())
        ]

    def _take_pair(self, candidate: Candidate, edit: Edit) -> Outcome:
        assert candidate.step is not None
        clear = edit.clear(candidate.rows, 2)
        rows, lead = candidate.rows[clear], candidate.lead[clear]
        least = min(2, len(candidate.rows))
        if len(rows) < least or 2 * len(rows) < len(clear):
            return "overlaps"
        parts = self.string.symbol[[int(rows[0]), int(rows[0]) + 1]]
        places = join([frames(np.zeros(1, np.complex128)), candidate.step])
        symbol = self.alphabet.add_group(parts, places)
        good = self._exact(symbol, lead, self.string.start[rows])
        if good.sum() < least:
            return "not exact"
        edit.replace(rows[good], np.full(int(good.sum()), 2), symbol, lead[good])
        return "taken"

    # ----------------------------------------------------------------- motifs

    def _motifs(
        self, pairs: Pairs, labels: Integers, cost: Tabled, least: float
    ) -> list[Candidate]:
        steps = -1 - np.arange(max(0, len(self.string) - 1))
        steps[pairs.first] = labels
        return [
            Candidate(each.gain, int(each.rows[0]), each.rows, identity(0), motif=each)
            for each in find_motifs(self.string, steps, cost, self.alphabet.tolerance, least)
        ]

    def _take_motif(self, motif: Motif, edit: Edit) -> Outcome:
        rows = motif.rows[edit.clear(motif.rows, motif.length)]
        if len(rows) < 2 or 2 * len(rows) < len(motif.rows):
            return "overlaps"
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
            return "not exact"
        edit.replace(rows[good], np.full(len(good), motif.length), symbol, lead[good])
        wrap_number = int(self.string.wrap.max(initial=0)) + 1 + len(edit.bodies)
        self.bodies[wrap_number] = (symbol, self.string.placed[first : first + 1])
        body = self.string[np.arange(first, first + motif.length)]
        edit.bodies.append(replace(body, wrap=np.full(motif.length, wrap_number, np.int64)))
        return "taken"

    def _exact(self, symbol: int, lead: Frames, start: Integers) -> NDArray[np.bool_]:
        worst = misses(self.alphabet, self.seen, symbol, lead, start)
        return np.asarray(worst <= self.alphabet.tolerance)

    # ------------------------------------------------------------------ trees

    def _trees(self, cost: Tabled, least: float) -> list[Candidate]:
        found = []
        for tree in self.trees.find(self.alphabet, self.string, cost.alone, least + TREE):
            rows = np.arange(tree.first, tree.first + tree.count)
            left = int(placement_tokens(tree.lead, self.alphabet.tolerance)[0])
            gain = float(cost.alone[rows].sum() - left - tree_tokens(tree.branching))
            if gain >= 1.0:
                found.append(Candidate(gain, tree.first, rows[:1], tree.lead, tree=tree))
        return found

    def _take_tree(self, tree: Tree, edit: Edit) -> Outcome:
        rows = np.array([tree.first])
        if not edit.clear(rows, tree.count)[0]:
            return "overlaps"
        part = int(self.string.symbol[tree.first])
        symbol = self.alphabet.add_tree(part, tree.branching)
        if not self._exact(symbol, tree.lead, self.string.start[rows])[0]:
            return "not exact"
        edit.replace(rows, np.array([tree.count]), symbol, tree.lead)
        return "taken"

    # -------------------------------------------------------------- sequences

    def _sequences(self, cost: Tabled, least: float) -> list[Candidate]:
        runs = find_runs(self.alphabet, self.string, self.fits, np.diff(cost.total), least)
        if not runs:
            return []
        labels = self._run_clusters(runs)
        found = []
        for rows in members(labels, 1):
            same = [runs[row] for row in rows.tolist()]
            counted = COUNTED if len({run.count for run in same}) > 1 else 0
            lead = join([run.lead for run in same])
            firsts = np.array([run.first for run in same], np.int64)
            counts = np.array([run.count for run in same], np.int64)
            saved = float((cost.total[firsts + counts] - cost.total[firsts]).sum())
            left = int(placement_tokens(lead, self.alphabet.tolerance).sum())
            rule = HEAD + counted + sequence_tokens(same[0].pattern)
            if self.alphabet[int(self.string.symbol[same[0].first])].pattern is not None:
                rule -= NESTED
            gain = float(saved - left - counted * len(same) - rule)
            if gain >= 1.0:
                # A row says more than rows of a table: where it is no shorter, it comes last.
                spared = saved - cost.saved(firsts, counts)
                gain = max(1.0 + gain / MANY, gain - spared)
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
        reach = self.alphabet.radii[symbol]
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
        rooms = [slack, further / count[:, None], inside]
        return cluster(labels, values, np.concatenate(rooms, axis=1))

    def _kind(self, pattern: Pattern) -> tuple[object, ...]:
        """Equal for patterns that may be one: those of one kind, or with one list of steps."""
        grid = 4 * self.alphabet.tolerance
        return (*pattern.label, tuple(round(step / grid) for step in pattern.steps))

    def _take_runs(self, candidate: Candidate, edit: Edit) -> Outcome:
        free = [run for run in candidate.runs if edit.clear(np.array([run.first]), run.count)[0]]
        # Where others took most, what is left is weighed again in the next round.
        if 2 * sum(run.count for run in free) < sum(run.count for run in candidate.runs):
            return "overlaps"
        family = -1
        outcome: Outcome = "overlaps"
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
                outcome = "taken"
            elif outcome == "overlaps":
                outcome = "not exact"
        return outcome


def _ranked(candidates: list[Candidate]) -> tuple[list[Candidate], list[Candidate]]:
    """Those that pay, best first: what a round takes, and all others."""
    candidates.sort(key=lambda each: (-each.worth, each.order))
    paying = [each for each in candidates if each.gain >= 1.0]
    chosen = [each for each in paying if each.worth >= SHARE * candidates[0].worth]
    return chosen, paying[len(chosen) :]


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
