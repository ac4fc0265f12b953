"""Deriving on the GPU where that was asked for, and saying why where it is not possible.

Takes a bound program and the back end that was asked for; gives the scene, or none and a note: then
numpy derives it. `gpu` asks for the card and fails without one; `auto` takes a real card if there
is one, and tells once a process why it did not. What a program cannot do there is no error for
either: those grammars run on the CPU and say so.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.runtime.gpu.device import is_of_card

if TYPE_CHECKING:
    from ipmlang.runtime.gpu.table import Table
    from ipmlang.runtime.scene import Scene


class _Told:
    """What `auto` has said in this process."""

    notes: frozenset[str] = frozenset()


def attempt(
    program: ir.Program, values: tuple[float, ...], seed: int, limits: ir.Limits, backend: str
) -> tuple[Scene | None, tuple[str, ...]]:
    """A scene and no note, or no scene and the notes for the one that numpy makes.

    Raises IpmError for errors of the grammar, and with `gpu` also for those of the card.
    """
    if backend == "gpu":
        return _derived(program, values, seed, limits)
    try:
        from ipmlang.runtime.gpu.device import device

        card = device()
        if card.is_software:
            return None, once(f"derived on the CPU: {card.info.renderer} is no graphics card")
        scene, notes = _derived(program, values, seed, limits)
    except IpmError as error:
        if not is_of_card(error):
            raise
        return None, once(f"derived on the CPU: {error.diagnostics[0].message}")
    return scene, once(*notes)


def attempt_table(
    program: ir.Program, values: tuple[float, ...], seed: int, limits: ir.Limits, backend: str
) -> Table | None:
    """The same, the result left on the card; None where `attempt` or numpy must do it, which say
    why. Raises IpmError as `attempt` does.
    """
    from ipmlang.runtime.gpu.device import device
    from ipmlang.runtime.gpu.reuse import table_of

    try:
        if backend == "auto" and device().is_software:
            return None
        return table_of(program, values, seed, limits)
    except IpmError as error:
        if backend == "auto" and is_of_card(error):
            return None
        raise


def cannot(why: str, backend: str) -> tuple[str, ...]:
    """The notes for a derivation that the CPU alone can do, for a reason beside the grammar's."""
    note = f"derived on the CPU: {why}"
    return (note,) if backend == "gpu" else once(note)


def once(*notes: str) -> tuple[str, ...]:
    """Those of the notes that were not given before in this process."""
    new = tuple(note for note in notes if note not in _Told.notes)
    _Told.notes |= frozenset(new)
    return new


def _derived(
    program: ir.Program, values: tuple[float, ...], seed: int, limits: ir.Limits
) -> tuple[Scene | None, tuple[str, ...]]:
    from ipmlang.runtime.gpu.derive import derive_gpu

    scene = derive_gpu(program, values, seed, limits)
    if scene is not None:
        return scene, ()
    from ipmlang.runtime.gpu.explain import reasons

    found = reasons(program)
    if not found:
        return None, ("derived on the CPU: the graphics card left this derivation to it",)
    why = f"{found[0].rule}, line {found[0].line}: {found[0].why}"
    return None, (f"nothing of this grammar runs on the GPU: {why}",)
