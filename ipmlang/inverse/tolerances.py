"""How far off each stage of an inference may be, as shares of the drawing's diagonal.

Takes options and a drawing's observation; gives one bound for instancing, search, rounding and
proof. By default a grammar is exact; with noise the bound is divided among the stages, so that what
is proven keeps it as a whole. Nothing here measures a grammar.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ipmlang.formats.drawing import Drawing
from ipmlang.inverse.grammar_file import SHARE as ROUNDING
from ipmlang.inverse.observation import TOLERANCE, Observation, observe
from ipmlang.inverse.options import LEAST_WITHIN, MOST_WITHIN, Options
from ipmlang.inverse.terminals import SHARE

LIMIT = 1e-6  # what every element must be given back within
OF_STEP = (0.01, 0.02, 0.04)  # of the way to the nearest equal shape: noise that is dropped
OF_SIZE = 0.01  # of the smallest shape: what noise may change of a shape
MEASURED = 1.1  # deviations of similar shapes are measured at points along them


@dataclass(frozen=True, slots=True)
class Tolerances:
    """shapes: what makes shapes equal; search: how far an expansion may be from what was observed;
    rounding: what one printed number may move a point by; proof: the bound on the whole.
    """

    shapes: float = TOLERANCE
    search: float = SHARE
    rounding: float = ROUNDING
    proof: float = LIMIT


def seen(drawing: Drawing, options: Options) -> tuple[Observation, Tolerances]:
    """The drawing with as much tolerance as the options ask for."""
    observed = observe(drawing, similarity=options.similarity)
    given = Tolerances()
    if options.within is not None:
        given = relaxed(options.within)
        shapes = min(given.shapes, OF_SIZE * _smallest(observed))
        if shapes > 2 * TOLERANCE:
            observed = observe(drawing, shapes, options.similarity)
    if options.similarity < 1:
        off = MEASURED * float(observed.error.max(initial=0.0)) / observed.diagonal
        given = replace(given, proof=given.proof + off)
    return observed, given


def _smallest(observed: Observation) -> float:
    """The extent of the smallest shape, a share of the diagonal."""
    radius = np.array([each.radius for each in observed.classes])
    drawn = radius[observed.shape] * observed.frames.scale if len(observed) else np.zeros(0)
    return float(drawn[drawn > 0].min(initial=observed.diagonal)) / observed.diagonal


def relaxed(within: float) -> Tolerances:
    """A bound divided among the stages.

    >>> relaxed(1e-3).search
    0.0007
    """
    return Tolerances(
        max(TOLERANCE, 0.1 * within),
        max(SHARE, 0.7 * within),
        max(ROUNDING, 0.05 * within),
        max(LIMIT, within),
    )


def noises(observed: Observation) -> tuple[float, ...]:
    """Bounds for a drawing with noise, from small to large: parts of the step from each shape to
    the nearest equal one, in the median.
    """
    from scipy.spatial import cKDTree

    steps = [np.zeros(0)]
    for shape in observed.classes:
        at = np.unique(observed.frames.position[shape.members])
        if len(at) > 1:
            points = np.stack([at.real, at.imag], axis=1)
            steps.append(np.asarray(cKDTree(points).query(points, 2)[0])[:, 1])
    every = np.concatenate(steps)
    step = float(np.median(every)) / observed.diagonal if len(every) else 0.0
    bounds = (float(np.clip(part * step, LEAST_WITHIN, MOST_WITHIN)) for part in OF_STEP)
    return tuple(dict.fromkeys(bounds))
