"""Parts removed, added, cut, split, joined and scaled: one part of a building becomes others.

In go drafts and what was selected, out come drafts (sections 4.2 and 4.3 of Demir et al. 2016).
What stands around stays where it is.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import fail
from ipmlang.edit.arithmetic import literal
from ipmlang.edit.buildings.forms import EXTENTS, Forms
from ipmlang.edit.buildings.growing import grown
from ipmlang.edit.buildings.measuring import Unit
from ipmlang.edit.buildings.rewriting import Placed, rewritten
from ipmlang.edit.buildings.tree import unknown
from ipmlang.edit.buildings.units import selected, tolerance
from ipmlang.edit.draft import Change, Draft
from ipmlang.edit.symbols import Elements, free_name, with_modules
from ipmlang.inverse.frames import Floats, Frames, compose, inverse, moved_to
from ipmlang.inverse.split.wording import all_nothing, call, times

AXES = ("x", "y", "z")
MOST_COPIES = 1000  # of a part that is split


def remove(draft: Draft, select: str, *, number: int | None = None) -> Draft:
    """The building without a part, or all of its kind. Raises IpmError if nothing would be left."""
    forms = Forms(grown(draft))
    gone = selected(forms.tree, select, number)
    rows = {row for unit in gone for row in _rows(forms, unit)}
    if len(rows) == len(forms.tree.owner):
        raise fail("bad-command", f"nothing would be left without `{select}`")
    return rewritten(forms, dict.fromkeys(gone, ()), what=f"no {select}")


def _rows(forms: Forms, unit: Unit) -> list[int]:
    return [unit[1]] if unit[0] == "terminal" else forms.tree.below(unit[1])


def add(
    draft: Draft,
    part: str,
    select: str,
    at: Floats,
    size: Floats | None = None,
    *,
    number: int | None = None,
) -> Draft:
    """A part `at` a place (3,) in the coordinates of another, in each of its kind; as large as it
    is, or of a size (3,). Raises IpmError for a place or a size that is none.
    """
    if not np.isfinite(at).all() or (size is not None and not (size >= 0).all()):
        raise fail("bad-command", "a part is added at three numbers, with sizes of 0 or more")
    forms = Forms(grown(draft))
    if part not in {*forms.tree.names, *forms.tree.terminals.labels}:
        elements: Elements = (ast.Module(_rule(draft, part)),)
        if size is not None:
            elements = (call("size", *map(_literal, size)), *elements)
        source = None
    else:
        source, elements = selected(forms.tree, part, 1)[0], ()
    more: dict[int, list[Placed]] = {}
    for kind, row in selected(forms.tree, select, number):
        if kind == "terminal":
            message = f"`{select}` is a terminal: nothing can be added to it"
            raise fail("bad-command", message, hint="name the rule that it stands in")
        frame = compose(forms.tree.frames[row : row + 1], moved_to(at))
        if source is not None and size is not None:
            x, y, z = map(_literal, size)
            elements = forms.fitted(source, row, (x, y, z))
        elif source is not None:
            elements = forms.plain(source, row)
        more.setdefault(row, []).append(Placed(frame, elements))
    return rewritten(forms, {}, more, what=part)


def _rule(draft: Draft, part: str) -> str:
    rules = {item.head.name for item in draft.grammar.items if isinstance(item, ast.Rule)}
    assets = {n for item in draft.grammar.items if isinstance(item, ast.Asset) for n in item.names}
    if part not in rules | assets:
        raise unknown(f"this grammar has no part `{part}`", part, rules | assets)
    return part


def _literal(value: float) -> ast.Number:
    return literal(float(value))


def cut(
    draft: Draft, select: str, axis: int, places: Sequence[float], *, number: int | None = None
) -> Draft:
    """A part cut by planes across one of its own axes, at distances from its low side: each piece
    is the part again, in that room. Raises IpmError for planes that miss it.
    """
    forms = Forms(grown(draft))
    at = {}
    for unit in selected(forms.tree, select, number):
        low, high = forms.measured.box(unit)
        whole = float(high[axis] - low[axis])
        ordered = sorted(places)
        if not ordered:
            raise fail("bad-command", f"no plane is given to cut `{select}` by", hint="--x 2.5")
        if not 0 < ordered[0] <= ordered[-1] < whole:
            message = f"a plane at {AXES[axis]} {ordered[0]:g} misses `{select}`"
            hint = f"it is {whole:g} long along its {AXES[axis]}"
            raise fail("bad-command", message, hint=hint)
        at[unit] = _pieces(forms, unit, axis, [0.0, *ordered, whole])
    return rewritten(forms, at, what=f"cut {select}")


def split(draft: Draft, select: str, axis: int, count: int, *, number: int | None = None) -> Draft:
    """A part split into so many copies of itself along one of its own axes."""
    if count < 2:
        raise fail("bad-command", f"a part is split into two or more, not {count}")
    if count > MOST_COPIES:
        raise fail("bad-command", f"a part is split into at most {MOST_COPIES:,}, not {count:,}")
    forms = Forms(grown(draft))
    at = {}
    for unit in selected(forms.tree, select, number):
        low, high = forms.measured.box(unit)
        whole = float(high[axis] - low[axis])
        if whole <= 0:
            raise fail("bad-command", f"`{select}` has no extent along its {AXES[axis]}")
        at[unit] = _pieces(forms, unit, axis, np.linspace(0.0, whole, count + 1).tolist())
    return rewritten(forms, at, what=f"split {select}")


def _pieces(forms: Forms, unit: Unit, axis: int, ends: Sequence[float]) -> list[Placed]:
    low, high = forms.measured.box(unit)
    found = []
    for begin, end in itertools.pairwise(ends):
        corner, size = low.copy(), high - low
        corner[axis], size[axis] = low[axis] + begin, end - begin
        x, y, z = map(_literal, size)
        frame = compose(forms.measured.frame(unit), moved_to(corner))
        found.append(Placed(frame, forms.fitted(unit, forms.measured.owner(unit), (x, y, z))))
    return found


def join(draft: Draft, select: str, numbers: Sequence[int], *, name: str | None = None) -> Draft:
    """Parts of one rule joined under a new one: a row where they are alike and evenly spaced.
    Raises IpmError for fewer than two, and for parts of different rules.
    """
    if len(set(numbers)) < 2:
        raise fail("bad-command", "two parts or more are joined", hint="--number 1 --number 2")
    forms = Forms(grown(draft))
    units = [selected(forms.tree, select, number)[0] for number in dict.fromkeys(numbers)]
    owners = {forms.measured.owner(unit) for unit in units}
    if len(owners) > 1:
        message = f"these `{select}` stand in different shapes"
        raise fail("bad-command", message, hint="join parts that one rule made")
    owner, first = owners.pop(), forms.measured.frame(units[0])
    base = Frames(first.position, *(getattr(forms.measured.frame(("shape", owner)), each)
                                    for each in ("rotation", "hand", "scale")))  # fmt: skip
    back = inverse(base)
    parts = [
        (compose(back, forms.measured.frame(unit)), forms.plain(unit, owner)) for unit in units
    ]
    bare = select.rpartition(".")[2]
    title = forms.new_name(name or f"{bare[0].upper()}{bare[1:]}_group")
    forms.rules[title] = (select, forms.laid(title, parts, tolerance(forms.tree)))
    at: dict[Unit, Sequence[Placed]] = dict.fromkeys(units[1:], ())
    at[units[0]] = [Placed(base, (ast.Module(title),))]
    return rewritten(forms, at, what=title)


def scale(draft: Draft, terminal: str, factors: Floats) -> Draft:
    """A terminal drawn so many times as large (3,) about the middle of its scope, wherever it
    stands, now and after later edits. Raises IpmError where there is no such terminal.
    """
    if not (np.isfinite(factors).all() and (factors > 0).all()):
        raise fail("bad-command", "a terminal is scaled by factors above 0")
    tree = grown(draft)
    labels = tree.terminals.labels
    rows = tree.terminals_of(terminal)
    if not rows:
        raise unknown(f"this building has no terminal `{terminal}`", terminal, set(labels))
    if len({labels[row] for row in rows}) > 1:
        several = ", ".join(f"`{name}`" for name in sorted({labels[row] for row in rows}))
        raise fail("bad-command", f"`{terminal}` is drawn by several terminals: {several}")
    terminal = labels[rows[0]]
    forms = Forms(tree)
    unit: Unit = ("terminal", rows[0])
    name = free_name(draft.grammar, f"{terminal}_scaled")
    grammar = with_modules(
        draft.grammar,
        lambda module, _: (replace(module, name=name) if module.name == terminal else module,),
    )
    body = _scaled(forms, unit, factors)
    items = list(grammar.items)
    place = max((k for k, item in enumerate(items) if isinstance(item, ast.Rule)), default=None)
    begin = len(items) - 1 if place is None else place + 1
    grammar = replace(
        grammar, items=(*items[:begin], ast.Rule(ast.Head(name), body), *items[begin:])
    )
    told = ", ".join(f"{factor:g}" for factor in factors)
    change = Change(terminal, "its scope", f"{told} times")
    return replace(draft, grammar=grammar, changes=(*draft.changes, change))


def _scaled(forms: Forms, unit: Unit, factors: Floats) -> Elements:
    name = forms.measured.name(unit)
    if not forms.tree.is_natural(unit[1]):
        shift = [
            times(literal((1 - k) / 2), each) for k, each in zip(factors, EXTENTS, strict=True)
        ]
        x, y, z = (
            ast.Number(0.0) if math.isclose(k, 1.0) else each
            for k, each in zip(factors, shift, strict=True)
        )
        size = [times(literal(k), each) for k, each in zip(factors, EXTENTS, strict=True)]
        move = [] if all_nothing((x, y, z)) else [call("translate", x, y, z)]
        return (*move, call("size", *size), ast.Module(name))
    low, high = forms.measured.box(unit)
    corner = low - (factors - 1) / 2 * (high - low)
    size = [literal(float(each)) for each in (high - low) * factors]
    x, y, z = map(_literal, corner)
    label = forms.new_name(f"{name}_fitted")
    return (
        *([] if all_nothing((x, y, z)) else [call("translate", x, y, z)]),
        call("size", *size),
        call("insert", ast.Name(name)),
        ast.Module(label),
    )
