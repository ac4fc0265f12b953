"""Files: drawings, meshes and pictures, read into plain types and written whole or not at all.

Nothing here derives, infers or prints. A file that cannot be read or written is a `FormatError`,
which the caller turns into a diagnostic.
"""

from __future__ import annotations


class FormatError(Exception):
    """A file is wrong or cannot be written: what is wrong, the line if known, how to mend it."""

    def __init__(self, message: str, line: int | None = None, hint: str | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.line = line
        self.hint = hint
