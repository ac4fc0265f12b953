"""What a person may choose about a picture, and the words for it on a command line.

Takes the texts after `--size`, `--view` and `--background`; gives a `Look`, or the `IpmError` of a
wrong command. Nothing is drawn here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

from ipmlang.compiler.diagnostics import fail, nearest

Background: TypeAlias = tuple[float, float, float, float]
"""Red, green, blue and opacity, 0 to 1, as shown on a screen (sRGB)."""

LARGEST = 8192  # pixels of a side: what software drawing manages in memory


@dataclass(frozen=True, slots=True)
class View:
    """Where the camera stands, in degrees: `azimuth` from the front (0) to the right (90) and the
    back (180), `elevation` above the horizon.
    """

    azimuth: float
    elevation: float


VIEWS = {
    "front": View(0.0, 0.0),
    "right": View(90.0, 0.0),
    "back": View(180.0, 0.0),
    "left": View(270.0, 0.0),
    "top": View(0.0, 90.0),
    "iso": View(32.0, 22.0),
}


@dataclass(frozen=True, slots=True)
class Look:
    """How a picture is made: pixels across and down (None: as many as suit it), the view, a ground
    that takes shadows, what is behind (None: a soft grey backdrop), and whether edges are drawn.
    """

    size: tuple[int, int] | None = None
    view: View = VIEWS["iso"]
    ground: bool = True
    background: Background | None = None
    lines: bool = False

    def pixels(self, count: int | None) -> tuple[int, int]:
        """Pixels across and down of a picture that stands (None), or of one of `count`."""
        return self.size or ((1600, 1000) if count is None else (800, 500))


def parse_size(word: str) -> tuple[int, int]:
    """Pixels across and down.

    >>> parse_size("1600x1000")
    (1600, 1000)
    """
    across, _, down = word.lower().partition("x")
    try:
        size = int(across), int(down)
    except ValueError:
        size = 0, 0
    if not all(1 <= side <= LARGEST for side in size):
        hint = f"write --size WIDTHxHEIGHT, each 1 to {LARGEST}, for example --size 1600x1000"
        raise fail("bad-command", f"`--size {word}` is no size", hint=hint)
    return size


def parse_view(word: str) -> View:
    """A view by its name or its two angles.

    >>> parse_view("right"), parse_view("-30,15")
    (View(azimuth=90.0, elevation=0.0), View(azimuth=-30.0, elevation=15.0))
    """
    if word in VIEWS:
        return VIEWS[word]
    azimuth, comma, elevation = word.partition(",")
    try:
        view = View(float(azimuth), float(elevation))
    except ValueError:
        view = View(math.nan, math.nan)
    if math.isfinite(view.azimuth) and abs(view.elevation) <= 90:
        return view
    meant = nearest(word, VIEWS)
    known = f"{', '.join(VIEWS)} or AZIMUTH,ELEVATION in degrees, for example 30,20"
    hint = f"did you mean {meant[0]}?" if meant and not comma else f"there are {known}"
    raise fail("bad-command", f"`--view {word}` is no view", hint=hint)


def parse_background(word: str) -> Background | None:
    """A colour, nothing, or None for the backdrop.

    >>> parse_background("white"), parse_background("transparent"), parse_background("studio")
    ((1.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 0.0), None)
    """
    from ipmlang.formats.svg.color import parse_color

    if word == "studio":
        return None
    if word == "transparent":
        return 0.0, 0.0, 0.0, 0.0
    found = parse_color(word)
    if found is None:
        hint = "write a colour (#f4f1ec, white), transparent, or studio"
        raise fail("bad-command", f"`--background {word}` is no colour", hint=hint)
    digits, alpha = found
    red, green, blue = (int(digits[k : k + 2], 16) / 255 for k in (1, 3, 5))
    return red, green, blue, alpha
