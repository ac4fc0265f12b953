"""What is worked out for many polygons at once is what the general algorithms give of each by
itself: on thousands of random polygons, those that nearly touch or nearly vanish among them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from ipmlang.geometry.faces import faces, faces_of
from ipmlang.geometry.footprints import footprint, sound
from ipmlang.geometry.pieces import Piece
from ipmlang.geometry.raising import extrude, extrusions
from ipmlang.geometry.setbacks import setback
from ipmlang.geometry.setbacks_together import setbacks
from ipmlang.geometry.solid import Floats, GeometryError, Solid, makeup, polygon

MANY = 1500


def ring(draw: np.random.Generator) -> Floats:
    """A star of 3 to 8 corners somewhere, or a near-rectangle; some have corners in one place or in
    one line.
    """
    if draw.random() < 0.5:
        w, h = draw.uniform(1, 20, 2)
        points = np.array([(0, 0), (w, 0), (w, h), (0, h)]) + draw.uniform(-1, 1, (4, 2))
    else:
        angles = np.sort(draw.uniform(0, 2 * np.pi, draw.integers(3, 9)))
        radii = draw.uniform(2, 12, len(angles))
        points = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)
    if draw.random() < 0.1:
        points[1] = points[0] + draw.choice([0.0, 1e-12, 1e-6]) * (points[2] - points[0])
    moved: Floats = points + draw.uniform(-50, 50, 2)
    return moved


def lots(seed: int, count: int = MANY) -> list[Solid]:
    draw = np.random.default_rng(seed)
    return [polygon(ring(draw), tags=["lot"] * int(draw.integers(0, 2))) for _ in range(count)]


def same(one: Solid, other: Solid) -> bool:
    """Whether two solids are the same to the last bit."""
    return makeup(one) == makeup(other) and bool((one.vertices == other.vertices).all())


def same_pieces(some: Sequence[Piece], others: Sequence[Piece]) -> bool:
    return len(some) == len(others) and all(
        a.words == b.words
        and same(a.solid, b.solid)
        and ((a.axes is None and b.axes is None) or np.array_equal(a.axes, b.axes))  # type: ignore[arg-type]
        for a, b in zip(some, others, strict=True)
    )


def test_setbacks_are_those_of_each_by_itself() -> None:
    polygons = lots(1)
    draw = np.random.default_rng(2)
    widths = draw.uniform(0, 2, (MANY, 4)) * (draw.random((MANY, 4)) < 0.8)
    widths[:, 1:][draw.random((MANY, 3)) < 0.4] = np.nan
    served = 0
    for one, row, made in zip(polygons, widths, setbacks(polygons, widths), strict=True):
        if made is not None:
            given = [None if np.isnan(each) else float(each) for each in row]
            assert given[0] is not None
            assert same_pieces(made, setback(one, given[0], *given[1:]))
            served += 1
    assert served > MANY / 2


def test_outlines_that_are_sound_are_taken_as_they_are() -> None:
    draw = np.random.default_rng(7)
    rings = [ring(draw)[:: -1 if k % 7 == 0 else 1] for k in range(MANY)]
    rings += [np.array([(0, 0), (2, 2), (2, 0), (0, 2)]), np.array([(0, 0), (1, 0), (2, 0)]),
              np.array([(0, 0), (np.nan, 0), (1, 1)]), np.zeros((2, 2)),
              np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0.1)])]  # fmt: skip
    taken = sound(rings).tolist()
    assert not any(taken[MANY:])
    assert sum(taken) > MANY / 2
    for one, yes in zip(rings, taken, strict=True):
        if yes:
            (made,), notes = footprint([one])
            assert not notes
            assert same(made, polygon(one))


def test_extrusions_are_those_of_each_by_itself() -> None:
    polygons = lots(3, 300)
    heights = np.random.default_rng(4).choice([3.0, -2.0, 0.0, 1e-7], len(polygons))
    up = np.tile((0.0, 0.6, 0.8), (len(polygons), 1))
    for directions in (None, up):
        many = extrusions(polygons, heights, directions)
        for one, height, made in zip(polygons, heights.tolist(), many, strict=True):
            if made is None:
                with pytest.raises(GeometryError):
                    extrude(one, height, None if directions is None else up[0])
                continue
            alone = extrude(one, height, None if directions is None else up[0])
            assert makeup(made) == makeup(alone)
            assert made.vertices == pytest.approx(alone.vertices, abs=1e-12)


def test_faces_are_those_of_each_by_itself() -> None:
    solids = [extrude(one, 2.0) for one in lots(5, 200)] + lots(6, 100)
    for one, many in zip(solids, faces_of(solids), strict=True):
        assert same_pieces(many, faces(one))
