"""Path data against svgpathtools as an oracle, and the corners where SVG is exact about it."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from ipmlang.formats.drawing import ARC, CUBIC, LINE, QUADRATIC, Floats, Outline
from ipmlang.formats.svg.bounds import outline_box, place, segment_ends
from ipmlang.formats.svg.paths import parse_path

TIMES = np.linspace(0, 1, 7)


def points(outline: Outline) -> Floats:
    """(n, 7, 2) points of the segments at equal parameters."""
    rows = []
    for kind, coords in zip(outline.kind, outline.coords, strict=True):
        t, s = TIMES[:, None], 1 - TIMES[:, None]
        a, b, c, d = coords
        if kind == LINE:
            rows.append(s * a + t * b)
        elif kind == QUADRATIC:
            rows.append(s * s * a + 2 * s * t * b + t * t * c)
        elif kind == CUBIC:
            rows.append(s**3 * a + 3 * s * s * t * b + 3 * s * t * t * c + t**3 * d)
        else:
            angle = d[0] + d[1] * t
            rows.append(a + b * np.cos(angle) + c * np.sin(angle))
    return np.array(rows)


def drawn(text: str) -> Outline:
    """The outline of path data that is right."""
    data = parse_path(text)
    assert data.whole
    assert data.outline is not None
    return data.outline


def random_path(seed: int) -> str:
    """Path data with every command, absolute and relative, numbers packed as tightly as allowed."""
    rng = random.Random(seed)
    words = [f"M{rng.uniform(-9, 9):.3f} {rng.uniform(-9, 9):.3f}"]
    for _ in range(30):
        letter = rng.choice("lhvcsqta")
        count = {"l": 2, "h": 1, "v": 1, "c": 6, "s": 4, "q": 4, "t": 2, "a": 2}[letter]
        numbers = " ".join(f"{rng.uniform(-9, 9):.3g}" for _ in range(count))
        if letter == "a":
            radii = f"{rng.uniform(0.1, 9):.3g} {rng.uniform(0.1, 9):.3g} {rng.randrange(360)}"
            numbers = f"{radii} {rng.randrange(2)} {rng.randrange(2)} {numbers}"
        words.append((letter.upper() if rng.random() < 0.5 else letter) + numbers)
    return "".join(words).replace(" -", "-")


@pytest.mark.parametrize("seed", range(20))
def test_against_svgpathtools(seed: int) -> None:
    """Equal points at equal parameters, whatever the commands."""
    svgpathtools = pytest.importorskip("svgpathtools")
    text = random_path(seed)
    expected = np.array(
        [[segment.point(t) for t in TIMES] for segment in svgpathtools.parse_path(text)]
    )
    found = points(drawn(text))
    assert len(found) == len(expected)
    assert np.abs(found[..., 0] + 1j * found[..., 1] - expected).max() < 1e-9 * 50


def test_segments_join() -> None:
    """Each segment begins where the one before it ends, arcs included."""
    outline = drawn(random_path(99))
    first, last = segment_ends(outline.kind, outline.coords)
    assert np.abs(first[1:] - last[:-1]).max() < 1e-12 * 50


@pytest.mark.parametrize(
    ("text", "ends"),
    [
        ("M1-2-3.5.5", [[-3.5, 0.5]]),
        ("M0 0 1e1.5", [[10, 0.5]]),
        ("m1 1 2 2 3 3", [[3, 3], [6, 6]]),
        ("M5,5z l1,0", [[5, 5], [6, 5]]),
        ("M1 1h2v3H0V0", [[3, 1], [3, 4], [0, 4], [0, 0]]),
        ("M0 0L1 0 1 1Zm5 5h1", [[1, 0], [1, 1], [0, 0], [6, 5]]),
        ("\n M 0 , 0 L 1 , 0 ,", [[1, 0]]),
    ],
)
def test_numbers_and_repetition(text: str, ends: list[list[float]]) -> None:
    """Numbers need no blanks between them, commands repeat, closing goes back to the start."""
    outline = drawn(text)
    assert segment_ends(outline.kind, outline.coords)[1].tolist() == ends


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("M0 0L1 1 2", 1),
        ("M0 0L1 1,,2 2", 1),
        ("M0 0L1 1 Q1 1", 1),
        ("M0 0H5 x", 1),
        ("M0 0h1a1 1 0 2 0 1 1", 1),
        ("L1 1", 0),
        ("M0 0L1 1 Z 5", 2),
        ("M,1 1 2 2", 0),
        ("M0 0L 1 nan", 0),
        ("rubbish", 0),
    ],
)
def test_errors_keep_what_stands_before(text: str, count: int) -> None:
    """Whole segments before the error are kept, and the error is known."""
    data = parse_path(text)
    assert not data.whole
    assert (0 if data.outline is None else len(data.outline.kind)) == count


def test_arc_flags_need_no_blanks() -> None:
    """`00.5` after the rotation are two flags and a number."""
    packed, spaced = (
        drawn("M0 0a1 1 0 01.5.5 1 1 0 10-.5.5"),
        drawn("M0 0a1 1 0 0 1 .5 .5 1 1 0 1 0 -.5 .5"),
    )
    assert np.array_equal(packed.coords, spaced.coords)


def test_degenerate_arcs() -> None:
    """No radius is a line, no distance is nothing, too small a radius grows."""
    assert drawn("M0 0A0 5 0 0 1 3 4").kind.tolist() == [LINE]
    assert parse_path("M1 1A5 5 0 0 1 1 1").outline is None
    (grown,) = drawn("M0 0A1 1 0 0 1 6 8").coords
    assert grown[0].tolist() == [3, 4]
    assert math.hypot(*grown[1]) == pytest.approx(5)


def test_nearly_closed_arc_is_a_whole_circle() -> None:
    """The way plotter files draw a dot: a large arc whose ends nearly meet."""
    outline = drawn("M10,10 a 2 2 0 1 0 0.001 0Z")
    assert outline.kind.tolist() == [ARC, LINE]
    assert outline_box(outline) == pytest.approx((8.0005, 10, 4, 4), abs=1e-3)


def test_smooth_curves_mirror_only_their_own_kind() -> None:
    """S after something else than C or S begins at the current point."""
    after_line = drawn("M0 0L1 1S2 2 3 3").coords[1]
    after_curve = drawn("M0 0C0 0 1 0 1 1S2 2 3 3").coords[1]
    assert after_line[1].tolist() == [1, 1]
    assert after_curve[1].tolist() == [1, 2]


def test_subpaths() -> None:
    """Starts, and which subpaths close; a lone move draws nothing."""
    outline = drawn("M9 9M0 0h1v1zM5 5h1M7 7")
    assert outline.starts.tolist() == [0, 3, 4]
    assert outline.closed.tolist() == [True, False]


def test_closing_where_it_began_adds_no_line() -> None:
    """Rounding of a relative chain does not leave a crumb of a line."""
    outline = drawn("m.1.1" + "l.1 0" * 10 + "l-1.0 0z")
    assert len(outline.kind) == 11


@pytest.mark.parametrize("seed", range(5))
def test_boxes_are_exact(seed: int) -> None:
    """The box of an outline holds all its points and touches some, also when it is mapped."""
    outline = place(drawn(random_path(seed)), (0.5, 0.7, -1.2, 0.3, 4.0, 5.0))
    x, y, width, height = outline_box(outline)
    cloud = points(outline).reshape(-1, 2)
    assert (cloud >= np.array([x, y]) - 1e-9).all()
    assert (cloud <= np.array([x + width, y + height]) + 1e-9).all()


def test_box_of_curves_is_tight() -> None:
    """A cubic and an arc reach their extremes between their ends."""
    assert outline_box(drawn("M0 0C0 4 4 4 4 0")) == pytest.approx((0, 0, 4, 3))
    assert outline_box(drawn("M0 0Q2 4 4 0")) == pytest.approx((0, 0, 4, 2))
    assert outline_box(drawn("M-1 0A1 1 0 0 1 1 0")) == pytest.approx((-1, -1, 2, 1))
