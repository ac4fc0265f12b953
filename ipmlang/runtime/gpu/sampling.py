"""Contexts as numbers for the shader: one channel of each that a program fetches.

In go contexts with their texels, out come columns of doubles as `sampling.glsl` reads them. What
is too large for one buffer of the card is left to the CPU. Nothing is interpolated here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime.sampling import Context

MOST = 1 << 23  # texels of all channels together: half of a block that every driver promises


@dataclass(frozen=True, slots=True)
class Sample:
    """A channel of a context, and the word of the code that says where in the data it begins."""

    context: int
    channel: int
    word: int


def extents(contexts: Sequence[Context]) -> tuple[int, ...]:
    """How many texels each context has."""
    return tuple(context.numbers.shape[0] * context.numbers.shape[1] for context in contexts)


def numbers(context: Context, channel: int) -> NDArray[np.float64]:
    """What the shader reads of one channel: where it lies, its extent, and its texels."""
    rows, columns, _ = context.numbers.shape
    head = [*context.place, columns, rows, context.nearest]
    texels = context.meant(context.numbers[:, :, channel])
    return np.concatenate([np.array(head, np.float64), texels.ravel()])
