"""One probe for each feature that an SVG reader may get wrong: what is drawn, where, how."""

from __future__ import annotations

import numpy as np
import pytest

from ipmlang.formats.drawing import ARC, LINE, Drawing, DrawnElement, PaintServer
from ipmlang.formats.svg import read_svg
from ipmlang.formats.svg.bounds import outline_box

HEAD = (
    '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
    'viewBox="0 0 400 200">'
)
SQUARE = '<rect width="10" height="10"/>'


def read(body: str) -> Drawing:
    """The drawing of a file with this content."""
    return read_svg((HEAD + body + "</svg>").encode())


def box(element: DrawnElement) -> list[float]:
    """The element's box as [x, y, width, height], rounded."""
    assert element.outline is not None
    return [round(value, 9) for value in outline_box(element.outline)]


def boxes(body: str) -> list[list[float]]:
    """The boxes of all that is drawn."""
    return [box(element) for element in read(body).elements]


def fills(body: str) -> list[object]:
    """The fills of all that is drawn, in paint order."""
    return [element.style.fill for element in read(body).elements]


def styled(
    css: str, body: str = '<g id="g"><rect id="r" class="c" width="1" height="1"/></g>'
) -> object:
    """The fill of the last element of `body` under a style sheet."""
    return fills(f"<style>{css}</style>{body}")[-1]


def codes(body: str) -> set[str]:
    """The codes of the notes."""
    return {note.code for note in read(body).notes}


def test_nested_transforms() -> None:
    """Transforms of groups apply from the outside in."""
    body = f'<g transform="translate(100 10)"><g transform="scale(2)">{SQUARE}</g></g>'
    assert boxes(body) == [[100, 10, 20, 20]]


@pytest.mark.parametrize(
    ("transform", "expected"),
    [
        ("matrix(2 0 0 3 1 4)", [1, 4, 20, 30]),
        ("translate(5)", [5, 0, 10, 10]),
        ("scale(2,.5)", [0, 0, 20, 5]),
        ("rotate(90)", [-10, 0, 10, 10]),
        ("rotate(180 5 5)", [0, 0, 10, 10]),
        ("skewX(45)", [0, 0, 20, 10]),
        ("skewY(45)", [0, 0, 10, 20]),
        ("translate(1,2)scale(3)", [1, 2, 30, 30]),
    ],
)
def test_transform_kinds(transform: str, expected: list[float]) -> None:
    """Every function of a transform list, alone and in a row."""
    assert boxes(f'<g transform="{transform}">{SQUARE}</g>') == [expected]


def test_css_transform_with_units() -> None:
    """The property takes units, and wins over the attribute."""
    body = (
        '<rect width="10" height="10" transform="scale(9)" style="transform:translate(1in,10%)"/>'
    )
    assert boxes(body) == [[96, 20, 10, 10]]


def test_transform_origin() -> None:
    """A transform turns about its origin: a point of the viewBox, or of the element's own box."""
    about = '<rect x="10" y="20" width="10" height="10" style="transform:scale(2);{}"/>'
    assert boxes(about.format("transform-origin:10px 20px")) == [[10, 20, 20, 20]]
    assert boxes(about.format("transform-origin:50% 50%")) == [[-180, -60, 20, 20]]
    own = "transform-box:fill-box;transform-origin:center"
    assert boxes(about.format(own)) == [[5, 15, 20, 20]]


def test_use() -> None:
    """A `use` places its target, by href or xlink:href, and hands its style down."""
    body = (
        '<defs><rect id="r" width="10" height="10"/></defs>'
        '<use href="#r" x="50" y="5" fill="red"/>'
        '<use xlink:href="#r" transform="scale(2)" x="10" fill="lime"/>'
    )
    assert boxes(body) == [[50, 5, 10, 10], [20, 0, 20, 20]]
    assert fills(body) == ["#ff0000", "#00ff00"]


def test_symbol_is_fitted_and_not_drawn_itself() -> None:
    """A symbol draws only through `use`, its viewBox fitted into the size asked for."""
    body = (
        '<symbol id="s" viewBox="0 0 5 5"><rect width="5" height="5"/></symbol>'
        '<use href="#s" x="100" width="50" height="100"/>'
    )
    assert boxes(body) == [[100, 25, 50, 50]]


