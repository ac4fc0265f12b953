"""Splits shared out by hand: recursive, one part after the other, plain numbers.

Written from what splits mean, not from how the engine lowers them: sizes that are fixed come first,
repeats take the number of copies that fits best, one factor stretches what floats.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

TINY = 1e-9


@dataclass(frozen=True)
class Part:
    kind: str
    size: float
    source: object = field(default=None, compare=False)


@dataclass(frozen=True)
class Group:
    parts: Sequence[Part | Group]
    mode: str


Parts = Sequence["Part | Group"]
Piece = tuple[Part, tuple[int, ...], float, float]  # the copies it is of, where, and how long


def text_of(parts: Parts) -> str:
    """The parts as a grammar writes them."""
    marks = {"absolute": "", "floating": "~", "relative": "'"}
    return " | ".join(
        f"{marks[each.kind]}{each.size!r}: B"
        if isinstance(each, Part)
        else f"{{ {text_of(each.parts)} }}{each.mode}"
        for each in parts
    )


def widths(parts: Parts, length: float) -> list[tuple[float, float]]:
    """Where each piece begins and how long it is."""
    return [(low, size) for _, _, low, size in pieces(parts, length)]


def pieces(parts: Parts, length: float) -> list[Piece]:
    """The pieces that are there, one after the other."""
    found: list[Piece] = []
    _share(parts, 0.0, length, length, (), found)
    return [each for each in found if each[3] > TINY * length]


def _share(
    parts: Parts,
    begin: float,
    length: float,
    whole: float,
    copies_around: tuple[int, ...],
    found: list[Piece],
) -> None:
    singles = [each for each in parts if isinstance(each, Part)]
    groups = [each for each in parts if isinstance(each, Group)]
    taken = sum(_nominal(each, whole) for each in singles)
    room = length - taken if length - taken > TINY * max(length, taken) else 0.0
    periods = {id(each): _nominal(each, whole) for each in groups}
    copies = {
        id(each): _copies(each, room * periods[id(each)] / (sum(periods.values()) or 1.0), whole)
        for each in groups
    }
    fixed = sum(_fixed(each, whole) * copies.get(id(each), 1) for each in parts)
    floats = sum((_nominal(each, whole) - _fixed(each, whole)) * copies.get(id(each), 1)
                 for each in parts)  # fmt: skip
    factor = max(length - fixed, 0.0) / floats if floats > 0 else 0.0
    at = 0.0
    for each in parts:
        own = _fixed(each, whole)
        size = own + factor * (_nominal(each, whole) - own)
        if isinstance(each, Part):
            size = min(size, length - at)
            found.append((each, copies_around, begin + at, size))
            at += size
            continue
        left = length - at
        for number in range(copies[id(each)]):
            low = number * size
            span = min(size, left - low)  # only what is fixed can need more than there is
            around = (*copies_around, number)
            _share(each.parts, begin + at + low, span, whole, around, found)
        at += min(copies[id(each)] * size, left)


def _nominal(each: Part | Group, whole: float) -> float:
    if isinstance(each, Group):
        return sum(_nominal(part, whole) for part in each.parts)
    return each.size * (whole if each.kind == "relative" else 1.0)


def _fixed(each: Part | Group, whole: float) -> float:
    if isinstance(each, Group):
        return sum(_fixed(part, whole) for part in each.parts)
    return 0.0 if each.kind == "floating" else _nominal(each, whole)


def _floats(each: Part | Group) -> bool:
    if isinstance(each, Group):
        return any(_floats(part) for part in each.parts)
    return each.kind == "floating"


def _copies(group: Group, room: float, whole: float) -> int:
    period = _nominal(group, whole)
    if room <= 0 or period <= 0:
        return 0
    if not _floats(group):
        ratio = room / period
        near = round(ratio)
        if abs(ratio - near) < 1e-9 * max(ratio, 1):
            return near
        return int(ratio) + (group.mode == "+")
    best = 1
    for count in range(1, int(room / period) + 3):
        if abs(room / count - period) < abs(room / best - period) - 1e-12:
            best = count
    return best
