"""Makes the nodes of rules and their successors: one function per alias of `grammar.lark`.

Each takes the members of a production and its range in the item, and gives back a node, or a list
that is still growing. Expressions and declarations have files of their own; `parse` gathers all.
Nothing here looks at names or types.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ipmlang.compiler import ast
from ipmlang.compiler.ast import Span
from ipmlang.compiler.automaton import Members
from ipmlang.compiler.build_expressions import UnbuildableError, unquote


def build_list_empty(members: Members, start: int, end: int) -> list[Any]:
    return []


def build_list_none(members: Members, start: int, end: int) -> list[Any]:
    return []


def build_list_first(members: Members, start: int, end: int) -> list[Any]:
    return [members[0]]


def build_list_next(members: Members, start: int, end: int) -> list[Any]:
    """The list so far and one more, with or without a separator between them."""
    members[0].append(members[-1])
    return members[0]  # type: ignore[no-any-return]


def build_list_pair(members: Members, start: int, end: int) -> list[Any]:
    members[0].append((members[1], members[2], start, end))
    return members[0]  # type: ignore[no-any-return]


def build_second(members: Members, start: int, end: int) -> object:
    return members[1]


def build_option(members: Members, start: int, end: int) -> tuple[str, object, int, int]:
    """A word and what follows it, to be told apart by the word."""
    return members[0], members[1], start, end


def build_option_word(members: Members, start: int, end: int) -> tuple[str, object, int, int]:
    return members[0], True, start, end


def build_option_text(members: Members, start: int, end: int) -> tuple[str, object, int, int]:
    return members[0], unquote(members[1], end - len(members[1])), start, end


def build_option_sites(members: Members, start: int, end: int) -> tuple[str, object, int, int]:
    return members[0], tuple(members[2]), start, end


def build_option_values(members: Members, start: int, end: int) -> tuple[str, object, int, int]:
    return members[0], tuple(members[1]), start, end


# ------------------------------------------------------- elements of a successor


def build_body_empty(members: Members, start: int, end: int) -> tuple[ast.Element, ...]:
    return ()


def build_body(members: Members, start: int, end: int) -> tuple[ast.Element, ...]:
    return tuple(members[0])


def build_module(members: Members, start: int, end: int) -> ast.Module:
    args = tuple(members[1]) if len(members) > 1 else ()
    return ast.Module(members[0], args, Span(start, end))


def build_bracket(members: Members, start: int, end: int) -> ast.Bracket:
    return ast.Bracket(members[1], Span(start, end))


def build_count(members: Members, start: int, end: int) -> ast.Count:
    return ast.Count(members[0], members[2], Span(start, end))


def build_rows(members: Members, start: int, end: int) -> ast.Rows:
    return ast.Rows(members[0], members[2], span=Span(start, end))


def build_places(members: Members, start: int, end: int) -> ast.Rows:
    return ast.Rows("at", members[1], True, Span(start, end))


def build_repeat(members: Members, start: int, end: int) -> ast.Repeat:
    options = once(members[4])
    return ast.Repeat(
        head=members[2],
        body=members[6],
        holes=options.get("except", ()),
        steps=options.get("steps", ()),
        rows=options.get("with"),
        span=Span(start, end),
    )


def build_split(members: Members, start: int, end: int) -> ast.Split:
    return ast.Split(members[1], tuple(members[3]), span=Span(start, end))


def build_split_arguments(members: Members, start: int, end: int) -> ast.Split:
    return ast.Split(members[1], tuple(members[4]), tuple(members[2]), span=Span(start, end))


def build_split_part(members: Members, start: int, end: int) -> ast.SplitPart:
    return ast.SplitPart(members[0], members[2], span=Span(start, end))


def build_split_group(members: Members, start: int, end: int) -> ast.SplitGroup:
    return ast.SplitGroup(tuple(members[1]), members[3], span=Span(start, end))


def build_size_absolute(members: Members, start: int, end: int) -> ast.Size:
    return ast.Size("absolute", members[0], Span(start, end))


def build_size_floating(members: Members, start: int, end: int) -> ast.Size:
    return ast.Size("floating", members[1], Span(start, end))


def build_size_relative(members: Members, start: int, end: int) -> ast.Size:
    return ast.Size("relative", members[1], Span(start, end))


def build_part(members: Members, start: int, end: int) -> ast.Part:
    return ast.Part(None, tuple(members[0]), span=Span(start, end))


def build_part_label(members: Members, start: int, end: int) -> ast.Part:
    return ast.Part(members[0], members[2], span=Span(start, end))


def build_block(members: Members, start: int, end: int) -> ast.Block:
    return ast.Block(members[0], (), tuple(members[2]), span=Span(start, end))


def build_block_arguments(members: Members, start: int, end: int) -> ast.Block:
    return ast.Block(members[0], tuple(members[1]), tuple(members[3]), span=Span(start, end))


def build_each(members: Members, start: int, end: int) -> ast.Each:
    return ast.Each(members[0], members[2], tuple(members[4]), span=Span(start, end))


def build_assign(members: Members, start: int, end: int) -> ast.Assign:
    return ast.Assign(members[1], members[3], span=Span(start, end))


def build_assign_closed(members: Members, start: int, end: int) -> ast.Assign:
    return ast.Assign(members[2], members[4], span=Span(start, end))


def build_local(members: Members, start: int, end: int) -> ast.Local:
    return ast.Local(members[1], members[3], span=Span(start, end))


def build_local_closed(members: Members, start: int, end: int) -> ast.Local:
    return ast.Local(members[2], members[4], span=Span(start, end))


# ------------------------------------------------------------------------ rules


def build_parameter(members: Members, start: int, end: int) -> ast.Parameter:
    return ast.Parameter(members[0], Span(start, end))


def build_parameters_none(members: Members, start: int, end: int) -> tuple[ast.Parameter, ...]:
    return ()


def build_parameters(members: Members, start: int, end: int) -> tuple[ast.Parameter, ...]:
    return tuple(members[1])


def build_context_module(members: Members, start: int, end: int) -> ast.ContextModule:
    parameters = members[1] if len(members) > 1 else ()
    return ast.ContextModule(members[0], parameters, Span(start, end))


def build_context_branch(members: Members, start: int, end: int) -> ast.ContextBranch:
    return ast.ContextBranch(tuple(members[1]), Span(start, end))


def build_context(members: Members, start: int, end: int) -> ast.Context:
    return ast.Context(tuple(members[0]), Span(start, end))


def _head(
    center: ast.ContextModule,
    left: ast.Context | None,
    right: ast.Context | None,
    span: Span,
) -> ast.Head:
    return ast.Head(center.name, center.parameters, left, right, span)


def build_head(members: Members, start: int, end: int) -> ast.Head:
    return _head(members[0], None, None, Span(start, end))


def build_head_left(members: Members, start: int, end: int) -> ast.Head:
    return _head(members[2], members[0], None, Span(start, end))


def build_head_right(members: Members, start: int, end: int) -> ast.Head:
    return _head(members[0], None, members[2], Span(start, end))


def build_head_both(members: Members, start: int, end: int) -> ast.Head:
    return _head(members[2], members[0], members[4], Span(start, end))


def build_chance_percent(members: Members, start: int, end: int) -> ast.Chance:
    return ast.Chance("percent", members[0], Span(start, end))


def build_chance_weight(members: Members, start: int, end: int) -> ast.Chance:
    return ast.Chance("weight", members[1], Span(start, end))


def build_production(members: Members, start: int, end: int) -> ast.Rule:
    return ast.Rule(members[0], members[2], span=Span(start, end))


def build_production_else(members: Members, start: int, end: int) -> ast.Rule:
    return ast.Rule(members[0], members[4], members[2], span=Span(start, end))


def build_otherwise(members: Members, start: int, end: int) -> ast.Otherwise:
    return ast.Otherwise(Span(start, end))


def build_production_guard(members: Members, start: int, end: int) -> ast.Rule:
    return ast.Rule(members[0], members[4], members[2], span=Span(start, end))


def build_production_chance(members: Members, start: int, end: int) -> ast.Rule:
    return ast.Rule(members[0], members[4], None, members[2], span=Span(start, end))


def build_production_both(members: Members, start: int, end: int) -> ast.Rule:
    return ast.Rule(members[0], members[6], members[2], members[4], span=Span(start, end))


def build_docs_first(members: Members, start: int, end: int) -> str:
    return unquote(members[0], start)


def build_docs_next(members: Members, start: int, end: int) -> str:
    return f"{members[0]}\n{unquote(members[1], end - len(members[1]))}"


def build_rule(members: Members, start: int, end: int) -> ast.Rule:
    rule: ast.Rule = members[0]
    return rule


def build_rule_interpret(members: Members, start: int, end: int) -> ast.Rule:
    rule: ast.Rule = members[1]
    return replace(rule, interpret=True, span=Span(start, end))


def build_rule_docs(members: Members, start: int, end: int) -> ast.Rule:
    rule: ast.Rule = members[1]
    return replace(rule, doc=members[0], span=Span(start, end))


def build_rule_docs_interpret(members: Members, start: int, end: int) -> ast.Rule:
    rule: ast.Rule = members[2]
    return replace(rule, interpret=True, doc=members[0], span=Span(start, end))


# ------------------------------------------------------------------------ options


def once(options: list[tuple[str, Any, int, int]]) -> dict[str, Any]:
    """Options by their words; a word may stand once."""
    found: dict[str, Any] = {}
    for word, value, start, end in options:
        if word in found:
            raise UnbuildableError("repeated-word", f"`{word}` stands here twice", start, end)
        found[word] = value
    return found
