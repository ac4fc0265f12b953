"""The scheme without rules: every part placed by hand, what rules are measured against.

Takes parts; gives a scheme. Nothing is searched.
"""

from __future__ import annotations

import numpy as np

from ipmlang.inverse.frames import compose, inverse, moved_to
from ipmlang.inverse.parts.observation import Parts
from ipmlang.inverse.split.scheme import Place, Rule, Scheme, Symbol, Terminal


def flat_scheme(parts: Parts) -> Scheme:
    """One rule that places all parts, class by class, in a box around them."""
    low, high = parts.low.min(axis=0), parts.high.max(axis=0)
    frame = moved_to(low)
    terminals: list[Symbol] = [
        Terminal(each.name, each.size, number) for number, each in enumerate(parts.classes)
    ]
    items = tuple(
        Place(number, compose(inverse(frame), parts.frames[each.members]))
        for number, each in enumerate(parts.classes)
    )
    rule = Rule("", np.asarray(high - low), items)
    return Scheme((*terminals, rule), frame)
