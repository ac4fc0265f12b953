"""What is told about one inference: how much was found, how exact it is, what it took.

Numbers and sentences only; nothing here measures or prints.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field


@dataclass(frozen=True, slots=True)
class RuleError:
    """How far what a rule draws is off, at most: a share of the diagonal; elements drawn by it."""

    rule: str
    error: float
    elements: int


@dataclass(frozen=True, slots=True)
class Report:
    """method: what was used; elements: how many were read; explained: share of them that stands
    under a rule that repeats or is used twice; rules: besides the axiom; rules_twice: of these,
    how many draw twice or more; max_error: share of the drawing's diagonal; tokens: of the grammar,
    a table's cells included; tokens_flat: of one placement per element; bytes; seconds of CPU time;
    notes: what was carried through or left out; mode: "exact", "within" a tolerance that was asked
    for, or "ideal", where one shape stands for similar ones; limit: share of the diagonal that was
    proven; rule_errors: where that is not exact, of each rule, worst first.
    """

    method: str
    elements: int
    explained: float
    rules: int
    rules_twice: int
    max_error: float
    tokens: int
    tokens_flat: int
    source_bytes: int
    grammar_bytes: int
    parts_bytes: int
    seconds: float
    notes: tuple[str, ...] = field(default=())
    mode: str = "exact"
    limit: float = 1e-6
    rule_errors: tuple[RuleError, ...] = field(default=())

    def as_record(self) -> dict[str, object]:
        """All of it, for JSON."""
        return asdict(self)

    def summary(self) -> str:
        """One line for a person."""
        rules = "no rules" if not self.rules else f"{self.rules} rule{'s' * (self.rules > 1)}"
        return (
            f"{self.elements} elements, {self.explained:.0%} explained by {rules}; "
            f"{self.tokens} tokens instead of {self.tokens_flat}; largest error "
            f"{self.max_error:.1e} of the diagonal; {self.seconds:.2g} s"
        )
