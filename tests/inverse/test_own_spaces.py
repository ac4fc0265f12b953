"""What has a space of its own (gradients, text) is shared however it is turned."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ipmlang
from ipmlang.formats.svg import read_svg, split_compound
from ipmlang.inverse.compare import compare
from ipmlang.inverse.observation import observe
from ipmlang.inverse.terminals import instances

GRADIENTS = (
    '<linearGradient id="l" x2="1" y2="0.4"><stop stop-color="#fff"/><stop offset="1"/>'
    '</linearGradient><radialGradient id="r"><stop stop-color="#fff"/>'
    '<stop offset="1" stop-color="#048"/></radialGradient>'
)
THINGS = {
    "rect": '<rect x="2" y="2" width="30" height="8" fill="url(#l)"/>',
    "circle": '<circle cx="12" cy="16" r="9" fill="url(#l)"/>',
    "round": '<circle cx="12" cy="16" r="9" fill="url(#r)"/>',
    "text": '<text x="3" y="8" font-size="6">ab</text>',
}
PLACES = [
    f"translate({90 + 70 * i} {90 + 70 * j}) rotate({40 * i + 7 * j}) scale({1 - 2 * (i % 2)} 1)"
    for i in range(4) for j in range(4)
]  # fmt: skip


def svg(body: str) -> bytes:
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 400">'
        f"<defs>{GRADIENTS}</defs>{body}</svg>"
    ).encode()


def placed(content: str) -> str:
    return "".join(f'<g transform="{place}">{content}</g>' for place in PLACES)


@pytest.mark.parametrize("name", THINGS)
def test_turned_and_mirrored_copies_are_one_terminal(name: str) -> None:
    observed = observe(split_compound(read_svg(svg(placed(THINGS[name])))))
    *_, turned = instances(observed)
    assert len(turned.terminals) == 1
    assert np.ptp(turned.string.placed.angle) > 90


def test_what_only_moves_stays_upright() -> None:
    body = "".join(f'<g transform="translate({9 * i} {i})">{THINGS["rect"]}</g>' for i in range(3))
    ways = instances(observe(split_compound(read_svg(svg(body)))))
    assert len(ways) == 1
    assert not ways[0].string.placed.angle.any()


def test_other_gradients_are_other_terminals() -> None:
    """One that runs another way through the same shape is no copy."""
    other = THINGS["rect"].replace("#l", "#r")
    observed = observe(split_compound(read_svg(svg(placed(THINGS["rect"]) + placed(other)))))
    *_, turned = instances(observed)
    assert len(turned.terminals) == 2


def test_they_are_given_back_as_one_rule(tmp_path: Path) -> None:
    source = svg(placed("".join(THINGS.values())))
    (tmp_path / "in.svg").write_bytes(source)
    found = ipmlang.infer(tmp_path / "in.svg")
    found.save(tmp_path / "x.ipm")
    ipmlang.save(ipmlang.load(tmp_path / "x.ipm").run(), tmp_path / "x.svg")
    comparison = compare(
        split_compound(read_svg(source)), split_compound(read_svg(tmp_path / "x.svg"))
    )
    assert comparison.agrees(1e-6), comparison
    assert found.report.rules == 1
    assert found.report.tokens < found.report.tokens_flat / 2
