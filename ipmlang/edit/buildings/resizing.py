"""Structure-preserving resize: what is selected gets a size, the rest stays attached.

In goes a draft, out comes a draft in which the shape has that size and all that touched still does.
The grammar's own parameters are tried first; else the attachments of all parts are solved (section
4.1 of Demir et al. 2016) and written back. Parts that would be stretched to more than 1.8 times
become rows of themselves, neighbours squeezed to less than 0.4 times are joined.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from ipmlang.compiler import ast, collector
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, fail
from ipmlang.edit.arithmetic import scaled
from ipmlang.edit.buildings.attachments import Attached, attach, settle, stretching, warped
from ipmlang.edit.buildings.deciding import Key
from ipmlang.edit.buildings.driving import Aim, counted, driven
from ipmlang.edit.buildings.forms import Forms
from ipmlang.edit.buildings.growing import grown
from ipmlang.edit.buildings.measuring import Unit, measured
from ipmlang.edit.buildings.rebuilding import MOST, Rebuilt, copies
from ipmlang.edit.buildings.repeating import can_stand_on, repeated
from ipmlang.edit.buildings.rewriting import Placed, rewritten
from ipmlang.edit.buildings.soundness import check_sound, follows
from ipmlang.edit.buildings.tree import Tree
from ipmlang.edit.buildings.units import Units, divided, is_whole, selected, tolerance, whole
from ipmlang.edit.draft import Draft
from ipmlang.inverse.frames import Floats, Frames, linear

SMALLEST = 10  # times how near touches, that something is at least
SAME = 1e-9
LARGEST = 1e12  # what a size or a factor is below
UP = np.array([0.0, 0.0, 1.0])


Way: TypeAlias = Literal["shares", "units", "terminals"]
"""Everything keeps its shares of the whole; or the attachments of units, or of all terminals, are
solved."""


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
            if not 0 < each < LARGEST:
                message = f"nothing can be made {each:g} large: a size is above 0"
                message += "" if each <= 0 else f" and below {LARGEST:g}"
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


def _with_lot(draft: Draft, tree: Tree, unit: Unit, factor: Floats) -> Draft:
    """The draft of a whole that is so many times as large with a lot that follows, which no rule
    asks about.
    """
    if not is_whole(tree, unit) or measured(tree).reads_lot():
        return draft
    if np.abs(_axes(tree, unit) - np.eye(3)).max() > SAME:
        return draft
    items = dict(enumerate(draft.grammar.items))
    for number, item in items.items():
        if isinstance(item, ast.Start) and item.place is not None and item.place.kind == "box":
            args = tuple(map(scaled, item.place.args, factor.tolist()))
            items[number] = replace(item, place=replace(item.place, args=args))
    return replace(draft, grammar=replace(draft.grammar, items=tuple(items.values())))


@collector.held()
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
    for axis in wanted.along:
        if aim[axis] < SMALLEST * tolerance(tree):
            message = f"`{select}` would be {aim[axis]:g} along its {'xyz'[axis]}: nothing is left"
            raise fail("bad-command", message, hint=f"it is {size[axis]:g} now")
    if parameters:
        others = [] if number is None else [each for each in every if each not in picked]
        keys = [[_key(forms, unit) for unit in units] for units in (picked, others)]
        meant = Aim(keys[0], keys[1], aim, wanted.along)
        found = driven(tree, meant)
        if found is not None:
            return found
        forms.tree = tree.of(_told(draft, meant.refused))
    factor = aim / np.where(size > 0, size, 1.0)
    if parameters and is_whole(tree, picked[0]):
        found = _by_counts(forms, picked, meant, factor, seed)
        if found is not None:
            return found
    made = _stretched(forms, picked, factor, wanted.along)
    return _with_lot(made, tree, picked[0], factor)


def _by_counts(
    forms: Forms, picked: Sequence[Unit], meant: Aim, factor: Floats, seed: int
) -> Draft | None:
    """The draft of a whole with more or fewer of what an attribute counts in it, and the rest
    stretched; None where no attribute does it, or it would stand there several times all the same.
    """
    often = _repeats(forms, picked[0], factor)
    draft: Draft | None = None
    for axis in meant.along:
        tree = forms.tree if draft is None else grown(draft, seed=seed)
        found = counted(tree, meant, axis, rest=often[axis] > 1)
        if found is None and often[axis] > 1:
            return None
        draft = draft if found is None else found
    if draft is None:
        return None
    x, y, z = (float(meant.size[k]) if k in meant.along else None for k in range(3))
    with suppress(IpmError):  # nothing is left to do where the lot has taken the rest
        return resize(draft, None, Wanted(x, y, z), seed=seed, parameters=False)
    return None


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
    size = forms.measured.extent(found[0])
    for axis in wanted.along:
        if size[axis] <= SAME:
            hint = f"it is {size[0]:g} x {size[1]:g} x {size[2]:g} along its own axes"
            message = f"`{name}` has no extent along its {'xyz'[axis]}"
            raise fail("nothing-selected", message, hint=hint)
    along = wanted.along
    sizes = [forms.measured.extent(unit)[along] for unit in found]
    same = np.flatnonzero(np.all(np.isclose(sizes, size[along], rtol=1e-6), axis=1))
    return [found[k] for k in same.tolist()], size


def _key(forms: Forms, unit: Unit) -> Key:
    """What a unit is found by in another derivation."""
    kind, row = unit
    keys = forms.tree.lineage.key if kind == "shape" else forms.tree.scene.instances.key
    return kind, int(keys[row])


# ------------------------------------------------------------------------------ stretching


def _stretched(forms: Forms, picked: Sequence[Unit], factor: Floats, along: Sequence[int]) -> Draft:
    """The draft with places and sizes from the attachments of units; of all terminals, where units
    do not hold together. A whole that is stretched too far stands there several times.
    """
    if is_whole(forms.tree, picked[0]) and np.ptp(factor) <= SAME:
        return _scaled(forms, picked[0], float(factor[0]))
    often = _repeats(forms, picked[0], factor)
    if max(often) > 1:
        return _repeated(forms, picked, factor / often, along, often)
    ways: list[Way] = ["shares", "units"] if _is_model(forms, picked[0]) else ["units"]
    for way in ways:
        with suppress(IpmError):
            return _attempted(Forms(forms.tree), picked, factor, along, way)
    return _attempted(Forms(forms.tree), picked, factor, along, "terminals")


def _scaled(forms: Forms, unit: Unit, factor: float) -> Draft:
    """The draft with a whole that is so many times as large along all axes, from its low corner."""
    own = forms.measured.frame(unit)
    low, _ = forms.measured.box_in(unit, own)
    corner = forms.measured.maps(own).out @ low
    frame = Frames(own.position + (1 - factor) * corner, own.rotation, own.hand, own.scale * factor)
    elements = forms.plain(unit, forms.measured.owner(unit))
    return grown(
        rewritten(forms, {unit: [Placed(frame, elements)]}, what=f"{factor:g} times")
    ).draft


def _repeats(forms: Forms, unit: Unit, factor: Floats) -> list[int]:
    """How often (3,) a whole building stands there that is to be so many times as large (3,): once,
    where it was made smaller before, or would have to stand on what is no floor.
    """
    if not _is_model(forms, unit):
        return [1, 1, 1]
    before = forms.measured.stretches(unit)
    usual = np.median(before, axis=0) if before else np.ones(3)
    often = [copies(each) for each in (factor * np.minimum(1.0, usual)).tolist()]
    if max(often) > MOST:
        message = f"`{forms.measured.name(unit)}` would stand there {max(often):,} times"
        raise fail("bad-command", message, hint="choose a smaller size")
    up = int(np.abs(_axes(forms.tree, unit) @ UP).argmax())
    if often[up] > 1 and not can_stand_on(forms, unit):
        often[up] = 1
    return often


def _is_model(forms: Forms, unit: Unit) -> bool:
    """Whether a unit is a whole building all of whose parts are read from files: such parts keep
    their shares of it, as openings in one would not fit rows of another.
    """
    return is_whole(forms.tree, unit) and forms.measured.is_of_assets(unit)


def _repeated(
    forms: Forms, picked: Sequence[Unit], factor: Floats, along: Sequence[int], often: list[int]
) -> Draft:
    """The draft with a whole that is so many times as large as often as said along each axis."""
    tree, symbol = forms.tree, forms.measured.name(picked[0])
    made = tree.draft
    rest = [axis for axis in along if abs(factor[axis] - 1) > SAME]
    if rest:
        one = np.where(np.isin(np.arange(3), rest), factor, 1.0)
        made = _stretched(forms, picked, one, rest)
    for axis, count in enumerate(often):
        if count > 1:
            made = repeated(made, symbol, axis, count)
            symbol = whole(grown(made))
    after = grown(made)
    check_sound(tree, after, tolerance(tree))
    return after.draft


def _attempted(
    forms: Forms, picked: Sequence[Unit], factor: Floats, along: Sequence[int], way: Way
) -> Draft:
    tree = forms.tree
    near = tolerance(tree)
    axes = _axes(tree, picked[0])
    made = divided(forms, picked, axes, along, near, fine=way == "terminals")
    system = _system(forms, made, picked, near)
    low, high = system.low.copy(), system.high.copy()
    for axis in along:
        low[:, axis], high[:, axis] = (
            _warped(system, _boxes(system, made, picked)[0], axis, factor[axis])
            if way == "shares"
            else _solved(system, made, picked, axis, factor[axis])
        )
    count = len(made.units)
    splits = not _is_model(forms, picked[0])
    at = Rebuilt(forms, made, low[:count], high[:count], near, splits).placed()
    result = rewritten(forms, at, what="resized")
    after = grown(result, like=tree)
    for axis in along:
        size = float(np.ptp(np.concatenate([made.low, made.high])[:, axis]))
        _check_followed(tree, after, picked, axes, axis, (factor[axis] - 1) * size)
    check_sound(tree, after, near)
    return after.draft


def _check_followed(
    before: Tree, after: Tree, picked: Sequence[Unit], axes: Floats, axis: int, wanted: float
) -> None:
    """Raises IpmError where a whole that is selected is not drawn larger by what is wanted: a rule
    that asks how large its scope is need not fill it.
    """
    row = picked[0][1]
    if is_whole(before, picked[0]) and not follows(before, after, axes, axis, wanted):
        message = f"`{before.names[row]}` does not follow along its {'xyz'[axis]}"
        hint = "its rules say otherwise how large it is: ipmlang edit set"
        raise fail("cannot-edit-there", message, hint=hint)


def _axes(tree: Tree, unit: Unit) -> Floats:
    """(3, 3) the own axes of a unit, as rows."""
    own = measured(tree).frame(unit)
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


def _boxes(system: Attached, made: Units, picked: Sequence[Unit]) -> list[int]:
    """The numbers of the boxes of what is selected."""
    index = {unit: k for k, unit in enumerate(made.units)}
    extra = iter(range(len(made.units), len(system)))
    return [index[unit] if unit in index else next(extra) for unit in picked]


def _warped(system: Attached, box: int, axis: int, factor: float) -> tuple[Floats, Floats]:
    """All boxes where one is so many times as large: what lies within it keeps its shares."""
    low, high = float(system.low[box, axis]), float(system.high[box, axis])
    new = np.array([low, low + factor * (high - low)])
    return warped(system, axis, np.array([low, high]), new)


def _solved(
    system: Attached, made: Units, picked: Sequence[Unit], axis: int, factor: float
) -> tuple[Floats, Floats]:
    boxes = _boxes(system, made, picked)
    first, count = boxes[0], len(system)
    if _is_all(system, first, axis, factor):
        return _warped(system, first, axis, factor)
    faces = system.faces[:, axis]
    low, high, off = system.low[:, axis], system.high[:, axis], system.off[:, axis]
    size = high - low
    old = np.array([low[first], high[first]])
    new = np.array([old[0], old[0] + factor * size[first]])
    pins = {int(faces[first]): float(new[0] - off[first])}
    pins[int(faces[first + count])] = float(new[1] - off[first + count])
    _ground(pins, system, made.axes, axis)
    extents = {
        box: factor * float(size[box]) - float(off[box + count] - off[box]) for box in boxes[1:]
    }
    fixed = np.array(sorted(pins), np.int64)
    own = stretching(system, axis, fixed, boxes, extents)
    found = settle(own, np.array([pins[each] for each in fixed.tolist()]))
    return _warped(system, first, axis, factor) if found is None else found


def _is_all(system: Attached, first: int, axis: int, factor: float) -> bool:
    """Whether everything lies within one box, so that it all keeps its shares of that; and what
    touches is not taken apart by what is between.
    """
    low, high = system.low[:, axis], system.high[:, axis]
    within = low.min() >= low[first] - system.tolerance
    within &= high.max() <= high[first] + system.tolerance
    between = 2 * float(np.abs(system.off[:, axis]).max())
    return bool(within) and between * max(factor, 1.0) <= system.tolerance


def _ground(pins: dict[int, float], system: Attached, axes: Floats, axis: int) -> None:
    """What stands on the ground stays there (the first attachment)."""
    up = float(axes[axis] @ np.array([0.0, 0.0, 1.0]))
    if abs(up) < 1 - 1e-9:
        return
    count = len(system)
    places = np.concatenate([system.low, system.high])[:, axis]
    values = places[:count] if up > 0 else places[count:]
    ground = values.min() if up > 0 else values.max()
    rows = np.flatnonzero(np.abs(values - ground) <= system.tolerance)
    for row in (rows if up > 0 else rows + count).tolist():
        face = int(system.faces[row, axis])
        pins.setdefault(face, float(places[row] - system.off[row, axis]))


__all__ = ["Wanted", "resize"]
