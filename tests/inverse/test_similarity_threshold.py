"""How similar shapes are, measured, and what a threshold makes one class."""

from __future__ import annotations

import numpy as np
import pytest
from inverse.synth import (
    STROKED,
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
    star,
)
from inverse.test_similarity import ROW, regular, round_curves, together

from ipmlang.formats.drawing import Floats, Outline
from ipmlang.inverse.compare import compare
from ipmlang.inverse.lsystem.curvature import sample
from ipmlang.inverse.lsystem.curves import moved
from ipmlang.inverse.lsystem.frames import frames
from ipmlang.inverse.lsystem.similarity import match
from ipmlang.inverse.observation import observe

HOOK = polygon([(0, 0), (1, 0), (1, 5), (6, 5), (6, 6), (0, 6)])
SLANT = polygon([(0, 0), (4.1, 1.3), (5.2, 3.7), (0.4, 9.9)])
ZIGZAG = polygon([(0, 0), (1, 2), (3, -1), (4, 3), (7, 0)], closed=False)
SHAPES = {
    "star": star(5),
    "rectangle": rectangle(3, 4),
    "leaf": leaf(),
    "slant": SLANT,
    "hook": HOOK,
    "zigzag": ZIGZAG,
    "circle": circle(2),
    "gear": compound(star(8), circle(1, 4)),
}


def similarities(lead: Outline, *others: Outline) -> Floats:
    """How similar others are to a shape."""
    return match(sample([lead, *others]), 0, np.arange(1, len(others) + 1), False).similarity


def anywhere(shape: Outline, random: np.random.Generator) -> Outline:
    """The shape placed at random, mirrored or not, begun at another corner if it is closed."""
    place = frames(
        np.array(complex(*random.uniform(-9, 9, 2))),
        random.uniform(-180, 180),
        random.uniform(0.2, 4),
        int(random.choice([-1, 1])),
    )
    if len(shape.closed) == 1 and shape.closed.all():
        shape = restarted(shape, int(random.integers(len(shape.kind))), bool(random.integers(2)))
    return moved(shape, place)


def drawn_by_hand(shape: Outline, noise: float, random: np.random.Generator) -> Outline:
    """A polygon through 200 points along another one, each off by `noise` of its radius."""
    corners = np.vstack([shape.coords[:, 0], shape.coords[:1, 0]])
    along = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    at = np.sort(random.uniform(0, along[-1], 200))
    points = np.stack([np.interp(at, along, corners[:, axis]) for axis in (0, 1)], axis=1)
    return polygon(points + random.normal(0, noise * radius(shape), points.shape))


def with_moved_corners(shape: Outline, noise: float, random: np.random.Generator) -> Outline:
    """The polygon with each corner off by `noise` of its radius."""
    corners = shape.coords[:, 0]
    return polygon(corners + random.normal(0, noise * radius(shape), corners.shape))


def radius(shape: Outline) -> float:
    """The root-mean-square distance of corners from their centre."""
    corners = shape.coords[:, 0]
    return float(np.sqrt(np.mean(np.sum((corners - corners.mean(axis=0)) ** 2, axis=1))))


@pytest.mark.parametrize("name", SHAPES)
def test_placement_hardly_shows(name: str) -> None:
    """Under rotation, scale, mirroring, another start and direction shapes stay similar."""
    random = np.random.default_rng(1)
    found = similarities(SHAPES[name], *(anywhere(SHAPES[name], random) for _ in range(40)))
    assert found.min() > 0.93


ROUND = {
    # What is a circle: least and largest similarity to one.
    "four cubics": (round_curves(4, 2), 0.999, 1.0),
    "eight quadratics": (round_curves(8, 2, 2), 0.99, 1.0),
    "64 sides": (regular(64, 2), 0.999, 1.0),
    "32 sides": (regular(32, 2), 0.99, 1.0),
    "16 sides": (regular(16, 2), 0.85, 0.98),
    "12 sides": (regular(12, 2), 0.6, 0.9),
    "8 sides": (regular(8, 2), 0.0, 0.55),
    "6 sides": (regular(6, 2), 0.0, 0.4),
    "a square": (rectangle(3, 3), 0.0, 0.2),
    "a star": (star(5), 0.0, 0.2),
}


@pytest.mark.parametrize("name", ROUND)
def test_what_is_a_circle(name: str) -> None:
    """A polygon is similar to a circle from about sixteen sides on, eight are too few."""
    shape, least, largest = ROUND[name]
    (found,) = similarities(circle(2), shape)
    assert least <= found <= largest + 1e-9


# Shape and noise, in radii: median similarity of twenty copies of which each point along the curve
# is off, and of twenty of which each corner is. Measured; a change of the method shows here.
BY_HAND = {
    ("star", 0.005): (0.93, 0.99),
    ("star", 0.01): (0.85, 0.98),
    ("star", 0.02): (0.60, 0.95),
    ("rectangle", 0.005): (0.97, 1.0),
    ("rectangle", 0.01): (0.82, 1.0),
    ("rectangle", 0.02): (0.40, 0.99),
    ("slant", 0.005): (0.96, 1.0),
    ("slant", 0.01): (0.79, 1.0),
    ("slant", 0.02): (0.36, 0.99),
    ("hook", 0.005): (0.95, 1.0),
    ("hook", 0.01): (0.80, 0.99),
    ("hook", 0.02): (0.39, 0.975),
}


