"""What waits to be derived: chunks of shapes as columns, by symbol and generation.

In go the children that bodies make, out come batches of at most so many shapes: a full chunk of the
deepest generation first, so that little waits. A column that is the same for a whole chunk stays
one number; unchanged columns are passed on, not copied.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime.code import Column
from ipmlang.runtime.keys import Words

CHUNK = 16_384
FINAL = 1 << 40  # the generation of what only its meaning is left of
Key = tuple[int, int]  # symbol, generation


@dataclass(frozen=True, slots=True, eq=False)
class Shapes:
    """`count` shapes of one symbol: their numbers, key words, arguments and states as columns;
    `rule` the production that made them, a number or (count,).
    """

    count: int
    numbers: NDArray[np.int32]
    k0: Words
    k1: Words
    rule: int | NDArray[np.int32]
    params: tuple[Column, ...]
    state: tuple[Column, ...]

    def take(self, rows: NDArray[np.int64] | slice) -> Shapes:
        """Some of the shapes."""
        numbers = self.numbers[rows]
        return Shapes(
            len(numbers),
            numbers,
            self.k0[rows],
            self.k1[rows],
            self.rule if isinstance(self.rule, int) else self.rule[rows],
            tuple(taken(column, rows) for column in self.params),
            tuple(taken(column, rows) for column in self.state),
        )


class Pending:
    """All chunks that wait."""

    def __init__(self) -> None:
        self._chunks: dict[Key, list[Shapes]] = {}
        self._counts: dict[Key, int] = {}
        self.count = 0

    def put(self, symbol: int, generation: int, shapes: Shapes) -> None:
        """Add shapes."""
        if shapes.count:
            key = (symbol, generation)
            self._chunks.setdefault(key, []).append(shapes)
            self._counts[key] = self._counts.get(key, 0) + shapes.count
            self.count += shapes.count

    def has(self, wanted: Callable[[int], bool]) -> bool:
        """Whether shapes of a symbol that is wanted wait."""
        return any(wanted(symbol) for symbol, _ in self._counts)

    def next(self, wanted: Callable[[int], bool] | None = None) -> tuple[Key, Shapes]:
        """The batch to derive next: at most CHUNK shapes; of a symbol that is wanted, if given."""
        waiting = [each for each in self._counts if wanted is None or wanted(each[0])]
        key = max(waiting, key=lambda each: (min(self._counts[each], CHUNK), each[1]))
        chunks = self._chunks[key]
        found: list[Shapes] = []
        room = CHUNK
        while chunks and room:
            chunk = chunks.pop()
            if chunk.count > room:
                chunks.append(chunk.take(slice(room, None)))
                chunk = chunk.take(slice(0, room))
            found.append(chunk)
            room -= chunk.count
        batch = merged(found)
        self._note(key, batch.count)
        return key, batch

    def take(self, wanted: Callable[[int], bool]) -> list[tuple[Key, Shapes]]:
        """All shapes of the symbols that are wanted, which then wait no more."""
        found = []
        for key in sorted(each for each in self._counts if wanted(each[0])):
            self.count -= self._counts.pop(key)
            found.append((key, merged(self._chunks.pop(key))))
        return found

    def level(self) -> list[tuple[Key, Shapes]]:
        """All shapes of the first generation that waits, by symbol."""
        first = min(generation for _, generation in self._counts)
        found = []
        for key in sorted(each for each in self._counts if each[1] == first):
            self.count -= self._counts.pop(key)
            found.append((key, merged(self._chunks.pop(key))))
        return found

    def all(self) -> Iterator[tuple[Key, Shapes]]:
        """Everything that waits, which then waits no more."""
        chunks, self._chunks, self._counts, self.count = self._chunks, {}, {}, 0
        for key in sorted(chunks):
            if chunks[key]:
                yield key, merged(chunks[key])

    def _note(self, key: Key, taken: int) -> None:
        self.count -= taken
        self._counts[key] -= taken
        if not self._counts[key]:
            del self._counts[key], self._chunks[key]


def taken(column: Column, rows: NDArray[np.int64] | slice) -> Column:
    """Some rows of a column; one number for all stays one number."""
    return column[rows] if isinstance(column, np.ndarray) else column


def merged(chunks: Sequence[Shapes]) -> Shapes:
    """Several chunks of one symbol as one."""
    if len(chunks) == 1:
        return chunks[0]
    counts = [chunk.count for chunk in chunks]
    rules = [chunk.rule for chunk in chunks]
    rule: int | NDArray[np.int32]
    if isinstance(rules[0], int) and all(
        isinstance(each, int) and each == rules[0] for each in rules
    ):
        rule = rules[0]
    else:
        pairs = zip(rules, counts, strict=True)
        rule = np.concatenate([np.broadcast_to(np.int32(each), (n,)) for each, n in pairs])
    params = zip(*(chunk.params for chunk in chunks), strict=True)
    state = zip(*(chunk.state for chunk in chunks), strict=True)
    return Shapes(
        sum(counts),
        np.concatenate([chunk.numbers for chunk in chunks]),
        np.concatenate([chunk.k0 for chunk in chunks]),
        np.concatenate([chunk.k1 for chunk in chunks]),
        rule,
        tuple(joined(columns, counts) for columns in params),
        tuple(joined(columns, counts) for columns in state),
    )


def joined(columns: Sequence[Column], counts: Sequence[int]) -> Column:
    """Columns one after the other, one number where all are the same number."""
    first = columns[0]
    if not isinstance(first, np.ndarray) and all(
        not isinstance(each, np.ndarray) and (each == first or (each != each and first != first))
        for each in columns
    ):
        return first
    pairs = zip(columns, counts, strict=True)
    return np.concatenate([_repeated(column, n) for column, n in pairs])


def _repeated(column: Column, count: int) -> NDArray[np.float64]:
    """A column with a row for each of so many shapes."""
    if isinstance(column, np.ndarray) and column.shape == (count,):
        return column
    return np.full(count, column)
