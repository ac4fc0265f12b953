"""What has a space of its own, turned with it: text and pictures, shapes under a gradient.

In go an observation and the frames of its elements, which only move such things; out come frames
that turn, size and mirror those that have a twin which stands otherwise, and for these what makes
two of them equal. The frame is that of the text or gradient, so no symmetry can hide it. Nothing
here makes terminals.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace

import numpy as np

from ipmlang.formats.drawing import Paint, PaintServer, Style
from ipmlang.formats.svg.transforms import inverse as undone
from ipmlang.formats.svg.transforms import is_usable
from ipmlang.inverse.effects import drawn_matrix, similar_space
from ipmlang.inverse.lsystem.frames import Frames, compose, frames, inverse, join, replaced
from ipmlang.inverse.observation import Observation
from ipmlang.runtime.export.drawn_assets import moved_style

DIGITS = 7  # in which two things must agree, of a turn, a factor and the diagonal


def turned_with_space(
    observed: Observation, styles: Sequence[Style], placed: Frames
) -> tuple[Frames, dict[int, Hashable]]:
    """The frames, and by row what those that were turned are equal in; styles: without effects."""
    found: dict[Hashable, list[tuple[int, Frames]]] = {}
    for row, (shape, style) in enumerate(
        zip(observed.shape.tolist(), observed.style.tolist(), strict=True)
    ):
        known = observed.classes[shape]
        if known.fragment is not None:
            matrix = known.fragment.matrix
            if is_usable(matrix):
                rest, place = similar_space(matrix, observed.flip)
                key: Hashable = (known.fragment.kind, known.fragment.xml, rest)
                found.setdefault(key, []).append((row, place))
        elif (server := _server(styles[style])) is not None and is_usable(server.matrix):
            _, space = similar_space(server.matrix, observed.flip)
            given = observed.frames[row : row + 1]
            place = frames(given.position, space.angle, given.scale, space.handedness)
            key = shape, _local(observed, row, styles[style], place)
            found.setdefault(key, []).append((row, place))
    twins = {key: rows for key, rows in found.items() if _differ([each for _, each in rows])}
    keys = {row: key for key, rows in twins.items() for row, _ in rows}
    if not keys:
        return placed, {}
    turned = join([_upright([place for _, place in rows]) for rows in twins.values()])
    return replaced(placed, np.array(list(keys), np.int64), turned), keys


def _server(style: Style) -> PaintServer | None:
    """The gradient or pattern that a style's space is."""
    return next(
        (each for each in (style.fill, style.stroke) if isinstance(each, PaintServer)), None
    )


def _upright(places: Sequence[Frames]) -> Frames:
    """Frames so turned and sized that the first one is plain."""
    first = places[0]
    back = inverse(frames(np.zeros(1, np.complex128), first.angle, first.scale, first.handedness))
    return compose(join(list(places)), back)


def _differ(places: Sequence[Frames]) -> bool:
    """Whether frames differ in more than where they are."""
    return len({(_short(p.angle[0]), _short(p.scale[0]), int(p.handedness[0])) for p in places}) > 1


def _local(observed: Observation, row: int, style: Style, place: Frames) -> Hashable:
    """How a shape and its style look in a frame, in so many digits: equal for equal things."""
    moved = moved_style(style, undone(drawn_matrix(place, observed.flip)))
    unit = observed.diagonal
    group = observed.classes[int(observed.shape[row])].symmetry
    base = compose(compose(inverse(place), observed.frames[row : row + 1]), group.stabiliser)
    seat = [
        (int(hand), _short(angle) % 360.0)
        for hand, angle in zip(base.handedness, base.angle, strict=True)
    ]
    pen = None if moved.stroke_matrix is None else tuple(map(_short, moved.stroke_matrix))
    plain = replace(moved, stroke_matrix=None, fill=_digits(moved.fill, unit),
                    stroke=_digits(moved.stroke, unit))  # fmt: skip
    return min(seat) if group.order else None, plain, pen


def _digits(paint: Paint, unit: float) -> Paint:
    if isinstance(paint, str):
        return paint
    a, b, c, d, e, f = paint.matrix
    linear = [_short(value / unit) for value in (a, b, c, d)]
    shift = [_short(value / unit) for value in (e, f)]
    return replace(paint, matrix=(linear[0], linear[1], linear[2], linear[3], shift[0], shift[1]))


def _short(value: float) -> float:
    return round(float(value), DIGITS) + 0.0
