"""Elements of a drawing grouped by shape: the first half of the 2010 paper's section 4.

In come outlines, out go classes with their symmetry groups and, for every element, its class and
frame. Lines are grouped by length, since all lines are similar; full ellipses by their proportions;
everything else by `shapes`. Nothing here reads styles or looks for patterns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from ipmlang.formats.drawing import LINE, Outline
from ipmlang.inverse.lsystem.compounds import PartClass, Parts, merge_compounds
from ipmlang.inverse.lsystem.curves import (
    Booleans,
    Curves,
    Integers,
    evaluate,
    full_ellipse,
    outline_at,
    segment_line,
    stack,
)
from ipmlang.inverse.lsystem.ellipses import Ellipses, find_ellipses
from ipmlang.inverse.lsystem.frames import Complexes, Floats, Frames, apply, frames, join, unit
from ipmlang.inverse.lsystem.segments import LIMIT, fewest_segments
from ipmlang.inverse.lsystem.shapes import Group, group_paths
from ipmlang.inverse.lsystem.symmetry import Symmetry, dihedral, of_line, simplest, trivial

Kind: TypeAlias = Literal["line", "ellipse", "path", "point", "fragment"]

SNAP = 15.0  # degrees, as in `alignment`


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """One class: kind as in `ShapeClass`, members (k,) ascending element numbers, their frames and
    errors (units), the representative outline, its symmetry and radius, and whether it is directed.
    """

    kind: Kind
    members: Integers
    frames: Frames
    error: Floats
    outline: Outline
    symmetry: Symmetry
    radius: float
    directed: bool


def group_elements(
    outlines: Sequence[Outline],
    curves: Curves,
    directed: Booleans,
    tolerance: float,
    decimals: int = 17,
) -> list[Found]:
    """Classes of all elements, in the order of their first members.

    curves: the outlines stacked, in the coordinates wanted; directed: (n,) start and direction are
    visible; tolerance: units, how far a placed representative may be from its element;
    decimals: of the coordinates, so that origins which may lie anywhere need no more.
    """
    extent = _extent(curves)
    # Shapes are told by plain curves, but shown as they were written.
    plain = fewest_segments(curves, directed, LIMIT * extent, tolerance * 1e-2)
    point = extent <= tolerance / 4
    line = ~point & (plain.counts == 1) & ~curves.closed
    line[line] = plain.kind[plain.offsets[:-1][line]] == LINE
    ellipses = find_ellipses(plain, tolerance / 4)
    ellipse = ellipses.full & ~point & ~directed
    path = np.flatnonzero(~(point | line | ellipse))
    found: list[Found] = []
    for fixed in (False, True):
        found += _lines(plain, np.flatnonzero(line & (directed == fixed)), fixed, tolerance)
    found += _ellipses(ellipses, np.flatnonzero(ellipse), tolerance)
    groups = group_paths(plain, path, _layouts(outlines), directed, tolerance)
    for group in _by_parts(groups, curves, outlines, directed, tolerance):
        found.append(_path(group, curves, outlines[group.model], decimals, directed))
    found += _points(curves, outlines, np.flatnonzero(point), directed)
    return sorted(found, key=lambda each: int(each.members[0]))


def _by_parts(
    groups: list[Group],
    curves: Curves,
    outlines: Sequence[Outline],
    directed: Booleans,
    tolerance: float,
) -> list[Group]:
    """The groups, those of several subpaths matched by their parts."""
    several = [each for each in groups if curves.subpaths[each.model] > 1]
    several = [each for each in several if not directed[each.model]]
    if not several:
        return groups
    split = [
        _subpaths(outline_at(curves, each.model, outlines[each.model], 0j)) for each in several
    ]
    parts = [part for group in split for part in group]
    free = np.zeros(len(parts), np.bool_)
    found = group_elements(parts, stack(parts), free, tolerance / 8)
    order = np.argsort(np.concatenate([each.members for each in found]))
    shape = np.repeat(np.arange(len(found)), [len(each.members) for each in found])[order]
    placed = join([each.frames for each in found])[order]
    ends = np.cumsum([len(group) for group in split])
    spans = [slice(int(end) - len(group), int(end)) for end, group in zip(ends, split, strict=True)]
    classes = [
        PartClass(each.symmetry, each.radius, each.radius / 2 if each.kind == "line" else 0j)
        for each in found
    ]
    merged = merge_compounds(
        several, [Parts(shape[span], placed[span]) for span in spans], classes, tolerance
    )
    replaced = {id(each) for each in several}
    return [each for each in groups if id(each) not in replaced] + merged


def _subpaths(outline: Outline) -> list[Outline]:
    """The subpaths as outlines of their own."""
    bounds = outline.starts.tolist()
    spans = zip(bounds[:-1], bounds[1:], outline.closed, strict=True)
    return [
        Outline(
            outline.kind[start:end],
            outline.coords[start:end],
            np.array([0, end - start], np.int32),
            np.array([closed]),
        )
        for start, end, closed in spans
    ]


def _extent(curves: Curves) -> Floats:
    """(n,) largest distance of the curve's points from its first one, 0 for empty ones."""
    along = evaluate(curves.kind, curves.points, np.array([0.0, 0.5, 1.0]))
    head = np.repeat(curves.offsets[:-1], curves.counts)
    away = np.abs(along - along[head, :1]).max(axis=1)
    result = np.zeros(len(curves.counts))
    some = np.flatnonzero(curves.counts)
    if len(some):
        result[some] = np.maximum.reduceat(away, curves.offsets[some])
    return result


