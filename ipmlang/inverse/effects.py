"""Group effects as placed copies of effect classes: clips, masks, filters, opacity.

In go the effects of a drawing, each with a space of its own; out come classes of those that are one
definition up to a similarity, and the frame of each. Definitions are compared as text, which the
reader has made canonical, and clips by the shape that they cut out. An effect that depends on no
space (opacity) has no frame. Nothing here knows which elements an effect wraps.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipmlang.formats.drawing import Drawing, Effect
from ipmlang.formats.svg.transforms import (
    IDENTITY,
    Matrix,
    determinant,
    inverse,
    is_usable,
    multiply,
    translate,
)
from ipmlang.inverse.appearance import is_spaceless
from ipmlang.inverse.clips import placed_clip
from ipmlang.inverse.lsystem.curves import stack
from ipmlang.inverse.lsystem.elements import Found, group_elements
from ipmlang.inverse.lsystem.frames import Frames, frames, identity
from ipmlang.inverse.lsystem.symmetry import Symmetry, trivial

DIGITS = 10  # in which the shape of two spaces must agree
WORDS = {"clip-path": "clip", "mask": "mask", "filter": "filter", "opacity": "faded"}


@dataclass(frozen=True, slots=True, eq=False)
class EffectClass:
    """Effects that are one definition up to a similarity.

    effect: as a parts file holds it, y down about zero; anchored: it lies somewhere, so that its
    frame matters; scale: the smallest of its frames; symmetry: the frames that keep it as it is.
    """

    effect: Effect
    anchored: bool
    scale: float
    symmetry: Symmetry

    @property
    def word(self) -> str:
        """What a person would call it."""
        return next((WORDS[name] for name, _ in self.effect.attributes if name in WORDS), "blend")


@dataclass(frozen=True, slots=True, eq=False)
class Effects:
    """The effects of a drawing: of and frames by their names there, a frame being one row."""

    classes: tuple[EffectClass, ...]
    of: Mapping[str, int]
    frames: Mapping[str, Frames]


def effect_classes(drawing: Drawing, flip: float, shared: bool, tolerance: float) -> Effects:
    """The classes of a drawing's effects; each one alone, in the world, unless they are `shared`.

    flip: c of y_model = c - y_svg; tolerance: units, how far equal clips may be apart.
    """
    if not shared:
        return _effects([_in_world([name], drawing, flip) for name in drawing.effects])
    kinds: dict[Hashable, list[str]] = {}
    spaces = {
        name: similar_space(effect.matrix, flip)
        for name, effect in drawing.effects.items()
        if not is_spaceless(effect) and is_usable(effect.matrix)
    }
    for name, effect in drawing.effects.items():
        usable = is_spaceless(effect) or name in spaces
        key = effect.attributes, effect.definitions, spaces[name][0] if name in spaces else None
        kinds.setdefault(key if usable else name, []).append(name)
    equal = list(kinds.values())
    found = _equal_clips(drawing, flip, tolerance, equal)
    taken = {name for each in found for name in each.frames}
    for names in equal:
        if names[0] in taken:
            continue
        effect = drawing.effects[names[0]]
        if len(names) == 1 or is_spaceless(effect):
            found.append(_in_world(names, drawing, flip))
        else:
            placed = {name: spaces[name][1] for name in names}
            found.append(_Found(replace(effect, matrix=spaces[names[0]][0]), placed, trivial()))
    return _effects(found)


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """One class under construction, with the frame of each effect in it by name."""

    effect: Effect
    frames: dict[str, Frames]
    symmetry: Symmetry


def _effects(found: Sequence[_Found]) -> Effects:
    classes: list[EffectClass] = []
    of: dict[str, int] = {}
    placed: dict[str, Frames] = {}
    for each in found:
        of |= dict.fromkeys(each.frames, len(classes))
        placed |= each.frames
        least = min(float(place.scale[0]) for place in each.frames.values())
        anchored = not is_spaceless(each.effect)
        classes.append(EffectClass(each.effect, anchored, least, each.symmetry))
    return Effects(tuple(classes), of, placed)


def _in_world(names: Sequence[str], drawing: Drawing, flip: float) -> _Found:
    """Effects that lie where they lie: one alone, or those that lie nowhere."""
    effect = drawing.effects[names[0]]
    matrix = IDENTITY
    if not is_spaceless(effect):  # a parts file has its coordinates about zero
        matrix = multiply(translate(0.0, -flip), effect.matrix)
    return _Found(replace(effect, matrix=matrix), {n: identity(1) for n in names}, trivial())


def _equal_clips(
    drawing: Drawing, flip: float, tolerance: float, equal: Sequence[Sequence[str]]
) -> list[_Found]:
    """Classes of clips that are written apart but cut out the same shape; equal: effects that are
    one definition already.
    """
    kind = {name: number for number, names in enumerate(equal) for name in names}
    clips = {name: clip for name in kind if (clip := placed_clip(drawing.effects[name]))}
    found: list[_Found] = []
    for rule in ("nonzero", "evenodd"):
        names = [name for name, clip in clips.items() if clip[1] == rule]
        outlines = [clips[name][0] for name in names]
        if len({kind[name] for name in names}) < 2:
            continue
        whole = np.zeros(len(names), np.bool_)
        for group in group_elements(outlines, stack(outlines, flip), whole, tolerance):
            members = [names[row] for row in group.members.tolist()]
            several = len({kind[name] for name in members}) > 1
            if several and group.kind in ("path", "ellipse"):
                found.append(_clip_class(drawing, flip, members, group))
    return found


def _clip_class(drawing: Drawing, flip: float, names: Sequence[str], group: Found) -> _Found:
    """Clips of one shape: the first one's definition, in the frame of the shape."""
    placed = {name: group.frames[row : row + 1] for row, name in enumerate(names)}
    effect = drawing.effects[names[0]]
    back = inverse(drawn_matrix(placed[names[0]], flip))
    return _Found(replace(effect, matrix=multiply(back, effect.matrix)), placed, group.symmetry)


def drawn_matrix(placed: Frames, flip: float) -> Matrix:
    """The map of y-down coordinates that a frame makes: from an asset's to a drawing's."""
    factor, hand = complex(placed.factor[0]), float(placed.handedness[0])
    return (
        factor.real * hand,
        -factor.imag * hand,
        factor.imag,
        factor.real,
        float(placed.x[0]),
        flip - float(placed.y[0]),
    )


def similar_space(matrix: Matrix, flip: float) -> tuple[Matrix, Frames]:
    """A usable map to the drawing as what is left of it, which keeps the downward axis, and a frame
    after that. It is the identity unless the space is squeezed or slanted.
    """
    a, b, c, d, e, f = matrix
    hand = 1 if determinant(matrix) > 0 else -1
    size = math.hypot(c, d)
    angle = math.degrees(math.atan2(c, d))
    place = frames(np.array([complex(e, flip - f)]), angle, size, hand)
    along, across = hand * (a * d - b * c) / size**2, (a * c + b * d) / size**2
    return (_rounded(along, 1.0), _rounded(across, 0.0), 0.0, 1.0, 0.0, 0.0), place


def _rounded(value: float, plain: float) -> float:
    """A number with so many digits that equal ones are equal; the plain one if it is that."""
    return plain if abs(value - plain) <= 10.0**-DIGITS else float(f"{value:.{DIGITS}g}")
