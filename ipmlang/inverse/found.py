"""What every inverse method gives back before its file is told of: a proven grammar and its parts.

Nothing here searches, prints or writes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ipmlang.compiler import ast
from ipmlang.inverse.report import Report

if TYPE_CHECKING:
    from ipmlang.inverse.explanation import Explanation


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """parts: the content of the parts file; suffix: of its name; report: without the counts of
    bytes, and with only those tokens that stand in the parts file; explanation: what won in each
    round, where that was asked for.
    """

    grammar: ast.Grammar
    parts: bytes
    suffix: str
    report: Report
    explanation: Explanation | None = None