def _layouts(outlines: Sequence[Outline]) -> Integers:
    """(n,) equal numbers for equal subpath offsets and closings."""
    known: dict[tuple[bytes, bytes], int] = {}
    keys = ((each.starts[:-1].tobytes(), each.closed.tobytes()) for each in outlines)
    return np.array([known.setdefault(key, len(known)) for key in keys], np.int64)


def _lines(curves: Curves, rows: Integers, directed: bool, tolerance: float) -> list[Found]:
    first = curves.offsets[rows]
    start, end = curves.points[first, 0], curves.points[first, 1]
    length = np.abs(end - start)
    angle, miss = _snapped_angle(end - start, tolerance / 8)
    placed = frames(start, angle)
    return [
        Found(
            "line",
            rows[part],
            placed[part],
            miss[part] + np.abs(length[part] - model),
            segment_line(model),
            of_line(model, directed),
            model,
            directed,
        )
        for part, model in _by_value(length, np.full(len(rows), tolerance / 2))
    ]


def _snapped_angle(step: Complexes, tolerance: float) -> tuple[Floats, Floats]:
    """Directions in degrees, multiples of 15 where the end moves less than the tolerance."""
    angle = np.angle(step, deg=True)
    near = SNAP * np.round(angle / SNAP)
    miss = np.abs(np.abs(step) * unit(near) - step)
    fits = miss <= tolerance
    return np.where(fits, near, angle), np.where(fits, miss, 0.0)


def _by_value(values: Floats, slack: Floats) -> list[tuple[Integers, float]]:
    """Parts of ascending positions whose values lie within their slack of one number, which is the
    shortest decimal that does. Cuts are made at the widest gaps, so that equal values with the
    noise of rounding stay together.
    """
    if not len(values):
        return []
    order = np.argsort(values, kind="stable")
    value = values[order]
    lows, highs = value - slack[order], value + slack[order]
    reach = np.maximum.accumulate(highs)
    bounds = np.flatnonzero(np.concatenate([[True], lows[1:] > reach[:-1]]))
    ends = np.append(bounds[1:], len(order))
    parts, todo = [], list(zip(bounds.tolist(), ends.tolist(), strict=True))[::-1]
    while todo:
        start, end = todo.pop()
        if end - start == 1 or lows[start:end].max() <= highs[start:end].min():
            part = np.sort(order[start:end])
            parts.append((part, _round_number(values[part])))
        else:
            cut = start + 1 + int(np.argmax(np.diff(value[start:end])))
            todo += [(cut, end), (start, cut)]
    return parts


