"""The text of `start … choices "…"`: which productions were drawn, in few letters.

In go the decisions of each symbol, out comes one line, and the other way about. A decision is the
number of the production taken, counting those of the symbol that have a percentage or a weight, in
the order of the file; one more than the last number means that none of them was. The order of
decisions is generation by generation, and from left to right in the string within one. Numbers are
coded against the frequencies seen so far (adaptive arithmetic coding, 6 bits a letter), so that 3
alternatives at random cost 1.6 bits, and rare ones less. Nothing here derives.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

from ipmlang.compiler.diagnostics import IpmError, fail

LETTERS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz-_"
VALUES = {letter: value for value, letter in enumerate(LETTERS)}
BITS = 6  # of a letter
WHOLE = 1 << 36  # the width of the coder's interval at the start
LEAST = 1 << 30  # below this width the next letter is known
SEEN = 1 << 16  # counts are halved when they add up to this


@dataclass(frozen=True, slots=True)
class Decisions:
    """What one symbol's modules took. `alternatives`: how many productions of it have a chance."""

    symbol: str
    alternatives: int
    taken: Sequence[int]


@dataclass(frozen=True, slots=True)
class Coded:
    """The same as letters: how many decisions there are, and their code."""

    symbol: str
    count: int
    code: str


def encode(decisions: Iterable[Decisions]) -> str:
    """The text of all decisions: `Leaf:6:Iw Side:2:`, symbols that never draw left out.

    >>> encode([Decisions("Leaf", 2, (0, 2, 1, 0, 0, 0)), Decisions("Side", 1, (0, 0))])
    'Leaf:6:Iw Side:2:'
    """
    return " ".join(
        f"{each.symbol}:{len(each.taken)}:{_encoded(each.taken, each.alternatives + 1)}"
        for each in decisions
        if len(each.taken)
    )


def read(text: str) -> list[Coded]:
    """The parts of a text, their codes not yet decoded. Raises IpmError for one that is none."""
    found = [_part(word) for word in text.split()]
    names = [each.symbol for each in found]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise fail("bad-choices", f"`choices` has decisions of `{twice}` twice")
    return found


class Lazy:
    """The decisions of a part, decoded as far as they are asked for: a hostile count costs nothing.

    >>> part = Lazy(Coded("Leaf", 6, "Iw"), 2)
    >>> part.take(4), part.take(9)
    ([0, 2, 1, 0], [0, 0])
    """

    def __init__(self, coded: Coded, alternatives: int) -> None:
        self.symbol = coded.symbol
        self._coded = coded
        self._numbers = alternatives + 1
        letters = [VALUES[letter] for letter in coded.code]
        self._waiting = _decoded(letters, coded.count, self._numbers)
        self._taken: list[int] = []

    def take(self, count: int) -> list[int]:
        """The next decisions, fewer where the text ends."""
        found = list(islice(self._waiting, count))
        self._taken += found
        return found

    def short(self) -> IpmError:
        """The error of a text that ended too early."""
        return fail(
            "bad-choices",
            f"the choices of `{self.symbol}` end after {self._coded.count:,} decisions, and the "
            "derivation asks for more",
            hint="the grammar was changed since they were written: run it with --seed",
        )

    def finish(self) -> None:
        """Nothing may be left, and the letters must be those of what was taken."""
        taken, count, code = self._taken, self._coded.count, self._coded.code
        if len(taken) < count:
            raise fail(
                "bad-choices",
                f"the choices of `{self.symbol}` are {count:,} decisions, and the derivation asks "
                f"for {len(taken):,}",
                hint="the grammar was changed since they were written: run it with --seed",
            )
        if _encoded(taken, self._numbers) != code:
            raise fail(
                "bad-choices",
                f"the choices of `{self.symbol}` are damaged: {len(code):,} letters that do not "
                f"spell {count:,} decisions among {self._numbers - 1} productions with a chance",
                hint="were letters lost, or productions added or taken away?",
            )


def _part(word: str) -> Coded:
    symbol, _, rest = word.partition(":")
    number, colon, code = rest.partition(":")
    if not symbol or not colon or not (number.isascii() and number.isdigit()):
        shown = word if len(word) <= 40 else f"{word[:40]}…"
        raise fail(
            "bad-choices",
            f"`choices` cannot be read at `{shown}`",
            hint="each part is a symbol, how often it draws, and letters: `Leaf:6:Iw`",
        )
    wrong = next((letter for letter in code if letter not in VALUES), None)
    if wrong is not None:
        raise fail("bad-choices", f"the choices of `{symbol}` have a letter `{wrong}`",
                   hint=f"the letters are {LETTERS}")  # fmt: skip
    return Coded(symbol, int(number), code)


class _Frequencies:
    """How often each number was seen; every one starts at half."""

    def __init__(self, numbers: int) -> None:
        self._counts = [1] * numbers
        self.total = numbers

    def span(self, number: int) -> tuple[int, int]:
        """What is below a number, and its own share."""
        return sum(self._counts[:number]), self._counts[number]

    def at(self, target: int) -> int:
        """The number whose share holds a place below `total`."""
        for number, count in enumerate(self._counts):
            target -= count
            if target < 0:
                return number
        return len(self._counts) - 1

    def note(self, number: int) -> None:
        """One more of a number."""
        self._counts[number] += 2
        self.total += 2
        if self.total > SEEN:
            self._counts = [(count + 1) // 2 for count in self._counts]
            self.total = sum(self._counts)


def _encoded(taken: Sequence[int], numbers: int) -> str:
    low, width = 0, WHOLE
    letters: list[int] = []
    seen = _Frequencies(numbers)
    for number in taken:
        below, own = seen.span(number)
        step = width // seen.total
        low, width = low + step * below, step * own
        seen.note(number)
        if low >= WHOLE:
            low -= WHOLE
            _carry(letters)
        while width < LEAST:
            letters.append(low >> 30)
            low = (low & (LEAST - 1)) << BITS
            width <<= BITS
    _finish(letters, low, width)
    return "".join(LETTERS[value] for value in letters).rstrip(LETTERS[0])


def _carry(letters: list[int]) -> None:
    place = len(letters) - 1
    while letters[place] == len(LETTERS) - 1:
        letters[place] = 0
        place -= 1
    letters[place] += 1


def _finish(letters: list[int], low: int, width: int) -> None:
    """Append the fewest letters that lie within the interval, whatever zeros follow."""
    for count in range(BITS + 1):
        unit = WHOLE >> (BITS * count)
        value = -(-low // unit) * unit
        if value < low + width:
            break
    if value >= WHOLE:
        value -= WHOLE
        _carry(letters)
    letters += [value >> (30 - BITS * place) & (len(LETTERS) - 1) for place in range(count)]


def _decoded(letters: Sequence[int], count: int, numbers: int) -> Iterator[int]:
    place, width = 0, WHOLE
    for value in (*letters, *[0] * BITS)[:BITS]:
        place = place << BITS | value
    waiting = iter(letters[BITS:])
    seen = _Frequencies(numbers)
    for _ in range(count):
        step = width // seen.total
        number = seen.at(min(place // step, seen.total - 1))
        below, own = seen.span(number)
        place, width = place - step * below, step * own
        seen.note(number)
        yield number
        while width < LEAST:
            place = place << BITS | next(waiting, 0)
            width <<= BITS
