"""Styles that symbols explain: each drawn symbol has its own, as the two halves of a dragon may.

In come a proven recursion and the styles of the segments it draws, in order; out comes the same
with the styles of its symbols, or None where segments of one symbol differ. Positions are proven
elsewhere.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ipmlang.inverse.recursion.program import DRAW, Recursion, expand
from ipmlang.inverse.recursion.strokes import Integers


def with_styles(recursion: Recursion, styles: Integers) -> Recursion | None:
    """The recursion with a style for each symbol. styles: (n,) numbers, one for each segment."""
    names = [DRAW, *sorted(recursion.drawn)]
    numbered = replace(recursion, styles={name: number for number, name in enumerate(names)})
    which = expand(numbered).style
    found: dict[str, int] = {}
    for number, name in enumerate(names):
        own = np.unique(styles[which == number])
        if len(own) > 1:
            return None
        if len(own):
            found[name] = int(own[0])
    return replace(recursion, styles=found)
