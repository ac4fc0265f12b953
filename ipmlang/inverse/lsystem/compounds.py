"""Shapes of several subpaths, matched part by part, whatever the order and starts of the parts.

In come groups of compound elements that were aligned point by point, with the parts of each group's
model; out go fewer groups, with the symmetries that exchange or turn parts (a washer is a circle,
whose two rims may start anywhere). Nothing here looks inside a part.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipmlang.inverse.lsystem.alignment import symmetry_of_turns
from ipmlang.inverse.lsystem.curves import Booleans, Integers
from ipmlang.inverse.lsystem.frames import (
    Complexes,
    Floats,
    Frames,
    apply,
    compose,
    frames,
    inverse,
    join,
    mirrored,
)
from ipmlang.inverse.lsystem.shapes import Group
from ipmlang.inverse.lsystem.symmetry import Symmetry, dihedral, simplest

MOST_PARTS = 48  # of one shape; more are left as the alignment point by point found them


@dataclass(frozen=True, slots=True, eq=False)
class PartClass:
    """A class of parts: its symmetry, its radius, and the middle of its representative."""

    symmetry: Symmetry
    radius: float
    middle: complex


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """The k parts of one shape: numbers of their classes (k,), and their frames."""

    shape: Integers
    frames: Frames


@dataclass(frozen=True, slots=True, eq=False)
class _Layout:
    """Where parts are: their middles (k,) and the mean of these; the size of the whole, by which
    scales are told; whether all middles are the mean.
    """

    middles: Complexes
    centre: complex
    size: float
    concentric: bool


def merge_compounds(
    groups: Sequence[Group],
    parts: Sequence[Parts],
    classes: Sequence[PartClass],
    tolerance: float,
) -> list[Group]:
    """Groups whose models have the same parts in the same arrangement made one, with symmetries."""
    alike: dict[bytes, list[int]] = {}
    for number, each in enumerate(parts):
        alike.setdefault(np.sort(each.shape).tobytes(), []).append(number)
    result: list[Group] = []
    for numbers in alike.values():
        if len(parts[numbers[0]].shape) > MOST_PARTS:
            result += [groups[number] for number in numbers]
            continue
        while numbers:
            lead, rest = numbers[0], numbers[1:]
            joined, numbers = [_centred(groups[lead], parts[lead], classes)], []
            for other in rest:
                found = next(_maps(parts[lead], parts[other], classes, tolerance), None)
                if found is None:
                    numbers.append(other)
                else:
                    joined.append(_seen_as(groups[other], joined[0], found))
            symmetry = _symmetry(parts[lead], classes, tolerance)
            result.append(_united(joined, symmetry, tolerance))
    return result


def _layout(parts: Parts, classes: Sequence[PartClass], tolerance: float) -> _Layout:
    middles = apply(parts.frames, np.array([classes[row].middle for row in parts.shape.tolist()]))
    centre = complex(middles.mean())
    radii = np.array([classes[row].radius for row in parts.shape.tolist()]) * parts.frames.scale
    away = np.abs(middles - centre)
    size = float(np.sqrt(np.mean(away**2 + radii**2)))
    return _Layout(middles, centre, size, bool(away.max() <= tolerance))


def _maps(a: Parts, b: Parts, classes: Sequence[PartClass], tolerance: float) -> Iterator[Frames]:
    """Frames (of shape ()) that map the parts of a onto those of b, as placed in the drawing."""
    here, there = (_layout(each, classes, tolerance) for each in (a, b))
    scale = there.size / here.size
    room = tolerance / 4
    turned = _turns(a, b, here, there, classes)
    turn = turned.factor / np.abs(turned.factor)
    position = there.centre - scale * turn * mirrored(
        np.full(len(turn), here.centre), turned.handedness
    )
    candidates = frames(position, np.angle(turn, deg=True), scale, turned.handedness)
    for row in range(len(candidates)):
        if _fits(candidates[row], a, b, classes, room):
            yield candidates[row]


def _turns(
    a: Parts, b: Parts, here: _Layout, there: _Layout, classes: Sequence[PartClass]
) -> Frames:
    """Candidate turns and handednesses, (c,) Frames of which the positions do not matter."""
    if here.concentric or there.concentric:
        # The part with the fewest symmetries tells the turn, by its own frame.
        orders = [classes[row].symmetry.order or np.inf for row in a.shape.tolist()]
        pivot = int(np.argmin(orders))
        same = np.flatnonzero(b.shape == a.shape[pivot])
        stabiliser = classes[int(a.shape[pivot])].symmetry.stabiliser
        turned = compose(b.frames[same][:, None], stabiliser)
        every = compose(turned, inverse(a.frames[pivot]))
        return frames(
            np.zeros(every.x.size, np.complex128),
            every.angle.ravel(),
            1.0,
            every.handedness.ravel(),
        )
    away = here.middles - here.centre
    often = np.array([np.count_nonzero(a.shape == row) for row in a.shape])
    far = np.abs(away) > 1e-6 * here.size
    pivot = int(np.lexsort((-np.abs(away), often, ~far))[0])
    same = np.flatnonzero(b.shape == a.shape[pivot])
    target = there.middles[same] - there.centre
    direct = np.angle(target / away[pivot], deg=True)
    flipped = np.angle(target / -np.conj(away[pivot]), deg=True)
    hand = np.repeat(np.array([1, -1], np.int8), len(same))
    return frames(
        np.zeros(2 * len(same), np.complex128), np.concatenate([direct, flipped]), 1.0, hand
    )


def _fits(
    placed: Frames, a: Parts, b: Parts, classes: Sequence[PartClass], tolerance: float
) -> bool:
    """Whether each part of a lands on a part of b of its class, and none of b is left."""
    landed = compose(placed, a.frames)
    for number in np.unique(a.shape).tolist():
        mine, yours = np.flatnonzero(a.shape == number), np.flatnonzero(b.shape == number)
        if len(mine) != len(yours):
            return False
        back = compose(inverse(b.frames[yours])[:, None], landed[mine])
        off = _displaced(back, classes[number]) * b.frames.scale[yours][:, None]
        near: Booleans = off <= tolerance
        if not (near.any(axis=0).all() and near.any(axis=1).all()):
            return False
    return True


def _displaced(moves: Frames, shape: PartClass) -> Floats:
    """How far frames (m, k) move a representative from itself, its symmetries allowed."""
    if shape.symmetry.order == 0:
        return np.abs(moves.position) + np.abs(moves.scale - 1) * shape.radius
    every = shape.symmetry.stabiliser
    off = np.abs(moves.position[..., None] - every.position)
    off = off + np.abs(moves.factor[..., None] - every.factor) * shape.radius
    off = np.where(moves.handedness[..., None] == every.handedness, off, np.inf)
    return np.asarray(off.min(axis=-1))


def _symmetry(parts: Parts, classes: Sequence[PartClass], tolerance: float) -> Symmetry:
    layout = _layout(parts, classes, tolerance / 4)
    circles = all(classes[row].symmetry.order == 0 for row in parts.shape.tolist())
    if layout.concentric and circles:
        return dihedral(0, 0.0)
    every = list(_maps(parts, parts, classes, tolerance))
    turns = [float(each.angle) for each in every if each.handedness > 0]
    mirrors = [float(each.angle) for each in every if each.handedness < 0]
    return symmetry_of_turns(turns, mirrors)


def _centred(group: Group, parts: Parts, classes: Sequence[PartClass]) -> Group:
    """The group about the mean of its parts' middles, which every symmetry keeps."""
    centre = _layout(parts, classes, 0.0).centre
    shift = frames(np.array([centre - group.centre]))
    radius = group.radius + abs(centre - group.centre)
    return replace(group, centre=centre, frames=compose(group.frames, shift), radius=radius)


def _seen_as(group: Group, lead: Group, placed: Frames) -> Group:
    """The group with its frames given for the model of `lead`, which `placed` maps to its own."""
    local = compose(frames(np.array([-group.centre])), placed)
    onto = compose(local, frames(np.array([lead.centre])))
    return replace(group, frames=compose(group.frames, onto))


def _united(groups: Sequence[Group], symmetry: Symmetry, tolerance: float) -> Group:
    members = np.concatenate([group.members for group in groups])
    order = np.argsort(members)
    error = np.concatenate([group.error for group in groups])
    if len(groups) > 1:
        error = error + tolerance / 4
    return replace(
        groups[0],
        members=members[order],
        frames=simplest(join([group.frames for group in groups])[order], symmetry),
        error=error[order],
        symmetry=symmetry,
    )