def test_preserve_aspect_ratio() -> None:
    """`none` stretches, `slice` covers, and the words of alignment move."""
    inner = (
        '<svg width="40" height="20" viewBox="0 0 10 10" overflow="visible" {}>' + SQUARE + "</svg>"
    )
    assert boxes(inner.format('preserveAspectRatio="none"')) == [[0, 0, 40, 20]]
    assert boxes(inner.format('preserveAspectRatio="xMaxYMax slice"')) == [[0, -20, 40, 40]]
    assert boxes(inner.format('preserveAspectRatio="xMinYMid"')) == [[0, 0, 20, 20]]


def test_nested_viewport_keeps_its_size_to_itself() -> None:
    """Percentages inside refer to the inner viewBox, those after it to the outer one."""
    body = (
        '<svg x="300" width="50" height="50" viewBox="0 0 10 10">'
        '<rect width="50%" height="50%"/></svg>'
        '<rect width="50%" height="50%"/>'
    )
    assert boxes(body) == [[300, 0, 25, 25], [0, 0, 200, 100]]


def test_nested_viewport_clips_only_what_sticks_out() -> None:
    """What fits needs no clip; what does not is wrapped in one."""
    inner = '<svg width="50" height="50"><rect width="{}" height="9" /></svg>'
    assert not read(inner.format(50)).effects
    assert len(read(inner.format(51)).effects) == 1
    assert len(read(inner.format('50" stroke="red')).effects) == 1


def test_a_viewport_clips_all_that_it_holds_or_nothing() -> None:
    """Copies of one symbol stay alike: what fits is not taken out of a clip that others need."""
    both = '<svg width="50" height="50"><rect width="9" height="9"/><rect width="{}" height="9"/>'
    for width, clipped in ((50, 0), (51, 1)):
        found = read(both.format(width) + "</svg>")
        assert [len(each.style.effects) for each in found.elements] == [clipped] * 2


@pytest.mark.parametrize(
    ("width", "expected"),
    [("1in", 96), ("2.54cm", 96), ("25.4mm", 96), ("72pt", 96), ("6pc", 96), ("3px", 3),
     ("2em", 20), ("2ex", 10), ("25%", 100), ("1e1", 10)],
)  # fmt: skip
def test_units(width: str, expected: float) -> None:
    """Absolute units at 96 to the inch, relative ones by font size and viewport."""
    (found,) = boxes(f'<g font-size="10"><rect width="{width}" height="1"/></g>')
    assert found[2] == pytest.approx(expected)


def test_percentage_of_the_diagonal() -> None:
    """A radius in percent is a part of the viewport's normalised diagonal."""
    (found,) = boxes('<circle r="10%"/>')
    assert found[2] == pytest.approx(0.2 * np.hypot(400, 200) / np.sqrt(2))


@pytest.mark.parametrize(
    ("css", "expected"),
    [
        (".c{fill:red}", "#ff0000"),
        ("#r{fill:red}", "#ff0000"),
        ("rect.c{fill:red}", "#ff0000"),
        ("circle.c{fill:red}", "#000000"),
        ("g > rect{fill:red}", "#ff0000"),
        ("svg > rect{fill:red}", "#000000"),
        ("svg rect{fill:red}", "#ff0000"),
        ("#r{fill:red} rect{fill:blue}", "#ff0000"),
        (".c{fill:red} rect{fill:blue}", "#ff0000"),
        ("rect{fill:red} rect{fill:blue}", "#0000ff"),
        ("rect{fill:red!important} #r{fill:blue}", "#ff0000"),
        ("@media print{rect{fill:red}}", "#000000"),
        ("@media screen{rect{fill:red}}", "#ff0000"),
        ("@media all{rect{fill:red}}", "#ff0000"),
        ("rect:first-child{fill:red}", "#ff0000"),
        ("g{fill:red}", "#ff0000"),
        (":root{--main:red} rect{fill:var(--main)}", "#ff0000"),
        ("rect{fill:nonsense}", "#000000"),
        ("rect{fill:red;fill:nonsense}", "#ff0000"),
        ("/* rect{fill:red} */", "#000000"),
        ("rect{fill:red", "#ff0000"),
    ],
)
def test_style_sheets(css: str, expected: str) -> None:
    """Selectors, combinators, specificity, importance and media."""
    assert styled(css) == expected


