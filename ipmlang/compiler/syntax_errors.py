"""Says in the user's words what is wrong with the syntax of an item.

In comes what the automaton refused: the token, what came before it and what could have stood there;
out goes one `Trouble`, with places relative to the item. Common mistakes are known by name; all others say what
was expected.
"""

from __future__ import annotations

from dataclasses import dataclass

from ipmlang.compiler.automaton import Refused, Token

OPENERS = {"LPAR": "RPAR", "LSQB": "RSQB", "LBRACE": "RBRACE"}
BRACKETS = {
    "LPAR": "(", "RPAR": ")", "LSQB": "[", "RSQB": "]", "LBRACE": "{", "RBRACE": "}",
}  # fmt: skip
ITEM_WORDS = frozenset(
    "import asset table surface context attr const fn turtle limit tropism ignore canvas axes "
    "site start interpret ipm".split()
)
OPERATORS = frozenset(
    "PLUS MINUS STAR SLASH LESS LESS_EQUAL MORE MORE_EQUAL EQUALS DIFFERS AND OR".split()
)
MARKS = frozenset("PLUS MINUS STAR SLASH AMPERSAND CARET BACKSLASH DOLLAR BANG".split())
# What can begin several things, by the members that give it away and those it brings along.
GROUPS = (
    (
        frozenset(("IMPORT", "ATTR", "START")),
        frozenset(word.upper() for word in ITEM_WORDS) | MARKS | {"NAME", "LSQB", "STRING"},
        "an item: a rule, or a word such as `attr` or `start`",
    ),
    (
        frozenset(("REPEAT", "SPLIT", "SET")),
        MARKS | {"NAME", "LSQB", "REPEAT", "SPLIT", "SET"},
        "a shape or operation",
    ),
    (
        frozenset(("NUMBER", "TRUE", "NAME", "LPAR")),
        frozenset(("NUMBER", "TRUE", "FALSE", "NAME", "LPAR", "MINUS", "STRING", "NOT", "IF")),
        "a value",
    ),
    (frozenset(("STAR", "SLASH", "PLUS")), OPERATORS, "an operator"),
    (frozenset(("DOLLAR", "BANG", "NAME")), MARKS | {"NAME", "LSQB"}, "a symbol"),
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


@dataclass(frozen=True, slots=True)
class Trouble:
    """A diagnostic of one item; places are relative to the item's text."""

    code: str
    message: str
    start: int
    end: int
    expected: str | None = None
    hint: str | None = None


def explain(refused: Refused, text: str) -> Trouble:
    """What is wrong, by the first of the known mistakes that fits, else by what was expected."""
    for mistake in (
        _unknown_character,
        _bad_number,
        _foreign_operator,
        _indented_item,
        _reserved_word,
        _unmatched,
        _missing_arrow,
    ):
        trouble = mistake(refused, text)
        if trouble is not None:
            return trouble
    token = refused.token
    if token.terminal == "$END":
        return _at_end("unexpected-end", "the item ends too early", refused, text)
    what = "this string" if token.terminal == "STRING" else f"`{token.text}`"
    return Trouble(
        "unexpected-token",
        f"{what} cannot stand here",
        token.start,
        token.end,
        words(refused.expected),
        _word_hint(refused),
    )


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


def _at_end(code: str, message: str, refused: Refused, text: str) -> Trouble:
    """Trouble where the item ends: its last character is marked."""
    last = refused.before[0].end if refused.before else len(text)
    return Trouble(code, message, max(0, last - 1), last, words(refused.expected))


# --------------------------------------------------------------- known mistakes


def _unknown_character(refused: Refused, text: str) -> Trouble | None:
    token = refused.token
    if token.terminal != "UNKNOWN":
        return None
    if token.text == '"':
        line = text.find("\n", token.start)
        end = len(text) if line < 0 else line
        hint = 'a string ends on its own line; a quote inside it is written `\\"`'
        return Trouble(
            "unclosed-string", "this string has no closing quote", token.start, end, None, hint
        )
    if token.text == ".":
        return _point(refused, text)
    printed = token.text if token.text.isprintable() else f"U+{ord(token.text):04X}"
    return Trouble(
        "unexpected-character",
        f"`{printed}` means nothing here",
        token.start,
        token.end,
        words(refused.expected),
        _CHARACTER_HINTS.get(token.text),
    )


_CHARACTER_HINTS = {
    ";": "an item ends with its line: leave the `;` out",
    "#": 'a comment starts with `//`; a colour is a string: "#d9694a"',
    "→": "the arrow of a rule is written `-->`",
    "…": "write out what `…` stands for",
    "“": 'strings stand in straight quotes: "…"',
    "”": 'strings stand in straight quotes: "…"',
    "×": "times is written `*`",
    "−": "minus is written `-`",
    "°": "angles are in degrees: leave the `°` out",
    "\x00": "this is not a text file, or it is damaged",
}


def _point(refused: Refused, text: str) -> Trouble:
    token = refused.token
    last = refused.before[0] if refused.before else None
    if last is not None and last.terminal == "NUMBER" and last.end == token.start:
        return Trouble(
            "bad-number",
            f"`{last.text}.` is not a number",
            last.start,
            token.end,
            None,
            "digits stand on both sides of one point: `1.0`",
        )
    if text[token.end : token.end + 1].isdigit():
        hint = "digits stand on both sides of the point: `0.5`"
        return Trouble(
            "bad-number", "a number starts with a digit", token.start, token.end, None, hint
        )
    hint = "`vertex` is the operation that adds a corner to a polygon"
    return Trouble(
        "unexpected-character", "`.` means nothing here", token.start, token.end, None, hint
    )


def _bad_number(refused: Refused, text: str) -> Trouble | None:
    token = refused.token
    last = refused.before[0] if refused.before else None
    if last is None or last.terminal != "NUMBER" or last.end != token.start:
        return None
    if not (token.text[:1].isalnum() or token.text[:1] == "_"):
        return None
    wrong = last.text + token.text
    return Trouble("bad-number", f"`{wrong}` is not a number", last.start, token.end, None, None)


# The last token, this one, and what was meant.
_FOREIGN = {
    ("MINUS", "MORE"): "the arrow of a rule is written `-->`",
    ("EQUAL", "MORE"): "the arrow of a rule is written `-->`; at least is `>=`",
    ("COLON", "EQUAL"): "the arrow of a rule is written `-->`",
    ("AMPERSAND", "AMPERSAND"): "write `and`",
    ("BAR", "BAR"): "write `or`",
    ("STAR", "STAR"): "a power is written `pow(a, b)`",
    ("LESS", "MORE"): "not equal is written `!=`",
}


def _foreign_operator(refused: Refused, text: str) -> Trouble | None:
    """An operator of another language, seen at its first character or its second."""
    token = refused.token
    previous = refused.before[0] if refused.before else None
    if previous is not None and previous.end == token.start:
        hint = _FOREIGN.get((previous.terminal, token.terminal))
        if hint is not None and previous.terminal != "AMPERSAND":
            return _foreign(previous.start, token.end, text, hint)
    after = text[token.end : token.end + 1]
    in_expression = "PLUS" in refused.expected and "SLASH" in refused.expected
    in_value = "NUMBER" in refused.expected and "NOT" in refused.expected
    if in_expression and token.terminal in ("AMPERSAND", "BAR") and after == token.text:
        hint = _FOREIGN[token.terminal, token.terminal]
        return _foreign(token.start, token.end + 1, text, hint)
    if token.terminal == "EQUAL" and previous is not None and in_expression:
        hint = "equal is written `==`"
        return _foreign(token.start, token.end, text, hint)
    if in_expression and token.terminal == "PERCENT":
        return _foreign(token.start, token.end, text, "a remainder is written `mod(a, b)`")
    if previous is not None and previous.terminal == "PERCENT" and token.terminal in OPERATORS | {
        "NUMBER", "NAME", "LPAR",
    }:  # fmt: skip
        hint = "a remainder is written `mod(a, b)`"
        return _foreign(previous.start, previous.end, text, hint)
    if in_expression and token.terminal == "CARET":
        return _foreign(token.start, token.end, text, "a power is written `pow(a, b)`")
    if in_value and token.terminal == "BANG":
        return _foreign(token.start, token.end, text, "write `not`")
    if token.terminal == "QUOTE" and in_value:
        hint = 'strings stand in double quotes: "…"'
        return _foreign(token.start, token.end, text, hint)
    return None


def _foreign(start: int, end: int, text: str, hint: str) -> Trouble:
    message = f"`{text[start:end]}` is no operator of this place"
    return Trouble("unknown-operator", message, start, end, None, hint)


def _indented_item(refused: Refused, text: str) -> Trouble | None:
    """A line that would be an item, if only it were not indented."""
    token = refused.token
    line = text.rfind("\n", 0, token.start) + 1
    first = next((each for each in reversed(refused.before) if each.start >= line), token)
    if first.start == line or not any(each.start < line for each in refused.before):
        return None
    second_arrow = token.terminal == "ARROW" and any(
        each.terminal == "ARROW" and each.start < line for each in refused.before
    )
    is_word = first.text in ITEM_WORDS and any(
        each.terminal in ("ARROW", "EQUAL") for each in refused.before if each.start < line
    )
    if not second_arrow and not is_word:
        return None
    end = text.find("\n", token.end)
    return Trouble(
        "item-not-in-first-column",
        "this looks like an item of its own, and is indented",
        first.start,
        len(text) if end < 0 else end,
        None,
        "every item starts in the first column; indented lines go on with the item above",
    )


def _reserved_word(refused: Refused, text: str) -> Trouble | None:
    """A rule for a symbol whose name begins another kind of item."""
    first = refused.before[-1] if refused.before else None
    if first is None or first.text not in ITEM_WORDS or len(refused.before) > 1:
        return None
    if refused.token.terminal not in ("ARROW", "COLON", "LPAR", "LESS", "MORE"):
        return None
    return Trouble(
        "reserved-word",
        f"`{first.text}` begins an item of its own and cannot be the name of a rule",
        first.start,
        first.end,
        None,
        f"another name will do: `{first.text.capitalize()}`",
    )


def _unmatched(refused: Refused, text: str) -> Trouble | None:
    """Brackets that do not pair."""
    opened: list[Token] = []
    for token in reversed(refused.before):
        if token.terminal in OPENERS:
            opened.append(token)
        elif token.terminal in OPENERS.values() and opened:
            opened.pop()
    token = refused.token
    if token.terminal == "$END" and opened:
        bracket = opened[-1]
        closer = BRACKETS[OPENERS[bracket.terminal]]
        message = f"this `{bracket.text}` is not closed"
        hint = f"the item ends without its `{closer}`"
        return Trouble("unclosed-bracket", message, bracket.start, bracket.end, None, hint)
    if token.terminal not in OPENERS.values():
        return None
    if not opened:
        message = f"this `{token.text}` closes nothing"
        return Trouble("stray-bracket", message, token.start, token.end)
    if OPENERS[opened[-1].terminal] == token.terminal:
        return None
    message = f"`{token.text}` stands where `{opened[-1].text}` is still open"
    closer = BRACKETS[OPENERS[opened[-1].terminal]]
    return Trouble("unclosed-bracket", message, token.start, token.end, f"`{closer}`")


def _missing_arrow(refused: Refused, text: str) -> Trouble | None:
    if "ARROW" not in refused.expected:
        return None
    message = "a rule needs `-->` between its head and its successor"
    if refused.token.terminal == "$END":
        return _at_end("missing-arrow", message, refused, text)
    token = refused.token
    return Trouble("missing-arrow", message, token.start, token.end, words(refused.expected))


def _word_hint(refused: Refused) -> str | None:
    """Where a word was taken for a keyword that may have been meant as a name."""
    last = refused.before[0] if refused.before else None
    if last is None or last.terminal == "NAME" or not last.text.isidentifier():
        return None
    return f"`{last.text}` is a word of the language here, not a name"
