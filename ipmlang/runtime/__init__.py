"""Deriving a program: bind its attributes, derive, and give the scene of instances.

On the CPU, which way it goes is the program's doing, never the caller's: shapes that expand
independently go by the batched frontier, turtles that thread, and choices that are drawn again, by
strings. Both give the same keys and the same order, and so does the graphics card where it is asked
for.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ipmlang.compiler.diagnostics import fail
from ipmlang.compiler.ir import Limits, Program
from ipmlang.runtime.scene import Scene

if TYPE_CHECKING:
    from ipmlang.runtime.gpu.table import Table
    from ipmlang.runtime.lineage import Lineage
    from ipmlang.runtime.replay import Replay

BACKENDS = ("auto", "cpu", "gpu")
_BACKENDS_HINT = "choose among " + ", ".join(f"`{name}`" for name in BACKENDS)


def derive(
    program: Program,
    *,
    seed: int | None = None,
    attrs: Mapping[str, int | float | bool | str] | None = None,
    backend: str = "cpu",
    limits: Limits | None = None,
    on: Path | str | None = None,
    tell: Callable[[Lineage], None] | None = None,
) -> Scene:
    """Run a program: the same seed and attributes give the same scene, on any machine. Without a
    seed, which is seed 0, the choices that a program brings along are drawn again. A residual must
    fit what is drawn where neither seed nor attributes are given; else one that does not is left
    out, and the scene's notes say so. `on` is a file whose faces or closed paths (`town.obj`, or
    with a node `town.svg#lots`) are what it starts on, whatever its own start stands on. `tell`
    gets the derivation tree, where shapes expand independently.

    `backend`: `cpu` is numpy, which says what is right; `gpu` computes on the graphics card all
    that can be; `auto` does so where there is one, and tells in the notes once a process why it
    did not. `Scene.backend` says what ran. Choices that are drawn again, and `tell`, need numpy.

    Raises IpmError for attributes that do not fit, limits reached, and numbers that are not finite;
    with `gpu` also where there is no card, where its memory is full or it fails.
    """
    if backend not in BACKENDS:
        raise fail("no-such-backend", f"there is no back end `{backend}` here", hint=_BACKENDS_HINT)
    begun = time.process_time()
    program, values, limits, replay = _bound(program, seed, attrs, limits, on)
    if tell is not None:
        obstacle = "its derivation tree was asked for"
    else:
        obstacle = "" if replay is None else "the choices it brings along are drawn again"
    scene, notes = _on_gpu(program, values, seed or 0, limits, backend, obstacle)
    if scene is None:
        scene = _on_cpu(program, values, seed or 0, limits, tell, replay)
    scene.notes = (*notes, *scene.notes)
    scene.seconds = time.process_time() - begun
    return scene


def derive_table(
    program: Program,
    *,
    seed: int | None = None,
    attrs: Mapping[str, int | float | bool | str] | None = None,
    backend: str = "gpu",
    limits: Limits | None = None,
) -> Table | None:
    """The same on the graphics card alone, whose result stays there for pictures to be made of it;
    None where the CPU has a part in it: then `derive` gives the scene, and says why.

    Raises IpmError as `derive` does.
    """
    from ipmlang.runtime.gpu.attempt import attempt_table

    if backend == "cpu":
        return None
    program, values, limits, replay = _bound(program, seed, attrs, limits, None)
    if replay is not None:
        return None
    return attempt_table(program, values, seed or 0, limits, backend)


def _bound(
    program: Program,
    seed: int | None,
    attrs: Mapping[str, int | float | bool | str] | None,
    limits: Limits | None,
    on: Path | str | None,
) -> tuple[Program, tuple[float, ...], Limits, Replay | None]:
    """A program with what it starts on, values for its attributes, its limits, and the choices that
    are drawn again.
    """
    from ipmlang.runtime.bind import bind
    from ipmlang.runtime.replay import Replay

    if on is not None:
        from ipmlang.runtime.scopes.ground import standing_on

        program = standing_on(program, str(on))
    written = program
    program, values = bind(program, attrs, seed or 0)
    if program.residual is not None and (attrs or seed is not None):
        program = replace(program, residual=replace(program.residual, strict=False))
    limits = program.limits if limits is None else _limits(limits, written, program)
    replay = None
    if seed is None and program.choices is not None:
        replay = Replay(program, program.choices, strict=not attrs)
    return program, values, limits, replay


def _on_gpu(
    program: Program,
    values: tuple[float, ...],
    seed: int,
    limits: Limits,
    backend: str,
    obstacle: str,
) -> tuple[Scene | None, tuple[str, ...]]:
    """What the graphics card derives if that was asked for, else None, and notes that say why."""
    if backend == "cpu":
        return None, ()
    from ipmlang.runtime.gpu.attempt import attempt, cannot

    if obstacle:
        return None, cannot(obstacle, backend)
    return attempt(program, values, seed, limits, backend)


def _on_cpu(
    program: Program,
    values: tuple[float, ...],
    seed: int,
    limits: Limits,
    tell: Callable[[Lineage], None] | None,
    replay: Replay | None,
) -> Scene:
    """What numpy derives: by the batched frontier where shapes expand independently."""
    from ipmlang.runtime.numpy_backend import derive_frontier
    from ipmlang.runtime.strings import derive_string

    if replay is None or program.scoped:
        scene = derive_frontier(program, values, seed, limits, tell, replay)
        if scene is not None:
            return scene
    return derive_string(program, values, seed, limits, replay)


def _limits(given: Limits, written: Program, bound: Program) -> Limits:
    """The limits given; those that are as the program has them are left to its attributes."""
    late = () if written.late is None else written.late.limits
    own = {
        name: getattr(bound.limits, name)
        for name, _ in late
        if getattr(given, name) == getattr(written.limits, name)
    }
    return replace(given, **own)
