"""Regular arrangements of instances of one symbol, whatever their paint order: rows, rings,
spirals, grids and nests, with noise, holes and clutter.

Takes the world frames of instances and what maps their symbol onto itself; gives lattices, best
first, which may share members: the caller chooses. Positions decide; angle, scale and handedness
are then regular, alternate or are arbitrary, column by column. What chance could make is not
reported. Nothing here makes rules, and nothing is random: neighbours vote, lattices grow member by
member with least squares, and all work is bounded.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

import numpy as np

from ipmlang.inverse.lattices.anchors import turned_about
from ipmlang.inverse.lattices.build import (
    TURNED,
    Instances,
    Lattice,
    of_chain,
    of_net,
    of_rings,
)
from ipmlang.inverse.lattices.chains import Chain
from ipmlang.inverse.lattices.cloud import Cloud, Integers, cloud
from ipmlang.inverse.lattices.grids import find_nets
from ipmlang.inverse.lattices.models import Model
from ipmlang.inverse.lattices.nets import Net
from ipmlang.inverse.lattices.rings import find_sunflowers, join_rings
from ipmlang.inverse.lattices.seeds import find_bends, find_rows
from ipmlang.inverse.lattices.sizes import find_sized
from ipmlang.inverse.lsystem.clusters import cluster
from ipmlang.inverse.lsystem.frames import Complexes, Frames, apply, mirrored

LEAST = 3  # instances
LAYERS = 4  # instances at one place that are looked at one after the other
NESTS = 400  # places where scales are looked at
LARGE = 9  # members of a grid in which nothing bent is looked for
SHARED = 0.8  # of its members in a better lattice: not reported

Memory: TypeAlias = "dict[bytes, list[Lattice]]"


def lattices_once(
    memory: Memory,
    placed: Frames,
    stabiliser: Frames,
    free: bool,
    radius: float,
    exact: float,
    loose: float,
    order: Integers,
    turned: float = TURNED,
) -> list[Lattice]:
    """What `find_lattices` finds, looked for once; memory: of searches before, added to."""
    columns = (placed.x, placed.y, placed.angle, placed.scale, placed.handedness, stabiliser.angle)
    sizes = np.array([radius, exact, free, loose, turned])
    key = b"".join(each.tobytes() for each in (*columns, order, sizes))
    if key not in memory:
        memory[key] = find_lattices(placed, stabiliser, free, radius, exact, loose, order, turned)
    return memory[key]


def find_lattices(
    placed: Frames,
    stabiliser: Frames,
    free: bool,
    radius: float,
    exact: float,
    loose: float,
    order: Integers,
    turned: float = TURNED,
) -> list[Lattice]:
    """Lattices among instances of one symbol, best first.

    placed: (n,) world frames; stabiliser: (k,) frames that map the symbol onto itself, identity
    first; free: any turn does too; radius: extent of the symbol at scale 1; exact: units within
    which something is exact; loose: share of the local step that members may be off, 0 where only
    what is exact is looked for; order: (n,) paint ranks; turned: radians, and share of its size,
    that an exact one may be off.
    """
    if len(placed) < LEAST:
        return []
    anchor = 0j if free else complex(stabiliser.position.mean())
    known = Instances(placed, stabiliser, free, radius, anchor, order, exact, loose, turned)
    found = _anchored(known)
    if np.count_nonzero(stabiliser.handedness > 0) == 1 and not free:
        point = turned_about(placed, order, radius, exact, loose)
        if point is not None:  # on the axis of a symbol that is its own mirror image
            anchor = complex(apply(stabiliser, point).mean())
            found += _anchored(replace(known, anchor=anchor))
    return _best(found)


def _anchored(known: Instances) -> list[Lattice]:
    """Lattices on which the anchor of each instance lies."""
    placed = known.placed
    spots = placed.position + placed.factor * mirrored(known.anchor, placed.handedness)
    layers, stacks = _layers(known, spots)
    found = [each for layer in layers for each in _in_layer(known, spots, layer)]
    return found + [each for stack in stacks for each in _in_stack(known, spots, stack)]


def _layers(known: Instances, spots: Complexes) -> tuple[list[Integers], list[Integers]]:
    """Instances at different places, layer by layer from the largest, and those at one place."""
    both = np.stack([spots.real, spots.imag], axis=1)
    slack = np.full_like(both, known.exact)
    place = cluster(np.zeros(len(spots), np.int64), both, slack)
    order = np.lexsort((known.order, -known.placed.scale, place))
    start = np.flatnonzero(np.diff(place[order], prepend=-1))
    size = np.diff(np.append(start, len(order)))
    depth = np.arange(len(order)) - np.repeat(start, size)
    layers = [np.sort(order[depth == k]) for k in range(min(LAYERS, int(size.max())))]
    high = np.flatnonzero(size >= LEAST)
    high = high[np.argsort(-size[high], kind="stable")][:NESTS]
    stacks = [order[start[k] : start[k] + size[k]] for k in high.tolist()]
    return [layer for layer in layers if len(layer) >= LEAST], stacks


def _in_layer(known: Instances, spots: Complexes, points: Integers) -> list[Lattice]:
    """Lattices of instances (p,) at different places."""
    seen = cloud(spots[points], known.exact, known.loose)
    shares = seen.shares
    used = np.zeros(len(points), np.bool_)
    nets = [net for share in shares for net in find_nets(seen, used, share)]
    bent = np.zeros(len(points), np.bool_)
    for net in nets:
        bent[net.rows] |= len(net) >= LARGE
    rows = [row for share in shares for row in find_rows(seen, used, share)]
    line = np.full(len(points), -1, np.int64)
    for number, row in enumerate(rows):
        line[row.rows] = number
        bent[row.rows] |= not row.model.straight
    chains = find_sunflowers(seen, bent)
    chains += [chain for share in shares for chain in find_bends(seen, bent, share, line)]
    chains += find_sized(seen, known.placed.scale[points] * max(known.radius, known.exact))
    return _built(known, seen, points, nets, rows + chains)


def _built(
    known: Instances, seen: Cloud, points: Integers, nets: list[Net], chains: list[Chain]
) -> list[Lattice]:
    """Everything found, rings about one centre both joined and alone."""
    made = [of_net(known, net, points) for net in nets]
    made += [of_rings(known, rings, points) for rings in join_rings(seen, chains)]
    made += [of_chain(known, chain, points) for chain in chains]
    return [each for each in made if each is not None]


def _in_stack(known: Instances, spots: Complexes, points: Integers) -> list[Lattice]:
    """Scale sequences of instances (p,) at one place: even steps, or even ratios."""
    size = known.placed.scale[points] * max(known.radius, known.exact)
    _, first = np.unique(np.round(size / known.exact), return_index=True)
    points, size = points[first], size[first]
    if len(points) < LEAST:
        return []
    middle = complex(spots[points].mean())
    for along in (size, np.log(size) * float(size.min())):
        seen = cloud(along.astype(np.complex128), known.exact, known.loose, straight=True)
        used = np.zeros(len(points), np.bool_)
        rows = [row for share in seen.shares for row in find_rows(seen, used, share)]
        still = Model("line", np.array([middle.real, middle.imag, 0.0, 0.0]))
        nests = [Chain(still, row.index, row.rows, row.reach) for row in rows]
        made = [of_chain(known, nest, points, nest=True) for nest in nests]
        good = [each for each in made if each is not None and each.scale.kind != "arbitrary"]
        if good:
            return good
    return []


def _best(found: list[Lattice]) -> list[Lattice]:
    """By gain, without those whose members a better one has nearly all."""
    chosen: list[Lattice] = []
    order = sorted(range(len(found)), key=lambda k: (-found[k].gain, k))
    owners: dict[int, list[int]] = {}
    for lattice in (found[k] for k in order):
        shared: dict[int, int] = {}
        for row in lattice.rows.tolist():
            for owner in owners.get(row, []):
                shared[owner] = shared.get(owner, 0) + 1
        if max(shared.values(), default=0) >= SHARED * len(lattice):
            continue
        for row in lattice.rows.tolist():
            owners.setdefault(row, []).append(len(chosen))
        chosen.append(lattice)
    return chosen
