"""Groups whose parts are painted among others and moved by noise are still rules: a half of a
drawing and its mirror image, in any paint order, given back exactly.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from inverse.provenance import sites
from inverse.synth import circle, copies, drawing, leaf, mirror_cell, polygon, rectangle, star

from ipmlang.formats.drawing import Drawing, DrawnElement
from ipmlang.formats.svg.write import write_svg
from ipmlang.inverse import Inference, infer

SHEET = (0.0, 0.0, 200.0, 200.0)
SHAPES = (leaf(7), rectangle(6, 3), star(5, 4, 1.7), leaf(5))


def halves(jitter: float, seed: int = 0, mirror: bool = True) -> list[DrawnElement]:
    """Eight shapes and their images, in no order."""
    random = np.random.default_rng(seed)
    made: list[DrawnElement] = []
    for number in range(8):
        cell = np.array([[0.0, 0.0, 0.0, 1.0, 1.0]])
        cell[0, :2] = random.uniform(8, 90), random.uniform(-90, 90)
        cell[0, 2:4] = random.uniform(-180, 180), random.uniform(0.8, 1.6)
        both = mirror_cell(cell, 0.0) if mirror else np.concatenate([cell, cell])
        both[:, :2] += 100.0, 100.0
        if not mirror:
            both[:, 0] = random.uniform(0, 200, 2)
        both[:, :2] += random.uniform(-jitter, jitter, (2, 2))
        made += copies(SHAPES[number % len(SHAPES)], both)
    return [made[row] for row in random.permutation(len(made)).tolist()]


def made_of(elements: list[DrawnElement], folder: Path, symmetrize: bool = False) -> Inference:
    sheet: Drawing = drawing(elements, SHEET)
    path = folder / "halves.svg"
    path.write_text(write_svg(sheet), encoding="utf-8")
    return infer(path, symmetrize=symmetrize)


def grouped(found: Inference, folder: Path) -> int:
    """How many elements stand under the largest rule that is used twice or more."""
    found.save(folder / "halves.ipm")
    shared = [len(each.boxes) for each in sites(found.grammar, folder) if each.shared]
    return max(shared, default=0)


@pytest.mark.parametrize("jitter", [0.0, 0.01, 0.1])
def test_a_half_and_its_mirror_image_are_one_rule(jitter: float, tmp_path: Path) -> None:
    found = made_of(halves(jitter), tmp_path)
    assert grouped(found, tmp_path) == 16
    assert "mirror" in found.text
    assert found.report.max_error <= 1e-6
    assert ("x, y" in found.text or "Rest" in found.text) == (jitter > 0)


def test_what_noise_moved_is_left_out_of_the_regular_grammar(tmp_path: Path) -> None:
    found = made_of(halves(0.05), tmp_path, symmetrize=True)
    assert grouped(found, tmp_path) == 16
    assert found.report.max_error > 1e-6
    assert "Rest" not in found.text


def test_pairs_that_no_similarity_shares_are_no_group(tmp_path: Path) -> None:
    found = made_of(halves(0.0, mirror=False), tmp_path)
    assert found.report.rules == 0


def test_few_pairs_are_no_group(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    lone = [polygon(random.uniform(-4, 4, (5, 2))) for _ in range(6)]
    placed = np.zeros((1, 5))
    placed[0] = 30.0, 40.0, 10.0, 1.0, 1.0
    elements = [each for shape in lone for each in copies(shape, placed + random.uniform(0, 9))]
    elements += halves(0.0)[:2]
    assert made_of(elements, tmp_path).report.rules == 0


def test_circles_follow_what_mirrors_the_other_parts(tmp_path: Path) -> None:
    elements = halves(0.01)
    for number, radius in enumerate((2.0, 3.0)):
        cell = np.array([[20.0 + 30 * number, 40.0, 0.0, 1.0, 1.0]])
        both = mirror_cell(cell, 0.0)
        both[:, :2] += 100.0, 100.0
        dots = copies(circle(radius), both)
        elements = [dots[0], *elements, dots[1]]
    assert grouped(made_of(elements, tmp_path), tmp_path) == 20


@pytest.mark.parametrize("jitter", [0.0, 0.02])
def test_a_third_turned_twice_more_is_one_rule(jitter: float, tmp_path: Path) -> None:
    random = np.random.default_rng(1)
    made: list[DrawnElement] = []
    for number in range(6):
        arm = complex(*random.uniform((20, -30), (80, 30))) * np.exp(2j * np.pi * np.arange(3) / 3)
        placed = np.ones((3, 5))
        placed[:, 0], placed[:, 1] = 100 + arm.real, 100 + arm.imag
        placed[:, :2] += random.uniform(-jitter, jitter, (3, 2))
        placed[:, 2] = random.uniform(-180, 180) + 120 * np.arange(3)
        made += copies(SHAPES[number % len(SHAPES)], placed)
    made = [made[row] for row in random.permutation(len(made)).tolist()]
    found = made_of(made, tmp_path)
    assert grouped(found, tmp_path) == 18
    assert found.report.rules == 1


def test_a_pair_of_parts_and_a_third_are_a_group_where_they_are_exact(tmp_path: Path) -> None:
    random = np.random.default_rng(2)
    sure: list[DrawnElement] = []
    lone: list[DrawnElement] = []
    left = np.array([[12.0, 5.0, 10.0, 1.0, 1.0], [19.0, 9.0, 70.0, 1.2, 1.0]])
    for shape, cell in zip((leaf(7), leaf(5)), left, strict=True):
        both = mirror_cell(cell[None], 0.0)
        both[:, :2] += 100.0, 100.0
        sure += copies(shape, both)
    far = mirror_cell(np.array([[60.0, -40.0, 33.0, 1.0, 1.0]]), 0.0)
    far[:, :2] += 100.0, 100.0
    ends = copies(star(5, 4, 1.7), far)
    for _ in range(6):
        at = np.array([[*random.uniform(10, 190, 2), 0.0, 1.0, 1.0]])
        lone += copies(polygon(random.uniform(-4, 4, (5, 2))), at)
    ranked = [sure[0], sure[2], ends[0], *lone[1:], sure[1], sure[3], lone[0], ends[1]]
    assert grouped(made_of(ranked, tmp_path), tmp_path) == 6
