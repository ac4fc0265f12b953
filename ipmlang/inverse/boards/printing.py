"""Boards, figures and labelled things as syntax, whichever it is.

Takes what was found for a stretch of the axiom; gives the loop, the table and the rules that say
it. Nothing here decides anything.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias, assert_never

from ipmlang.compiler import ast
from ipmlang.inverse.boards.board import Board
from ipmlang.inverse.boards.board_printing import Printed, printed_board
from ipmlang.inverse.boards.figure_printing import printed_figures
from ipmlang.inverse.boards.figures import Figures
from ipmlang.inverse.boards.label_printing import printed_labels
from ipmlang.inverse.boards.labelled import Labelled
from ipmlang.inverse.naming import Names

Block: TypeAlias = (
    "Board | Figures | Labelled"  # all have the rows of the axiom from `start` to `stop`
)


def printed_block(
    block: Block, names: Mapping[int, str], given: Names, error: float, before: Sequence[Printed]
) -> Printed:
    """A block as syntax. names: of the symbols; given: names that are taken; error: units, what a
    point may be off; before: what stands before it.
    """
    match block:
        case Board():
            return printed_board(block, names, given)
        case Figures():
            heads = {each.start: each.loop.head for each in before}
            head = None if block.like is None else heads.get(block.like)
            table = head.table if isinstance(head, ast.Rows) else None
            return printed_figures(block, names, given, error, table)
        case Labelled():
            return printed_labels(block, names, given, error)
        case _:
            assert_never(block)
