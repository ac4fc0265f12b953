"""Many placed things as columns: what terminals are, and frames as maps of points.

In go frames with a row for each thing, out come matrices, a row each. What is placed, and what
made it, is not known here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import Floats, Frames, linear


@dataclass(frozen=True, slots=True, eq=False)
class Terminals:
    """m drawn things: frames; low, high (m, 3): their boxes in their own axes; label (m,) names."""

    frames: Frames
    low: Floats
    high: Floats
    labels: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Maps:
    """n frames as maps of points: out, into (n, 3, 3) and origin (n, 3), such that `into @ point +
    origin` is a point of the world in the frame; turn (n, 3, 3): their axes, as columns.
    """

    turn: Floats
    out: Floats
    into: Floats
    origin: Floats

    def __getitem__(self, row: int) -> Maps:
        """Those of one, without the n."""
        return Maps(self.turn[row], self.out[row], self.into[row], self.origin[row])


def maps_of(frames: Frames) -> Maps:
    """Frames as maps of points."""
    out = linear(frames)
    turn = out / frames.scale[:, None, None]
    turn[:, :, 0] *= frames.hand[:, None]
    into = turn.transpose(0, 2, 1) / frames.scale[:, None, None]
    into[:, 0] *= frames.hand[:, None]
    return Maps(turn, out, into, np.einsum("nij,nj->ni", into, -frames.position))


__all__ = ["Maps", "Terminals", "maps_of"]
