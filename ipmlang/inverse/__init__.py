"""From a drawing to the grammar that a person would have written: read, propose, score, simplify.

`infer` takes a file and gives an `Inference`: the syntax tree, the terminals' file, a report. The
grammar has been derived and compared with the drawing when it is returned. Only `save` writes.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import Source, fail
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.parse import parse
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.formats import FormatError
from ipmlang.formats.drawing import Drawing
from ipmlang.inverse.options import Options, Weights, check_options
from ipmlang.inverse.report import Report

if TYPE_CHECKING:
    from ipmlang.inverse.explanation import Explanation

__all__ = ["Inference", "Report", "Weights", "infer"]

Progress = Callable[[str], None]
FARTHEST = 1e8  # times its size that a drawing may be away from the origin


@dataclass(frozen=True, slots=True, eq=False)
class Inference:
    """A proven grammar. stem: the name its text uses for the parts file; parts: that file;
    explanation: what won in each round, where that was asked for.
    """

    grammar: ast.Grammar
    parts: bytes
    report: Report
    stem: str
    explanation: Explanation | None = None

    @property
    def text(self) -> str:
        """The grammar as it is written beside `<stem>.parts.svg`."""
        return format_grammar(self.grammar)

    def save(self, path: Path | str) -> None:
        """Write `x.ipm` and `x.parts.svg` beside it, both or neither."""
        from ipmlang.formats.atomic import write_files

        path = Path(path)
        if _stem(path) != path.stem:
            raise fail(
                "bad-command",
                f"`{path.name}` cannot name its parts file",
                hint='choose a name without ", \\ and #',
            )
        beside = path.with_name(f"{path.stem}.parts.svg")
        text = self._text_beside(path.stem)
        try:
            write_files({path: text.encode("utf-8"), beside: self.parts})
        except FormatError as error:
            raise fail("cannot-write", error.message, hint=error.hint) from error

    def _text_beside(self, stem: str) -> str:
        """The text for `<stem>.parts.svg`, laid out anew: another name breaks lines elsewhere."""
        if stem == self.stem:
            return self.text
        text = self.text.replace(f'"{self.stem}.parts.svg', f'"{stem}.parts.svg')
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
    progress: Progress | None = None,
) -> Inference:
    """The grammar of a drawing. `flat`: one placement per element and no rules, the baseline. The
    others are those of `Options`: by default the grammar is exact and the shortest one found.

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
    drawing = _read(path)
    from ipmlang.inverse.regular import grammar_of

    made = grammar_of(drawing, _stem(path), flat, say, options)
    text = format_grammar(made.grammar)
    report = replace(
        made.report,
        tokens=count_text_tokens(text) + made.report.tokens,
        grammar_bytes=len(text.encode("utf-8")),
        parts_bytes=len(made.parts.encode("utf-8")),
        source_bytes=drawing.source_bytes,
        seconds=round(time.process_time() - started, 3),
        notes=_notes(drawing),
    )
    grammar = replace(made.grammar, header=_header(path, report, flat))
    parts = made.parts.encode("utf-8")
    return Inference(grammar, parts, report, _stem(path), made.explanation)


def _check_method(path: Path, method: str) -> None:
    known = ("auto", "lsystem", "split", "docking")
    if method not in known:
        raise fail("unknown-method", f"there is no method `{method}`", hint=", ".join(known))
    if method in ("split", "docking"):
        raise fail(
            "unknown-method",
            f"the method `{method}` is not there yet",
            hint="`lsystem` reads drawings (.svg)",
        )
    if path.suffix.lower() not in (".svg", ".svgz"):
        raise fail(
            "not-a-drawing",
            f"`{path.name or path}` is no drawing that can be read yet",
            hint="grammars are inferred from .svg files",
        )


def _stem(path: Path) -> str:
    return path.stem.replace('"', "_").replace("\\", "_").replace("#", "_")


def _read(path: Path) -> Drawing:
    from ipmlang.formats.svg import read_svg, split_compound

    try:
        drawing = split_compound(read_svg(path))
    except FormatError as error:
        place = f"{path}:{error.line}" if error.line is not None else str(path)
        said = str(path) in error.message
        message = error.message if said else f"{place}: {error.message}"
        raise fail("unreadable", message, hint=error.hint) from error
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise fail("unreadable", f"cannot read {path}: {reason}") from error
    if drawing.box is not None and _is_far(drawing.box):
        raise fail(
            "unreadable",
            f"{path}: the viewBox is so far from the origin that no number tells points apart",
            hint="move the drawing nearer to the origin",
        )
    return drawing


def _is_far(box: tuple[float, float, float, float]) -> bool:
    x, y, width, height = box
    return max(abs(x), abs(y)) > FARTHEST * max(width, height)


def _notes(drawing: Drawing) -> tuple[str, ...]:
    """What the reader says, and what is carried through without being understood."""
    kinds: dict[str, int] = {}
    for element in drawing.elements:
        if element.fragment is not None:
            kinds[element.fragment.kind] = kinds.get(element.fragment.kind, 0) + 1
    said = [
        note.message + (f" ({note.count} times)" if note.count > 1 else "")
        for note in drawing.notes
    ]
    told = " ".join(said)
    carried = [
        f"<{kind}> is carried through as it is ({count} times)"
        for kind, count in sorted(kinds.items())
        if f"<{kind}>" not in told
    ]
    return tuple(dict.fromkeys(carried + said))


def _header(path: Path, report: Report, flat: bool) -> tuple[ast.Comment, ...]:
    """What was read, how much was explained, the largest error."""
    lines = [f"Read from {path.name}: {report.elements} elements."]
    if flat:
        lines.append("One placement per element; nothing was looked for.")
    else:
        share = round(report.explained * report.elements)
        rules = f"{report.rules} rule{'s' * (report.rules != 1)}"
        explained = f"{rules} for {share} of them" if report.rules else "no rule pays"
        lines.append(f"Found: {explained}; {report.tokens} tokens instead of {report.tokens_flat}.")
    lines.append(_largest_error(report))
    lines += [f"Note: {note}" for note in report.notes]
    return tuple(ast.Comment(line.replace("\n", " ")) for line in lines)


def _largest_error(report: Report) -> str:
    """How exact the grammar is, and which rule is worst where it is not meant to be exact."""
    line = f"Largest error: {report.max_error:.1e} of the diagonal"
    if report.mode == "ideal":
        line += ", similar shapes being one"
    elif report.mode == "within":
        line += f", {report.limit:.1e} being allowed"
    if report.rule_errors:
        line += f"; most of it in {report.rule_errors[0].rule}"
    return line + "."
