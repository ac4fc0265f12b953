"""Rows that run side by side as one row of pairs: columns with their capitals, floors with walls.

Takes a scheme; gives the same one in which rows, grids and rings of a rule that have the same
members are one of them, of a rule for what stands together, where that is shorter. Patterns are
found symbol by symbol, so that what was never looked at as a group may still be one. What is drawn
does not change.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from ipmlang.inverse.frames import (
    Floats,
    Frames,
    around,
    compose,
    inverse,
    join,
    matrices,
    moved_to,
    spread,
)
from ipmlang.inverse.split.changing import on_symbols
from ipmlang.inverse.split.cost import scheme_tokens
from ipmlang.inverse.split.expansion import expand, placements
from ipmlang.inverse.split.facades.homes import at_home
from ipmlang.inverse.split.facades.matching import matched
from ipmlang.inverse.split.measuring import extents
from ipmlang.inverse.split.scheme import Array, Item, Place, Ring, Rule, Scheme, Symbol

MOST = 40  # schemes that are weighed
CLOSE = 1e-6  # share of a turn, and of what the first row spans, that does not count

Row: TypeAlias = Array | Ring
Key: TypeAlias = tuple[object, ...]


def paired(scheme: Scheme, small: float) -> Scheme:
    """The scheme with rows of pairs where these are shorter; small: units that do not count."""
    best, least = scheme, _length(scheme, small)
    weighed = 0
    while True:
        better = None
        for each in _ways(best, small):
            weighed += 1
            length = _length(each, small)
            if length < least:
                better, least = each, length
                break
            if weighed == MOST:
                break
        if better is None:
            break
        best = better
    if best is scheme or not matched(expand(best), expand(scheme), 5 * small):
        return scheme
    return best


def _length(scheme: Scheme, small: float) -> int:
    return scheme_tokens(at_home(scheme, small)[0], small)


def _ways(scheme: Scheme, small: float) -> Iterator[Scheme]:
    """The scheme with rows of one rule joined, for each rule that has rows with equal members."""
    boxes = extents(scheme)
    for number, rule in enumerate(scheme.symbols):
        if not isinstance(rule, Rule):
            continue
        for rows in _abreast(rule, small):
            whole = rows[0][1]
            first = join([_begun_beside(whole, row, small) for _, row in rows])
            content = [row.symbol for _, row in rows]
            joined = [index for index, _ in rows]
            for other, frame in _known(scheme.symbols[:number], content, first, small):
                yield _with_row(scheme, number, joined, replace(whole, symbol=other, first=frame))
            for frame in _corners(first, boxes[content]):
                made = _rule(content, compose(inverse(frame), first), boxes[content])
                row = replace(whole, symbol=number, first=frame)
                yield _with_row(_with_rule(scheme, number, made), number + 1, joined, row)


def _abreast(rule: Rule, small: float) -> list[list[tuple[int, Row]]]:
    """Rows of a rule with equal members, and which items they are; all of them run one way."""
    groups: dict[Key, list[tuple[int, Row]]] = {}
    for index, item in enumerate(rule.items):
        if isinstance(item, Array | Ring):
            row = _onward(item)
            groups.setdefault(_key(row, 8 * small), []).append((index, row))
    return [rows for rows in groups.values() if len(rows) > 1]


def _onward(row: Row) -> Row:
    """The same row from its other end, if it runs backwards and may as well be said so."""
    if row.holes or (isinstance(row, Array) and any(each.angle for each in row.directions)):
        return row
    if isinstance(row, Ring):
        if row.angle >= 0 or row.grows:
            return row
        last = placements(row)[0][1][-1:]
        return replace(row, first=last, angle=-row.angle, rise=-row.rise)
    directions, shift = [], np.zeros(3)
    for each in row.directions:
        lead = each.step[np.flatnonzero(np.abs(each.step) > CLOSE * np.abs(each.step).max())[:1]]
        if (lead < 0).any() and not each.steps:
            shift = shift + (each.count - 1) * each.step
            each = replace(each, step=-each.step)
        directions.append(each)
    return replace(row, directions=tuple(directions), first=compose(moved_to(shift), row.first))


def _key(row: Row, gap: float) -> Key:
    """What is the same for rows whose members stand to each other in the same way."""
    if isinstance(row, Array):
        steps = [
            (each.count, _rounded(each.step, gap), _rounded(each.steps, CLOSE), each.angle)
            for each in row.directions
        ]
        return (tuple(steps), row.holes)
    numbers = (row.angle, row.growth, row.gain)
    about = _rounded(row.center - row.axis * float(row.center @ row.axis), gap)
    rise = _rounded([row.rise], gap)
    return (row.count, about, _rounded([*row.axis, *numbers], CLOSE), rise, row.holes)


def _rounded(values: Floats | Sequence[float], gap: float) -> tuple[int, ...]:
    return tuple(np.round(np.asarray(values, np.float64) / gap).astype(np.int64).tolist())


def _begun_beside(whole: Row, row: Row, small: float) -> Frames:
    """The first frame of a row; of a ring that closes, the member that is nearest to the first of
    another.
    """
    if not isinstance(row, Ring) or row.holes or row.grows or abs(row.rise) > small:
        return row.first
    if abs(row.count * row.angle - 360.0) > CLOSE:
        return row.first
    members = placements(row)[0][1]
    away = np.linalg.norm(members.position - whole.first.position, axis=1)
    nearest = int(np.argmin(np.round(away / (8 * small))))
    return members[nearest : nearest + 1]


def _known(
    symbols: Sequence[Symbol], content: list[int], first: Frames, small: float
) -> Iterator[tuple[int, Frames]]:
    """Rules that draw just this, and the frame in which they do."""
    for number, rule in enumerate(symbols):
        if not isinstance(rule, Rule) or len(rule.items) != len(content):
            continue
        single = {
            item.symbol: item.frames
            for item in rule.items
            if isinstance(item, Place) and len(item.frames) == 1 and item.stretch is None
        }
        if sorted(single) != sorted(content):
            continue
        inside = join([single[symbol] for symbol in content])
        frames = matrices(compose(first, inverse(inside)))
        if np.abs(frames - frames[0]).max() <= small:
            yield number, compose(first, inverse(inside))[:1]


def _corners(first: Frames, boxes: Floats) -> list[Frames]:
    """Frames in which the members of a pair may be said: at the low corner of all, upright or
    turned as the first.
    """
    turned = replace(first[:1], position=np.zeros((1, 3)))
    found = []
    for turn in (moved_to(np.zeros((1, 3))), turned):
        low, _ = _box(compose(inverse(turn), first), boxes)
        found.append(replace(turn, position=spread(turn, low[None])[0]))
    upright = np.abs(matrices(turned)[0, :, :3] - np.eye(3)).max() <= CLOSE
    return found[:1] if upright else found


def _box(frames: Frames, boxes: Floats) -> tuple[Floats, Floats]:
    """Corners (3,) of the box around boxes (n, 2, 3) in frames (n,)."""
    low, high = around(frames, boxes[:, 0], boxes[:, 1])
    return low.min(axis=0), high.max(axis=0)


def _rule(content: list[int], inside: Frames, boxes: Floats) -> Rule:
    """The rule for what stands together, in coordinates that begin at its low corner."""
    items: dict[int, list[int]] = {}
    for row, symbol in enumerate(content):
        items.setdefault(symbol, []).append(row)
    placed = tuple(Place(symbol, inside[np.array(rows)]) for symbol, rows in items.items())
    low, high = _box(inside, boxes)
    return Rule("", high - np.minimum(low, 0.0), placed)


def _with_rule(scheme: Scheme, number: int, rule: Rule) -> Scheme:
    """The scheme with one more rule, of this number."""
    numbers = {each: each + (each >= number) for each in range(len(scheme.symbols))}

    def numbered(symbol: Symbol) -> Symbol:
        if not isinstance(symbol, Rule):
            return symbol
        return replace(symbol, items=tuple(on_symbols(item, numbers) for item in symbol.items))

    symbols = [numbered(symbol) for symbol in scheme.symbols]
    return replace(scheme, symbols=(*symbols[:number], rule, *symbols[number:]))


def _with_row(scheme: Scheme, number: int, joined: Sequence[int], row: Row) -> Scheme:
    """The scheme with one row in a rule, in place of the items of these indices."""
    rule = scheme.symbols[number]
    assert isinstance(rule, Rule)
    items: list[Item] = [item for k, item in enumerate(rule.items) if k not in joined[1:]]
    items[joined[0]] = row
    changed = replace(rule, items=tuple(items))
    symbols = (*scheme.symbols[:number], changed, *scheme.symbols[number + 1 :])
    return replace(scheme, symbols=symbols)
