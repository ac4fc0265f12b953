"""The numbers of random calls and of modules in a body, over trees: in the order of the text, sizes
of a split before its parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ipmlang.compiler import ast


@dataclass
class Sites:
    """The numbers of random calls and modules of a body, in the order in which they count."""

    next: int = 0
    found: dict[int, int] = field(default_factory=dict)

    def note(self, node: object) -> None:
        self.found[id(node)] = self.next
        self.next += 1

    def value(self, expr: ast.Expr) -> None:
        match expr:
            case ast.Call():
                for each in expr.args:
                    self.value(each.value)
                if expr.name in ("rand", "irand", "pick"):
                    self.note(expr)
            case ast.Binary():
                self.value(expr.left)
                self.value(expr.right)
            case ast.Unary():
                self.value(expr.value)
            case ast.If():
                for part in (expr.condition, expr.value, expr.other):
                    self.value(part)

    def body(self, elements: Sequence[ast.Element]) -> None:
        for each in elements:
            match each:
                case ast.Module():
                    for arg in each.args:
                        self.value(arg.value)
                    self.note(each)
                case ast.Bracket():
                    self.body(each.body)
                case ast.Assign() | ast.Local():
                    self.value(each.value)
                case ast.Repeat():
                    assert isinstance(each.head, ast.Count)
                    self.value(each.head.limit)
                    for hole in each.holes:
                        self.value(hole)
                    self.body(each.body)
                    if each.steps:
                        self.note((each, "steps"))
                case ast.Split():
                    self.sizes(each.parts)
                    self.parts(each.parts)
                case ast.Block():
                    for part in each.parts:
                        self.body(part.body)
                    self.note(each)

    def sizes(self, parts: Sequence[ast.SplitPart | ast.SplitGroup]) -> None:
        for each in parts:
            if isinstance(each, ast.SplitPart):
                self.value(each.size.value)
            else:
                self.sizes(each.parts)

    def parts(self, parts: Sequence[ast.SplitPart | ast.SplitGroup]) -> None:
        for each in parts:
            if isinstance(each, ast.SplitPart):
                self.body(each.body)
            else:
                self.parts(each.parts)
