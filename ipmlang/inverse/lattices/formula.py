"""A lattice as a rule would say it: formulas in the index with numbers that a person would write,
holes, and what is left over for each copy.

Takes a lattice that was found among placements of one symbol; gives the formula with rounded
numbers, the frames that it predicts and the residual of each member. Nothing here prints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

import numpy as np

from ipmlang.inverse.lattices.build import Lattice
from ipmlang.inverse.lattices.models import Model
from ipmlang.inverse.lattices.nets import Net
from ipmlang.inverse.lattices.rings import Rings
from ipmlang.inverse.lsystem.frames import (
    Floats,
    Frames,
    compose,
    frames,
    identity,
    inverse,
    join,
    unit,
    wrap,
)
from ipmlang.inverse.lsystem.symbols import Integers

Radial: TypeAlias = Literal["even", "root", "power"]
RADIAL: dict[str, Radial] = {"vogel": "root", "log": "power"}
OFF = 0.25  # of the tolerance: what is off by more has a residual
SHARE = 0.3  # of a usual residual: what rounding a number may add to it
COLUMNS = ("x", "y", "angle", "scale")
MOST_DIGITS, FEW_DIGITS = 9, 3  # decimals are fewer than those; they usually are fewer than these


@dataclass(frozen=True, slots=True, eq=False)
class Formula:
    """Frames at nodes k = 0 … count - 1, in the world.

    across: members of a line, 0 for a row: node k has i = k mod across, j = floor(k / across), else
    i = k; lead: (1,) frame before all; moves: (2, 3) coefficients of x and y in (i, j, i²), None if
    polar: coefficients of the turn in (i, j), and two of the radius in i, or j if `nested`, see
    `radial`; upright: the turn is taken back; turn, growth: (2,) coefficients of angle and scale in
    (i, j), of the logarithm of the scale if `geometric`; inside: (1,) what all members are turned,
    sized and moved by at the end; stagger: how far every second line is moved along i.
    """

    count: int
    across: int
    lead: Frames
    moves: Floats | None
    polar: Floats | None
    turn: Floats
    growth: Floats
    radial: Radial = "even"
    nested: bool = False
    upright: bool = False
    geometric: bool = False
    stagger: float = 0.0
    inside: Frames = field(default_factory=lambda: identity(1))

    @property
    def length(self) -> int:
        """Members of a line."""
        return self.across or self.count

    @property
    def turned_by(self) -> float:
        """Degrees about the centre from one member to the next, 0 in straight lines."""
        return 0.0 if self.polar is None else float(self.polar[0])

    @property
    def line(self) -> str:
        """What a straight line of members is called."""
        if self.moves is not None and abs(self.moves[0, 0]) < abs(self.moves[1, 0]):
            return "column"
        return "row"

    @property
    def steps(self) -> tuple[float, float]:
        """From one member and from one line to the next, 0 where it is not along x or y."""
        plain = self.moves is not None and not self.stagger and not self.moves[:, 2].any()
        if not plain or self.moves is None:
            return 0.0, 0.0
        x, y = (float(each.sum()) * (np.count_nonzero(each) == 1) for each in self.moves.T[:2])
        return x, y

    def frames(self) -> Frames:
        """(count,) world frames."""
        return frames_at([self], np.arange(self.count)).flat()


def frames_at(formulas: Sequence[Formula], node: Integers) -> Frames:
    """(f, m) world frames at nodes (m,) of formulas that differ in their numbers only."""
    one, k = formulas[0], node.astype(np.float64)
    i, j = (k % one.across, k // one.across) if one.across else (k, np.zeros(len(k)))
    turn = _stacked([each.turn for each in formulas])
    growth = _stacked([each.growth for each in formulas])
    angle = turn[0] * i + turn[1] * j
    grown = growth[0] * i + growth[1] * j
    scale = np.exp(grown) if one.geometric else 1 + grown
    if one.polar is None:
        moves = _stacked([np.ravel(each.moves) for each in formulas if each.moves is not None])
        basis = (i + one.stagger * (j % 2), j, i * i)
        x, y = (sum(a * b for a, b in zip(side, basis, strict=True)) for side in np.split(moves, 2))
        at = x + 1j * y
    else:
        polar = _stacked([each.polar for each in formulas if each.polar is not None])
        around = polar[0] * i + polar[1] * j
        at = _radii(one, polar[2], polar[3], j if one.nested else i) * unit(around)
        angle = angle + (0.0 if one.upright else around)
    lead = join([each.lead for each in formulas])
    inside = join([each.inside for each in formulas])
    return compose(compose(lead[:, None], frames(at, angle, scale)), inside[:, None])


def _stacked(numbers: Sequence[Floats]) -> Floats:
    """(k, f, 1) numbers (k,) of f formulas."""
    return np.stack(numbers, axis=1)[:, :, None]


def _radii(kind: Formula, first: Floats, second: Floats, index: Floats) -> Floats:
    """(f, m) distances from the centre."""
    if kind.radial == "root":
        return np.asarray(first * np.sqrt(np.maximum(index + second, 0.0)))
    if kind.radial == "power":
        return np.asarray(first * np.exp(second * index))
    return np.asarray(first + second * index)


@dataclass(frozen=True, slots=True, eq=False)
class LatticeRule:
    """`part` at the nodes of a formula. holes: nodes without a member; rows: (m,) members' rows by
    node; residual: (count,) frames inside the predicted ones; columns: which of `COLUMNS` of them
    are not nothing; ranks: (count,) paint order, -1 at holes; kind: as of the lattice.
    """

    part: int
    formula: Formula
    holes: tuple[int, ...]
    rows: Integers
    residual: Frames
    columns: tuple[str, ...]
    ranks: Integers
    kind: str

    def of(self, rows: Integers) -> LatticeRule:
        """The same rule, its members named by other rows (m,)."""
        return replace(self, rows=rows)

    @property
    def drawn(self) -> Integers:
        """(m,) ranks of the members, by node."""
        return self.ranks[self.ranks >= 0]


def lattice_rule(
    part: int, lattice: Lattice, ranks: Integers, radius: float, tolerance: float
) -> LatticeRule | None:
    """The rule of a lattice, None where no formula here says it.

    ranks: of all rows that `lattice.rows` may name; radius: extent of the symbol; tolerance: units.
    """
    if lattice.handedness.kind == "arbitrary" or len(np.unique(lattice.chosen.handedness)) > 1:
        return None
    made = fitted_formula(lattice)
    if made is None:
        return None
    formula, node = made
    order = np.argsort(node)
    node, rows = node[order], lattice.rows[order]
    chosen = lattice.chosen[order]
    # What is missing at the end needs no holes: the loop ends before.
    formula = replace(formula, count=int(node[-1]) + 1)
    formula = _rounded(formula, node, chosen, radius, tolerance)
    predicted = formula.frames()
    inside = compose(inverse(predicted[node]), chosen)
    columns = tuple(_needed(inside, chosen.scale, radius, tolerance))
    full = {name: np.zeros(formula.count) for name in COLUMNS} | {"scale": np.ones(formula.count)}
    for name in columns:
        full[name][node] = getattr(inside, name)
    residual = frames(full["x"] + 1j * full["y"], full["angle"], full["scale"])
    ranked = np.full(formula.count, -1, np.int64)
    ranked[node] = ranks[rows]
    holes = tuple(sorted(set(range(formula.count)) - set(node.tolist())))
    return LatticeRule(part, formula, holes, rows, residual, columns, ranked, lattice.kind)


def _needed(inside: Frames, scale: Floats, radius: float, tolerance: float) -> list[str]:
    """The columns in which some member is off."""
    reach = radius * scale
    worst = (
        ("x", np.abs(inside.x) * scale),
        ("y", np.abs(inside.y) * scale),
        ("angle", np.deg2rad(np.abs(inside.angle)) * reach),
        ("scale", np.abs(inside.scale - 1) * reach),
    )
    return [name for name, gap in worst if float(gap.max()) > OFF * tolerance]


# ----------------------------------------------------------------------- formulas


def fitted_formula(lattice: Lattice) -> tuple[Formula, Integers] | None:
    """The formula as fitted, and the node of each member."""
    place = lattice.place
    if isinstance(place, Net):
        made, node = _of_net(lattice, place)
    elif isinstance(place, Rings):
        made, node = _of_rings(lattice, place)
    elif place.straight:
        made, node = _of_line(lattice, place)
    else:
        made, node = _of_spiral(lattice, place)
    if int(node.min()) < 0 or len(np.unique(node)) < len(node):
        return None
    made = replace(made, geometric=lattice.scale.kind == "regular" and lattice.scale.geometric)
    return replace(made, inside=_common(made, node, lattice)), node


def _common(formula: Formula, node: Integers, lattice: Lattice) -> Frames:
    """The frame that members have in common inside of what the formula predicts."""
    each = compose(inverse(formula.frames()[node]), lattice.chosen)
    middle = complex(np.median(each.x), np.median(each.y))
    turn = each.angle[0] + float(np.median(wrap(each.angle - each.angle[0])))
    even = lattice.angle.kind == "regular", lattice.scale.kind == "regular"
    size = float(np.median(each.scale)) if even[1] else 1.0
    return frames(np.array([middle]), turn if even[0] else 0.0, size)


def _lead(lattice: Lattice, at: complex, angle: float = 0.0) -> tuple[Frames, int]:
    """The frame before all, and its handedness; angle: the world's, of local +x."""
    hand = int(lattice.chosen.handedness[0])
    # In a mirrored frame x points the other way.
    return frames(np.array([at]), angle if hand > 0 else angle - 180.0, 1.0, hand), hand


