"""The OpenGL context that pictures are drawn in, and what to say when a picture is too much for it.

Gives the one context of the process for the length of a `with` block, after which all that was made
in it is released. One thread may use it, and no process may be forked while it lives.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ipmlang.compiler.diagnostics import fail
from ipmlang.runtime.gpu.context import DRAWING, shared_context

if TYPE_CHECKING:
    import moderngl

_SMALLER = "ask for a smaller --size, or draw in software: LIBGL_ALWAYS_SOFTWARE=1 ipmlang …"


@contextmanager
def gl_context() -> Iterator[moderngl.Context]:
    """A context of OpenGL 3.3 or later; an `IpmError` that names the packages if there is none, and
    another one if what is drawn in the block is too much for it.
    """
    with shared_context(DRAWING) as context:
        from moderngl import Error

        try:
            yield context
        except Error as error:
            message = f"OpenGL refused to draw this: {error}"
            raise fail("cannot-draw", message, hint=_SMALLER) from error
