"""viewBox and preserveAspectRatio: the map from a viewport's content to where it is placed."""

from __future__ import annotations

from ipmlang.formats.svg.transforms import Box, Matrix
from ipmlang.formats.svg.units import numbers

_ALIGN = {"min": 0.0, "mid": 0.5, "max": 1.0}


def parse_view_box(text: str | None) -> Box | None:
    """(x, y, width, height); None where it is absent, unreadable or of negative size.

    >>> parse_view_box("0 0 10,5"), parse_view_box("0 0 -1 5")
    ((0.0, 0.0, 10.0, 5.0), None)
    """
    values, whole = numbers(text or "")
    if not whole or len(values) != 4 or values[2] < 0 or values[3] < 0:
        return None
    if any(value in (float("inf"), float("-inf")) for value in values):
        return None
    return (values[0], values[1], values[2], values[3])


def fit(view: Box, target: Box, aspect: str | None) -> Matrix | None:
    """The map from the box `view` to the box `target`; None if one of them has no area.

    >>> fit((0, 0, 10, 10), (0, 0, 40, 20), "xMinYMid")
    (2.0, 0.0, 0.0, 2.0, 0.0, 0.0)
    """
    if min(view[2], view[3], target[2], target[3]) <= 0:
        return None
    sx, sy = target[2] / view[2], target[3] / view[3]
    words = (aspect or "").split()
    if words and words[0] == "defer":
        words = words[1:]
    align = words[0] if words else "xMidYMid"
    if align == "none":
        return (sx, 0.0, 0.0, sy, target[0] - view[0] * sx, target[1] - view[1] * sy)
    scale = max(sx, sy) if words[1:] == ["slice"] else min(sx, sy)
    left = _ALIGN.get(align[1:4].lower(), 0.5) * (target[2] - view[2] * scale)
    down = _ALIGN.get(align[5:8].lower(), 0.5) * (target[3] - view[3] * scale)
    return (
        scale,
        0.0,
        0.0,
        scale,
        target[0] + left - view[0] * scale,
        target[1] + down - view[1] * scale,
    )
