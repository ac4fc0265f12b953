"""Compound paths come apart exactly where the picture cannot change."""

from __future__ import annotations

import numpy as np
import pytest

from ipmlang.formats.drawing import Drawing
from ipmlang.formats.svg import read_svg, split_compound


def parts(path: str) -> list[int]:
    """The number of subpaths of each element after splitting one `<path …/>`."""
    text = f'<svg xmlns="http://www.w3.org/2000/svg"><path {path}/></svg>'
    drawing = split_compound(read_svg(text.encode()))
    return [len(e.outline.closed) for e in drawing.elements if e.outline is not None]


APART = "M0 0h9v9h-9zM20 0h9v9h-9z"
HOLE = "M0 0h9v9h-9zM3 3v3h3v-3z"
SPIKE = "M0 0L20 1L0 2zM25 0h9v2h-9z"
CROSSING = "M0 0L9 9M9 0L0 9"


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        (f'd="{APART}"', [1, 1]),
        (f'd="{HOLE}"', [2]),
        (f'd="{HOLE}M30 30h1v1z"', [2, 1]),
        (f'd="M30 30h1v1z{HOLE}"', [1, 2]),
        (f'd="{HOLE}" fill="none" stroke="red"', [1, 1]),
        (f'd="{HOLE}" fill="none"', [1, 1]),
        (f'd="{CROSSING}" stroke="red"', [1, 1]),
        (f'd="{CROSSING}" stroke="red" stroke-opacity=".5"', [2]),
        (f'd="{CROSSING}" stroke="#ff000080"', [2]),
        (f'd="{CROSSING}" stroke="red" opacity=".5"', [2]),
        (f'd="{APART}" stroke="red" stroke-linejoin="round" stroke-width="10"', [1, 1]),
        (f'd="{APART}" stroke="red" stroke-linejoin="round" stroke-width="12"', [2]),
        (f'd="{APART}" stroke="red" stroke-width="10"', [1, 1]),
        (f'd="{SPIKE}" stroke="red" stroke-width="2"', [1, 1]),
        (f'd="{SPIKE}" stroke="red" stroke-width="2" stroke-miterlimit="40"', [2]),
        ('d="M0 0h1v1zM1 1h1v1z"', [2]),
        ('d="M0 0h1"', [1]),
    ],
)
def test_what_stays_together(path: str, expected: list[int]) -> None:
    """Fills join what overlaps, translucent pens what they cross, opaque pens nothing."""
    assert parts(path) == expected


def test_chains_of_overlaps() -> None:
    """Squares that touch only through others are one, in a long row too."""
    row = "".join(f"M{i} {i % 7}h1v2h-1z" for i in range(1000))
    assert parts(f'd="{row}"') == [1] * 0 + sorted(parts(f'd="{row}"'), reverse=True)
    assert sum(parts(f'd="{row}"')) == 1000
    touching = "".join(f"M{i} 0h1v2h-1z" for i in range(1000))
    assert parts(f'd="{touching}M0 9h1v1z"') == [1000, 1]


def test_against_all_pairs() -> None:
    """The same groups as joining every pair of boxes that touch, the slow way."""
    random = np.random.default_rng(5)
    corners = random.uniform(0, 40, (200, 2)).round(3)
    data = "".join(f"M{x} {y}h2v2h-2z" for x, y in corners)
    groups = list(range(len(corners)))
    for i, a in enumerate(corners):
        for j, b in enumerate(corners[:i]):
            if (np.abs(a - b) <= 2).all():
                old, new = groups[i], groups[j]
                groups = [new if group == old else group for group in groups]
    sizes = [groups.count(group) for group in dict.fromkeys(groups)]
    assert sorted(parts(f'd="{data}"')) == sorted(sizes)


def test_pieces_keep_geometry_and_style() -> None:
    """Nothing is moved or restyled, and order is kept."""
    text = f'<svg xmlns="http://www.w3.org/2000/svg"><path id="p" fill="red" d="{APART}"/></svg>'
    whole: Drawing = read_svg(text.encode())
    first, second = split_compound(whole).elements
    assert first.style == second.style == whole.elements[0].style
    assert first.source == ("p",)
    assert first.outline is not None and second.outline is not None
    assert second.outline.coords[0, 0].tolist() == [20, 0]
    assert second.outline.starts.tolist() == [0, 4]
