"""Boards, figures and labels: what a person would say in a formula and a table.

Takes the axiom of a drawing; gives things of any size on the nodes of a grid, painted line by line,
as a number for each, figures of lines that differ in lengths alone as these lengths, and things
with labels as a list of the labels. Nothing here looks at groups or at things that are painted in
another order.
"""

from ipmlang.inverse.boards.board import Board, Formulas, with_boards
from ipmlang.inverse.boards.board_printing import Printed
from ipmlang.inverse.boards.figures import Figures, with_figures
from ipmlang.inverse.boards.labelled import Labelled, with_labels
from ipmlang.inverse.boards.printing import Block, printed_block

__all__ = [
    "Block",
    "Board",
    "Figures",
    "Formulas",
    "Labelled",
    "Printed",
    "printed_block",
    "with_boards",
    "with_figures",
    "with_labels",
]
