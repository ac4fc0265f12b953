"""What a person may ask of an inference beyond the file: weights, tolerances, modes.

Plain values that are passed down unchanged, and the ranges that they must be in. Nothing here
reads a drawing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Literal, TypeAlias

from ipmlang.compiler.diagnostics import fail

Mode: TypeAlias = Literal["exact", "within", "ideal"]
MOST_WEIGHT = 10.0
LEAST_SIMILARITY = 0.6  # what the paper uses
LEAST_WITHIN, MOST_WITHIN = 1e-6, 0.1


@dataclass(frozen=True, slots=True)
class Weights:
    """How much four things count when groups compete, after equation 5 of the paper: that elements
    are near each other, that they are similar, that sequences are long, that there are many places.
    1 leaves the choice to the description length, more prefers, less avoids; 0 to 10.
    """

    near: float = 1.0
    similar: float = 1.0
    long: float = 1.0
    many: float = 1.0

    @property
    def neutral(self) -> bool:
        """Whether the description length alone decides."""
        return self == Weights()


@dataclass(frozen=True, slots=True)
class Options:
    """similarity: elements so similar (0.6 to 1, the paper's section 4.1) are one shape; 1 asks for
    equal ones. within: share of the diagonal that the grammar may be off; None for the usual bound,
    with `symmetrize` for one that the drawing's own steps choose. symmetrize: the regular grammar
    of a drawing with noise, without what is off. paper: rules for pairs that do not pay, until one
    symbol is left. explain: keep what won in each round of the search.
    """

    weights: Weights = Weights()
    similarity: float = 1.0
    within: float | None = None
    symmetrize: bool = False
    paper: bool = False
    explain: bool = False

    @property
    def mode(self) -> Mode:
        """What the proof compares with: the drawing, the drawing within a tolerance, or shapes that
        stand for similar ones.
        """
        if self.similarity < 1:
            return "ideal"
        return "exact" if self.within is None and not self.symmetrize else "within"


USUAL = Options()


def check_options(options: Options) -> None:
    """Raise IpmError for a value outside its range."""
    for weight in fields(Weights):
        value = getattr(options.weights, weight.name)
        _check(f"the weight `{weight.name}`", value, 0.0, MOST_WEIGHT, "1 is neutral")
    _check("the similarity", options.similarity, LEAST_SIMILARITY, 1.0, "1 asks for equal shapes")
    if options.within is not None:
        hint = "it is a share of the drawing's diagonal"
        _check("`within`", options.within, LEAST_WITHIN, MOST_WITHIN, hint)


def check_model_options(options: Options) -> None:
    """Raise IpmError for what can be asked of drawings alone."""
    asked = {
        "the weights": not options.weights.neutral,
        "`similarity`": options.similarity < 1,
        "`symmetrize`": options.symmetrize,
        "`explain`": options.explain,
    }
    for what, is_asked in asked.items():
        if is_asked:
            verb = "are" if what == "the weights" else "is"
            hint = "`within` says how far the grammar of a model may be off"
            raise fail("bad-command", f"{what} {verb} for drawings", hint=hint)


def _check(what: str, value: float, low: float, high: float, hint: str) -> None:
    if math.isnan(value) or not low <= value <= high:
        message = f"{what} must be from {low:g} to {high:g}, not {value:g}"
        raise fail("bad-command", message, hint=hint)
