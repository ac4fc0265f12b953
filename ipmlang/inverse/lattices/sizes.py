"""Chains of instances numbered by their sizes: noise moves things more often than it scales them.

Takes a cloud and the size of what stands at each point; gives chains whose members shrink or grow
evenly or by one ratio, and whose places follow from the same number. So sequences are found whole
whose steps become as small as the noise, or as the holes between members. Nothing here looks at
angles.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ipmlang.inverse.lattices.chains import (
    LATE,
    Chain,
    allowance,
    believable,
    finished,
)
from ipmlang.inverse.lattices.cloud import Cloud, Integers, cloud
from ipmlang.inverse.lattices.models import GROWTH, Kind, Model, at, fit, start
from ipmlang.inverse.lattices.seeds import find_rows
from ipmlang.inverse.lsystem.frames import Complexes, Floats

LEAST, MOST = 5, 400  # different sizes: of fewer there is no rule, of more chance makes many
AROUND = np.linspace(-1.0, 1.0, 73)  # of the room in which the step of an angle is looked for
FINEST = 1e-9  # radians: nothing is told by a finer step
STRAYS = 0.25  # of the members may have their size by chance


def find_sized(known: Cloud, sizes: Floats) -> list[Chain]:
    """Chains of points; sizes: (n,) units, of what stands at each."""
    _, first = np.unique(np.round(sizes / known.exact), return_index=True)
    if not LEAST <= len(first) <= MOST:
        return []
    size = np.maximum(sizes[first], known.exact)
    small, tests = float(size.min()), float(len(size) ** 2)
    ways: tuple[tuple[Floats, Kind], ...] = ((np.log(size) * small, "log"), (size, "parabola"))
    found: list[Chain] = []
    for along, kind in ways:
        for row in _even(known, along):
            growth = float(row.model.numbers[2]) / small
            chain = _placed(known, kind, growth, row.index, first[row.rows])
            if chain is not None and believable(known, chain, tests):
                found.append(chain)
    return found


def _even(known: Cloud, along: Floats) -> list[Chain]:
    """Even steps among numbers (k,), exact ones before noisy ones."""
    seen = cloud(along.astype(np.complex128), known.exact, known.loose, straight=True)
    used = np.zeros(len(along), np.bool_)
    return [row for share in seen.shares for row in find_rows(seen, used, share)]


def _placed(
    known: Cloud, kind: Kind, growth: float, index: Integers, rows: Integers
) -> Chain | None:
    """The chain of members (m,) whose places follow from their index, without a few strays."""
    most = int(STRAYS * len(rows))
    for _ in range(most + 1):
        places = known.at[rows]
        first = _growing(growth, index, places) if kind == "log" else start(kind, places, index)
        if first is None:
            return None
        model = fit(first, index, places)
        off = np.abs(places - at(model, index))
        allowed = allowance(known, model, index, known.loose)
        if (off <= LATE * allowed).all():
            share = 0.0 if (off <= known.exact).all() else known.loose
            return finished(known, replace(model, held=()), index, rows, share)
        keep = np.arange(len(rows)) != int(np.argmax(off / allowed))
        index, rows = index[keep], rows[keep]
    return None


def _growing(growth: float, index: Integers, places: Complexes) -> Model:
    """The spiral of this growth nearest to places (m,), whose angular step is looked for all
    around, and then ever more closely.
    """
    turn, room = 0.0, np.pi
    while room > FINEST:
        turns = turn + room * AROUND
        turn = float(turns[np.argmin(_turned(growth, turns, index, places)[2])])
        room *= 2 / len(AROUND)
    middle, arm, _ = _turned(growth, np.array([turn]), index, places)
    where, reach = complex(middle[0]), complex(arm[0])
    numbers = [where.real, where.imag, np.angle(reach), turn, abs(reach), growth]
    return Model("log", np.array(numbers), held=(GROWTH,))


def _turned(
    growth: float, turns: Floats, index: Integers, places: Complexes
) -> tuple[Complexes, Complexes, Floats]:
    """(t,) centres and first arms that fit places (m,) best, and the misfit, of angular steps."""
    i = index - index[0]
    arms = np.exp((growth + 1j * turns[:, None]) * i)
    apart = arms - arms.mean(axis=1, keepdims=True)
    arm = (apart.conj() @ (places - places.mean())) / (np.abs(apart) ** 2).sum(axis=1)
    middle = places.mean() - arm * arms.mean(axis=1)
    off = (np.abs(middle[:, None] + arm[:, None] * arms - places) ** 2).sum(axis=1)
    return middle, arm * np.exp(-(growth + 1j * turns) * index[0]), off
