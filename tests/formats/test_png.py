"""Drawings as pictures."""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from ipmlang.formats import FormatError, png
from ipmlang.formats.drawing import LINE
from ipmlang.formats.png import png_bytes, write_png
from tests.formats.outlines import drawing, outline

SQUARE = outline([LINE] * 3, [[10, 10, 60, 10], [60, 10, 60, 40], [60, 40, 10, 10]], closed=True)


def test_a_picture_has_the_drawing_in_it(tmp_path: Path) -> None:
    """Black inside, white outside, the right size."""
    from PIL import Image

    write_png(drawing(SQUARE, box=(0, 0, 100, 50)), tmp_path / "a.png", 200)
    picture = Image.open(tmp_path / "a.png").convert("RGB")
    assert picture.size == (200, 100)
    assert picture.getpixel((100, 30)) == (0, 0, 0)
    assert picture.getpixel((190, 90)) == (255, 255, 255)


def test_a_transparent_picture() -> None:
    """No background where none is wanted."""
    from PIL import Image

    found = png_bytes(drawing(SQUARE, box=(0, 0, 100, 50)), 100, transparent=True)
    assert Image.open(io.BytesIO(found)).convert("RGBA").getpixel((95, 45)) == (0, 0, 0, 0)


def test_a_tall_drawing_is_bounded() -> None:
    """Nothing asks for pictures larger than libraries make."""
    assert png._pixels(1.0, 1e6, 1200) == (1, 16_384)
    with pytest.raises(FormatError, match="pixels wide"):
        png_bytes(drawing(SQUARE), 0)
    with pytest.raises(FormatError, match="no area"):
        png_bytes(drawing(SQUARE, box=(0, 0, 0, 5)), 10)


def test_a_picture_process_that_takes_too_long_or_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both end as plain errors."""
    with pytest.raises(FormatError, match="seconds"):
        png_bytes(drawing(SQUARE), seconds=0.001)
    monkeypatch.setattr(png, "write_svg", lambda _: "<svg")
    with pytest.raises(FormatError, match="cannot make the picture"):
        png_bytes(drawing(SQUARE))
