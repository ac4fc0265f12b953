"""The axiom of another grammar, as elements that a grammar which imports it can use.

In go the other draft and the importing tree, out come elements with the names of the other file
qualified, and that file's text where it has to be adapted: the `turtle` item of an imported grammar
does not hold, so what it says is written into each operation that leans on it.
"""

from __future__ import annotations

from dataclasses import replace

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import fail
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.nodes import mapped
from ipmlang.compiler.ops import OPERATIONS, SETTINGS
from ipmlang.edit.draft import Draft
from ipmlang.edit.symbols import Elements, defined_names

Settings = dict[str, ast.Expr]


def axiom_of(other: Draft, alias: str, main: ast.Grammar) -> Elements:
    """The elements behind the other grammar's `start`. Raises IpmError where they mean nothing
    apart from their own file.
    """
    start = _start(other)
    named = {name for item in other.grammar.items for name in defined_names(item)}
    filled = mapped(start.axiom, lambda node: _filled(node, other.grammar, main))
    axiom = mapped(filled, lambda node: _qualified(node, alias, named))
    width = _settings(other.grammar).get("width")
    if width is None or width == _settings(main).get("width"):
        return axiom
    pen = ast.Module("!", (ast.Argument(mapped(width, lambda n: _qualified(n, alias, named))),))
    return (pen, *axiom)


def adapted(other: Draft, main: ast.Grammar) -> bytes | None:
    """The other file's text as it must be to mean the same where it is imported; None if that is
    the text it has.
    """
    tree = mapped(other.grammar, lambda node: _filled(node, other.grammar, main))
    return None if tree == other.grammar else format_grammar(tree).encode("utf-8")


def _start(other: Draft) -> ast.Start:
    starts = [item for item in other.grammar.items if isinstance(item, ast.Start)]
    if not starts:
        raise fail("bad-command", f"{other.path.name} has no `start`, so it has no axiom to take")
    start = starts[-1]
    plain = ast.Start(start.axiom)
    bound = [item for item in other.grammar.items if isinstance(item, ast.Tropism | ast.Ignore)]
    if replace(start, choices=None) != plain or bound:
        what = "takes a fixed number of steps" if start.steps is not None else "sets more than that"
        raise fail(
            "bad-command",
            f"the axiom of {other.path.name} cannot be taken alone: the file {what}",
            hint=f"draw it first: ipmlang run {other.path.name} -o part.svg, and take the drawing",
        )
    return start


def _settings(grammar: ast.Grammar) -> Settings:
    return {
        setting.key: setting.value
        for item in grammar.items
        if isinstance(item, ast.Turtle)
        for setting in item.settings
    }


def _filled(node: object, other: ast.Grammar, main: ast.Grammar) -> object:
    """An operation that leans on a turtle setting which differs, with its argument."""
    if not isinstance(node, ast.Module) or node.args:
        return node
    record = OPERATIONS.get(node.name)
    heads = {item.head.name for item in other.items if isinstance(item, ast.Rule)}
    if record is None or not record.defaults or node.name in heads:
        return node
    setting = record.defaults[0][1]
    if not isinstance(setting, str):
        return node
    own, theirs = _settings(other).get(setting), _settings(main).get(setting)
    if own == theirs:
        return node
    default = SETTINGS["turtle", setting].default
    value = own or ast.Number(float(default or 0.0))
    return replace(node, args=(ast.Argument(value),))


def _qualified(node: object, alias: str, named: set[str]) -> object:
    """A name of the other file as it is called where that file is imported."""
    match node:
        case ast.Module(name=name) | ast.Call(name=name) | ast.Block(name=name):
            return replace(node, name=f"{alias}.{name}") if _root(name) in named else node
        case ast.Name(id=name):
            return replace(node, id=f"{alias}.{name}") if _root(name) in named else node
        case ast.Rows(table=name):
            return replace(node, table=f"{alias}.{name}") if _root(name) in named else node
        case _:
            return node


def _root(name: str) -> str:
    return name.partition(".")[0]
