"""A scheme as a grammar: what `ipmlang infer` prints for buildings.

In goes a scheme, out come items of a syntax tree: tables, rules from the axiom down, the start.
Names and numbers are a person's; the formatter alone makes text of them. Nothing is searched here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.frames import Frames
from ipmlang.inverse.naming import Names
from ipmlang.inverse.split.changing import top_down
from ipmlang.inverse.split.measuring import in_cells, needing_size, reaches
from ipmlang.inverse.split.placing import Precision, spots, steps_to
from ipmlang.inverse.split.printing.inlining import inlined
from ipmlang.inverse.split.printing.items import Wording, copies_of, item_elements
from ipmlang.inverse.split.printing.lifting import lifted
from ipmlang.inverse.split.printing.naming import part_words, symbol_names
from ipmlang.inverse.split.printing.parameters import Told, told
from ipmlang.inverse.split.printing.schedules import arrangement
from ipmlang.inverse.split.scheme import Rule, Scheme, Split, Terminal
from ipmlang.inverse.split.wording import bracket, call


@dataclass(frozen=True, slots=True, eq=False)
class Printed:
    """items: of the grammar but its version, assets and axes; names: of the symbols; rules: how
    many there are besides the axiom's; families: symbols that are one rule with parameters.
    """

    items: tuple[ast.Item, ...]
    names: tuple[str, ...]
    rules: int
    families: tuple[tuple[int, ...], ...] = ()


def print_scheme(
    scheme: Scheme,
    axiom: str,
    precision: Precision,
    one_by_one: bool = False,
    lift: bool = True,
) -> Printed:
    """The grammar of a scheme; axiom: what the whole is called, as a wish; one_by_one: without
    tables, every placement written out; lift: counts become attributes.
    """
    given = Names()
    unnamed = frozenset() if one_by_one else inlined(scheme, precision.length)
    names = symbol_names(scheme, axiom, given, unnamed)
    wording = make_wording(scheme, names, precision, given)
    wording.one_by_one = one_by_one
    wording.bodies = {number: partial(rule_body, wording, number) for number in unnamed}
    attributes = () if one_by_one or not lift else _lift(wording)
    numbers = {names[number]: number for number in top_down(scheme) if number not in unnamed}
    rules = [_rule(wording, number) for number in numbers.values()]
    shapes = {name: "" for name, each in zip(names, scheme.symbols, strict=True)
              if isinstance(each, Terminal)} | part_words(scheme, names)  # fmt: skip
    made = Told(tuple(rules), tuple(wording.tables))
    if not one_by_one:
        made = told(rules, wording.tables, shapes, given)
    items: list[ast.Item] = [*attributes, *made.tables]
    items += [_spaced(rule, first=k == 0) for k, rule in enumerate(made.rules)]
    items.append(_start(wording))
    families = tuple(tuple(numbers[name] for name in each) for each in made.families)
    return Printed(tuple(items), names, len(made.rules) - 1, families)


def _lift(wording: Wording) -> tuple[ast.Attr, ...]:
    """Counts as attributes, and the scopes that follow them."""
    found = lifted(wording)
    wording.sized |= found.sizes
    return found.attributes


def make_wording(
    scheme: Scheme, names: Sequence[str], precision: Precision, given: Names
) -> Wording:
    """What the rules of a scheme are printed with."""
    wording = Wording(scheme, names, precision, reaches(scheme), given=given)
    for number, size in needing_size(scheme, precision.length).items():
        wording.sized[number] = precision.vector(size)
    wording.sizing = frozenset(wording.sized) - in_cells(scheme)
    return wording


def rule_body(wording: Wording, number: int) -> tuple[ast.Element, ...]:
    """The successor of a rule of the scheme: the shapes that follow each other in it."""
    rule = wording.scheme.symbols[number]
    assert isinstance(rule, Rule)
    body: list[ast.Element] = []
    if number in wording.sizing:
        body.append(call("size", *wording.sized[number]))
    own = _scheduled(wording, number, rule, body)
    for k, item in enumerate(rule.items):
        elements = own[k] if k in own else item_elements(wording, number, k, item)
        if isinstance(item, Split) and k < len(rule.items) - 1:
            elements = [bracket(elements)]
        body += elements
    return tuple(body) or (ast.Module("nil"),)


def _scheduled(
    wording: Wording, number: int, rule: Rule, body: list[ast.Element]
) -> dict[int, list[ast.Element]]:
    """The elements of items that only place copies, by item; those of all go to the body."""
    found = (
        {} if wording.one_by_one else {k: copies_of(wording, x) for k, x in enumerate(rule.items)}
    )
    copies = {k: each for k, each in found.items() if each is not None}
    title = f"{wording.names[number]}_parts".lower()
    made = arrangement(list(copies.values()), title, wording.given)
    body += made.first
    wording.tables += made.tables
    return {k: list(own) for k, own in zip(copies, made.own, strict=True)}


def _rule(wording: Wording, number: int) -> ast.Rule:
    rule = wording.scheme.symbols[number]
    assert isinstance(rule, Rule)
    body = rule_body(wording, number)
    if number == wording.scheme.axiom:
        body = _framed(wording, wording.scheme.frame, body)
    return ast.Rule(ast.Head(wording.names[number]), body, doc=rule.note or None)


def _framed(
    wording: Wording, frame: Frames, body: tuple[ast.Element, ...]
) -> tuple[ast.Element, ...]:
    """The axiom's body in its coordinates; what mirrors or grows stands in a bracket."""
    reach = float(wording.reach[wording.scheme.axiom])
    spot = spots(frame, wording.precision, reach)[0]
    steps = steps_to(spot)
    if spot.mirrored or spot.scale is not None:
        return (bracket([*steps, *body]),)
    return (*steps, *body)


def _spaced(rule: ast.Rule, first: bool) -> ast.Rule:
    return replace(rule, blank_before=first or rule.doc is not None)


def _start(wording: Wording) -> ast.Start:
    """`start Castle on box(4, 5, 6)`."""
    axiom = wording.scheme.axiom
    size = np.maximum(wording.scheme.symbols[axiom].size, 0.0)
    place = ast.Place("box", wording.sized.get(axiom) or wording.precision.vector(size))
    name = wording.names[axiom]
    return ast.Start((ast.Module(name),), place, blank_before=True)
