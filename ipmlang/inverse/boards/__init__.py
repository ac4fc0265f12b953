"""Boards: things of any size on the nodes of a grid, painted line by line.

Takes the axiom of a drawing; gives what stands on grids as formulas of the node and a number for
each thing. Nothing here looks at groups or at things that are painted in another order.
"""

from ipmlang.inverse.boards.board import Board, with_boards
from ipmlang.inverse.boards.printing import Printed, printed

__all__ = ["Board", "Printed", "printed", "with_boards"]
