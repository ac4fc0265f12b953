"""The one OpenGL context of this process: made without a window, lent to whoever computes or draws,
released when the last of them is done.

OpenGL knows one current context a thread, so computing and drawing share theirs: what one leaves in
a buffer the other draws without a copy. One thread owns it, and a process forked from its owner
must not touch OpenGL at all: the driver's threads did not come along. Nothing is drawn here.
"""

from __future__ import annotations

import atexit
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ipmlang.compiler.diagnostics import IpmError, fail

if TYPE_CHECKING:
    import moderngl

PACKAGES = "libegl1 libgl1 libgl1-mesa-dri"
"""What Debian and Ubuntu call OpenGL in software."""

DRAWING, COMPUTING = 330, 430
"""The versions of OpenGL that have what pictures and what compute shaders need."""


@dataclass(slots=True, eq=False)
class _Lent:
    """A context, the thread that owns it, and how many hold it now."""

    context: moderngl.Context
    thread: int
    holders: int = 0


class _Process:
    """What this process knows of OpenGL: its context, if one is open, whether it ever had one, and
    whether it is a fork of a process that had.
    """

    lent: _Lent | None = None
    opened: bool = False
    forked: bool = False
    # Never released: a context that a fork copied belongs to the parent's driver.
    abandoned: _Lent | None = None


@contextmanager
def shared_context(version: int) -> Iterator[moderngl.Context]:
    """The context, of at least `version`, for the length of the block.

    Raises IpmError `no-opengl` where there is none of that version, and `gpu-failed` in another
    thread than the one that opened it, or in a forked process.
    """
    context = take(version)
    try:
        yield context
    finally:
        give_back(context)


def take(version: int) -> moderngl.Context:
    """Hold the context until `give_back`; errors as in `shared_context`."""
    if _Process.forked:
        message = "this process was forked from one that had opened OpenGL"
        raise fail("gpu-failed", message, hint="start worker processes with `spawn`, not `fork`")
    if _Process.lent is None:
        _Process.lent = _Lent(_created(version), threading.get_ident())
        _Process.opened = True
    lent = _Process.lent
    check_thread()
    if lent.context.version_code < version:
        raise _missing(version, f"this one has {_spelled(lent.context.version_code)}")
    lent.holders += 1
    return lent.context


def give_back(context: moderngl.Context) -> None:
    """Let go of a context; with the last holder goes all that was made in it."""
    lent = _Process.lent
    if lent is None or lent.context is not context:
        return  # it was lost, or is the parent's
    lent.holders -= 1
    if lent.thread != threading.get_ident():
        return  # a generator that another thread closed: the owner releases at its own end
    collect(lent.context)
    if lent.holders <= 0:
        _Process.lent = None
        lent.context.release()


def collect(context: moderngl.Context) -> None:
    """Release what was made in a context and nobody names any more."""
    while context.objects:
        forgotten = context.objects.popleft()
        if hasattr(forgotten, "release"):  # else it was released by hand before it was forgotten
            forgotten.release()


def is_open(context: moderngl.Context) -> bool:
    """Whether this is the context of the process, still open."""
    return _Process.lent is not None and _Process.lent.context is context


def discard(context: moderngl.Context) -> None:
    """Forget a context that the driver lost: whoever takes one next gets another."""
    if is_open(context):
        _Process.lent = None
        context.release()


def check_thread() -> None:
    """An `IpmError` in any thread but the one that opened the context."""
    lent = _Process.lent
    if lent is not None and lent.thread != threading.get_ident():
        raise fail(
            "gpu-failed",
            "the OpenGL context belongs to another thread of this process",
            hint="derive and draw in one thread, or let that one release the GPU first",
        )


def _abandon_in_fork() -> None:
    # Also after a release: the driver's threads, which the child lacks, outlive their context.
    _Process.abandoned, _Process.lent = _Process.lent, None
    _Process.forked = _Process.opened


def _release_at_exit() -> None:
    lent = _Process.lent
    if lent is not None and lent.thread == threading.get_ident():
        lent.holders = 1
        give_back(lent.context)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_abandon_in_fork)
atexit.register(_release_at_exit)


def _created(version: int) -> moderngl.Context:
    """A context for everything if the machine has one, else one of `version`."""
    reason = ""
    for wanted in dict.fromkeys((COMPUTING, version)):
        for settings in _ways():
            try:
                context = _context(wanted, **settings)
            except ImportError as error:
                message = f"pictures and the GPU need moderngl: {error}"
                raise fail("no-opengl", message, hint="pip install moderngl") from error
            except Exception as error:  # moderngl and glcontext raise plain ones
                reason = reason or str(error)
            else:
                # What nobody names any more is released by `give_back`, in the owner's thread.
                context.gc_mode = "context_gc"
                return context
    raise _missing(version, reason)


def _ways() -> tuple[dict[str, str], ...]:
    """How to ask for a context, the best first; EGL needs no window system."""
    if not sys.platform.startswith("linux"):
        return ({},)
    os.environ.setdefault("EGL_LOG_LEVEL", "fatal")  # no chatter about cards it may not open
    by_name = {"libgl": "libGL.so.1", "libegl": "libEGL.so.1"}  # where the linker keeps no cache
    return {"backend": "egl"}, {"backend": "egl", **by_name}


def _context(version: int, **settings: str) -> moderngl.Context:
    from moderngl import create_context

    # Its stub takes every setting for a dictionary.
    return create_context(version, standalone=True, **settings)  # type: ignore[arg-type]


def _missing(version: int, reason: str) -> IpmError:
    return fail(
        "no-opengl",
        f"there is no OpenGL {_spelled(version)} on this machine: {reason}",
        hint=f"install one, a software renderer will do: apt-get install -y {PACKAGES}",
    )


def _spelled(version: int) -> str:
    return f"{version // 100}.{version // 10 % 10}"
