"""Outlines as SVG path data, many at once.

Takes outlines and a number of decimals; gives the `d` text of each, in absolute coordinates, with
one `M` a subpath and one command a segment. Arcs become `A` commands where that is accurate to the
rounding, else two `A` or a run of cubics. Never reads path data and knows nothing of elements.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats import FormatError
from ipmlang.formats.drawing import ARC, LINE, Outline
from ipmlang.formats.numbers import decimal_texts
from ipmlang.formats.svg.arc_pieces import Pieces, arc_pieces, extra_decimals

_BATCH = 50_000
_Integers = NDArray[np.intp]
_Flags = NDArray[np.bool_]

# A command has a code: 0 nothing, 1 L, 2 Q, 3 C (the kinds of `Outline`), 4-7 A with its two flags;
# +8 if it opens a subpath, +16 if it closes one, +32 if it ends an outline.
_NUMBERS_OF = (0, 2, 4, 6, 5, 5, 5, 5)
_BODIES = (
    "",
    "L%s %s",
    "Q%s %s %s %s",
    "C%s %s %s %s %s %s",
    "A%s %s %s 0 0 %s %s",
    "A%s %s %s 0 1 %s %s",
    "A%s %s %s 1 0 %s %s",
    "A%s %s %s 1 1 %s %s",
)
_TEMPLATES = tuple(
    ("M%s %s" if code & 8 else "")
    + _BODIES[code & 7]
    + ("Z" if code & 16 else "")
    + ("\n" if code & 32 else "")
    for code in range(64)
)
_USED = np.array(
    [
        [bool(code & 8)] * 2 + [column < _NUMBERS_OF[code & 7] for column in range(6)]
        for code in range(64)
    ]
)


def path_texts(outlines: Sequence[Outline], decimals: int) -> list[str]:
    """The path data of each outline; empty for an outline without segments."""
    texts: list[str] = []
    batch: list[Outline] = []
    size = 0
    for outline in outlines:
        batch.append(outline)
        size += len(outline.kind)
        if size >= _BATCH:
            texts += _batch_texts(batch, decimals)
            batch, size = [], 0
    return texts + (_batch_texts(batch, decimals) if batch else [])


@dataclass(slots=True)
class Segments:
    """The segments of a batch of outlines in one table; `first` and `last` of their subpath."""

    kind: NDArray[np.uint8]
    coords: NDArray[np.float64]
    outline: _Integers
    first: _Flags
    last: _Flags
    start: _Integers  # the segment that opens this one's subpath
    closed: _Flags


def _batch_texts(outlines: list[Outline], decimals: int) -> list[str]:
    texts = [""] * len(outlines)
    filled = [index for index, outline in enumerate(outlines) if len(outline.kind)]
    if not filled:
        return texts
    segments = segment_table([outlines[index] for index in filled])
    if not np.isfinite(segments.coords).all():
        raise FormatError(
            "the drawing has a coordinate without a value (not a number, or infinite)"
        )
    decimals += extra_decimals(segments.coords[segments.kind == ARC])
    pieces = commands(segments, np.full(len(segments.kind), 10.0**-decimals))
    lines = _print(pieces, segments, decimals).split("\n")
    for index, line in zip(filled, lines, strict=False):
        texts[index] = line
    return texts


def segment_table(outlines: list[Outline]) -> Segments:
    counts = np.array([len(outline.kind) for outline in outlines])
    kind = np.concatenate([outline.kind for outline in outlines])
    coords = np.concatenate([outline.coords for outline in outlines])
    offsets = np.concatenate([[0], np.cumsum(counts)])
    subpaths = np.array([len(outline.starts) - 1 for outline in outlines])
    opens = np.concatenate([outline.starts[:-1] for outline in outlines]).astype(np.intp)
    opens += np.repeat(offsets[:-1], subpaths)
    ends = np.append(opens[1:], len(kind))
    closed = np.concatenate([outline.closed for outline in outlines])
    used = opens < ends
    opens, ends, closed = opens[used], ends[used], closed[used]
    first, last = np.zeros(len(kind), bool), np.zeros(len(kind), bool)
    first[opens], last[ends - 1] = True, True
    subpath = np.cumsum(first) - 1
    outline_index = np.repeat(np.arange(len(outlines)), counts)
    return Segments(kind, coords, outline_index, first, last, opens[subpath], closed[subpath])


def commands(segments: Segments, unit: NDArray[np.float64]) -> Pieces:
    """One command or more a segment: its code, its numbers, its segment, its start and end. unit:
    (n,) what rounding keeps of each segment.
    """
    kind, coords = segments.kind, segments.coords
    plain = np.flatnonzero(kind != ARC)
    code = kind[plain].astype(np.intp)
    numbers = coords[plain, 1:].reshape(-1, 6)
    # Columns behind the last number of a command are never printed.
    final = coords[plain, np.array([0, 1, 2, 3])[np.minimum(code, 3)]]
    straight = Pieces(plain, code, numbers, coords[plain, 0], final)
    arcs = np.flatnonzero(kind == ARC)
    if not len(arcs):
        return straight
    curved = arc_pieces(coords[arcs], arcs, unit[arcs])
    owner = np.concatenate([straight.segment, curved.segment])
    order = np.argsort(owner, kind="stable")
    return Pieces(
        owner[order],
        np.concatenate([straight.code, curved.code])[order],
        np.concatenate([straight.numbers, curved.numbers])[order],
        np.concatenate([straight.start, curved.start])[order],
        np.concatenate([straight.end, curved.end])[order],
    )


def _print(pieces: Pieces, segments: Segments, decimals: int) -> str:
    owner = pieces.segment
    changes = np.flatnonzero(np.diff(owner)) + 1
    heads = np.concatenate([[0], changes])
    tails = np.append(changes, len(owner)) - 1
    opening = np.zeros(len(owner), bool)
    opening[heads[segments.first[owner[heads]]]] = True
    code = pieces.code.copy()
    _close(code, pieces, segments, tails, heads, 10.0**-decimals)
    code += 8 * opening
    finals = np.append(segments.outline[owner][1:] != segments.outline[owner][:-1], True)
    code += 32 * finals
    table = np.concatenate([pieces.start, pieces.numbers], axis=1)
    used = _USED[code]
    texts = decimal_texts(table[used], decimals)
    _sharpen(texts, table, used, pieces.code, decimals)
    return "".join([_TEMPLATES[each] for each in code.tolist()]) % tuple(texts)


def _close(
    code: _Integers,
    pieces: Pieces,
    segments: Segments,
    tails: _Integers,
    heads: _Integers,
    unit: float,
) -> None:
    """Close subpaths, in place: a closing line is what `Z` draws, other ends meet the start."""
    owner = pieces.segment[tails]
    closing = tails[segments.last[owner] & segments.closed[owner]]
    if not len(closing):
        return
    head_of = np.zeros(len(segments.kind), np.intp)
    head_of[pieces.segment[heads]] = heads
    opener = head_of[segments.start[pieces.segment[closing]]]
    gap = np.abs(pieces.end[closing] - pieces.start[opener]).max(axis=1)
    meets = gap <= 1.5 * unit
    # A line without length must be written: `Z` would not draw it.
    short = np.abs(pieces.start[closing] - pieces.start[opener]).max(axis=1) <= 1.5 * unit
    dropped = meets & ~short & (code[closing] == LINE)
    snapped = closing[meets & ~dropped]
    width = np.array(_NUMBERS_OF)[code[snapped]]
    begin = pieces.start[opener[meets & ~dropped]]
    pieces.numbers[snapped, width - 2] = begin[:, 0]
    pieces.numbers[snapped, width - 1] = begin[:, 1]
    code[closing[dropped]] = 0
    code[closing] += 16


def _sharpen(
    texts: list[str],
    table: NDArray[np.float64],
    used: _Flags,
    kind: _Integers,
    decimals: int,
) -> None:
    """Print the radii and the rotation of arcs with more digits, in place: the centre that a
    reader computes from them is less exact than they are.
    """
    rows = np.flatnonzero(kind >= 4)
    if not len(rows):
        return
    first = np.cumsum(used.sum(axis=1))[rows] - 5
    for column, places in enumerate((decimals + 3, decimals + 3, 12)):
        better = decimal_texts(table[rows, 2 + column], places)
        for position, text in zip((first + column).tolist(), better, strict=True):
            texts[position] = text
