"""Drawings as PNG pictures.

Takes a `Drawing` and a width in pixels; gives the bytes of a PNG, on white unless asked otherwise.
librsvg draws it (from the wheel pyvips-binary, which needs no system library), in a process of its
own with limits on time and memory. Text appears in fonts of the machine, if it has any.
"""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path

from ipmlang.formats import FormatError
from ipmlang.formats.atomic import write_file
from ipmlang.formats.drawing import Drawing
from ipmlang.formats.svg.write import fitted_box, write_svg

_LARGEST = 16_384
_MEMORY = 6 << 30
_SECONDS = 120.0
_NO_LIBRARY = 3


def write_png(
    drawing: Drawing, path: Path | str, width: int = 1200, *, transparent: bool = False
) -> None:
    """Write a PNG of a drawing, `width` pixels wide (less if it would be over 16,384 high)."""
    write_file(path, png_bytes(drawing, width, transparent=transparent))


def png_bytes(
    drawing: Drawing, width: int = 1200, *, transparent: bool = False, seconds: float = _SECONDS
) -> bytes:
    """The PNG of a drawing; a `FormatError` says why there can be none."""
    box = drawing.box if drawing.box is not None else fitted_box(drawing.elements)
    across, down = _pixels(box[2], box[3], width)
    sized = dataclasses.replace(drawing, box=box, width=str(across), height=str(down))
    return _rasterized(write_svg(sized), transparent, seconds)


def _pixels(width: float, height: float, wanted: int) -> tuple[int, int]:
    if not 1 <= wanted <= _LARGEST:
        raise FormatError(f"a picture is 1 to {_LARGEST} pixels wide, not {wanted}")
    if width <= 0 or height <= 0:
        raise FormatError("the drawing has no area to make a picture of")
    down = wanted * height / width
    if down > _LARGEST:
        wanted, down = max(1, round(wanted * _LARGEST / down)), _LARGEST
    return wanted, max(1, round(down))


def _rasterized(svg: str, transparent: bool, seconds: float) -> bytes:
    program = Path(__file__).with_name("rasterize.py")
    background = "transparent" if transparent else "white"
    try:
        done = subprocess.run(
            [sys.executable, "-I", str(program), str(_MEMORY), background],
            input=svg.encode("utf-8"),
            capture_output=True,
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise FormatError(
            f"making the picture took over {seconds:g} seconds",
            hint="write an SVG instead, or ask for fewer pixels",
        ) from error
    except OSError as error:
        raise FormatError(f"cannot start the picture process: {error}") from error
    if done.returncode == 0 and done.stdout.startswith(b"\x89PNG"):
        return done.stdout
    said = done.stderr.decode("utf-8", "replace").strip().splitlines()
    reason = said[-1] if said else f"the picture process ended with code {done.returncode}"
    if done.returncode == _NO_LIBRARY:
        raise FormatError(
            f"PNG needs the library pyvips: {reason}", hint="pip install pyvips pyvips-binary"
        )
    raise FormatError(f"cannot make the picture: {reason}", hint="write an SVG instead")
