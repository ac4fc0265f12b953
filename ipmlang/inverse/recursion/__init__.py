"""Recursion from drawings: segments in paint order become the L-system whose turtle drew them.

`fold` takes straight segments and gives a proven `Recursion` (rules, start, number of steps,
placement) or None: `strokes` reads the joints, `windows` tells congruent runs, `sizes` says which
recursions the count allows, `layout` finds the copies, `bodies` and `attach` write commands,
`settle` proves; `stochastic` and `stems` read alternatives and their draws. `find_branching` takes
copies of any shape in any order and gives the paper's R(m), `find_tips` what stands at its ends.
`fold_repeats` takes segments that no recursion draws but that repeat a motif, repeats included.
"""

from __future__ import annotations

from ipmlang.inverse.recursion.branching import Branching, find_branching
from ipmlang.inverse.recursion.branching_grammar import branching_rules, branching_start, tip_place
from ipmlang.inverse.recursion.grammar import as_grammar
from ipmlang.inverse.recursion.program import Recursion
from ipmlang.inverse.recursion.repetition import fold_repeats
from ipmlang.inverse.recursion.search import fold
from ipmlang.inverse.recursion.segments import Segments, segments
from ipmlang.inverse.recursion.tips import Tipped, find_tips

__all__ = [
    "Branching",
    "Recursion",
    "Segments",
    "Tipped",
    "as_grammar",
    "branching_rules",
    "branching_start",
    "find_branching",
    "find_tips",
    "fold",
    "fold_repeats",
    "segments",
    "tip_place",
]
