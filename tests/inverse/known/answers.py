"""What inference makes of grammars that an author wrote: run, inferred from the drawing, compared.

In goes the name of a grammar in this folder; out comes an `Answer` with the tokens of both, and how
far the two drawings are apart. Nothing is kept, and no grammar is treated in a way of its own.
"""

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

from inverse.provenance import ruled_share

import ipmlang
from ipmlang.compiler import ast
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.formats.drawing import Drawing
from ipmlang.formats.svg import read_svg, read_table, split_compound
from ipmlang.inverse import Inference, infer
from ipmlang.inverse.compare import Comparison, compare

FOLDER = Path(__file__).parent
BOUNDS = FOLDER / "bounds.json"


@dataclass(frozen=True, slots=True)
class Answer:
    """author, flat, inferred: tokens of the author's grammar, of one placement per element, and of
    what was inferred; ruled, author_ruled: share of the elements under repetition or rules used
    twice, in both; rules, seconds: of the inference; comparison: of what it draws with what the
    author's grammar draws; text: what was inferred.
    """

    name: str
    elements: int
    author: int
    flat: int
    inferred: int
    ruled: float
    author_ruled: float
    rules: int
    seconds: float
    comparison: Comparison
    text: str

    @property
    def ratio(self) -> float:
        """Tokens inferred over the author's."""
        return self.inferred / self.author


def names() -> list[str]:
    """All grammars of the folder."""
    return sorted(path.stem for path in FOLDER.glob("*.ipm"))


def bounds() -> dict[str, tuple[float, float]]:
    """The ratio that each grammar must not pass and the share of elements under rules that it must
    reach; `bench_known.py --tighten` tightens them.
    """
    kept = json.loads(BOUNDS.read_text(encoding="utf-8"))
    return {name: (ceiling, floor) for name, (ceiling, floor) in kept.items()}


def answer(name: str) -> Answer:
    """The grammar is run to SVG, the SVG inferred, what was found saved, loaded and run again."""
    author = FOLDER / f"{name}.ipm"
    with tempfile.TemporaryDirectory(prefix="ipmlang-known-") as folder:
        drawn = Path(folder) / f"{name}.svg"
        ipmlang.save(ipmlang.load(author).run(), drawn)
        found = infer(drawn)
        comparison = compare(_read(drawn), _redrawn(found, Path(folder) / f"{name}.ipm"))
        ruled = ruled_share(found.grammar, Path(folder))
    report = found.report
    return Answer(
        name=name,
        elements=report.elements,
        author=tokens_of(author),
        flat=report.tokens_flat,
        inferred=report.tokens,
        ruled=ruled,
        author_ruled=ruled_share(ipmlang.load(author).checked.grammar, FOLDER),
        rules=report.rules,
        seconds=report.seconds,
        comparison=comparison,
        text=found.text,
    )


def tokens_of(path: Path) -> int:
    """Tokens of a grammar's formatted text, and the cells of the tables beside it, as a report
    counts them.
    """
    grammar = ipmlang.load(path)
    tables = (item for item in grammar.checked.grammar.items if isinstance(item, ast.Table))
    beside = [table.reference for table in tables if table.reference is not None]
    return count_text_tokens(grammar.format()) + sum(_cells(path.parent, each) for each in beside)


def _cells(folder: Path, reference: str) -> int:
    file, _, name = reference.partition("#")
    return sum(len(row) for row in read_table(folder / file, name).rows)


def _redrawn(found: Inference, path: Path) -> Drawing:
    found.save(path)
    drawn = path.with_suffix(".svg")
    ipmlang.save(ipmlang.load(path).run(), drawn)
    return _read(drawn)


def _read(path: Path) -> Drawing:
    return split_compound(read_svg(path))
