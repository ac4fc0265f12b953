"""Says in the user's words what is wrong with the syntax of an item.

In comes what the automaton refused: the token, what came before it and what could have stood there;
out goes one `Trouble`, with places relative to the item. Common mistakes are known by name; all
others say what was expected.
"""

from __future__ import annotations

from dataclasses import dataclass

from ipmlang.compiler.automaton import RefusedError, Token
from ipmlang.compiler.diagnostics import nearest
from ipmlang.compiler.expected import BRACKETS, ITEM_WORDS, words

COMPARISONS = ("LESS", "LESS_EQUAL", "MORE", "MORE_EQUAL", "EQUALS", "DIFFERS")
OPENERS = {"LPAR": "RPAR", "LSQB": "RSQB", "LBRACE": "RBRACE"}


@dataclass(frozen=True, slots=True)
class Trouble:
    """A diagnostic of one item; places are relative to the item's text."""

    code: str
    message: str
    start: int
    end: int
    expected: str | None = None
    hint: str | None = None


def explain(refused: RefusedError, text: str) -> Trouble:
    """What is wrong, by the first of the known mistakes that fits, else by what was expected."""
    for mistake in (
        _unknown_character,
        _bad_number,
        _indented_item,
        _foreign_operator,
        _reserved_word,
        _unmatched,
        _repeat_head,
        _parts,
        _unknown_item,
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


def _at_end(code: str, message: str, refused: RefusedError, text: str) -> Trouble:
    """Trouble where the item ends: its last character is marked."""
    last = refused.before[0].end if refused.before else len(text)
    return Trouble(code, message, max(0, last - 1), last, words(refused.expected))


# --------------------------------------------------------------- known mistakes


def _unknown_character(refused: RefusedError, text: str) -> Trouble | None:
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
    known = _CHARACTER_HINTS.get(token.text)
    expected = None if known is not None else words(refused.expected)
    message = f"`{printed}` means nothing here"
    return Trouble("unexpected-character", message, token.start, token.end, expected, known)


_CHARACTER_HINTS = {
    ";": "an item ends with its line: leave the `;` out",
    "#": 'a comment starts with `//`; a colour is a string: "#d9694a"',
    "?": "a choice is written `if a then b else c`",
    "→": "the arrow of a rule is written `-->`",
    "…": "write out what `…` stands for",
    "“": 'strings stand in straight quotes: "…"',
    "”": 'strings stand in straight quotes: "…"',
    "×": "times is written `*`",
    "−": "minus is written `-`",
    "°": "angles are in degrees: leave the `°` out",
    "\x00": "this is not a text file, or it is damaged",
}


def _point(refused: RefusedError, text: str) -> Trouble:
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


def _bad_number(refused: RefusedError, text: str) -> Trouble | None:
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
    (
        "COLON",
        "EQUAL",
    ): "a value is named with `const` or `attr`; the arrow of a rule is written `-->`",
    ("AMPERSAND", "AMPERSAND"): "write `and`",
    ("BAR", "BAR"): "write `or`",
    ("STAR", "STAR"): "a power is written `pow(a, b)`",
    ("LESS", "MORE"): "not equal is written `!=`",
    ("MINUS", "ARROW"): "the arrow of a rule is written `-->`",
}
_FOREIGN_IN_EXPRESSION = {
    "EQUAL": "equal is written `==`",
    "PERCENT": "a remainder is written `mod(a, b)`",
    "CARET": "a power is written `pow(a, b)`",
    "AMPERSAND": "write `and`",
}


def _foreign_operator(refused: RefusedError, text: str) -> Trouble | None:
    """An operator of another language, seen at its first character or its second."""
    token = refused.token
    previous = refused.before[0] if refused.before else None
    if previous is not None and previous.end == token.start:
        hint = _FOREIGN.get((previous.terminal, token.terminal))
        if hint is not None:
            return _foreign(previous.start, token.end, text, hint)
    in_expression = {"PLUS", "SLASH"} <= refused.expected and "DOLLAR" not in refused.expected
    if in_expression and text[token.end : token.end + 1] == token.text:
        hint = _FOREIGN.get((token.terminal, token.terminal))
        if hint is not None:
            return _foreign(token.start, token.end + 1, text, hint)
    if in_expression and token.terminal in _FOREIGN_IN_EXPRESSION:
        return _foreign(token.start, token.end, text, _FOREIGN_IN_EXPRESSION[token.terminal])
    if previous is not None and previous.terminal == "PERCENT" and token.terminal == "COLON":
        message = "nothing stands between a percentage and the arrow"
        hint = "the condition comes first: x > 3 : 30% -->"
        return Trouble("unexpected-token", message, token.start, token.end, "`-->`", hint)
    if previous is not None and previous.terminal == "PERCENT" and "ARROW" in refused.expected:
        hint = _FOREIGN_IN_EXPRESSION["PERCENT"]
        return _foreign(previous.start, previous.end, text, hint)
    if in_expression and token.terminal in COMPARISONS:
        message = "comparisons do not chain"
        hint = "write `a < b and b < c`"
        return Trouble("chained-comparison", message, token.start, token.end, None, hint)
    if token.terminal == "BANG" and {"NUMBER", "NOT"} <= refused.expected:
        return _foreign(token.start, token.end, text, "write `not`")
    if previous is not None and text.startswith("/*", refused.before[-1].start):
        hint = "a comment starts with `//`, and goes on to the end of its line"
        return _foreign(refused.before[-1].start, refused.before[-1].start + 2, text, hint)
    if token.terminal == "QUOTE":
        hint = 'strings stand in double quotes: "…"'
        return Trouble(
            "unexpected-token", "`'` cannot stand here", token.start, token.end, None, hint
        )
    return None


