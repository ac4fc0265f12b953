"""A whole building so many times in a row: what becomes of one that is stretched too far.

In goes a draft, out comes one in which an attribute says how often the building stands there, so
that the next resize has but to count. Whether it shall repeat is decided elsewhere (section 4.1 of
Demir et al. 2016: a subtree that is stretched too far is split into copies).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ipmlang.compiler import ast
from ipmlang.edit.arithmetic import literal
from ipmlang.edit.buildings.forms import Forms
from ipmlang.edit.buildings.growing import grown
from ipmlang.edit.buildings.measuring import Unit
from ipmlang.edit.buildings.rewriting import Placed, rewritten
from ipmlang.edit.buildings.units import tolerance
from ipmlang.edit.draft import Draft
from ipmlang.inverse.split.placing import Precision
from ipmlang.inverse.split.wording import NOTHING, bracket, call, times

HEADS = (ast.Version, ast.Import, ast.Axes, ast.Asset, ast.Attr, ast.Const)
STANDS = 0.9  # of its ground, that a building has on top where another one can stand on it
FINE = 80  # of how near touches, that a step is off by a part at most


def repeated(draft: Draft, symbol: str, axis: int, count: int) -> Draft:
    """A building that stands `count` times along an axis of its own, each where the last one ends;
    symbol: what all of it is drawn by.
    """
    forms = Forms(grown(draft))
    tree = forms.tree
    unit: Unit = ("shape", tree.names.index(symbol))
    low, high = forms.measured.box_in(unit, forms.measured.frame(unit))
    bare = symbol.rpartition(".")[2]
    title, counted = forms.new_name(f"{bare}Row"), forms.new_name(f"{bare.lower()}_count")
    precision = Precision(tolerance(tree) / FINE / count)
    move: list[ast.Expr] = [NOTHING, NOTHING, NOTHING]
    move[axis] = times(precision.number(float(high[axis] - low[axis])), ast.Name("i"))
    around = forms.measured.owner(unit)
    body = bracket([call("translate", *move), *forms.plain(unit, around)])
    forms.rules[title] = (symbol, (ast.Repeat(ast.Count("i", ast.Name(counted)), (body,)),))
    at = {unit: [Placed(forms.measured.frame(unit), (ast.Module(title),))]}
    made = rewritten(forms, at, what=title)
    doc = f"times that {bare} repeats along {'xyz'[axis]}"
    span = ast.Range(ast.Number(1.0), None)
    attribute = ast.Attr(counted, "int", literal(float(count)), span, doc)
    items = made.grammar.items
    place = max((k for k, each in enumerate(items) if isinstance(each, HEADS)), default=-1) + 1
    grammar = replace(made.grammar, items=(*items[:place], attribute, *items[place:]))
    return replace(made, grammar=grammar)


def can_stand_on(forms: Forms, unit: Unit) -> bool:
    """Whether a building has a top as wide as its ground, on which another one can stand: no roof,
    whose box is as wide but not its ridge.
    """
    tree, rows = forms.tree, forms.measured.rows(unit)
    drawn = zip(
        rows, tree.maps["terminal"].out[rows], tree.terminals.frames.position[rows], strict=True
    )
    points = np.concatenate([tree.outline(row) @ out.T + place for row, out, place in drawn])
    near, height = tolerance(tree), points[:, 2]
    ground = points[height <= height.min() + near, :2]
    top = points[height >= height.max() - near, :2]
    shared = np.minimum(ground.max(axis=0), top.max(axis=0))
    shared -= np.maximum(ground.min(axis=0), top.min(axis=0))
    return bool((shared >= STANDS * np.ptp(ground, axis=0)).all())