def test_where_a_style_comes_from_decides() -> None:
    """Attribute < sheet < style attribute < important sheet < important style attribute."""
    body = '<rect width="1" height="1" fill="#111111" {}/>'
    assert styled("", body.format("")) == "#111111"
    assert styled("rect{fill:#222}", body.format("")) == "#222222"
    assert styled("rect{fill:#222}", body.format('style="fill:#333"')) == "#333333"
    assert styled("rect{fill:#222!important}", body.format('style="fill:#333"')) == "#222222"
    both = body.format('style="fill:#333!important"')
    assert styled("rect{fill:#222!important}", both) == "#333333"


def test_style_sheet_after_use_and_behind() -> None:
    """A sheet counts wherever it stands, and matches the original of what a `use` copies."""
    body = '<defs><g id="d"><rect class="c" width="1" height="1"/></g></defs><use href="#d"/>'
    assert fills(body + "<style>#d .c{fill:red}</style>") == ["#ff0000"]


@pytest.mark.parametrize(
    ("paint", "color", "alpha"),
    [
        ("currentColor", "#00ff00", None),
        ("rgb(100%,0%,50%)", "#ff0080", None),
        ("rgb(1, 2, 3)", "#010203", None),
        ("hsl(120,100%,25%)", "#008000", None),
        ("hsla(240 100% 50% / 25%)", "#0000ff", "0.25"),
        ("rgba(255,0,0,0.5)", "#ff0000", "0.5"),
        ("#f00c", "#ff0000", "0.8"),
        ("#00ff0033", "#00ff00", "0.2"),
        ("rebeccapurple", "#663399", None),
        ("transparent", "#000000", "0"),
        ("none", "none", None),
    ],
)
def test_colors(paint: str, color: str, alpha: str | None) -> None:
    """Every way to write a colour; alpha becomes opacity of the fill."""
    (element,) = read(f'<g color="lime"><rect width="1" height="1" fill="{paint}"/></g>').elements
    assert element.style.fill == color
    assert dict(element.style.more).get("fill-opacity") == alpha


def test_alpha_and_opacity_multiply() -> None:
    """The alpha of a colour times fill-opacity; the opacity of the element apart from it."""
    body = '<rect width="1" height="1" fill="#ff000080" fill-opacity="50%" opacity=".25"/>'
    more = dict(read(body).elements[0].style.more)
    assert float(more["fill-opacity"]) == pytest.approx(128 / 255 / 2)
    assert more["opacity"] == "0.25"


def test_gradient_fill() -> None:
    """A gradient is kept, hrefs resolved, with the map from its box to the world."""
    body = (
        '<linearGradient id="a"><stop offset="0" stop-color="red"/>'
        '<stop offset="50%" style="stop-color:currentColor;stop-opacity:.5" color="blue"/>'
        "</linearGradient>"
        '<linearGradient id="b" href="#a" gradientTransform="translate(.5)"/>'
        '<g transform="scale(2)"><rect x="10" y="20" width="30" height="40" fill="url(#b)"/></g>'
    )
    paint = read(body).elements[0].style.fill
    assert isinstance(paint, PaintServer)
    assert paint.matrix == pytest.approx((60, 0, 0, 80, 20 + 30, 40))
    assert 'gradientUnits="userSpaceOnUse"' in paint.xml
    assert '<stop offset="0.5" stop-color="#0000ff" stop-opacity="0.5"/>' in paint.xml
    assert codes(body) == {"gradient"}


def test_paints_that_cannot_be() -> None:
    """A lone stop is a colour, a missing server falls back, nothing to fall back on is nothing."""
    rect = '<rect width="1" height="1" fill="{}"/>'
    stop = '<linearGradient id="a"><stop stop-color="red"/></linearGradient>'
    assert fills(stop + rect.format("url(#a)")) == ["#ff0000"]
    assert fills(rect.format("url(#missing) blue")) == ["#0000ff"]
    assert fills(rect.format("url(#missing)")) == ["none"]


def test_pattern_fill() -> None:
    """A pattern is kept with what it draws, styles worked in."""
    body = (
        "<style>.dot{fill:red}</style>"
        '<pattern id="p" width=".5" height=".5"><circle class="dot" r="1"/></pattern>'
        '<rect x="10" width="20" height="20" fill="url(#p)"/>'
    )
    paint = read(body).elements[0].style.fill
    assert isinstance(paint, PaintServer)
    assert 'x="10" y="0" width="10" height="10"' in paint.xml
    assert '<circle r="1" fill="red"/>' in paint.xml
    assert "class" not in paint.xml


