"""Reads the text of one top-level item with the parse tables, and hands back what it builds.

An LALR(1) automaton with one pattern as its lexer: a word is a keyword only where the state can
take it there. Nodes are built as productions complete, chains of single-member productions are
gone through in one look-up, and the time is linear in the text. It knows nothing of the language
but its tables and the functions it is given; trouble leaves it as an error, never as recursion.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

# What the members of a production have been built to: nodes, lists of nodes, texts of tokens.
Members: TypeAlias = "list[Any]"
Builder: TypeAlias = Callable[[Members, int, int], object]

TABLES = Path(__file__).with_name("grammar.tables")


@dataclass(frozen=True, slots=True)
class Token:
    """One lexical token; `terminal` is its name in grammar.lark."""

    terminal: str
    text: str
    start: int
    end: int


@dataclass(frozen=True, slots=True)
class Automaton:
    """The tables. `actions[state]` maps a terminal's number to the state to go to (0 accepts) or to
    -1 - production; `productions` are (rule, length, builder), without builder when the single
    member is handed on; `chains` remembers what single-member productions lead to.
    """

    terminals: tuple[str, ...]
    scan: re.Pattern[str]
    keywords: Mapping[str, int]
    productions: tuple[tuple[str, int, Builder | None], ...]
    actions: tuple[dict[int, int], ...]
    gotos: tuple[dict[str, int], ...]
    chains: dict[tuple[int, str, int], int]


@dataclass(slots=True)
class RefusedError(Exception):
    """The item ends here: `token` cannot stand after what was read.

    `expected` are the terminals that could, `before` the tokens up to it, last one first.
    """

    token: Token
    expected: frozenset[str]
    before: tuple[Token, ...]


@dataclass(slots=True)
class TooDeepError(Exception):
    """The item nests deeper than the stack of the automaton is allowed to grow."""

    start: int
    end: int


MAX_STACK = 300


def load(builders: Mapping[str, Builder]) -> Automaton:
    """The automaton of the shipped tables, with the functions that build."""
    data = json.loads(TABLES.read_text(encoding="utf-8"))
    return Automaton(
        terminals=tuple(data["terminals"]),
        scan=re.compile(data["pattern"], re.DOTALL),
        keywords=data["keywords"],
        productions=tuple(
            (rule, length, builders[name] if name else None)
            for rule, length, name in data["productions"]
        ),
        actions=tuple(dict(zip(row[::2], row[1::2], strict=True)) for row in data["actions"]),
        gotos=tuple(data["gotos"]),
        chains={},
    )


def run(machine: Automaton, text: str, comments: list[tuple[int, int]]) -> object:
    """What `text`, one whole item, is built to. Ranges of comments are added to `comments`."""
    terminals, actions, productions = machine.terminals, machine.actions, machine.productions
    chains, keywords = machine.chains, machine.keywords
    comment, name = terminals.index("COMMENT"), terminals.index("NAME")
    states, starts, last = [0], [0], 0
    values: Members = [None]
    row = actions[0]
    for match in machine.scan.finditer(text):
        kind = match.lastindex or 0
        start, end = match.span(kind)
        if kind == comment:
            comments.append((start, end))
            continue
        value = match[kind]
        if kind == name:
            kind = keywords.get(value, name)
        while True:
            action = row.get(kind)
            if action is None:
                action = row.get(name) if value in keywords else None
                if action is None:
                    raise _refusal(machine, match, text)
            if action > 0:
                states.append(action)
                values.append(value)
                starts.append(start)
                row = actions[action]
                last = end
                break
            if action == 0:
                return values[-1]
            rule, length, build = productions[-1 - action]
            if build is None:
                del states[-1]
            elif length:
                begin = starts[-length]
                built = build(values[-length:], begin, last)
                del states[-length:], values[-length:], starts[-length:]
                values.append(built)
                starts.append(begin)
            else:
                values.append(build([], last, last))
                starts.append(last)
            below = states[-1]
            state = chains.get((below, rule, kind))
            if state is None:
                state = _chain(machine, below, rule, kind)
            states.append(state)
            row = actions[state]
        if len(states) > MAX_STACK:
            raise TooDeepError(start, end)
    raise AssertionError("the pattern matches the end of every text")


def _chain(machine: Automaton, below: int, rule: str, kind: int) -> int:
    """The state after `rule` on top of `below`, gone on through single-member productions."""
    name = machine.terminals.index("NAME")
    is_keyword = kind in machine.keywords.values()
    start = rule
    while True:
        state = machine.gotos[below][rule]
        row = machine.actions[state]
        action = row.get(kind, row.get(name) if is_keyword else None)
        if action is None or action >= 0 or machine.productions[-1 - action][2] is not None:
            machine.chains[below, start, kind] = state
            return state
        rule = machine.productions[-1 - action][0]


def _refusal(machine: Automaton, match: re.Match[str], text: str) -> RefusedError:
    """The error at the token of `match`, with all that could stand in its place."""
    number = match.lastindex or 0
    before = tokens(machine, text[: match.start(number)])
    terminal = machine.terminals[machine.keywords.get(match[number], number)]
    token = Token(terminal, match[number], *match.span(number))
    states = _states_after(machine, before)
    expected = frozenset(
        terminal
        for kind, terminal in enumerate(machine.terminals)
        if kind in machine.actions[states[-1]] and _after(machine, states, kind) is not None
    )
    return RefusedError(token, expected, tuple(reversed(before)))


def _states_after(machine: Automaton, before: list[Token]) -> list[int]:
    """The states when the last token was taken in, and nothing was reduced for the next one: a
    token that is refused may have led to reductions that others would not.
    """
    states = [0]
    for token in before:
        kind = machine.terminals.index(token.terminal)
        after = _after(machine, states, kind)
        states = after or _after(machine, states, machine.terminals.index("NAME")) or states
    return states


def _after(machine: Automaton, states: list[int], kind: int) -> list[int] | None:
    """The states when a terminal was taken in, or None: reductions in a merged state may promise
    too much.
    """
    stack = list(states)
    while True:
        action = machine.actions[stack[-1]].get(kind)
        if action is None:
            return None
        if action >= 0:
            return [*stack, action]
        rule, length, _ = machine.productions[-1 - action]
        if length:
            del stack[-length:]
        stack.append(machine.gotos[stack[-1]][rule])


def tokens(machine: Automaton, text: str) -> list[Token]:
    """All tokens of a text but its comments; keywords bear the name of their own terminal."""
    found = []
    for match in machine.scan.finditer(text):
        kind = match.lastindex or 0
        terminal = machine.terminals[kind]
        if terminal == "NAME":
            terminal = machine.terminals[machine.keywords.get(match[kind], kind)]
        if terminal not in ("COMMENT", "$END"):
            found.append(Token(terminal, match[kind], *match.span(kind)))
        elif terminal == "$END":
            break
    return found


@cache
def lexicon() -> Automaton:
    """The tables alone, for those who only ask for tokens."""
    data = json.loads(TABLES.read_text(encoding="utf-8"))
    return load({name: _nothing for _, _, name in data["productions"] if name})


def _nothing(members: Members, start: int, end: int) -> object:
    return None
