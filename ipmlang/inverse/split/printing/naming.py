"""What a person would call the symbols of a scheme: by what they draw and how it stands.

Rules that bring a name keep it; others are called by their main part and its arrangement (TowerRow,
WindowGrid, Pair). Takes a scheme; gives a name for each symbol, none twice. Nothing is printed.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

import numpy as np

from ipmlang.inverse.frames import Floats, around
from ipmlang.inverse.naming import LONGEST, Names, capital
from ipmlang.inverse.parts.describing import place_word
from ipmlang.inverse.parts.naming import numbered
from ipmlang.inverse.split.changing import top_down
from ipmlang.inverse.split.expansion import placements
from ipmlang.inverse.split.scheme import (
    Array,
    Direction,
    Item,
    Octant,
    Place,
    Ring,
    Rule,
    Scheme,
    Split,
    Terminal,
)

_NAMELESS = re.compile(r"Part\d*")  # shapes for which neither the file nor their box has a word
WHOLE = ("Base", "Body", "Roof")  # places of what is as wide as all of it
UPWARD = 0.7  # share of a step that has to be up for a column


def symbol_names(
    scheme: Scheme, axiom: str, names: Names, unnamed: frozenset[int] = frozenset()
) -> tuple[str, ...]:
    """A name for every symbol; axiom: the wish for the last one; unnamed: rules that are not told
    by name, which are called by what they mainly draw.
    """
    wishes: list[str] = []
    shapes = [each.name for each in scheme.symbols if isinstance(each, Terminal)]
    # Some shapes of the file stand for others: what is left is numbered anew.
    terminals = iter(numbered([name.rstrip("0123456789") or name for name in shapes]))
    for number, symbol in enumerate(scheme.symbols):
        if isinstance(symbol, Terminal):
            wishes.append(next(terminals))
        elif number == scheme.axiom:
            wishes.append(axiom)
        else:
            wishes.append(symbol.name or rule_wish(scheme, symbol, wishes))
    given: dict[int, str] = {}
    for number in _order(scheme):
        if number not in unnamed:
            given[number] = names.give(wishes[number])
    for number in sorted(unnamed):
        rule = scheme.symbols[number]
        assert isinstance(rule, Rule)
        given[number] = given.get(_main(scheme, rule), wishes[number])
    return tuple(given[number] for number in range(len(wishes)))


def _order(scheme: Scheme) -> list[int]:
    """The terminals, whose names are ids; then the rules as they are printed, the axiom first."""
    terminals = [k for k, each in enumerate(scheme.symbols) if isinstance(each, Terminal)]
    rules = [k for k, each in enumerate(scheme.symbols) if isinstance(each, Rule)]
    return list(dict.fromkeys([*terminals, *top_down(scheme), *rules]))


def rule_wish(scheme: Scheme, rule: Rule, named: Sequence[str]) -> str:
    """A name for a rule that brings none, from the names of what it places."""
    drawn = [(symbol, len(frames)) for item in rule.items for symbol, frames in placements(item)]
    stem = capital(named[_main(scheme, rule)]) if drawn else "Empty"
    kind = _arrangement(rule.items) or _gathering(_shapes(scheme, rule))
    says_nothing = _NAMELESS.fullmatch(stem) is not None or len(stem + kind) > LONGEST
    return kind if says_nothing else stem + kind


def _main(scheme: Scheme, rule: Rule) -> int:
    """What takes most of the eye in a rule: a symbol that has a name of its own, and is the same
    in others like it.
    """
    drawn = [(symbol, len(frames)) for item in rule.items for symbol, frames in placements(item)]
    if not drawn:
        return scheme.axiom
    alike = [each for each in drawn if not _has_others(scheme, each[0])]
    main = max(alike or drawn, key=lambda each: _bulk(scheme, each[0]) * each[1])[0]
    inner = scheme.symbols[main]
    return main if isinstance(inner, Terminal) or inner.name else _main(scheme, inner)


def _has_others(scheme: Scheme, symbol: int) -> bool:
    """Whether a symbol is a shape that is there in other materials, too."""
    one = scheme.symbols[symbol]
    return isinstance(one, Terminal) and one.form >= 0


def part_words(scheme: Scheme, names: Sequence[str]) -> dict[str, str]:
    """What shapes that are there in several materials are in the rules that place them: a roof, by
    their names.
    """
    words: dict[str, str] = {}
    for rule in scheme.symbols:
        for item in rule.items if isinstance(rule, Rule) else ():
            for symbol, frames in placements(item):
                one = scheme.symbols[symbol]
                if isinstance(one, Terminal) and one.form >= 0:
                    low, high = around(frames[:1], one.low, one.low + one.size)
                    whole = np.stack([np.zeros(3), rule.size])
                    word = place_word(low[0], high[0], whole, "")
                    words.setdefault(names[symbol], word.lower() if word in WHOLE else "")
    return words


def _bulk(scheme: Scheme, symbol: int) -> float:
    """How much of the eye a symbol takes: the two longer sides of its box."""
    sides = np.sort(scheme.symbols[symbol].size)
    return float(sides[1] * sides[2])


def _shapes(scheme: Scheme, rule: Rule) -> Counter[int]:
    """How many of each shape a rule draws in all."""
    total: Counter[int] = Counter()
    for item in rule.items:
        for inner, frames in placements(item):
            symbol = scheme.symbols[inner]
            if isinstance(symbol, Terminal):
                total[inner] += len(frames)
            else:
                for shape, count in _shapes(scheme, symbol).items():
                    total[shape] += count * len(frames)
    return total


def _gathering(shapes: Counter[int]) -> str:
    """A word for so many of some shapes that stand in no order."""
    if shapes.total() == 2:
        return "Pair"
    return "Set" if len(shapes) == 1 else "Group"


def _arrangement(items: Sequence[Item]) -> str:
    """A word for what all stands in, empty for none."""
    if len(items) == 1:
        match items[0]:
            case Array(directions=(Direction(angle=angle),)) if angle:
                return "Ring"
            case Array(directions=directions):
                return _array_word([direction.step for direction in directions])
            case Ring(angle=0.0):
                return "Row"
            case Ring(rise=rise, grows=grows):
                return "Spiral" if rise or grows else "Ring"
            case Split(axis=axis):
                return ("Bays", "Layers", "Storeys")[axis]
            case Octant():
                return "Part"
            case Place():
                return ""
    return ""


def _array_word(steps: Sequence[Floats]) -> str:
    if len(steps) > 1:
        return "Grid" if len(steps) == 2 else "Block"
    length = float(np.linalg.norm(steps[0]))
    return "Column" if abs(float(steps[0][2])) > UPWARD * length else "Row"
