"""Classes united where one can stand for another: what finding equal and similar shapes share.

In come classes and a search that says which of them a leading one stands for; out go fewer classes,
each shown by its leading one, with frames from it to every element and errors measured on the
curves. Only curves with the same number of open and closed subpaths meet. Which shapes fit is
decided in `rewriting` and `resemblance`; lines, points and text are left alone.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from ipmlang.inverse.distance import Locus
from ipmlang.inverse.lsystem.curvature import Samples
from ipmlang.inverse.lsystem.curves import Integers
from ipmlang.inverse.lsystem.elements import Found
from ipmlang.inverse.lsystem.frames import (
    Floats,
    Frames,
    apply,
    compose,
    frames,
    join,
    mirrored,
)
from ipmlang.inverse.lsystem.similarity import match
from ipmlang.inverse.lsystem.symmetry import simplest

FIRST = 4  # classes most like a leading one that are compared with it; then twice as many, as long
GROWTH = 4  # as one in so many fits
NEAREST = 64  # of them are known from the start
STRIDE = 4  # of the points along a curve, so many are measured


@dataclass(frozen=True, slots=True, eq=False)
class Fits:
    """Shapes that a leading one stands for: numbers (k,), its frames in them, deviations (k,)."""

    rows: Integers
    frames: Frames
    error: Floats


class Search(Protocol):
    """What classes may be one. order: the most telling first."""

    order: list[int]

    @abstractmethod
    def near(self, lead: int) -> Integers:
        """Shapes like a given one, the likest first."""

    @abstractmethod
    def fit(self, lead: int, rows: Integers) -> Fits:
        """Which of some shapes the given one stands for."""


def merged(found: Sequence[Found], search: Callable[[list[Found]], Search]) -> list[Found]:
    alike: dict[tuple[int, int, bool], list[Found]] = {}
    result: list[Found] = []
    for each in found:
        if each.kind in ("path", "ellipse"):
            closed = each.outline.closed
            key = len(closed), int(np.count_nonzero(closed)), each.directed
            alike.setdefault(key, []).append(each)
        else:
            result.append(each)
    for shapes in alike.values():
        result += _led(shapes, search(shapes)) if len(shapes) > 1 else shapes
    return sorted(result, key=lambda each: int(each.members[0]))


def _led(shapes: list[Found], search: Search) -> list[Found]:
    """Shapes with those that they lead made one."""
    free = np.ones(len(shapes), np.bool_)
    result = []
    for lead in search.order:
        if not free[lead]:
            continue
        free[lead] = False
        near = search.near(lead)
        near = near[free[near]]
        start, size, fits = 0, FIRST, []
        while start < len(near):
            part = near[start : start + size]
            fits.append(search.fit(lead, part))
            free[fits[-1].rows] = False
            if GROWTH * len(fits[-1].rows) < len(part):
                break
            start, size = start + size, 2 * size
        result.append(_united(shapes, lead, fits))
    return result


def _united(shapes: list[Found], lead: int, fits: list[Fits]) -> Found:
    placed, error, members = [shapes[lead].frames], [shapes[lead].error], [shapes[lead].members]
    for fit in fits:
        for index, row in enumerate(fit.rows.tolist()):
            other = shapes[row]
            placed.append(compose(other.frames, fit.frames[index]))
            error.append(other.error + fit.error[index] * other.frames.scale)
            members.append(other.members)
    if len(members) == 1:
        return shapes[lead]
    order = np.argsort(np.concatenate(members))
    return replace(
        shapes[lead],
        members=np.concatenate(members)[order],
        frames=simplest(join(placed)[order], shapes[lead].symmetry),
        error=np.concatenate(error)[order],
    )


def symmetries(shape: Found) -> int:
    """How many frames keep a shape, very many for a circle."""
    return len(shape.symmetry.stabiliser) if shape.symmetry.order else 1 << 30


def matched(
    samples: Samples, lead: int, rows: Integers, directed: bool, least: float
) -> tuple[Floats, Frames]:
    """Similarities (k,) of a shape with others, and its frames in them."""
    found = match(samples, lead, rows, directed, least)
    ratio = samples.radius[rows] / samples.radius[lead]
    factor = found.factor * ratio
    hand = np.where(found.mirrored, -1, 1).astype(np.int8)
    centre = samples.centre[rows] + samples.radius[rows] * found.shift
    position = centre - factor * mirrored(np.full(len(rows), samples.centre[lead]), hand)
    return found.similarity, frames(position, np.angle(factor, deg=True), np.abs(factor), hand)


def deviation(placed: Frames, lead: Locus, other: Locus) -> float:
    """Largest distance between a curve under a frame (of shape ()) and another one."""
    mine, yours = lead.along[::STRIDE], other.along[::STRIDE]
    there = apply(placed, mine)
    away = np.abs(other.closest(there)[0] - there).max()
    back = mirrored((yours - placed.position) / placed.factor, placed.handedness)
    return float(max(away, np.abs(lead.closest(back)[0] - back).max() * placed.scale))