def _changes(lattice: Lattice) -> tuple[Floats, Floats]:
    """How angle and scale change with (i, j), the latter as a share of the first, or its logarithm
    where it is geometric.
    """
    turn, growth = np.zeros(2), np.zeros(2)
    if lattice.angle.kind == "regular" and not lattice.angle.geometric:
        turn = np.array(lattice.angle.terms[1:3])
    if lattice.scale.kind == "regular":
        first = 1.0 if lattice.scale.geometric else lattice.scale.terms[0]
        growth = np.array(lattice.scale.terms[1:3]) / first
    return turn, growth


def _of_net(lattice: Lattice, net: Net) -> tuple[Formula, Integers]:
    turn, growth = _changes(lattice)
    (columns, lines), (i, j), steps = net.shape, lattice.index.T, (net.u, net.v)
    if lattice.order_kind == "column-major" and not net.stagger:
        i, j, columns, lines, steps = j, i, lines, columns, steps[::-1]
        turn, growth = turn[::-1], growth[::-1]
    lead, hand = _lead(lattice, net.origin)
    local = [step / complex(lead.factor[0]) for step in steps]
    moves = np.array(
        [[each.real * hand for each in local] + [0.0], [each.imag for each in local] + [0.0]]
    )
    made = Formula(
        columns * lines, columns, lead, moves, None, turn * hand, growth, stagger=net.stagger
    )
    return made, i + columns * j


