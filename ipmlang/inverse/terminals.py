"""Terminals by inverse instancing (section 4.2 of the paper): one symbol for each shape and style.

Takes an observation; gives the alphabet with its terminals, the string of all elements, and what
each terminal's asset shows. Text and pictures stand at their own origin, gradients and slanted pens
are expressed in the frame of what they paint. Nothing here looks for patterns.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import (
    DrawnElement,
    Fragment,
    Outline,
    PaintServer,
    Style,
)
from ipmlang.formats.svg.attributes import Linear
from ipmlang.formats.svg.transforms import inverse, multiply
from ipmlang.inverse.effects import EffectClass, drawn_matrix, effect_classes
from ipmlang.inverse.lsystem.curves import flipped, moved
from ipmlang.inverse.lsystem.frames import ORIGIN, Frames, compose, frames
from ipmlang.inverse.lsystem.frames import inverse as undo
from ipmlang.inverse.lsystem.groups import Kind, group_runs
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Seen, see
from ipmlang.inverse.lsystem.symmetry import trivial
from ipmlang.inverse.observation import Observation, ShapeClass
from ipmlang.inverse.own_spaces import turned_with_space
from ipmlang.runtime.export.drawn_assets import depends_on_frame, moved_style

LEAST = 12  # so many lengths of lines, each of fewer than
OFTEN = 3  # lines, share one asset
FEW_LENGTHS = 40  # lengths of lines that are also tried as one line, stretched, in a drawing of at
MOST_STRETCHED = 3000  # most so many elements
SHARE = 3e-7  # of the diagonal: how far an expansion may be from what was observed


@dataclass(frozen=True, slots=True, eq=False)
class Terminal:
    """What an asset shows: a shape class in a style, or a fragment about its own origin (y down).
    row: the first element drawn by it; base: how the representative lies in the asset; space: the
    linear part of the map by which the file drew that element, as seen from the asset (y down).
    """

    row: int
    shape: ShapeClass
    style: Style
    fragment: Fragment | None
    base: Frames
    space: Linear | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Instanced:
    """An observation as a string of terminals.

    string: of all elements; with effects, a stretch for what each group holds behind it, see
    `group_runs`, whose symbol and frame `bodies` has; effects: the classes of effects that symbols
    name; element: (m,) the element of each row of `seen`.
    """

    alphabet: Alphabet
    string: Arrangement
    seen: Seen
    terminals: tuple[Terminal, ...]
    effects: tuple[EffectClass, ...]
    bodies: Mapping[int, tuple[int, Frames]]
    element: NDArray[np.int64]


def instances(observed: Observation) -> list[Instanced]:
    """Every way to see the drawing as terminals: with what has a space of its own only moved; where
    some of that has a twin that stands otherwise, turned with its space; where lines have a few
    lengths, as one line stretched, for a thing with lines may stand there smaller.
    """
    plain = [replace(style, effects=()) for style in observed.styles]
    upright = _upright(observed)
    turned, twins = turned_with_space(observed, plain, upright)
    ways = [_instance(observed, plain, upright, {}, _rare_lines(observed))]
    if twins:
        ways.append(_instance(observed, plain, turned, twins, _rare_lines(observed)))
    if few := _few_lengths(observed):
        ways.append(_instance(observed, plain, upright, {}, few))
    return ways


def with_stretched_lines(observed: Observation) -> Instanced | None:
    """The drawing with all lines of a style as one, stretched; None where all have one length."""
    several = [numbers for numbers in _line_classes(observed) if len(numbers) > 1]
    if not several:
        return None
    plain = [replace(style, effects=()) for style in observed.styles]
    return _instance(observed, plain, _upright(observed), {}, several)


def _instance(
    observed: Observation,
    plain: Sequence[Style],
    given: Frames,
    twins: Mapping[int, Hashable],
    stretched: Sequence[Sequence[int]],
) -> Instanced:
    """The alphabet of terminals and the string of all elements in paint order; plain: the styles
    without effects; twins: by row, what makes terminals equal that are turned; stretched: classes
    of lines that are the first of them, stretched to measure.
    """
    alphabet = Alphabet(SHARE * observed.diagonal)
    shapes, placed = _scaled_lines(observed, given, stretched)
    known: dict[Hashable, int] = {}
    terminals: list[Terminal] = []
    numbers = np.empty(len(observed), np.int64)
    for row, (shape, style) in enumerate(
        zip(shapes.tolist(), observed.style.tolist(), strict=True)
    ):
        key, made = _terminal(observed, row, shape, plain[style], placed)
        key = twins.get(row, key)
        if key not in known:
            bound = made.fragment is not None or depends_on_frame(made.style)
            symmetry = trivial() if bound else made.shape.symmetry
            radius = made.shape.radius * float(made.base.scale[0])
            # A space of its own shows a wrong turn as far as the drawing reaches.
            radius = max(radius, observed.diagonal) if bound else radius
            known[key] = alphabet.add_terminal(symmetry, radius)
            terminals.append(replace(made, space=_space(observed, row, placed)))
        numbers[row] = known[key]
    every = np.arange(len(observed))
    string = Arrangement(numbers, placed, every, np.zeros(len(observed), np.int64))
    seen = see(alphabet, numbers, placed)
    return Instanced(alphabet, string, seen, tuple(terminals), (), {}, every)


def grouped(observed: Observation, instanced: Instanced, shared: bool) -> Instanced:
    """What was instanced, with the runs under each group effect as symbols; each run by itself
    unless they are `shared`.
    """
    if not any(style.effects for style in observed.styles):
        return instanced
    effects = effect_classes(observed.drawing, observed.flip, shared, observed.tolerance)
    kinds = [
        Kind(each.anchored, observed.diagonal / each.scale, each.symmetry)
        for each in effects.classes
    ]
    of_style = [
        [(name, effects.of[name], effects.frames[name]) for name in style.effects]
        for style in observed.styles
    ]
    stacks = [of_style[style] for style in observed.style.tolist()]
    made = group_runs(instanced.alphabet, instanced.string, instanced.seen, stacks, kinds, shared)
    return Instanced(
        made.alphabet,
        made.string,
        made.seen,
        instanced.terminals,
        effects.classes,
        made.bodies,
        made.element,
    )


def _upright(observed: Observation) -> Frames:
    """The frames of all elements. What depends on its frame (gradients, slanted pens) and fragments
    are only moved, never turned or scaled, so that nothing about them is rounded.
    """
    given = observed.frames
    x, y = given.x.copy(), given.y.copy()
    for shape in observed.classes:
        if shape.fragment is not None:
            x[shape.members] = shape.fragment.matrix[4]
            y[shape.members] = observed.flip - shape.fragment.matrix[5]
    fixed = _bound(observed)
    return Frames(
        x,
        y,
        np.where(fixed, 0.0, given.angle),
        np.where(fixed, 1.0, given.scale),
        np.where(fixed, 1, given.handedness).astype(np.int8),
    )


def _bound(observed: Observation) -> NDArray[np.bool_]:
    """(n,) elements whose style depends on their frame."""
    bound = [depends_on_frame(replace(style, effects=())) for style in observed.styles]
    return np.array(bound, np.bool_)[observed.style]


def _rare_lines(observed: Observation) -> list[list[int]]:
    """Classes of lines of a length that hardly another one has, where there are many, so that a
    thousand lengths need one asset.
    """
    rare = [
        [number for number in numbers if len(observed.classes[number].members) < OFTEN]
        for numbers in _line_classes(observed)
    ]
    return [numbers for numbers in rare if len(numbers) >= LEAST]


def _few_lengths(observed: Observation) -> list[list[int]]:
    """Classes of lines where there are a few lengths, the most frequent one first."""
    if len(observed) > MOST_STRETCHED:
        return []
    several = [numbers for numbers in _line_classes(observed) if 2 <= len(numbers) <= FEW_LENGTHS]
    return [
        sorted(numbers, key=lambda each: (-len(observed.classes[each].members), each))
        for numbers in several
    ]


def _line_classes(observed: Observation) -> list[list[int]]:
    """The classes of lines without and with a direction."""
    return [
        [
            number
            for number, shape in enumerate(observed.classes)
            if shape.kind == "line" and shape.directed == directed
        ]
        for directed in (False, True)
    ]


def _scaled_lines(
    observed: Observation, placed: Frames, stretched: Sequence[Sequence[int]]
) -> tuple[NDArray[np.int32], Frames]:
    """Shapes and frames where all lines of some classes are of the first one, stretched; not those
    whose style would be stretched with them.
    """
    shapes, scale = observed.shape.copy(), placed.scale.copy()
    free = ~_bound(observed)
    for numbers in stretched:
        unit = observed.classes[numbers[0]].radius
        for number in numbers:
            members = observed.classes[number].members
            rows = members[free[members]]
            shapes[rows] = numbers[0]
            scale[rows] *= observed.classes[number].radius / unit
    return shapes, Frames(placed.x, placed.y, placed.angle, scale, placed.handedness)


def _terminal(
    observed: Observation, row: int, shape: int, style: Style, placed: Frames
) -> tuple[Hashable, Terminal]:
    """The terminal that draws an element, and what makes it equal to others."""
    known = observed.classes[shape]
    if known.fragment is None and not depends_on_frame(style):
        return (shape, style), Terminal(row, known, style, None, ORIGIN)
    place = placed[row : row + 1]
    if known.fragment is not None:
        linear = multiply(inverse(drawn_matrix(_about_zero(place), 0.0)), known.fragment.matrix)[:4]
        fragment = replace(known.fragment, matrix=(*linear, 0.0, 0.0))
        return (fragment.kind, fragment.xml, linear), Terminal(row, known, style, fragment, ORIGIN)
    back = inverse(drawn_matrix(place, observed.flip))
    local = _rounded(moved_style(style, back))
    base = _about_zero(compose(undo(place), observed.frames[row : row + 1]))
    key = float(base.angle[0]), float(base.scale[0]), int(base.handedness[0])
    return (shape, local, key), Terminal(row, known, local, None, base)


def _space(observed: Observation, row: int, placed: Frames) -> Linear | None:
    """The linear part of the map from the file's numbers for an element to its asset's."""
    linear = observed.drawing.elements[row].space
    return None if linear is None else _seen_from(placed[row : row + 1], linear)


def _seen_from(place: Frames, linear: Linear) -> Linear:
    back = inverse(drawn_matrix(_about_zero(place), 0.0))
    return multiply(back, (*linear, 0.0, 0.0))[:4]


def asset_space(terminal: Terminal, place: Frames | None) -> Linear | None:
    """The space of a terminal's numbers, see `Terminal`, where its asset lies at a place."""
    if terminal.space is None or place is None:
        return terminal.space
    return multiply(drawn_matrix(_about_zero(place), 0.0), (*terminal.space, 0.0, 0.0))[:4]


