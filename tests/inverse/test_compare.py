"""The comparison that proves results: what it must notice, and what it must overlook."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from inverse.synth import (
    BLACK,
    STROKED,
    circle,
    copies,
    drawing,
    grid,
    leaf,
    line,
    polygon,
    rectangle,
    restarted,
    ring,
    row,
    star,
)

from ipmlang.formats.drawing import (
    CUBIC,
    LINE,
    Drawing,
    DrawnElement,
    Effect,
    Fragment,
    Outline,
    PaintServer,
    Style,
)
from ipmlang.inverse.appearance import same_text
from ipmlang.inverse.compare import Comparison, compare
from ipmlang.inverse.lsystem.curves import moved
from ipmlang.inverse.lsystem.frames import frames

DIAGONAL = float(np.hypot(100, 100))
IDENTITY = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)


def sample() -> list[DrawnElement]:
    """A bit of everything."""
    elements = copies(leaf(), ring(7, 30, (50, 50))) + copies(star(5), grid(4, 3, (20, 3), (0, 20)))
    elements += copies(circle(3, 2), row(5, (9, 0), (5, 90))) + copies(
        line(8), ring(6, 20), STROKED
    )
    return elements + copies(rectangle(5, 3), row(4, (0, 9)), STROKED)


def against(changed: Sequence[DrawnElement]) -> Comparison:
    """The sample against a changed one."""
    return compare(drawing(sample()), drawing(changed))


def shifted(element: DrawnElement, by: complex) -> DrawnElement:
    """The element moved."""
    assert element.outline is not None
    outline = moved(element.outline, frames(np.array([by]))[0])
    return replace(element, outline=outline)


def shown(a: Outline, b: Outline, style: Style = BLACK) -> Comparison:
    """Two drawings of one outline each."""
    return compare(drawing([DrawnElement(a, style)]), drawing([DrawnElement(b, style)]))


def test_a_drawing_agrees_with_itself() -> None:
    """Nothing differs, and the error is exactly zero."""
    found = against(sample())
    assert found.agrees()
    assert found.max_error == 0.0
    assert found.offenders == ()
    assert found.elements == len(sample())


@pytest.mark.parametrize("number", [0, 8, 20, 25, 31])
def test_a_moved_element_is_noticed(number: int) -> None:
    """2e-6 of the diagonal is too far, 5e-7 is not, and both are measured."""
    for share, agrees in ((2e-6, False), (5e-7, True), (2e-2, False)):
        elements = sample()
        elements[number] = shifted(elements[number], share * DIAGONAL * 1j)
        found = against(elements)
        assert found.agrees() == agrees
        assert found.max_error == pytest.approx(share, rel=1e-2 if share > 1e-3 else 1e-6)
        assert found.missing == found.extra == 0
        assert found.offenders[0].element == number


def test_a_far_element_is_missing_nowhere_but_moved() -> None:
    """An element on its own number with no better partner is measured, not lost."""
    elements = sample()
    elements[4] = shifted(elements[4], 30 + 0j)
    found = against(elements)
    assert found.max_error > 0.1
    assert found.missing == 0


@pytest.mark.parametrize(("first", "second"), [(0, 1), (3, 15), (21, 30)])
def test_swapped_order_is_noticed(first: int, second: int) -> None:
    """Two elements that change places in the paint order break it."""
    elements = sample()
    elements[first], elements[second] = elements[second], elements[first]
    found = against(elements)
    assert found.order_violations >= 1
    assert found.missing == found.extra == found.style_differences == 0
    assert not found.agrees()


def test_lost_and_added_elements_are_noticed() -> None:
    """Counts and numbers of what only one drawing has."""
    elements = sample()
    del elements[5]
    found = against(elements)
    assert (found.missing, found.extra, found.order_violations) == (1, 0, 0)
    assert [each.element for each in found.offenders if each.what == "missing"] == [5]
    found = against([*sample(), shifted(sample()[0], 3 + 3j)])
    assert (found.missing, found.extra) == (0, 1)


@pytest.mark.parametrize(
    "style",
    [
        Style(fill="#000001"),
        Style(fill="none"),
        Style(stroke="#ff0000"),
        Style(more=(("fill-rule", "evenodd"),)),
        Style(fill=PaintServer("linearGradient", "<linearGradient/>", IDENTITY)),
    ],
)
def test_a_changed_style_is_noticed(style: Style) -> None:
    """Whatever shows counts."""
    elements = sample()
    elements[3] = replace(elements[3], style=style)
    found = against(elements)
    assert found.style_differences == 1
    assert not found.agrees()


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        (Style(fill="#FF0000"), Style(fill="#ff0000"), True),
        (STROKED, replace(STROKED, stroke_width=0.5 + 1e-9), True),
        (STROKED, replace(STROKED, stroke_width=0.5001), False),
        (STROKED, replace(STROKED, dashes=(1.0, 2.0)), False),
        (STROKED, replace(STROKED, more=(("stroke-linecap", "round"),)), False),
        (BLACK, replace(BLACK, more=(("stroke-linecap", "round"),)), True),
        (BLACK, replace(BLACK, stroke_width=9.0, dashes=(1.0,)), True),
        (STROKED, replace(STROKED, stroke_matrix=(1.0, 0.0, 0.0, 1.0)), True),
        (STROKED, replace(STROKED, stroke_matrix=(2.0, 0.0, 0.0, 0.5)), False),
    ],
)
def test_styles_are_compared_as_seen(one: Style, other: Style, same: bool) -> None:
    """What cannot be seen does not count, and numbers have a tolerance."""
    shape = leaf()
    a, b = (drawing([DrawnElement(shape, each)]) for each in (one, other))
    assert compare(a, b).agrees() == same


def test_gradients_are_compared_by_content_and_place() -> None:
    """The same gradient somewhere else is another paint."""
    paint = PaintServer("linearGradient", '<linearGradient x1="0"/>', IDENTITY)
    near = replace(paint, xml='<linearGradient x1="0.0"/>')
    far = replace(paint, matrix=(1, 0, 0, 1, 5, 0))
    shape = rectangle(9, 9)
    assert shown(shape, shape, Style(fill=paint)).agrees()
    one = drawing([DrawnElement(shape, Style(fill=paint))])
    assert compare(one, drawing([DrawnElement(shape, Style(fill=near))])).agrees()
    assert not compare(one, drawing([DrawnElement(shape, Style(fill=far))])).agrees()


def test_effects_are_compared_by_content_not_by_name() -> None:
    """Keys and ids are only names; what they stand for, and which run they wrap, is not."""

    def grouped(key: str, name: str, opacity: str, second: str | None = None) -> Drawing:
        clip = f'<clipPath id="{name}"/>'
        effect = Effect((("clip-path", f"url(#{name})"), ("opacity", opacity)), clip, IDENTITY)
        keys = [key, second or key]
        elements = [DrawnElement(leaf(), replace(BLACK, effects=(each,))) for each in keys]
        return replace(drawing(elements), effects=dict.fromkeys(keys, effect))

    assert compare(grouped("a", "clip1", "0.5"), grouped("b", "c", "0.50")).agrees()
    assert not compare(grouped("a", "clip1", "0.5"), grouped("a", "clip1", "0.6")).agrees()
    assert not compare(grouped("a", "c", "0.5"), grouped("a", "c", "0.5", "other")).agrees()
    plain = drawing([DrawnElement(leaf(), BLACK)] * 2)
    assert not compare(grouped("a", "c", "0.5"), plain).agrees()


def test_fragments_are_compared_by_text_and_place() -> None:
    """Carried XML must be the same and stand in the same place."""
    text = Fragment("text", "<text>hello</text>", IDENTITY)

    def with_text(fragment: Fragment) -> Drawing:
        return drawing([DrawnElement(None, BLACK, fragment)])

    one = with_text(text)
    assert compare(one, with_text(text)).agrees()
    assert not compare(one, with_text(replace(text, xml="<text>hallo</text>"))).agrees()
    off = compare(one, with_text(replace(text, matrix=(1, 0, 0, 1, 2e-6 * DIAGONAL, 0))))
    assert off.max_error == pytest.approx(2e-6)
    assert not compare(one, with_text(replace(text, matrix=(1.1, 0, 0, 1, 0, 0)))).agrees()
    assert not compare(one, drawing([DrawnElement(leaf(), BLACK)])).agrees()


@pytest.mark.parametrize("backwards", [False, True])
def test_another_start_or_direction_is_the_same_curve(backwards: bool) -> None:
    """Unless dashes make it show."""
    again = restarted(leaf(), 1, backwards)
    assert shown(leaf(), again).max_error < 1e-15
    assert not shown(leaf(), again, replace(STROKED, dashes=(2.0, 1.0))).agrees()


def test_circles_are_the_same_however_they_are_cut() -> None:
    """Pieces and starts do not matter, radius and centre do."""
    assert shown(circle(5), circle(5, 4, 0.7)).agrees(1e-12)
    found = shown(circle(5), circle(5 + 2e-6 * DIAGONAL, 4))
    assert found.max_error == pytest.approx(2e-6)


def test_other_segments_of_one_curve_agree() -> None:
    """A cut line, and a line written as a cubic, are where the line is."""
    whole = polygon([(0, 0), (90, 30)], closed=False)
    cut = polygon([(0, 0), (30, 10), (90, 30)], closed=False)
    assert shown(whole, cut).max_error < 1e-14
    coords = np.array([[(0, 0), (30, 10), (60, 20), (90, 30)]], float)
    cubic = Outline(np.array([CUBIC], np.uint8), coords, whole.starts, whole.closed)
    assert shown(whole, cubic).max_error < 1e-14
    assert whole.kind[0] == LINE


def test_an_approximation_is_measured_truly() -> None:
    """The well-known cubic circle is 2.7e-4 of its radius off, and that is what is found."""
    handle = 4 / 3 * np.tan(np.pi / 8)
    quarter = np.array([(1, 0), (1, handle), (handle, 1), (0, 1)])
    turn = np.array([[0, 1], [-1, 0]])
    coords = np.stack([quarter @ np.linalg.matrix_power(turn, k) for k in range(4)]) * 40
    arcs = circle(40)
    cubics = Outline(np.full(4, CUBIC, np.uint8), coords, np.array([0, 4], np.int32), arcs.closed)
    found = shown(arcs, cubics)
    assert found.max_error * DIAGONAL / 40 == pytest.approx(2.7253e-4, rel=0.01)


def test_open_and_closed_strokes_differ() -> None:
    """A join is not two caps; a fill without stroke shows neither."""
    ends = [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 0.0)]
    opened, closed = polygon(ends, closed=False), polygon(ends[:3])
    assert not shown(opened, closed, STROKED).agrees()
    assert shown(opened, closed, BLACK).agrees()


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("M0 0L1.5,2", "M0 0L1.50,2.0", True),
        ("rotate(30 1 2)", "rotate(30.00000001 1 2)", True),
        ("rotate(30 1 2)", "rotate(30.001 1 2)", False),
        ("#999998", "#999999", False),
        ("#99999998", "#99999999", False),
        ("fill:#1e3a5f", "fill:#1e3a5f", True),
        ("layer1234567", "layer1234568", False),
        ("12px", "12.0px", True),
    ],
)
def test_numbers_in_texts_have_a_tolerance_and_names_have_none(
    one: str, other: str, same: bool
) -> None:
    """Texts agree word by word, their numbers within 1e-6."""
    assert same_text(one, other) == same


def test_a_circle_has_no_ends() -> None:
    """A stroke that comes round smoothly shows neither caps nor a join."""
    closed = circle(5, 4)
    opened = Outline(closed.kind, closed.coords, closed.starts, np.array([False]))
    assert shown(opened, closed, STROKED).agrees()


def test_another_canvas_differs() -> None:
    """Unless the first drawing had none."""
    elements = sample()
    wide = drawing(elements, (0, 0, 200, 100))
    assert compare(drawing(elements), wide).canvas_differs
    assert compare(drawing(elements, None), wide).agrees()


def test_many_elements_in_another_order() -> None:
    """Two long runs that are exchanged are told from losses."""
    placed = grid(40, 50, (2.0, 0.0), (0.0, 2.0))
    elements = copies(line(0.5), placed, STROKED)
    exchanged = [*elements[1000:], *elements[:1000]]
    found = compare(drawing(elements), drawing(exchanged))
    assert found.order_violations == 1000
    assert found.missing == found.extra == 0
