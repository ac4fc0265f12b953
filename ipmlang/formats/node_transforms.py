"""Matrices of copies as translation, rotation and scale, the way glTF likes them, all at once.

Takes (n, 3, 4) maps; gives their parts, and templates with numbers that print them as JSON. A map
that shears has no such parts and is printed as a matrix. Nothing here knows meshes or files.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.distinct import distinct_rows

Floats = NDArray[np.float64]

_NUMBER = "%.10g"
_MATRIX, _ROTATED, _SCALED, _SHIFTED = 8, 4, 2, 1


@dataclass(slots=True)
class Transforms:
    """matrix (n, 3, 4); translation (n, 3); rotation (n, 4) unit quaternions x, y, z, w; scale
    (n, 3), negative along x for mirrored maps; sheared (n,): the parts do not say it.
    """

    matrix: Floats
    translation: Floats
    rotation: Floats
    scale: Floats
    sheared: NDArray[np.bool_]

    def templates(self, rows: slice) -> tuple[list[str], tuple[float, ...]]:
        """The end of each node's JSON as a template, and all their numbers in order."""
        rotation, scale = self.rotation[rows], self.scale[rows]
        turned = np.concatenate([rotation, scale], axis=1)
        first, which = distinct_rows(turned)
        if len(first) * 4 <= len(which) and not self.sheared[rows].any():
            return _alike(self.translation[rows], turned[first], which)
        kind = np.where(self.sheared[rows], _MATRIX, 0)
        plain = kind == 0
        kind += np.where(plain, _kinds(turned), 0)
        kind += np.where(plain & (self.translation[rows] != 0).any(axis=1), _SHIFTED, 0)
        table = np.concatenate([self.translation[rows], turned], axis=1)
        used = _USED[kind]
        if not plain.all():
            table = np.concatenate([table, self._columns(rows)], axis=1)
        else:
            used = used[:, :10]
        return [_TEMPLATES[each] for each in kind.tolist()], tuple(table[used].tolist())

    def _columns(self, rows: slice) -> Floats:
        """The maps as the sixteen numbers of a matrix, by columns."""
        full = np.zeros((len(self.matrix[rows]), 4, 4))
        full[:, :3], full[:, 3, 3] = self.matrix[rows], 1.0
        return full.transpose(0, 2, 1).reshape(-1, 16)


def _list(count: int) -> str:
    return "[" + ",".join([_NUMBER] * count) + "]"


_TEMPLATES = [
    (',"translation":' + _list(3) if kind & _SHIFTED else "")
    + (',"rotation":' + _list(4) if kind & _ROTATED else "")
    + (',"scale":' + _list(3) if kind & _SCALED else "")
    + (',"matrix":' + _list(16) if kind & _MATRIX else "")
    + "}"
    for kind in range(16)
]
_USED = np.array(
    [
        [bool(kind & _SHIFTED)] * 3
        + [bool(kind & _ROTATED)] * 4
        + [bool(kind & _SCALED)] * 3
        + [bool(kind & _MATRIX)] * 16
        for kind in range(16)
    ]
)


def _kinds(turned: Floats) -> NDArray[np.int64]:
    """Which of rotation and scale (n, 7) have to be said."""
    rotated = (np.abs(turned[:, :3]) > 1e-15).any(axis=1)
    scaled = (np.abs(turned[:, 4:] - 1) > 1e-15).any(axis=1)
    return np.where(rotated, _ROTATED, 0) + np.where(scaled, _SCALED, 0)


def _alike(
    translation: Floats, turned: Floats, which: NDArray[np.int64]
) -> tuple[list[str], tuple[float, ...]]:
    """Templates and numbers where few rotations and scales (k, 7) serve for all: these are printed
    once, so that only translations are left to print.
    """
    kinds = _kinds(turned)
    numbers = [
        tuple(row[_USED[kind][3:10]].tolist()) for row, kind in zip(turned, kinds, strict=True)
    ]
    texts = [_TEMPLATES[kind] % own for kind, own in zip(kinds.tolist(), numbers, strict=True)]
    shift = _TEMPLATES[_SHIFTED].removesuffix("}")
    ends = [begin + text for text in texts for begin in ("", shift)]
    shifted = (translation != 0).any(axis=1)
    templates = [ends[number] for number in (which * 2 + shifted).tolist()]
    return templates, tuple(translation[shifted].reshape(-1).tolist())


def decomposed(matrix: Floats) -> Transforms:
    """The parts of maps (n, 3, 4)."""
    linear = matrix[:, :, :3]
    scale = np.linalg.norm(linear, axis=1)
    # A mirrored map mirrors its own x first.
    scale[:, 0] *= np.where(np.linalg.det(linear) < 0, -1.0, 1.0)
    flat = scale == 0
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.where(flat[:, None, :], 0.0, linear / scale[:, None, :])
    turn = _completed(turn, flat)
    gram = np.einsum("nij,nik->njk", turn, turn)
    sheared = np.abs(gram - np.eye(3)).max(axis=(1, 2), initial=0.0) > 1e-9
    return Transforms(matrix, matrix[:, :, 3], quaternions(turn), scale, sheared)


def _completed(turn: Floats, flat: NDArray[np.bool_]) -> Floats:
    """Rotations whose axes without extent are filled in so that all three are at right angles."""
    for row in np.flatnonzero(flat.any(axis=1)).tolist():
        axes = np.flatnonzero(~flat[row])
        basis = turn[row][:, axes]
        left, _, _ = np.linalg.svd(basis, full_matrices=True)
        rest = left[:, len(axes) :]
        turn[row][:, np.flatnonzero(flat[row])] = rest
        if np.linalg.det(turn[row]) < 0:
            turn[row][:, np.flatnonzero(flat[row])[0]] *= -1
    return turn


def quaternions(turn: Floats) -> Floats:
    """Unit quaternions (n, 4), x, y, z, w, of rotations (n, 3, 3), by the largest of four sums."""
    m = turn
    trace = m[:, 0, 0] + m[:, 1, 1] + m[:, 2, 2]
    diagonal = np.stack([m[:, 0, 0], m[:, 1, 1], m[:, 2, 2], trace], axis=1)
    choice = np.argmax(diagonal, axis=1)
    result = np.empty((len(m), 4))
    for case in range(3):
        rows = np.flatnonzero(choice == case)
        i, j, k = case, (case + 1) % 3, (case + 2) % 3
        result[rows, i] = 1 + 2 * m[rows, i, i] - trace[rows]
        result[rows, j] = m[rows, j, i] + m[rows, i, j]
        result[rows, k] = m[rows, k, i] + m[rows, i, k]
        result[rows, 3] = m[rows, k, j] - m[rows, j, k]
    rows = np.flatnonzero(choice == 3)
    result[rows, 0] = m[rows, 2, 1] - m[rows, 1, 2]
    result[rows, 1] = m[rows, 0, 2] - m[rows, 2, 0]
    result[rows, 2] = m[rows, 1, 0] - m[rows, 0, 1]
    result[rows, 3] = 1 + trace[rows]
    return np.asarray(result / np.linalg.norm(result, axis=1, keepdims=True))
