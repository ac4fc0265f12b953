"""Parts copied into other parts: fitted or repeated to fill, instead of what stands there or around
it, turned as that is turned.

In go drafts and what was selected, out come drafts (section 4.3 of Demir et al. 2016). The source
may come from another grammar, which is imported: so a building takes on another one's style. Where
a part is put is decided by boxes alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import fail
from ipmlang.compiler.nodes import mapped
from ipmlang.edit.arithmetic import literal
from ipmlang.edit.buildings.forms import EXTENTS, Forms
from ipmlang.edit.buildings.growing import grown
from ipmlang.edit.buildings.measuring import Unit
from ipmlang.edit.buildings.rewriting import Placed, rewritten
from ipmlang.edit.buildings.units import selected
from ipmlang.edit.draft import Draft
from ipmlang.edit.symbols import Elements, defined_names
from ipmlang.inverse.frames import Floats, Frames, compose, from_matrices, linear, moved_to

UP = np.array([0.0, 0.0, 1.0])
OFTEN = 1.5  # times as large as it is: from there on a source fills with copies
UPRIGHT = 0.7  # of an axis's length that is upward where it points up


@dataclass(frozen=True, slots=True)
class Copying:
    """How a source comes to stand: insert: between a target and its parts, which are kept; fill: as
    often as it fits, about as large as it is, rather than once, stretched.
    """

    insert: bool = False
    fill: bool = False


def paste(
    draft: Draft,
    source: str,
    select: str,
    how: Copying | None = None,
    *,
    number: int | None = None,
    source_number: int = 1,
) -> Draft:
    """A part of a building where others stand. Raises IpmError where there is no such part, and
    where it would hold itself.
    """
    how = how or Copying()
    forms = Forms(grown(draft))
    taken = selected(forms.tree, source, source_number)[0]
    targets = selected(forms.tree, select, number)
    _refuse_loops(forms, taken, targets)
    at: dict[Unit, Sequence[Placed]] = {}
    for target in targets:
        if target == taken:
            continue
        at[target] = (
            _inserted(forms, taken, target)
            if how.insert
            else [into(forms, taken, forms, target, how.fill)]
        )
    return rewritten(forms, at, what=source)


def _refuse_loops(forms: Forms, source: Unit, targets: Sequence[Unit]) -> None:
    rows = set(forms.tree.above(forms.measured.owner(source)))
    for kind, row in targets:
        if kind == "shape" and row in rows:
            names = forms.measured.name(source), forms.measured.name((kind, row))
            message = f"`{names[0]}` stands in `{names[1]}` itself"
            raise fail("bad-command", message, hint="choose one that does not, with --number")


def into(forms: Forms, source: Unit, others: Forms, target: Unit, fill: bool = False) -> Placed:
    """A source of one tree in the box of a target of another (or the same), turned as that is."""
    low, high = others.measured.box(target)
    own_low, own_high = forms.measured.box(source)
    natural = (
        (own_high - own_low)
        * forms.measured.frame(source).scale[0]
        / others.measured.frame(target).scale[0]
    )
    matrix = _turn(forms, source, others, target, high - low)
    size = (high - low)[np.abs(matrix).argmax(axis=0)]
    size = np.where(size > 0, size, natural)
    corner = np.where(matrix.sum(axis=1) > 0, low, high)
    inner = from_matrices(np.concatenate([matrix, corner[:, None]], axis=1)[None])
    frame = compose(others.measured.frame(target), inner)
    around = others.measured.owner(target) if forms is others else 0
    x, y, z = (literal(float(each)) for each in size)
    often = [k for k in range(3) if fill and natural[k] > 0 and size[k] >= OFTEN * natural[k]]
    if not often:
        return Placed(frame, forms.fitted(source, around, (x, y, z)))
    name = forms.row_rule(source, natural, tuple(often), forms.measured.frame(source))
    scope = ast.Module("size", tuple(ast.Argument(each) for each in (x, y, z)))
    return Placed(frame, (*forms.pens(source, around), scope, ast.Module(name)))


def _turn(forms: Forms, source: Unit, others: Forms, target: Unit, extent: Floats) -> Floats:
    """(3, 3) the axes of a source, as columns, in those of a target: up to up, thin to thin. Two
    that fill their scopes have the same axes.
    """
    if forms.measured.fills(source) and others.measured.fills(target):
        return np.eye(3)
    low, high = forms.measured.box(source)
    mine = _ordered(forms.measured.frame(source), high - low)
    theirs = _ordered(others.measured.frame(target), extent)
    matrix = np.zeros((3, 3))
    for (k, up), (a, other) in zip(mine, theirs, strict=True):
        matrix[a, k] = up * other
    if np.linalg.det(matrix) < 0:
        matrix[:, mine[1][0]] *= -1
    return matrix


def _ordered(frame: Frames, extent: Floats) -> list[tuple[int, float]]:
    """The axes of a part with their directions: the one that points up, the wider one, the thin
    one.
    """
    upward = UP @ (linear(frame)[0] / frame.scale[0])
    up = int(np.abs(upward).argmax())
    sign = 1.0 if upward[up] > 0 or abs(upward[up]) < UPRIGHT else -1.0
    rest = sorted((k for k in range(3) if k != up), key=lambda k: (-float(extent[k]), k))
    return [(up, sign), (rest[0], 1.0), (rest[1], 1.0)]


def _inserted(forms: Forms, source: Unit, target: Unit) -> list[Placed]:
    """The target in each part of the source, which is fitted to the target's box."""
    if source[0] == "terminal":
        raise fail("bad-command", "only a rule can be inserted: a terminal has no parts")
    low, high = forms.measured.box(source)
    first, last = forms.measured.box(target)
    axis = np.abs(_turn(forms, source, forms, target, last - first)).argmax(axis=1)
    extent = np.where(high > low, high - low, 1.0)
    placed = []
    for unit in forms.measured.parts(source[1]):
        begin, end = forms.measured.box_in(unit, forms.measured.frame(source))
        share = np.stack([(begin - low) / extent, (end - low) / extent])[:, axis]
        corner = first + share[0] * (last - first)
        x, y, z = (literal(float(each)) for each in (share[1] - share[0]) * (last - first))
        frame = compose(forms.measured.frame(target), moved_to(corner))
        placed.append(Placed(frame, forms.fitted(target, forms.measured.owner(target), (x, y, z))))
    return placed


