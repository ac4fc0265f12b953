"""How the members of a sequence follow from their index: the right-hand side of the paper's rule
r1.

A pattern gives the frames of the first n members in the frame of the sequence. `even` is a
polynomial in the index, in the frame of the first member; `turtle` carries on from member to member
with t(m) = t0 + tΔ·m (equation 4); `listed` goes ahead by uneven steps; `polar` goes around the
origin. Nothing here looks at drawings.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from ipmlang.inverse.lsystem.frames import Floats, Frames, compose, frames, identity, join, unit

Four: TypeAlias = tuple[float, float, float, float]
Kind: TypeAlias = Literal["even", "turtle", "listed", "polar"]
NOTHING: Four = (0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Pattern:
    """Degrees, and units of the first (turtle: of the current) member's frame.

    even: member i is at base·i + delta·i², for (x, y, angle, scale - 1).
    turtle: base is t0 = (α, d, s, β), delta is tΔ, and each step also mirrors if `mirrored`.
    listed: ahead along x by uneven `steps`.
    polar: base is (turn, radius, r, growth): member i is turned by turn·i, then goes ahead by
        radius + r·i, or by radius·√(i + r) if `rooted`, then turns back by turn·i if `upright`, and
        is 1 + growth·i as large.

    Then each member turns by `rest` and moves by `inner` in its own frame, so that a pattern which
    is plain about another point than a shape's middle (the tip of a leaf) can be found.
    """

    kind: Kind
    base: Four
    delta: Four = NOTHING
    mirrored: bool = False
    steps: tuple[float, ...] = ()
    rooted: bool = False
    upright: bool = False
    rest: float = 0.0
    inner: complex = 0j

    @property
    def constant(self) -> bool:
        """Every step is the same."""
        return self.delta == NOTHING

    def about(self, inside: Frames) -> Pattern:
        """The same with other frames of the members: turned and moved, not mirrored or scaled."""
        angle = float(inside.angle[0])
        inner = complex(inside.position[0] * unit(np.array(-angle)))
        return replace(self, rest=angle, inner=inner)

    @property
    def numbers(self) -> tuple[float, ...]:
        """All eleven that may differ between patterns of one label."""
        return (*self.base, *self.delta, self.rest, self.inner.real, self.inner.imag)

    @property
    def label(self) -> tuple[object, ...]:
        """Equal for patterns that differ in their numbers only."""
        return (self.kind, self.constant, self.mirrored, self.rooted, self.upright)

    def places(self, count: int) -> Frames:
        """(count,) frames in the frame of the sequence.

        >>> Pattern("even", (2.0, 0.0, 0.0, 0.0)).places(3).x.tolist()
        [0.0, 2.0, 4.0]
        >>> Pattern("polar", (90.0, 1.0, 1.0, 0.0)).places(3).x.tolist()
        [1.0, 0.0, -3.0]
        """
        made = self._origins(count)
        return compose(made, self.inside) if self.rest or self.inner else made

    @property
    def inside(self) -> Frames:
        """The frame of a member in the frame that the pattern gives it."""
        turned = frames(np.zeros(1, np.complex128), self.rest)
        return compose(turned, frames(np.array([self.inner])))

    def _origins(self, count: int) -> Frames:
        index = np.arange(count, dtype=np.float64)
        if self.kind == "listed":
            along = np.concatenate([[0.0], np.cumsum(self.steps)])
            return frames(along.astype(np.complex128))
        if self.kind == "even":
            x, y, angle, growth = (
                first * index + second * index * index
                for first, second in zip(self.base, self.delta, strict=True)
            )
            return frames(x + 1j * y, angle, 1 + growth)
        if self.kind == "polar":
            turn = self.base[0] * index
            heading = np.zeros_like(index) if self.upright else turn
            grown = 1 + self.base[3] * index
            return frames(self.radii(index) * unit(turn), heading, grown)
        return self._alternating(count) if self.mirrored else self._carried(index[: count - 1])

    def radii(self, index: Floats) -> Floats:
        """(n,) distances from the centre of a polar pattern's members."""
        _, radius, change, _ = self.base
        if self.rooted:
            return np.asarray(radius * np.sqrt(np.maximum(index + change, 0.0)))
        return np.asarray(radius + change * index)

    def _carried(self, index: Floats) -> Frames:
        alpha, distance, scale, beta = (
            t0 + t1 * index for t0, t1 in zip(self.base, self.delta, strict=True)
        )
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
