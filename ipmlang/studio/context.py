"""An OpenGL context without a window, and what to say where there is none.

Gives a context for the length of a `with` block, after which all that was made in it is released:
contexts that are left alone hold their memory to the end of the process. One thread may use it,
and no process may be forked while it lives.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ipmlang.compiler.diagnostics import IpmError, fail

if TYPE_CHECKING:
    import moderngl

PACKAGES = "libegl1 libgl1 libgl1-mesa-dri"
"""What Debian and Ubuntu call OpenGL in software."""

_VERSION = 330


@contextmanager
def gl_context() -> Iterator[moderngl.Context]:
    """A context of OpenGL 3.3 or later; an `IpmError` that names the packages if there is none, and
    another one if what is drawn in the block is too much for it.
    """
    context = _created()
    from moderngl import Error

    try:
        context.gc_mode = "context_gc"
        yield context
    except Error as error:
        hint = "ask for a smaller --size, or draw in software: LIBGL_ALWAYS_SOFTWARE=1 ipmlang …"
        raise fail("cannot-draw", f"OpenGL refused to draw this: {error}", hint=hint) from error
    finally:
        context.gc()
        context.release()


def _created() -> moderngl.Context:
    reason = ""
    for settings in _ways():
        try:
            return _context(**settings)
        except ImportError as error:
            hint = "pip install moderngl"
            raise fail("no-opengl", f"pictures need moderngl: {error}", hint=hint) from error
        except Exception as error:  # moderngl and glcontext raise plain ones
            reason = reason or str(error)
    raise _missing(reason)


def _ways() -> tuple[dict[str, str], ...]:
    """How to ask for a context, the best first; EGL needs no window system."""
    if not sys.platform.startswith("linux"):
        return ({},)
    os.environ.setdefault("EGL_LOG_LEVEL", "fatal")  # no chatter about cards it may not open
    by_name = {"libgl": "libGL.so.1", "libegl": "libEGL.so.1"}  # where the linker keeps no cache
    return {"backend": "egl"}, {"backend": "egl", **by_name}


def _context(**settings: str) -> moderngl.Context:
    from moderngl import create_context

    # Its stub takes every setting for a dictionary.
    return create_context(_VERSION, standalone=True, **settings)  # type: ignore[arg-type]


def _missing(reason: str) -> IpmError:
    return fail(
        "no-opengl",
        f"there is no OpenGL to draw with on this machine: {reason}",
        hint=f"install one, a software renderer will do: apt-get install -y {PACKAGES}",
    )
