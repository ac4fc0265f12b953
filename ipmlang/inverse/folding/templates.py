"""One rule with parameters for stretches of rows that differ in numbers, or in symbols, too.

Takes several stretches of rows of the same forms; finds the frame of each in which they differ
least, which numbers vary, and which of these follow another one; gives the rule's rows with
expressions, and the arguments of each stretch. Nothing here searches.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ast
from ipmlang.inverse.folding.pivots import about_points
from ipmlang.inverse.folding.rows import (
    LABELS,
    Row,
    Words,
    element,
    moved,
    row_tokens,
    with_numbers,
)
from ipmlang.inverse.folding.symbols import LABEL, MARK, Given, given_symbols, with_marks
from ipmlang.inverse.lsystem.frames import Frames, compose, frames, identity, inverse
from ipmlang.inverse.numbers import linear, shortest

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
HEAD = 2  # `Name -->`
READ = 2  # tokens that a parameter must save for whoever has to find out what it does
FINE = 1e-9  # degrees or ratio: numbers that are equal
TURNED = frozenset({"angle", "scale"})  # labels of numbers that no error of distances holds for
PLACES = 12  # decimals of angles and factors; those of distances follow the error
PLAIN = 3  # decimals that the slope of a number that follows another one may have
SURE = 3  # stretches from which a slope other than 1 is believed
ANCHORS = 4  # rows that are tried as the place where a stretch stands
MOST = 4  # parameters that a person can tell apart
LEADERS = 2  # numbers that follow each other of which one becomes the parameter


@dataclass(frozen=True, slots=True)
class Said:
    """How a number of a rule is written: first + slope * parameter, -1 for none."""

    first: float
    parameter: int = -1
    slope: float = 0.0

    def expr(self, names: Sequence[str]) -> ast.Expr:
        """As an expression of the parameters so called."""
        if self.parameter < 0:
            return ast.Number(self.first)
        return linear(self.first, self.slope, names[self.parameter], (0.0, 0.0))

    @property
    def words(self) -> Words:
        """What the expression takes, and the number that it is, if it is one."""
        if self.parameter < 0:
            return 1 + (self.first < 0), self.first
        product = 1 if abs(self.slope) == 1 else 3
        if self.first == 0:
            return product + (self.slope < 0), None
        return 2 + (self.first < 0) + product, None


@dataclass(frozen=True, eq=False)
class Template:
    """A rule with parameters. rows, said: what it says, a Said for every number of the rows;
    labels: a word for each parameter; calls: (k, p) the arguments of each stretch; places: (k,)
    where each stands; given: the parameters that are symbols, which come first.
    """

    rows: tuple[Row, ...]
    said: tuple[Said, ...]
    labels: tuple[str, ...]
    calls: Floats
    places: Frames
    given: Given

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

    @cached_property
    def tokens(self) -> int:
        """Of the rule, its head included."""
        words = iter([each.words for each in self.said])
        own = sum(row_tokens(row, words) for row in self.rows)
        return HEAD + (2 + len(self.words) if self.words else 0) + own

    def call_rows(self, name: str) -> list[Row]:
        """The row that stands for each stretch."""
        still = [
            Row(name=name, args=tuple(each), symbols=symbols)
            for each, symbols in zip(self.calls.tolist(), self.given.names, strict=True)
        ]
        return list(moved(still, self.places))


@dataclass(frozen=True, slots=True)
class Rounding:
    """error: units that two distances may be apart and still be one; places: decimals that a sum
    of distances has.
    """

    error: float
    places: int


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
    symbols = given_symbols(stretches, bound)
    if symbols is None:
        return None
    written = sum(row.tokens for each in stretches for row in each)
    # The rule says each row at least once, and each call its name.
    most = written - sum(row.least for row in stretches[0]) - len(stretches) - HEAD
    if most < needed:
        return None
    table = np.array([[value for row in each for value in row.numbers] for each in stretches])
    few = _parameters_for(most - needed, table) - symbols.count
    if symbols.count:  # what draws hardly more than it is told is no easier to read
        few = min(few, symbols.things - symbols.count)
    if few < 0:
        return None
    best: tuple[Template, int] | None = None
    for places in _anchors(stretches[0], table, given):
        made = _fitted(symbols, table, places, given, few)
        if made is None:
            continue
        saved = written - made.tokens - sum(row.tokens for row in made.call_rows("T"))
        saved -= READ * len(made.words)
        if saved >= needed:
            best, needed = (made, saved), saved + 1
    return best


def _parameters_for(room: int, table: Floats) -> int:
    """How many parameters so many tokens pay for at most: each is named in the rule's head and an
    argument of each call (k of the table), with brackets around all of them.
    """
    calls = len(table)
    return max(0, min(MOST, (room - 2 * (calls + 1)) // (calls + 1 + READ)))


def _anchors(rows: Sequence[Row], table: Floats, given: Rounding) -> Iterator[Frames]:
    """(k,) frames in which the stretches could be equal: those of one of their rows, of rows that
    keep their places to each other the first; as they are where something cannot be moved.
    """
    if not all(row.placed for row in rows):
        yield identity(len(table))
        return
    known: set[bytes] = set()
    for column, row in zip(_begins(rows), rows, strict=True):
        x, y, angle, scale = table[:, column : column + 4].T
        turned = np.ptp(angle) > FINE or np.ptp(scale) > FINE
        own = Frames(x, y, angle, scale, np.full(len(x), row.hand, np.int8))
        own = own if turned else frames(own.position)
        steps = np.round(np.concatenate([x - x[0], y - y[0]]), max(0, given.places - 2)) + 0.0
        key = steps.tobytes() + np.round(np.concatenate([angle, scale]), 9).tobytes()
        if key not in known and len(known) < ANCHORS:
            known.add(key)
            yield own


def _begins(rows: Sequence[Row]) -> list[int]:
    """The column of each row's first number."""
    return list(accumulate((len(row.numbers) for row in rows[:-1]), initial=0))


