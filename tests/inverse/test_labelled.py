"""Labelled things are one loop and a list of labels, with whatever else differs in formulas."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from ipmlang.inverse import infer

MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
HEAD = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 900 400">'
KEYS = ("1234567890", "QWERTYUIOP", "ASDFGHJKL", "ZXCVBNM")
CITIES = ((13, 40), (77, 112), (190, 31), (214, 160), (333, 90), (402, 244), (471, 18), (520, 201))


def grammar(tmp_path: Path, body: str) -> str:
    """What is inferred of a drawing, on one line."""
    path = tmp_path / "drawing.svg"
    path.write_text(f"{HEAD}{body}</svg>", encoding="utf-8")
    return " ".join(infer(path).text.split())


def test_a_row_of_ticks_has_its_numbers_in_a_list(tmp_path: Path) -> None:
    body = "".join(
        f'<path d="M{50 + 30 * k} 300v6" stroke="#000"/>'
        f'<text x="{50 + 30 * k}" y="320">{5 * k}</text>'
        for k in range(9)
    )
    text = grammar(tmp_path, body)
    labels = " ".join(f"text{5 * k}" for k in range(9))
    assert f"table Labels(shape) = {labels}" in text
    assert "repeat(i < 9) with r in Labels { [at(50 + 30 * i, 100) " in text
    assert "[at(0, -20) r.shape]] }" in text


def test_keys_in_ragged_rows_have_their_letters_in_a_list(tmp_path: Path) -> None:
    body = "".join(
        f'<rect x="{20 + 50 * c + 15 * r}" y="{20 + 50 * r}" width="44" height="44"/>'
        f'<text x="{30 + 50 * c + 15 * r}" y="{48 + 50 * r}" fill="#fff">{key}</text>'
        for r, row in enumerate(KEYS)
        for c, key in enumerate(row)
    )
    text = grammar(tmp_path, body)
    assert "repeat(k < 37) except (29) with r in Labels" in text
    assert "letter_q letter_w letter_e" in text
    assert text.count("] ]") <= 1 and text.count("square") == 2  # as an asset, and in the loop


def test_dots_placed_by_hand_have_their_names_and_places_in_a_table(tmp_path: Path) -> None:
    body = "".join(
        f'<circle cx="{x}" cy="{y}" r="4"/><text x="{x + 6}" y="{y + 3}">{name}</text>'
        for name, (x, y) in zip(MONTHS, CITIES, strict=False)
    )
    text = grammar(tmp_path, body)
    assert "table Labels(shape, x, y) = jan, 13, 360 feb, 77, 288" in text
    assert "repeat(r in Labels) { [at(r.x, r.y) circle [at(6, -3) r.shape]] }" in text


def _loose(k: int) -> tuple[float, float]:
    return 20 + 41 * k + 3 * (k % 3), 50 + 17 * ((k * 5) % 7)


def _turned(k: int) -> tuple[float, float]:
    return 20 + 40 * k, 50


@pytest.mark.parametrize(
    ("place", "aside"),
    [(_loose, lambda k: (6 + k, 3)), (_turned, lambda k: (6, 3 + (k % 2)))],
    ids=["labels aside", "labels up and down"],
)
def test_labels_that_stand_otherwise_each_time_are_placed_by_themselves(
    tmp_path: Path,
    place: Callable[[int], tuple[float, float]],
    aside: Callable[[int], tuple[float, float]],
) -> None:
    body = ""
    for k, name in enumerate(MONTHS):
        (x, y), (across, down) = place(k), aside(k)
        body += f'<circle cx="{x}" cy="{y}" r="4"/>'
        body += f'<text x="{x + across}" y="{y + down}">{name}</text>'
    assert "table Labels" not in grammar(tmp_path, body)
