"""Deriving a program: bind its attributes, derive, and give the scene of instances.

Which executor runs is the program's doing, never the caller's: shapes that expand independently go
by the batched frontier, turtles that thread by strings. Both give the same keys and the same order.
"""

from __future__ import annotations

import time
from collections.abc import Mapping

from ipmlang.compiler.diagnostics import fail
from ipmlang.compiler.ir import Limits, Program
from ipmlang.runtime.scene import Scene

BACKENDS = ("auto", "cpu")


def derive(
    program: Program,
    *,
    seed: int = 0,
    attrs: Mapping[str, int | float | bool | str] | None = None,
    backend: str = "cpu",
    limits: Limits | None = None,
) -> Scene:
    """Run a program: the same seed and attributes give the same scene, on any machine.

    Raises IpmError for attributes that do not fit, limits reached, and numbers that are not finite.
    """
    from ipmlang.runtime.bind import bind
    from ipmlang.runtime.numpy_backend import derive_frontier
    from ipmlang.runtime.strings import derive_string

    if backend not in BACKENDS:
        raise fail("no-such-backend", f"there is no back end `{backend}` here", hint="use `cpu`")
    begun = time.process_time()
    program, values = bind(program, attrs, seed)
    limits = limits or program.limits
    scene = derive_frontier(program, values, seed, limits)
    if scene is None:
        scene = derive_string(program, values, seed, limits)
    scene.seconds = time.process_time() - begun
    return scene
