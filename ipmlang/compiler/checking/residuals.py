"""A `residual` item: its table, and what the columns of that are called."""

from __future__ import annotations

from ipmlang.compiler import ast
from ipmlang.compiler.checking.elements import columns_of
from ipmlang.compiler.checking.expressions import Scope
from ipmlang.compiler.diagnostics import nearest
from ipmlang.compiler.ir import RESIDUAL_COLUMNS


def check_residual(scope: Scope, residual: ast.Residual) -> None:
    """Check a residual; a column that means nothing would be lost in silence."""
    for column in columns_of(scope, residual.table, residual.span) or ():
        if column not in RESIDUAL_COLUMNS:
            scope.findings.trouble(
                residual.span,
                "no-such-column",
                f"the column `{column}` of `{residual.table}` is nothing that a residual adjusts",
                expected=", ".join(f"`{each}`" for each in RESIDUAL_COLUMNS),
                suggestions=nearest(column, RESIDUAL_COLUMNS),
            )