@pytest.mark.parametrize(("name", "noise"), BY_HAND)
def test_noise_lowers_similarity_gradually(name: str, noise: float) -> None:
    """The table of measured similarities of copies drawn by hand."""
    random, shape = np.random.default_rng(1), SHAPES[name]
    along = [drawn_by_hand(shape, noise, random) for _ in range(20)]
    corners = [with_moved_corners(shape, noise, random) for _ in range(20)]
    found = [float(np.median(similarities(shape, *copies))) for copies in (along, corners)]
    assert found == pytest.approx(BY_HAND[name, noise], abs=0.06)


@pytest.mark.parametrize(("height", "similar"), [(3.95, True), (3.5, True), (6, False)])
def test_the_threshold_decides(height: float, similar: bool) -> None:
    """Rectangles of about the same proportions are one class at the paper's 0.6."""
    shapes = rectangle(3, 4), rectangle(3, height)
    assert len(together(*shapes).classes) == 2
    assert len(together(*shapes, similarity=0.6).classes) == (1 if similar else 2)


def test_stricter_thresholds_make_more_classes() -> None:
    """Seven proportions: all apart, some together, more together."""
    shapes = [rectangle(3, 4 + 0.25 * step) for step in range(7)]
    counts = [len(together(*shapes, similarity=value).classes) for value in (1, 0.98, 0.9, 0.6)]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] == 7
    assert counts[-1] < 4


def test_other_shapes_stay_apart_at_the_papers_threshold() -> None:
    """Nine shapes that nobody would call alike, in three copies each."""
    shapes = [*SHAPES.values(), star(6), star(7), regular(6, 3), rectangle(3, 9), rectangle(3, 3)]
    observed = together(*shapes, similarity=0.6)
    assert len(observed.classes) == len(shapes)
    assert compare(observed.drawing, rebuilt(observed)).agrees(3e-7)


def test_the_deviation_is_reported() -> None:
    """`error` is the largest distance between the class's shape in its frame and the element."""
    observed = together(circle(3), regular(32, 3), similarity=0.6)
    assert len(observed.classes) == 1
    again = rebuilt(observed)
    assert observed.classes[0].kind == "ellipse"
    measured = compare(observed.drawing, again).max_error * observed.diagonal
    assert observed.error.max() == pytest.approx(measured, rel=0.05)
    sagitta = 3 * (1 - np.cos(np.pi / 32))
    assert 0.3 * sagitta < observed.error[3] < 2 * sagitta


def test_noisy_copies_are_one_class_of_the_clean_shape() -> None:
    """Sixty stars drawn by hand and sixty hooks, each with one clean one used twice."""
    random = np.random.default_rng(4)
    elements = []
    for shape in (star(5, 4.0, 1.6), HOOK):
        elements += copies(shape, ROW)
        for _ in range(60):
            noisy = drawn_by_hand(shape, 0.005, random)
            place = np.array([[*random.uniform(5, 95, 2), random.uniform(0, 360), 0.7, -1.0]])
            elements += copies(noisy, place)
    drawn = drawing(elements)
    observed = observe(drawn, similarity=0.6)
    assert [len(each.members) for each in observed.classes] == [62, 62]
    outline = observed.classes[1].outline
    assert outline is not None
    assert len(outline.kind) == 6
    assert observed.error.max() < 0.3
    again = observe(drawn, similarity=0.6)
    assert observed.frames.x.tobytes() == again.frames.x.tobytes()


def test_rounded_coordinates_are_similar() -> None:
    """Copies at two decimals are no longer equal, but next to."""
    random = np.random.default_rng(2)
    elements = []
    for _ in range(12):
        shape = anywhere(SLANT, random)
        rounded = np.round(shape.coords[:, 0] * 3 + 50, 2)
        elements += copies(polygon(rounded), np.array([[0.0, 0.0, 0.0, 1.0, 1.0]]))
    drawn = drawing(elements)
    assert len(observe(drawn).classes) > 6
    assert len(observe(drawn, similarity=0.95).classes) == 1


def test_open_and_closed_curves_are_not_similar() -> None:
    """However near the ends of the open one are."""
    ends = np.append(SLANT.coords[:, 0], [[0.05, 0.0]], axis=0)
    gap = polygon(ends, closed=False)
    assert len(together(SLANT, gap, style=STROKED, similarity=0.6).classes) == 2


def test_lines_keep_their_lengths() -> None:
    """All lines are similar, so similarity says nothing about them."""
    observed = observe(drawing(copies(line(5), ROW) + copies(line(5.5), ROW)), similarity=0.6)
    assert len(observed.classes) == 2
