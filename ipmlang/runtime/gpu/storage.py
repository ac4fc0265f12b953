"""A storage buffer on the graphics card: bytes that shaders read and write.

Takes what `device` allocated; gives numpy arrays back. A column of a table is one buffer, since a
driver promises only 128 MB of each. It allocates nothing itself. What the driver refuses is an
`IpmError`, `gpu-failed`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import fail
from ipmlang.runtime.gpu.context import is_open

if TYPE_CHECKING:
    import moderngl

Number = TypeVar("Number", bound=np.generic)


class Storage:
    """So many bytes on the card, `size` of them in use; released with `release` or the context."""

    __slots__ = ("raw", "size")

    def __init__(self, raw: moderngl.Buffer, size: int) -> None:
        self.raw = raw
        self.size = size

    def bind(self, binding: int) -> None:
        """Make it the storage block of that number."""
        self.raw.bind_to_storage_buffer(binding)

    def write(self, content: bytes | memoryview | NDArray[np.generic], offset: int = 0) -> None:
        """Put bytes, or an array of any shape, at an offset in bytes."""
        if isinstance(content, np.ndarray):
            content = np.ascontiguousarray(content).tobytes()
        if len(content):
            with _told("written"):
                self.raw.write(content, offset=offset)

    def read(self, size: int | None = None, offset: int = 0) -> bytes:
        """So many bytes from an offset, or all the rest; waits for the card."""
        size = self.size - offset if size is None else size
        if not size:
            return b""
        with _told("read"):
            return bytes(self.raw.read(size, offset=offset))

    def array(
        self, kind: type[Number], count: int | None = None, offset: int = 0
    ) -> NDArray[Number]:
        """`count` numbers of a kind from an offset in bytes, or all the rest; waits for the card.
        The array is the caller's own.
        """
        step = np.dtype(kind).itemsize
        count = (self.size - offset) // step if count is None else count
        found = np.empty(count, kind)
        if count:
            with _told("read"):
                whole = found.view(np.uint8).data
                self.raw.read_into(whole, size=count * step, offset=offset)
        return found

    def clear(self) -> None:
        """Set every byte to 0."""
        self.raw.clear()

    def copy_to(self, other: Storage, size: int, offset: int = 0, there: int = 0) -> None:
        """Copy so many bytes to an offset in another buffer, on the card."""
        if size:
            with _told("copied"):
                self.raw.ctx.copy_buffer(
                    other.raw, self.raw, size, read_offset=offset, write_offset=there
                )

    def release(self) -> None:
        """Give the memory back now, if it did not go with its context."""
        if is_open(self.raw.ctx):  # else its number may be that of a buffer of another context
            self.raw.release()
        self.size = 0


@contextmanager
def _told(what: str) -> Iterator[None]:
    """The driver's refusal as an error that people can read."""
    from moderngl import Error

    try:
        yield
    except Error as error:
        message = f"memory of the graphics card cannot be {what}: {error}"
        raise fail("gpu-failed", message, hint="derive on the CPU: --backend cpu") from error
