"""Patterns fitted to the members of one sequence by least squares over all of them.

Takes world frames in order; gives a pattern with the world frame of the sequence, or None where no
such pattern makes sense. Fits are global: what is linear in its numbers is solved at once, what
carries on from step to step is refined until its last member is right too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ipmlang.inverse.lsystem.frames import (
    Complexes,
    Floats,
    Frames,
    compose,
    frames,
    inverse,
    unit,
    wrap,
)
from ipmlang.inverse.lsystem.patterns import Four, Pattern

ROUNDS = 12  # of refinement; it converges in three where the pattern is right


@dataclass(frozen=True, slots=True, eq=False)
class Sequence:
    """Members in order: world frames (n,), extent, whether they have no heading, and how far, in
    units, they may be off.
    """

    placed: Frames
    reach: float
    free: bool
    slack: float

    def __len__(self) -> int:
        return len(self.placed)

    @property
    def contents(self) -> tuple[bytes | float, ...]:
        """Equal for sequences that have equal members."""
        placed = self.placed
        columns = (placed.x, placed.y, placed.angle, placed.scale, placed.handedness)
        return (*(column.tobytes() for column in columns), self.reach, self.free, self.slack)

    @property
    def hand(self) -> int:
        """The handedness of the first member."""
        return int(self.placed.handedness[0])

    @property
    def angles(self) -> Floats:
        """(n,) angles without jumps."""
        angle = self.placed.angle
        return np.asarray(angle[0] + np.concatenate([[0.0], np.cumsum(wrap(np.diff(angle)))]))


Fitted = tuple[Pattern, Frames]


@dataclass(slots=True, eq=False)
class Fits:
    """Remembers what was fitted: most runs of one round of a search are there in the next one."""

    known: dict[tuple[object, ...], Fitted | None] = field(default_factory=dict)

    def __call__(
        self, fit: Callable[..., Fitted | None], given: Sequence, *how: int | float | None
    ) -> Fitted | None:
        """fit(given, *how)."""
        key = (fit.__name__, how, *given.contents)
        if key not in self.known:
            self.known[key] = fit(given, *how)
        return self.known[key]


def fit_even(given: Sequence, degree: int) -> Fitted | None:
    """Polynomials of degree 1 or 2 in the index for x, y, angle and scale."""
    index = np.arange(len(given), dtype=np.float64)
    powers = np.stack([index**k for k in range(degree + 1)], axis=1)
    # Of the degree 2 only the position: turns and sizes that change so are no person's rule.
    columns = np.stack([given.placed.x, given.placed.y, given.angles, given.placed.scale], axis=1)
    solved = np.linalg.lstsq(powers, columns, rcond=None)[0]
    solved = np.vstack([solved, np.zeros((3 - len(solved), 4))])
    x, y, angle, scale = solved[0].tolist()
    if scale <= 0:
        return None
    if given.free and degree == 1:
        angle, solved[1:, 2] = _heading(complex(*solved[1, :2]), given), 0.0
    start = frames(np.array([complex(x, y)]), angle, scale, given.hand)
    hand, factor = given.hand, complex(start.factor[0])

    def local(row: Floats) -> Four:
        step = complex(row[0], row[1]) / factor
        return (step.real * hand, step.imag, float(row[2]) * hand, float(row[3]) / scale)

    return plain_numbers(given, (Pattern("even", local(solved[1]), local(solved[2])), start))


def _heading(step: complex, given: Sequence) -> float:
    """The angle of a row of what has no heading: along the row, so that turned rows are alike."""
    if abs(step) <= given.slack:
        return 0.0
    # In a mirrored frame x points the other way.
    return float(np.angle(step if given.hand > 0 else -step, deg=True))


def fit_turtle(given: Sequence) -> Fitted | None:
    """A constant step: the mean of all steps, refined so that the last member is right."""
    alpha, distance, scale, beta = _steps(given)
    step = compose(inverse(given.placed[:1]), given.placed[1:2])
    base = (
        float(alpha[0] + np.mean(wrap(alpha - alpha[0]))),
        float(distance.mean()),
        float(scale.mean()),
        float(beta[0] + np.mean(wrap(beta - beta[0]))),
    )
    pattern = Pattern("turtle", base, mirrored=bool(step.handedness[0] < 0))
    if pattern.mirrored:
        return pattern, given.placed[:1]
    if abs(scale.mean() - 1) * given.reach <= 1e-9 * (1 + distance.mean()):
        turning = abs(base[0] + base[3]) > 1e-7
        return None if turning else (pattern, given.placed[:1])
    return _ahead(given, _refined(given, pattern))


def fit_turtle_linear(given: Sequence) -> Fitted | None:
    """t(m) = t0 + tΔ·m (equation 4), about a point of each member that is found too."""
    base, delta = [], []
    for column, values in enumerate(_steps(given)):
        if column in (0, 3):
            values = values[0] + np.concatenate([[0.0], np.cumsum(wrap(np.diff(values)))])
        slope, start = np.polyfit(np.arange(len(values)), values, 1)
        base.append(float(start))
        delta.append(float(slope))
    pattern = Pattern(
        "turtle", (base[0], base[1], base[2], base[3]), (delta[0], delta[1], delta[2], delta[3])
    )
    plain = _refined(given, pattern)
    if worst(given, plain) <= given.slack:
        return _ahead(given, plain)
    # About another point than its middle a member may turn at the end of the step only.
    turning = (0.0, delta[1], delta[2], delta[0] + delta[3])
    about = _refined(given, replace(pattern, delta=turning), shifted=True)
    return _ahead(given, about) if worst(given, about) <= given.slack else None


def _ahead(given: Sequence, fitted: Fitted) -> Fitted:
    """The same turtle with its heading along the way, so that all turning is after the step."""
    pattern, lead = fitted
    alpha = pattern.base[0]
    if pattern.delta[0] or pattern.mirrored:
        return plain_numbers(given, fitted)
    turned = frames(np.zeros(1, np.complex128), alpha)
    base = (0.0, pattern.base[1], pattern.base[2], alpha + pattern.base[3])
    made = replace(pattern, base=base, rest=pattern.rest - alpha)
    return plain_numbers(given, (made, compose(lead, turned)))


def plain_numbers(given: Sequence, fitted: Fitted) -> Fitted:
    """The same with as few decimals as keep every member where it is."""
    pattern, lead = fitted
    room = max(2 * worst(given, fitted), given.slack / 12)
    more = (0, 0, 0, 0) if pattern.kind == "polar" else (2, 2, 2, 2)
    for digits in range(8):
        base = [round(value, digits) + 0.0 for value in pattern.base]
        further = zip(pattern.delta, more, strict=True)
        delta = [round(value, digits + k) + 0.0 for value, k in further]
        plain = replace(pattern, base=_four(np.array(base)), delta=_four(np.array(delta)))
        plain = replace(plain, rest=round(pattern.rest, digits) + 0.0)
        if _may_be_right(given, plain, lead, room) and worst(given, (plain, lead)) <= room:
            return plain, lead
    return fitted


def _may_be_right(given: Sequence, pattern: Pattern, lead: Frames, room: float) -> bool:
    """Whether the last member is where an even pattern has it: what numbers that are too plain put
    furthest off. Of other patterns nothing is known.
    """
    if pattern.kind != "even" or pattern.inner:
        return True
    last, placed = len(given) - 1, given.placed
    x, y = (pattern.base[k] * last + pattern.delta[k] * last * last for k in range(2))
    at = complex(lead.factor[0]) * complex(x * int(lead.handedness[0]), y)
    off = abs(at + complex(lead.x[0] - placed.x[-1], lead.y[0] - placed.y[-1]))
    return off <= room * (1 + 1e-6)


def worst(given: Sequence, fitted: Fitted) -> float:
    """The largest distance, in units, between a member and its place in the pattern."""
    pattern, lead = fitted
    return float(np.abs(_gaps(given, pattern, lead)).max())


def _gaps(given: Sequence, pattern: Pattern, lead: Frames) -> Floats:
    """How far x, y, size and turn of every member are off, in units."""
    placed = compose(lead, pattern.places(len(given)))
    gap = placed.position - given.placed.position
    grown = (placed.scale - given.placed.scale) * given.reach
    turn = np.deg2rad(wrap(placed.angle - given.placed.angle)) * given.reach * given.placed.scale
    return np.concatenate([gap.real, gap.imag, grown] + ([] if given.free else [turn]))


def _steps(given: Sequence) -> tuple[Floats, Floats, Floats, Floats]:
    """(α, d, s, β) of every step, d and s in units of the member it starts from."""
    step = compose(inverse(given.placed[:-1]), given.placed[1:])
    distance = np.abs(step.position)
    still = distance <= 1e-9 * given.reach
    alpha = np.where(still, 0.0, np.angle(step.position, deg=True))
    return alpha, distance, step.scale, wrap(step.angle - alpha)


def _refined(given: Sequence, pattern: Pattern, shifted: bool = False) -> Fitted:
    """The numbers of a turtle and its first frame, by Gauss-Newton over all members; shifted: and
    the point of each member that it moves.
    """
    lead = given.placed[:1]
    start = np.array([*pattern.base, *pattern.delta, *np.zeros(6)])
    used = np.concatenate([_used(pattern), [True] * 4, [shifted] * 2])
    scale = _units(given, pattern)

    def frames_of(values: Floats) -> Fitted:
        full = start.copy()
        full[used] += values * scale[used]
        inner = complex(full[12], full[13])
        made = replace(pattern, base=_four(full[:4]), delta=_four(full[4:8]), inner=inner)
        at = lead.position + full[8] + 1j * full[9]
        first = frames(at, lead.angle + full[10], lead.scale * (1 + full[11]), lead.handedness)
        return made, compose(first, frames(np.array([-inner])))

    def miss(values: Floats) -> Floats:
        return _gaps(given, *frames_of(values))

    return frames_of(_least_squares(miss, int(used.sum())))


def _used(pattern: Pattern) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which numbers of a turtle may change: what is nothing stays so."""
    start = (*pattern.base, *pattern.delta)
    neutral = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    small = (1e-5, 1e-9, 1e-7, 1e-5, 1e-7, 1e-9, 1e-9, 1e-7)
    rows = zip(start, neutral, small, strict=True)
    return np.array([abs(value - rest) > room for value, rest, room in rows])


