"""Puts terminals of `grammar.lark` into the words of those who write grammars.

In come the terminals that could stand at some place, out goes `a value, `,` or `)``: what can begin
the same thing is said once, by that thing's name.
"""

from __future__ import annotations

BRACKETS = {
    "LPAR": "(", "RPAR": ")", "LSQB": "[", "RSQB": "]", "LBRACE": "{", "RBRACE": "}",
}  # fmt: skip
ITEM_WORDS = frozenset(
    (
        *("ipm", "import", "style", "asset", "table", "surface", "context", "attr", "const", "fn"),
        *("turtle", "limit", "tropism", "ignore", "canvas", "axes", "residual", "site", "start"),
        "interpret",
    )
)
OPERATORS = frozenset(
    (
        *("PLUS", "MINUS", "STAR", "SLASH", "AND", "OR"),
        *("LESS", "LESS_EQUAL", "MORE", "MORE_EQUAL", "EQUALS", "DIFFERS"),
    )
)
MARKS = frozenset(
    (
        *("PLUS", "MINUS", "STAR", "SLASH", "AMPERSAND"),
        *("CARET", "BACKSLASH", "DOLLAR", "BANG"),
    )
)
SHAPES = MARKS | {"NAME", "LSQB", "REPEAT", "SPLIT", "SET", "WITH"}
# What can begin several things, by the members that give it away and those it brings along.
GROUPS = (
    (
        frozenset(("IMPORT", "ATTR", "START")),
        frozenset(word.upper() for word in ITEM_WORDS) | MARKS | {"NAME", "LSQB", "STRING"},
        "an item: a rule, or a word such as `attr` or `start`",
    ),
    (
        frozenset(("NUMBER", "NOT", "REPEAT")),
        SHAPES | {"NUMBER", "STRING", "NOT", "LPAR"},
        "a label, a shape or operation",
    ),
    (
        frozenset(("REPEAT", "SPLIT", "SET")),
        SHAPES,
        "a shape or operation",
    ),
    (
        frozenset(("NUMBER", "TRUE", "NAME", "LPAR")),
        frozenset(("NUMBER", "TRUE", "FALSE", "NAME", "LPAR", "MINUS", "STRING", "NOT", "IF")),
        "a value",
    ),
    (frozenset(("DOLLAR", "BANG", "NAME")), MARKS | {"NAME", "LSQB"}, "a symbol"),
    (frozenset(("STAR", "SLASH", "PLUS")), OPERATORS, "an operator"),
)
NAMED = {
    "NAME": "a name",
    "NUMBER": "a number",
    "STRING": "a string",
    "$END": "the end of the item",
    "AT_EACH": "`at each`",
    "ARROW": "`-->`",
    "DOTS": "`..`",
    "COLON": "`:`",
    "COMMA": "`,`",
    "BAR": "`|`",
    "EQUAL": "`=`",
    "LESS": "`<`",
    "MORE": "`>`",
    "PERCENT": "`%`",
    "TILDE": "`~`",
    "QUOTE": "`'`",
    "STAR": "`*`",
    "PLUS": "`+`",
    "MINUS": "`-`",
    **{terminal: f"`{mark}`" for terminal, mark in BRACKETS.items()},
}


def words(terminals: frozenset[str]) -> str | None:
    """Terminals in words: `a value, "," or ")"`; nothing for none."""
    left = set(terminals) - {"LITERALS"}
    said = []
    for signs, members, name in GROUPS:
        if signs <= left:
            said.append(name)
            left -= members
    if "NAME" in left and any(each.isalpha() and each not in NAMED for each in left):
        left.discard("NAME")
        said.append("a name")
    said += sorted(NAMED.get(each, f"`{each.lower()}`") for each in left)
    if len(said) < 2:
        return said[0] if said else None
    return f"{', '.join(said[:-1])} or {said[-1]}"
