"""What the encoder says of an instruction that has no body on the GPU."""

from __future__ import annotations


class UnsupportedError(Exception):
    """A production that the CPU must derive: what of it, and why."""

    def __init__(self, what: str, why: str) -> None:
        super().__init__(what, why)
        self.what = what
        self.why = why