def _units(given: Sequence, pattern: Pattern) -> Floats:
    """What each number is measured in, so that all columns of the Jacobian are of one size."""
    count = float(len(given))
    length = max(abs(pattern.base[1]), 1e-9)
    turn = 1.0 / count
    one = [turn, length, 1.0 / count, turn]
    slopes = [each / count for each in one]
    return np.array([*one, *slopes, length, length, 1.0, 1.0, length, length])


def _least_squares(miss: Callable[[Floats], Floats], count: int) -> Floats:
    values = np.zeros(count)
    error = miss(values)
    for _ in range(ROUNDS):
        columns = []
        for k in range(count):
            moved = values.copy()
            moved[k] += 1e-6
            columns.append((miss(moved) - error) / 1e-6)
        step = np.linalg.lstsq(np.stack(columns, axis=1), -error, rcond=None)[0]
        better = miss(values + step)
        if not np.all(np.isfinite(better)) or np.sum(better**2) >= np.sum(error**2):
            break
        values, error = values + step, better
    return values


def _four(values: Floats) -> Four:
    a, b, c, d = values.tolist()
    return a, b, c, d


# ------------------------------------------------------------------------- polar


def fit_polar(given: Sequence, growing: bool, turn: float | None = None) -> Fitted | None:
    """Members about a centre: positions c + ω^k (A + B k), ω the turn from one to the next.

    turn: degrees, for members that stand upright; None: that of the members' own angles.
    """
    index = np.arange(len(given), dtype=np.float64)
    angle = _turn(given)[0] if turn is None else _better_turn(given, turn)
    omega = unit(angle * index)
    columns = [np.ones(len(given), np.complex128), omega] + ([omega * index] if growing else [])
    solved = np.linalg.lstsq(np.stack(columns, axis=1), given.placed.position, rcond=None)[0]
    arms = (given.placed.position - solved[0]) * omega.conj()
    slope = float(np.polyfit(index, given.placed.scale, 1)[0]) / float(given.placed.scale[0])
    ahead = complex(solved[2] - slope * solved[1]) if growing else complex(solved[1])
    if abs(ahead) <= 1e-9 * max(float(np.abs(arms).max()), given.reach):
        return None
    return _about(given, complex(solved[0]), ahead, angle, turn is not None, False)


