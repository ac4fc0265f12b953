"""Lines drawn under a transform that makes the pen an ellipse."""

from __future__ import annotations

import math
from pathlib import Path

from ipmlang.inverse import infer


def test_lines_of_many_lengths_under_a_slanted_pen(tmp_path: Path) -> None:
    """Such a pen is not stretched with its line: each length is a thing of its own."""
    turns = [0.4 * row for row in range(16)]
    lines = "".join(
        f'<path d="M0 0L{9 * math.cos(turn)} {9 * math.sin(turn)}" '
        f'transform="matrix(4 0 0 2.5 {30 + row} 40)"/>'
        for row, turn in enumerate(turns)
    )
    head = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 99 99">'
    path = tmp_path / "a.svg"
    path.write_text(f'{head}<g fill="none" stroke="#369">{lines}</g></svg>', encoding="utf-8")
    assert infer(path).report.max_error <= 1e-6
