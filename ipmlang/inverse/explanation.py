"""Why a grammar is as it is: which cluster won in each round of the search, in words.

Takes the journal of a search and the names that the grammar gave to symbols; gives records and
text. Nothing here searches or prints.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass

from ipmlang.compiler import ast
from ipmlang.inverse.lsystem.journal import Journal, Trial
from ipmlang.inverse.lsystem.symbols import Alphabet

SHOWN = 4  # symbols that are told of one place


@dataclass(frozen=True, slots=True)
class Tried:
    """One cluster: kind ("pair", "motif", "sequence", "tree", "lattice"), symbols in each of its
    places, mean length of these, tokens saved (gain), what the weights make of it (multiplier), the
    four terms of equation 5, outcome ("taken", "overlaps", "not exact", "not tried"), its new name.
    """

    kind: str
    symbols: tuple[str, ...]
    places: int
    length: float
    gain: float
    multiplier: float
    near: float
    similar: float
    long: float
    many: float
    outcome: str
    name: str

    def __str__(self) -> str:
        shown = " ".join(self.symbols[:SHOWN]) + (" …" if len(self.symbols) > SHOWN else "")
        length = f"{self.length:.3g} × " if self.kind not in ("pair", "motif") else ""
        places = f"{self.places} place{'s' * (self.places != 1)}"
        weighed = f" × {self.multiplier:.3g}" if self.multiplier != 1 else ""
        terms = ", ".join(f"{name} {getattr(self, name):.2f}" for name in TERMS)
        made = f" -> {self.name}" if self.name else ""
        what = f"{self.kind} {length}{shown} in {places}"
        return f"  {self.outcome:9}  {what}: saves {self.gain:.0f}{weighed} ({terms}){made}"


TERMS = ("near", "similar", "long", "many")


@dataclass(frozen=True, slots=True)
class Told:
    """One round. left: symbols before it; tried: the foremost clusters; more: how many others."""

    left: int
    tried: tuple[Tried, ...]
    more: int
    more_taken: int


@dataclass(frozen=True, slots=True)
class Explanation:
    """What competed. attempts: whole grammars with their tokens, in the order in which they were
    proven; chosen: the first that was right; rounds: of the search behind the rules; notes: what
    was not looked for.
    """

    attempts: tuple[tuple[str, int], ...]
    chosen: str
    rounds: tuple[Told, ...]
    notes: tuple[str, ...] = ()

    def as_records(self) -> list[dict[str, object]]:
        """The rounds, for JSON."""
        return [{"round": number + 1, **asdict(each)} for number, each in enumerate(self.rounds)]

    @property
    def text(self) -> str:
        """For a person to read."""
        lines = []
        for number, each in enumerate(self.rounds):
            lines.append(f"round {number + 1}: {each.left} symbols")
            lines += [str(tried) for tried in each.tried]
            if each.more:
                lines.append(f"  and {each.more} more, {each.more_taken} of them taken")
        tokens = ", ".join(f"{name} {count}" for name, count in self.attempts)
        lines += [f"note: {note}" for note in self.notes]
        return "\n".join([*lines, f"chosen: {self.chosen} (tokens: {tokens})"]) + "\n"


def explain(
    journal: Journal,
    alphabet: Alphabet,
    names: Mapping[int, str],
    attempts: tuple[tuple[str, int], ...],
    chosen: str,
) -> Explanation:
    """The journal in words; names: of the symbols that the grammar still has."""

    def spelled(symbol: int) -> str:
        return _spelled(alphabet, names, symbol)

    rounds = tuple(
        Told(
            each.left,
            tuple(_tried(trial, spelled) for trial in each.trials),
            each.more,
            each.more_taken,
        )
        for each in journal.rounds
    )
    return Explanation(attempts, chosen, rounds, journal.notes)


def printed_names(grammar: ast.Grammar) -> frozenset[str]:
    """What rules and assets of a printed grammar are called."""
    rules = {item.head.name for item in grammar.items if isinstance(item, ast.Rule)}
    assets = {name for item in grammar.items if isinstance(item, ast.Asset) for name in item.names}
    return frozenset(rules | assets)


def _tried(trial: Trial, spelled: Callable[[int], str]) -> Tried:
    return Tried(
        trial.kind,
        tuple(spelled(symbol) for symbol in trial.symbols),
        trial.places,
        round(trial.length, 3),
        trial.gain,
        trial.multiplier,
        trial.terms.near,
        trial.terms.similar,
        trial.terms.long,
        trial.terms.many,
        trial.outcome,
        spelled(trial.symbol) if trial.symbol >= 0 else "",
    )


def _spelled(alphabet: Alphabet, names: Mapping[int, str], symbol: int) -> str:
    """A symbol's name, or, where its rule was written out, what it is made of."""
    if symbol in names:
        return names[symbol]
    definition = alphabet[symbol]
    if definition.terminal:
        return "effect"
    parts = definition.parts.tolist()
    if definition.pattern is not None or definition.branching is not None:
        return f"{len(parts)}·{_spelled(alphabet, names, parts[0])}"
    shown = [_spelled(alphabet, names, part) for part in parts[:SHOWN]]
    return f"({' '.join(shown)}{' …' if len(parts) > SHOWN else ''})"
