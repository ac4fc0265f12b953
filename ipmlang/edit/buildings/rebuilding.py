"""Parts in their new boxes: moved, stretched, split into rows of themselves, or joined.

In go units with the boxes that an edit gives them, out comes what is drawn in place of each. Parts
beyond 1.8 times their size become rows, neighbours squeezed to less than 0.4 times are joined
(section 4.1 of Demir et al. 2016). Where the boxes come from is not known here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ipmlang.compiler.diagnostics import fail
from ipmlang.edit.buildings.forms import Forms
from ipmlang.edit.buildings.measuring import Unit
from ipmlang.edit.buildings.rewriting import Placed
from ipmlang.edit.buildings.sizing import STAYS, Sizing, own_ratios, ratios
from ipmlang.edit.buildings.units import Units
from ipmlang.inverse.frames import Floats, Frames

LARGE, LITTLE = 1.8, 0.4  # times its size: beyond, a part is split, or joined (section 4.1)
MOST = 1000  # copies of a part along an axis
EVEN = 0.1  # of how near touches, by which sizes may differ and are the same
SAME = 1e-9


@dataclass(slots=True, eq=False)
class Rebuilt:
    """Units in their new boxes: moved, stretched, split into rows of themselves, or joined; neither
    of the last two unless `splits`.
    """

    forms: Forms
    made: Units
    low: Floats
    high: Floats
    near: float
    splits: bool = True
    sizing: Sizing = field(init=False)
    upright: Frames = field(init=False)

    def __post_init__(self) -> None:
        self.sizing = Sizing(self.forms, self.near)
        self.upright = self.forms.measured.upright(self.made.axes)

    def placed(self) -> dict[Unit, list[Placed]]:
        """What stands in place of each unit that is elsewhere, or of another size."""
        made, same = self.made, STAYS * self.near
        before = made.high - made.low
        gone = self._join(ratios(before, self.high - self.low, same))
        self._even_out()
        ratio = ratios(before, self.high - self.low, same)
        low, high = np.abs(self.low - made.low), np.abs(self.high - made.high)
        moved = (np.maximum(low, high).max(axis=1, initial=0.0) > same).tolist()
        return {
            unit: [] if k in gone else [self._unit(k, unit, ratio[k])]
            for k, unit in enumerate(made.units)
            if k in gone or moved[k]
        }

    def _even_out(self) -> None:
        """Parts of one kind that got sizes which differ by less than what touches get one, about
        their middles: a solution is no more exact than that, and equal parts are said once.
        """
        kinds: dict[str, list[int]] = {}
        for k, unit in enumerate(self.made.units):
            kinds.setdefault(self.forms.measured.name(unit), []).append(k)
        more = (self.high - self.low) - (self.made.high - self.made.low)
        for axis, grown in enumerate((np.abs(more) > STAYS * self.near).T.tolist()):
            for every in kinds.values():
                rows = [k for k in every if grown[k]]
                if not rows:
                    continue
                size = (self.high - self.low)[rows, axis]
                off = 0.5 * (size - evened(size, EVEN * self.near))
                self.low[rows, axis] += off
                self.high[rows, axis] -= off

    def _unit(self, k: int, unit: Unit, ratio: Floats) -> Placed:
        """A unit after its box went from one to the other."""
        forms, measured, axes = self.forms, self.forms.measured, self.made.axes
        own, owner = measured.frame(unit), measured.owner(unit)
        if (ratio == 1).all():
            shift = (self.low[k] - self.made.low[k]) @ axes
            frame = Frames(own.position + shift, own.rotation, own.hand, own.scale)
            return Placed(frame, forms.plain(unit, owner), shift)
        along = np.flatnonzero(ratio != 1).tolist()
        square = measured.is_square(unit, self.upright, along)
        base = own if square else self.upright
        low, high = measured.box(unit) if square else measured.box_in(unit, base)
        grown = own_ratios(measured.turned(unit, self.upright), ratio) if square else ratio
        corner = axes @ (measured.maps(base).out @ low + base.position[0])
        moved = self.low[k] + (corner - self.made.low[k]) * ratio
        size = (high - low) * grown
        frame = Frames((moved @ axes)[None], base.rotation, base.hand, base.scale)
        shift = (moved - corner) @ axes
        grown = grown * np.minimum(1.0, measured.stretched(unit))
        stays = measured.fills(unit) or not self.splits
        many = [1 if stays else copies(each) for each in grown.tolist()]
        if max(many) > MOST:
            often = f"{max(many):,}" if max(many) < 10**6 else "over a million"
            what = f"`{measured.name(unit)}` would stand there {often} times"
            raise fail("bad-command", what, hint="choose a smaller size")
        if max(many) == 1:
            sized, elements = self.sizing.placed(unit, owner, size, frame, base)
            if sized is not frame:
                shift = sized.position[0] - own.position[0]
            return Placed(sized, elements, shift)
        repeated = tuple(axis for axis in range(3) if many[axis] > 1)
        elements = self.sizing.row(unit, owner, size, high - low, repeated, base)
        return Placed(frame, elements, shift)

    def _join(self, ratio: Floats) -> set[int]:
        """The units that go because one beside them takes their room, too."""
        gone: set[int] = set()
        for axis in range(3 if self.splits else 0):
            small = [k for k in np.flatnonzero(ratio[:, axis] < LITTLE).tolist() if k not in gone]
            for run in _runs(self.forms, self.made, small, axis):
                whole = sum(float(self.high[k, axis] - self.low[k, axis]) for k in run)
                natural = float(self.made.high[run[0], axis] - self.made.low[run[0], axis])
                if len(run) < 2 or self.forms.measured.fills(self.made.units[run[0]]):
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


def copies(ratio: float) -> int:
    """How many copies a part becomes that is stretched so much."""
    return 1 if ratio <= LARGE else max(2, round(ratio))


def _runs(forms: Forms, made: Units, small: Sequence[int], axis: int) -> list[list[int]]:
    """Squeezed siblings of one symbol that touch along an axis, in its order."""
    across = [k for k in range(3) if k != axis]
    lanes: dict[object, list[int]] = {}
    for k in small:
        own = np.concatenate([made.low[k, across], made.high[k, across]])
        unit = made.units[k]
        lane = (
            forms.measured.owner(unit),
            forms.measured.name(unit),
            tuple(np.round(own, 6).tolist()),
        )
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