def _of_line(lattice: Lattice, model: Model) -> tuple[Formula, Integers]:
    turn, growth = _changes(lattice)
    node, known = lattice.index.reshape(-1), model.numbers
    lead, hand = _lead(lattice, complex(known[0], known[1]))
    bend = complex(known[4], known[5]) if len(known) > 4 else 0j
    factor = complex(lead.factor[0])
    step, bend = complex(known[2], known[3]) / factor, bend / factor
    moves = np.array([[step.real * hand, 0.0, bend.real * hand], [step.imag, 0.0, bend.imag]])
    return Formula(int(node.max()) + 1, 0, lead, moves, None, turn * hand, growth), node


def _along(lattice: Lattice, step: float) -> bool:
    """Whether members turn with the lattice, by so many degrees from i to i + 1."""
    turn = _changes(lattice)[0][0]
    return bool(
        lattice.angle.kind == "regular" and abs(wrap(np.array(turn - step))) < abs(step) / 8
    )


def _of_spiral(lattice: Lattice, model: Model) -> tuple[Formula, Integers]:
    turn, growth = _changes(lattice)
    node, known = lattice.index.reshape(-1), model.numbers
    step = float(np.rad2deg(known[3]))
    lead, hand = _lead(lattice, complex(known[0], known[1]), float(np.rad2deg(known[2])))
    along = _along(lattice, step)
    polar = np.array([step * hand, 0.0, known[4], known[5] if len(known) > 5 else 0.0])
    radial = RADIAL.get(model.kind, "even")
    made = Formula(
        int(node.max()) + 1,
        0,
        lead,
        None,
        polar,
        np.zeros(2) if along else turn * hand,
        growth,
        radial,
        upright=not along,
    )
    return made, node


