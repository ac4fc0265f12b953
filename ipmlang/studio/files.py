"""Picture files: one picture, a moving one, or a numbered row of them.

Takes pixels and the path that a person named; gives the contents of files, ready to be written
whole. Names that say no format are refused before any work. Nothing is drawn or written here.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import fail
from ipmlang.formats.atomic import Content

Pixels = NDArray[np.uint8]

STILL = (".png", ".webp", ".jpg", ".jpeg")
MOVING = (".webp", ".gif", ".apng")
TURN = 4.0  # seconds that a whole turn takes
_NUMBERED = re.compile(r"%(0?)(\d*)d")
_FORMATS = {".png": "PNG", ".apng": "PNG", ".webp": "WEBP", ".gif": "GIF", ".jpg": "JPEG"}
_FORMATS[".jpeg"] = "JPEG"
_SETTINGS: dict[str, dict[str, object]] = {
    "JPEG": {"quality": 92},
    "WEBP": {"quality": 90, "method": 4},
}


def check_picture(path: Path, count: int | None) -> None:
    """Refuse a file that could not be written; `count` is None for a picture that stands."""
    known = STILL if count is None or is_numbered(path) else MOVING
    suffix = path.suffix.lower()
    if suffix not in known:
        listed = f"{', '.join(known[:-1])} or {known[-1]}"
        more = "" if count is None else "; or number pictures: name-%03d.png"
        hint = f"name a file that ends in {listed}{more}"
        raise fail("unknown-format", f"`{path.name}` does not say what to write", hint=hint)
    if not path.absolute().parent.is_dir():
        message = f"cannot write `{path}`: there is no folder `{path.parent}`"
        raise fail("cannot-write", message, hint="make the folder first, or name one that exists")


def is_numbered(path: Path) -> bool:
    """Whether the name has a place for a number: turn-%03d.png."""
    return _NUMBERED.search(path.name) is not None


def numbered(path: Path, number: int) -> Path:
    """The name with the number in its place.

    >>> numbered(Path("turn-%03d.png"), 7).name
    'turn-007.png'
    """

    def put(found: re.Match[str]) -> str:
        return str(number).rjust(int(found[2] or 0), "0" if found[1] else " ")

    return path.with_name(_NUMBERED.sub(put, path.name, count=1))


def contents(path: Path, pictures: Iterator[Pixels], count: int | None) -> Mapping[Path, Content]:
    """The files of a result by path; numbered pictures are drawn while they are written."""
    if count is None:
        return {path: encoded(next(pictures), path.suffix)}
    if is_numbered(path):
        return {numbered(path, number): _later(pictures, path.suffix) for number in range(count)}
    return {path: animated(list(pictures), path.suffix)}


def _later(pictures: Iterator[Pixels], suffix: str) -> Iterator[bytes]:
    yield encoded(next(pictures), suffix)


def encoded(pixels: Pixels, suffix: str) -> bytes:
    """The bytes of a picture (height, width, 4) in the format of a suffix."""
    return _saved([pixels], suffix)


def animated(pictures: list[Pixels], suffix: str) -> bytes:
    """The bytes of a picture that moves, for ever and once around in four seconds."""
    pause = max(20, round(1000 * TURN / len(pictures)))  # milliseconds; viewers refuse less
    return _saved(pictures, suffix, save_all=True, duration=pause, loop=0)


def _saved(pictures: list[Pixels], suffix: str, **options: object) -> bytes:
    from PIL import Image, features

    kind = _FORMATS[suffix.lower()]
    if kind == "WEBP" and not features.check("webp"):
        hint = "name a .png, or a .gif if it moves"
        raise fail("cannot-write", "this Pillow was built without WebP", hint=hint)
    solid = all((each[:, :, 3] == 255).all() for each in pictures)
    images = [
        Image.fromarray(each).convert("RGB" if solid or kind == "JPEG" else "RGBA")
        for each in pictures
    ]
    options |= _SETTINGS.get(kind, {})
    if len(images) > 1:
        options["append_images"] = images[1:]
    stream = io.BytesIO()
    images[0].save(stream, kind, **options)
    return stream.getvalue()
