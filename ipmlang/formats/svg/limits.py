"""How much a drawing may ask for, and what the reader wants said about it.

`Limits` bound bytes, depth and expansion, so that a small hostile file cannot mean hours or
gigabytes. `Notes` count what was skipped or carried through. Neither touches files or geometry.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ipmlang.formats.drawing import Note


@dataclass(frozen=True, slots=True)
class Limits:
    """Bounds of one reading; past one the file is refused with a `FormatError`.

    bytes: of the file, unpacked. depth: of nested elements. elements: drawn after `use` and markers
    are expanded. selector_steps: work for matching style sheets. carried: characters of text,
    gradients and other definitions that are carried through.
    """

    bytes: int = 128 * 1024 * 1024
    depth: int = 256
    elements: int = 1_000_000
    selector_steps: int = 5_000_000
    carried: int = 64 * 1024 * 1024


@dataclass(slots=True)
class Notes:
    """Notes counted by code; the first message and line of a code stay."""

    found: dict[str, Note] = field(default_factory=dict)

    def add(self, code: str, message: str, line: int | None = None) -> None:
        """Say it once more: the count of `code` grows by one."""
        old = self.found.get(code)
        if old is None:
            self.found[code] = Note(code, message, 1, line)
        else:
            self.found[code] = Note(code, old.message, old.count + 1, old.line)

    def listed(self) -> tuple[Note, ...]:
        """All notes, in order of code."""
        return tuple(self.found[code] for code in sorted(self.found))