def test_clip_path() -> None:
    """A clip is carried as an effect around what it clips, with its definition."""
    body = (
        '<clipPath id="c"><circle r="5"/></clipPath>'
        f'<g transform="scale(2)" clip-path="url(#c)">{SQUARE}{SQUARE}</g>{SQUARE}'
    )
    drawing = read(body)
    (key,) = drawing.effects
    assert [element.style.effects for element in drawing.elements] == [(key,), (key,), ()]
    effect = drawing.effects[key]
    assert effect.matrix == (2, 0, 0, 2, 0, 0)
    assert '<circle r="5"/></clipPath>' in effect.definitions
    assert dict(effect.attributes)["clip-path"].strip("url(#)") in effect.definitions


def test_group_opacity_is_an_effect_of_many_and_a_style_of_one() -> None:
    """A group of two is composited as one; the opacity of a lone element is its own."""
    lone = read(f'<g opacity=".5"><g opacity=".5">{SQUARE}</g></g>')
    assert dict(lone.elements[0].style.more) == {"opacity": "0.25"}
    assert not lone.effects
    pair = f'<g opacity=".5">{SQUARE}{SQUARE}</g>'
    twice = read(pair + pair + SQUARE + pair)
    first, second = twice.elements[0].style.effects, twice.elements[2].style.effects
    assert first != second
    assert twice.elements[1].style.effects == first
    assert twice.elements[5].style.effects == first


def test_document_order() -> None:
    """Elements of different kinds keep the order in which they are painted."""
    body = (
        '<circle r="1" fill="#111111"/><path d="M0 0h1" fill="#222222"/>'
        '<g><rect width="1" height="1" fill="#333333"/></g><line x2="1" fill="#444444"/>'
        '<polygon points="0 0 1 0 1 1" fill="#555555"/>'
    )
    assert fills(body) == ["#111111", "#222222", "#333333", "#444444", "#555555"]


def test_what_is_not_displayed_or_hidden_is_no_element() -> None:
    """display:none hides all below; visibility may come back."""
    body = (
        f'<g display="none">{SQUARE}</g><g style="display:none">{SQUARE}</g><g visibility="hidden">'
        '<rect width="1" height="1"/><rect width="2" height="2" visibility="visible"/></g>'
    )
    assert boxes(body) == [[0, 0, 2, 2]]


def test_without_paint_is_an_element_all_the_same() -> None:
    """Plotter files have outlines without stroke or fill; sizes of zero draw nothing."""
    body = (
        '<path fill="none" d="M0 0h5"/><rect width="0" height="5"/><circle/><polyline points=""/>'
    )
    (element,) = read(body).elements
    assert (element.style.fill, element.style.stroke) == ("none", "none")


def test_text_is_carried_through() -> None:
    """Text comes with the styles it inherits, sizes free of the viewport, and what it refers to."""
    body = (
        "<style>.t{font-weight:bold}</style>"
        '<linearGradient id="g"><stop stop-color="red"/><stop offset="1"/></linearGradient>'
        '<g font-family="serif" transform="translate(5 6)">'
        '<text class="t" x="50%" y="7" fill="url(#g)">a &lt; <tspan dx="1em">b</tspan></text></g>'
    )
    drawing = read(body)
    fragment = drawing.elements[0].fragment
    assert fragment is not None
    assert fragment.matrix == (1, 0, 0, 1, 5, 6)
    assert 'x="200"' in fragment.xml
    assert 'font-family="serif"' in fragment.xml
    assert 'font-weight="bold"' in fragment.xml
    assert 'a &lt; <tspan dx="1em">b</tspan>' in fragment.xml
    name = fragment.xml.split('fill="url(#')[1].split(")")[0]
    assert f'<linearGradient id="{name}"' in fragment.xml
    assert codes(body) >= {"text"}


def fragment(body: str) -> tuple[str, tuple[float, ...]]:
    """What the only element of a drawing shows, and its matrix."""
    (element,) = read(body).elements
    assert element.fragment is not None
    return element.fragment.xml, element.fragment.matrix


