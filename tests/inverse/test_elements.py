"""Elements grouped by shape: what is one class, in which frame, and with which symmetries."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from inverse.synth import (
    BLACK,
    STROKED,
    at,
    circle,
    compound,
    copies,
    drawing,
    grid,
    leaf,
    line,
    mirror_cell,
    polygon,
    rebuilt,
    rectangle,
    restarted,
    ring,
    row,
    scaled,
    star,
)

from ipmlang.formats.drawing import Drawing, DrawnElement, Floats, Fragment, Outline, Style
from ipmlang.inverse.compare import compare
from ipmlang.inverse.lsystem.curves import moved
from ipmlang.inverse.lsystem.frames import compose, frames, identity, inverse
from ipmlang.inverse.lsystem.symmetry import alternatives
from ipmlang.inverse.observation import Observation, observe
from tests import real_drawings

ARROW = polygon([(0, 0), (-3, 2), (-1, 0), (-3, -2)])  # one mirror, along x
WAVE = polygon([(-3, 0), (-1, 2), (1, -2), (3, 0)], closed=False)  # a half turn, no mirror


def scattered(count: int, seed: int = 1) -> Floats:
    """Placements anywhere, turned, scaled and mirrored at random."""
    random = np.random.default_rng(seed)
    placed = np.empty((count, 5))
    placed[:, :2] = random.uniform(0, 100, (count, 2))
    placed[:, 2] = random.uniform(-180, 180, count)
    placed[:, 3] = random.uniform(0.3, 3.0, count)
    placed[:, 4] = random.choice([-1, 1], count)
    return placed


def seen(*elements: list[DrawnElement], box: bool = True) -> Observation:
    """What is seen of the elements, proven to be what was drawn."""
    drawn = drawing([each for part in elements for each in part], *([] if box else [None]))
    observed = observe(drawn)
    result = compare(drawn, rebuilt(observed))
    assert result.agrees(3e-7), result
    assert observed.error.max() <= observed.tolerance * (1 + 1e-9)
    return observed


@pytest.mark.parametrize("shape", [leaf(), ARROW, WAVE, star(5), rectangle(3, 4), circle(3, 4)])
def test_one_class_whatever_the_placement(shape: Outline) -> None:
    """Turning, scaling, moving and mirroring leave a shape in its class."""
    observed = seen(copies(shape, scattered(60)))
    assert len(observed.classes) == 1
    assert observed.classes[0].members.tolist() == list(range(60))


def test_frames_are_those_of_the_arrangement() -> None:
    """Relative to the first copy, frames are those that placed the copies, y turned up."""
    placed = scattered(20)
    hand = placed[:, 4].astype(np.int8)
    wanted = frames(placed[:, 0] + 1j * (100 - placed[:, 1]), -placed[:, 2], placed[:, 3], hand)
    observed = seen(copies(leaf(), placed))
    steps = compose(observed.frames, inverse(observed.frames[:1]))
    true = compose(wanted, inverse(wanted[:1]))
    assert steps.handedness.tolist() == true.handedness.tolist()
    np.testing.assert_allclose(steps.factor, true.factor, atol=1e-8)


@pytest.mark.parametrize("first", [0, 1, 2])
@pytest.mark.parametrize("backwards", [False, True])
def test_start_and_direction_do_not_matter(first: int, backwards: bool) -> None:
    """A closed curve may begin anywhere and run either way."""
    again = restarted(leaf(), first, backwards)
    observed = seen(copies(leaf(), scattered(5)), copies(again, scattered(5, seed=2)))
    assert len(observed.classes) == 1


def test_open_curves_run_either_way() -> None:
    """An open curve and its reverse are one class."""
    corners = [(0.0, 0.0), (4.0, 1.0), (5.0, 3.0), (5.0, 9.0)]
    there, back = polygon(corners, closed=False), polygon(corners[::-1], closed=False)
    assert len(seen(copies(there, scattered(4)), copies(back, scattered(4, 2))).classes) == 1


@pytest.mark.parametrize(
    ("shape", "order", "axis"),
    [
        (leaf(), 1, None),
        (WAVE, 2, None),
        (ARROW, 1, 0.0),
        (rectangle(3, 4), 2, 0.0),
        (rectangle(3, 3), 4, 0.0),
        (star(5), 5, 0.0),
        (star(7), 7, 0.0),
        (polygon([(0, 3), (-1, 0), (1, 0)]), 1, 90.0),
        (circle(2), 0, 0.0),
        (circle(2, pieces=3), 0, 0.0),
        (line(5), 2, 0.0),
    ],
)
def test_symmetry_groups(shape: Outline, order: int, axis: float | None) -> None:
    """Each shape's own rotations and mirrors are found."""
    symmetry = seen(copies(shape, row(2, (20, 0)))).classes[0].symmetry
    assert symmetry.order == order
    if axis is None:
        assert symmetry.axis is None
    else:
        assert symmetry.axis == pytest.approx(axis, abs=1e-9)


