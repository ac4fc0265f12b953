"""How the members of a sequence follow from their index: the right-hand side of the paper's rule
r1.

A pattern gives the frames of the first n members in the frame of the sequence. `even` is linear in
the frame of the first member, `turtle` carries on from member to member with t(m) = t0 + tΔ·m
(equation 4), `listed` goes ahead by uneven steps. Nothing here looks at drawings.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from ipmlang.inverse.lsystem.frames import Frames, compose, frames, identity, join, unit

Four: TypeAlias = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Pattern:
    """kind "even": base is (x, y, angle, scale) added at each step, delta is zero. kind "turtle":
    base is t0 = (α, d, s, β), delta is tΔ, and each step also mirrors if `mirrored`. kind "listed":
    the sequence heads along its x by uneven `steps`, each member turned by base[0]. Degrees, and
    units of the first (even, listed) or current (turtle) member's frame.
    """

    kind: Literal["even", "turtle", "listed"]
    base: Four
    delta: Four = (0.0, 0.0, 0.0, 0.0)
    mirrored: bool = False
    steps: tuple[float, ...] = ()

    @property
    def constant(self) -> bool:
        """Every step is the same."""
        return self.delta == (0.0, 0.0, 0.0, 0.0)

    def places(self, count: int) -> Frames:
        """(count,) frames relative to the first member.

        >>> Pattern("even", (2.0, 0.0, 0.0, 0.0)).places(3).x.tolist()
        [0.0, 2.0, 4.0]
        """
        index = np.arange(count, dtype=np.float64)
        if self.kind == "listed":
            along = np.concatenate([[0.0], np.cumsum(self.steps)])
            return frames(along.astype(np.complex128), self.base[0])
        if self.kind == "even":
            x, y, angle, growth = self.base
            return frames(index * np.complex128(complex(x, y)), index * angle, 1 + index * growth)
        step = [t0 + t1 * index[: count - 1] for t0, t1 in zip(self.base, self.delta, strict=True)]
        if self.mirrored:
            return self._alternating(count)
        alpha, distance, scale, beta = step
        size = np.concatenate([[1.0], np.cumprod(scale)])
        heading = np.concatenate([[0.0], np.cumsum(alpha + beta)])
        moves = distance * size[:-1] * unit(heading[:-1] + alpha)
        return frames(np.concatenate([[0j], np.cumsum(moves)]), heading, size)

    def _alternating(self, count: int) -> Frames:
        """A mirrored step, twice, is a plain one: places by pairs."""
        alpha, distance, scale, beta = self.base
        step = frames(np.array([distance * unit(np.array(alpha))]), alpha + beta, scale, -1)
        placed = [identity(1)]
        for _ in range(count - 1):
            placed.append(compose(placed[-1], step))
        return join(placed)
