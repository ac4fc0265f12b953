"""What happened in a search: which clusters were weighed in each round, and what became of them.

Takes candidates as they are tried; keeps the foremost of each round with their terms. Symbols are
numbers; whoever prints a journal knows their names. Nothing here decides.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

from ipmlang.inverse.lsystem.importance import Terms
from ipmlang.inverse.lsystem.symbols import Integers

Outcome: TypeAlias = Literal["taken", "overlaps", "not exact", "not tried"]
KEPT = 6  # clusters of a round that are told one by one


@dataclass(frozen=True, slots=True)
class Trial:
    """One cluster in one round. symbols: what stands in one place; places: how many there are;
    length: the mean number of symbols in a place; gain: tokens that its rule saves, at most;
    multiplier: what the weights make of that; symbol: the new one, -1 where it was not taken.
    """

    kind: str
    symbols: tuple[int, ...]
    places: int
    length: float
    gain: float
    multiplier: float
    terms: Terms
    outcome: Outcome
    symbol: int = -1


@dataclass(frozen=True, slots=True)
class Round:
    """left: symbols in the string before it; trials: the foremost, in order; more: how many other
    clusters there were, and how many of these were taken.
    """

    left: int
    trials: tuple[Trial, ...]
    more: int
    more_taken: int


@dataclass(slots=True)
class Journal:
    """The rounds of one search, in order; notes: what was not looked for, in words."""

    rounds: list[Round] = field(default_factory=list)
    notes: tuple[str, ...] = ()

    def note(self, text: str) -> None:
        """Say once what was not looked for."""
        self.notes = (*(each for each in self.notes if each != text), text)

    def add(self, left: int, trials: list[Trial]) -> None:
        """Note a round; trials by what they are worth."""
        rest = trials[KEPT:]
        taken = sum(each.outcome == "taken" for each in rest)
        self.rounds.append(Round(left, tuple(trials[:KEPT]), len(rest), taken))

    def renumber(self, number: Integers) -> None:
        """Give symbols their new numbers; number: (n,) of each old one."""

        def renamed(trial: Trial) -> Trial:
            symbols = tuple(int(number[each]) for each in trial.symbols)
            new = int(number[trial.symbol]) if trial.symbol >= 0 else -1
            return replace(trial, symbols=symbols, symbol=new)

        self.rounds = [
            replace(each, trials=tuple(renamed(trial) for trial in each.trials))
            for each in self.rounds
        ]
