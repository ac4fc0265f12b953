"""What the SVG writer prints comes back from the reader as it was."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ipmlang.formats import FormatError
from ipmlang.formats.drawing import (
    ARC,
    CUBIC,
    LINE,
    QUADRATIC,
    Drawing,
    DrawnElement,
    Effect,
    Fragment,
    PaintServer,
    Style,
)
from ipmlang.formats.svg import read_svg
from ipmlang.formats.svg.write import fitted_box, write_svg
from tests.formats.outlines import drawing, outline, points
from tests.real_drawings import NAMES, whole


def back(made: Drawing) -> Drawing:
    """What the reader makes of the written drawing."""
    return read_svg(write_svg(made).encode("utf-8"))


def test_every_kind_of_segment_comes_back() -> None:
    """Lines and curves are the same to the rounding, closing lines are not doubled."""
    made = drawing(
        outline([LINE, LINE, LINE], [[0, 0, 4, 0], [4, 0, 4, 3], [4, 3, 0, 0]], closed=True),
        outline([QUADRATIC], [[1, 2, 3.123456789, 4, 5, -6e-7]]),
        outline([CUBIC, LINE], [[1, 2, 3, 4, 5, 6, 7, 8], [7, 8, 9, 1]]),
    )
    for one, other in zip(made.elements, back(made).elements, strict=True):
        assert one.outline is not None
        assert other.outline is not None
        assert (one.outline.kind == other.outline.kind).all()
        assert (one.outline.closed == other.outline.closed).all()
        assert np.abs(points(one.outline) - points(other.outline)).max() < 1e-8


@pytest.mark.parametrize("sweep", [0.3, -1.0, 2.5, 3.14, np.pi, -np.pi, 4.0, -6.0, 6.28])
@pytest.mark.parametrize("radius", [20.0, 9.0, 0.01])
def test_arcs_come_back_where_they_were(sweep: float, radius: float) -> None:
    """Circles, ellipses at any angle, thin ones, half turns and nearly whole ones."""
    angle = 0.7
    u = np.array([np.cos(angle), np.sin(angle)]) * 20
    v = np.array([-np.sin(angle), np.cos(angle)]) * radius
    one = outline([ARC], [[50, 50, *u, *v, 0.4, sweep]])
    found = back(drawing(one)).elements[0].outline
    assert found is not None
    assert np.abs(_ends(found)[0] - _ends(one)[0]).max() < 1e-7
    assert np.abs(_ends(found)[1] - _ends(one)[1]).max() < 1e-7
    # Every point of the result lies on the ellipse, to the rounding.
    local = np.linalg.solve(np.stack([u, v], axis=1), (points(found) - 50).reshape(-1, 2).T)
    assert np.abs(np.hypot(*local) - 1).max() * min(radius, 20) < 1e-7


def _ends(one: object) -> tuple[np.ndarray, np.ndarray]:
    sampled = points(one)  # type: ignore[arg-type]
    return sampled[0, 0], sampled[-1, -1]


def test_numbers_are_short_and_never_in_exponents() -> None:
    """What a person would write stays as it is."""
    text = write_svg(drawing(outline([LINE], [[1e-9, 0.1 + 0.2, 10.0, -1e-7]])))
    assert '<path d="M0 0.3L10 -0.0000001"' in text


def test_style_comes_back() -> None:
    """Everything that a style can say."""
    style = Style(
        fill="#102030",
        stroke="#ff0000",
        stroke_width=0.25,
        dashes=(2.0, 1.0),
        dash_offset=0.5,
        more=(("fill-rule", "evenodd"), ("opacity", "0.5"), ("stroke-linecap", "round")),
    )
    shape = outline([LINE], [[0, 0, 5, 5]])
    found = back(Drawing((DrawnElement(shape, style),), (0, 0, 9, 9))).elements[0].style
    assert found == style


def test_a_slanted_pen_keeps_outline_and_pen() -> None:
    """A stroke under a transform that is no similarity."""
    pen = (2.0, 0.0, 0.5, 0.5)
    style = Style(fill="none", stroke="#000000", stroke_width=0.5, stroke_matrix=pen)
    shape = outline([LINE, CUBIC], [[1, 2, 5, 5], [5, 5, 6, 6, 7, 9, 1, 3]])
    found = back(Drawing((DrawnElement(shape, style),), (0, 0, 9, 9))).elements[0]
    assert found.outline is not None
    assert np.abs(points(found.outline) - points(shape)).max() < 1e-9
    assert found.style.stroke_width == pytest.approx(0.5)
    assert found.style.stroke_matrix == pytest.approx(pen)


def test_equal_gradients_are_written_once() -> None:
    """Definitions are shared by all elements that use them."""
    stop = '<stop stop-color="#ff0000"/><stop offset="1" stop-color="#0000ff"/>'
    xml = f'<linearGradient gradientUnits="userSpaceOnUse" x2="9">{stop}</linearGradient>'
    paint = PaintServer("linearGradient", xml, (2.0, 0.0, 0.0, 2.0, 1.0, 0.0))
    shape = outline([LINE], [[0, 0, 5, 5]])
    elements = tuple(DrawnElement(shape, Style(fill=paint)) for _ in range(3))
    text = write_svg(Drawing(elements, (0, 0, 9, 9)))
    assert text.count("<linearGradient") == 1
    assert text.count("url(#paint1)") == 3
    found = read_svg(text.encode()).elements[2].style.fill
    assert isinstance(found, PaintServer)
    assert found.matrix == pytest.approx(paint.matrix)


def test_runs_of_effects_nest() -> None:
    """A run with one effect is one group; an effect within it a group inside."""
    clip = '<clipPath id="c"><rect width="4" height="4"/></clipPath>'
    effects = {
        "a": Effect((("opacity", "0.5"),), "", (1, 0, 0, 1, 0, 0)),
        "b": Effect((("clip-path", "url(#c)"),), clip, (2, 0, 0, 2, 1, 1)),
    }
    shape = outline([LINE, LINE], [[0, 0, 9, 5], [9, 5, 2, 8]])
    stacks = [(), ("a",), ("a", "b"), ("a",), ()]
    elements = tuple(DrawnElement(shape, Style(effects=each)) for each in stacks)
    made = Drawing(elements, (0, 0, 9, 9), effects=effects)
    text = write_svg(made)
    assert text.count('opacity="0.5"') == 1
    found = read_svg(text.encode())
    assert [len(each.style.effects) for each in found.elements] == [0, 1, 2, 1, 0]
    inner = found.effects[found.elements[2].style.effects[1]]
    assert inner.matrix == pytest.approx((2, 0, 0, 2, 1, 1))
    for element in found.elements:
        assert element.outline is not None
        assert np.abs(points(element.outline) - points(shape)).max() < 1e-9


def test_ids_of_carried_xml_do_not_clash() -> None:
    """Two fragments that use one id keep their own definitions."""
    xml = '<g><linearGradient id="a"><stop/></linearGradient><text fill="url(#a)">{}</text></g>'
    fragments = [Fragment("text", xml.format(word), (1, 0, 0, 1, 0, 0)) for word in "xy"]
    made = Drawing(tuple(DrawnElement(None, Style(), each) for each in fragments), (0, 0, 9, 9))
    text = write_svg(made)
    assert text.count('id="a"') == 1
    assert text.count('fill="url(#a)"') == 1


def test_box_and_size_are_kept_or_fitted() -> None:
    """A drawing keeps its box as written; one without gets a box around what is drawn."""
    made = replace(drawing(outline([LINE], [[0, 0, 5, 5]])), width="10in", height="5in")
    found = back(made)
    assert (found.box, found.width, found.height) == (made.box, "10in", "5in")
    circle = outline([ARC], [[10, 10, 3, 0, 0, 3, 0, 6.28]])
    style = Style(fill="none", stroke="#000000", stroke_width=2.0)
    x, y, width, height = fitted_box([DrawnElement(circle, style)])
    assert (x, y, width, height) == pytest.approx((6 - 0.16, 6 - 0.16, 8.32, 8.32))
    assert fitted_box([]) == (0.0, 0.0, 1.0, 1.0)


def test_a_coordinate_without_a_value_is_refused() -> None:
    """NaN never reaches a file."""
    with pytest.raises(FormatError, match="without a value"):
        write_svg(drawing(outline([LINE], [[0, 0, np.nan, 1]])))


@pytest.mark.parametrize("name", NAMES)
def test_real_drawings_come_back(name: str) -> None:
    """Every element in order, with its style, no point further off than 1e-9 of the diagonal."""
    first = whole(name)
    second = back(first)
    assert len(first.elements) == len(second.elements)
    diagonal = float(np.hypot(*first.box[2:])) if first.box else 1.0
    for one, other in zip(first.elements, second.elements, strict=True):
        assert one.style.more == other.style.more
        assert len(one.style.effects) == len(other.style.effects)
        assert isinstance(one.style.fill, str) == isinstance(other.style.fill, str)
        if one.outline is None or other.outline is None:
            assert one.outline is other.outline
        elif len(one.outline.kind) == len(other.outline.kind):
            assert np.abs(points(one.outline) - points(other.outline)).max() < 1e-9 * diagonal
        else:
            # Only turns that are nearly half or whole are written as more arcs than they were.
            turns = np.abs(one.outline.coords[one.outline.kind == ARC][:, 3, 1])
            assert ((turns > 6.28) | (np.abs(turns - np.pi) < 1e-3)).any()
