"""Prefix products over segments: what a turtle's state is after each of its commands.

In go columns of equal length (rotations, scales, displacements) cut into consecutive segments, out
come the inclusive products from each segment's start. Work goes in lockstep: the k-th rows of all
segments at once; long segments are cut into blocks whose totals are scanned in turn (f64
throughout). A path's frames need one scan of rotations and cumulative sums of what they turn, so
nothing here composes whole transforms row by row. No I/O, and no knowledge of shapes or symbols.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import accumulate
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

Real: TypeAlias = NDArray[np.float64]
Whole: TypeAlias = NDArray[np.int64]
Columns: TypeAlias = tuple[Real, ...]
Combine: TypeAlias = Callable[[Columns, Columns], Columns]

BLOCK = 128  # flat between 128 and 512
FEW = 8  # so many segments are walked quicker one by one
LONG = 2048  # from here on a sum is quicker segment by segment


@dataclass(slots=True, eq=False)
class Frames:
    """Similarity frames: position (n, 3), unit quaternion w, x, y, z (n, 4), and signed scale (n,),
    negative where the frame is mirrored (local x first).
    """

    position: Real
    rotation: Real
    scale: Real

    def __len__(self) -> int:
        return len(self.scale)


def whole(count: int) -> Whole:
    """The lengths of one segment over `count` rows."""
    return np.array([count], np.int64)


def scan(
    columns: Columns, lengths: Whole, combine: Combine, start: Columns | None = None
) -> Columns:
    """Inclusive prefix products of `columns` (each (n,) or (n, k)) in segments of `lengths` rows.

    `combine(before, after)` is associative and works row by row on tuples of columns. `start` holds
    one row a segment, the product before it; without it a segment starts with its own first row.
    """
    lengths, start = _filled(lengths, start)
    if not len(lengths):
        return columns
    if lengths.max() <= BLOCK:
        return lockstep(columns, lengths, combine, start)
    pieces = -(-lengths // BLOCK)
    sizes = np.full(pieces.sum(), BLOCK, np.int64)
    last = np.cumsum(pieces) - 1
    sizes[last] = lengths - (pieces - 1) * BLOCK
    local = lockstep(columns, sizes, combine, None)
    ends = np.cumsum(sizes) - 1
    before = scan(tuple(column[ends] for column in local), pieces, combine, start)
    return _joined(local, before, sizes, last - pieces + 1, combine, start)


def _joined(
    local: Columns,
    before: Columns,
    sizes: Whole,
    first: Whole,
    combine: Combine,
    start: Columns | None,
) -> Columns:
    """Products within pieces, each times the product before its piece."""
    through = tuple(np.roll(column, 1, axis=0) for column in before)
    for column, values in zip(through, start or (), strict=False):
        column[first] = values
    product = combine(tuple(np.repeat(column, sizes, axis=0) for column in through), local)
    if start is None:
        begins = np.cumsum(sizes) - sizes
        rows = ranges(begins[first], sizes[first])
        for out, values in zip(product, local, strict=True):
            out[rows] = values[rows]
    return product


def lockstep(columns: Columns, lengths: Whole, combine: Combine, start: Columns | None) -> Columns:
    """A scan whose k-th step combines the k-th rows of all segments that have one.

    Rows are laid out by rank in their segment, longest segments first: each step then reads and
    writes one contiguous run.
    """
    order = np.argsort(-lengths, kind="stable")
    if start is not None:
        start = tuple(column[order] for column in start)
    place, counts = _ranked(lengths, order)
    laid = []
    for column in columns:
        values = np.empty_like(column)
        values[place] = column
        laid.append(values)
    begin = 0
    previous = start
    for count in counts.tolist():
        rows = tuple(column[begin : begin + count] for column in laid)
        if previous is not None:
            result = combine(tuple(column[:count] for column in previous), rows)
            for row, value in zip(rows, result, strict=True):
                row[...] = value
        previous = rows
        begin += count
    return tuple(column[place] for column in laid)


class Walk(Protocol):
    """A step that is not associative: for columns of states, and for one state."""

    def columns(self, before: Columns, row: Columns) -> Columns:
        """The states after the step, from those before it and what each row does."""

    def single(self, before: tuple[float, ...], row: tuple[float, ...]) -> tuple[float, ...]:
        """What `columns` gives, for one state."""


def walked(columns: Columns, lengths: Whole, walk: Walk) -> Columns:
    """States after each row of each segment; its first row is the state that it starts from.

    Goes in lockstep where many segments are that long, and through the rest one by one.
    """
    lengths, _ = _filled(lengths, None)
    wide = -np.partition(-lengths, FEW)[FEW] if len(lengths) > FEW else 0
    heads = np.minimum(lengths, wide)
    begins = np.cumsum(lengths) - lengths
    if wide:
        rows = ranges(begins, heads)
        part = lockstep(tuple(column[rows] for column in columns), heads, walk.columns, None)
        for column, values in zip(columns, part, strict=True):
            column[rows] = values
    for segment in np.flatnonzero(lengths > wide).tolist():
        first = begins[segment] + max(wide - 1, 0)
        _walk_one(columns, slice(first, begins[segment] + lengths[segment]), walk)
    return columns


def _walk_one(columns: Columns, rows: slice, walk: Walk) -> None:
    """Walk through rows whose first one is already a state."""
    does = list(zip(*(column[rows].tolist() for column in columns), strict=True))
    states = list(accumulate(does, walk.single))
    for column, values in zip(columns, zip(*states, strict=True), strict=True):
        column[rows] = values


def _ranked(lengths: Whole, order: Whole) -> tuple[Whole, Whole]:
    """Where each row goes in the layout by rank, and how many rows each rank has."""
    ends = np.bincount(lengths)[1:]
    counts = np.cumsum(ends[::-1])[::-1]
    offsets = np.cumsum(counts) - counts
    place_of_segment = np.empty(len(order), np.int64)
    place_of_segment[order] = np.arange(len(order))
    begins = np.cumsum(lengths) - lengths
    rank = np.arange(int(lengths.sum())) - np.repeat(begins, lengths)
    return offsets[rank] + np.repeat(place_of_segment, lengths), counts


def _filled(lengths: Whole, start: Columns | None) -> tuple[Whole, Columns | None]:
    """The segments that have rows."""
    if len(lengths) and lengths.min() > 0:
        return lengths, start
    kept = lengths > 0
    return lengths[kept], None if start is None else tuple(column[kept] for column in start)


def ranges(begins: Whole, lengths: Whole) -> Whole:
    """The numbers begins[i] .. begins[i] + lengths[i] - 1 of all i, one after the other.

    >>> ranges(np.array([5, 0]), np.array([2, 3])).tolist()
    [5, 6, 0, 1, 2]
    """
    ends = np.cumsum(lengths)
    return np.repeat(begins - ends + lengths, lengths) + np.arange(ends[-1] if len(ends) else 0)


def running_sum(values: Real, lengths: Whole, start: Real | None = None) -> Real:
    """Inclusive sums of values (n,) or (n, k) in segments, added in order from `start` (a row a
    segment): the same bits as a turtle that walks.
    """
    return _accumulated(values, lengths, start, np.add)


def running_product(values: Real, lengths: Whole, start: Real | None = None) -> Real:
    """Inclusive products of values (n,), multiplied in order from `start` (one a segment)."""
    return _accumulated(values, lengths, start, np.multiply)


def _accumulated(values: Real, lengths: Whole, start: Real | None, apply: np.ufunc) -> Real:
    lengths, first = _filled(lengths, None if start is None else (start,))
    start = first[0] if first else None
    if not len(lengths):
        return values.copy()
    if lengths.min() >= LONG or len(lengths) == 1:
        return _each(values, lengths, start, apply)
    if lengths.max() >= LONG:
        return _by_length(values, lengths, start, apply)
    return lockstep((values,), lengths, lambda a, b: (apply(a[0], b[0]),), first)[0]


def _each(values: Real, lengths: Whole, start: Real | None, apply: np.ufunc) -> Real:
    out = np.empty_like(values)
    ends = np.cumsum(lengths)
    for segment in range(len(lengths)):
        rows = slice(ends[segment] - lengths[segment], ends[segment])
        part = values[rows]
        if start is not None:
            part = part.copy()
            part[0] = apply(start[segment], part[0])
        apply.accumulate(part, axis=0, out=out[rows])
    return out


def _by_length(values: Real, lengths: Whole, start: Real | None, apply: np.ufunc) -> Real:
    """Long segments one by one, the others in lockstep: both add strictly in order."""
    out = np.empty_like(values)
    begins = np.cumsum(lengths) - lengths
    for chosen in (lengths >= LONG, lengths < LONG):
        rows = ranges(begins[chosen], lengths[chosen])
        first = None if start is None else start[chosen]
        out[rows] = _accumulated(values[rows], lengths[chosen], first, apply)
    return out


def quaternion_product(before: Columns, after: Columns) -> Columns:
    """The product of unit quaternions, each a tuple of columns w, x, y, z."""
    aw, ax, ay, az = before
    bw, bx, by, bz = after
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def normalised(quaternion: Columns) -> Columns:
    """Quaternions scaled back to length 1: products drift by an ulp a step."""
    w, x, y, z = quaternion
    length = np.sqrt(w * w + x * x + y * y + z * z)
    return w / length, x / length, y / length, z / length


def turned(rotation: Columns, vector: Columns) -> Columns:
    """Vectors (x, y, z) rotated by unit quaternions (w, x, y, z), all as columns."""
    w, i, j, k = rotation
    x, y, z = vector
    tx, ty, tz = 2 * (j * z - k * y), 2 * (k * x - i * z), 2 * (i * y - j * x)
    return (
        x + w * tx + (j * tz - k * ty),
        y + w * ty + (k * tx - i * tz),
        z + w * tz + (i * ty - j * tx),
    )


def unit(degrees: Real) -> tuple[Real, Real]:
    """Cosine and sine of angles in degrees, exact at multiples of 90.

    >>> [part.tolist() for part in unit(np.array([90.0, -180.0, 45.0]))]
    [[0.0, -1.0, 0.707...], [1.0, 0.0, 0.707...]]
    """
    quarter = np.rint(degrees / 90)
    rest = np.deg2rad(degrees - 90 * quarter)
    cosine, sine = np.cos(rest), np.sin(rest)
    turns = quarter.astype(np.int64) & 3
    swap = (turns & 1).astype(bool)
    across, along = np.where(swap, sine, cosine), np.where(swap, cosine, sine)
    across[(turns == 1) | (turns == 2)] *= -1
    along[turns >= 2] *= -1
    return across + 0.0, along + 0.0


def about_z(degrees: Real) -> Real:
    """Rotations by angles in degrees about z, as unit quaternions (n, 4)."""
    cosine, sine = unit(np.remainder(degrees + 360, 720) / 2 - 180)
    zero = np.zeros_like(cosine)
    return np.stack((cosine, zero, zero, sine), axis=1)


def chain(steps: Frames, start: Frames | None = None, lengths: Whole | None = None) -> Frames:
    """Products of frames along chains: row k of a chain is start * steps[0] * … * steps[k].

    `start` has one row a chain (default: the identity); `lengths` the rows of each chain (default:
    one chain). A step moves by its position in the frame it finds, then turns, then scales.
    """
    lengths = whole(len(steps)) if lengths is None else lengths
    start = start or identity(len(lengths))
    scale = running_product(steps.scale, lengths, start.scale)
    found = shifted(scale, lengths, start.scale)
    hand = np.sign(found)
    own = _split(steps.rotation)
    own = (own[0], own[1], own[2] * hand, own[3] * hand)
    rotation = normalised(scan(own, lengths, quaternion_product, _split(start.rotation)))
    first = _split(start.rotation)
    held = tuple(shifted(column, lengths, row) for column, row in zip(rotation, first, strict=True))
    x, y, z = (steps.position[:, axis] for axis in range(3))
    size = np.abs(found)
    move = np.stack(turned(held, (x * found, y * size, z * size)), axis=1)
    position = running_sum(move, lengths, start.position)
    return Frames(position, np.stack(rotation, axis=1), scale)


def planar_chain(
    x: Real,
    y: Real,
    degrees: Real,
    scale: Real,
    lengths: Whole | None = None,
    start: tuple[Real, Real, Real, Real] | None = None,
) -> tuple[Real, Real, Real, Real]:
    """`chain` in the plane: x, y, angle in degrees and signed scale, all (n,), in and out.

    Angles are added, not multiplied up, so a turtle that turns by right angles stays exact.
    """
    lengths = whole(len(x)) if lengths is None else lengths
    if start is None:
        zero = np.zeros(len(lengths))
        start = (zero, zero, zero, zero + 1)
    factor = running_product(scale, lengths, start[3])
    found = shifted(factor, lengths, start[3])
    angle = running_sum(np.copysign(1.0, found) * degrees, lengths, start[2])
    cosine, sine = unit(shifted(angle, lengths, start[2]))
    along, across = x * found, y * np.abs(found)
    return (
        running_sum(cosine * along - sine * across, lengths, start[0]),
        running_sum(sine * along + cosine * across, lengths, start[1]),
        angle,
        factor,
    )


def identity(count: int) -> Frames:
    """`count` frames at the origin."""
    rotation = np.zeros((count, 4))
    rotation[:, 0] = 1
    return Frames(np.zeros((count, 3)), rotation, np.ones(count))


def shifted(inclusive: Real, lengths: Whole, start: Real) -> Real:
    """Exclusive products from inclusive ones: each row gets the row before it in its segment, the
    first of a segment its start.
    """
    out = np.empty_like(inclusive)
    out[1:] = inclusive[:-1]
    begins = np.cumsum(lengths) - lengths
    kept = lengths > 0
    out[begins[kept]] = start[kept]
    return out


def _split(rotation: Real) -> Columns:
    return rotation[:, 0], rotation[:, 1], rotation[:, 2], rotation[:, 3]