def _about_zero(place: Frames) -> Frames:
    """The frame at the origin."""
    return frames(np.zeros(1, np.complex128), place.angle, place.scale, place.handedness)


def _rounded(style: Style) -> Style:
    """Matrices rounded to twelve digits, so that equal ones are equal."""

    def paint(given: str | PaintServer) -> str | PaintServer:
        if isinstance(given, str):
            return given
        a, b, c, d, e, f = (_digits(value, given.matrix) for value in given.matrix)
        return replace(given, matrix=(a, b, c, d, e, f))

    pen = style.stroke_matrix
    if pen is not None:
        a, b, c, d = (_digits(value, pen) for value in pen)
        pen = (a, b, c, d)
    return replace(style, fill=paint(style.fill), stroke=paint(style.stroke), stroke_matrix=pen)


def _digits(value: float, beside: tuple[float, ...]) -> float:
    size = max(abs(each) for each in beside) or 1.0
    return round(value, 11 - int(np.floor(np.log10(size)))) + 0.0


def asset_elements(shown: Sequence[tuple[Terminal, Frames | None]]) -> list[DrawnElement]:
    """Terminals as their parts file holds them, y down, with where each lies about the origin."""
    drawn = iter(_pages([_outline(*each) for each in shown if each[0].fragment is None]))
    return [
        _fragment(terminal.fragment, place)
        if terminal.fragment is not None
        else DrawnElement(next(drawn), _asset_style(terminal.style, place))
        for terminal, place in shown
    ]


