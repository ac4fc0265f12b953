"""One curve however it was written is one class; what only looks like it is not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from inverse.synth import (
    BLACK,
    STROKED,
    at,
    circle,
    compound,
    copies,
    drawing,
    leaf,
    line,
    polygon,
    rebuilt,
    rectangle,
    restarted,
)

from ipmlang.formats.drawing import CUBIC, LINE, QUADRATIC, Floats, Outline, Style
from ipmlang.inverse.compare import compare
from ipmlang.inverse.lsystem.curves import stack
from ipmlang.inverse.lsystem.segments import LIMIT, fewest_segments
from ipmlang.inverse.observation import Observation, observe
from tests import real_drawings

DASHED = replace(STROKED, dashes=(1.0, 0.5))


def curve(
    kinds: Sequence[int], points: Sequence[Sequence[Sequence[float]]], closed: bool
) -> Outline:
    """An outline of segments given by their points."""
    coords = np.zeros((len(kinds), 4, 2))
    for row, segment in enumerate(points):
        coords[row, : len(segment)] = segment
    starts = np.array([0, len(kinds)], np.int32)
    return Outline(np.array(kinds, np.uint8), coords, starts, np.array([closed]))


def halves(points: Sequence[Sequence[float]], share: float) -> tuple[Floats, Floats]:
    """A Bezier curve cut in two, after de Casteljau."""
    levels = [np.asarray(points, np.float64)]
    while len(levels[-1]) > 1:
        levels.append((1 - share) * levels[-1][:-1] + share * levels[-1][1:])
    return np.array([each[0] for each in levels]), np.array([each[-1] for each in levels[::-1]])


def round_curves(pieces: int, radius: float, degree: int = 3) -> Outline:
    """A circle drawn by so many cubics or quadratics."""
    step = 2 * np.pi / pieces
    segments = []
    for index in range(pieces):
        start, end = np.exp(1j * step * index), np.exp(1j * step * (index + 1))
        if degree == 3:
            reach = 4 / 3 * np.tan(step / 4)
            numbers = [start, start * (1 + 1j * reach), end * (1 - 1j * reach), end]
        else:
            numbers = [start, np.exp(1j * step * (index + 0.5)) / np.cos(step / 2), end]
        segments.append([(radius * each.real, radius * each.imag) for each in numbers])
    return curve([CUBIC if degree == 3 else QUADRATIC] * pieces, segments, True)


def regular(corners: int, radius: float) -> Outline:
    """A regular polygon."""
    angle = 0.1 + np.arange(corners) * 2 * np.pi / corners
    return polygon(radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def part_of(outline: Outline, count: int) -> Outline:
    """The first segments of an outline, open."""
    starts = np.array([0, count], np.int32)
    return Outline(outline.kind[:count], outline.coords[:count], starts, np.array([False]))


def together(*shapes: Outline, style: Style = BLACK, similarity: float = 1.0) -> Observation:
    """What is seen of three copies of each shape: as drawn, and turned, scaled and mirrored."""
    random = np.random.default_rng(3)
    elements = []
    for row, shape in enumerate(shapes):
        for column in range(3):
            place = [10.0 + 30 * column, 10.0 + 20 * row, 0.0, 1.0, 1.0]
            if column:
                place[2:] = [random.uniform(-180, 180), random.uniform(0.5, 2), (-1.0) ** column]
            elements += copies(shape, np.array([place]), style)
    return observe(drawing(elements), similarity=similarity)


def same_class(observed: Observation) -> None:
    """All elements are one class, which gives the drawing back."""
    assert len(observed.classes) == 1
    assert observed.error.max() <= observed.tolerance
    assert compare(observed.drawing, rebuilt(observed)).agrees(3e-7)


LEAF = leaf()
FIRST, SECOND = halves(LEAF.coords[1].tolist(), 0.37)
LEAF_OF_FOUR = curve(
    [CUBIC, CUBIC, CUBIC, LINE], [LEAF.coords[0], FIRST, SECOND, LEAF.coords[2, :2]], True
)
EXTRA_CORNERS = polygon([(-1.5, 0), (-1.5, -2), (0, -2), (1.5, -2), (1.5, 2), (-1.5, 2)])
RECTANGLE_OF_CUBICS = curve(
    [CUBIC] * 4,
    [[a, 0.7 * a + 0.3 * b, 0.2 * a + 0.8 * b, b] for a, b in rectangle(3, 4).coords[:, :2]],
    True,
)
OBLIQUE = np.array([(0.123456, 0.7), (3.1, 4.2), (7.3, 1.1)])
MIDDLE = np.round(0.3 * OBLIQUE[0] + 0.7 * OBLIQUE[1], 6)
ARCH = curve([QUADRATIC, LINE], [[(0, 0), (2, 3), (5, 0)], [(5, 0), (0, 0)]], True)
ARCH_OF_CUBIC = curve([CUBIC, LINE], [[(0, 0), (4 / 3, 2), (3, 2), (5, 0)], [(5, 0), (0, 0)]], True)
WRITTEN = {
    "rectangle with points on its sides": (rectangle(3, 4), EXTRA_CORNERS),
    "rectangle from another corner, backwards": (
        rectangle(3, 4),
        restarted(EXTRA_CORNERS, 2, True),
    ),
    "rectangle of straight cubics": (rectangle(3, 4), RECTANGLE_OF_CUBICS),
    "cubic in two": (LEAF, LEAF_OF_FOUR, restarted(LEAF_OF_FOUR, 2)),
    "quadratic as cubic": (ARCH, ARCH_OF_CUBIC),
    "circle of arcs": (circle(3), circle(3, 4), circle(3, 2, 0.7)),
    "half a circle": tuple(part_of(circle(3, 2 * n), n) for n in (1, 2, 3)),
    "circle of sixteen cubics": (circle(1), round_curves(16, 1)),
    "small circle of four cubics": (circle(0.03), round_curves(4, 0.03), round_curves(8, 0.03)),
    "side in two, to six decimals": (
        polygon(OBLIQUE),
        polygon([OBLIQUE[0], MIDDLE, OBLIQUE[1], OBLIQUE[2]]),
    ),
    "washer": (
        compound(circle(5, 4), round_curves(16, 0.5)),
        compound(circle(0.5), circle(5, 2, 0.3)),
    ),
}


@pytest.mark.parametrize("name", WRITTEN)
def test_one_curve_is_one_class_however_written(name: str) -> None:
    """Segments, start and direction are no property of a shape."""
    same_class(together(*WRITTEN[name]))


def test_a_straight_cubic_is_a_line() -> None:
    """Of equal length, of course."""
    cubic = curve([CUBIC], [[(0, 0), (1, 0), (3, 0), (5, 0)]], False)
    pieces = polygon([(0, 0), (2, 0), (5, 0)], closed=False)
    elements = [each for shape in (line(5), cubic, pieces) for each in copies(shape, ROW)]
    observed = observe(drawing(elements))
    assert [each.kind for each in observed.classes] == ["line"]
    same_class(observed)


ROW = np.array([[10.0, 10.0, 0.0, 1.0, 1.0], [30.0, 40.0, 25.0, 1.0, -1.0]])


def test_dashes_keep_their_start_through_rewriting() -> None:
    """A dashed curve may be cut otherwise, but not begin elsewhere."""
    same_class(together(LEAF, LEAF_OF_FOUR, style=DASHED))
    assert len(together(LEAF, restarted(LEAF_OF_FOUR, 1), style=DASHED).classes) == 2


def test_ends_show_where_there_is_a_stroke() -> None:
    """A stroked triangle that returns to its start without closing has caps there."""
    corners = [(0.0, 0.0), (3.0, 1.0), (2.0, 5.0)]
    back = polygon([*corners, corners[0]], closed=False)
    assert len(together(polygon(corners), back, style=STROKED).classes) == 2


def test_a_line_there_and_back_is_not_shortened() -> None:
    """A corner that turns round is on the line, but the line goes on past its end."""
    spike = polygon([(0, 0), (6, 0), (4, 0), (4, 3)], closed=False)
    bent = polygon([(0, 0), (4, 0), (4, 3)], closed=False)
    assert len(together(spike, bent).classes) == 2


NEAR = {
    "circle of four cubics": (circle(3), round_curves(4, 3)),
    "circle of eight quadratics": (circle(3), round_curves(8, 3, 2)),
    "circle of 64 sides": (circle(3), regular(64, 3)),
    "corner moved by 1e-5 of the diagonal": (
        polygon([(0, 0), (4, 1), (5, 4), (0, 9)]),
        polygon([(0, 0), (2, 0.5), (4, 1), (5, 4.0014), (0, 9)]),
    ),
    "point beside its side": (
        rectangle(3, 4),
        polygon([(0, 0), (1.5, 1e-3), (3, 0), (3, 4), (0, 4)]),
    ),
    "almost a straight cubic": (
        line(5),
        curve([CUBIC], [[(0, 0), (1, 0), (3, 1e-3), (5, 0)]], False),
    ),
    "washers": (
        compound(circle(5, 4), circle(1)),
        compound(circle(5, 2), at(round_curves(16, 1), 1e-3, 0)),
    ),
}


@pytest.mark.parametrize("name", NEAR)
def test_near_but_different_curves_are_apart(name: str) -> None:
    """Beyond the tolerance nothing is merged unless similarity is asked for."""
    one, other = NEAR[name]
    observed = together(one, other)
    assert not set(observed.shape[:3]) & set(observed.shape[3:])
    assert compare(observed.drawing, rebuilt(observed)).agrees(3e-7)


def test_many_near_shapes_neither_merge_nor_split() -> None:
    """Sixty quadrilaterals that differ by 1e-4 of the diagonal, each written in three ways."""
    elements = []
    random = np.random.default_rng(5)
    for number in range(60):
        corners = np.array([(0, 0), (6, 1), (7, 5), (1, 8 + 0.0142 * number)])
        middle = (corners[1] + corners[2]) / 2
        more = np.insert(corners, 2, middle, axis=0)
        ways = polygon(corners), polygon(more), restarted(polygon(more), 3, True)
        for way in ways:
            place = np.array([[*random.uniform(0, 90, 2), random.uniform(0, 360), 1.0, 1.0]])
            elements += copies(way, place)
    shape = observe(drawing(elements)).shape.reshape(60, 3)
    assert (shape == shape[:, :1]).all()
    assert len(np.unique(shape)) == 60


def test_rewriting_keeps_every_point() -> None:
    """Joined segments run where the given ones did."""
    for shape in (EXTRA_CORNERS, LEAF_OF_FOUR, circle(3, 4), RECTANGLE_OF_CUBICS):
        given = stack([shape])
        made = fewest_segments(given, np.array([False]), np.array([LIMIT * 8]), 0.0)
        assert made.counts[0] < given.counts[0] or shape is RECTANGLE_OF_CUBICS
        rewritten = Outline(
            made.kind,
            np.stack([made.points.real, made.points.imag], axis=-1),
            np.array([0, len(made.kind)], np.int32),
            shape.closed,
        )
        one, other = (drawing(copies(each, ROW[:1])) for each in (shape, rewritten))
        assert compare(one, other).agrees(1e-8)


CLASSES = {"cad_lego": 22, "cad_packed_boxes": 82, "mandala": 26, "map_usa_counties": 3219}


@pytest.mark.parametrize("name", CLASSES)
def test_real_drawings_keep_their_classes(name: str) -> None:
    """Where programs wrote one way only, there is nothing to merge."""
    observed = real_drawings.observed(name)
    assert len(observed.classes) == CLASSES[name]
    assert observed.error.max() <= observed.tolerance * (1 + 1e-9)
