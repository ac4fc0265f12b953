"""Counts the lexical tokens of a grammar, the size that inference makes smaller, and knows which
words are free to be names.

A token is a name, a number, a string, an operator or mark, or one bracket; commas, comments and
layout do not count. `-5` is two tokens.
"""

from __future__ import annotations

import re

from ipmlang.compiler import ast
from ipmlang.compiler.automaton import lexicon

# Comments come first and are taken away; the rest follows the terminals of grammar.lark.
_COMMENT = re.compile(r'("(?:[^"\\\n]|\\[^\n])*")|//[^\n]*+')
_TOKEN = re.compile(
    r'"(?:[^"\\\n]|\\[^\n])*"'
    r"|[^\W\d]\w*+(?:\.[^\W\d]\w*+)*"
    r"|[0-9]++(?:\.[0-9]++)?(?:[eE][+-]?[0-9]++)?"
    r"|-->|\.\.|[<>=!]=|[^\s,]"
)
_NAME = re.compile(r"[^\W\d]\w*(?:\.[^\W\d]\w*)*")


def count_tokens(grammar: ast.Grammar) -> int:
    """How many tokens the text of a grammar has.

    >>> from ipmlang.compiler.diagnostics import Source
    >>> from ipmlang.compiler.parse import parse
    >>> count_tokens(parse(Source("<text>", "A --> F(1, 2) [B] // and so on"))[0])
    10
    """
    from ipmlang.compiler.format import format_grammar

    return count_text_tokens(format_grammar(grammar))


def count_text_tokens(text: str) -> int:
    """The same for a text that need not be a whole grammar."""
    if "//" in text:
        text = _COMMENT.sub(lambda match: match[1] or "", text)
    return len(_TOKEN.findall(text))


def reserved_words() -> frozenset[str]:
    """The words that are keywords somewhere: never wrong to avoid them as names."""
    return frozenset(lexicon().keywords) | {"at"}


def is_free_name(text: str) -> bool:
    """Whether a text can be the name of a symbol, an attribute or a column wherever it stands."""
    return _NAME.fullmatch(text) is not None and text not in reserved_words()
