"""Structure-preserving resize: what is selected gets a size, the rest stays attached.

In goes a draft, out comes a draft in which the shape has that size and all that touched still does.
The grammar's own parameters are tried first; else the attachments of all parts are solved (section
4.1 of Demir et al. 2016) and written back. Parts that would be stretched to more than 1.8 times
become rows of themselves, neighbours squeezed to less than 0.4 times are joined.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, fail
from ipmlang.edit.buildings.attachments import Attached, attach, settle, stretching, warped
from ipmlang.edit.buildings.deciding import Key
from ipmlang.edit.buildings.driving import Aim, driven
from ipmlang.edit.buildings.forms import Forms, Unit
from ipmlang.edit.buildings.rewriting import Placed, rewritten
from ipmlang.edit.buildings.rows import Room
from ipmlang.edit.buildings.soundness import check_sound
from ipmlang.edit.buildings.tree import grown
from ipmlang.edit.buildings.units import Units, divided, selected, tolerance, whole
from ipmlang.edit.draft import Draft
from ipmlang.inverse.frames import Floats, Frames, from_matrices, linear

LARGE, LITTLE = 1.8, 0.4  # times its size: beyond, a part is split, or joined (section 4.1)
SAME = 1e-9
EVEN = 0.1  # of how near touches, by which sizes may differ and are the same


@dataclass(frozen=True, slots=True)
class Wanted:
    """Sizes along the own axes of what is selected; None leaves one. factors: they are factors."""

    x: float | None = None
    y: float | None = None
    z: float | None = None
    factors: bool = False

    def __post_init__(self) -> None:
        given = [each for each in (self.x, self.y, self.z) if each is not None]
        if not given:
            hint = "say which: --x 24, or --scale --x 1.5"
            raise fail("bad-command", "no size is given", hint=hint)
        for each in given:
            if not 0 < each < math.inf:
                message = f"nothing can be made {each:g} large: a size is above 0"
                raise fail("bad-command", message)

    @property
    def along(self) -> list[int]:
        """The axes that are said."""
        return [k for k, each in enumerate((self.x, self.y, self.z)) if each is not None]

    def of(self, size: Floats) -> Floats:
        """(3,) the sizes of something that is so large now."""
        given = [self.x, self.y, self.z]
        found = size.copy()
        for axis in self.along:
            value = given[axis]
            assert value is not None
            found[axis] = size[axis] * value if self.factors else value
        return found


def resize(
    draft: Draft,
    select: str | None,
    wanted: Wanted,
    *,
    number: int | None = None,
    seed: int = 0,
    parameters: bool = True,
) -> Draft:
    """A shape, or all of its kind that are as large, made as large as wanted; None: the whole.
    `number` chooses the n-th; without `parameters` places and sizes are changed, never an attribute
    or the lot.

    Raises IpmError where nothing is selected, and where the edit would tear the building apart.

    >>> from ipmlang.edit import read_text
    >>> wall = read_text('''ipm 1
    ... Wall --> [size(4, 1, 3) cube Stone] [translate(4, 0, 0) size(2, 1, 3) cube Brick]
    ... start Wall
    ... ''')
    >>> print(resize(wall, "Stone", Wanted(x=5.0)).text.splitlines()[1])
    Wall --> [size(5, 1, 3) cube Stone] [translate(5, 0, 0) size(2, 1, 3) cube Brick]
    """  # fmt: skip
    tree = grown(draft, seed=seed)
    forms = Forms(tree)
    select = whole(tree) if select is None else select
    every = selected(tree, select)
    picked, size = _alike(forms, selected(tree, select, number), wanted, select)
    aim = wanted.of(size)
    if np.allclose(aim, size, rtol=1e-12):
        return draft
    if parameters:
        others = [] if number is None else [each for each in every if each not in picked]
        keys = [[_key(forms, unit) for unit in units] for units in (picked, others)]
        meant = Aim(keys[0], keys[1], aim, wanted.along)
        found = driven(tree, meant)
        if found is not None:
            return found
        forms.tree = replace(tree, draft=_told(draft, meant.refused))
    return _stretched(forms, picked, aim / np.where(size > 0, size, 1.0), wanted.along)


def _told(draft: Draft, refused: Sequence[str]) -> Draft:
    """The draft with a note of the attributes that would have done, had they been allowed to."""
    if not refused:
        return draft
    message = f"{refused[0]}, out of its range: places and sizes were changed instead"
    return replace(
        draft, notes=(*draft.notes, Diagnostic("out-of-range", message, severity="warning"))
    )


def _alike(forms: Forms, found: list[Unit], wanted: Wanted, name: str) -> tuple[list[Unit], Floats]:
    """The first of those selected and all that are as large along the axes in question."""
    size = forms.extent(found[0])
    for axis in wanted.along:
        if size[axis] <= SAME:
            hint = f"it is {size[0]:g} x {size[1]:g} x {size[2]:g} along its own axes"
            message = f"`{name}` has no extent along its {'xyz'[axis]}"
            raise fail("nothing-selected", message, hint=hint)
    along = wanted.along
    same = [u for u in found if np.allclose(forms.extent(u)[along], size[along], rtol=1e-6)]
    return same, size


def _key(forms: Forms, unit: Unit) -> Key:
    """What a unit is found by in another derivation."""
    kind, row = unit
    keys = forms.tree.lineage.key if kind == "shape" else forms.tree.scene.instances.key
    return kind, int(keys[row])


# ------------------------------------------------------------------------------ stretching


def _stretched(forms: Forms, picked: Sequence[Unit], factor: Floats, along: Sequence[int]) -> Draft:
    """The draft with places and sizes from the attachments of units; of all terminals, where units
    do not hold together.
    """
    try:
        return _attempted(forms, picked, factor, along, fine=False)
    except IpmError:
        return _attempted(Forms(forms.tree), picked, factor, along, fine=True)


def _attempted(
    forms: Forms, picked: Sequence[Unit], factor: Floats, along: Sequence[int], *, fine: bool
) -> Draft:
    tree = forms.tree
    near = tolerance(tree)
    axes = _axes(forms, picked[0])
    made = divided(forms, picked, axes, along, near, fine=fine)
    system = _system(forms, made, picked, near)
    low, high = system.low.copy(), system.high.copy()
    for axis in along:
        low[:, axis], high[:, axis] = _solved(forms, system, made, picked, axis, factor[axis])
    count = len(made.units)
    at = Rebuilt(forms, made, low[:count], high[:count], near).placed()
    result = rewritten(forms, at, what="resized")
    check_sound(tree, grown(result), near)
    return result


def _axes(forms: Forms, unit: Unit) -> Floats:
    """(3, 3) the own axes of a unit, as rows."""
    own = forms.frame(unit)
    return np.asarray((linear(own)[0] / own.scale[0]).T)


def _system(forms: Forms, made: Units, picked: Sequence[Unit], near: float) -> Attached:
    """The boxes of all units, and those of selected shapes that were taken apart, which hold all
    that is below them.
    """
    low, high = made.low, made.high
    held: list[tuple[int, int]] = []
    index = {unit: k for k, unit in enumerate(made.units)}
    all_low, all_high = forms.tree.boxes(made.axes)
    extra = [unit for unit in picked if unit not in index]
    for number, unit in enumerate(extra, start=len(made.units)):
        rows = forms.tree.below(unit[1])
        low = np.vstack([low, all_low[rows].min(axis=0)])
        high = np.vstack([high, all_high[rows].max(axis=0)])
        inside = set(rows)
        held += [
            (k, number) for k, own in enumerate(made.rows) if not inside.isdisjoint(own.tolist())
        ]
    return attach(low, high, near, np.array(held, np.int64).reshape(-1, 2))


def _solved(
    forms: Forms, system: Attached, made: Units, picked: Sequence[Unit], axis: int, factor: float
) -> tuple[Floats, Floats]:
    index = {unit: k for k, unit in enumerate(made.units)}
    extra = iter(range(len(made.units), len(system)))
    boxes = [index[unit] if unit in index else next(extra) for unit in picked]
    first = boxes[0]
    count = len(system)
    faces = system.faces[:, axis]
    size = system.high[:, axis] - system.low[:, axis]
    pins = {int(faces[first]): float(system.low[first, axis])}
    pins[int(faces[first + count])] = float(system.low[first, axis] + factor * size[first])
    _ground(pins, system, made.axes, axis)
    extents = {box: factor * float(size[box]) for box in boxes[1:]}
    fixed = np.array(sorted(pins), np.int64)
    own = stretching(system, axis, fixed, boxes, extents)
    found = settle(own, np.array([pins[each] for each in fixed.tolist()]))
    if found is not None:
        return found
    old = np.array([system.low[first, axis], system.high[first, axis]])
    return warped(system, axis, old, np.array([old[0], old[0] + factor * size[first]]))


def _ground(pins: dict[int, float], system: Attached, axes: Floats, axis: int) -> None:
    """What stands on the ground stays there (the first attachment)."""
    up = float(axes[axis] @ np.array([0.0, 0.0, 1.0]))
    if abs(up) < 1 - 1e-9:
        return
    count = len(system)
    values = (system.low if up > 0 else system.high)[:, axis]
    ground = values.min() if up > 0 else values.max()
    rows = np.flatnonzero(np.abs(values - ground) <= system.tolerance)
    for face in system.faces[rows if up > 0 else rows + count, axis].tolist():
        pins.setdefault(face, float(ground))


# -------------------------------------------------------------------------------- rebuilt


@dataclass(slots=True, eq=False)
class Rebuilt:
    """Units in their new boxes: moved, stretched, split into rows of themselves, or joined."""

    forms: Forms
    made: Units
    low: Floats
    high: Floats
    near: float

    def placed(self) -> dict[Unit, list[Placed]]:
        """What stands in place of each unit that is elsewhere, or of another size."""
        before = self.made.high - self.made.low
        after = self.high - self.low
        gone = self._join(_ratios(before, after))
        self._even_out()
        ratio = _ratios(before, self.high - self.low)
        found: dict[Unit, list[Placed]] = {}
        for k, unit in enumerate(self.made.units):
            if k in gone:
                found[unit] = []
                continue
            same = np.allclose(ratio[k], 1.0, rtol=0, atol=SAME)
            if same and np.allclose(self.low[k], self.made.low[k], rtol=0, atol=SAME):
                continue
            found[unit] = [self._unit(k, unit, ratio[k])]
        return found

    def _even_out(self) -> None:
        """Parts of one kind whose sizes differ by less than what touches get one size, about their
        middles: a solution is no more exact than that, and equal parts are said once.
        """
        kinds: dict[str, list[int]] = {}
        for k, unit in enumerate(self.made.units):
            kinds.setdefault(self.forms.name(unit), []).append(k)
        for rows in kinds.values():
            for axis in range(3):
                size = (self.high - self.low)[rows, axis]
                off = 0.5 * (size - evened(size, EVEN * self.near))
                self.low[rows, axis] += off
                self.high[rows, axis] -= off

    def _unit(self, k: int, unit: Unit, ratio: Floats) -> Placed:
        """A unit after its box went from one to the other."""
        forms, axes = self.forms, self.made.axes
        own, owner = forms.frame(unit), forms.owner(unit)
        if np.allclose(ratio, 1.0, rtol=0, atol=SAME):
            shift = (self.low[k] - self.made.low[k]) @ axes
            frame = Frames(own.position + shift, own.rotation, own.hand, own.scale)
            return Placed(frame, forms.plain(unit, owner), shift)
        base = own if forms.is_square(unit, _upright(axes)) else _upright(axes)
        square = forms.is_square(unit, base)
        low, high = forms.box(unit) if square else forms.box_in(unit, base)
        turned = axes @ (linear(base)[0] / base.scale[0])
        axis = np.abs(turned).argmax(axis=0)
        corner = axes @ (linear(base)[0] @ low + base.position[0])
        moved = self.low[k] + (corner - self.made.low[k]) * ratio
        size = (high - low) * ratio[axis]
        frame = Frames((moved @ axes)[None], base.rotation, base.hand, base.scale)
        numbers = Room(self.near).precision.vector(size)
        shift = (moved - corner) @ axes
        many = [1 if forms.fills(unit) else _copies(float(each)) for each in ratio[axis]]
        if max(many) == 1:
            return Placed(frame, forms.fitted(unit, owner, numbers, base), shift)
        repeated = tuple(axis for axis in range(3) if many[axis] > 1)
        name = forms.row_rule(unit, high - low, repeated, base)
        elements = (*forms.pens(unit, owner), _call_size(numbers), ast.Module(name))
        return Placed(frame, elements, shift)

    def _join(self, ratio: Floats) -> set[int]:
        """The units that go because one beside them takes their room, too."""
        gone: set[int] = set()
        for axis in range(3):
            small = [k for k in np.flatnonzero(ratio[:, axis] < LITTLE).tolist() if k not in gone]
            for run in _runs(self.forms, self.made, small, axis):
                whole = sum(float(self.high[k, axis] - self.low[k, axis]) for k in run)
                natural = float(self.made.high[run[0], axis] - self.made.low[run[0], axis])
                if len(run) < 2 or self.forms.fills(self.made.units[run[0]]):
                    continue
                keep = max(1, min(len(run) - 1, round(whole / natural)))
                begin = float(self.low[run[0], axis])
                for place, k in enumerate(run[:keep]):
                    self.low[k, axis] = begin + place * whole / keep
                    self.high[k, axis] = begin + (place + 1) * whole / keep
                gone.update(run[keep:])
        return gone


def evened(sizes: Floats, near: float) -> Floats:
    """Sizes (n,) with those that all lie within `near` in the middle of them.

    >>> evened(np.array([3.0, 1.0, 1.0004, 2.0]), 0.001).tolist()
    [3.0, 1.0002, 1.0002, 2.0]
    """
    order = np.argsort(sizes, kind="stable")
    found = sizes.copy()
    begin = 0
    for end in range(1, len(sizes) + 1):
        if end == len(sizes) or sizes[order[end]] - sizes[order[begin]] > near:
            group = order[begin:end]
            found[group] = 0.5 * (sizes[group[0]] + sizes[group[-1]])
            begin = end
    return found


def _ratios(before: Floats, after: Floats) -> Floats:
    """How many times as large; 1 where there is no extent."""
    return np.asarray(np.where(before > 0, after / np.where(before > 0, before, 1.0), 1.0))


def _upright(axes: Floats) -> Frames:
    """The frame at the origin with these axes, rows of (3, 3)."""
    return from_matrices(np.concatenate([axes.T, np.zeros((3, 1))], axis=1)[None])


def _call_size(size: Sequence[ast.Expr]) -> ast.Module:
    return ast.Module("size", tuple(ast.Argument(each) for each in size))


def _copies(ratio: float) -> int:
    """How many copies a part becomes that is stretched so much."""
    return 1 if ratio <= LARGE else max(2, round(ratio))


def _runs(forms: Forms, made: Units, small: Sequence[int], axis: int) -> list[list[int]]:
    """Squeezed siblings of one symbol that touch along an axis, in its order."""
    across = [k for k in range(3) if k != axis]
    lanes: dict[object, list[int]] = {}
    for k in small:
        own = np.concatenate([made.low[k, across], made.high[k, across]])
        unit = made.units[k]
        lane = (forms.owner(unit), forms.name(unit), tuple(np.round(own, 6).tolist()))
        lanes.setdefault(lane, []).append(k)
    runs: list[list[int]] = []
    for found in lanes.values():
        found.sort(key=lambda k: float(made.low[k, axis]))
        for k in found:
            last = runs[-1][-1] if runs and runs[-1][0] in found else None
            if last is not None and abs(made.high[last, axis] - made.low[k, axis]) <= 1e-6:
                runs[-1].append(k)
            else:
                runs.append([k])
    return runs


__all__ = ["Rebuilt", "Wanted", "resize"]
