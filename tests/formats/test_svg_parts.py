"""Parts files are short, and what they hold comes back as it was."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipmlang.formats.drawing import (
    ARC,
    CUBIC,
    LINE,
    QUADRATIC,
    DrawnElement,
    Outline,
    PaintServer,
    Style,
)
from ipmlang.formats.svg import read_node, read_svg
from ipmlang.formats.svg.parts import write_parts
from ipmlang.formats.svg.paths import parse_path
from ipmlang.formats.svg.short_paths import short_path_texts
from tests.formats.outlines import outline, points

TOLERANCE = 1e-6


def short(one: Outline, allowed: float = TOLERANCE) -> str:
    """The text of one outline."""
    return short_path_texts([one], [allowed])[0]


def parsed(text: str) -> Outline:
    """The outline of path data."""
    data = parse_path(text)
    assert data.whole
    assert data.outline is not None
    return data.outline


@pytest.mark.parametrize(
    "text",
    [
        "M.5 1h4l-.5 2z",
        "M105 107h4L0 0z",
        "M0 0c1 2 3 4 5 5s3 4 5 5",
        "M0 0q1 2 3 4t5 5",
        "m3 3 1-1M9 7v2",
        "M100 100h1v1z",
        "M0 0a4 4 0 0 1 4 4v3",
    ],
)
def test_what_is_short_stays_as_it_is(text: str) -> None:
    """Text that could not be shorter is written again letter by letter."""
    assert short(parsed(text)) == text


def test_only_the_place_of_a_shape_needs_its_decimals() -> None:
    """Steps are short though no coordinate is."""
    made = parsed("M0.123457 7.654321h2.5v1.25h-2.5z")
    assert short(made, 1e-7) == "M.123457 7.654321h2.5v1.25h-2.5z"


@pytest.mark.parametrize("seed", range(20))
def test_random_paths_come_back(seed: int) -> None:
    """All kinds of segments, subpaths open and closed, at many scales."""
    random = np.random.default_rng(seed)
    count = 60
    size = 10.0 ** random.integers(-3, 6)
    coords = random.normal(0, 1, (count, 4, 2)).round(random.integers(2, 9)) * size
    coords[1:, 0] = coords[:-1, 3]
    kind = random.integers(LINE, CUBIC + 1, count).astype(np.uint8)
    for row in range(count):
        coords[row, kind[row]] = coords[row, 3]
        coords[row, kind[row] + 1 :] = 0
        if row + 1 < count:
            coords[row + 1, 0] = coords[row, kind[row]]
    starts = np.array([0, 7, 8, 31, count], np.int32)
    closed = np.array([False, False, True, False])
    one = Outline(kind, coords, starts, closed)
    found = parsed(short(one, 1e-6 * size))
    # A closing line of its own stands in the outline that is read.
    kept = np.concatenate([np.arange(31), np.arange(32, count + 1)])
    assert (found.kind[kept] == one.kind).all()
    off = np.abs(points(found)[:, kept] - points(one)).max()
    assert off <= 1.01e-6 * size


@pytest.mark.parametrize("sweep", [0.3, -1.0, 2.5, 3.14, np.pi, -np.pi, 4.0, -6.0, 6.28])
@pytest.mark.parametrize("radius", [20.0, 9.0, 0.01])
def test_arcs_keep_their_ellipse(sweep: float, radius: float) -> None:
    """Every point of what is read lies on the ellipse, also where ends say little about it."""
    u = np.array([np.cos(0.7), np.sin(0.7)]) * 20
    v = np.array([-np.sin(0.7), np.cos(0.7)]) * radius
    found = parsed(short(outline([ARC], [[50, 50, *u, *v, 0.4, sweep]])))
    local = np.linalg.solve(np.stack([u, v], axis=1), (points(found) - 50).reshape(-1, 2).T)
    assert np.abs(np.hypot(*local) - 1).max() * min(radius, 20) < 3 * TOLERANCE


def _read(path: Path, elements: dict[str, DrawnElement], **said: object) -> dict[str, DrawnElement]:
    text = write_parts({name: [each] for name, each in elements.items()}, **said)  # type: ignore[arg-type]
    path.write_text(text, encoding="utf-8")
    return {name: read_node(path, name).elements[0] for name in elements}


def test_shared_styles_are_said_once_and_read_everywhere(tmp_path: Path) -> None:
    """Groups say what many have in common; nobody gets what another said."""
    line = outline([LINE], [[0, 0, 5, 5]])
    pens = [Style(fill="none", stroke="#ff0000", stroke_width=0.5, dashes=(0.5, 1.0))] * 3
    pens += [Style(fill="none", stroke="#00ff00"), Style(), Style(more=(("opacity", "0.5"),))]
    pens += [Style(stroke="#ff0000", more=(("stroke-linecap", "round"),))]
    elements = {f"line_{k}": DrawnElement(line, pen) for k, pen in enumerate(pens)}
    path = tmp_path / "a.svg"
    found = _read(path, elements)
    assert [each.style for each in found.values()] == pens
    assert path.read_text(encoding="utf-8").count("dasharray") == 1


@pytest.mark.parametrize("pen", [None, 2.0, 0.3])
def test_numbers_of_the_file_that_drew_it_come_back(tmp_path: Path, pen: float | None) -> None:
    """What was drawn under a transform is written in the numbers from before it."""
    stroke = "" if pen is None else f' fill="none" stroke="#000" stroke-width="{pen}"'
    body = f'<g transform="scale(.0497602460870352)"><path d="m10 20 3 7 11-35 80 4"{stroke}/></g>'
    source = f'<svg xmlns="http://www.w3.org/2000/svg">{body}</svg>'
    element = read_svg(source.encode()).elements[0]
    assert element.space is not None
    path = tmp_path / "a.svg"
    found = _read(path, {"a": element}, allowed={"a": 1e-7}, spaces={"a": element.space})["a"]
    text = path.read_text(encoding="utf-8")
    assert "m10 20 3 7 11-35 80 4" in text
    assert found.style == element.style
    assert found.outline is not None
    assert element.outline is not None
    assert np.abs(points(found.outline) - points(element.outline)).max() <= 1e-7


def test_circles_are_circles_unless_their_start_shows(tmp_path: Path) -> None:
    """Dashes begin where the outline does."""
    turned = outline(
        [ARC, ARC], [[0, 0, 3, 0, 0, 3, 0, -np.pi], [0, 0, 3, 0, 0, 3, -np.pi, -np.pi]]
    )
    made = replace(turned, closed=np.array([True]))
    dashed = Style(stroke="#000000", dashes=(1.0,))
    elements = {"plain": DrawnElement(made, Style()), "dashed": DrawnElement(made, dashed)}
    path = tmp_path / "a.svg"
    found = _read(path, elements)
    assert path.read_text(encoding="utf-8").count('<circle id="plain" r="3"') == 1
    assert path.read_text(encoding="utf-8").count("<circle") == 1
    for each in found.values():
        assert each.outline is not None
        assert np.abs(np.hypot(*points(each.outline).reshape(-1, 2).T) - 3).max() < 1e-7


def test_gradients_say_how_they_differ_and_come_back(tmp_path: Path) -> None:
    """An earlier definition gives what is the same; what only it says is not inherited."""
    stop = '<stop offset="0" stop-color="#ff0000"/><stop offset="1" stop-color="#0000fe"/>'
    ends = 'gradientUnits="userSpaceOnUse" x1="0" y1="0" x2="{}" y2="0"{}'
    servers = [
        PaintServer("linearGradient", f"<linearGradient {said}>{stop}</linearGradient>", matrix)
        for said, matrix in [
            (ends.format(9, ""), (2.0, 0.0, 0.0, 2.0, 1.0, 0.0)),
            (ends.format(9, ""), (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)),
            (ends.format(5, ' spreadMethod="reflect"'), (1.0, 0.0, 0.0, 1.0, 0.0, 3.5)),
            (ends.format(5, ""), (0.0, 1.0, -1.0, 0.0, 0.0, 3.5)),
        ]
    ]
    line = outline([LINE], [[0, 0, 5, 5]])
    elements = {f"p_{k}": DrawnElement(line, Style(fill=each)) for k, each in enumerate(servers)}
    path = tmp_path / "a.svg"
    found = _read(path, elements)
    assert [each.style.fill for each in found.values()] == servers
    assert path.read_text(encoding="utf-8").count("#f00") == 1


def test_quadratic_handles_in_their_start_are_kept() -> None:
    """A parabola that begins with no direction is not taken for a smooth one."""
    one = outline([QUADRATIC, QUADRATIC], [[0, 0, 0, 0, 4, 4], [4, 4, 4, 4, 9, 0]])
    assert np.abs(points(parsed(short(one))) - points(one)).max() == 0
