"""Group effects while a derivation runs: every application of `effect` is a group of its own.

In go the states in which `effect` was met, as columns of a batch or one by one; out come numbers of
groups, which shapes carry in their state like a pen's colour, and at the end the table of all
groups: what wraps each, in which frame it is anchored, where it stands. No drawing is known here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.runtime import scan
from ipmlang.runtime.code import Column
from ipmlang.runtime.scene import AssetRef, Groups

Floats = NDArray[np.float64]
FIELD = "effect"  # of the pen: holds the number of the innermost group, -1 outside all


@dataclass(slots=True, eq=False)
class Met:
    """Groups that were begun, `count` of them: the number of the text that names the effect, the
    group around, and the state's columns; each a number for all or one a group.
    """

    count: int
    text: Column
    parent: Column
    state: Mapping[str, Column]


@dataclass(slots=True, eq=False)
class Grouping:
    """The groups of one derivation."""

    met: list[Met] = field(default_factory=list)
    count: int = 0

    def begin(
        self, count: int, text: Column, parent: Column, state: Mapping[str, Column]
    ) -> Floats:
        """The numbers (count,) of new groups, one for each row of a batch."""
        first = self.count
        self.met.append(Met(count, text, parent, state))
        self.count += count
        return np.arange(first, self.count, dtype=np.float64)

    def begin_one(self, text: float, parent: float, state: Mapping[str, float]) -> float:
        """The number of one new group."""
        return float(self.begin(1, text, parent, state)[0])

    def groups(self, program: ir.Program, of: NDArray[np.int32]) -> Groups | None:
        """All groups; `of` (n,): the innermost one of each row. None if there are none."""
        if not self.count:
            return None
        columns = {
            name: self._column(name) for name in {name for each in self.met for name in each.state}
        }
        zero = np.zeros(self.count)
        position = np.stack([columns.get(axis, zero) for axis in "xyz"], axis=1)
        if "angle" in columns:
            rotation = scan.about_z(columns["angle"])
        else:
            rotation = np.stack([columns[axis] for axis in "wijk"], axis=1)
            rotation /= np.linalg.norm(rotation, axis=1)[:, None]
        texts, effect = np.unique(self._joined("text").astype(np.int64), return_inverse=True)
        return Groups(
            of,
            self._joined("parent").astype(np.int32),
            effect.reshape(-1).astype(np.int32),
            tuple(reference(program, program.strings[text]) for text in texts.tolist()),
            position,
            rotation,
            columns.get("scale", np.ones(self.count)),
            columns.get("layer", zero),
        )

    def _joined(self, name: str) -> Floats:
        parts = [np.broadcast_to(getattr(each, name), (each.count,)) for each in self.met]
        return np.concatenate(parts)

    def _column(self, name: str) -> Floats:
        parts = [np.broadcast_to(each.state[name], (each.count,)) for each in self.met]
        return np.concatenate(parts).astype(np.float64)


def reference(program: ir.Program, text: str) -> AssetRef | None:
    """`fence.parts.svg#g1`, beside the grammar; None for no text."""
    if not text:
        return None
    name, _, node = text.partition("#")
    return AssetRef(node or name, Path(program.path).parent / name, node or None)
