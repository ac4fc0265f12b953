"""Path keys and uniforms: a random number is a function of (seed, key, site) and of nothing else.

A shape's key is 64 bits in two u32 words; child keys and draws come from it by pcg3d (Jarzynski
and Olano, "Hash Functions for GPU Rendering", 2020), the same bits for numpy batches, for single
numbers and on a GPU. What stands in a repeat mixes in its site first and then the number of its
copy, outer repeats before inner ones, each as a full 32-bit word. Nothing here keeps a state, so
results never depend on the order of calls. The scheme is version 1 of the language: changing it
changes models.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Words: TypeAlias = NDArray[np.uint32]

MASK = 0xFFFFFFFF
ROOT_WORD = 0x1B873593
DRAW_BIT = 0x80000000  # parts draws from children: both are numbered by the same sites
CHOICE_SITE = 0x40000000  # the draw that chooses among a symbol's productions
FEW = 5  # rows hashed quicker one by one
BLOCK = 16384  # rows hashed at once: the working set stays in the second-level cache

_MULTIPLIER = np.uint32(1664525)
_INCREMENT = np.uint32(1013904223)
_SHIFT = np.uint32(16)


def root(seed: int) -> tuple[int, int]:
    """The key of a derivation: its seed (its low 64 bits), hashed.

    >>> root(0) == root(1 << 64), root(0) == root(1)
    (True, False)
    """
    x, y, _ = pcg3d_single(seed & MASK, (seed >> 32) & MASK, ROOT_WORD)
    return x, y


def child(k0: Words, k1: Words, site: Words | int, *copies: Words | int) -> tuple[Words, Words]:
    """Keys of the children at `site`, one for all or (n,). k0, k1: (n,) words of the parents' keys;
    `copies`: the numbers of the copies in the repeats around the site, outermost first, each (n,)
    or one number.
    """
    return _mixed(k0, k1, (site, *copies))


def copy(k0: Words, k1: Words, index: Words | int) -> tuple[Words, Words]:
    """Keys (n,) with the number of a repeat's copy mixed in, (n,) or one number."""
    return _mixed(k0, k1, (index,))


def uniform(k0: Words, k1: Words, site: int, *copies: Words | int) -> NDArray[np.float64]:
    """The draws of `site`, (n,) multiples of 2^-24 in [0, 1), exact in f32 and f64 alike.

    >>> draws = uniform(np.arange(4, dtype=np.uint32), np.zeros(4, np.uint32), 7)
    >>> float(draws[2]) == uniform_single(2, 0, 7)
    True
    """
    high, _ = _mixed(k0, k1, (site ^ DRAW_BIT, *copies))
    return (high >> np.uint32(8)).astype(np.float64) * 2.0**-24


def choice(k0: Words, k1: Words) -> NDArray[np.float64]:
    """The draw that chooses the production of each shape, (n,)."""
    return uniform(k0, k1, CHOICE_SITE)


def child_single(k0: int, k1: int, site: int, *copies: int) -> tuple[int, int]:
    """What `child` gives, for one key."""
    for word in (site, *copies):
        k0, k1, _ = pcg3d_single(k0, k1, word)
    return k0, k1


def uniform_single(k0: int, k1: int, site: int, *copies: int) -> float:
    """What `uniform` gives, for one key."""
    high, _ = child_single(k0, k1, site ^ DRAW_BIT, *copies)
    return (high >> 8) * 2.0**-24


def choice_single(k0: int, k1: int) -> float:
    """What `choice` gives, for one key."""
    return uniform_single(k0, k1, CHOICE_SITE)


def packed(k0: Words, k1: Words) -> NDArray[np.uint64]:
    """Keys as one u64 each, the first word high: how an instance table stores them."""
    return (k0.astype(np.uint64) << np.uint64(32)) | k1


def pcg3d_single(x: int, y: int, z: int) -> tuple[int, int, int]:
    """Three words hashed to three words."""
    x = (x * 1664525 + 1013904223) & MASK
    y = (y * 1664525 + 1013904223) & MASK
    z = (z * 1664525 + 1013904223) & MASK
    x = (x + y * z) & MASK
    y = (y + z * x) & MASK
    z = (z + x * y) & MASK
    x ^= x >> 16
    y ^= y >> 16
    z ^= z >> 16
    x = (x + y * z) & MASK
    y = (y + z * x) & MASK
    z = (z + x * y) & MASK
    return x, y, z


def pcg3d(x: Words, y: Words, z: Words | int) -> tuple[Words, Words]:
    """The first two words that pcg3d gives, for (n,) words or one third word for all."""
    x = x * _MULTIPLIER
    x += _INCREMENT
    y = y * _MULTIPLIER
    y += _INCREMENT
    if isinstance(z, int):
        z = np.full(1, (z * 1664525 + 1013904223) & MASK, np.uint32)
    else:
        z = z * _MULTIPLIER
        z += _INCREMENT
    x += y * z
    y += z * x
    z = z + x * y
    x ^= x >> _SHIFT
    y ^= y >> _SHIFT
    z ^= z >> _SHIFT
    x += y * z
    y += z * x
    return x, y


def _mixed(k0: Words, k1: Words, words: Iterable[Words | int]) -> tuple[Words, Words]:
    words = [word if isinstance(word, int) else word.astype(np.uint32) for word in words]
    count = max([len(k0), *(len(word) for word in words if not isinstance(word, int))])
    if len(k0) != count:
        k0, k1 = np.broadcast_to(k0, (count,)), np.broadcast_to(k1, (count,))
    if count <= BLOCK:
        return _chained(k0, k1, words)
    out = np.empty((2, count), np.uint32)
    for start in range(0, count, BLOCK):
        rows = slice(start, start + BLOCK)
        part = [word if isinstance(word, int) else word[rows] for word in words]
        out[0, rows], out[1, rows] = _chained(k0[rows], k1[rows], part)
    return out[0], out[1]


def _chained(k0: Words, k1: Words, words: Iterable[Words | int]) -> tuple[Words, Words]:
    if len(k0) <= FEW:
        return _one_by_one(k0, k1, words)
    for word in words:
        k0, k1 = pcg3d(k0, k1, word)
    return k0, k1


def _one_by_one(k0: Words, k1: Words, words: Iterable[Words | int]) -> tuple[Words, Words]:
    pairs = list(zip(k0.tolist(), k1.tolist(), strict=True))
    for word in words:
        each = [word] * len(pairs) if isinstance(word, int) else word.tolist()
        pairs = [child_single(*pair, own) for pair, own in zip(pairs, each, strict=True)]
    out = np.array(pairs, np.uint32).reshape(len(pairs), 2)
    return out[:, 0], out[:, 1]
