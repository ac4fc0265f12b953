"""The one way to report trouble: a diagnostic says what is wrong, where, what was expected, and how
to mend it. Stages collect them; `render` prints one with the source line marked. Nothing here
decides whether to stop, and nothing else prints source lines.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from typing import Literal

# Control pictures and `�` for what would move the cursor, colour or reorder a terminal's text.
_VISIBLE = (
    {code: 0x2400 + code for code in range(0x20) if chr(code) not in "\n\t"}
    | {0x7F: 0x2421}
    | dict.fromkeys((*range(0x80, 0xA0), *range(0x2028, 0x202F), *range(0x2066, 0x206A)), 0xFFFD)
    | dict.fromkeys((0x200E, 0x200F, 0xFEFF, *range(0xD800, 0xE000)), 0xFFFD)
)


@lru_cache(maxsize=4)
def _line_starts(text: str) -> tuple[int, ...]:
    """Where each line starts; kept, so that thousands of diagnostics of one file stay quick."""
    return (0, *(found.end() for found in re.finditer("\n", text)))


@dataclass(frozen=True, slots=True)
class Source:
    """A text and where it came from (a path, or `<text>`)."""

    path: str
    text: str

    def place(self, offset: int) -> tuple[int, int, str]:
        """Line and column (both from 1) of a character offset, and the whole line."""
        offset = max(0, min(offset, len(self.text)))
        start = self.text.rfind("\n", 0, offset) + 1
        end = self.text.find("\n", offset)
        line = self.text[start : len(self.text) if end < 0 else end]
        return bisect_right(_line_starts(self.text), start), offset - start + 1, line.rstrip("\r")


@dataclass(frozen=True, slots=True)
class Label:
    """A second place that matters: `first defined here`."""

    start: int
    end: int
    message: str


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One problem. start and end are absolute offsets in `source`; without a source it has no place
    (a missing file, a limit). `trail` is a derivation path such as `Lot > Floor[3] > Tile[7]`.
    """

    code: str
    message: str
    severity: Literal["error", "warning"] = "error"
    source: Source | None = None
    start: int = 0
    end: int = 0
    expected: str | None = None
    hint: str | None = None
    suggestions: tuple[str, ...] = ()
    labels: tuple[Label, ...] = ()
    trail: str | None = None


class IpmError(Exception):
    """Raised at a stage's end when it found errors; carries all of them."""

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__("\n\n".join(render(each) for each in self.diagnostics))


def fail(
    code: str,
    message: str,
    *,
    hint: str | None = None,
    source: Source | None = None,
    start: int = 0,
    end: int = 0,
) -> IpmError:
    """An error of one diagnostic, ready to raise."""
    return IpmError([Diagnostic(code, message, source=source, start=start, end=end, hint=hint)])


def nearest(word: str, known: Iterable[str]) -> tuple[str, ...]:
    """Up to three known names that `word` may have meant, best first."""
    return tuple(get_close_matches(word, sorted(set(known)), n=3, cutoff=0.6))


def render(diagnostic: Diagnostic) -> str:
    r"""The text a person reads.

    >>> source = Source("fence.ipm", "start Fense(24)\n")
    >>> print(render(Diagnostic("unknown-symbol", "no rule or asset is called `Fense`",
    ...     source=source, start=6, end=11, suggestions=("Fence",))))
    error[unknown-symbol]: no rule or asset is called `Fense`
      --> fence.ipm:1:7
       |
     1 | start Fense(24)
       |       ^^^^^
       = did you mean `Fence`?
    """
    lines = [f"{diagnostic.severity}[{diagnostic.code}]: {diagnostic.message}"]
    gutter = ""
    if diagnostic.source is not None:
        number, column, _ = diagnostic.source.place(diagnostic.start)
        gutter = " " * (len(str(number)) + 1)
        lines += [f"  --> {diagnostic.source.path}:{number}:{column}", f"{gutter} |"]
        lines += _marked(diagnostic.source, diagnostic.start, diagnostic.end, gutter, "^", "")
        for label in diagnostic.labels:
            lines += _marked(diagnostic.source, label.start, label.end, gutter, "-", label.message)
    gutter = gutter or "  "
    if diagnostic.expected:
        lines.append(f"{gutter} = expected {diagnostic.expected}")
    if diagnostic.suggestions:
        names = " or ".join(f"`{name}`" for name in diagnostic.suggestions)
        lines.append(f"{gutter} = did you mean {names}?")
    if diagnostic.trail:
        lines.append(f"{gutter} = in {diagnostic.trail}")
    if diagnostic.hint:
        lines.append(f"{gutter} = {diagnostic.hint}")
    return "\n".join(lines).translate(_VISIBLE)


def _marked(
    source: Source, start: int, end: int, gutter: str, mark: str, message: str
) -> list[str]:
    number, column, text = source.place(start)
    shown, column, width = _excerpt(text, column, max(1, end - start))
    note = f" {message}" if message else ""
    pad = "".join("\t" if char == "\t" else " " for char in shown[: column - 1])
    return [
        f"{number:>{len(gutter)}} | {shown}",
        f"{gutter} | {pad}{mark * width}{note}",
    ]


def _excerpt(text: str, column: int, width: int) -> tuple[str, int, int]:
    """A line of bounded length around the marked place (inferred lines can be very long)."""
    width = max(1, min(width, len(text) - column + 1, 60))
    if len(text) <= 100:
        return text, column, width
    left = max(0, column - 41)
    head = "… " if left else ""
    shown = head + text[left : left + 98] + (" …" if left + 98 < len(text) else "")
    return shown, column - left + len(head), width
