"""Shapes in their own axes, where their copies are turned this way and that.

In go parts, out come the same parts with such shapes turned about the vertical until their level
edges run along x and y, and the copies turned back. A house that stands askew everywhere is then
drawn as a person would draw it, and has a width and a depth to edit. Nothing is drawn elsewhere.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ipmlang.inverse.frames import Frames, about, compose, identity, inverse, linear, moved_to
from ipmlang.inverse.parts.axes import askew, straightened
from ipmlang.inverse.parts.observation import Likeness, PartClass, Parts

UP = np.array([0.0, 0.0, 1.0])
QUARTER = 90.0  # degrees
FEW = 2  # headings that say nothing
EVEN = 7.5  # degrees: turns by whole multiples of that follow some order


def upright(parts: Parts) -> Parts:
    """The parts with shapes in their own axes."""
    frames, classes = parts.frames, list(parts.classes)
    back: dict[int, Frames] = {}
    for number, each in enumerate(classes):
        turn = askew(each.mesh) if by_hand(frames[each.members]) else 0.0
        if turn:
            classes[number], back[number] = _turned(each, turn)
            frames = _with(frames, each, compose(frames[each.members], back[number]))
    likenesses = tuple(_turned_likeness(each, back) for each in parts.likenesses)
    return replace(parts, frames=frames, classes=tuple(classes), likenesses=likenesses)


def _turned_likeness(each: Likeness, back: dict[int, Frames]) -> Likeness:
    one, other = (back.get(number, identity()) for number in (each.shape, each.of))
    return replace(each, frame=compose(inverse(one), compose(each.frame, other)))


def by_hand(frames: Frames) -> bool:
    """Whether copies are turned this way and that about the vertical, and not all as one of them,
    or as the members of a ring are.

    >>> from ipmlang.inverse.frames import join
    >>> ring = about(UP, np.array([0.0, 45, 90, 135]))
    >>> odd = about(UP, np.array([0.0, 17.2, 70.8, 131.3]))
    >>> [by_hand(replace(join([identity()] * 4), rotation=turn)) for turn in (ring, odd)]
    [False, True]
    """
    turn = linear(frames)
    heading = np.degrees(np.arctan2(turn[:, 1, 0], turn[:, 0, 0]))
    apart = np.unique(np.round((heading - heading[:1]) % QUARTER, 2) % QUARTER)
    steps = np.unique(np.round(np.diff(apart), 1))
    odd = np.abs(apart / EVEN - np.rint(apart / EVEN)) > 0.01
    return 2 * int(odd.sum()) >= len(apart) > FEW and 2 * len(steps) >= len(apart)


def _turned(each: PartClass, degrees: float) -> tuple[PartClass, Frames]:
    """A shape turned to the right, and the frame in which it is what it was."""
    mesh = straightened(each.mesh, degrees)
    low = mesh.vertices.min(axis=0)
    turn = replace(identity(), rotation=about(UP, np.array([degrees])))
    back = compose(turn, moved_to(low[None]))
    symmetry = compose(compose(inverse(back), each.symmetry), back)
    mesh = replace(mesh, vertices=mesh.vertices - low)
    size = np.ptp(mesh.vertices, axis=0)
    return replace(each, mesh=mesh, size=size, symmetry=symmetry), back


def _with(frames: Frames, each: PartClass, own: Frames) -> Frames:
    """All frames, those of a class's members as given."""
    column = [frames.position, frames.rotation, frames.hand, frames.scale]
    given = [own.position, own.rotation, own.hand, own.scale]
    position, rotation, hand, scale = (np.array(values) for values in column)
    for values, new in zip((position, rotation, hand, scale), given, strict=True):
        values[each.members] = new
    return Frames(position, rotation, hand, scale)
