"""Real drawings, read whole: how many elements, what is carried through, and the same picture."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray

from ipmlang.formats.drawing import Drawing
from ipmlang.formats.svg import read_svg, split_compound
from ipmlang.formats.svg.write import write_svg
from tests.real_drawings import parted, path_of, whole

Pixels: TypeAlias = NDArray[np.float64]

# Outlines drawn, subpaths in them, texts and images.
COUNTS = {
    "batik_cards": (376, 376, 104),
    "batik_mapSpain": (678, 708, 152),
    "batik_moonPhases": (214, 214, 13),
    "batik_sunRise": (98, 98, 4),
    "batik_symbolViewBox": (409, 409, 17),
    "cad_ex13": (148, 148, 0),
    "cad_lego": (406, 406, 0),
    "cad_line_types": (874, 1171, 0),
    "cad_packed_boxes": (600, 600, 0),
    "flag_eu": (121, 121, 0),
    "flag_ir": (164, 453, 0),
    "flag_ni": (163, 222, 0),
    "flag_us": (54, 59, 0),
    "flag_uz": (126, 126, 0),
    "flag_ve": (83, 83, 0),
    "knotwork": (44, 128, 0),
    "lsys_dragon": (8193, 8193, 0),
    "lsys_plant": (6049, 6049, 0),
    "lsys_plant_stochastic": (6049, 6049, 0),
    "mandala": (369, 369, 0),
    "map_usa_counties": (3142, 3344, 0),
    "pattern_tile": (3, 3, 0),
    "pcb_moire": (10, 10, 0),
    "resvg_image": (18, 18, 0),
    "resvg_use_nested": (1, 1, 0),
    "vega_small_multiples": (293, 293, 154),
    "vpype_7k_lines": (7000, 7000, 0),
    "vpype_circlelines": (715, 715, 0),
    "vpype_halftone": (1, 2464, 0),
    "vpype_multi_skull": (8744, 8744, 0),
}


def outlines(drawing: Drawing) -> int:
    """How many elements are outlines."""
    return sum(element.outline is not None for element in drawing.elements)


@pytest.mark.parametrize("name", COUNTS)
def test_counts(data: Path, name: str) -> None:
    """Everything that is drawn is there, nothing is skipped as wrong."""
    drawing = whole(name)
    subpaths = sum(len(e.outline.closed) for e in drawing.elements if e.outline is not None)
    found = outlines(drawing)
    assert (found, subpaths, len(drawing.elements) - found) == COUNTS[name]
    carried = {"text", "image", "gradient", "pattern", "filter", "clip-path", "background"}
    notes = {note.code for note in drawing.notes}
    assert notes <= carried | {"use-cycle", "use-external"}


def test_stars_and_stripes(data: Path) -> None:
    """50 stars by a marker, and stripes that are six strokes in one path."""
    drawing = parted("flag_us")
    stars = [e for e in drawing.elements if e.outline is not None and len(e.outline.kind) == 5]
    assert sum(element.style.fill == "#ffffff" for element in stars) == 50
    assert sum(element.style.stroke == "#ffffff" for element in drawing.elements) == 6


def test_dots(data: Path) -> None:
    """Every dot of a halftone is an element of its own."""
    assert outlines(parted("vpype_halftone")) == 2464


# librsvg draws nothing of a file with a circular reference, and overlapping rings taken apart have
# lighter edges.
@pytest.mark.parametrize("name", sorted({*COUNTS} - {"resvg_use_nested", "vpype_halftone"}))
def test_same_picture(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Read and written again, whole or taken apart, a drawing looks the same to an independent
    renderer.
    """
    monkeypatch.setenv("LANGUAGE", "en")
    monkeypatch.setenv("LC_ALL", "en_US.UTF-8")
    path = path_of(name)
    drawing = read_svg(path)
    given = pixels(path.read_bytes().decode("latin-1").replace('encoding="iso-8859-1"', ""))
    for each in (drawing, split_compound(drawing)):
        made = pixels(write_svg(each))
        assert made.shape == given.shape
        # Edges may be rounded to another grey, a few pixels of the thinnest rings as well.
        blurred = np.abs(coarse(made) - coarse(given))
        assert blurred.max() < 40
        assert (blurred > 16).mean() < 0.002


def pixels(text: str) -> Pixels:
    """The drawing as (h, w, 4) values; absolute sizes are dropped, only the viewBox counts."""
    import pyvips

    end = text.find(">", text.find("<svg"))
    if "viewBox" in text[:end]:
        head = re.sub(r"""\s(width|height)=(["'])[^"']*\2""", "", text[:end])
        text = head + text[end:]
    image = pyvips.Image.svgload_buffer(text.encode(), unlimited=True)
    scaled = pyvips.Image.svgload_buffer(text.encode(), unlimited=True, scale=600 / image.width)
    return np.asarray(scaled.numpy(), dtype=np.float64)


def coarse(image: Pixels) -> Pixels:
    """Means of 3 x 3 pixels, so that the shade of an edge does not count."""
    height, width = (size // 3 * 3 for size in image.shape[:2])
    return image[:height, :width].reshape(height // 3, 3, width // 3, 3, 4).mean(axis=(1, 3))