def fit_rooted(given: Sequence) -> Fitted | None:
    """Members about a centre at radius·√(k + k0), as seeds stand in a sunflower's head."""
    index = np.arange(len(given), dtype=np.float64)
    angle = _turn(given)[0]
    found = _spokes(given.placed.position, angle * index)
    if found is None:
        return None
    centre, ahead = found
    outward = ((given.placed.position - centre) * unit(-angle * index) / ahead).real
    return _about(given, centre, ahead if outward[-1] > outward[0] else -ahead, angle, False, True)


def _about(
    given: Sequence, centre: complex, ahead: complex, turn: float, upright: bool, rooted: bool
) -> Fitted | None:
    """The pattern about a centre whose first arm has the direction `ahead`; turn: degrees."""
    index = np.arange(len(given), dtype=np.float64)
    slope, size = np.polyfit(index, given.placed.scale, 1)
    if size <= 0:
        return None
    heading = float(np.angle(ahead, deg=True))
    # In a mirrored frame x points the other way.
    lead = frames(
        np.array([centre]), heading if given.hand > 0 else heading - 180.0, float(size), given.hand
    )
    local = compose(inverse(lead), given.placed)
    around, growth = turn * given.hand, float(slope / size)
    arms = local.position * unit(-around * index)
    drift = 0.0 if upright else around
    first = float(local.angle[0])
    rest = first + float(np.mean(wrap(local.angle - drift * index - first)))
    side = 0.0 if upright else float(np.mean(arms.imag / (1 + growth * index)))
    radii = _rooted_radii(arms.real, index) if rooted else (*_even_radii(arms.real, index), 0.0)
    if radii is None:
        return None
    radius, change, along = radii
    inner = (along + 1j * side) * complex(unit(np.array(-rest)))
    made = Pattern(
        "polar",
        (around, radius, change, growth),
        rooted=rooted,
        upright=upright and not given.free,
        rest=0.0 if given.free else rest,
        inner=inner if abs(inner) * size > given.slack / 30 else 0j,
    )
    return plain_numbers(given, (made, lead))