def _of_rings(lattice: Lattice, rings: Rings) -> tuple[Formula, Integers]:
    turn, growth = _changes(lattice)
    i, j = lattice.index.T
    around = rings.closed or int(i.max()) + 1
    step, twist = float(np.rad2deg(rings.step)), float(np.rad2deg(rings.twist))
    lead, hand = _lead(lattice, rings.centre, float(np.rad2deg(rings.phase)))
    along = _along(lattice, step)
    made = Formula(
        around * (int(j.max()) + 1),
        around,
        lead,
        None,
        np.array([step * hand, twist * hand, rings.radius, rings.growth]),
        np.zeros(2) if along else turn * hand,
        growth,
        nested=True,
        upright=not along,
    )
    return made, i % around + around * j


# ----------------------------------------------------------------------- rounding


def _rounded(
    formula: Formula, node: Integers, chosen: Frames, radius: float, tolerance: float
) -> Formula:
    """The same with as few decimals as cost next to nothing in precision: steps before places."""
    gap = _gaps([formula], node, chosen, radius)[0]
    for rounding in (_round_moves, _round_polar, _round_changes, _round_inside, _round_lead):
        room = np.maximum(tolerance / 8, (1 + SHARE) * gap)
        if rounding(formula, 0) is formula:
            continue
        for digits in (range(FEW_DIGITS), range(FEW_DIGITS, MOST_DIGITS)):
            ways = [rounding(formula, each) for each in digits]
            off = _gaps(ways, node, chosen, radius)
            good = np.flatnonzero((off <= room).all(axis=1))
            if len(good):
                formula, gap = ways[good[0]], off[good[0]]
                break
    return formula


def _round_moves(formula: Formula, digits: int) -> Formula:
    if formula.moves is None:
        return formula
    return replace(formula, moves=np.round(formula.moves, digits) + 0.0)


def _round_polar(formula: Formula, digits: int) -> Formula:
    if formula.polar is None:
        return formula
    return replace(formula, polar=np.round(formula.polar, digits) + 0.0)


def _round_changes(formula: Formula, digits: int) -> Formula:
    turn, growth = np.round(formula.turn, digits) + 0.0, np.round(formula.growth, digits + 2) + 0.0
    return replace(formula, turn=turn, growth=growth)


def _round_inside(formula: Formula, digits: int) -> Formula:
    inside = formula.inside
    at, angle = np.round(inside.position, digits), np.round(inside.angle, digits) + 0.0
    return replace(formula, inside=frames(at, angle, np.round(inside.scale, digits + 2)))


def _round_lead(formula: Formula, digits: int) -> Formula:
    lead = formula.lead
    at, angle = np.round(lead.position, digits), np.round(lead.angle, digits) + 0.0
    return replace(formula, lead=frames(at, angle, 1.0, lead.handedness))


def _gaps(formulas: Sequence[Formula], node: Integers, chosen: Frames, radius: float) -> Floats:
    """(f, 6) usual and largest distance of members from their nodes, and of what lies `radius` from
    their middles by their angle and by their scale, units; the formulas differ in numbers only.
    """
    made = np.full((len(formulas), 6), np.inf)
    sized = [k for k, each in enumerate(formulas) if each.inside.scale[0] > 0]
    if not sized:
        return made
    off = compose(inverse(frames_at([formulas[k] for k in sized], node)), chosen)
    reach = radius * chosen.scale
    gaps = np.stack(
        [
            np.abs(off.position) * chosen.scale / off.scale,
            np.deg2rad(np.abs(wrap(off.angle))) * reach,
            np.abs(off.scale - 1) * reach,
        ]
    )
    made[sized] = np.concatenate([np.sqrt(np.mean(gaps**2, axis=2)), gaps.max(axis=2)]).T
    return made
