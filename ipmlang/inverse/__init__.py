"""From a drawing or a model to the grammar that a person would have written: read, propose, score,
simplify.

`infer` takes a file and gives an `Inference`: the syntax tree, the terminals' file, a report. The
grammar has been derived and compared with the file when it is returned. Only `save` writes.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import Source, fail
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.parse import parse
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.formats import FormatError
from ipmlang.formats.mesh import SUFFIXES as MODELS
from ipmlang.inverse.header import header
from ipmlang.inverse.options import Options, Weights, check_model_options, check_options
from ipmlang.inverse.report import Report

if TYPE_CHECKING:
    from ipmlang.inverse.explanation import Explanation
    from ipmlang.inverse.found import Found

__all__ = ["Inference", "Report", "Weights", "infer"]

Progress = Callable[[str], None]
Up = Literal["auto", "y", "z"]
DRAWINGS = (".svg", ".svgz")
READS = {"lsystem": DRAWINGS, "split": MODELS}  # file suffixes by method


@dataclass(frozen=True, slots=True, eq=False)
class Inference:
    """A proven grammar. stem: the name its text uses for the parts file; parts: that file, of this
    suffix; explanation: what won in each round, where that was asked for.
    """

    grammar: ast.Grammar
    parts: bytes
    report: Report
    stem: str
    explanation: Explanation | None = None
    suffix: str = ".svg"

    @property
    def text(self) -> str:
        """The grammar as it is written beside `<stem>.parts.svg`."""
        return format_grammar(self.grammar)

    def save(self, path: Path | str) -> None:
        """Write `x.ipm` and `x.parts.svg` (or .obj, .glb) beside it, both or neither."""
        from ipmlang.formats.atomic import write_files

        path = Path(path)
        if _stem(path) != path.stem:
            raise fail(
                "bad-command",
                f"`{path.name}` cannot name its parts file",
                hint='choose a name without ", \\ and #',
            )
        beside = path.with_name(f"{path.stem}.parts{self.suffix}")
        text = self._text_beside(path.stem)
        try:
            write_files({path: text.encode("utf-8"), beside: self.parts})
        except FormatError as error:
            raise fail("cannot-write", error.message, hint=error.hint) from error

    def _text_beside(self, stem: str) -> str:
        """The text for `<stem>.parts.svg`, laid out anew: another name breaks lines elsewhere."""
        if stem == self.stem:
            return self.text
        own, wanted = (f'"{each}.parts{self.suffix}' for each in (self.stem, stem))
        text = self.text.replace(own, wanted)
        return format_grammar(parse(Source(f"{stem}.ipm", text))[0])


def infer(
    path: Path | str,
    *,
    method: str = "auto",
    flat: bool = False,
    weights: Weights | None = None,
    similarity: float = 1.0,
    within: float | None = None,
    symmetrize: bool = False,
    paper: bool = False,
    explain: bool = False,
    up: Up = "auto",
    progress: Progress | None = None,
) -> Inference:
    """The grammar of a drawing or a model. `flat`: one placement per element and no rules, the
    baseline; `up`: which axis is up in the file of a model. The others are those of `Options`: by
    default the grammar is exact and the shortest one found.

    Raises IpmError for a file that cannot be read, for methods that are not there yet, and for
    options out of their range.
    """
    path = Path(path)
    _check_method(path, method)
    options = Options(weights or Weights(), similarity, within, symmetrize, paper, explain)
    check_options(options)
    started = time.process_time()
    say = progress or (lambda _: None)
    say(f"reading {path.name}")
    found = _found(path, options, flat, up, say)
    text = format_grammar(found.grammar)
    report = replace(
        found.report,
        tokens=count_text_tokens(text) + found.report.tokens,
        grammar_bytes=len(text.encode("utf-8")),
        parts_bytes=len(found.parts),
        seconds=round(time.process_time() - started, 3),
    )
    grammar = replace(found.grammar, header=header(path, report, flat))
    return Inference(grammar, found.parts, report, _stem(path), found.explanation, found.suffix)


def _found(path: Path, options: Options, flat: bool, up: Up, say: Progress) -> Found:
    """What the method that reads such files finds."""
    if path.suffix.lower() in DRAWINGS:
        from ipmlang.inverse.drawings import grammar_of_drawing

        if up != "auto":
            raise fail("bad-command", "a drawing has no up axis", hint="--up is for models")
        return grammar_of_drawing(path, _stem(path), flat, say, options)
    from ipmlang.inverse.models import grammar_of_model

    check_model_options(options)
    return grammar_of_model(path, _stem(path), flat, up, say, options)


def _check_method(path: Path, method: str) -> None:
    known = ("auto", *READS, "docking")
    if method not in known:
        raise fail("unknown-method", f"there is no method `{method}`", hint=", ".join(known))
    if method == "docking":
        raise fail(
            "unknown-method",
            "the method `docking` is not there yet",
            hint="`lsystem` reads drawings (.svg), `split` reads models (.obj, .glb)",
        )
    suffix = path.suffix.lower()
    if suffix not in (*DRAWINGS, *MODELS):
        raise fail(
            "not-a-drawing",
            f"`{path.name or path}` is no drawing or model that can be read",
            hint=f"grammars are inferred from .svg files, and from {', '.join(MODELS)}",
        )
    if method != "auto" and suffix not in READS[method]:
        other = "split" if method == "lsystem" else "lsystem"
        raise fail(
            "unknown-method",
            f"the method `{method}` does not read {suffix} files",
            hint=f"`{other}` does",
        )


def _stem(path: Path) -> str:
    return path.stem.replace('"', "_").replace("\\", "_").replace("#", "_")
