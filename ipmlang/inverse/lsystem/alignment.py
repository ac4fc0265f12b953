"""How one sequence of points maps onto others by rotation, scale and mirroring, and onto itself.

In come points along curves as complex rows of equal length; out go frames with the largest distance
between mapped and given points, and the symmetries of a sequence. Closed sequences may start
anywhere and all may run backwards: every start is tried at once as a cross-correlation (FFT), so a
match costs M log M. Nothing here knows outlines or styles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import Complexes, Floats, Frames, frames, unit
from ipmlang.inverse.lsystem.symmetry import Symmetry, dihedral, trivial

Integers = NDArray[np.int64]

SNAP = 15.0  # degrees: turns that people write; a fitted angle this close within tolerance is one
CHUNK = 1 << 18  # points correlated at a time, so that memory stays below 100 MB


@dataclass(frozen=True, slots=True)
class Freedom:
    """Which other parameterisations draw the same curve. step: samples per segment, by multiples of
    which a closed sequence may be shifted, 0 where the start is fixed; reversible: backwards too.
    """

    step: int
    reversible: bool


def align(
    model: Complexes, rows: Complexes, freedom: Freedom, tolerance: float
) -> tuple[Frames, Floats]:
    """Frames that map `model` (M,), centred at 0, onto each of `rows` (k, M), and the errors (k,).

    Least squares over points for the best start, direction and handedness; then turns that are
    multiples of 15 degrees and scale 1 are taken where they fit about as well.
    """
    variants = _variants(model[None], freedom)[0]
    centre = rows.mean(axis=1)
    angle, scale, error = np.zeros((3, len(rows)))
    hand = np.ones(len(rows), np.int8)
    for part in _chunks(rows):
        given = rows[part] - centre[part, None]
        raw, matched, variant = _best_fit(given, variants, freedom.step)
        angle[part], scale[part], error[part] = _snapped(raw, matched, given, tolerance)
        hand[part] = np.where(variant < len(variants) // 2, 1, -1)
    return frames(centre, angle, scale, hand), error


def _variants(models: Complexes, freedom: Freedom) -> Complexes:
    """(G, V, M): each model as it is, backwards if it may be, then the same mirrored."""
    forms = [models]
    if freedom.reversible:
        back = models[:, ::-1]
        # A closed sequence keeps its first point first, so that shifts still fall on segment ends.
        forms.append(np.roll(back, 1, axis=1) if freedom.step else back)
    return np.stack(forms + [-np.conj(form) for form in forms], axis=1)


def _correlate(given: Complexes, variants: Complexes, step: int) -> Complexes:
    """(k, V, shifts) sums over m of given[k, m] * conj(variant[k, v, m + shift * step])."""
    if not step:
        return np.asarray(np.sum(given[:, None] * np.conj(variants), axis=2)[:, :, None])
    product = np.fft.fft(variants, axis=2) * np.conj(np.fft.fft(given, axis=1))[:, None]
    return np.asarray(np.conj(np.fft.ifft(product, axis=2))[:, :, ::step])


def _best_fit(
    given: Complexes, variants: Complexes, step: int
) -> tuple[Complexes, Complexes, Integers]:
    """For each row of `given`: the least-squares factor, the matched model points, the variant."""
    fits = _correlate(given, variants[None], step)
    flat = fits.reshape(len(given), -1)
    strength = np.abs(flat)
    # Among equally good fits the first wins: unmirrored, forward, same start. The margin is no more
    # than rounding, since what is lost in strength is lost squared in distance.
    best = np.argmax(strength >= strength.max(axis=1, keepdims=True) * (1 - 1e-14), axis=1)
    variant, shift = np.divmod(best, fits.shape[2])
    columns = (np.arange(given.shape[1]) + (shift * step)[:, None]) % given.shape[1]
    matched = variants[variant[:, None], columns]
    power = float(np.sum(np.abs(variants[0]) ** 2))
    return flat[np.arange(len(given)), best] / power, matched, variant


def _snapped(
    factor: Complexes, matched: Complexes, given: Complexes, tolerance: float
) -> tuple[Floats, Floats, Floats]:
    """Angle and scale of the factor, or rounder ones within the tolerance, and the error."""
    angle, scale = np.angle(factor, deg=True), np.abs(factor)
    error = np.abs(factor[:, None] * matched - given).max(axis=1)
    fitted, turn = (angle.copy(), scale.copy()), SNAP * np.round(angle / SNAP)
    one = np.ones_like(scale)
    # A round number may cost some precision, but no more than fitting has cost already.
    room = np.minimum(np.maximum(1.25 * error, tolerance / 8), tolerance)
    # From the least to the most wanted, so that the last that fits stays.
    for wanted_angle, wanted_scale in ((fitted[0], one), (turn, fitted[1]), (turn, one)):
        candidate = wanted_scale * unit(wanted_angle)
        miss = np.abs(candidate[:, None] * matched - given).max(axis=1)
        fits = miss <= room
        angle[fits], scale[fits] = wanted_angle[fits], wanted_scale[fits]
        error[fits] = miss[fits]
    return angle, scale, error


def find_symmetries(models: Complexes, freedom: Freedom, tolerances: Floats) -> list[Symmetry]:
    """The groups of G sequences (G, M), each centred at 0: the rotations and mirrors that keep
    every point within the sequence's tolerance (G,) of where a point of the sequence was.
    """
    power = np.sum(np.abs(models) ** 2, axis=1)
    limits = np.sqrt(np.maximum(0.0, 1 - models.shape[1] * tolerances**2 / power)) - 1e-12
    result = [trivial()] * len(models)
    for part in _chunks(models):
        variants = _variants(models[part], freedom)
        fits = _correlate(models[part], variants, freedom.step) / power[part, None, None]
        likely = np.abs(fits) >= limits[part, None, None]
        # One fit is the identity; only rows with more are worth a closer look.
        for row in np.flatnonzero(np.count_nonzero(likely, axis=(1, 2)) > 1).tolist():
            number = part.start + row
            turns = _proven_turns(
                models[number],
                variants[row],
                fits[row],
                likely[row],
                freedom.step,
                float(tolerances[number]),
            )
            result[number] = symmetry_of_turns(*turns)
    return result


def symmetry_of_turns(turns: list[float], mirrors: list[float]) -> Symmetry:
    """The group with these rotations and mirrored frames, angles in degrees, as measured.

    >>> symmetry_of_turns([0.0, 180.0000001], []).stabiliser.angle.tolist()
    [0.0, 180.0]
    """
    order = _order(np.array(turns))
    return dihedral(order, _axis(mirrors, order) if mirrors else None)


def _proven_turns(
    model: Complexes,
    variants: Complexes,
    fits: Complexes,
    likely: NDArray[np.bool_],
    step: int,
    tolerance: float,
) -> tuple[list[float], list[float]]:
    """Angles in degrees of the rotations and of the mirrored frames that keep every point."""
    turns: tuple[list[float], list[float]] = ([], [])
    for variant, shift in np.argwhere(likely & (fits != 0)).tolist():
        turn = fits[variant, shift] / np.abs(fits[variant, shift])
        matched = np.roll(variants[variant], -shift * step)
        if np.abs(turn * matched - model).max() <= tolerance:
            mirrored = variant >= len(variants) // 2
            turns[int(mirrored)].append(float(np.angle(turn, deg=True)))
    return turns


def _order(angles: Floats) -> int:
    """How many different rotations there are; 1 unless they are evenly spread, as in a group."""
    turns = np.sort(np.mod(angles, 360.0))
    if len(turns) < 2:
        return 1
    distinct = turns[np.concatenate([[True], np.diff(turns) > 1e-3])]
    if len(distinct) > 1 and 360.0 - distinct[-1] + distinct[0] <= 1e-3:
        distinct = distinct[:-1]
    count = len(distinct)
    even = np.arange(count) * (360.0 / count) + distinct[0]
    return count if np.abs(distinct - even).max() < 1e-2 else 1


def _axis(angles: list[float], order: int) -> float:
    """Direction of the axis nearest to +x among the mirrors' frames, whole degrees if nearly so."""
    period = 180.0 / order
    axis = min(round((angle - 180.0) / 2 % period, 9) for angle in angles)
    exact = min(((angle - 180.0) / 2 % period for angle in angles), key=lambda a: abs(a - axis))
    whole = float(np.round(exact))
    return whole % period if abs(exact - whole) < 1e-6 else exact


