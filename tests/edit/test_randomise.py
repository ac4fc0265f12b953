"""Parameters that vary with the seed, by how much, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ipmlang
from ipmlang import IpmError, edit
from ipmlang.edit import Selection, amount


def drawn_at(path: Path, label: str, seed: int) -> np.ndarray:
    scene = ipmlang.load(path).run(seed=seed)
    return scene.instances.position[scene.instances.label == scene.labels.index(label), :2]


def test_an_amount_bounds_every_step_and_every_seed_differs(house: Path) -> None:
    out = house.with_name("wild.ipm")
    edit.save(edit.randomise(edit.read(house), Selection("Storey", "f"), amount("1.5")), out)
    assert "f(step + rand(-1.5, 1.5))" in out.read_text(encoding="utf-8")
    rows = [drawn_at(out, "frame", seed)[:4, 0] for seed in range(8)]
    steps = np.diff(rows, axis=1)
    assert np.abs(steps - 20).max() <= 1.5
    assert np.abs(steps - 20).max() > 1.0
    assert len({row.tobytes() for row in rows}) == 8
    assert np.array_equal(drawn_at(out, "frame", 3), drawn_at(out, "frame", 3))


def test_each_copy_draws_for_itself(house: Path) -> None:
    out = house.with_name("wild.ipm")
    edit.save(edit.randomise(edit.read(house), Selection("Wreath", "f"), amount("20%")), out)
    far = np.hypot(*(drawn_at(out, "leaf", 1) - (60, 70)).T)
    assert len(set(far.round(6))) == 6
    assert (far >= 4).all() and (far <= 6).all()


def test_a_share_of_an_angle_in_a_ring_is_one_of_the_step(house: Path) -> None:
    draft = edit.randomise(edit.read(house), Selection("Wreath", "+"), amount("10%"))
    assert "+(60 * (i + rand(-0.1, 0.1)))" in draft.text


def test_counts_stay_whole(house: Path) -> None:
    out = house.with_name("wild.ipm")
    edit.save(edit.randomise(edit.read(house), Selection("Wreath", "repeat"), amount("2")), out)
    counts = {len(drawn_at(out, "leaf", seed)) for seed in range(30)}
    assert counts == {4, 5, 6, 7, 8}


def test_attributes_are_drawn_within_their_ranges(house: Path) -> None:
    out = house.with_name("wild.ipm")
    edit.save(edit.randomise_values(edit.read(house), ["columns", "step"], amount("20")), out)
    text = out.read_text(encoding="utf-8")
    assert "= 4 + irand(-3, 8)" in text
    assert "= 20 + rand(-15, 20)" in text
    counts = {len(drawn_at(out, "frame", seed)) for seed in range(12)}
    assert len(counts) > 3
    assert all(count % 2 == 0 for count in counts)  # one draw a run, for both storeys


def test_all_that_moves_varies_but_no_coordinate(house: Path) -> None:
    draft = edit.randomise(edit.read(house), Selection(), amount("10%"))
    assert {each.where for each in draft.changes} == {
        "Storey: f distance", "Wreath: + angle", "Wreath: f distance",
    }  # fmt: skip


def test_anew_is_not_twice_and_nothing_takes_it_back(house: Path) -> None:
    plain = edit.read(house)
    for selection, by in ((Selection(), "10%"), (Selection("Wreath", "f"), "1")):
        once = edit.randomise(plain, selection, amount(by))
        assert edit.randomise(once, selection, amount(by)).text == once.text
        assert edit.randomise(once, selection, amount("0%")).text == plain.text


def test_steps_stay_known_and_get_loose(tmp_path: Path) -> None:
    text = "ipm 1\nRow --> repeat(i < 4) steps (10, 20, 10) { [F(1)] }\nstart Row"
    chosen = Selection("Row", "repeat", "steps")
    draft = edit.randomise(edit.read_text(text), chosen, amount("30%"))
    assert "steps (10, 20, 10) { [F(1)] f(rand(-4, 4)) }" in draft.text
    every = edit.randomise(draft, Selection(), amount("30%"))
    assert "{ [F(1 + rand(-0.3, 0.3))] f(rand(-4, 4)) }" in every.text
    assert edit.randomise(every, Selection(), amount("30%")).text == every.text
    again = edit.randomise(draft, chosen, amount("3"))
    assert "steps (10, 20, 10) { [F(1)] f(rand(-3, 3)) }" in again.text
    edit.save(again, tmp_path / "out.ipm")
    rows = [drawn_at(tmp_path / "out.ipm", "F", seed)[:, 0] for seed in range(5)]
    assert np.abs(np.diff(rows, axis=1) - (10, 20, 10)).max() <= 3
    assert len({row.tobytes() for row in rows}) == 5


def test_one_amount_for_lengths_and_angles_is_refused(house: Path) -> None:
    with pytest.raises(IpmError, match="angles and lengths"):
        edit.randomise(edit.read(house), Selection(), amount("1"))


@pytest.mark.parametrize("by", ["0.8", "1", "100%"])
def test_a_scale_may_not_reach_zero(by: str) -> None:
    draft = edit.read_text("ipm 1\nstart *(0.8) F")
    with pytest.raises(IpmError, match="must stay above 0"):
        edit.randomise(draft, Selection(operation="*"), amount(by))


def test_a_constant_and_a_text_cannot_vary(house: Path) -> None:
    with pytest.raises(IpmError, match="make it an attribute: attr rise = 24"):
        edit.randomise_values(edit.read(house), ["rise"], amount("1"))
    with pytest.raises(IpmError, match="no number"):
        edit.randomise_values(edit.read(house), ["style"], amount("1"))
