"""Chains of points that one model predicts: grown from a few members, one prediction at a time.

Takes a cloud and a first guess; at each step the model says where members before, between and
after those known should be, they are looked up, and the model is fitted again, so that errors do
not add up. What is left is trimmed to few holes and must be unlikely by chance. Nothing here
chooses the first guess.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lattices.cloud import SELDOM, Cloud, Integers, likely
from ipmlang.inverse.lattices.models import TURN, Kind, Model, at, fit, spacing
from ipmlang.inverse.lsystem.frames import Floats

GAP = 3  # holes in a row that growing steps over
HOLES = 0.4  # share of the nodes of a chain
WHOLE = 6  # members below which a chain has no holes
GROWTHS = 40
USUAL, TAIL = 0.7, 1.4  # of the noise allowed: where the usual is less, the largest may be more
SHORT = 6  # members that must be neighbours: rounded drawings make exact chains that short
NEAREST = 3  # neighbours between which a short exact chain runs
SMOOTH = 1.0  # Durbin-Watson statistic below which residuals are no noise: 2 where they are,
CHANCE = 3.0  # give or take so many standard deviations by chance
EARLY, LATE = 2.5, 1.6  # times the noise that a prediction may be off, of few members and of many
LEAST_EXACT: dict[Kind, int] = {
    "line": 3,
    "parabola": 6,
    "ring": 4,
    "log": 5,
    "archimedes": 6,
    "vogel": 8,
}
LEAST_LOOSE: dict[Kind, int] = {
    "line": 5,
    "parabola": 7,
    "ring": 5,
    "log": 7,
    "archimedes": 8,
    "vogel": 10,
}
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """index: (m,) rising, rows: (m,) points of the cloud; reach: units, the largest residual."""

    model: Model
    index: Integers
    rows: Integers
    reach: float

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def nodes(self) -> int:
        """Members and holes."""
        if self.model.closed:
            return self.model.closed
        return int(self.index[-1] - self.index[0]) + 1


def allowance(known: Cloud, model: Model, index: Integers, share: float) -> Floats:
    """(m,) units that members may be off: `share` 0 asks for exact places."""
    if share == 0:
        return np.full(len(index), known.exact)
    return np.asarray(np.maximum(known.exact, share * spacing(model, index)))


def grow(
    known: Cloud,
    given: Model,
    index: Integers,
    rows: Integers,
    used: Mask,
    share: float,
    fitted: bool = False,
) -> Chain | None:
    """The longest chain about given members (m,) that no other took; None if they do not fit, or
    are too few; fitted: the model was fitted to these members.
    """
    model = given if fitted else fit(given, index, known.at[rows])
    for _ in range(GROWTHS):
        slack = LATE if len(rows) >= 8 else EARLY
        new_index, new_rows = _next(known, model, index, rows, used, share, slack)
        if not len(new_rows):
            break
        index, rows = np.concatenate([index, new_index]), np.concatenate([rows, new_rows])
        model = fit(model, index, known.at[rows])
        keep = _off(known, model, index, rows) <= LATE * allowance(known, model, index, share)
        if keep.sum() < 3:
            return None
        index, rows = index[keep], rows[keep]
        if not keep.all() and not keep[-len(new_rows) :].any():
            break
    if len(rows) < LEAST_EXACT[model.kind]:
        return None
    order = np.argsort(index)
    return finished(known, model, index[order], rows[order], share)


def _off(known: Cloud, model: Model, index: Integers, rows: Integers) -> Floats:
    return np.abs(known.at[rows] - at(model, index))


def _next(
    known: Cloud,
    model: Model,
    index: Integers,
    rows: Integers,
    used: Mask,
    share: float,
    slack: float,
) -> tuple[Integers, Integers]:
    """Members between, before and after the known ones, as far ahead as half their number."""
    first, last = int(index.min()), int(index.max())
    before, after = _window(model, last - first + 1)
    fresh = np.ones(last - first + before + after + 1, np.bool_)
    fresh[index - (first - before)] = False
    wanted = np.flatnonzero(fresh) + (first - before)
    if model.kind == "vogel":
        wanted = wanted[wanted + model.numbers[5] > -0.5]
    if not len(wanted):
        return wanted, wanted
    reach = slack * allowance(known, model, wanted, share)
    hit = known.find(at(model, wanted), reach)
    free = np.flatnonzero(hit >= 0)
    free = free[~used[hit[free]] & ~(hit[free, None] == rows).any(axis=1)]
    if not len(free):
        return free, free
    wanted, hit = wanted[free], hit[free]
    _, once = np.unique(hit, return_index=True)
    wanted, hit = wanted[np.sort(once)], hit[np.sort(once)]
    near = _unbroken(wanted, first, last)
    return wanted[near], hit[near]


def _window(model: Model, span: int) -> tuple[int, int]:
    """How far to look before and after; a ring is not gone around twice."""
    ahead = max(GAP + 1, span // 2)
    if model.kind != "ring":
        return ahead, ahead
    around = 2 * np.pi / max(abs(float(model.numbers[TURN])), 1e-9)
    room = max(0, min(round(around), 10**6) - span)
    before = min(ahead, room // 2)
    return before, min(ahead, room - before)


def _unbroken(wanted: Integers, first: int, last: int) -> Mask:
    """Which of rising indices no gap separates from the known ones."""
    after, before = wanted[wanted > last], wanted[wanted < first][::-1]
    near_after = np.minimum.accumulate(np.diff(after, prepend=last) <= GAP + 1)
    near_before = np.minimum.accumulate(np.diff(-before, prepend=-first) <= GAP + 1)
    inner = np.ones(len(wanted) - len(after) - len(before), np.bool_)
    return np.concatenate([near_before[::-1], inner, near_after])


def finished(
    known: Cloud, model: Model, index: Integers, rows: Integers, share: float
) -> Chain | None:
    """Without members that are too far off, closed where it is a full ring, with few holes."""
    for _ in range(4):
        model = closed(model, index)
        off = _off(known, model, index, rows)
        allowed = allowance(known, model, index, share)
        keep = tolerable(off, allowed, known.exact) & few_holes(model, index)
        if keep.all():
            return Chain(model, index, rows, float(off.max()))
        if keep.sum() < 3:
            return None
        index, rows = index[keep], rows[keep]
        model = fit(replace(model, closed=0), index, known.at[rows])
        if model.kind == "ring":
            model = fit(closed(model, index), index, known.at[rows])
    return None


def tolerable(off: Floats, allowed: Floats, exact: float) -> Mask:
    """(m,) which members are near enough: a few may be off more where most are off less."""
    size = off / allowed
    if (allowed <= exact).all() or np.sqrt(np.mean(size**2)) > USUAL:
        return np.asarray(size <= 1)
    return np.asarray(size <= TAIL)


def closed(model: Model, index: Integers) -> Model:
    """A ring of which most members are there, with the step that divides the full turn."""
    if model.kind != "ring" or model.closed:
        return model
    step = float(model.numbers[TURN])
    around = round(2 * np.pi / max(abs(step), 1e-6))
    span = int(index[-1] - index[0]) + 1
    off = abs(2 * np.pi / max(abs(step), 1e-6) - around) * span / around
    if around < 3 or span > around or off > 0.1 or len(index) < (1 - HOLES) * around:
        return model
    numbers = model.numbers.copy()
    numbers[TURN] = np.sign(step) * 2 * np.pi / around
    return replace(model, numbers=numbers, closed=around)


def few_holes(model: Model, index: Integers) -> Mask:
    """(m,) which members stay if holes are to be few: cut off at the widest gaps."""
    keep = np.ones(len(index), np.bool_)
    if model.closed and len(index) >= (1 - HOLES) * model.closed:
        return keep
    first, last = 0, len(index)
    while last - first > 2:
        there = index[first:last]
        nodes, count = int(there[-1] - there[0]) + 1, last - first
        if count == nodes or (count >= WHOLE and nodes - count <= HOLES * nodes):
            break
        gaps = np.diff(there)
        worst = int(np.argmax(gaps))
        if worst + 1 >= count - worst - 1:
            last = first + worst + 1
        else:
            first += worst + 1
    keep[:first], keep[last:] = False, False
    return keep


def believable(known: Cloud, chain: Chain, tests: float) -> bool:
    """Whether chance would hardly make it, and it has members enough."""
    exact = chain.reach <= known.exact
    least = (LEAST_EXACT if exact else LEAST_LOOSE)[chain.model.kind]
    if len(chain) < least:
        return False
    if len(chain) <= SHORT and exact and not _local(known, chain):
        return False
    if not exact and chain.model.kind == "ring" and not chain.model.closed and len(chain) < 6:
        return False
    reach = chain.reach
    if not exact and _drifts(known, chain):
        return False
    if not exact:
        noise = float(np.median(allowance(known, chain.model, chain.index, known.loose)))
        reach = max(reach, USUAL * noise)
    odds = likely(known, tests, chain.rows, chain.nodes, chain.model.fixed, reach)
    return odds <= (SELDOM if exact or chain.model.kind == "line" else SELDOM - 1)


def _drifts(known: Cloud, chain: Chain) -> bool:
    """Whether members are off alike where they are neighbours, as where a parabola stands for an
    arc: another rule would say that, and this one with its residuals says nothing.
    """
    off = known.at[chain.rows] - at(chain.model, chain.index)
    next_to = np.diff(chain.index) == 1
    pairs = int(next_to.sum())
    if pairs < SHORT:
        return False
    jumps = float(np.mean(np.abs(np.diff(off)[next_to]) ** 2))
    least = min(SMOOTH, 2 - CHANCE * np.sqrt(2 / pairs))  # of x and of y, each its own noise
    return bool(jumps < least * float(np.mean(np.abs(off) ** 2)))


def _local(known: Cloud, chain: Chain) -> bool:
    """Whether each member is about as near to the next as any points are there."""
    here, there = chain.rows[:-1], chain.rows[1:]
    few = min(NEAREST, known.near.shape[1]) - 1
    apart = np.abs(known.at[there] - known.at[here])
    rooms = [np.abs(known.at[known.near[rows, few]] - known.at[rows]) for rows in (here, there)]
    return bool((apart <= 1.001 * np.maximum(rooms[0], rooms[1])).all())
