"""The random scheme of language version 1: fixed bits, equal twins, no visible structure."""

from __future__ import annotations

import warnings

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ipmlang.runtime import keys

WORD = st.integers(0, keys.MASK)


def words(values: list[int]) -> keys.Words:
    return np.array(values, np.uint32)


def test_known_answers_never_change() -> None:
    assert keys.pcg3d_single(1, 2, 3) == (4204755366, 1223881804, 1500469937)
    assert keys.root(0) == (295939701, 2795123341)
    assert keys.root(3) != keys.root(3 << 32)
    assert keys.child_single(*keys.root(0), 5, 7) == (2514979237, 3930100886)
    assert keys.choice_single(*keys.root(0)) * 2**24 == 2766736


@given(st.lists(st.tuples(WORD, WORD, WORD), min_size=1, max_size=20), WORD)
def test_batches_and_single_numbers_have_the_same_bits(
    rows: list[tuple[int, int, int]], site: int
) -> None:
    k0, k1, index = (words(list(column)) for column in zip(*rows, strict=True))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        first, second = keys.child(k0, k1, site, index)
        copied = keys.copy(k0, k1, index)
        draws = keys.uniform(k0, k1, site, index, 3)
        chosen = keys.choice(k0, k1)
    for i, (a, b, c) in enumerate(rows):
        assert (first[i], second[i]) == keys.child_single(a, b, site, c)
        assert (copied[0][i], copied[1][i]) == keys.child_single(a, b, c)
        assert draws[i] == keys.uniform_single(a, b, site, c, 3)
        assert chosen[i] == keys.choice_single(a, b)


def test_blocks_do_not_show() -> None:
    count = 3 * keys.BLOCK + 5
    k0, k1 = np.arange(count, dtype=np.uint32), np.full(1, 9, np.uint32)
    whole = keys.child(k0, np.repeat(k1, count), 4, np.arange(count))
    one = keys.child_single(count - 1, 9, 4, count - 1)
    assert (whole[0][-1], whole[1][-1]) == one
    spread = keys.child(k0[:1], k1, 4, np.arange(count))
    assert (spread[0][-1], spread[1][-1]) == keys.child_single(0, 9, 4, count - 1)


def tree(levels: int, width: int) -> tuple[keys.Words, keys.Words]:
    """Keys of all leaves of a derivation tree with `width` sites a node."""
    first, second = (words([word]) for word in keys.root(1))
    for _ in range(levels):
        pairs = [keys.child(first, second, site) for site in range(width)]
        first = np.concatenate([pair[0] for pair in pairs])
        second = np.concatenate([pair[1] for pair in pairs])
    return first, second


def test_keys_of_a_tree_are_distinct_and_even() -> None:
    first, second = tree(5, 12)
    assert len(np.unique(keys.packed(first, second))) == 12**5
    for column in (first, second):
        for half in (column >> np.uint32(16), column & np.uint32(0xFFFF)):
            counts = np.bincount(half >> np.uint32(4), minlength=4096)
            chi = ((counts - len(half) / 4096) ** 2).sum() / (len(half) / 4096)
            assert abs(chi - 4095) / np.sqrt(2 * 4095) < 4


def test_draws_of_sites_copies_and_seeds_do_not_hang_together() -> None:
    first, second = tree(4, 16)
    draws = [keys.uniform(first, second, 0), keys.uniform(first, second, 1)]
    draws += [keys.uniform(first, second, 0, 0), keys.uniform(first, second, 0, 1)]
    draws += [keys.choice(first, second), keys.uniform(*keys.child(first, second, 0), 0)]
    correlation = np.corrcoef(np.array(draws)) - np.eye(len(draws))
    assert np.abs(correlation).max() < 5 / np.sqrt(len(first))
    seeds = np.array([keys.choice_single(*keys.root(seed)) for seed in range(4096)])
    assert abs(seeds.mean() - 0.5) < 4 * np.sqrt(1 / 12 / 4096)
    assert abs(np.corrcoef(seeds[1:], seeds[:-1])[0, 1]) < 4 / 64
