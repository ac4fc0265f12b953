"""What maps a part onto itself: turns and mirrors about its centre, proved one by one.

Takes model parts, one or many of equal counts at once; gives the group of each. Round parts have
more maps than anyone can use: of these only the ones along the axes are kept, which are a group
again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.parts.aligning import refined
from ipmlang.inverse.parts.anchors import Anchors, corner_lengths
from ipmlang.inverse.parts.copies import Model, Truths, matched

_BATCH = 1_000_000  # corners compared at a time
_MOST_WORK = 20_000_000  # corners compared to find all maps of a part onto itself
_LARGEST = 600_000  # corners of a part whose maps are looked for


@dataclass(frozen=True, slots=True, eq=False)
class SelfMaps:
    """What maps a model onto itself: linear (s, 3, 3), the identity first, and places (s, v): the
    vertex that each vertex comes to. whole: False if only those along the axes were looked for.
    """

    linear: Floats
    places: Integers
    whole: bool


def self_maps(models: Model, most: int) -> list[SelfMaps]:
    """All maps of each model onto itself; only those along the axes where there may be more than
    `most` or where the model is very large.
    """
    copies = models.copies
    count, corners = copies.corners.shape
    if corners > _LARGEST:
        return [_alone(models, False)] * count
    lengths = corner_lengths(copies)
    anchors = Anchors.of(copies, lengths, models.tolerance)
    row, corner, forward = anchors.candidates(copies, lengths)
    linear = anchors.maps(copies, row, corner, forward)
    many = np.bincount(row, minlength=count)
    whole = (many <= most) & (many * corners <= _MOST_WORK)
    kept = np.abs(linear - np.eye(3)).max(axis=(1, 2)) > 1e-6
    kept &= whole[row] | _along_axes(linear)
    row, linear = row[kept], linear[kept]
    step = max(1, _BATCH // corners)
    found = [
        _proved(models, row[k : k + step], linear[k : k + step], anchors.slack)
        for k in range(0, len(row), step)
    ]
    return _by_model(models, found, whole)


def _alone(models: Model, whole: bool) -> SelfMaps:
    size = models.copies.points.shape[1]
    return SelfMaps(np.eye(3)[None], np.arange(size)[None], whole)


def _proved(
    models: Model, row: Integers, linear: Floats, slack: Floats
) -> tuple[Integers, Floats, Integers]:
    """Those of the maps that bring their model onto itself, at their best."""
    copies, own = models.copies[row], models.at(row)
    found, places = matched(own, copies, linear, slack[row])
    best, good = refined(own.at(np.flatnonzero(found)), copies[found], linear[found], places)
    return row[found][good], best[good], places[good]


def _by_model(
    models: Model, found: list[tuple[Integers, Floats, Integers]], whole: Truths
) -> list[SelfMaps]:
    """The maps of each model, after the identity."""
    count, alone = len(whole), _alone(models, True)
    if not found:
        return [_alone(models, bool(each)) for each in whole]
    row, linear, places = (np.concatenate(column) for column in zip(*found, strict=True))
    starts = np.searchsorted(row, np.arange(count + 1)).tolist()
    return [
        SelfMaps(
            np.concatenate([alone.linear, linear[begin:end]]),
            np.concatenate([alone.places, places[begin:end]]),
            bool(all_of_them),
        )
        for begin, end, all_of_them in zip(starts[:-1], starts[1:], whole, strict=True)
    ]


def _along_axes(linear: Floats) -> Truths:
    """Which maps take axes to axes."""
    close: Truths = np.abs(linear - np.rint(linear)).max(axis=(1, 2)) < 1e-5
    return close
