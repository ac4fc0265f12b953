"""The table that was derived last, kept on the card: asked for again, it is not derived again.

Takes what `derive_table` takes and gives the same. A derivation of other values, another seed or
another program replaces what is kept, and so does one of the same program whose files changed on
disk meanwhile; where the card is full, what is kept goes first. Nothing is kept of what failed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from ipmlang.compiler import ir
from ipmlang.runtime.gpu.device import device
from ipmlang.runtime.gpu.table import Table, derive_table

# Compared by identity: long, and the same objects in all runs of one program.
_LONG = frozenset({"symbols", "productions", "axiom", "tables", "ground", "residual", "assets"})

Stamps = tuple[tuple[Path, int, int], ...]


@dataclass(frozen=True, slots=True)
class _Inputs:
    program: ir.Program
    attrs: tuple[float, ...]
    seed: int
    limits: ir.Limits
    stamps: Stamps

    def are(self, other: _Inputs) -> bool:
        """Whether a derivation of either makes the same table."""
        return (self.attrs, self.seed, self.limits, self.stamps) == (
            (other.attrs, other.seed, other.limits, other.stamps)
        ) and _is_same(self.program, other.program)


class _Kept:
    """What this process keeps: for one card, a table and what it was made of."""

    made: tuple[_Inputs, Table] | None = None


def table_of(
    program: ir.Program, attrs: Sequence[float], seed: int, limits: ir.Limits
) -> Table | None:
    """The same as `derive_table`. Whoever gets the table releases it, whether or not it is kept."""
    inputs = _Inputs(program, tuple(attrs), seed, limits, _stamps(program))
    card = device()
    if _Kept.made is not None:
        before, found = _Kept.made
        if found.card is card and before.are(inputs):
            return found.lend()
        forget()
    made = derive_table(program, attrs, seed, limits)
    if made is None:
        return None
    _Kept.made = inputs, made
    card.on_full = forget
    return made.lend()


def forget() -> None:
    """Keep nothing: the card has the memory back once nobody else holds the table."""
    found, _Kept.made = _Kept.made, None
    if found is not None:
        found[1].release()


def _is_same(one: ir.Program, other: ir.Program) -> bool:
    for each in fields(ir.Program):
        own, given = getattr(one, each.name), getattr(other, each.name)
        if own is not given and (each.name in _LONG or own != given):
            return False
    return True


def _stamps(program: ir.Program) -> Stamps:
    """When the files that a derivation reads were written, and their sizes."""
    paths = {each.path for each in program.assets} | {each.path for each in program.contexts}
    found = [(path, path.stat()) for path in sorted(paths) if path.exists()]
    return tuple((path, about.st_mtime_ns, about.st_size) for path, about in found)
