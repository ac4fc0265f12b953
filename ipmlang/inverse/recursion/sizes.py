"""Which recursions a number of segments allows: arithmetic before any geometry.

A symbol X with q copies of itself and g other pieces in its body, where a piece grows p-fold each
step, has x(k) = q x(k-1) + g p^(k-1) segments; a drawing has a axiom symbols and c axiom pieces.
All solutions of x for a given total come out, the small bodies first, if the copies make up half of
what a symbol draws: else nothing would prove them. Nothing here looks at points.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

FEWEST_STEPS = 3
MOST_STEPS = 16
MOST_COPIES = 32
MOST_PIECES = 40
MOST_AXIOM = 8
MOST_AXIOM_PIECES = 4
FASTEST_GROWTH = 6


@dataclass(frozen=True, slots=True)
class Sizes:
    """One solution. drawn: X itself is drawn when no step is left (x(0) = 1, else 0)."""

    axiom_copies: int
    axiom_pieces: int
    copies: int
    pieces: int
    growth: int
    drawn: bool
    steps: int

    def count(self, steps: int) -> int:
        """Segments that X draws with so many steps left."""
        total = int(self.drawn)
        for step in range(steps):
            total = self.copies * total + self.pieces * self.growth**step
        return total

    def piece(self, steps: int) -> int:
        """Segments of one piece with so many steps left."""
        return int(self.growth**steps)

    @property
    def longest_piece(self) -> int:
        """Segments of the longest piece that is drawn, which is straight."""
        if self.axiom_pieces:
            return self.piece(self.steps)
        return self.piece(self.steps - 1) if self.pieces else 1

    @property
    def weight(self) -> int:
        """Symbols that have to be written."""
        return self.axiom_copies + self.axiom_pieces + self.copies + self.pieces


def solutions(total: int, straight: int) -> list[Sizes]:
    """All of them, the shortest to write first, then the ones with more steps. straight: segments
    of the longest straight run in the drawing.
    """
    found = [
        sizes
        for growth in range(1, FASTEST_GROWTH + 1)
        for drawn in (False, True)
        for copies in range(2, MOST_COPIES + 1)
        for sizes in _of_body(total, growth, drawn, copies)
        if sizes.longest_piece <= straight
    ]
    return sorted(found, key=lambda each: (each.weight, -each.steps, each.growth, each.copies))


def _of_body(total: int, growth: int, drawn: bool, copies: int) -> Iterator[Sizes]:
    pieces_sum, powers = 0, 1
    for steps in range(1, MOST_STEPS + 1):
        pieces_sum, powers = copies * pieces_sum + growth ** (steps - 1), powers * copies
        if powers * drawn > total or pieces_sum > total * MOST_PIECES or growth**steps > total:
            return
        if steps < FEWEST_STEPS:
            continue
        for axiom_copies in range(1, MOST_AXIOM + 1):
            for axiom_pieces in range(MOST_AXIOM_PIECES + 1):
                rest = total - axiom_pieces * growth**steps
                if rest <= 0 or rest % axiom_copies:
                    continue
                left = rest // axiom_copies - powers * drawn
                if left < 0 or left % pieces_sum:
                    continue
                pieces = left // pieces_sum
                if pieces <= MOST_PIECES and (pieces > 0 or (drawn and growth == 1)):
                    found = Sizes(axiom_copies, axiom_pieces, copies, pieces, growth, drawn, steps)
                    if 2 * copies * found.count(steps - 1) >= found.count(steps):
                        yield found
