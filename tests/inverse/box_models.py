"""Models of plain boxes as parts, for what looks at places alone: no meshes, no files."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ipmlang.formats.mesh_types import triangle_mesh
from ipmlang.inverse.frames import Frames, from_matrices, identity, linear, matrices
from ipmlang.inverse.parts.observation import PartClass, Parts
from ipmlang.inverse.split.expansion import expand
from ipmlang.inverse.split.scheme import Scheme

QUARTERS = tuple(
    np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]], float)
    for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))
)


@dataclass
class Boxes:
    """Parts put one after the other: the size of each class by name, and who stands where."""

    sizes: dict[str, tuple[float, float, float]]
    placed: list[tuple[str, np.ndarray]] = field(default_factory=list)

    def put(self, name: str, low: tuple[float, float, float], quarter: int = 0) -> None:
        """A box whose low corner in the world is `low`, turned by quarters about z."""
        turn = QUARTERS[quarter]
        far = turn @ np.array(self.sizes[name])
        corner = np.array(low) - np.minimum(far, 0.0)
        self.placed.append((name, np.concatenate([turn, corner[:, None]], axis=1)))

    def parts(self, seed: int | None = None) -> Parts:
        """What was put, in another order where there is a seed."""
        order = np.arange(len(self.placed))
        if seed is not None:
            order = np.random.default_rng(seed).permutation(len(order))
        used = {name for name, _ in self.placed}
        names = [name for name in self.sizes if name in used]
        shape = np.array([names.index(self.placed[row][0]) for row in order], np.int64)
        frames = from_matrices(np.array([self.placed[row][1] for row in order]))
        low, high = boxes(np.array([self.sizes[name] for name in names])[shape], frames)
        return Parts(
            shape, frames, low, high, ((),) * len(shape), self._classes(names, shape),
            np.zeros(len(shape)), float(np.linalg.norm(high.max(0) - low.min(0))), "z-up", 0, 0, 0,
        )  # fmt: skip

    def _classes(self, names: list[str], shape: np.ndarray) -> tuple[PartClass, ...]:
        nothing = triangle_mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int64))
        return tuple(
            PartClass(
                name, nothing, np.array(self.sizes[name]), identity(), np.flatnonzero(shape == row)
            )
            for row, name in enumerate(names)
        )


def boxes(size: np.ndarray, frames: Frames) -> tuple[np.ndarray, np.ndarray]:
    """The boxes in the world of boxes of `size` (n, 3) in their frames."""
    far = np.einsum("nij,nj->nij", linear(frames), size)
    low = frames.position + np.minimum(far, 0).sum(axis=2)
    return low, low + np.abs(far).sum(axis=2)


def same(scheme: Scheme, parts: Parts, small: float = 1e-9) -> bool:
    """Whether a scheme draws the parts, each in its frame, no more and no fewer."""
    shape, frames = expand(scheme)
    if len(shape) != len(parts.shape):
        return False
    drawn, seen = _rows(shape, frames), _rows(parts.shape, parts.frames)
    nearest = np.abs(drawn[:, None] - seen[None]).max(axis=2)
    return bool((nearest.min(axis=0) <= small).all() and (nearest.min(axis=1) <= small).all())


def _rows(shape: np.ndarray, frames: Frames) -> np.ndarray:
    return np.concatenate([shape[:, None] * 1e6, matrices(frames).reshape(-1, 12)], axis=1)
