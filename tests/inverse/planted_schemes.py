"""Models planted with known structure: schemes written by hand, spelt out and shuffled into parts.

What a planted scheme draws comes out as `Parts` in random order, so that what inference finds can
be compared with what was put in. Shapes are boxes, wedges without any symmetry, or prisms.
"""

from __future__ import annotations

import numpy as np

from ipmlang.formats.mesh_types import Mesh
from ipmlang.inverse.frames import Frames, compose, from_matrices, identity, join, moved_to, spread
from ipmlang.inverse.parts.observation import PartClass, Parts
from ipmlang.inverse.split.expansion import expand
from ipmlang.inverse.split.scheme import Item, Place, Rule, Scheme, Symbol, Terminal


def wedge(size: tuple[float, float, float]) -> PartClass:
    """A shape that looks like itself in one frame only."""
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0.3, 1, 0], [0.1, 0.2, 1]]) * size
    return _class(vertices, np.asarray(size), identity())


def box(size: tuple[float, float, float]) -> PartClass:
    """A box; its symmetry is that of its sides."""
    extent = np.asarray(size, np.float64)
    corners = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)], np.float64) * extent
    return _class(corners, extent, box_symmetry(extent))


def box_symmetry(size: np.ndarray) -> Frames:
    """The frames that map a box from (0, 0, 0) to `size` onto itself, the identity first."""
    from itertools import permutations, product

    matrices = []
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            turn = np.zeros((3, 3))
            turn[np.arange(3), order] = signs
            if np.allclose(np.abs(turn) @ size, size):
                middle = size / 2
                matrices.append(np.concatenate([turn, (middle - turn @ middle)[:, None]], axis=1))
    matrices.sort(key=lambda m: (-np.trace(m[:, :3]), -np.linalg.det(m[:, :3])))
    return from_matrices(np.array(matrices))


def _class(vertices: np.ndarray, size: np.ndarray, symmetry: Frames) -> PartClass:
    count = len(vertices)
    corners = np.arange(count)
    mesh = Mesh(vertices, corners, np.array([0, count]), np.array([-1]), np.array([-1]))
    return PartClass("", mesh, size, symmetry, np.zeros(0, np.int64))


def turned(axis: int, degrees: float, at: tuple[float, float, float] = (0, 0, 0)) -> Frames:
    """One frame, turned about a coordinate axis."""
    half = np.radians(degrees) / 2
    rotation = np.zeros((1, 4))
    rotation[0, 0], rotation[0, 1 + axis] = np.cos(half), np.sin(half)
    return Frames(np.array([at], np.float64), rotation, np.ones(1), np.ones(1))


def mirrored(at: tuple[float, float, float] = (0, 0, 0)) -> Frames:
    """One frame, mirrored in x."""
    return Frames(np.array([at], np.float64), identity().rotation, -np.ones(1), np.ones(1))


def planted(
    classes: list[PartClass], rules: list[list[Item]], seed: int = 0, noise: float = 0.0
) -> Parts:
    """Parts that rules over classes draw, shuffled, their placements off by `noise` units."""
    symbols: list[Symbol] = [
        Terminal(f"part{index}", each.size, index) for index, each in enumerate(classes)
    ]
    symbols += [Rule("", np.ones(3), tuple(items)) for items in rules]
    shape, frames = expand(Scheme(tuple(symbols), moved_to(np.zeros((1, 3)))))
    return observed(classes, shape, frames, seed, noise)


def observed(
    classes: list[PartClass], shape: np.ndarray, frames: Frames, seed: int, noise: float = 0.0
) -> Parts:
    """Parts that stand in these frames, shuffled; each frame one of those that look the same."""
    random = np.random.default_rng(seed)
    order = random.permutation(len(shape))
    shape, frames = shape[order], frames[order]
    rows = []
    for index in range(len(shape)):
        symmetry = classes[shape[index]].symmetry
        pick = random.integers(len(symmetry))
        rows.append(compose(frames[index : index + 1], symmetry[pick : pick + 1]))
    frames = join(rows)
    moved = frames.position + random.uniform(-noise, noise, (len(shape), 3))
    frames = Frames(moved, frames.rotation, frames.hand, frames.scale)
    low, high = np.zeros((len(shape), 3)), np.zeros((len(shape), 3))
    for index in range(len(shape)):
        points = spread(frames[index : index + 1], classes[shape[index]].mesh.vertices)[0]
        low[index], high[index] = points.min(axis=0), points.max(axis=0)
    named = tuple(
        PartClass(f"part{k}", each.mesh, each.size, each.symmetry, np.nonzero(shape == k)[0])
        for k, each in enumerate(classes)
    )
    diagonal = float(np.linalg.norm(high.max(axis=0) - low.min(axis=0)))
    nothing = np.zeros(len(shape))
    path: tuple[tuple[str, ...], ...] = ((),) * len(shape)
    return Parts(shape, frames, low, high, path, named, nothing, diagonal, "z-up", 0, 0, 0)


def places(symbol: int, *frames: Frames) -> Place:
    """A symbol at some frames."""
    return Place(symbol, join(frames))


def at(*spots: tuple[float, float, float]) -> Frames:
    """Plain translations."""
    return moved_to(np.array(spots, np.float64))