def _fragment(fragment: Fragment, place: Frames | None) -> DrawnElement:
    matrix = multiply(drawn_matrix(_at(place), 0.0), fragment.matrix)
    return DrawnElement(None, Style(), replace(fragment, matrix=matrix))


def _asset_style(style: Style, place: Frames | None) -> Style:
    if not depends_on_frame(style):
        return style
    return moved_style(style, drawn_matrix(_at(place), 0.0))


def _outline(terminal: Terminal, place: Frames | None) -> Outline:
    """The outline of a terminal where it lies about the origin, y up."""
    outline = terminal.shape.outline
    assert outline is not None
    if place is None and _is_upright(terminal.base):
        return outline
    return moved(outline, compose(_at(place), terminal.base))


def _at(place: Frames | None) -> Frames:
    return ORIGIN if place is None else place


def _pages(outlines: Sequence[Outline]) -> list[Outline]:
    """The outlines with y down."""
    if not outlines:
        return []
    kind = np.concatenate([each.kind for each in outlines])
    coords = np.concatenate([each.coords for each in outlines])
    points = flipped(kind, coords[..., 0] + 1j * coords[..., 1], 0.0)
    turned = np.stack([points.real, points.imag], axis=-1)
    ends = np.cumsum([len(each.kind) for each in outlines])
    parts = np.split(turned, ends[:-1])
    return [
        Outline(each.kind, part, each.starts, each.closed)
        for each, part in zip(outlines, parts, strict=True)
    ]


def _is_upright(place: Frames) -> bool:
    return bool(place.angle[0] == 0 and place.scale[0] == 1 and place.handedness[0] > 0)