def _round_number(values: Floats) -> float:
    """A number in the middle of the values, with as few digits as their spread allows."""
    low, high = float(values.min()), float(values.max())
    middle, room = (low + high) / 2, max((high - low) / 8, abs(high) * 1e-12)
    for digits in range(1, 17):
        rounded = float(f"{middle:.{digits}g}")
        if abs(rounded - middle) <= room:
            return rounded
    return middle


def _ellipses(found: Ellipses, rows: Integers, tolerance: float) -> list[Found]:
    major, minor = found.major[rows], found.minor[rows]
    circle = major - minor <= tolerance / 4
    ratio = np.where(circle, 1.0, minor / np.maximum(major, 1e-300))
    slack = np.where(circle, 0.0, tolerance / (4 * np.maximum(major, 1e-300)))
    classes = []
    for part, value in _by_value(ratio, slack):
        size = _usual(major[part])
        symmetry = dihedral(0, 0.0) if value == 1.0 else dihedral(2, 0.0)
        place = frames(found.centre[rows[part]], found.angle[rows[part]], major[part] / size)
        classes.append(
            Found(
                "ellipse",
                rows[part],
                simplest(place, symmetry),
                found.gap[rows[part]] + np.abs(minor[part] - value * major[part]),
                full_ellipse(size, size * value),
                symmetry,
                size,
                False,
            )
        )
    return classes


def _usual(values: Floats) -> float:
    """The most frequent of the values, the first such in order."""
    _, which, often = np.unique(
        np.round(np.log(values), 9), return_inverse=True, return_counts=True
    )
    return float(values[np.argmax(often[which.ravel()])])


def _path(
    group: Group, curves: Curves, source: Outline, decimals: int, directed: Booleans
) -> Found:
    shift = _rounded_origin(group.centre, group.symmetry, decimals) - group.centre
    moved = group.frames
    if shift:
        at = apply(moved, shift)
        moved = replace(moved, x=at.real, y=at.imag)
    outline = outline_at(curves, group.model, source, group.centre + shift)
    fixed = bool(directed[group.model])
    return Found(
        "path", group.members, moved, group.error, outline, group.symmetry, group.radius, fixed
    )


def _rounded_origin(centre: complex, symmetry: Symmetry, decimals: int) -> complex:
    """The centre, with the coordinates that no symmetry fixes rounded: copies that are only moved
    then stand at positions with no more decimals than the input has.
    """
    if symmetry.order != 1 or decimals > 9:
        return centre
    x, y = round(centre.real, decimals), round(centre.imag, decimals)
    match symmetry.axis:
        case None:
            return complex(x, y)
        case 0.0:
            return complex(x, centre.imag)
        case 90.0:
            return complex(centre.real, y)
        case _:
            return centre


def _points(
    curves: Curves, outlines: Sequence[Outline], rows: Integers, directed: Booleans
) -> list[Found]:
    """Elements without extent: those with the same segments are one class."""
    parts: dict[tuple[bytes, bytes, bytes], list[int]] = {}
    for row in rows.tolist():
        outline = outlines[row]
        key = outline.kind.tobytes(), outline.starts.tobytes(), outline.closed.tobytes()
        parts.setdefault(key, []).append(row)
    found = []
    for members in parts.values():
        empty = not len(outlines[members[0]].kind)
        heads = curves.offsets[members]
        at = np.zeros(len(members), complex) if empty else curves.points[heads, 0]
        outline = outline_at(curves, members[0], outlines[members[0]], complex(at[0]))
        found.append(
            Found(
                "point",
                np.array(members, np.int64),
                frames(at),
                np.zeros(len(members)),
                outline,
                trivial(),
                0.0,
                False,
            )
        )
    return found
