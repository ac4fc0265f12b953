"""What a part of a grammar draws when it stands alone, in its own frame.

In go a draft and elements for an axiom, out come the drawing, with coordinates as an asset file has
them, and where the turtle is left. The draft is not changed and nothing of it is written.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ast, compile_file
from ipmlang.compiler.diagnostics import fail
from ipmlang.edit.draft import Draft
from ipmlang.edit.saving import about, staged
from ipmlang.edit.symbols import Elements, free_name
from ipmlang.formats.drawing import Drawing
from ipmlang.formats.svg.bounds import segment_boxes
from ipmlang.runtime import derive
from ipmlang.runtime.export.sheet import drawing_of
from ipmlang.runtime.scene import SCOPE, SEGMENT, Instances, Scene

Box = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Frame:
    """Where a turtle is left in the plane: place, degrees, scale, and whether it is mirrored."""

    x: float
    y: float
    angle: float
    scale: float
    mirrored: bool

    @property
    def is_start(self) -> bool:
        """Whether it is where it started."""
        far = max(abs(self.x), abs(self.y), abs(self.angle), abs(self.scale - 1))
        return far < 1e-9 and not self.mirrored


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """A part by itself. drawing: y down, the part's origin at 0; end: where it leaves the turtle;
    sets_pen: it leaves the pen changed; layered: it paints out of the order of derivation; width:
    that of its lines whose pen sets none, where that is a share of the whole drawing.
    """

    drawing: Drawing
    end: Frame
    sets_pen: bool
    layered: bool
    width: float | None = None


def try_part(draft: Draft, part: Elements, seed: int = 0) -> Trial:
    """Derive a part as the axiom. Raises IpmError where it cannot be, or leaves the plane."""
    mark = free_name(draft.grammar, "Mark")
    alone = _alone(draft.grammar, part, mark)
    with staged(replace(draft, grammar=alone), draft.path) as made, about(made, draft.path):
        scene = _derived(made.path, draft.allow_outside, seed)
        table = scene.instances
        marked = np.isin(table.rule, [k for k, each in enumerate(scene.rules) if each.rule == mark])
        first, last = np.flatnonzero(marked)[[0, -1]].tolist()
        shown = _rows(scene, ~marked)
        width = _set_widths(shown, lambda: _default_width(draft, seed))
        return Trial(
            drawing_of(shown),
            _frame(table, last),
            _pen(table, first) != _pen(table, last),
            bool((shown.instances.layer != 0).any()),
            None if has_canvas(draft.grammar) else width,
        )


def _alone(grammar: ast.Grammar, part: Elements, mark: str) -> ast.Grammar:
    """The part between two marks, which tell where the turtle is. Without its canvas a drawing is
    flipped about 0, as the drawings of assets are; a residual is of the whole drawing.
    """
    apart = ast.Start | ast.Canvas | ast.Residual
    kept = tuple(item for item in grammar.items if not isinstance(item, apart))
    line = ast.Module("draw", (ast.Argument(ast.Number(1.0)),))
    rule = ast.Rule(ast.Head(mark), (ast.Bracket((line,)),))
    start = ast.Start((ast.Module(mark), *part, ast.Module(mark)))
    return replace(grammar, items=(*kept, rule, start))


def _derived(path: Path, allow_outside: bool, seed: int) -> Scene:
    _, program, _ = compile_file(path, allow_outside=allow_outside)
    scene = derive(program, seed=seed)
    if not scene.flat:
        hint = "parts of drawings can be measured and stored, parts of models not yet"
        raise fail("not-flat", "this part leaves the plane", hint=hint)
    return scene


def _rows(scene: Scene, kept: NDArray[np.bool_]) -> Scene:
    """The scene with some of its rows."""
    columns = {each.name: getattr(scene.instances, each.name)[kept] for each in fields(Instances)}
    groups = scene.groups
    if groups is not None:
        groups = replace(groups, of=groups.of[kept])
    return replace(scene, instances=Instances(**columns), groups=groups)


def _frame(table: Instances, row: int) -> Frame:
    x, y = table.position[row, :2].tolist()
    w, z = table.rotation[row, 0], table.rotation[row, 3]
    scale = float(table.scale[row])
    return Frame(x, y, math.degrees(2 * math.atan2(z, w)), abs(scale), scale < 0)


def _pen(table: Instances, row: int) -> tuple[int, int, str, float]:
    """What a pen holds, in a form that can be compared."""
    width = f"{table.width[row]:g}"
    return int(table.style[row]), int(table.color[row]), width, float(table.layer[row])


# --------------------------------------------------------------------------- widths


def _set_widths(scene: Scene, default: Callable[[], float]) -> float | None:
    """Lines whose pen sets no width get the one that they have in the whole drawing, which is
    given back; None if there are no such lines.
    """
    table = scene.instances
    bare = np.isin(table.asset, (SEGMENT, SCOPE)) & np.isnan(table.width)
    if not bare.any():
        return None
    width = default()
    table.width[bare] = width
    return width


def has_canvas(grammar: ast.Grammar) -> bool:
    """Whether a drawing has a box of its own, and with it lines of width 1."""
    return any(isinstance(item, ast.Canvas) for item in grammar.items)


def _default_width(draft: Draft, seed: int) -> float:
    """The width of lines whose pen sets none: 1 on a canvas, else as the whole drawing has it."""
    if has_canvas(draft.grammar):
        return 1.0
    with staged(draft, draft.path) as made, about(made, draft.path):
        scene = _derived(made.path, draft.allow_outside, seed)
        table = scene.instances
        bare = np.flatnonzero(np.isin(table.asset, (SEGMENT, SCOPE)) & np.isnan(table.width))
        if not len(bare):
            return 1.0
        drawn = drawing_of(_rows(scene, np.isin(table.asset, (SEGMENT,)))).elements
        return drawn[0].style.stroke_width if drawn else 1.0


# ---------------------------------------------------------------------------- boxes


def box_of(drawing: Drawing) -> Box | None:
    """(x, y, width, height) of the outlines of a drawing, pens apart; None if it has none."""
    outlines = [each.outline for each in drawing.elements if each.outline is not None]
    outlines = [each for each in outlines if len(each.kind)]
    if not outlines:
        return None
    kind = np.concatenate([outline.kind for outline in outlines])
    boxes = segment_boxes(kind, np.concatenate([outline.coords for outline in outlines]))
    x0, y0 = boxes[:, :2].min(axis=0).tolist()
    x1, y1 = boxes[:, 2:].max(axis=0).tolist()
    return x0, y0, x1 - x0, y1 - y0
