"""How position follows from one index: lines, parabolas, rings and three kinds of spiral.

A model is a kind and a few real parameters; here they are evaluated, fitted by least squares
(Gauss-Newton for what turns about a centre), started from a few members in a row, and renumbered.
Nothing here looks points up.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from ipmlang.inverse.lattices.cloud import Integers
from ipmlang.inverse.lsystem.frames import Complexes, Floats

Kind: TypeAlias = Literal["line", "parabola", "ring", "log", "archimedes", "vogel"]
TERMS: dict[Kind, int] = {
    "line": 4,
    "parabola": 6,
    "ring": 5,
    "log": 6,
    "archimedes": 6,
    "vogel": 6,
}
ROUNDS = 12
ENOUGH = 0.999  # of the misfit before: where a round leaves more, it is the last
NOTHING = 1e-12  # of the largest singular value: what is taken for none
STILL = 1e-3  # of a step: what changes by less from step to step does not turn
TURN, GROWTH = 3, 5  # where the angular step and the growth stand among the parameters
LARGE = 0.9  # of the steps of what shrinks are shorter than the one that noise is a share of


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """numbers: line x0 y0 x1 y1, parabola also x2 y2: x = x0 + x1 i + x2 i². The others begin with
    the centre x y, the phase and the step of the angle (radians); then ring radius; log a and g of
    a exp(g i); archimedes a and b of a + b i; vogel k and i0 of k sqrt(i + i0).
    closed: of a ring, members all around, 0 for an arc; its angular step is held. held: other
    parameters that are known from elsewhere.
    """

    kind: Kind
    numbers: Floats
    closed: int = 0
    held: tuple[int, ...] = ()

    @property
    def straight(self) -> bool:
        """Position is a polynomial of the index."""
        return self.kind in ("line", "parabola")

    @property
    def fixed(self) -> float:
        """How many members determine it."""
        return (TERMS[self.kind] - (self.closed > 0)) / 2


@dataclass(frozen=True, slots=True, eq=False)
class Turning:
    """What turns about a centre, at m indices: places, directions from the centre, radii, and the
    derivatives of these by the radial parameters.
    """

    places: Complexes
    ahead: Complexes
    radius: Floats
    radial: list[Floats]


def at(model: Model, index: Integers | Floats) -> Complexes:
    """(m,) positions of indices.

    >>> at(Model("line", np.array([1.0, 0, 2, 0])), np.arange(3)).real.tolist()
    [1.0, 3.0, 5.0]
    """
    i = np.asarray(index, np.float64)
    known = model.numbers
    if model.straight:
        along = known[0::2] + 1j * known[1::2]
        return np.asarray(along[0] + i * (along[1] + (i * along[2] if len(along) > 2 else 0)))
    return np.asarray(turning(model, i).places)


def _radius(model: Model, i: Floats) -> tuple[Floats, list[Floats]]:
    """Radii of indices and their derivatives by the radial parameters."""
    rest = model.numbers[4:]
    match model.kind:
        case "ring":
            return rest[0] + np.zeros(i.shape), [np.ones(i.shape)]
        case "log":
            grown = np.exp(np.clip(rest[1] * i, -60, 60))
            return rest[0] * grown, [grown, rest[0] * i * grown]
        case "archimedes":
            return rest[0] + rest[1] * i, [np.ones(i.shape), i]
        case _:
            root = np.sqrt(np.maximum(i + rest[1], 1e-9))
            return rest[0] * root, [root, rest[0] / (2 * root)]


def spacing(model: Model, index: Integers) -> Floats:
    """(m,) units between neighbours about each index: what noise is a share of. Where steps shrink,
    noise often does not: it is a share of a large one.
    """
    known = model.numbers
    match model.kind:
        case "vogel":
            return np.full(len(index), np.sqrt(np.pi) * abs(known[4]))
        case "line":
            return np.full(len(index), np.hypot(known[2], known[3]))
        case "ring":
            return np.full(len(index), abs(2 * known[4] * np.sin(known[TURN] / 2)))
    before, here, after = at(model, index + np.array([[-1], [0], [1]]))
    local = np.asarray(np.minimum(np.abs(after - here), np.abs(here - before)), np.float64)
    if model.kind == "log":
        return np.maximum(local, _large(local))
    return local


def _large(values: Floats) -> float:
    """What is at least as large as LARGE of the values, as `np.quantile`, which takes ten times as
    long for a few.
    """
    ordered, place = np.sort(values).tolist(), LARGE * (len(values) - 1)
    below = int(place)
    low, high = ordered[below], ordered[min(below + 1, len(ordered) - 1)]
    share = place - below
    return float(high - (high - low) * (1 - share) if share >= 0.5 else low + (high - low) * share)


def fit(model: Model, index: Integers, places: Complexes) -> Model:
    """The model of this kind nearest to places (m,), from where it is."""
    if model.straight:
        return _fit_straight(model, index, places)
    i = np.asarray(index, np.float64)
    held = (*model.held, TURN) if model.closed else model.held
    free = [k for k in range(len(model.numbers)) if k not in held]
    best, turned = model, turning(model, i)
    left = _misfit(turned.places, places)
    for _ in range(ROUNDS):
        apart = places - turned.places
        slope = slopes(turned, i)[:, free]
        change = np.zeros(len(best.numbers))
        change[free] = _solve(
            np.concatenate([slope.real, slope.imag]), np.concatenate([apart.real, apart.imag])
        )
        tried = Model(best.kind, best.numbers + change, best.closed, best.held)
        after = turning(tried, i)
        rest = _misfit(after.places, places)
        if not rest < left:
            break
        done = rest > ENOUGH * left
        best, turned, left = tried, after, rest
        if done:
            break
    return best


def _solve(slopes: Floats, rest: Floats) -> Floats:
    """Least squares with columns of equal size, so that turns and units go together."""
    size = np.sqrt((slopes**2).sum(axis=0))
    size[size == 0] = 1.0
    return np.asarray(np.linalg.lstsq(slopes / size, rest, rcond=NOTHING)[0] / size, np.float64)


def _misfit(found: Complexes, places: Complexes) -> float:
    return float((np.abs(places - found) ** 2).sum())


def turning(model: Model, i: Floats) -> Turning:
    """What turns, at indices (m,); with numbers (k, s, 1) that of s models, all of them (s, m)."""
    known = model.numbers
    radius, radial = _radius(model, i)
    ahead = np.exp(1j * (known[2] + known[TURN] * i))
    return Turning(known[0] + 1j * known[1] + radius * ahead, ahead, radius, radial)


def slopes(turned: Turning, i: Floats) -> Complexes:
    """(…, m, k) derivatives of the places (…, m) by each parameter."""
    made = np.empty((*turned.ahead.shape, 4 + len(turned.radial)), np.complex128)
    made[..., 0], made[..., 1] = 1, 1j
    made[..., 2] = 1j * turned.radius * turned.ahead
    made[..., 3] = made[..., 2] * i
    for k, each in enumerate(turned.radial):
        made[..., 4 + k] = turned.ahead * each
    return made


def _fit_straight(model: Model, index: Integers, places: Complexes) -> Model:
    degree = TERMS[model.kind] // 2
    middle = float(np.mean(index))
    i = index - middle
    powers = i[:, None] ** np.arange(degree)
    both = np.stack([places.real, places.imag], axis=1)
    known = np.linalg.lstsq(powers, both, rcond=None)[0]
    if degree == 3:
        known[1] -= 2 * middle * known[2]
        known[0] -= middle * known[1] + middle**2 * known[2]
    else:
        known[0] -= middle * known[1]
    return replace(model, numbers=known.ravel())


def start(kind: Kind, places: Complexes, index: Integers) -> Model | None:
    """A first guess from members (m,) at rising indices, three or more of them in a row; None if
    they cannot be one.
    """
    if kind in ("line", "parabola"):
        return _fit_straight(Model(kind, np.zeros(TERMS[kind])), index, places)
    steps, ahead = np.diff(places), np.diff(index) == 1
    twice = np.flatnonzero(ahead[1:] & ahead[:-1])
    if kind == "vogel" or not len(twice) or (np.abs(steps) == 0).any():
        return None
    ratio = steps[twice + 1] / steps[twice]
    growth = 0.0 if kind == "ring" else float(np.log(np.abs(ratio)).mean())
    turn = float(np.angle(ratio.mean()))
    similar = np.exp(growth + 1j * turn)
    if abs(similar - 1) < STILL:
        return None
    once = np.flatnonzero(ahead)
    arm = complex(np.mean(steps[once] / (similar ** index[once] * (similar - 1))))
    middle = complex(np.mean(places - arm * similar**index))
    radial = {
        "ring": [abs(arm)],
        "log": [abs(arm), growth],
        "archimedes": [abs(arm), abs(arm) * growth],
    }[kind]
    first = [middle.real, middle.imag, float(np.angle(arm)), turn, *radial]
    return fit(Model(kind, np.array(first)), index, places)


def renumbered(model: Model, first: int, last: int, back: bool) -> Model:
    """The same places with index 0 where `first` was, or with `back` where `last` was."""
    zero = float(last if back else first)
    known = model.numbers.copy()
    sign = -1.0 if back else 1.0
    if model.straight:
        along = known[0::2] + 1j * known[1::2]
        curve = along[2] if len(along) > 2 else 0j
        moved = [along[0] + zero * (along[1] + zero * curve), sign * (along[1] + 2 * zero * curve)]
        both = np.array([*moved, curve][: len(along)])
        return replace(model, numbers=np.stack([both.real, both.imag], axis=1).ravel())
    known[2] += known[TURN] * zero
    known[TURN] *= sign
    if model.kind == "log":
        known[4] *= np.exp(known[5] * zero)
        known[5] *= sign
    elif model.kind == "archimedes":
        known[4] += known[5] * zero
        known[5] *= sign
    elif model.kind == "vogel":
        known[5] += zero
    return replace(model, numbers=known)


def centre(model: Model) -> complex:
    """What a turning model turns about."""
    return complex(model.numbers[0], model.numbers[1])
