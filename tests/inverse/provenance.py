"""Which rules every element of a derived grammar stands under, whatever form the rules have.

In goes a grammar's syntax tree and the folder of its parts; out come `Site`s: each repeat and each
rule that others name, with the boxes of all elements derived below it. The tree is derived in an
instrumented copy: around each site the paint order is raised by a power of two of its own, and
lowered again, so that an instance's order tells all sites above it. A residual, which may set the
order, is left out of the copy; what is drawn comes from the grammar as it is.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ast, compile_text
from ipmlang.compiler.format import format_grammar
from ipmlang.formats.drawing import Drawing
from ipmlang.inverse.distance import bounding_boxes
from ipmlang.inverse.lsystem.curves import stack
from ipmlang.runtime import derive
from ipmlang.runtime.export.sheet import drawing_of
from ipmlang.runtime.scene import Instances, Scene

Floats = NDArray[np.float64]
Elements = tuple[ast.Element, ...]

TOGETHER = 30  # sites in one derivation: as many bits fit above the grammar's own orders
LOWEST = 65536.0  # what the first site adds; a grammar's own orders stay far below


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """where: the repeat's number or the rule's name; repeats: whether it is a repetition with
    places by a rule, a repeat or a recursion; shared: whether it is a rule named twice or more, or
    under a repetition; boxes: (n, 4) least and largest x and y of the elements below it.
    """

    where: int | str
    repeats: bool
    shared: bool
    boxes: Floats


def sites(grammar: ast.Grammar, folder: Path) -> list[Site]:
    """All sites of a grammar, whose parts lie in a folder, with what is derived below them."""
    grammar, found = _spread(grammar), []
    for marks, scene, order in _passes(grammar, folder):
        for k, mark in enumerate(marks):
            below = drawing_of(_taken(scene, (order >> k) & 1 == 1))
            found.append(Site(mark.where, mark.repeats, mark.shared, boxes_of(below)))
    return found


def ruled_share(grammar: ast.Grammar, folder: Path) -> float:
    """The share of the terminals under a repetition or a rule that is used twice or more."""
    ruled, grammar = np.zeros(0, np.bool_), _spread(grammar)
    for marks, _, order in _passes(grammar, folder):
        bits = sum(1 << k for k, mark in enumerate(marks) if mark.repeats or mark.shared)
        here = (order & bits) != 0
        ruled = here | ruled if len(ruled) else here
    return float(ruled.mean()) if len(ruled) else 0.0


def boxes_of(drawing: Drawing) -> Floats:
    """(n, 4) least and largest x and y of every element with an outline."""
    outlines = [each.outline for each in drawing.elements if each.outline is not None]
    if not outlines:
        return np.zeros((0, 4))
    return bounding_boxes(stack(outlines), np.arange(len(outlines)))


# ------------------------------------------------------------- tables of many things


def _spread(grammar: ast.Grammar) -> ast.Grammar:
    """The grammar with loops over tables that name symbols written out, row by row, so that each
    symbol is named where it stands.
    """
    tables = {each.name: each for each in grammar.items if isinstance(each, ast.Table)}

    def spread(body: Elements) -> Elements:
        made: list[ast.Element] = []
        for element in body:
            changed = _inside(element, spread)
            match changed:
                case ast.Repeat(ast.Rows(row, name)) if f"{row}.shape" in _names(changed):
                    cells = (
                        dict(zip(tables[name].columns, r, strict=True)) for r in tables[name].rows
                    )
                    for each in cells:
                        made += _read(changed.body, {f"{row}.{key}": v for key, v in each.items()})
                case _:
                    made.append(changed)
        return tuple(made)

    def item(given: ast.Item) -> ast.Item:
        return replace(given, body=spread(given.body)) if isinstance(given, ast.Rule) else given

    return replace(grammar, items=tuple(item(each) for each in grammar.items))


def _read(body: Elements, cells: dict[str, ast.Expr]) -> Elements:
    """Elements with the cells of a row in place of what reads them."""
    made: list[ast.Element] = []
    for element in body:
        if isinstance(element, ast.Bracket):
            element = replace(element, body=_read(element.body, cells))
        elif isinstance(element, ast.Module):
            named = cells.get(element.name)
            name = named.id if isinstance(named, ast.Name) else element.name
            values = [
                cells.get(each.value.id, each.value)
                if isinstance(each.value, ast.Name)
                else each.value
                for each in element.args
            ]
            args = [replace(each, value=v) for each, v in zip(element.args, values, strict=True)]
            element = replace(element, name=name, args=tuple(args))
        made.append(element)
    return tuple(made)


# ------------------------------------------------------------------ what there is


@dataclass(frozen=True, slots=True)
class _Mark:
    """A site before anything is derived; see Site."""

    where: int | str
    repeats: bool
    shared: bool


def _marks(grammar: ast.Grammar) -> list[_Mark]:
    called = _calls(grammar)
    loops = [
        _Mark(number, _is_regular(repeat), False) for number, repeat in enumerate(_repeats(grammar))
    ]
    leads = _leads(grammar)
    return loops + [_Mark(name, name in leads[name], often > 1) for name, often in called.items()]


def _rules(grammar: ast.Grammar) -> list[ast.Rule]:
    return [item for item in grammar.items if isinstance(item, ast.Rule)]


def _bodies(grammar: ast.Grammar) -> Iterator[Elements]:
    for item in grammar.items:
        if isinstance(item, ast.Rule):
            yield item.body
        elif isinstance(item, ast.Start):
            yield item.axiom


def _walk(node: object) -> Iterator[object]:
    """A node and all nodes below it, in the order written."""
    yield node
    if isinstance(node, tuple):
        for each in node:
            yield from _walk(each)
    elif hasattr(node, "__dataclass_fields__"):
        for each in fields(node):  # type: ignore[arg-type]
            yield from _walk(getattr(node, each.name))


def _repeats(grammar: ast.Grammar) -> list[ast.Repeat]:
    return [
        node for body in _bodies(grammar) for node in _walk(body) if isinstance(node, ast.Repeat)
    ]


def _names(body: object) -> list[str]:
    return [node.name for node in _walk(body) if isinstance(node, ast.Module)]


def _calls(grammar: ast.Grammar) -> Counter[str]:
    """How often each symbol with rules is named from elsewhere; under a repeat counts as twice."""
    heads = {rule.head.name for rule in _rules(grammar)}
    found: Counter[str] = Counter()
    for body in _bodies(grammar):
        found.update(name for name in _names(body) if name in heads)
        for node in _walk(body):
            if isinstance(node, ast.Repeat):
                found.update({name for name in _names(node.body) if name in heads})
    return found


def _leads(grammar: ast.Grammar) -> dict[str, set[str]]:
    """All symbols that the rules of each symbol lead to, itself only if they lead back."""
    named: dict[str, set[str]] = {}
    for rule in _rules(grammar):
        named.setdefault(rule.head.name, set()).update(_names(rule.body))
    found: dict[str, set[str]] = {}
    for name in named:
        seen: set[str] = set()
        waiting = [name]
        while waiting:
            new = named.get(waiting.pop(), set()) - seen
            seen |= new
            waiting += new
        found[name] = seen
    return found


def _is_regular(repeat: ast.Repeat) -> bool:
    """Whether copies are placed by more than a list of places: the index, a motion from copy to
    copy, listed steps, or arithmetic.
    """
    if repeat.steps or any(_moves(each) for each in repeat.body):
        return True
    inside = list(_walk(repeat.body))
    if isinstance(repeat.head, ast.Rows):
        return any(isinstance(node, ast.Binary) for node in inside)
    index = repeat.head.variable
    return any(isinstance(node, ast.Name) and node.id == index for node in inside)


def _moves(element: ast.Element) -> bool:
    return isinstance(element, ast.Module) and element.name in {"f", "F", "at", "+", "-", "*"}


# ---------------------------------------------------------------- instrumentation


def _instrumented(grammar: ast.Grammar, bit: dict[int | str, float]) -> ast.Grammar:
    """The grammar with the paint order raised around each marked site."""
    number = iter(range(len(_repeats(grammar))))
    leads = _leads(grammar)
    # The symbols that lead to one and back: a call among them is no new site.
    inside = {
        name: {name, *(each for each in there if name in leads.get(each, set()))}
        for name, there in leads.items()
    }
    items: list[ast.Item] = []
    for item in grammar.items:
        if isinstance(item, ast.Rule):
            own = inside[item.head.name]
            items.append(replace(item, body=_marked(item.body, bit, own, number)))
        elif isinstance(item, ast.Start):
            items.append(replace(item, axiom=_marked(item.axiom, bit, set(), number)))
        elif not isinstance(item, ast.Residual):
            items.append(item)
    return replace(grammar, items=tuple(items))


def _marked(
    body: Elements, bit: dict[int | str, float], own: set[str], number: Iterator[int]
) -> Elements:
    def inner(elements: Elements) -> Elements:
        return _marked(elements, bit, own, number)

    done: list[ast.Element] = []
    for element in body:
        mark: int | str | None = None
        if isinstance(element, ast.Repeat):
            mark = next(number)
        elif isinstance(element, ast.Module) and element.name not in own:
            mark = element.name
        changed = _inside(element, inner)
        if mark is None or mark not in bit:
            done.append(changed)
        else:
            done += [_raised(bit[mark]), changed, _raised(-bit[mark])]
    return tuple(done)


def _inside(element: ast.Element, inner: Callable[[Elements], Elements]) -> ast.Element:
    """An element with what stands in its braces changed."""
    if isinstance(element, ast.Repeat | ast.Bracket):
        return replace(element, body=inner(element.body))
    if isinstance(element, ast.Block | ast.Each):
        parts = tuple(replace(part, body=inner(part.body)) for part in element.parts)
        return replace(element, parts=parts)
    return element


def _raised(steps: float) -> ast.Module:
    return ast.Module("layer", (ast.Argument(ast.Number(steps)),))


def _passes(
    grammar: ast.Grammar, folder: Path
) -> Iterator[tuple[list[_Mark], Scene, NDArray[np.int64]]]:
    """Some of the marks, what is derived, and for each terminal the bits of the marks above it."""
    marks = _marks(grammar)
    drawn = _derived(grammar, folder)
    for first in range(0, len(marks), TOGETHER):
        some = marks[first : first + TOGETHER]
        bit = {mark.where: LOWEST * 2.0**k for k, mark in enumerate(some)}
        traced = _derived(_instrumented(grammar, bit), folder).instances.layer
        if len(traced) != len(drawn.instances):
            raise ValueError("the instrumented grammar draws other terminals")
        yield some, drawn, np.round(traced / LOWEST).astype(np.int64)


def _derived(grammar: ast.Grammar, folder: Path) -> Scene:
    return derive(compile_text(format_grammar(grammar), folder=folder)[1])


def _taken(scene: Scene, rows: NDArray[np.bool_]) -> Scene:
    """The scene with some of its instances."""
    table = scene.instances
    columns = {each.name: getattr(table, each.name)[rows] for each in fields(table)}
    return replace(scene, instances=Instances(**columns))
