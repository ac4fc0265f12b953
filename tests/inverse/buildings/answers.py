"""What inference makes of buildings that an author wrote: derived, disguised, inferred, compared.

In goes the name of a grammar in this folder; out comes an `Answer` for each disguise, with rules
and tokens of both and how far the triangles are apart. No building is treated in a way of its own.
"""

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from inverse.disguise import TURN, apart, disguised, model_of, triangles_of

import ipmlang
from ipmlang.compiler import ast
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.inverse import infer

FOLDER = Path(__file__).parent
BOUNDS = FOLDER / "bounds.json"
DISGUISES = {"shuffled": (0.0, False), "turned": (TURN, False), "welded": (TURN, True)}


@dataclass(frozen=True, slots=True)
class Answer:
    """author, inferred, flat: tokens of the author's grammar, of what was inferred, of one
    placement per part; author_rules, rules: rules of both, one for each name; parts: how many were
    seen; error: share of the diagonal by which a triangle is off; seconds: of CPU time.
    """

    name: str
    disguise: str
    parts: int
    author: int
    flat: int
    inferred: int
    author_rules: int
    rules: int
    error: float
    seconds: float
    text: str

    @property
    def ratio(self) -> float:
        """Tokens inferred over the author's."""
        return self.inferred / self.author


def names() -> list[str]:
    """All grammars of the folder."""
    return sorted(path.stem for path in FOLDER.glob("*.ipm"))


def bounds() -> dict[str, float]:
    """The ratio that each building in each disguise must not pass, by `name disguise`."""
    return dict(json.loads(BOUNDS.read_text(encoding="utf-8")))


def answer(name: str, disguise: str) -> Answer:
    """The grammar is derived, disguised and inferred; what was found is saved, loaded, derived."""
    author = FOLDER / f"{name}.ipm"
    degrees, weld = DISGUISES[disguise]
    vertices, triangles = model_of(author)
    with tempfile.TemporaryDirectory(prefix="ipmlang-building-") as folder:
        seen = Path(folder) / "model.obj"
        text = disguised(vertices, triangles, names().index(name), degrees, weld)
        seen.write_text(text, encoding="utf-8")
        found = infer(seen, up="z")
        found.save(Path(folder) / "found.ipm")
        there = triangles_of(seen)
        back = Path(folder) / "back.obj"
        ipmlang.save(ipmlang.load(Path(folder) / "found.ipm").run(), back)
        error = apart(there, triangles_of(back)) / _diagonal(there)
    report = found.report
    return Answer(
        name=name,
        disguise=disguise,
        parts=report.elements,
        author=count_text_tokens(author.read_text(encoding="utf-8")),
        flat=report.tokens_flat,
        inferred=report.tokens,
        author_rules=_rules(ipmlang.load(author).checked.grammar),
        rules=_rules(found.grammar),
        error=error,
        seconds=report.seconds,
        text=found.text,
    )


def _diagonal(triangles: np.ndarray) -> float:
    return float(np.linalg.norm(np.ptp(triangles.reshape(-1, 3), axis=0)))


def _rules(grammar: ast.Grammar) -> int:
    return len({item.head.name for item in grammar.items if isinstance(item, ast.Rule)})