def _foreign(start: int, end: int, text: str, hint: str) -> Trouble:
    message = f"`{text[start:end]}` is no operator of this place"
    return Trouble("unknown-operator", message, start, end, None, hint)


def _indented_item(refused: RefusedError, text: str) -> Trouble | None:
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


def _reserved_word(refused: RefusedError, text: str) -> Trouble | None:
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


def _unmatched(refused: RefusedError, text: str) -> Trouble | None:
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


def _repeat_head(refused: RefusedError, text: str) -> Trouble | None:
    """A `repeat` without its counter."""
    token = refused.token
    if not refused.before or refused.before[0].terminal != "REPEAT":
        return None
    message = "`repeat` needs a counter or a table in brackets"
    hint = "the copies are numbered from 0: repeat(i < 3) { F }"
    expected = "`(i < count)` or `(row in table)`"
    return Trouble("missing-counter", message, token.start, token.end, expected, hint)


def _parts(refused: RefusedError, text: str) -> Trouble | None:
    """A part that is not there, or parts without a bar between them."""
    token = refused.token
    previous = refused.before[0] if refused.before else None
    if previous is None:
        return None
    if token.terminal in ("BAR", "RBRACE") and previous.terminal in ("BAR", "LBRACE"):
        message = "a part is missing here"
        hint = "what stays empty is written `nil`"
        return Trouble("empty-part", message, token.start, token.end, words(refused.expected), hint)
    if token.terminal == "COLON" and "BAR" in refused.expected:
        message = "a new part begins here, without a `|` before it"
        return Trouble("missing-bar", message, previous.start, token.end, "`|`")
    return None


def _unknown_item(refused: RefusedError, text: str) -> Trouble | None:
    """A misspelt first word, and documentation of what has none."""
    first = refused.before[-1] if refused.before else None
    second = refused.before[-2] if len(refused.before) > 1 else refused.token
    if first is None:
        return None
    if first.terminal == "STRING" and second.text in ITEM_WORDS:
        message = "a string on a line of its own documents a rule, and no rule is below"
        hint = "an attribute has its documentation behind it; anything else a comment"
        return Trouble("misplaced-doc", message, first.start, first.end, None, hint)
    if first.terminal != "NAME" or second.terminal != "NAME" or "-->" in text:
        return None
    close = nearest(first.text.lower(), ITEM_WORDS)
    if not close:
        return None
    message = f"no item starts with `{first.text}`"
    return Trouble(
        "unknown-item", message, first.start, first.end, None, f"did you mean `{close[0]}`?"
    )


def _missing_arrow(refused: RefusedError, text: str) -> Trouble | None:
    token = refused.token
    in_head = bool({"ARROW", "DOLLAR"} & refused.expected)
    first = next((each for each in reversed(refused.before) if each.terminal != "STRING"), token)
    if not in_head or first.text in ITEM_WORDS - {"interpret"} or "-->" in text:
        return None
    message = "a rule needs `-->` between its head and its successor"
    if token.terminal == "$END":
        return _at_end("missing-arrow", message, refused, text)
    hint = "a value is named with `const` or `attr`" if token.terminal == "EQUAL" else None
    return Trouble("missing-arrow", message, token.start, token.end, words(refused.expected), hint)


def _word_hint(refused: RefusedError) -> str | None:
    """A hint for a second arrow, or a keyword that may have been meant as a name."""
    last = refused.before[0] if refused.before else None
    if refused.token.terminal == "ARROW" and any(t.terminal == "ARROW" for t in refused.before):
        return "a rule has one `-->`"
    if last is None or last.terminal == "NAME" or not last.text.isidentifier():
        return None
    if len(refused.before) == 1:
        return None
    return f"`{last.text}` is a word of the language here, not a name"
