"""Recursion from drawings: segments in paint order become the L-system whose turtle drew them.

`fold` takes straight segments and gives a proven `Recursion` (rules, start, number of steps,
placement) or None: `strokes` reads the joints, `windows` tells congruent runs, `sizes` says which
recursions the count allows, `layout` finds the copies, `bodies` and `attach` write commands,
`settle` proves; `stochastic` reads alternatives and their draws. `find_branching` takes placed
copies of any shape in any order and gives the paper's R(m). Nothing here reads files.
"""

from __future__ import annotations

from ipmlang.inverse.recursion.branching import Branching, find_branching
from ipmlang.inverse.recursion.branching_grammar import branching_rules, branching_start
from ipmlang.inverse.recursion.fold import fold
from ipmlang.inverse.recursion.grammar import as_grammar
from ipmlang.inverse.recursion.program import Recursion

__all__ = [
    "Branching",
    "Recursion",
    "as_grammar",
    "branching_rules",
    "branching_start",
    "find_branching",
    "fold",
]
