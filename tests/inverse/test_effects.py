"""Clips, masks, filters and opacity: what they wrap is found like any shape, and given back.

Drawings are written as SVG, read, inferred, derived and read again. What a rule may share is said
by how many tokens are left; that nothing is lost by the comparison, which is tested here as well.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ipmlang
from ipmlang.formats.drawing import Drawing, Effect
from ipmlang.formats.svg import read_svg, split_compound
from ipmlang.formats.svg.transforms import multiply
from ipmlang.inverse import Inference
from ipmlang.inverse.appearance import same_effects
from ipmlang.inverse.clips import placed_clip
from ipmlang.inverse.compare import Comparison, compare
from ipmlang.inverse.effects import drawn_matrix, effect_classes

THING = (
    '<rect x="2" y="2" width="30" height="8" fill="#d33"/><circle cx="12" cy="16" r="9"/>'
    '<path d="M0 0L20 30L5 25Z" fill="#3a3"/>'
)
CLIP = '<clipPath id="c"><path d="M0 0H16V18L4 20Z"/></clipPath>'
MASK = (
    '<mask id="m" maskUnits="userSpaceOnUse" x="-9" y="-9" width="60" height="60">'
    '<rect width="30" height="15" x="-5" fill="#fff" fill-opacity="0.7"/></mask>'
)
FILTER = '<filter id="f"><feGaussianBlur stdDeviation="2"/></filter>'
SYMBOL = f'<symbol id="s" viewBox="0 0 20 20">{THING}</symbol>'
USE = '<use href="#s" width="20" height="20"/>'


def svg(body: str, *definitions: str) -> bytes:
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 400">'
        f"<defs>{''.join(definitions)}</defs>{body}</svg>"
    ).encode()


def each(transforms: Sequence[str], content: str, attributes: str = "") -> str:
    return "".join(
        f'<g transform="{transform}" {attributes}>{content}</g>' for transform in transforms
    )


GRID = [f"translate({40 * i} {50 * j})" for j in range(4) for i in range(6)]
ANY = [
    "translate(60 50)",
    "translate(150 60) rotate(33) scale(2)",
    "translate(260 60) scale(-1.3 1.3)",
    "translate(60 200) rotate(-70) scale(0.8 -0.8)",
    "translate(200 220) rotate(90)",
    "translate(330 330) rotate(201) scale(1.7)",
]


def round_trip(source: bytes, folder: Path) -> tuple[Inference, Comparison]:
    """What is inferred, and how what it draws differs from the source."""
    (folder / "in.svg").write_bytes(source)
    found = ipmlang.infer(folder / "in.svg")
    found.save(folder / "x.ipm")
    ipmlang.save(ipmlang.load(folder / "x.ipm").run(), folder / "x.svg")
    again = split_compound(read_svg(folder / "x.svg"))
    return found, compare(split_compound(read_svg(source)), again)


def references(found: Inference) -> list[str]:
    """What `effect` refers to, in order."""
    return re.findall(r'effect\("in\.parts\.svg#(\w+)"\)', found.text)


@pytest.mark.parametrize(
    "attributes",
    ['clip-path="url(#c)"', 'mask="url(#m)"', 'filter="url(#f)"', 'opacity="0.5"',
     'clip-path="url(#c)" opacity="0.4"', 'style="mix-blend-mode:multiply"'],
)  # fmt: skip
@pytest.mark.parametrize("places", [GRID, ANY], ids=["grid", "any"])
def test_equal_groups_are_one_rule(places: list[str], attributes: str, tmp_path: Path) -> None:
    """However they are turned, sized and mirrored: one rule, one effect in the parts file."""
    source = svg(each(places, THING, attributes), CLIP, MASK, FILTER)
    found, comparison = round_trip(source, tmp_path)
    assert comparison.agrees(1e-6), comparison
    assert len(references(found)) == 1
    most = 125 if places is GRID else 150
    assert found.report.tokens <= most < found.report.tokens_flat


def test_clipped_symbols_are_things_like_any(tmp_path: Path) -> None:
    """A grid of symbol instances, each with the clip of its own viewport."""
    found, comparison = round_trip(svg(each(GRID, USE), SYMBOL), tmp_path)
    assert comparison.agrees(1e-6), comparison
    assert found.report.elements == 72
    assert found.report.tokens <= 135
    assert "repeat" in found.text
    assert len(references(found)) == 1


def test_groups_in_groups(tmp_path: Path) -> None:
    inner = each(["rotate(20)", "translate(-20 3) scale(.8)"], THING, 'clip-path="url(#c)"')
    content = f'<rect width="40" height="40" x="-20" y="-20" fill="#ccc"/>{inner}'
    source = svg(each(ANY, content, 'mask="url(#m)"'), CLIP, MASK)
    found, comparison = round_trip(source, tmp_path)
    assert comparison.agrees(1e-6), comparison
    assert found.report.elements == 42
    assert sorted(references(found)) == ["clip", "mask"]
    assert found.report.tokens <= 190


def test_a_long_run_is_searched_and_shares_rules(tmp_path: Path) -> None:
    """A plot that is clipped as a whole: rows inside it, and its things outside it too."""
    inside = each([f"translate({20 * i} {40 * j})" for i in range(12) for j in range(8)], THING)
    outside = each([f"translate({41 * i} 350)" for i in range(9)], THING)
    frame = '<clipPath id="v"><rect x="20" y="20" width="200" height="300"/></clipPath>'
    found, comparison = round_trip(
        svg(f'<g clip-path="url(#v)">{inside}</g>{outside}', frame), tmp_path
    )
    assert comparison.agrees(1e-6), comparison
    assert found.report.elements == 3 * (96 + 9)
    assert found.report.tokens <= 180
    assert found.report.explained == 1
    assert len(references(found)) == 1
    assert len(re.findall(r"\bcircle\b", found.text)) == 2  # as an asset and in one rule


def test_what_no_rule_explains_stays_a_table_inside_a_group(tmp_path: Path) -> None:
    generator = np.random.default_rng(3)
    dots = "".join(
        f'<circle r="4" cx="{x:.2f}" cy="{y:.2f}"/>' for x, y in generator.uniform(0, 400, (90, 2))
    )
    frame = '<clipPath id="v"><rect x="20" y="20" width="200" height="300"/></clipPath>'
    plain, _ = round_trip(svg(dots), tmp_path)
    found, comparison = round_trip(svg(f'<g clip-path="url(#v)">{dots}</g>', frame), tmp_path)
    assert comparison.agrees(1e-6), comparison
    assert found.report.rules == 0
    assert found.report.explained == 0
    assert found.report.tokens <= plain.report.tokens + 8


@pytest.mark.parametrize(
    "clip",
    ['<rect x="{}" y="{}" width="25" height="30"/>', '<circle cx="{}" cy="{}" r="12"/>',
     '<path transform="translate({} {})" d="M0 0H20L10 30Z" clip-rule="evenodd"/>'],
)  # fmt: skip
def test_clips_written_in_the_drawing_are_told_by_their_shape(clip: str, tmp_path: Path) -> None:
    """As drawing programs write them: a clip path for each group, all of them different."""
    places = [(10 + 40 * i, 20 + 60 * j) for j in range(4) for i in range(8)]
    clips = (
        f'<clipPath id="c{n}">{clip.format(x, y)}</clipPath>' for n, (x, y) in enumerate(places)
    )
    groups = "".join(
        f'<g clip-path="url(#c{n})"><g transform="translate({x} {y})">{THING}</g></g>'
        for n, (x, y) in enumerate(places)
    )
    found, comparison = round_trip(svg(groups, *clips), tmp_path)
    assert comparison.agrees(1e-6), comparison
    assert len(references(found)) == 1
    assert found.report.tokens <= 140


def test_groups_that_touch_stay_apart(tmp_path: Path) -> None:
    """Five half transparent groups, one on the other, are not one."""
    found, comparison = round_trip(svg(each(["translate(50 50)"] * 5, THING, 'opacity="0.5"')),
                                   tmp_path)  # fmt: skip
    assert comparison.agrees(1e-6), comparison
    assert (tmp_path / "x.svg").read_text().count('opacity="0.5"') == 5
    assert found.report.tokens < 110


def test_equal_content_under_other_effects_is_told_how_far_it_is_apart(tmp_path: Path) -> None:
    """Content and clip move apart: by the number that one rule is told."""
    shifts = [0, 3, 7, 12]
    groups = "".join(
        f'<g transform="translate({90 * n} 50)" clip-path="url(#c)">'
        f'<g transform="translate({shift} 0)">{THING}</g></g>'
        for n, shift in enumerate(shifts)
    )
    found, comparison = round_trip(svg(groups, CLIP), tmp_path)
    assert comparison.agrees(1e-6), comparison
    assert references(found) == ["clip"]
    assert re.search(r"\n\w+\(x\) +-->", found.text)
    assert re.search(r"\n\w+ +--> rect", found.text)


# ------------------------------------------------------------------------- classes


def drawing_with(*bodies: str) -> Drawing:
    return read_svg(svg("".join(bodies), CLIP, MASK, FILTER))


def test_frames_and_classes_give_each_effect_back() -> None:
    """Slanted spaces too: a class keeps what no frame can say."""
    slanted = [f"{place} matrix(1 0.2 0.5 1.2 0 0)" for place in ANY]
    drawing = drawing_with(
        each(ANY, THING, 'mask="url(#m)"'), each(slanted, THING, 'mask="url(#m)"')
    )
    effects = effect_classes(drawing, 400.0, True, 1e-4)
    assert len(effects.classes) == 2
    for name, effect in drawing.effects.items():
        made = effects.classes[effects.of[name]].effect
        assert made.definitions == effect.definitions
        matrix = multiply(drawn_matrix(effects.frames[name], 400.0), made.matrix)
        assert np.abs(np.subtract(matrix, effect.matrix)).max() < 1e-7


def test_opacity_lies_nowhere() -> None:
    drawing = drawing_with(each(ANY, THING, 'opacity="0.5"'), each(ANY, THING, 'opacity="0.6"'))
    effects = effect_classes(drawing, 400.0, True, 1e-4)
    assert [(kind.anchored, kind.word) for kind in effects.classes] == [(False, "faded")] * 2


def test_a_plain_clip_is_an_outline_and_others_are_not() -> None:
    effect = Effect(
        (("clip-path", "url(#k)"),),
        '<clipPath id="k"><rect x="1" y="2" width="3" height="4" clip-rule="evenodd"/></clipPath>',
        (2, 0, 0, 2, 5, 0),
    )
    found = placed_clip(effect)
    assert found is not None
    assert found[1] == "evenodd"
    assert found[0].coords[:, 0].min(axis=0).tolist() == [7, 4]
    assert found[0].coords[:, 0].max(axis=0).tolist() == [13, 12]
    for more in (
        {"attributes": (*effect.attributes, ("opacity", "0.5"))},
        {"definitions": effect.definitions.replace("<rect", '<circle r="1"/><rect')},
        {"definitions": effect.definitions.replace('id="k"', 'id="k" transform="scale(2)"')},
        {"definitions": effect.definitions.replace('"3"', '"50%"')},
        {"definitions": effect.definitions.replace(
            'id="k"', 'id="k" clipPathUnits="objectBoundingBox"')},
    ):  # fmt: skip
        assert placed_clip(replace(effect, **more)) is None  # type: ignore[arg-type]


def test_effects_are_compared_strictly() -> None:
    """Another clip, another place, another share: each is seen."""

    def seen(effect: Effect) -> Drawing:
        return Drawing((), effects={"e": effect})

    clip = Effect((("clip-path", "url(#k)"),), "", (1, 0, 0, 1, 5, 0))
    rect = '<clipPath id="k"><rect x="0" y="0" width="{}" height="4"/></clipPath>'
    path = '<clipPath id="other"><path d="M5 0H8V4H5Z"/></clipPath>'
    first = replace(clip, definitions=rect.format(3))
    same = Effect((("clip-path", "url(#other)"),), path, (1, 0, 0, 1, 0, 0))
    wrong = [
        replace(first, matrix=(1, 0, 0, 1, 5.01, 0)),
        replace(first, definitions=rect.format(3.01)),
        replace(same, definitions=path.replace("<path", '<path clip-rule="evenodd"')),
        replace(first, attributes=(("mask", "url(#k)"),)),
        replace(first, attributes=(*first.attributes, ("opacity", "0.5"))),
    ]
    assert same_effects(seen(first), seen(same), ["e"], ["e"], 100.0)
    for each_wrong in wrong:
        assert not same_effects(seen(first), seen(each_wrong), ["e"], ["e"], 100.0)
    faded = [Effect((("opacity", share),), "", (1, 0, 0, 1, x, 0)) for share, x in
             (("0.5", 0), ("0.5", 7), ("0.51", 0))]  # fmt: skip
    assert same_effects(seen(faded[0]), seen(faded[1]), ["e"], ["e"], 100.0)
    assert not same_effects(seen(faded[0]), seen(faded[2]), ["e"], ["e"], 100.0)