@pytest.mark.parametrize("shape", [WAVE, ARROW, rectangle(3, 4), star(6), line(5), circle(2)])
def test_alternatives_draw_the_same(shape: Outline) -> None:
    """All frames of an element that are called equivalent give that element back."""
    observed = seen(copies(shape, ring(6, 30, (50, 50))))
    every = alternatives(observed.frames, observed.classes[0].symmetry)
    assert every.x.shape[1] > 1
    for column in range(every.x.shape[1]):
        other = rebuilt(replace(observed, frames=every[:, column]))
        assert compare(observed.drawing, other).agrees(1e-9)


def test_frames_are_plain_where_they_can_be() -> None:
    """Most frequent size has scale 1; turns of a symmetric shape are the smallest; right angles
    and unit scales are exact.
    """
    squares = copies(rectangle(4, 4), scaled(3, 8, 0.5)) + copies(rectangle(4, 4), row(5, (9, 0)))
    observed = seen(squares)
    assert np.count_nonzero(observed.frames.scale == 1.0) == 6
    assert set(observed.frames.angle.tolist()) == {0.0}
    turned = seen(copies(leaf(), ring(12, 20, (50, 50))))
    assert np.allclose(turned.frames.angle % 30, 0, atol=0)
    assert (turned.frames.handedness == 1).all()


def test_moved_copies_keep_the_decimals_of_the_input() -> None:
    """A shape without symmetry is placed at positions no longer than its coordinates."""
    corners = [(0.0, 0.0), (4.1, 1.3), (5.2, 3.7), (0.4, 9.9)]
    observed = seen(copies(polygon(corners), row(9, (7.3, 1.1))))
    assert observed.precision == 1
    np.testing.assert_allclose(observed.frames.x, np.round(observed.frames.x, 1), atol=1e-11)
    assert observed.classes[0].outline is not None
    coords = observed.classes[0].outline.coords
    np.testing.assert_allclose(coords, np.round(coords, 1), atol=1e-11)


def test_mirrored_cell_is_told_by_handedness() -> None:
    """Copies that only a mirror explains have handedness -1, and no others."""
    observed = seen(copies(leaf(), mirror_cell(row(4, (0, 20)), 50)))
    assert observed.frames.handedness.tolist() == [1] * 4 + [-1] * 4


def test_lines_are_classed_by_length() -> None:
    """All lines are similar, so length tells them apart; the frame runs from start to end."""
    observed = seen(copies(line(5), ring(6, 30)), copies(line(7), ring(6, 20)))
    assert [each.radius for each in observed.classes] == [5.0, 7.0]
    assert observed.classes[0].kind == "line"
    np.testing.assert_allclose(observed.frames.angle[:3], [0, -60, -120], atol=1e-12)
    assert (observed.frames.scale == 1).all()


def test_style_is_apart_from_shape() -> None:
    """One class holds several styles, and one style several classes."""
    observed = seen(
        copies(leaf(), row(2, (20, 0)), BLACK), copies(leaf(), row(2, (0, 20)), STROKED)
    )
    assert len(observed.classes) == 1
    assert observed.style.tolist() == [0, 0, 1, 1]
    assert observed.styles == (BLACK, STROKED)


def test_dashes_fix_start_and_direction() -> None:
    """Where dashes begin shows, so a dashed curve is not the same from another start."""
    dashed = replace(STROKED, dashes=(2.0, 1.0))
    square = rectangle(8, 8)
    observed = seen(copies(square, row(2, (20, 0)), dashed))
    assert observed.classes[0].directed
    assert len(observed.classes[0].symmetry.stabiliser) == 1
    again = observe(
        drawing(
            copies(restarted(leaf(), 1), row(1, (0, 0)), dashed)
            + copies(leaf(), row(1, (30, 0)), dashed)
        )
    )
    assert len(again.classes) == 2


@pytest.mark.parametrize(("off", "classes"), [(1e-9, 1), (1e-7, 1), (3e-6, 2), (1e-4, 2)])
def test_shapes_are_merged_up_to_the_tolerance_only(off: float, classes: int) -> None:
    """A corner moved by a share of the diagonal splits the class once the share is too large."""
    corners = np.array([(0.0, 0.0), (4.1, 1.3), (5.2, 3.7), (0.4, 9.9)])
    bent = corners.copy()
    bent[2, 0] += off * np.hypot(100, 100)
    observed = seen(
        copies(polygon(corners), row(2, (20, 0))), copies(polygon(bent), row(2, (0, 20)))
    )
    assert len(observed.classes) == classes


