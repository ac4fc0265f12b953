"""From points on a lattice to frames on it: columns, paint order, holes and residuals.

Takes chains, grids and sets of rings found among the positions of instances of one symbol; gives
lattices that predict whole frames. Instances whose angle or scale breaks the rule that nearly all
follow are left out, so they become holes. Nothing here searches for positions.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from ipmlang.inverse.lattices.chains import Chain, closed, few_holes
from ipmlang.inverse.lattices.cloud import Integers
from ipmlang.inverse.lattices.columns import Column, Columns, Slack, fit_columns
from ipmlang.inverse.lattices.models import GROWTH, TURN, Model, at, fit, renumbered
from ipmlang.inverse.lattices.nets import Net, net_at, turned
from ipmlang.inverse.lattices.order import OrderKind, across, along
from ipmlang.inverse.lattices.rings import Rings, ring_order, rings_at, wound
from ipmlang.inverse.lsystem.frames import Complexes, Floats, Frames, frames, mirrored, wrap

LatticeKind: TypeAlias = Literal["row", "ring", "spiral", "grid", "nest"]
Place: TypeAlias = Model | Net | Rings
TURNED = 1e-3  # radians, and share of its size, that what is exact may be off
WIDEST = 3.0  # degrees that an angle may be off with noise
TALLEST = 0.05  # share that a scale may be off with noise
FEW = 5  # members below which every column must follow a rule
SURE = 8  # members below which angle or scale must follow a rule where places are noisy
FAITHFUL = 0.5  # share by which a fitted step may differ from that of the members themselves
LOOSER = 1.5  # times as far off members may be with the latter
TIDY: tuple[OrderKind, ...] = ("row-major", "column-major", "boustrophedon", "column-boustrophedon")


@dataclass(frozen=True, slots=True, eq=False)
class Instances:
    """All instances of one symbol. placed: (n,) world frames; stabiliser: frames that keep the
    symbol, `free`: so does any turn; radius: its extent at scale 1; anchor: the local point that
    all of these keep; order: (n,) paint ranks; exact: units; loose: share of the step; turned:
    radians, and share of the size, that exact ones may be off however small they are.
    """

    placed: Frames
    stabiliser: Frames
    free: bool
    radius: float
    anchor: complex
    order: Integers
    exact: float
    loose: float
    turned: float = TURNED


@dataclass(frozen=True, slots=True, eq=False)
class Lattice:
    """A regular arrangement of instances of one symbol.

    place: how positions follow from the node; anchor: the point of the symbol that lies there;
    angle, scale, handedness: how these follow; index: (m,) or (m, 2) node of each member from 0;
    rows: (m,) instances; chosen: (m,) their frames, of all equivalent ones the nearest to the rule;
    holes: (h,) or (h, 2) nodes without a member; residual: (m, 4) dx, dy (units, of the anchor),
    dangle (degrees), dscale: what is observed minus what is predicted; exact: it is nothing where
    a column has a rule; order_kind, stride: how the paint order runs, 0 for no constant stride;
    gain: tokens saved, roughly.
    """

    kind: LatticeKind
    place: Place
    anchor: complex
    angle: Column
    scale: Column
    handedness: Column
    index: Integers
    rows: Integers
    chosen: Frames
    holes: Integers
    residual: Floats
    exact: bool
    order_kind: OrderKind
    stride: int
    gain: float

    def __len__(self) -> int:
        return len(self.rows)

    def positions(self, index: Integers) -> Complexes:
        """Places (k,) of the anchor at nodes (k,) or (k, 2)."""
        return positions(self.place, index)

    def frames(self, index: Integers) -> Frames:
        """Predicted frames (k,) at nodes (k,) or (k, 2)."""
        nodes = flat(index)
        made = frames(
            np.zeros(len(nodes), np.complex128),
            self.angle.at(nodes),
            self.scale.at(nodes),
            np.where(self.handedness.at(nodes) < 0, -1, 1).astype(np.int8),
        )
        corner = self.positions(index) - made.factor * mirrored(self.anchor, made.handedness)
        return frames(corner, made.angle, made.scale, made.handedness)

    @property
    def base(self) -> Frames:
        """(1,) the predicted frame of the first node."""
        return self.frames(np.zeros((1, *self.index.shape[1:]), np.int64))

    @property
    def parameters(self) -> dict[str, float]:
        """What says where positions are, by name: units and degrees."""
        return parameters(self.place)


def flat(index: Integers) -> Integers:
    """(k, 2) nodes of (k,) or (k, 2)."""
    if index.ndim == 2:
        return index
    return np.stack([index, np.zeros_like(index)], axis=1)


def positions(place: Place, index: Integers) -> Complexes:
    """Places (k,) of nodes (k,) or (k, 2)."""
    match place:
        case Model():
            return at(place, index)
        case Net():
            return net_at(place, index)
        case Rings():
            return rings_at(place, index)


def parameters(place: Place) -> dict[str, float]:
    """Numbers of a place by name, in units and degrees."""
    match place:
        case Net():
            numbers = [place.origin.real, place.origin.imag, place.u.real, place.u.imag]
            numbers += [place.v.real, place.v.imag, place.stagger]
            return dict(zip(("x", "y", "ux", "uy", "vx", "vy", "stagger"), numbers, strict=True))
        case Rings():
            return {
                "x": place.centre.real,
                "y": place.centre.imag,
                "phase": float(np.rad2deg(place.phase)),
                "step": float(np.rad2deg(place.step)),
                "radius": place.radius,
                "growth": place.growth,
                "twist": float(np.rad2deg(place.twist)),
                "closed": float(place.closed),
            }
        case Model():
            return _of_model(place)


def _of_model(model: Model) -> dict[str, float]:
    known = model.numbers.tolist()
    if model.straight:
        names = ("x", "y", "x1", "y1", "x2", "y2")
        return dict(zip(names, known, strict=False))
    radial = {
        "ring": ("radius",),
        "log": ("radius", "growth"),
        "archimedes": ("radius", "growth"),
        "vogel": ("spread", "first"),
    }[model.kind]
    named = dict(zip(("x", "y", "phase", "step", *radial), known, strict=True))
    named["phase"], named["step"] = np.rad2deg(named["phase"]), np.rad2deg(named["step"])
    return {**named, "closed": float(model.closed)} if model.kind == "ring" else named


# ------------------------------------------------------------------------ building


def of_chain(
    known: Instances, chain: Chain, points: Integers, nest: bool = False
) -> Lattice | None:
    """A row, ring, spiral or nest; points: (p,) the instance of each point of the cloud."""
    model, index, rows = chain.model, chain.index, points[chain.rows]
    columns = _columns(known, rows, flat(index), _turn(model), _step(model, index))
    if not columns.keep.all():
        keep = columns.keep
        keep[keep] = few_holes(model, index[keep])
        index, rows = index[keep], rows[keep]
        if len(rows) < FEW:
            return None
        model = model if nest else fit(model, index, _anchors(known, rows))
    model, index = _in_order(closed(model, index), index, known.order[rows])
    columns = _columns(known, rows, flat(index), _turn(model), _step(model, index))
    model = model if nest else _as_turned(known, model, columns, index, rows)
    order, stride = along(known.order[rows], index)
    return _built(known, _kind(model, nest), model, index, rows, columns, order, stride)


def _as_turned(
    known: Instances, model: Model, columns: Columns, index: Integers, rows: Integers
) -> Model:
    """The model with the angular step and growth of its members, where these follow it exactly:
    noise moves things more often than it turns or scales them.
    """
    if model.straight or known.free:
        return model
    numbers, held = model.numbers.copy(), []
    turn, grown = columns.angle, columns.scale
    steady = turn.exact and turn.kind == "regular" and not turn.terms[3]
    for there, known_exactly, value in (
        (TURN, steady and not model.closed, float(np.deg2rad(turn.terms[1]))),
        (GROWTH, model.kind == "log" and grown.exact and grown.geometric, grown.terms[1]),
    ):
        if known_exactly and abs(value - numbers[there]) <= FAITHFUL * abs(numbers[there]):
            numbers[there] = value
            held.append(there)
    if not held:
        return model
    places = _anchors(known, rows)
    tried = fit(replace(model, numbers=numbers, held=tuple(held)), index, places)
    off, before = (np.abs(places - at(each, index)).max() for each in (tried, model))
    return tried if off <= max(LOOSER * before, known.exact) else model


def of_net(known: Instances, net: Net, points: Integers) -> Lattice | None:
    """A grid, numbered so that it is painted in order where some numbering is."""
    rank = known.order[points[net.rows]]
    ways = [turned(net, back, down) for back in (False, True) for down in (False, True)]
    kinds = [across(rank, each.index) for each in ways]
    best = min(range(4), key=lambda k: (_tidiness(kinds[k][0]), k))
    net = ways[best]
    return _of_nodes(known, "grid", net, net.index, points[net.rows], *kinds[best])


def of_rings(known: Instances, rings: Rings, points: Integers) -> Lattice | None:
    """A set of rings about one centre, numbered so that it is painted in order if it can be."""
    rank = known.order[points[rings.rows]]
    ways = [wound(rings, rank, inwards) for inwards in (False, True)]
    kinds = [across(rank, each.index) for each in ways]
    best = min(range(2), key=lambda k: (_tidiness(kinds[k][0]), k))
    rings = ways[best]
    return _of_nodes(known, "ring", rings, rings.index, points[rings.rows], *kinds[best])


def _of_nodes(
    known: Instances,
    kind: LatticeKind,
    place: Net | Rings,
    index: Integers,
    rows: Integers,
    order: OrderKind,
    stride: int,
) -> Lattice | None:
    turn = float(np.rad2deg(place.step)) if isinstance(place, Rings) else 0.0
    step = _net_step(place)
    columns = _columns(known, rows, index, turn, np.full(len(rows), step))
    if not columns.keep.all():
        index, rows = index[columns.keep], rows[columns.keep]
        columns = _columns(known, rows, index, turn, np.full(len(rows), step))
    return _built(known, kind, place, index, rows, columns, order, stride)


def _net_step(place: Net | Rings) -> float:
    if isinstance(place, Net):
        return min(abs(place.u), abs(place.v + place.stagger * place.u))
    return abs(place.growth)


def _tidiness(kind: OrderKind) -> int:
    return TIDY.index(kind) if kind in TIDY else len(TIDY)


def _turn(model: Model) -> float:
    """Degrees by which the lattice turns at each step."""
    return 0.0 if model.straight else float(np.rad2deg(model.numbers[TURN]))


def _step(model: Model, index: Integers) -> Floats:
    """(m,) units from each node to the next."""
    return np.asarray(np.abs(at(model, index + 1) - at(model, index)))


def _kind(model: Model, nest: bool) -> LatticeKind:
    if nest:
        return "nest"
    if model.straight:
        return "row"
    return "ring" if model.kind == "ring" else "spiral"


def _anchors(known: Instances, rows: Integers) -> Complexes:
    placed = known.placed[rows]
    return np.asarray(placed.position + placed.factor * mirrored(known.anchor, placed.handedness))


def _columns(
    known: Instances, rows: Integers, index: Integers, turn: float, step: Floats
) -> Columns:
    """Angle, scale and handedness of members; a turn of a small symbol may be off more."""
    placed = known.placed[rows]
    size = np.maximum(known.radius * placed.scale, known.exact)
    noise = np.maximum(known.exact, known.loose * step) / size
    sure = np.minimum(known.exact / size, known.turned)
    slack = Slack(
        (np.rad2deg(sure), np.minimum(np.rad2deg(noise), WIDEST)),
        (sure * placed.scale, np.minimum(noise, TALLEST) * placed.scale),
    )
    return fit_columns(placed, known.stabiliser, known.free, index, slack, turn)


def _in_order(model: Model, index: Integers, rank: Integers) -> tuple[Model, Integers]:
    """Numbered from 0, in paint order where that goes along it either way."""
    first, last = int(index.min()), int(index.max())
    if model.closed:
        first, back = ring_order(rank, index, model.closed)
        last = first
        index = ((first - index) if back else (index - first)) % model.closed
        return renumbered(model, first, last, back), index
    falls = int((np.diff(rank[np.argsort(index)]) < 0).sum())
    back = model.kind != "vogel" and falls > (len(rank) - 1) / 2
    return renumbered(model, first, last, back), (last - index) if back else (index - first)


def _holes(place: Place, index: Integers) -> Integers:
    """Nodes without a member, of the box or around."""
    if index.ndim == 1:
        around = place.closed if isinstance(place, Model) else 0
        return np.setdiff1d(np.arange(around or int(index.max()) + 1), index)
    wide, high = index.max(axis=0) + 1
    if isinstance(place, Rings):
        wide = place.closed or wide
    there = np.zeros((wide, high), np.bool_)
    there[tuple(index.T)] = True
    return np.argwhere(~there).astype(np.int64)


def _built(
    known: Instances,
    kind: LatticeKind,
    place: Place,
    index: Integers,
    rows: Integers,
    columns: Columns,
    order: OrderKind,
    stride: int,
) -> Lattice | None:
    """With members in the order of their nodes; None where few members follow too little."""
    given = (columns.angle, columns.scale, columns.handedness)
    free = [each.kind == "arbitrary" for each in given]
    if len(rows) < FEW and (any(free) or not all(each.exact for each in given)):
        return None
    evident = [not lost for lost, told in zip(free, (not known.free, True), strict=False) if told]
    if not any(evident) and not all(each.exact for each in given) and len(rows) < SURE:
        return None
    sort = np.argsort(index) if index.ndim == 1 else np.lexsort((index[:, 0], index[:, 1]))
    index, rows, chosen = index[sort], rows[sort], columns.chosen[sort]
    anchors = _anchors(known, rows)
    corner = anchors - chosen.factor * mirrored(known.anchor, chosen.handedness)
    chosen = frames(corner, chosen.angle, chosen.scale, chosen.handedness)
    nodes = flat(index)
    off = anchors - positions(place, index)
    turn, grown = wrap(chosen.angle - columns.angle.at(nodes)), columns.scale.at(nodes)
    residual = np.stack([off.real, off.imag, turn, chosen.scale - grown], axis=1)
    sure = all(each.exact or each.kind == "arbitrary" for each in given)
    exact = sure and float(np.abs(off).max()) <= known.exact
    holes = _holes(place, index)
    gain = _gain(len(rows), len(holes), free, exact, place)
    made = Lattice(
        kind,
        place,
        known.anchor,
        *given,
        index,
        rows,
        chosen,
        holes,
        residual,
        exact,
        order,
        stride,
        gain,
    )
    return made if gain > 0 else None


def _gain(members: int, holes: int, free: list[bool], exact: bool, place: Place) -> float:
    """Tokens that places one by one would take, less those of the rule, its holes and residuals."""
    rule = 10 if isinstance(place, Net | Rings) or not place.straight else 6
    each = 8 - 2 * sum(free) - (0 if exact else 2)
    return float(each * members - 2 * holes - rule)