@pytest.mark.parametrize(
    ("body", "matrix"),
    [
        ('<text x="30.1" y="7">ab<tspan x="30.1" dy="1em">c</tspan></text>', (30.1, 7)),
        ('<text x="12" y="0">ab<tspan x="12" dy="1em">c</tspan></text>', (12, 0)),
        ('<text x="10%" y="50%">ab<tspan x="10%" dy="1em">c</tspan></text>', (40, 100)),
        ('<text transform="translate(3 4)">ab<tspan x="0" dy="1em">c</tspan></text>', (3, 4)),
    ],
)
def test_equal_labels_are_equal_wherever_they_begin(body: str, matrix: tuple[float, float]) -> None:
    """Their places are their matrix, whether they were written as attributes or as transforms."""
    shown = '<text>ab<tspan x="0" dy="1em">c</tspan></text>'
    assert fragment(body) == (shown, (1, 0, 0, 1, *matrix))


def test_letters_and_pictures_begin_at_the_origin_too() -> None:
    """A list of places counts from the first; numbers stay as short as they were."""
    assert fragment('<text x="10.1 20.3" y="5">ab</text>')[0] == '<text x="0 10.2">ab</text>'
    href = "data:image/png;base64,AA=="
    xml, matrix = fragment(f'<image x="4" y="3" width="2" height="1" href="{href}"/>')
    assert matrix == (1, 0, 0, 1, 4, 3)
    assert " x=" not in xml and " y=" not in xml


@pytest.mark.parametrize(
    "body",
    [
        '<text x="1em" y="7">a</text>',
        '<path id="p" d="M0 0h9"/><text x="9" y="7"><textPath href="#p">a</textPath></text>',
        '<linearGradient id="g" gradientUnits="userSpaceOnUse"><stop/></linearGradient>'
        '<text x="9" y="7" fill="url(#g)">a</text>',
        '<text x="9" y="7">a<animate attributeName="x" to="20"/></text>',
    ],
)
def test_a_text_stays_where_something_would_stay_behind(body: str) -> None:
    """Places in ems, along a path, under a paint in the units of the drawing, in motion."""
    found = read(body).elements[-1].fragment
    assert found is not None
    assert found.matrix == (1, 0, 0, 1, 0, 0)
    assert 'y="7"' in found.xml


def test_bad_path_data_keeps_the_valid_prefix() -> None:
    """Everything before the error is drawn, and said."""
    body = '<path d="M0 0 L10 0 10 10 Lx"/>'
    assert boxes(body) == [[0, 0, 10, 10]]
    assert codes(body) == {"path-data"}


def test_switch_takes_the_first_that_holds() -> None:
    """By language; what no condition excludes holds."""
    body = (
        '<switch><rect systemLanguage="de" width="1" height="1"/>'
        '<rect systemLanguage="fr, en-GB" width="2" height="2"/>'
        '<rect width="3" height="3"/></switch>'
        '<rect systemLanguage="de" width="4" height="4"/>'
    )
    assert boxes(body) == [[0, 0, 2, 2]]


def test_markers() -> None:
    """Start, middle and end, turned along the path, after their path in paint order."""
    body = (
        '<marker id="m" orient="auto" markerUnits="userSpaceOnUse" overflow="visible">'
        '<rect width="4" height="1" fill="red"/></marker>'
        '<path d="M0 0H100V100" marker-start="url(#m)" marker-mid="url(#m)" marker-end="url(#m)"/>'
    )
    drawing = read(body)
    assert [element.style.fill for element in drawing.elements] == ["#000000"] + ["#ff0000"] * 3
    assert box(drawing.elements[1]) == [0, 0, 4, 1]
    assert box(drawing.elements[3]) == [99, 100, 1, 4]
    half = np.sqrt(0.5)
    assert box(drawing.elements[2]) == pytest.approx([100 - half, 0, 5 * half, 5 * half])


def test_marker_scale_reference_and_view_box() -> None:
    """A marker grows with the pen, and its reference point lands on the vertex."""
    body = (
        '<marker id="m" markerWidth="2" markerHeight="2" refX="5" refY="5" viewBox="0 0 10 10">'
        f'{SQUARE}</marker><line x1="50" y1="50" x2="60" y2="50" stroke-width="3" stroke="red" '
        'marker-start="url(#m)"/>'
    )
    assert boxes(body)[1] == [47, 47, 6, 6]
    assert not read(body).effects


