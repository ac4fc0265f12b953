"""Motifs with all their occurrences, where more of them stand about than were followed.

Takes a field and a motif that grew from some of the pairs of its kind; gives the same motif with
every other occurrence that shares no row with those it has. Bounded in lookups; nothing grows here.
"""

from __future__ import annotations

import numpy as np

from ipmlang.inverse.frames import Integers, compose, inverse, matrices
from ipmlang.inverse.split.search.fields import Field, look_up_moved
from ipmlang.inverse.split.search.growth import Grown
from ipmlang.inverse.split.search.seeds import MOST

WORK = 40_000  # lookups at most


def completed(field: Field, grown: Grown, error: float) -> Grown:
    """The motif with the occurrences that were not followed, if so many pairs may be of its kind
    that some were left out.
    """
    draft = field.draft
    amount = np.bincount(draft.symbol, minlength=len(draft.figures))
    rarest = int(np.argmin(amount[draft.symbol[grown.rows[0]]]))
    anchor = grown.rows[0, rarest]
    symbol = draft.symbol[anchor]
    if amount[symbol] <= MOST:
        return grown
    used = np.zeros(len(draft), np.bool_)
    used[grown.rows] = True
    others = np.nonzero((draft.symbol == symbol) & ~used)[0]
    symmetry = draft.figures[symbol].symmetry
    many = len(symmetry)
    if not 0 < len(others) * many * grown.rows.shape[1] <= WORK:
        return grown
    of = np.repeat(others, many)
    turned = compose(draft.frames[of], symmetry[np.tile(np.arange(many), len(others))])
    motion = matrices(compose(turned, inverse(draft.frames[anchor : anchor + 1])))
    ways, rows = np.arange(len(of)), np.zeros((len(of), 0), np.int64)
    for row in grown.rows[0]:
        here = draft.body[of[ways]]
        hit = look_up_moved(field, row[None], motion[ways], here, error)[0]
        rows = np.concatenate([rows, hit[:, None]], axis=1)[hit >= 0]
        ways = ways[hit >= 0]
    apart = _apart(rows, used)
    return Grown(
        np.concatenate([grown.rows, rows[apart]]),
        np.concatenate([grown.motion, motion[ways[apart]]]),
    )


def _apart(rows: Integers, used: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> Integers:
    """Which groups (w, m) share no row with one before or with what is used."""
    taken = []
    for index in np.nonzero(~used[rows].any(axis=1))[0].tolist():
        own = rows[index]
        if not used[own].any() and len(set(own.tolist())) == len(own):
            used[own] = True
            taken.append(index)
    return np.array(taken, np.int64)
