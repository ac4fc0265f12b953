"""Every `tests/corpus/x.ipm` gives what `x.out` says, run by run.

An `.out` file is blocks of `word value` lines, one block a run. `set name=value` sets an attribute
and `seed n` the seed; the other words are expectations: `modules`, `brackets` (opening ones) and
`drawn` (segments) are counts; `hash` is the start of the sha256 of the symbols written in the
book's spelling without separators; `string` is the whole string; `vertices`, `end` and `extent`
are the distinct ends of segments, the end of the last one, and the size of what is drawn.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from ipmlang.compiler import ir
from ipmlang.runtime.scene import SEGMENT, Scene
from ipmlang.runtime.strings import derive_modules, derive_string
from tests.engine.grammars import compiled

CORPUS = Path(__file__).parent / "corpus"
BOOK = {"turn": "|", "tick": "'", "cut": "%", "S0": "0", "S1": "1"}
Block = dict[str, str]


def blocks() -> Iterator[tuple[str, Block]]:
    for path in sorted(CORPUS.glob("*.out")):
        for text in path.read_text().split("\n\n"):
            lines = [line.split(" ", 1) for line in text.splitlines() if line]
            if lines:
                yield path.stem, dict(lines)


def test_every_grammar_of_the_corpus_has_expectations() -> None:
    told = {name for name, _ in blocks()}
    assert told == {path.stem for path in CORPUS.glob("*.ipm")}
    assert all(block.keys() - {"set", "seed"} for _, block in blocks())


def label(value: object) -> str:
    return value if isinstance(value, str) else " ".join(list(value.values())[:1])  # type: ignore[attr-defined]


@pytest.mark.parametrize(("name", "expected"), list(blocks()), ids=label)
def test_corpus(name: str, expected: Block) -> None:
    block = dict(expected)
    program = compiled(CORPUS / f"{name}.ipm")
    attrs = attributes(program, block.pop("set", ""))
    seed = int(block.pop("seed", 0))
    string = derive_modules(program, attrs, seed, program.limits)
    measured = of_string(string)
    if block.keys() - measured.keys():
        measured |= of_scene(derive_string(program, attrs, seed, program.limits))
    for word, value in block.items():
        if word in ("hash", "string"):
            assert measured[word] == value, word
        else:
            numbers = [float(part) for part in value.split()]
            assert measured[word][: len(numbers)] == pytest.approx(numbers, abs=1e-4), word
            assert all(abs(rest) < 1e-9 for rest in measured[word][len(numbers) :])


def attributes(program: ir.Program, text: str) -> list[float]:
    given = dict(part.split("=") for part in text.split())
    values = []
    for attribute in program.attrs:
        default = attribute.default[0][-1].const
        assert isinstance(default, int | float)
        values.append(float(given.get(attribute.name, default)))
    return values


def of_string(string: list[tuple[str, tuple[float, ...]]]) -> dict:
    names = [name for name, _ in string]
    text = "".join(BOOK.get(name, name) for name in names)
    shown = [
        f"{name}({','.join(f'{arg:.7g}' for arg in args)})" if args else name
        for name, args in string
    ]
    return {
        "modules": [len(names)],
        "brackets": [names.count("[")],
        "hash": hashlib.sha256(text.encode()).hexdigest()[:16],
        "string": " ".join(shown),
    }


def of_scene(scene: Scene) -> dict:
    found = scene.instances
    segments = np.flatnonzero(found.asset == SEGMENT)
    begins = found.position[segments]
    w, x, y, z = found.rotation[segments].T
    heading = np.stack((1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)), axis=1)
    length = found.size[segments, 0] * found.scale[segments]
    ends = begins + heading * length[:, None]
    points = np.concatenate((begins, ends))
    return {
        "drawn": [len(segments)],
        "vertices": [len(np.unique(np.round(points, 6) + 0.0, axis=0))],
        "end": ends[-1].tolist() if len(ends) else [],
        "extent": np.ptp(points, axis=0).tolist(),
    }