def closest_start(rows: Complexes, others: Complexes, freedom: Freedom) -> Floats:
    """(k,) largest distance between points of each row (k, M) and the same row of `others`, for the
    start and direction of the other that make it least; nothing is moved or turned.
    """
    result = np.full(len(rows), np.inf)
    for part in _chunks(rows):
        middle = rows[part].mean(axis=1, keepdims=True)
        a, b = rows[part] - middle, others[part] - middle
        variants = [b]
        if freedom.reversible:
            back = b[:, ::-1]
            variants.append(np.roll(back, 1, axis=1) if freedom.step else back)
        for variant in variants:
            result[part] = np.minimum(result[part], _least_shift(a, variant, freedom.step))
    return result


def _least_shift(a: Complexes, b: Complexes, step: int) -> Floats:
    if not step:
        return np.asarray(np.abs(a - b).max(axis=1))
    product = np.fft.fft(b, axis=1) * np.conj(np.fft.fft(a, axis=1))
    # The sum of squared distances is least where the real part of the correlation is largest.
    shift = np.argmax(np.fft.ifft(product, axis=1).real[:, ::step], axis=1) * step
    columns = (np.arange(a.shape[1]) + shift[:, None]) % a.shape[1]
    return np.asarray(np.abs(a - np.take_along_axis(b, columns, axis=1)).max(axis=1))


def _chunks(rows: Complexes) -> list[slice]:
    size = max(1, CHUNK // max(rows.shape[1], 1))
    return [slice(start, start + size) for start in range(0, len(rows), size)]