def _even_radii(along: Floats, index: Floats) -> tuple[float, float]:
    change, radius = np.polyfit(index, along, 1)
    return float(radius), float(change)


def _rooted_radii(along: Floats, index: Floats) -> tuple[float, float, float] | None:
    """(radius, k0, rest) of radius·√(k + k0) + rest."""

    def solved(offset: float) -> tuple[Floats, float]:
        columns = np.stack([np.sqrt(index + offset), np.ones_like(index)], axis=1)
        found = np.linalg.lstsq(columns, along, rcond=None)[0]
        return found, float(np.abs(columns @ found - along).max())

    offsets = [*np.arange(0, 4, 0.25).tolist(), 5.0, 8.0, 13.0, 21.0]
    best = min(offsets, key=lambda each: solved(each)[1])

    def miss(values: Floats) -> Floats:
        found, _ = solved(max(0.0, best + float(values[0])))
        offset = max(0.0, best + float(values[0]))
        return np.asarray(found[0] * np.sqrt(index + offset) + found[1] - along)

    fine = best if best == 0 else max(0.0, best + float(_least_squares(miss, 1)[0]))
    if solved(float(np.round(fine)))[1] <= 2 * solved(fine)[1] + 1e-12:
        fine = float(np.round(fine))
    (radius, rest), error = solved(fine)
    sensible = radius > 0 and error <= 1e-3 * np.ptp(along)
    return (float(radius), fine, float(rest)) if sensible else None


def _turn(given: Sequence) -> tuple[float, float]:
    """The even turn of the members' angles, and the angle of the first."""
    angle, first = np.polyfit(np.arange(len(given)), given.angles, 1)
    return float(angle), float(first)


def _better_turn(given: Sequence, turn: float) -> float:
    """A turn measured from step to step, made right over the whole ring."""
    placed = given.placed.position
    index = np.arange(len(given), dtype=np.float64)
    for _ in range(3):
        columns = np.stack([np.ones(len(given), np.complex128), unit(turn * index)], axis=1)
        solved = np.linalg.lstsq(columns, placed, rcond=None)[0]
        if abs(solved[1]) == 0:
            return turn
        phase = np.angle((placed - solved[0]) / solved[1] * unit(-turn * index), deg=True)
        turn += float(np.polyfit(index, phase, 1)[0])
    return turn


def _spokes(placed: Complexes, angles: Floats) -> tuple[complex, complex] | None:
    """A centre c, and the one direction into which (p_k - c), turned back by its angle, goes on
    from a common point.

    With n the normal of that direction, Re(conj(n) R_k^-1 (p_k - c)) is constant: linear in
    (n, conj(n) c, the constant), so they are the singular vector of the least singular value.
    """
    back, middle = unit(-angles), complex(placed.mean())
    moved = (placed - middle) * back / max(float(np.abs(placed - middle).max()), 1e-300)
    rows = np.stack([moved.real, moved.imag, -back.real, back.imag, np.ones(len(placed))], axis=1)
    _, values, vectors = np.linalg.svd(rows)
    normal = complex(vectors[4][0], vectors[4][1])
    if values[4] > 1e-4 * values[0] or abs(normal) < 1e-9:
        return None
    normal /= abs(normal)
    # With the normal known there is one real equation for each member.
    factor = normal.conjugate() * back
    matrix = np.stack([factor.real, -factor.imag, np.ones(len(placed))], axis=1)
    solved = np.linalg.lstsq(matrix, (factor * (placed - middle)).real, rcond=None)[0]
    return middle + complex(solved[0], solved[1]), normal * -1j