def _fitted(
    symbols: Given, table: Floats, places: Frames, given: Rounding, most: int
) -> Template | None:
    """The template whose rows stand in the given frames, None where more than `most`
    numbers would be parameters.
    """
    rows: Sequence[Row] = symbols.rows
    begins = np.array(_begins(rows))
    hands = np.array([row.hand for row in rows], np.int8)
    x, y, angle, scale = (table[:, begins + k] for k in range(4))
    stand = Frames(x, y, angle, scale, np.tile(hands, (len(table), 1)))
    local = compose(inverse(places)[:, None], stand)
    table = table.copy()
    for k, column in enumerate((local.x, local.y, local.angle, local.scale)):
        table[:, begins + k] = np.round(column, given.places if k < 2 else PLACES) + 0.0
    rows = [
        row if row.hand == hand else replace(row, hand=hand)
        for row, hand in zip(rows, local.handedness[0].tolist(), strict=True)
    ]
    rows, table = about_points(rows, table, begins.tolist(), given.error)
    words = [word for row in rows for word in labels_of(row)]
    errors = np.array([FINE if word in TURNED else given.error for word in words])
    found = _parameters(table, errors, most)
    if found is None:
        return None
    said, used, signs = found
    calls = table[:, used] * signs + 0.0
    own = with_numbers(rows, table[0].tolist())
    return Template(own, tuple(said), tuple(words[c] for c in used), calls, places, symbols)


def labels_of(row: Row) -> list[str]:
    """A word for each number of a row."""
    inner = [word for each in row.inner for word in labels_of(each)]
    return [*LABELS, *("n" for _ in row.args), *inner]


# ------------------------------------------------------------------------ parameters


