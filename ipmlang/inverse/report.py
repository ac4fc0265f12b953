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
    """method: what was used; elements: how many were read, the components of a model; explained:
    share of them that stands under a rule that repeats or is used twice; rules: besides the axiom;
    rules_twice: of these, how many draw twice or more; max_error: share of the drawing's diagonal;
    tokens: of the grammar, a table's cells included; tokens_flat: of one placement per element,
    with two for each point of the outlines that rules draw and a parts file would hold; bytes;
    seconds of CPU time; notes: what was carried through or left out; mode: "exact", "within" a
    tolerance that was asked for, or "ideal", where one shape stands for similar ones; limit: share
    of the diagonal that was proven; rule_errors: where that is not exact, of each rule, worst
    first.

    Of models besides: labels: shapes that differ by more than a rigid motion; repeated: elements
    that share theirs; explained_repeated: share of these that `explained` counts; terminals: shapes
    in the parts file; triangles: as counted in the file.
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
    labels: int = 0
    repeated: int = 0
    explained_repeated: float = 0.0
    terminals: int = 0
    triangles: int = 0

    @property
    def ratio(self) -> float:
        """How many times longer one placement per element is."""
        return self.tokens_flat / max(1, self.tokens)

    def as_record(self) -> dict[str, object]:
        """All of it, for JSON."""
        return {**asdict(self), "ratio": round(self.ratio, 3)}

    def summary(self) -> str:
        """One line for a person."""
        rules = "no rules" if not self.rules else f"{self.rules} rule{'s' * (self.rules > 1)}"
        read = f"{self.elements} elements"
        if self.triangles:
            read = f"{counted(self.elements, 'component')} of {counted(self.labels, 'shape')}"
        return (
            f"{read}, {self.explained:.0%} explained by {rules}; "
            f"{self.tokens} tokens instead of {self.tokens_flat}; largest error "
            f"{self.max_error:.1e} of the diagonal; {self.seconds:.2g} s"
        )


def counted(count: int, thing: str) -> str:
    """`1 shape`, `4 shapes`."""
    return f"{count} {thing}{'s' * (count != 1)}"
