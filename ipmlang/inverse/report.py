"""What is told about one inference: how much was found, how exact it is, what it took.

Numbers and sentences only; nothing here measures or prints.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field


@dataclass(frozen=True, slots=True)
class Report:
    """method: what was used; elements: how many were read; explained: share of them that stands
    under a rule that repeats or is used twice; rules: besides the axiom; rules_twice: of these,
    how many draw twice or more; max_error: share of the drawing's diagonal; tokens: of the grammar,
    a table's cells included; tokens_flat: of one placement per element; bytes; seconds of CPU time;
    notes: what was carried through or left out.
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
