"""Outlines as path data in few bytes, many at once, for files that are read by programs.

Takes outlines and how far a point of each may be moved; gives the `d` text of each with as few
decimals as that allows, each command in the shorter of absolute and relative form, with H, V, S, T
and letters left out that say nothing new. Where only the place of an outline needs many decimals,
its steps are written without them. Steps are counted in whole units of the last decimal, so
roundings never add up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats import FormatError
from ipmlang.formats.drawing import ARC, Outline
from ipmlang.formats.numbers import decimal_texts, without_zero
from ipmlang.formats.svg.arc_pieces import Pieces, growth
from ipmlang.formats.svg.path_data import Segments, commands, path_texts, segment_table

_Floats = NDArray[np.float64]
_Integers = NDArray[np.int64]
_Flags = NDArray[np.bool_]

_BATCH = 50_000
_MOST_DECIMALS = 15
_SMALLEST = 1e-15  # of a coordinate: nothing is written more exactly
_LARGEST = 1e15  # where whole numbers end
_ROUND = 1e-12  # of the radius: where an ellipse is a circle
_TOO_SHORT = 4e-8  # of the radius: what a chord is longer than an arc allows, if it spans half
_WORST_GROWTH = 2e4  # arcs whose centres shift more than this are cut into others

# Forms of commands: 0 nothing, 1 L, 2 Q, 3 C, 4 A, 5 H, 6 V, 7 S, 8 T; the columns each prints of
# (x1, y1, x2, y2, x3, y3), for A of (rx, ry, rotation, x, y).
_LETTERS = ("", "L", "Q", "C", "A", "H", "V", "S", "T")
_EITHER_LETTERS = np.array([_LETTERS, [letter.lower() for letter in _LETTERS]], object)
_LINE, _QUADRATIC, _CUBIC, _ARC, _LEVEL, _UPRIGHT, _SMOOTH, _SMOOTHER = range(1, 9)
_COLUMNS = np.array(
    [
        [0, 0, 0, 0, 0, 0],
        [1, 1, 0, 0, 0, 0],
        [1, 1, 1, 1, 0, 0],
        [1, 1, 1, 1, 1, 1],
        [1, 1, 1, 1, 1, 0],
        [1, 0, 0, 0, 0, 0],
        [0, 1, 0, 0, 0, 0],
        [0, 0, 1, 1, 1, 1],
        [0, 0, 1, 1, 0, 0],
    ],
    np.bool_,
)


def short_path_texts(outlines: Sequence[Outline], allowed: Sequence[float]) -> list[str]:
    """The path data of each outline, empty for one without segments; allowed: units, how far its
    points may be moved.

    >>> ends = [[[0.5, 1], [4.5, 1]], [[4.5, 1], [4, 3]]]
    >>> coords = np.concatenate([ends, np.zeros((2, 2, 2))], axis=1)
    >>> corner = Outline(np.ones(2, np.uint8), coords, np.array([0, 2]), np.array([True]))
    >>> short_path_texts([corner], [1e-6])
    ['M.5 1h4l-.5 2z']
    """
    texts = [""] * len(outlines)
    batch: list[int] = []
    size = 0
    for row, outline in enumerate(outlines):
        if not len(outline.kind):
            continue
        if not np.abs(outline.coords[:, :3]).max() < _LARGEST:
            texts[row] = path_texts([outline], 1)[0]
            continue
        batch.append(row)
        size += len(outline.kind)
        if size >= _BATCH:
            _place(texts, batch, outlines, allowed)
            batch, size = [], 0
    _place(texts, batch, outlines, allowed)
    return texts


def _place(
    texts: list[str], rows: list[int], outlines: Sequence[Outline], allowed: Sequence[float]
) -> None:
    if not rows:
        return
    made = _batch_texts([outlines[row] for row in rows], np.array([allowed[row] for row in rows]))
    for row, text in zip(rows, made, strict=True):
        texts[row] = text


@dataclass(slots=True)
class _Steps:
    """Commands of a batch in whole units of the last decimal of their outline.

    code: (p,) as in `Pieces`; outline: (p,); opens, closes: (p,) of their subpath; points: (p, 3,
    2) the controls and the end, of arcs the end alone; begin: (p, 2) the current point before each;
    top: (p, 2) where its subpath began; decimals: (k,) of each outline; origin: (k, 2) what the
    units count from; fine: (k,) the decimals of that; placed: (k,) whether these are more;
    radii: (k,) the decimals of radii.
    """

    code: _Integers
    outline: _Integers
    opens: _Flags
    closes: _Flags
    points: _Integers
    begin: _Integers
    top: _Integers
    decimals: _Integers
    origin: _Floats
    fine: _Integers
    placed: _Flags
    radii: _Integers


def _batch_texts(outlines: list[Outline], allowed: _Floats) -> list[str]:
    segments = segment_table(outlines)
    if not np.isfinite(segments.coords).all():
        raise FormatError(
            "the drawing has a coordinate without a value (not a number, or infinite)"
        )
    allowed = _for_arcs(segments, np.maximum(allowed, _SMALLEST * _sizes(segments)))
    pieces = commands(segments, allowed[segments.outline])
    steps = _steps(pieces, segments, allowed)
    return _Printer(steps, pieces).texts()


def _sizes(segments: Segments) -> _Floats:
    """(k,) the largest coordinate of each outline."""
    starts = np.flatnonzero(np.diff(segments.outline, prepend=-1))
    return np.maximum.reduceat(np.abs(segments.coords[:, :3]).max(axis=(1, 2)), starts)


def _for_arcs(segments: Segments, allowed: _Floats) -> _Floats:
    """Less is allowed where the ends of arcs decide where their centres are."""
    rows = np.flatnonzero(segments.kind == ARC)
    worst = np.ones(len(allowed))
    shift = np.clip(growth(np.abs(segments.coords[rows, 3, 1])), 1.0, _WORST_GROWTH)
    np.maximum.at(worst, segments.outline[rows], shift)
    return allowed / worst


def _steps(pieces: Pieces, segments: Segments, allowed: _Floats) -> _Steps:
    """The commands on the coarsest decimal grid that is fine enough for each outline."""
    owner = pieces.segment
    outline = segments.outline[owner].astype(np.int64)
    head = np.diff(owner, prepend=-1) != 0
    tail = np.append(head[1:], True)
    opens = head & segments.first[owner]
    closes = tail & segments.last[owner] & segments.closed[owner]
    code = np.minimum(pieces.code, _ARC).astype(np.int64)
    first = np.flatnonzero(np.diff(outline, prepend=-1))
    corner = pieces.start[first]
    points = _points(pieces, code)
    values = np.concatenate([points, pieces.start[:, None]], axis=1)
    values[:, 3][~opens] = np.nan  # starts are written where a subpath begins
    fixed, loose = (
        _decimals(values - zero[outline][:, None], outline, allowed / 2)
        for zero in (np.zeros_like(corner), corner)
    )
    placed = loose < fixed
    decimals = np.where(placed, loose, fixed)
    origin = np.where(placed[:, None], corner, 0.0)
    unit = 10.0 ** decimals[outline]
    grid = np.rint(np.nan_to_num((points - origin[outline][:, None]) * unit[:, None, None]))
    start = np.rint((pieces.start - origin[outline]) * unit[:, None]).astype(np.int64)
    grid = grid.astype(np.int64)
    fine = _decimals(corner[:, None], np.arange(len(corner)), allowed / 2)
    radii = np.clip(np.ceil(-np.log10(allowed)), 1, _MOST_DECIMALS).astype(np.int64)
    made = _Steps(
        code, outline, opens, closes, grid, start, start, decimals, origin, fine, placed, radii
    )  # fmt: skip
    _follow(made, start)
    return made


def _points(pieces: Pieces, code: _Integers) -> _Floats:
    """(p, 3, 2) the points of each command, its end last in use; NaN where there is none."""
    points = pieces.numbers.reshape(-1, 3, 2).copy()
    arcs = code == _ARC
    points[arcs, 0] = pieces.numbers[arcs, 3:5]
    counts = np.where(arcs, 1, code)
    points[np.arange(3) >= counts[:, None]] = np.nan
    return points


def _decimals(values: _Floats, outline: _Integers, allowed: _Floats) -> _Integers:
    """(k,) the fewest decimals by which no value (p, n, 2) of an outline is moved too far."""
    given = ~np.isnan(values.reshape(len(values), -1))
    flat = values.reshape(len(values), -1)[given]
    starts = np.flatnonzero(np.diff(np.repeat(outline, given.sum(axis=1)), prepend=-1))
    found = np.full(len(allowed), _MOST_DECIMALS, np.int64)
    open_rows = np.arange(len(allowed))
    for decimals in range(_MOST_DECIMALS):
        scaled = flat * 10.0**decimals
        off = np.abs(scaled - np.rint(scaled)) * 10.0**-decimals
        worst = np.maximum.reduceat(off, starts)
        fine = worst <= allowed[open_rows]
        found[open_rows[fine]] = decimals
        if fine.all():
            break
        sizes = np.diff(np.append(starts, len(flat)))
        kept = np.repeat(~fine, sizes)
        flat, open_rows = flat[kept], open_rows[~fine]
        starts = np.concatenate([[0], np.cumsum(sizes[~fine])[:-1]])
    return found


def _follow(steps: _Steps, start: _Integers) -> None:
    """Set where each command begins: where the one before it ended, as whoever reads it will."""
    ends = _ends(steps)
    opened = np.maximum.accumulate(np.where(steps.opens, np.arange(len(ends)), 0))
    steps.top = start[opened]
    steps.begin = np.where(steps.opens[:, None], start, np.roll(ends, 1, axis=0))
    closing = np.flatnonzero(steps.closes)
    back = (ends[closing] == steps.top[closing]).all(axis=1)
    near = np.abs(ends[closing] - steps.top[closing]).max(axis=1, initial=0) <= 1
    line = steps.code[closing] == _LINE
    # A line without length must be written: closing alone would not draw it.
    short = (steps.begin[closing] == steps.top[closing]).all(axis=1)
    steps.code[closing[(back | near) & line & ~short]] = 0
    met = closing[near & ~back & ~line]
    last = np.where(steps.code[met] == _ARC, 0, steps.code[met] - 1)
    steps.points[met, last] = steps.top[met]


def _ends(steps: _Steps) -> _Integers:
    last = np.where(steps.code == _ARC, 0, steps.code - 1)
    return steps.points[np.arange(len(last)), np.maximum(last, 0)]


class _Printer:
    """Prints a batch of commands."""

    def __init__(self, steps: _Steps, pieces: Pieces) -> None:
        self._steps = steps
        self._pieces = pieces
        self._arcs = np.flatnonzero(steps.code == _ARC)
        self._decimals = steps.decimals[steps.outline]
        absolute = steps.points.reshape(-1, 6)
        step = (steps.points - steps.begin[:, None]).reshape(-1, 6)
        self._form = _forms(steps, step)
        self._relative = self._shorter(absolute, step)
        self._chosen = np.where(self._relative[:, None], step, absolute)

    def _shorter(self, absolute: _Integers, step: _Integers) -> _Flags:
        """(p,) whether the relative form is the shorter one, or the only one."""
        used = _COLUMNS[self._form]
        used[self._arcs, 2:] = False
        lengths = [_length(each, used, self._decimals) for each in (absolute, step)]
        # A letter more says that steps have ended, so places must spare more than that.
        return np.asarray((lengths[1] <= lengths[0] + 1) | self._steps.placed[self._steps.outline])

    def texts(self) -> list[str]:
        """The path data of each outline."""
        numbers, ends = self._numbers()
        # Numbers behind others of the same command with what parts them.
        parted = [_joint(before, word) + word for before, word in pairwise(numbers)]
        letters = _EITHER_LETTERS[self._relative.astype(np.int64), self._form].tolist()
        moves = self._moves()
        arcs = self._arc_texts()
        steps = self._steps
        texts: list[str] = []
        words: list[str] = []
        before, last, number, start = "", "", -1, 0
        columns = (letters, ends, steps.opens.tolist(), steps.closes.tolist())
        outlines = steps.outline.tolist()
        for row, (letter, end, opens, closes) in enumerate(zip(*columns, strict=True)):
            if outlines[row] != number:
                texts.append("".join(words))
                words, before, last, number = [], "", "", outlines[row]
            if opens:
                move, x, y = moves[row]
                if letter == "l" and not words:
                    move = "m"
                words += [move, x, _joint(x, y), y]
                before, last = ("l" if move == "m" else "L"), y
            if letter:
                first = numbers[start]
                if row in arcs:
                    first = _joined([*arcs[row], first])
                words.append(letter if letter != before else _joint(last, first))
                words.append(first)
                words += parted[start : end - 1]
                before, last, start = letter, numbers[end - 1], end
            if closes:
                words.append("z")
                before = ""
        texts.append("".join(words))
        return texts[1:]

    def _numbers(self) -> tuple[list[str], list[int]]:
        """The numbers of all commands in their order, arcs without radii, and where those of each
        end.
        """
        used = _COLUMNS[self._form]
        used[self._arcs, 2:] = False
        counts = used.sum(axis=1)
        texts = self._texts_of(self._chosen[used], np.repeat(self._decimals, counts))
        return texts, np.cumsum(counts).tolist()

    def _texts_of(self, values: _Integers, decimals: _Integers) -> list[str]:
        texts = np.empty(len(values), object)
        for each in np.unique(decimals).tolist():
            rows = np.flatnonzero(decimals == each)
            made = " ".join(decimal_texts(values[rows] / 10.0**each, each))
            # As `without_zero`, for all of them.
            short = f" {made}".replace(" 0.", " .").replace(" -0.", " -.")
            texts[rows] = np.array(short.split(), object)
        found: list[str] = texts.tolist()
        return found

    def _moves(self) -> dict[int, tuple[str, str, str]]:
        """The letter and the numbers of what opens each subpath, by its command."""
        steps = self._steps
        rows = np.flatnonzero(steps.opens)
        outline = steps.outline[rows]
        first = np.diff(outline, prepend=-1) != 0
        point = steps.begin[rows]
        ends = np.where(steps.closes[rows - 1, None], steps.top[rows - 1], _ends(steps)[rows - 1])
        step = np.where(first[:, None], point, point - ends)
        used = np.ones_like(point, np.bool_)
        decimals = self._decimals[rows]
        shorter = _length(step, used, decimals) < _length(point, used, decimals)
        relative = ~first & (shorter | steps.placed[outline])
        chosen = np.where(relative[:, None], step, point)
        flat = self._texts_of(chosen.ravel(), np.repeat(decimals, 2))
        found = {
            row: ("m" if moved else "M", flat[2 * k], flat[2 * k + 1])
            for k, (row, moved) in enumerate(zip(rows.tolist(), relative.tolist(), strict=True))
        }
        for row, number in zip(rows[first].tolist(), outline[first].tolist(), strict=True):
            if steps.placed[number]:
                x, y = decimal_texts(steps.origin[number], int(steps.fine[number]))
                found[row] = ("M", without_zero(x), without_zero(y))
        return found

    def _arc_texts(self) -> dict[int, list[str]]:
        """Radii, rotation and flags of the arcs, by their command."""
        rows = self._arcs
        numbers, codes = self._pieces.numbers[rows], self._pieces.code[rows]
        even = np.abs(numbers[:, 0] - numbers[:, 1]) <= _ROUND * numbers[:, 0]
        chord = np.hypot(*(self._pieces.end - self._pieces.start)[rows].T)
        # Radii that are too small for their chord grow until they fit: a few digits say enough.
        half = even & (chord > (2 + _TOO_SHORT) * numbers[:, 0])
        coarse = 10.0 ** (np.floor(np.log10(np.maximum(numbers[:, 0], 1e-300))) - 2)
        radius = np.where(half, np.floor(numbers[:, 0] / coarse) * coarse, numbers[:, 0])
        numbers = np.where((np.arange(6) < 2) & even[:, None], radius[:, None], numbers)
        places = self._steps.radii[self._steps.outline[rows]]
        found: dict[int, list[str]] = {}
        for row, values, code, decimals in zip(
            rows.tolist(), numbers.tolist(), codes.tolist(), places.tolist(), strict=True
        ):
            radii = decimal_texts(np.array(values[:2]), decimals)
            tilt = decimal_texts(np.array(values[2:3]), 12)
            flags = [str((code - 4) >> 1), str((code - 4) & 1)]
            found[row] = [*map(without_zero, [*radii, *tilt]), *flags]
        return found


def _forms(steps: _Steps, step: _Integers) -> _Integers:
    """(p,) the form of each command: the one with the fewest numbers that says the same."""
    form = steps.code.copy()
    line = form == _LINE
    form[line & (step[:, 1] == 0)] = _LEVEL
    form[line & (step[:, 0] == 0) & (step[:, 1] != 0)] = _UPRIGHT
    for code, smooth in ((_CUBIC, _SMOOTH), (_QUADRATIC, _SMOOTHER)):
        rows = np.flatnonzero(steps.code == code)
        after = (np.roll(steps.code, 1)[rows] == code) & ~steps.opens[rows]
        handle = steps.points[rows - 1, code - 2]
        expected = np.where(after[:, None], steps.begin[rows] - handle, 0)
        mirrored = (step[rows, :2] == expected).all(axis=1)
        # A parabola whose handle lies in its start is rare, and readers differ about it.
        form[rows[mirrored & (after | (code == _CUBIC))]] = smooth
    return form


def _length(values: _Integers, used: _Flags, decimals: _Integers) -> _Integers:
    """(p,) characters of the numbers in use, signs and blanks included."""
    broken = np.abs(values) % 10 ** decimals[:, None] > 0
    counts = used.sum(axis=1)
    places = np.repeat(decimals, counts)
    value, rest, before = values[used], broken[used], np.roll(broken, 1, axis=1)[used]
    size = np.abs(value)
    whole = size // 10**places
    zeros = np.zeros_like(size)
    for power in range(1, int(decimals.max(initial=0)) + 1):
        zeros += size % 10**power == 0
    shown = np.where(rest, 1 + places - np.minimum(zeros, places), 0)
    digits = np.searchsorted(10 ** np.arange(18), whole, side="right")
    length = np.maximum(digits + shown, 1)
    # A minus parts numbers as a blank does; so does a point after a number that has one.
    parted = (value >= 0) & ~((whole == 0) & rest & before)
    length = length + (parted | (value < 0))
    row = np.repeat(np.arange(len(values)), counts)
    return np.bincount(row, length, len(values)).astype(np.int64)


def _joined(words: Sequence[str]) -> str:
    """Numbers one after the other, with what parts them."""
    return words[0] + "".join(_joint(before, word) + word for before, word in pairwise(words))


def _joint(before: str, word: str) -> str:
    """What parts a number from the one before it."""
    if word[0] == "-" or (word[0] == "." and "." in before):
        return ""
    return " "
