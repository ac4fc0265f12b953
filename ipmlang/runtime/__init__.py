"""Deriving a program: bind its attributes, derive, and give the scene of instances."""

from __future__ import annotations

from collections.abc import Mapping

from ipmlang.compiler.ir import Limits, Program
from ipmlang.runtime.scene import Scene


def derive(
    program: Program,
    *,
    seed: int = 0,
    attrs: Mapping[str, int | float | bool | str] | None = None,
    backend: str = "cpu",
    limits: Limits | None = None,
) -> Scene:
    """Run a program."""
    from ipmlang.runtime.strings import derive_string

    values = []
    for attr in program.attrs:
        code, register = attr.default
        values.append(next(float(i.const) for i in code if i.out == register))
    return derive_string(program, values, seed, limits or program.limits)