def test_near_symmetry_is_no_symmetry() -> None:
    """A rectangle that is almost a square is not turned by a quarter."""
    side = 10 + 1e-4
    observed = seen(copies(rectangle(10, side), row(3, (20, 0))))
    assert observed.classes[0].symmetry.order == 2


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.integers(3, 12), st.booleans())
def test_random_shapes_neither_split_nor_merge(seed: int, corners: int, closed: bool) -> None:
    """Forty random outlines in five copies each, with the noise of arithmetic: forty classes."""
    random = np.random.default_rng(seed)
    shapes = [polygon(random.uniform(-5, 5, (corners, 2)), closed) for _ in range(40)]
    elements = [
        element
        for number in range(5)
        for shape in shapes
        for element in copies(shape, scattered(1, seed + number))
    ]
    observed = observe(drawing(elements))
    assert len(observed.classes) == 40
    assert all(len(each.members) == 5 for each in observed.classes)
    assert (observed.shape.reshape(5, 40) == np.arange(40)).all()


WASHER = compound(circle(5, 4), circle(3, 4))
GEAR = compound(star(8), circle(1, 4))
FACE = compound(circle(5, 4), at(circle(1), 2, 2), at(circle(1), -2, 2), at(rectangle(3, 1), 0, -2))


@pytest.mark.parametrize(
    ("one", "other", "order", "mirrored"),
    [
        (WASHER, compound(circle(3, 2, 0.4), circle(5, 3, 0.1)), 0, True),
        (GEAR, compound(circle(1, 2, 0.5), at(star(8), 0, 0, 45)), 8, True),
        (
            FACE,
            compound(
                circle(5),
                at(circle(1), -2, 2),
                at(rectangle(3, 1), 0, -2, 180),
                at(circle(1), 2, 2),
            ),
            1,
            True,
        ),
        (compound(at(line(4), -2, 0), at(line(4), 0, -2, 90)),) * 2 + (4, True),
        (compound(at(leaf(1), 3, 0), at(leaf(1), -3, 0, 180)),) * 2 + (2, False),
    ],
    ids=["washer", "gear", "face", "cross", "pair"],
)
def test_compounds_are_matched_part_by_part(
    one: Outline, other: Outline, order: int, mirrored: bool
) -> None:
    """The order and starts of subpaths do not matter, and parts may change places."""
    observed = seen(copies(one, scattered(5)), copies(other, scattered(5, 2)))
    assert len(observed.classes) == 1
    symmetry = observed.classes[0].symmetry
    assert symmetry.order == order
    assert (symmetry.axis is not None) == mirrored
    every = alternatives(observed.frames, symmetry)
    for column in range(every.x.shape[1]):
        again = rebuilt(replace(observed, frames=every[:, column]))
        assert compare(observed.drawing, again).agrees(3e-7)


def test_other_compounds_are_other_classes() -> None:
    """The same parts in another arrangement are another shape."""
    one = compound(at(leaf(2), 0, 0), at(leaf(2), 5, 0))
    other = compound(at(leaf(2), 0, 0), at(leaf(2), 5, 0.01))
    observed = seen(copies(one, row(2, (20, 0))), copies(other, row(2, (0, 20), (0, 20))))
    assert len(observed.classes) == 2


def test_ellipses_by_proportion() -> None:
    """Circles of all sizes and cuts are one class, each other proportion is one more."""
    oval = circle(1.0)
    oval.coords[0, 2] *= 0.5
    observed = seen(
        copies(circle(2, 4, 0.3), row(2, (9, 0))),
        copies(circle(5, 2), row(2, (9, 9))),
        copies(oval, scattered(5)),
    )
    assert [each.kind for each in observed.classes] == ["ellipse", "ellipse"]
    assert [each.symmetry.order for each in observed.classes] == [0, 2]
    assert observed.frames.scale[:4].tolist() == [1.0, 1.0, 2.5, 2.5]


def test_fragments_points_and_empty_outlines_are_kept() -> None:
    """Every element has a row, whatever it is."""
    text = Fragment("text", "<text>hello</text>", (1, 0, 0, 1, 5, 5))
    empty = Outline(
        np.zeros(0, np.uint8), np.zeros((0, 4, 2)), np.zeros(1, np.int32), np.zeros(0, np.bool_)
    )
    elements = [
        DrawnElement(None, BLACK, text, ("label",)),
        *copies(line(0.0), row(2, (5, 5))),
        DrawnElement(empty, BLACK),
        *copies(leaf(), row(2, (20, 0))),
    ]
    observed = observe(drawing(elements))
    kinds = [observed.classes[number].kind for number in observed.shape]
    assert kinds == ["fragment", "point", "point", "point", "path", "path"]
    assert observed.sources[0] == ("label",)
    assert observed.z.tolist() == list(range(6))
    assert compare(observed.drawing, rebuilt(observed)).agrees()


