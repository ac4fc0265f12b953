"""Making a grammar that shows a fault small: `shrink(text, shows)` drops what the fault can do
without.

In go a text and the question whether a text still shows the fault (one that does not compile shows
none); out comes a text from which nothing more can be dropped: no line, no bracketed or braced
part, no element, no run of words. The result is for a person to read; nothing is written.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from ipmlang.compiler.diagnostics import IpmError

WORD = re.compile(r'"[^"\n]*"|-->|[<>=!]=|\.\.|\w+(?:\.\w+)*|\S')
CLOSING = {"[": "]", "{": "}", "(": ")"}
Tokens = list[str]


def shrink(text: str, shows: Callable[[str], bool], tries: int = 4000) -> str:
    """The text with as little left as still shows the fault."""
    lines = [WORD.findall(line) for line in text.splitlines() if line.strip()]
    left = [tries]

    def holds(candidate: list[Tokens]) -> bool:
        left[0] -= 1
        try:
            return left[0] > 0 and shows(_text(candidate))
        except IpmError:
            return False

    before: list[Tokens] = []
    while before != lines and left[0] > 0:
        before = [list(line) for line in lines]
        for number in range(len(lines) - 1, 0, -1):
            without = [*lines[:number], *lines[number + 1 :]]
            if holds(without):
                lines = without
        for number in range(len(lines) - 1, 0, -1):
            lines = _line(lines, number, holds)
    return _text(lines)


def _line(lines: list[Tokens], number: int, holds: Callable[[list[Tokens]], bool]) -> list[Tokens]:
    """The same with less in one line."""
    again = True
    while again:
        again = False
        for smaller in _smaller(lines[number]):
            candidate = [*lines[:number], smaller, *lines[number + 1 :]]
            if holds(candidate):
                lines, again = candidate, True
                break
    return lines


def _smaller(tokens: Tokens) -> Iterator[Tokens]:
    """A line with a part left out, large parts first; what is in brackets may stay without them."""
    ends = _ends(tokens)
    parts = sorted(ends.items(), key=lambda each: each[0] - each[1])
    for first, last in parts:
        yield tokens[:first] + tokens[last + 1 :]
        yield tokens[:first] + tokens[first + 1 : last] + tokens[last + 1 :]
        yield [*tokens[:first], "1", *tokens[last + 1 :]]
        if first:
            yield tokens[: first - 1] + tokens[last + 1 :]
            yield [*tokens[: first - 1], "1", *tokens[last + 1 :]]
    for size in (8, 4, 3, 2, 1):
        for first in range(len(tokens) - size + 1):
            yield tokens[:first] + tokens[first + size :]
    for place, token in enumerate(tokens):
        if re.fullmatch(r"[\d.]+", token) and token != "1":
            yield [*tokens[:place], "1", *tokens[place + 1 :]]


def _ends(tokens: Tokens) -> dict[int, int]:
    """Where what opens at a token closes."""
    found, waiting = {}, []
    for place, token in enumerate(tokens):
        if token in CLOSING:
            waiting.append(place)
        elif waiting and token == CLOSING[tokens[waiting[-1]]]:
            found[waiting.pop()] = place
    return found


def _text(lines: list[Tokens]) -> str:
    return "\n".join([*(" ".join(line) for line in lines), ""])
