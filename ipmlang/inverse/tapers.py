"""Rows whose counts change evenly from one to the next: a pediment, a triangle of stones.

Takes a body of a book; says which stretches of it are sequences of one family, placed evenly, with
counts that are linear in the index, and makes sequences of the one or two members at the thin end.
Nothing here prints.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import Frames, compose, join, wrap
from ipmlang.inverse.lsystem.symbols import Alphabet
from ipmlang.inverse.simplify import AXIOM, Body, Book

LEAST = 4  # rows that are shorter as a repeat than written out


@dataclass(frozen=True, slots=True, eq=False)
class Taper:
    """`rows` sequences: row k has `count + slope * k` members and stands at `first + step * k`, for
    (x, y, angle, scale).
    """

    rows: int
    count: int
    slope: int
    first: NDArray[np.float64]
    step: NDArray[np.float64]
    handedness: int

    def at(self, row: int) -> Frames:
        """(1,) the frame of a row, further ones and those before the first too."""
        x, y, angle, scale = (self.first + self.step * row)[:, None]
        return Frames(x, y, angle, scale, np.array([self.handedness], np.int8))


def taper_at(book: Book, body: Body, start: int, near: float, least: int = LEAST) -> Taper | None:
    """The longest taper that begins with a member of a body; near: units, what rows may be off."""
    if int(body.parts[start]) not in book.family:
        return None
    parts = body.parts[start:].tolist()
    end = _even_counts(book, parts)
    if end < least:
        return None
    places, index = body.places[start : start + end], np.arange(end, dtype=np.float64)
    angle = places.angle[0] + np.cumsum(wrap(np.diff(places.angle, prepend=places.angle[:1])))
    columns = np.stack([places.x, places.y, angle, places.scale], axis=1)
    bent = np.abs(np.diff(columns, 2, axis=0)) > np.array([near, near, 1e-6, 1e-7])
    bent |= (places.handedness[2:] != places.handedness[0])[:, None]
    bad = np.flatnonzero(bent.any(axis=1))
    end = int(bad[0]) + 2 if len(bad) else end
    if end < least:
        return None
    powers = np.stack([np.ones(end), index[:end]], axis=1)
    first, step = np.linalg.lstsq(powers, columns[:end], rcond=None)[0]
    count, then = (book.count[part] for part in parts[:2])
    return Taper(end, count, then - count, first, step, int(places.handedness[0]))


def _even_counts(book: Book, parts: list[int]) -> int:
    """How many of the first parts are sequences of one family with counts that change evenly."""
    family = book.family.get(parts[0])
    end = 0
    while end < len(parts) and family is not None and book.family.get(parts[end]) == family:
        counts = [book.count[part] for part in parts[max(0, end - 2) : end + 1]]
        if end and (counts[-1] == counts[-2] or len(set(np.diff(counts).tolist())) > 1):
            break
        end += 1
    return end


# ------------------------------------------------------------------------ thin ends


def complete_tapers(book: Book, alphabet: Alphabet) -> None:
    """Make sequences of what stands where a taper would go on: two members, then one."""
    for rule in list(book.bodies):
        start = 0
        while start < len(book.bodies[rule].parts):
            found = taper_at(book, book.bodies[rule], start, alphabet.tolerance, least=3)
            start = start + 1 if found is None else _completed(book, alphabet, rule, start, found)


def _completed(book: Book, alphabet: Alphabet, rule: int, start: int, taper: Taper) -> int:
    """Complete one taper at its thin end; where the body goes on after it."""
    family = book.family[int(book.bodies[rule].parts[start])]
    growing = taper.slope > 0
    at, row = (start, -1) if growing else (start + taper.rows, taper.rows)
    while (count := taper.count + taper.slope * row) > 0:
        body, lead = book.bodies[rule], taper.at(row)
        first = at - count if growing else at
        if not _stands_there(book, alphabet, family, body, first, count, lead):
            break
        if rule == AXIOM and not _painted_together(book, family, first, count):
            break
        _put(book, rule, first, count, _sequence(book, alphabet, family, count), lead)
        at, row = (first, row - 1) if growing else (first + 1, row + 1)
    return at + taper.rows - 1 - row if growing else at


def _stands_there(
    book: Book, alphabet: Alphabet, family: int, body: Body, first: int, count: int, lead: Frames
) -> bool:
    """Whether the members from `first` on are what a row of a family would be at `lead`."""
    loop, rows = book.loops[family], slice(max(0, first), first + count)
    if first < 0 or (body.parts[rows] != loop.part).any() or len(body.parts[rows]) < count:
        return False
    wanted = compose(lead, loop.pattern.places(count))
    return bool(alphabet.alike(loop.part, body.places[rows], wanted).all())


def _painted_together(book: Book, family: int, first: int, count: int) -> bool:
    """Whether nothing of a lattice is painted between members that stand in the axiom."""
    steps = np.diff(book.ranks[first : first + count])
    return bool((steps == book.extent[book.loops[family].part]).all())


def _sequence(book: Book, alphabet: Alphabet, family: int, count: int) -> int:
    """The symbol of a sequence with so many members, a new one where there is none."""
    for symbol, known in book.count.items():
        if known == count and book.family[symbol] == family:
            return symbol
    loop = book.loops[family]
    symbol = alphabet.add_sequence(loop.part, count, loop.pattern, family)
    book.family[symbol], book.count[symbol] = family, count
    book.size = np.append(book.size, alphabet[symbol].drawn)
    book.extent = np.append(book.extent, alphabet[symbol].size)
    return symbol


def _put(book: Book, rule: int, first: int, count: int, symbol: int, lead: Frames) -> None:
    """Write one symbol in place of some members of a body."""
    body, after = book.bodies[rule], first + count
    parts = [*body.parts[:first].tolist(), symbol, *body.parts[after:].tolist()]
    places = join([body.places[:first], lead, body.places[after:]])
    book.bodies[rule] = Body(np.array(parts, np.int64), places)
    if rule == AXIOM:
        book.ranks = np.delete(book.ranks, np.arange(first + 1, after))
