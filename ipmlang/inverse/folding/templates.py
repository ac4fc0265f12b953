"""One rule with parameters for stretches of rows that differ in numbers, or in symbols, too.

Takes several stretches of rows of the same forms; finds the frame of each in which they differ
least, which numbers vary, and which of these follow another one; gives the rule's rows with
expressions, and the arguments of each stretch. Nothing here searches.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ast
from ipmlang.inverse.folding.fits import MOST, READ, Fit, Rounding, fits
from ipmlang.inverse.folding.least import least_tokens
from ipmlang.inverse.folding.parameters import Parameters, Said, parameters
from ipmlang.inverse.folding.rows import LABELS, Row, element, moved, with_numbers
from ipmlang.inverse.folding.symbols import LABEL, MARK, Given, given_symbols, with_marks
from ipmlang.inverse.lsystem.frames import Frames

Floats = NDArray[np.float64]
TURNED = frozenset({"angle", "scale"})  # labels of numbers that no error of distances holds for


@dataclass(frozen=True, eq=False)
class Template:
    """A rule with parameters. rows, said: what it says, a Said for every number of the rows;
    labels: a word for each parameter; calls: (k, p) the arguments of each stretch; places: (k,)
    where each stands; given: the parameters that are symbols, which come first; tokens: of the
    rule, its head included.
    """

    rows: tuple[Row, ...]
    said: tuple[Said, ...]
    labels: tuple[str, ...]
    calls: Floats
    places: Frames
    given: Given
    tokens: int

    @property
    def words(self) -> tuple[str, ...]:
        """A word for each parameter, symbols first."""
        return (*(LABEL for _ in range(self.given.count)), *self.labels)

    def body(self, names: Sequence[str], leaving: Set[str]) -> tuple[ast.Element, ...]:
        """What the rule says with these names of parameters."""
        count = self.given.count
        values = iter([each.expr(names[count:]) for each in self.said])
        rows = with_marks(self.rows, {f"{MARK}{k}": name for k, name in enumerate(names[:count])})
        return tuple(element(row, [next(values) for _ in row.numbers], leaving) for row in rows)

    def call_rows(self, name: str) -> list[Row]:
        """The row that stands for each stretch."""
        still = [
            Row(name=name, args=tuple(each), symbols=symbols)
            for each, symbols in zip(self.calls.tolist(), self.given.names, strict=True)
        ]
        return list(moved(still, self.places))


def rounding(error: float) -> Rounding:
    """For drawings whose numbers may be off by an error, units."""
    return Rounding(2 * error, max(0, int(np.ceil(-np.log10(error / 100)))))


def best_template(
    stretches: Sequence[Sequence[Row]],
    given: Rounding,
    needed: int,
    bound: Set[str] = frozenset(),
) -> tuple[Template, int] | None:
    """The template that saves most tokens, and how many, for stretches of rows of the same forms;
    None where none saves those needed.

    What could stand anywhere is placed by those who call it, not by its parameters; bound: symbols
    that cannot be parameters.
    """
    written = sum(row.tokens for each in stretches for row in each)
    if written - least_tokens(stretches, given) < needed:
        return None
    symbols = given_symbols(stretches, bound)
    if symbols is None:
        return None
    few = MOST - symbols.count
    if symbols.count:  # what draws hardly more than it is told is no easier to read
        few = min(few, symbols.things - symbols.count)
    if few < 0:
        return None
    table = np.array([[value for row in each for value in row.numbers] for each in stretches])
    tried = fits(symbols, table, given, written - needed)
    best: tuple[Fit, Parameters, Floats, int] | None = None
    first = 0
    for fit in sorted(tried, key=lambda each: each.least):
        # Of frames that save the same, it is the one of the first row.
        room = written - fit.least - needed - (best is not None and fit.order > first)
        if room < 0:
            continue
        found = parameters(fit.table, fit.errors, fit.varying, fit.means(few, room))
        if found is None:
            continue
        calls = fit.table[:, found.used] * found.signs + 0.0
        own = fit.rule_tokens(found)
        saved = written - own - fit.call_tokens(calls) - READ * (symbols.count + len(found.used))
        if saved - (best is not None and fit.order > first) >= needed:
            best, needed, first = (fit, found, calls, own), saved, fit.order
    return None if best is None else (_template(*best), needed)


def _template(fit: Fit, found: Parameters, calls: Floats, tokens: int) -> Template:
    """The rule with these parameters, and the arguments (k, p) of each stretch."""
    rows = with_numbers(fit.own_rows(), fit.table[0].tolist())
    words = [word for row in rows for word in labels_of(row)]
    labels = tuple(words[column] for column in found.used)
    return Template(rows, found.said, labels, calls, fit.places, fit.symbols, tokens)


def labels_of(row: Row) -> list[str]:
    """A word for each number of a row."""
    inner = [word for each in row.inner for word in labels_of(each)]
    return [*LABELS, *("n" for _ in row.args), *inner]
