"""Rules that differ in numbers or symbols become one rule with parameters, steps become repeats.

Takes rules as they are printed, gives fewer and shorter ones that draw the same in the same order;
`fold` is the entry. Nothing here knows drawings, frames of shapes, or how rules were found.
"""

from ipmlang.inverse.folding.counting import rules_drawn
from ipmlang.inverse.folding.fold import MOST_ROWS, Folded, fold

__all__ = ["MOST_ROWS", "Folded", "fold", "rules_drawn"]