def test_an_empty_drawing() -> None:
    """Nothing drawn, nothing seen."""
    observed = observe(Drawing(()))
    assert len(observed) == 0
    assert observed.classes == ()
    assert observed.diagonal == 1.0


def test_observing_twice_gives_the_same() -> None:
    """No order of hashes or threads shows."""
    drawn = drawing(copies(star(5), scattered(50)) + copies(leaf(), grid(5, 5, (9, 1), (0, 8))))
    first, second = observe(drawn), observe(drawn)
    assert first.shape.tobytes() == second.shape.tobytes()
    assert first.frames.angle.tobytes() == second.frames.angle.tobytes()


def test_canvas_turns_y_up() -> None:
    """y of the model is c - y of the file with c = 2 vy + vh, without a box -y."""
    placed = row(2, (3, 4), (10, 20))
    boxed = observe(drawing(copies(line(5), placed), (0, 10, 100, 80)))
    assert boxed.flip == 100
    assert boxed.frames.y.tolist() == [80.0, 76.0]
    free = observe(drawing(copies(line(5), placed), None))
    assert free.frames.y.tolist() == [-20.0, -24.0]
    assert free.diagonal == pytest.approx(np.hypot(8, 4))


@pytest.mark.parametrize(("decimals", "precision"), [(0, 0), (2, 2), (6, 6), (12, 17)])
def test_precision_is_that_of_the_numbers(decimals: int, precision: int) -> None:
    """The decimals of the coordinates, up to nine."""
    corners = np.round(np.random.default_rng(3).uniform(0, 100, (50, 2)), decimals)
    assert observe(drawing([DrawnElement(polygon(corners), Style())])).precision == precision


def test_moving_an_outline_and_back() -> None:
    """A frame and its inverse leave every kind of segment where it was."""
    shape = leaf()
    turned = frames(np.array([3 + 4j]), 37.0, 2.5, -1)
    back = moved(moved(shape, turned[0]), inverse(turned)[0])
    np.testing.assert_allclose(back.coords, shape.coords, atol=1e-12)
    assert len(identity(0)) == 0


def test_copies_of_lines_stay_together_among_similar_lengths() -> None:
    """Eight copies of each of many lines, rounded as files are: copies share a class, though other
    lengths lie as near as the tolerance.
    """
    random = np.random.default_rng(5)
    ends = np.cumsum(random.uniform(1.5e-4, 9e-4, 200)) + 5
    elements = [
        element
        for _ in range(8)
        for end in ends + random.uniform(-1e-5, 1e-5, 200)
        for element in copies(line(float(end)), scattered(1))
    ]
    observed = observe(drawing(elements, (0, 0, 600, 800)))
    shape = observed.shape.reshape(8, 200)
    assert observed.tolerance == pytest.approx(2e-4)
    assert (shape == shape[0]).all()


CLASSES = {
    # name: (most classes beside text, elements of the largest): what the picture shows.
    "lsys_dragon": (2, 8192),
    "lsys_plant": (2, 6048),
    "lsys_plant_stochastic": (2, 6048),
    "flag_eu": (2, 120),
    "flag_uz": (6, 120),
    "flag_ve": (5, 80),
    "batik_cards": (6, 81),
    "batik_symbolViewBox": (16, 160),
    "pcb_moire": (3, 6),
    "cad_packed_boxes": (90, 39),
    "cad_line_types": (50, 78),
    "vega_small_multiples": (12, 244),
    "vpype_halftone": (8, 1180),
}


@pytest.mark.parametrize("name", sorted(CLASSES))
def test_classes_of_real_drawings(name: str) -> None:
    """Real drawings have the shapes that they show, and placing them gives the drawing back."""
    observed = real_drawings.observed(name)
    most, largest = CLASSES[name]
    sizes = [len(each.members) for each in observed.classes if each.kind != "fragment"]
    assert len(sizes) <= most
    assert max(sizes) >= largest
    assert compare(observed.drawing, rebuilt(observed)).agrees(3e-7)


@pytest.mark.parametrize("name", ["map_usa_counties", "vpype_7k_lines", "batik_mapSpain"])
def test_unstructured_drawings_stay_so(name: str) -> None:
    """Where nothing repeats, next to nothing is merged."""
    observed = real_drawings.observed(name)
    assert len(observed.classes) > 0.8 * len(observed)
    assert compare(observed.drawing, rebuilt(observed)).agrees(3e-7)


def test_the_eight_skulls_share_their_lines() -> None:
    """8744 loose lines are eight copies of one drawing, four of them mirrored."""
    shape = real_drawings.observed("vpype_multi_skull").shape.reshape(8, -1)
    assert (shape == shape[0]).all()
