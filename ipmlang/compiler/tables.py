"""Turns `grammar.lark` into the parse tables that ship with the package.

Lark reads the grammar and computes the LALR(1) automaton; what comes out here is that automaton in
numbers, with canonical numbering, as JSON. `python -m ipmlang.compiler.tables` writes it to
`grammar.tables`; a test writes it again and compares. Nothing at run time imports this file or
Lark: reading the numbers takes milliseconds, building them a second.
"""

from __future__ import annotations

import json
import re
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lark import Lark
    from lark.grammar import Rule, Symbol
    from lark.lexer import TerminalDef

GRAMMAR = Path(__file__).parent.parent / "grammar.lark"
TABLES = Path(__file__).with_name("grammar.tables")
END = "$END"
END_PATTERN = r"(\Z)"
ANY_PATTERN = "(.)"


def generate() -> str:
    """The text of `grammar.tables` for the grammar as it is now."""
    from lark import Lark

    parser = Lark(
        GRAMMAR.read_text(encoding="utf-8"),
        parser="lalr",
        start="item",
        maybe_placeholders=False,
        keep_all_tokens=True,
    )
    terminals, pattern, keywords = _lexicon(parser)
    rules = sorted(parser.rules, key=_rule_text)
    productions = [[rule.origin.name, len(rule.expansion), _builder(rule)] for rule in rules]
    actions, gotos = _automaton(parser, rules, {name: i for i, name in enumerate(terminals)})
    sections = {
        "terminals": json.dumps(terminals),
        "pattern": json.dumps(pattern),
        "keywords": json.dumps(keywords),
        "productions": _lines(productions),
        "actions": _lines(actions),
        "gotos": _lines(gotos),
    }
    return "{\n" + ",\n".join(f'"{key}": {text}' for key, text in sections.items()) + "\n}\n"


def _lines(rows: list[list[object]] | list[list[int]] | list[dict[str, int]]) -> str:
    return "[\n" + ",\n".join(json.dumps(row, separators=(",", ":")) for row in rows) + "\n]"


def _rule_text(rule: Rule) -> str:
    return f"{rule.origin.name}: " + " ".join(symbol.name for symbol in rule.expansion)


def _builder(rule: Rule) -> str:
    """The name of the function that makes the node; empty where one member is handed on."""
    if rule.alias is None and len(rule.expansion) != 1:
        raise ValueError(f"`{_rule_text(rule)}` needs an alias: it has no single member")
    return rule.alias or ""


def _lexicon(parser: Lark) -> tuple[list[str], str, dict[str, int]]:
    """Terminals in the order of the groups of one master pattern, that pattern, and the number of
    each keyword. Group 0 is a whole match, so number 0 stays without a terminal.
    """
    definitions = {each.name: each for each in parser.terminals}
    names = {name for name in definitions if not name.startswith("__IGNORE")}
    name_pattern = re.compile(definitions["NAME"].pattern.to_regexp())
    keywords = sorted(
        name
        for name in names
        if definitions[name].pattern.type == "str"
        and name_pattern.fullmatch(definitions[name].pattern.value)
    )
    marks = sorted(
        (
            name
            for name in names
            if definitions[name].pattern.type == "str" and name not in keywords
        ),
        key=lambda name: (-len(definitions[name].pattern.value), name),
    )
    patterns = sorted(names.difference(keywords, marks), key=lambda name: _order(definitions[name]))
    ordered = [*patterns, *marks]
    blank = next(each for name, each in definitions.items() if name.startswith("__IGNORE"))
    groups = [f"({definitions[name].pattern.to_regexp()})" for name in ordered]
    master = f"(?:{blank.pattern.value})?(?:{'|'.join([*groups, END_PATTERN, ANY_PATTERN])})"
    terminals = ["", *ordered, END, "UNKNOWN", *keywords]
    numbers = {definitions[name].pattern.value: terminals.index(name) for name in keywords}
    return terminals, master, numbers


def _order(terminal: TerminalDef) -> tuple[int, str]:
    return (-terminal.priority, terminal.name)


def _automaton(
    parser: Lark, rules: list[Rule], numbers: Mapping[str, int]
) -> tuple[list[list[int]], list[dict[str, int]]]:
    """Per state, its actions as pairs (terminal, action) and its gotos by rule name. An action of
    0 or more is the state to go to, below 0 it is -1 - production; to accept is to go to state 0,
    which nothing else enters.
    """
    table = parser.parser.parser._parse_table
    rule_numbers = {rule: i for i, rule in enumerate(rules)}
    order = _canonical(table.states, table.start_states["item"])
    final = table.end_states["item"]
    actions, gotos = [], []
    for state in order:
        row: dict[int, int] = {}
        goto: dict[str, int] = {}
        for symbol, (kind, target) in sorted(table.states[state].items()):
            if str(kind) == "Reduce":
                row[numbers[symbol]] = -1 - rule_numbers[target]
            elif symbol not in numbers:
                goto[symbol] = order[target]
            else:
                row[numbers[symbol]] = order[target]
        if state == final:
            row[numbers[END]] = 0
        actions.append([number for pair in sorted(row.items()) for number in pair])
        gotos.append(goto)
    return actions, gotos


def _canonical(
    states: Mapping[Symbol, Mapping[str, tuple[object, Symbol]]], first: Symbol
) -> dict[Symbol, int]:
    """Numbers for the states: breadth first by the names of the symbols, so that they do not hang
    on the order of any set inside Lark.
    """
    order = {first: 0}
    waiting = deque([first])
    while waiting:
        row = states[waiting.popleft()]
        for _, (kind, target) in sorted(row.items(), key=lambda pair: pair[0]):
            if str(kind) != "Reduce" and target not in order:
                order[target] = len(order)
                waiting.append(target)
    return order


if __name__ == "__main__":
    TABLES.write_text(generate(), encoding="utf-8")
