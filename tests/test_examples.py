"""Every example checks without a warning, is in the formatter's layout, and draws something."""

from __future__ import annotations

from pathlib import Path

import pytest

import ipmlang

EXAMPLES = sorted((Path(__file__).resolve().parents[1] / "examples").glob("*.ipm"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example(path: Path, tmp_path: Path) -> None:
    grammar = ipmlang.load(path)
    assert not grammar.warnings
    assert grammar.format() == path.read_text(encoding="utf-8")
    scene = grammar.run(seed=1)
    assert len(scene.instances) > 10
    output = tmp_path / ("out.svg" if scene.flat else "out.glb")
    ipmlang.save(scene, output)
    assert output.stat().st_size > 500