def _parameters(
    table: Floats, errors: Floats, most: int
) -> tuple[list[Said], list[int], Floats] | None:
    """How each column (k, h) is said; the columns that are parameters, and the sign of each; None
    where there would be more than `most` parameters.
    """
    said = [Said(value) for value in table[0].tolist()]
    waiting = np.flatnonzero(np.ptp(table, axis=0) > errors)
    close = _collinear(table[:, waiting], errors[waiting])
    if _directions(close) > most:
        return None
    used: list[int] = []
    signs: list[float] = []
    left = np.ones(len(waiting), np.bool_)
    while left.any():
        if len(used) >= most:
            return None
        near = waiting[close[int(np.argmax(left))] & left]
        leaders = near[: LEADERS if len(near) > 1 else 1].tolist()
        groups = [_followers(table, errors, column, near) for column in leaders]
        group = min(groups, key=lambda each: _cost(table, each))
        column = next(iter(group))
        sign = -1.0 if (table[:, column] < 0).sum() * 2 > len(table) else 1.0
        for other, (first, slope) in group.items():
            said[other] = Said(first, len(used), slope * sign)
        used.append(column)
        signs.append(sign)
        left[np.searchsorted(waiting, list(group))] = False
    return said, used, np.array(signs)


def _directions(close: NDArray[np.bool_]) -> int:
    """How many parameters there are at least: columns of which none follows another one."""
    left, count = np.ones(len(close), np.bool_), 0
    while left.any():
        left &= ~close[int(np.argmax(left))]
        count += 1
    return count


def _collinear(table: Floats, errors: Floats) -> NDArray[np.bool_]:
    """(w, w) which columns could be first + slope * another one."""
    if len(table) < SURE:
        apart = np.abs(table[-1] - table[0])
        return np.asarray(np.abs(apart[:, None] - apart) <= errors, np.bool_)
    spread = table - table.mean(axis=0)
    products = spread.T @ spread
    sizes = np.diag(products)
    rest = sizes[None, :] - products**2 / np.maximum(sizes, 1e-300)[:, None]
    near = rest <= len(table) * errors[None, :] ** 2 + 1e-12 * sizes[None, :]
    return np.asarray(near | np.eye(len(sizes), dtype=np.bool_), np.bool_)


def _cost(table: Floats, group: dict[int, tuple[float, float]]) -> int:
    """Tokens by which a column as a parameter, with its followers, is worse than each alone."""
    column = next(iter(group))
    negative = int(min((table[:, column] < 0).sum(), (table[:, column] > 0).sum()))
    said = sum(Said(first, 0, slope).words[0] for first, slope in group.values())
    return said + len(table) + 1 + negative - (len(table) + 2) * len(group)


def _followers(
    table: Floats, errors: Floats, column: int, others: Integers
) -> dict[int, tuple[float, float]]:
    """A column, and those that are first + slope * this one where that is shorter than another
    parameter. Slopes are plain numbers; two stretches tell none but 1 and -1.
    """
    made = {int(column): (0.0, 1.0)}
    if len(others) == 1:
        return made
    values, near = table[:, column], table[:, others]
    spread = values - values.mean()
    slopes = spread @ near / (spread @ spread)
    waiting = np.flatnonzero(others != column)
    for places in range(PLAIN + 1 if len(values) >= SURE else 1):
        if not len(waiting):
            break
        rounded = np.round(slopes[waiting], places)
        rest = near[:, waiting] - values[:, None] * rounded
        room = errors[others[waiting]] - np.ptp(rest, axis=0)
        sound = (room >= 0) & (rounded != 0) & ((len(values) >= SURE) | (np.abs(rounded) == 1))
        own = others[waiting[sound]]
        rooms = np.maximum(room[sound], errors[own] / 8)
        columns = (own, rest[:, sound].mean(axis=0), rooms, rounded[sound])
        for other, mean, off, slope in zip(*(each.tolist() for each in columns), strict=True):
            first = shortest(mean, off)
            if Said(first, 0, slope).words[0] <= len(values) + 2:
                made[other] = (first, slope)
        waiting = waiting[~sound]
    return made
