"""How similar curves are, after section 4.1 of the 2010 paper: samples that turn alike vote for the
move that takes one curve onto the other, and the move with most votes says how much agrees.

In come samples of one shape and of several others, out go the best moves and their similarities, 1
where everything agrees. Every sample counts by how near its counterpart is in place, direction and
curvature (the profile that mean shift uses), so similarity falls gradually. Nothing here decides
what is similar enough.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.curvature import Samples
from ipmlang.inverse.lsystem.curves import Booleans, Integers
from ipmlang.inverse.lsystem.frames import Complexes, Floats

# What counts as no agreement at all: a distance in radii, a difference of directions and of turns
# in radians.
APART, ASKEW, BENT = 0.2, np.deg2rad(20.0), np.deg2rad(16.0)
SHARP = np.deg2rad(30.0)  # turns beyond this are compared by their ratio
COARSE = 2  # every so many samples vote
TURNS = 24  # cells of the transformation space around
CELLS, CELL = 8, 0.16  # and along x and y, so many of so many radii
PEAKS = 3  # of each transformation space that are looked at
ROUNDS = 3  # of mean shift
GENEROUS, DOUBT = 1.5, 0.75  # what few samples leave open: how far apart, how similar
WIDE = 3.0  # how much further samples may be apart at first, cells being coarse
START_ROOM = 1 / 16  # of the length, how far starts may be apart where they show


@dataclass(frozen=True, slots=True, eq=False)
class Matches:
    """How one shape lies in k others. similarity: (k,) 0 to 1; factor, shift: (k,) complex, and
    mirrored: (k,), of the move in radii about centres, z -> factor * (z or -conj z) + shift.
    """

    similarity: Floats
    factor: Complexes
    shift: Complexes
    mirrored: Booleans


@dataclass(frozen=True, slots=True, eq=False)
class _Side:
    """Samples by variant: points, heading and turn (..., M)."""

    points: Complexes
    heading: Complexes
    turn: Floats

    def __getitem__(self, rows: Integers) -> _Side:
        return _Side(self.points[rows], self.heading[rows], self.turn[rows])

    def thinned(self, step: int = COARSE) -> _Side:
        """Every few of them."""
        few = (..., slice(step // 2, None, step))
        return _Side(self.points[few], self.heading[few], self.turn[few])

    def moved(self, factor: Complexes, shift: Complexes) -> _Side:
        """The samples under moves (...)."""
        unit = factor / np.maximum(np.abs(factor), 1e-300)
        return _Side(
            factor[..., None] * self.points + shift[..., None],
            unit[..., None] * self.heading,
            self.turn,
        )

    def features(self) -> Floats:
        """(..., M, 5) columns whose distance is 1 where samples have nothing in common."""
        columns = [
            self.points.real / APART,
            self.points.imag / APART,
            self.heading.real / ASKEW,
            self.heading.imag / ASKEW,
            bent(self.turn) / BENT,
        ]
        return np.stack(np.broadcast_arrays(*columns), axis=-1)


def bent(turn: Floats) -> Floats:
    """Turns as they are compared: small ones by their difference, sharp ones by their ratio."""
    return np.asarray(SHARP * np.arcsinh(turn / SHARP))


def match(
    samples: Samples, lead: int, others: Integers, directed: bool, least: float = 0.0
) -> Matches:
    """How the shape `lead` lies in others of its kind: as many subpaths, closed alike. directed:
    start and direction show; least: similarities clearly below are given as 0.
    """
    given = _Side(samples.points, samples.heading, samples.turn)[others]
    variants, hands = _variants(samples, lead, directed)
    factor, shift = _voted(variants.thinned(), given.thinned(), directed)
    form = np.broadcast_to(np.repeat(np.arange(len(hands)), PEAKS), factor.shape)
    for step, left in ((COARSE, 3), (COARSE, 1)):
        few = variants[form].thinned(step), given.thinned(step)
        factor, shift, near = _coarse(*few, factor, shift, WIDE, directed)
        best = np.argsort(-near, axis=1, kind="stable")[:, :left]
        factor, shift = (np.take_along_axis(each, best, 1) for each in (factor, shift))
        form = np.take_along_axis(form, best, 1)
    factor, shift, best = factor[:, 0], shift[:, 0], form[:, 0]
    hope = _hope(variants.thinned()[best], given.thinned(), factor, shift, directed)
    rows = np.flatnonzero(hope >= DOUBT * least)
    if not len(rows):
        return Matches(np.zeros(len(others)), factor, shift, hands[best])
    given, chosen = given[rows], variants[best[rows]]
    mine = _Links(samples.before[lead][None], samples.after[lead][None])
    yours = _Links(samples.before[others[rows]], samples.after[others[rows]])
    move = factor[rows], shift[rows]
    for _ in range(ROUNDS):
        move = _fine(chosen, given, *move, mine, yours, directed)[1:]
    similarity = np.zeros(len(others))
    similarity[rows] = _fine(chosen, given, *move, mine, yours, directed)[0]
    factor[rows], shift[rows] = move
    return Matches(similarity, factor, shift, hands[best])


def _hope(
    chosen: _Side, given: _Side, factor: Complexes, shift: Complexes, directed: bool
) -> Floats:
    """(k,) what the few samples say of the similarity."""
    features = chosen.moved(factor, shift).features()
    apart = _apart(features / GENEROUS, given.features() / GENEROUS, directed)
    mine, yours = (_weights(apart.min(axis=axis)).mean(axis=1) for axis in (1, 2))
    return np.asarray(np.minimum(mine, yours))


@dataclass(frozen=True, slots=True, eq=False)
class _Links:
    """The samples before and after each, (k, M)."""

    before: Integers
    after: Integers


def _variants(samples: Samples, lead: int, directed: bool) -> tuple[_Side, Booleans]:
    """(V, M) a shape as it is, mirrored, and either way round where that is open; which of them are
    mirrored.
    """
    points, heading, turn = samples.points[lead], samples.heading[lead], samples.turn[lead]
    image, ahead = -np.conj(points), -np.conj(heading)
    forms = [(points, heading, turn, False), (image, -ahead, turn, True)]
    if not samples.ring[lead]:
        forms = [(points, heading, turn, False), (image, ahead, -turn, True)]
    if not (samples.ring[lead] or directed):
        forms += [(points, -heading, -turn, False), (image, -ahead, turn, True)]
    columns = (np.stack([form[column] for form in forms]) for column in range(3))
    return _Side(*columns), np.array([form[3] for form in forms])


def _voted(variants: _Side, given: _Side, directed: bool) -> tuple[Complexes, Complexes]:
    """(k, V) turns and shifts at the fullest cell of each variant's transformation space."""
    size = 2 * np.pi / TURNS
    mean = (given.turn[:, None, None, :] + variants.turn[None, :, :, None]) / 2
    likely = np.abs(given.turn[:, None, None, :] - mean) <= BENT / 2
    if directed:
        likely &= _in_step(variants.points.shape[-1], given.points.shape[-1])
    row, form, mine, yours = np.nonzero(likely)
    # Where a curve turns says more about a move than a place on a straight line does.
    weight = np.abs(mean[likely]) + BENT / 8
    angles = np.angle(variants.heading), np.angle(given.heading)
    around = np.floor((angles[1][row, yours] - angles[0][form, mine]) / size + 0.5)
    turned = np.exp(1j * size * np.arange(TURNS))[around.astype(np.int64) % TURNS]
    shift = (given.points[row, yours] - turned * variants.points[form, mine]) / CELL
    x, y = (np.floor(part).astype(np.int64) + CELLS // 2 for part in (shift.real, shift.imag))
    inside = (x >= 0) & (x < CELLS) & (y >= 0) & (y < CELLS)
    number = (row * variants.points.shape[0] + form) * TURNS + around.astype(np.int64) % TURNS
    number = (number * CELLS + x) * CELLS + y
    shape = (len(given.points), len(variants.points), TURNS, CELLS, CELLS)
    votes = np.bincount(number[inside], weight[inside], int(np.prod(shape)))
    return _peaks(np.asarray(votes, np.float64).reshape(shape))


def _peaks(votes: Floats) -> tuple[Complexes, Complexes]:
    """(k, V * PEAKS) turns and shifts of the fullest cells, each in another direction."""
    # Neighbouring cells count together, so that no border splits a cluster.
    votes = votes + np.roll(votes, -1, axis=2)
    votes = votes[..., :-1, :] + votes[..., 1:, :]
    votes = votes[..., :-1] + votes[..., 1:]
    flat = votes.reshape(*votes.shape[:3], -1)
    place, height = np.argmax(flat, axis=3), flat.max(axis=3)
    turns = []
    for _ in range(PEAKS):
        cell = np.argmax(height, axis=2)
        turns.append(cell)
        near = np.abs((np.arange(TURNS) - cell[..., None] + TURNS // 2) % TURNS - TURNS // 2)
        height = np.where(near <= TURNS // 12, -1.0, height)
    cells = np.stack(turns, axis=2)
    column, line = np.divmod(np.take_along_axis(place, cells, axis=2), CELLS - 1)
    factor = np.exp(2j * np.pi / TURNS * (cells + 0.5))
    shift = CELL * ((column + 1 - CELLS // 2) + 1j * (line + 1 - CELLS // 2))
    return factor.reshape(len(votes), -1), shift.reshape(len(votes), -1)


def _in_step(count: int, other: int) -> Booleans:
    """Whether samples are about as far from the starts of their curves."""
    mine, yours = (np.arange(each) / each for each in (count, other))
    return np.asarray(np.abs(mine[:, None] - yours) <= START_ROOM)


def _apart(mine: Floats, yours: Floats, directed: bool) -> NDArray[np.float32]:
    """(..., M, N) squared distances of features (..., M, 5) and (..., N, 5), to five digits."""
    one = np.concatenate([-2 * mine, _squared(mine), np.ones_like(mine[..., :1])], axis=-1)
    other = np.concatenate([yours, np.ones_like(yours[..., :1]), _squared(yours)], axis=-1)
    result = one.astype(np.float32) @ np.swapaxes(other.astype(np.float32), -1, -2)
    if directed:
        result += ~_in_step(mine.shape[-2], yours.shape[-2])
    return np.asarray(result)


def _squared(features: Floats) -> Floats:
    return np.asarray(np.sum(features**2, axis=-1, keepdims=True))


def _weights(squares: NDArray[np.floating]) -> Floats:
    return np.clip(1.0 - np.asarray(squares, np.float64), 0.0, 1.0)


def _coarse(
    variants: _Side,
    given: _Side,
    factor: Complexes,
    shift: Complexes,
    wide: float,
    directed: bool,
) -> tuple[Complexes, Complexes, Floats]:
    """One step of mean shift for every variant: moves (k, V), and how much agreed before it."""
    mine = variants.moved(factor, shift).features()
    apart = _apart(mine / wide, given.features()[:, None] / wide, directed)
    here, there = np.argmin(apart, axis=2), np.argmin(apart, axis=3)
    weights = [
        _weights(np.take_along_axis(apart, here[:, :, None], 2)[:, :, 0]),
        _weights(np.take_along_axis(apart, there[..., None], 3)[..., 0]),
    ]
    yours = np.broadcast_to(given.points[:, None], here.shape)
    ours = np.concatenate(
        [np.take_along_axis(variants.points, here, axis=2), variants.points], axis=2
    )
    theirs = np.concatenate([yours, np.take_along_axis(yours, there, axis=2)], axis=2)
    fitted = _fitted(ours, theirs, np.concatenate(weights, axis=2), factor, shift)
    return *fitted, np.minimum(*(each.mean(axis=2) for each in weights))


def _fitted(
    ours: Complexes, theirs: Complexes, weight: Floats, factor: Complexes, shift: Complexes
) -> tuple[Complexes, Complexes]:
    """The moves of least weighted squares, the given ones where next to nothing agrees."""
    total = weight.sum(axis=-1)
    enough = total > 4
    safe = np.where(enough, total, 1.0)[..., None]
    share = weight / safe
    centre, target = (np.sum(share * each, axis=-1, keepdims=True) for each in (ours, theirs))
    power = np.sum(share * np.abs(ours - centre) ** 2, axis=-1)
    turned = np.sum(share * (theirs - target) * np.conj(ours - centre), axis=-1)
    enough &= (power > 1e-6) & (np.abs(turned) > 1e-6)
    made = np.where(enough, turned / np.where(enough, power, 1.0), factor)
    return made, np.where(enough, (target - made[..., None] * centre)[..., 0], shift)


def _fine(
    mine: _Side,
    given: _Side,
    factor: Complexes,
    shift: Complexes,
    links: _Links,
    others: _Links,
    directed: bool,
) -> tuple[Floats, Complexes, Complexes]:
    """Similarities (k,) under moves (k,), and better moves. Between samples curves run straight, in
    direction and turn as well.
    """
    features, theirs = mine.moved(factor, shift).features(), given.features()
    apart = _apart(features, theirs, directed)
    nearest = np.argmin(apart, axis=1), np.argmin(apart, axis=2)
    there = _between(features, mine.points, links, nearest[0], theirs)
    here = _between(theirs, given.points, others, nearest[1], features)
    if directed:
        there[0][np.take_along_axis(apart, nearest[0][:, None], 1)[:, 0] >= 1] = 1.0
        here[0][np.take_along_axis(apart, nearest[1][..., None], 2)[..., 0] >= 1] = 1.0
    weights = _weights(there[0]), _weights(here[0])
    ours = np.concatenate([there[1], mine.points], axis=1)
    yours = np.concatenate([given.points, here[1]], axis=1)
    fitted = _fitted(ours, yours, np.concatenate(weights, axis=1), factor, shift)
    return np.minimum(weights[0].mean(axis=1), weights[1].mean(axis=1)), *fitted


def _between(
    features: Floats, points: Complexes, links: _Links, nearest: Integers, target: Floats
) -> tuple[Floats, Complexes]:
    """(k, N) squared distances of targets (k, N, 5) from the polylines of features (k, M, 5) about
    their nearest samples, and the points (k, N) there.
    """
    row = np.arange(len(nearest))[:, None]
    foot, at = features[row, nearest], points[row, nearest]
    best = np.sum((target - foot) ** 2, axis=2)
    place = at
    for link in (links.before, links.after):
        other = link[row if len(link) > 1 else 0, nearest]
        step = features[row, other] - foot
        size = np.maximum(np.sum(step**2, axis=2), 1e-300)
        part = np.clip(np.sum((target - foot) * step, axis=2) / size, 0.0, 1.0)
        off = np.sum((target - foot - part[..., None] * step) ** 2, axis=2)
        place = np.where(off < best, at + part * (points[row, other] - at), place)
        best = np.minimum(off, best)
    return best, place
