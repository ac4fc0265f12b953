"""Operations of docking: pieces laid out on a grid of digits.

Records only; no executor runs them yet. A site is a symbol, a docker is what its rule places with
`at`, so docking needs no other operation.
"""

from __future__ import annotations

from ipmlang.compiler.ops.record import Param
from ipmlang.compiler.ops.scope import scoped

TABLE = (
    scoped("tile", "Lay pieces out on a grid: each count n gives an axis the cells before, 1 to "
                    "n, and "
            "after; a piece's label has one digit an axis: 1 before, 2 repeated, 3 after. `by` "
            "is the "
            "step of the first axis; the steps of further axes follow it.",
            ((Param("counts", "any", many=True), Param("by", "vector", named=True)),),
            ("tile(4, by: (2.4, 0, 0)) { 1: corner | 2: bay | 3: corner }",
             "tile(4, 3, by: (2.4, 0, 0), (0, 0, 3.1)) { 11: corner | 21: bottom | 22: bay }"),
            ("tile(4) { 1: corner }", "tile(4, by: (1, 0, 0)) { 5: corner }",
             "tile(4, by: (1, 0, 0))"),
            family="docking", effect="structure", labels=("*123",)),
)  # fmt: skip
