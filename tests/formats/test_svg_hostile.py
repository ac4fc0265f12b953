"""Files that are broken or mean harm: a clear error or a result with notes, in bounded time."""

from __future__ import annotations

import gzip
import resource
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from ipmlang.formats import FormatError
from ipmlang.formats.svg import Limits, read_node, read_svg, svg_ids

SVG = b'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">'
RECT = b'<rect width="5" height="5"/>'


@pytest.fixture(autouse=True)
def bounded() -> Iterator[None]:
    """No test here may burn more than a few seconds of CPU or grow past a gigabyte."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.process_time()
    yield
    assert time.process_time() - start < 10
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert after < 1_500_000 or after == before  # in KiB; tests before this one count, too


def notes(data: bytes) -> dict[str, int]:
    """The notes of a reading, counted by code."""
    return {note.code: note.count for note in read_svg(data).notes}


def refused(data: bytes | Path, limits: Limits | None = None) -> FormatError:
    """The error that reading must end in."""
    with pytest.raises(FormatError) as caught:
        read_svg(data, limits=limits)
    assert "\n" not in caught.value.message
    return caught.value


@pytest.mark.parametrize("data", [b"", b"  \n", b"hello", b"\x00\x01", b"\xff\xfe\x00", b"<svg"])
def test_what_is_not_xml(data: bytes) -> None:
    """An error with a line, whatever the bytes."""
    assert refused(data).line == 1


def test_what_is_not_svg() -> None:
    """Another format is named."""
    assert "<html>" in refused(b"<html><svg/></html>").message


def test_cut_off_file_names_its_line(data: Path) -> None:
    """XML that ends too early."""
    assert refused(SVG + b"\n<g>\n<rect").line == 3
    assert refused(data / "hostile" / "unclosed.svg").line == 1


def test_missing_file(tmp_path: Path) -> None:
    """The reason the system gives."""
    assert "No such file" in refused(tmp_path / "none.svg").message


def test_entities(data: Path) -> None:
    """A bomb is refused; a harmless entity is left out and counted; nothing outside is opened."""
    assert "entit" in refused(data / "hostile" / "entity_bomb.svg").message
    attribute = b'<!DOCTYPE svg [<!ENTITY w "5">]>' + SVG + b'<rect width="&w;" height="5"/></svg>'
    assert len(read_svg(attribute).elements) == 1
    external = read_svg(data / "hostile" / "external_entity.svg")
    assert {note.code for note in external.notes} == {"entity", "image"}
    secret = Path("/etc/hostname")
    if secret.is_file():
        text = secret.read_text(encoding="utf-8").strip()
        assert all(text not in e.fragment.xml for e in external.elements if e.fragment)


def test_doctype_of_the_w3c_is_fine() -> None:
    """It is never fetched."""
    doctype = (
        b'<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" '
        b'"http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">'
    )
    assert len(read_svg(doctype + SVG + RECT + b"</svg>").elements) == 1


def test_depth(data: Path) -> None:
    """Nesting ends in an error, not in a recursion; what is just allowed works."""
    assert "256 deep" in refused(data / "hostile" / "empty_groups.svg").message
    assert "256 deep" in refused(SVG + b"<g>" * 1_000_000 + b"</g>" * 1_000_000 + b"</svg>").message
    deep = SVG + b"<g>" * 250 + RECT + b"</g>" * 250 + b"</svg>"
    assert len(read_svg(deep).elements) == 1
    text = b"<text>" + b"<tspan>" * 250 + b"a" + b"</tspan>" * 250 + b"</text>"
    assert len(read_svg(SVG + text + b"</svg>").elements) == 1


def test_use_cycles(data: Path) -> None:
    """Circles are cut where they close, and counted."""
    drawing = read_svg(data / "hostile" / "use_cycle.svg")
    assert len(drawing.elements) == 2
    assert {note.code: note.count for note in drawing.notes} == {"use-cycle": 2, "use-dangling": 1}
    assert len(read_svg(data / "hostile" / "resvg_indirect_recursive_3.svg").elements) == 2


def use_bomb(levels: int, leaf: bytes) -> bytes:
    """10 ** levels copies of `leaf`."""
    groups = [b'<g id="g0">' + leaf + b"</g>"]
    for level in range(levels):
        uses = b'<use href="#g%d"/>' % level * 10
        groups.append(b'<g id="g%d">' % (level + 1) + uses + b"</g>")
    return SVG + b"<defs>" + b"\n".join(groups[:-1]) + b"</defs>\n" + groups[-1] + b"</svg>"


def test_use_bombs() -> None:
    """Copies are counted before they are made; the place is named."""
    error = refused(use_bomb(9, RECT))
    assert error.message.startswith('<g id="g')
    assert "the limit is 1,000,000" in error.message
    assert error.line is not None
    assert refused(use_bomb(4, RECT), Limits(elements=5_000)).line is not None
    assert len(read_svg(use_bomb(3, RECT)).elements) == 1000


def test_use_bomb_of_nothing() -> None:
    """Copies that draw nothing are not made; those that hide it are bounded as well."""
    assert not read_svg(use_bomb(9, b"")).elements
    hidden = use_bomb(5, b'<rect visibility="hidden" width="1" height="1"/>')
    assert "too large" in refused(hidden).message


def test_all_use_all() -> None:
    """A complete graph of references has factorially many ways through it."""
    uses = b"".join(b'<use href="#g%d"/>' % i for i in range(12))
    groups = b"".join(b'<g id="g%d">' % i + uses + RECT + b"</g>" for i in range(12))
    refused(SVG + groups + b"</svg>", Limits(elements=20_000))


def test_marker_bomb() -> None:
    """Markers on the paths of markers multiply too."""
    path = b'<path d="M0 0' + b"h1" * 100 + b'" style="marker:url(#%s)"/>'
    markers = b"".join(
        b'<marker id="m%d">' % i + path % (b"m%d" % (i + 1)) + b"</marker>" for i in range(6)
    )
    refused(SVG + markers + path % b"m0" + b"</svg>", Limits(elements=20_000))


def test_copies_of_a_long_path() -> None:
    """A few elements may mean billions of segments."""
    long = b'<path id="p" d="M0 0' + b"h1" * 100_000 + b'"/>'
    refused(SVG + long + b'<use href="#p"/>' * 2000 + b"</svg>")


def test_bad_numbers(data: Path) -> None:
    """Bad items are skipped and counted; the rest is drawn."""
    drawing = read_svg(data / "hostile" / "bad_numbers.svg")
    assert len(drawing.elements) == 2
    counted = {note.code: note.count for note in drawing.notes}
    assert counted["singular-matrix"] == 1
    assert counted["transform"] == 1
    assert counted["path-data"] == 1
    assert counted["negative-size"] == 1


def test_overflow() -> None:
    """Coordinates that end up infinite leave their element out."""
    body = b'<g transform="scale(1e200)"><g transform="scale(1e200)">' + RECT + b"</g></g>" + RECT
    assert notes(SVG + body + b"</svg>") == {"singular-matrix": 1}
    path = b'<path d="M0 0L1e308 1e308l1e308 1e308"/><path d="M0 0A1e308 1 0 0 1 9 9"/>'
    drawing = read_svg(SVG + path + RECT + b"</svg>")
    assert len(drawing.elements) >= 1
    assert {note.code for note in drawing.notes} == {"not-finite"}


def test_long_path(data: Path) -> None:
    """400,000 segments in one attribute."""
    (element,) = read_svg(data / "hostile" / "huge_path.svg").elements
    assert element.outline is not None
    assert len(element.outline.kind) > 390_000


def test_long_attribute() -> None:
    """An attribute of more than ten million characters, which XML parsers refuse at first."""
    (element,) = read_svg(SVG + b'<path d="M0 0' + b" " * 11_000_000 + b'h1"/></svg>').elements
    assert element.outline is not None


def test_size_limit() -> None:
    """Bytes are limited, also when they are packed."""
    limits = Limits(bytes=1000)
    assert "1,000 bytes" in refused(SVG + b" " * 2000 + b"</svg>", limits).message
    packed = gzip.compress(SVG + b" " * 100_000_000 + b"</svg>")
    assert "1,000 bytes" in refused(packed, limits).message
    assert len(read_svg(gzip.compress(SVG + RECT + b"</svg>")).elements) == 1
    assert "gzip" in refused(b"\x1f\x8bnot packed").message


@pytest.mark.parametrize(
    "css",
    [
        b"*" + b" *" * 200 + b"{fill:red}",
        b"x " + b"* " * 8 + b"{fill:red}",
        b"a ~ b ~ c ~ *{fill:red}",
        b"rect:nth-of-type(2n+1){fill:red}" * 30,
        b"@media all{" * 100_000,
        b"rect{fill:" + b"(" * 100_000 + b"}",
        b":not(" * 5_000 + b"*" + b")" * 5_000 + b"{fill:red}",
        b".a{fill:red}" * 20_000,
        b":root{--a:var(--b)var(--b);--b:var(--c)var(--c);--c:var(--a)var(--a)}rect{fill:var(--a)}",
        b"{}}}}{{{;;;@@@@!!!",
    ],
    ids=range(10),
)
def test_style_sheet_bombs(css: bytes) -> None:
    """Style sheets may be refused or half understood, but never take for ever."""
    body = (b"<g>" * 60 + RECT * 20 + b"</g>" * 60) + b"<a/>" + RECT * 2000
    data = SVG + b"<style><![CDATA[" + css + b"]]></style>" + body + b"</svg>"
    try:
        assert len(read_svg(data).elements) == 2020
    except FormatError as error:
        assert "style sheets" in error.message


def test_definitions_that_refer_in_circles() -> None:
    """Gradients, patterns, clips and masks may refer to themselves or each other."""
    body = (
        b'<linearGradient id="a" href="#b"/><linearGradient id="b" href="#a"/>'
        b'<pattern id="p" width="1" height="1">'
        b'<rect width="1" height="1" fill="url(#p)"/></pattern>'
        b'<clipPath id="c" clip-path="url(#c)"><rect clip-path="url(#c)"/></clipPath>'
        b'<mask id="m"><use href="#u"/></mask><g id="u" mask="url(#m)">' + RECT + b"</g>"
        b'<rect width="1" height="1" fill="url(#a)"/><rect width="1" height="1" fill="url(#p)"/>'
        b'<rect width="1" height="1" clip-path="url(#c)" mask="url(#m)"/>'
    )
    assert len(read_svg(SVG + body + b"</svg>").elements) == 4


def test_definitions_that_multiply() -> None:
    """A chain of patterns, each painted with the next, is copied once, not 2^n times."""
    chain = b"".join(
        b'<pattern id="p%d" width="1" height="1">' % i
        + b'<rect width="1" height="1" fill="url(#p%d)"/>' % (i + 1) * 2
        + b"</pattern>"
        for i in range(60)
    )
    body = chain + b'<rect width="1" height="1" fill="url(#p0)"/>'
    assert len(read_svg(SVG + body + b"</svg>").elements) == 1


def test_carried_text_is_bounded() -> None:
    """A long text used many times is refused before memory is full."""
    text = b'<text id="t">' + b"x" * 100_000 + b"</text>" + b'<use href="#t"/>' * 10_000
    assert "too much text" in refused(SVG + text + b"</svg>").message


def test_scripts_are_not_carried() -> None:
    """Foreign content comes without scripts and event attributes."""
    body = (
        b'<foreignObject onload="alert(1)"><p xmlns="http://www.w3.org/1999/xhtml" '
        b'onclick="alert(2)">hi</p><script>alert(3)</script></foreignObject>'
    )
    (element,) = read_svg(SVG + body + b"</svg>").elements
    assert element.fragment is not None
    assert "alert" not in element.fragment.xml
    assert '<p xmlns="http://www.w3.org/1999/xhtml">hi</p>' in element.fragment.xml


def test_one_node(tmp_path: Path) -> None:
    """A node comes in its own coordinates; what is not there is an error with what is."""
    path = tmp_path / "parts.svg"
    path.write_bytes(
        SVG + b'<g transform="scale(9)" fill="red"><g id="a" transform="translate(1 2)">' + RECT
        + b'</g></g><symbol id="s" viewBox="0 0 1 1">' + RECT + b"</symbol></svg>"
    )  # fmt: skip
    (element,) = read_node(path, "a").elements
    assert element.outline is not None
    assert element.outline.coords[0, 0].tolist() == [1, 2]
    assert element.style.fill == "#ff0000"
    (inner,) = read_node(path, "s").elements
    assert inner.outline is not None
    assert inner.outline.coords[0, 1].tolist() == [5, 0]
    assert svg_ids(path) == {"a", "s"}
    with pytest.raises(FormatError) as caught:
        read_node(path, "b")
    assert caught.value.hint == "it has a, s"