# ------------------------------------------------------------------------- other grammars


def transfer(
    draft: Draft,
    other: Draft,
    rule: str,
    select: str,
    how: Copying | None = None,
    *,
    number: int | None = None,
) -> Draft:
    """A rule of another building where parts of this one stand: style transfer. The other grammar
    is imported, with its files. Raises IpmError where either has no such part.
    """
    from ipmlang.edit.additions import with_import

    fill = how is not None and how.fill
    forms, theirs = Forms(grown(draft)), Forms(grown(other))
    source = selected(theirs.tree, rule, 1)[0]
    named = {name for item in other.grammar.items for name in defined_names(item)}
    draft, alias = with_import(draft, other, None)
    at = {}
    for target in selected(forms.tree, select, number):
        placed = into(theirs, source, forms, target, fill)
        at[target] = [replace(placed, elements=_qualified(placed.elements, alias, named))]
    for name, (_, body) in theirs.rules.items():
        forms.rules[name] = (select, _qualified(body, alias, named))
    forms.tree = replace(forms.tree, draft=draft)
    return rewritten(forms, at, what=rule)


def _qualified(elements: Elements, alias: str, named: set[str]) -> Elements:
    """Names of the other file as they are called where it is imported."""

    def change(node: object) -> object:
        match node:
            case ast.Module(name=name) | ast.Call(name=name) | ast.Block(name=name):
                known = name.partition(".")[0] in named
                return replace(node, name=f"{alias}.{name}") if known else node
            case ast.Name(id=name):
                known = name.partition(".")[0] in named
                return replace(node, id=f"{alias}.{name}") if known else node
            case _:
                return node

    return mapped(elements, change)


# ------------------------------------------------------------------------------- floors


def mixed(draft: Draft, among: Sequence[str], *, name: str | None = None) -> Draft:
    """Wherever one of some parts stands, one of all of them, drawn anew by each seed: random
    floors. Raises IpmError for fewer than two.
    """
    if len(set(among)) < 2:
        message = "one part alone cannot be mixed"
        raise fail("bad-command", message, hint="name two or more: --among Floor --among Attic")
    forms = Forms(grown(draft))
    sources = [selected(forms.tree, each, 1)[0] for each in dict.fromkeys(among)]
    wish = name or f"Any_{forms.measured.name(sources[0]).rpartition('.')[2]}"
    title = forms.new_name(wish)
    rules = []
    for place, source in enumerate(sources):
        guard = ast.Otherwise() if place == len(sources) - 1 else None
        chance = None if guard else ast.Chance("percent", literal(100 / len(sources)))
        pens = forms.pens(source, 0)
        body = (*pens, *forms.fitted(source, 0, EXTENTS)[len(pens) + 1 :])  # in its own scope
        rules.append(ast.Rule(ast.Head(title), body, guard, chance))
    at: dict[Unit, Sequence[Placed]] = {}
    for source in sources:
        for target in selected(forms.tree, forms.measured.name(source)):
            low, high = forms.measured.box(target)
            frame = compose(forms.measured.frame(target), moved_to(low))
            size = tuple(ast.Argument(literal(float(each))) for each in high - low)
            at[target] = [Placed(frame, (ast.Module("size", size), ast.Module(title)))]
    items = draft.grammar.items
    place = max((k for k, each in enumerate(items) if isinstance(each, ast.Rule)), default=-1) + 1
    grammar = replace(draft.grammar, items=(*items[:place], *rules, *items[place:]))
    forms.tree = replace(forms.tree, draft=replace(draft, grammar=grammar))
    return rewritten(forms, at, what=title)