def test_marker_context_paint() -> None:
    """context-stroke is the stroke of the path that bears the marker."""
    body = (
        '<marker id="m"><rect width="1" height="1" fill="context-stroke"/></marker>'
        '<line x2="1" stroke="blue" marker-end="url(#m)"/>'
    )
    assert fills(body)[1] == "#0000ff"


def test_pen_under_transforms() -> None:
    """Widths and dashes grow with the map; a pen that becomes an ellipse says so."""
    line = '<line x2="9" stroke="red" stroke-width="2" stroke-dasharray="1,2" {}/>'
    (scaled,) = read(line.format('transform="rotate(30)scale(3)"')).elements
    assert scaled.style.stroke_width == pytest.approx(6)
    assert scaled.style.dashes == pytest.approx((3, 6))
    assert scaled.style.stroke_matrix is None
    (flat,) = read(line.format('transform="scale(4,1)"')).elements
    assert flat.style.stroke_width == pytest.approx(4)
    assert flat.style.stroke_matrix == pytest.approx((2, 0, 0, 0.5))
    (fixed,) = read(line.format('transform="scale(3)" vector-effect="non-scaling-stroke"')).elements
    assert fixed.style.stroke_width == 2


def test_shapes_are_their_equivalent_paths() -> None:
    """Kinds, starts and directions of the basic shapes."""
    circle, plain, rounded = (
        element.outline
        for element in read(
            '<circle cx="5" cy="6" r="2"/><rect x="1" y="2" width="3" height="4"/>'
            '<rect x="1" y="2" width="30" height="40" rx="5"/>'
        ).elements
    )
    assert circle is not None and plain is not None and rounded is not None
    assert circle.kind.tolist() == [ARC] * 4
    assert circle.coords[0, 0].tolist() == [5, 6]
    assert plain.kind.tolist() == [LINE] * 4
    assert plain.coords[:, 0].tolist() == [[1, 2], [4, 2], [4, 6], [1, 6]]
    assert rounded.kind.tolist() == [LINE, ARC] * 4
    assert rounded.coords[0, 0].tolist() == [6, 2]
    assert all(outline.closed.tolist() == [True] for outline in (circle, plain, rounded))


def test_names_are_kept() -> None:
    """The ids of groups and the element's id and classes, outermost first."""
    (element,) = read(
        '<g id="forest"><g id="tree"><line class="leaf big" x2="1"/></g></g>'
    ).elements
    assert element.source == ("forest", "tree", "leaf", "big")


def test_box_of_the_drawing() -> None:
    """From the viewBox, else from absolute sizes, else none."""
    root = '<svg xmlns="http://www.w3.org/2000/svg" {}><rect width="50%" height="1"/></svg>'

    def of(attributes: str) -> Drawing:
        return read_svg(root.format(attributes).encode())

    sized = of('width="1in" height="50"')
    assert sized.box == (0, 0, 96, 50)
    assert sized.width == "1in"
    assert box(sized.elements[0])[2] == 48
    assert of('width="10in" viewBox="1 2 3 4"').box == (1, 2, 3, 4)
    assert of('width="100%"').box is None


def test_a_clip_fitted_to_each_box_stays_one_for_each() -> None:
    """Neighbours with one clip share a group, but not where the clip follows what it clips."""
    clip = '<clipPath id="c" clipPathUnits="{}"><circle r=".5"/></clipPath>'
    pair = '<rect width="9" height="9" clip-path="url(#c)"/>' * 2
    for units, groups in (("userSpaceOnUse", 1), ("objectBoundingBox", 2)):
        drawing = read(clip.format(units) + pair)
        assert len({element.style.effects for element in drawing.elements}) == groups


def test_what_is_left_out_of_the_root_is_said() -> None:
    def said(fitting: str) -> bool:
        head = HEAD.replace(">", f' preserveAspectRatio="{fitting}">')
        notes = read_svg((head + SQUARE + "</svg>").encode()).notes
        return "root-fitting" in {note.code for note in notes}

    assert said("none") and said("xMinYMin") and said("xMidYMid slice")
    assert not said("xMidYMid") and not said("xMidYMid meet")
