"""Drawings read for inference, and what their readers say of them.

Takes the path of an SVG; gives its proven grammar. A file that cannot be read is an IpmError that
names the place. Nothing is written.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.formats import FormatError
from ipmlang.formats.collection import without_collection
from ipmlang.formats.drawing import Drawing
from ipmlang.inverse.found import Found
from ipmlang.inverse.options import Options

FARTHEST = 1e8  # times its size that a drawing may be away from the origin


def grammar_of_drawing(
    path: Path, stem: str, flat: bool, say: Callable[[str], None], options: Options
) -> Found:
    """The shortest proven grammar of a drawing."""
    with without_collection():
        drawing = _read(path)
        from ipmlang.inverse.regular import grammar_of

        made = grammar_of(drawing, stem, flat, say, options)
    notes = (*_notes(drawing), *made.report.notes)
    report = replace(made.report, source_bytes=drawing.source_bytes, notes=notes)
    return Found(made.grammar, made.parts.encode("utf-8"), ".svg", report, made.explanation)


def _read(path: Path) -> Drawing:
    from ipmlang.formats.svg import read_svg, split_compound
    from ipmlang.inverse.turtle_paths import turtle_paths

    try:
        drawing = read_svg(path)
        drawing = split_compound(drawing, turtle_paths(drawing))
    except FormatError as error:
        raise unreadable(path, error) from error
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


def unreadable(path: Path, error: FormatError) -> IpmError:
    """What a person is told of a file that cannot be read, with its line where that is known."""
    place = f"{path}:{error.line}" if error.line is not None else str(path)
    message = error.message if str(path) in error.message else f"{place}: {error.message}"
    return fail("unreadable", message, hint=error.hint)


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
