"""Drawings with planted structure among clutter, and how much of it a grammar found.

`plant` makes two structures of a kind in a paint order, with holes and jitter, random shapes and
random copies of their own shapes around them, and keeps which element belongs to which. `score`
runs what was inferred and tells recall and precision of the elements under its rules.
"""

from __future__ import annotations

import inspect
import json
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from inverse.provenance import Site, boxes_of, sites
from inverse.synth import (
    copies,
    drawing,
    grid,
    leaf,
    mirror_cell,
    polygon,
    rectangle,
    ring,
    row,
    scaled,
    star,
)
from numpy.typing import NDArray

from ipmlang.formats.drawing import Drawing, DrawnElement, Floats, Outline, Style
from ipmlang.formats.svg.write import write_svg
from ipmlang.inverse import Inference, infer

Kind = Literal["row", "ring", "grid", "mirrored", "scaled", "quadratic"]
Order = Literal["contiguous", "interleaved", "shuffled"]
KINDS: tuple[Kind, ...] = ("row", "ring", "grid", "mirrored", "scaled", "quadratic")
ORDERS: tuple[Order, ...] = ("contiguous", "interleaved", "shuffled")
JITTERS = (0.0, 0.001, 0.005, 0.01)  # of the step
SHEET = (0.0, 0.0, 400.0, 300.0)
FLOORS = Path(__file__).parent / "known" / "planted_floors.json"
CLUTTER, ALONE = -1, -2
LEAST = 3  # members of a structure that make a rule its own
COLORS = ("#2a6f4e", "#c8506a", "#2a6f97", "#d98e2b")


Case = tuple[Kind, float, Order, float]  # kind, jitter, paint order, holes
# What the tests measure: every kind in every order while it is regular, less of it with jitter.
CASES: tuple[Case, ...] = tuple(
    (kind, jitter, order, holes)
    for kind in KINDS
    for jitter, orders, holes in (
        (0.0, ORDERS, 0.0),
        (0.001, ("contiguous", "shuffled"), 0.0),
        (0.01, ORDERS[:1], 0.0),
        (0.001, ORDERS[:1], 0.2),
        (0.01, ("contiguous", "shuffled"), 0.2),
    )
    for order in orders
)


def name_of(case: Case) -> str:
    """As it stands in the file of floors."""
    kind, jitter, order, holes = case
    return f"{kind} {jitter:.1%} {order}{' with holes' if holes else ''}"


def floors() -> dict[str, tuple[float, float]]:
    """Recall and precision that each case must reach; `bench_planted.py --raise` lifts them."""
    kept = json.loads(FLOORS.read_text(encoding="utf-8"))
    return {name: (recall, precision) for name, (recall, precision) in kept.items()}


@dataclass(frozen=True, slots=True, eq=False)
class Planted:
    """member: (n,) the structure of each element, CLUTTER, or ALONE where a hole has taken the
    mirror image; near: units, how far an element may be moved and still be known again.
    """

    kind: Kind
    drawing: Drawing
    member: NDArray[np.int64]
    near: float


@dataclass(frozen=True, slots=True)
class Score:
    """Elements: in structures, of these under rules that hold three or more of their structure, and
    under any rule that counts.
    """

    planted: int
    found: int
    ruled: int

    @property
    def recall(self) -> float:
        """The share of the planted elements that were found."""
        return self.found / self.planted

    @property
    def precision(self) -> float:
        """The share of the elements under rules that belong there; 1 where there are no rules."""
        return self.found / self.ruled if self.ruled else 1.0

    def __str__(self) -> str:
        precision = f"{self.precision:.2f}" if self.ruled else "–"
        return f"{self.recall:.2f} / {precision}"


def total(scores: Iterable[Score]) -> Score:
    """All elements of several drawings together."""
    every = list(scores)
    return Score(
        sum(each.planted for each in every),
        sum(each.found for each in every),
        sum(each.ruled for each in every),
    )


# ---------------------------------------------------------------------- planting


def plant(kind: Kind, jitter: float, order: Order, holes: float = 0.0, seed: int = 0) -> Planted:
    """A drawing with two structures of a kind; jitter is a share of the step, holes of the copies.

    >>> planted = plant("ring", 0.001, "shuffled")
    >>> len(planted.drawing.elements) == len(planted.member)
    True
    """
    random = np.random.default_rng([seed, KINDS.index(kind), ORDERS.index(order)])
    shapes = _shapes(random)
    middles = ((105.0, 150.0), (295.0, 150.0))
    elements: list[list[DrawnElement]] = []
    members: list[NDArray[np.int64]] = []
    near = 0.5
    for which, middle in enumerate(middles):
        made, step = _structure(kind, shapes[3 * which : 3 * which + 3], middle, random)
        kept = np.flatnonzero(random.random(len(made)) >= holes)
        near = max(near, 3 * jitter * step)
        elements.append(_shaken([made[index] for index in kept], jitter * step, random))
        partner = np.isin((kept + len(made) // 2) % len(made), kept)
        members.append(np.where(partner | (kind != "mirrored"), which, ALONE))
    clutter = _clutter(shapes, random)
    order_of = _paint_order([len(each) for each in (*elements, clutter)], order, random)
    every = [*elements[0], *elements[1], *clutter]
    member = np.concatenate([*members, np.full(len(clutter), CLUTTER)])
    sheet = drawing([every[index] for index in order_of.tolist()], SHEET)
    return Planted(kind, sheet, member[order_of], near)


Copies = tuple[Outline, Floats, Style]  # a shape, one placement (1, 5), its paint


def _shapes(random: np.random.Generator) -> list[Outline]:
    """Different shapes with and without symmetry, in any order."""
    every = [
        leaf(7),
        star(5, 4, 1.7),
        rectangle(6, 3),
        leaf(5),
        star(4, 4, 1.5),
        _irregular(random),
    ]
    return [every[index] for index in random.permutation(len(every)).tolist()]


def _irregular(random: np.random.Generator) -> Outline:
    """A polygon that no other equals."""
    count = int(random.integers(5, 9))
    angle = np.sort(random.uniform(0, 2 * np.pi, count))
    radius = random.uniform(1.5, 4.5, count)
    return polygon(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1))


def _structure(
    kind: Kind, shapes: list[Outline], middle: tuple[float, float], random: np.random.Generator
) -> tuple[list[Copies], float]:
    """The copies of one structure, about a point, and its step in units."""
    count = int(random.integers(12, 19))
    turn = float(random.uniform(-15, 15))
    direction = np.array([np.cos(np.deg2rad(turn)), np.sin(np.deg2rad(turn))])
    step = float(random.uniform(8, 10))
    if kind == "mirrored":
        return _mirrored(shapes, middle, random), 10.0
    if kind == "row":
        placed = row(count, tuple(step * direction))
    elif kind == "ring":
        placed = ring(count, step * count / (2 * np.pi))
    elif kind == "grid":
        skew = float(random.uniform(0, 4))
        placed = grid(
            6, int(random.integers(4, 7)), tuple(2 * step * direction), (skew, 2.1 * step)
        )
        step *= 2
    elif kind == "scaled":
        placed = scaled(count, step, float(random.uniform(0.92, 0.97)), turn)
    else:
        index = np.arange(count)
        placed = row(count, (0.0, 0.0))
        placed[:, 0] = 0.7 * step * index
        placed[:, 1] = 0.1 * step * index * (index - count / 2)
    placed[:, :2] += np.array(middle) - (placed[:, :2].min(axis=0) + placed[:, :2].max(axis=0)) / 2
    paint = Style(fill=COLORS[int(random.integers(len(COLORS)))])
    return [(shapes[0], placed[k : k + 1], paint) for k in range(len(placed))], step


def _mirrored(
    shapes: list[Outline], middle: tuple[float, float], random: np.random.Generator
) -> list[Copies]:
    """Eight shapes at random places, and the mirror image of them all."""
    made: list[Copies] = []
    for number in range(8):
        cell = np.array([[0.0, 0.0, 0.0, 1.0, 1.0]])
        cell[0, :2] = random.uniform(8, 70), random.uniform(-60, 60)
        cell[0, 2:4] = random.uniform(-180, 180), random.uniform(0.8, 1.6)
        paint = Style(fill=COLORS[number % len(COLORS)])
        both = mirror_cell(cell, 0.0)
        both[:, :2] += middle
        shape = shapes[number % len(shapes)]
        made += [(shape, both[:1], paint), (shape, both[1:], paint)]
    return made[0::2] + made[1::2]


def _shaken(made: list[Copies], amount: float, random: np.random.Generator) -> list[DrawnElement]:
    """One element a copy, moved by up to an amount in each coordinate."""
    elements: list[DrawnElement] = []
    for shape, placed, paint in made:
        moved = placed.copy()
        moved[:, :2] += random.uniform(-amount, amount, (1, 2))
        elements += copies(shape, moved, paint)
    return elements


def _clutter(shapes: list[Outline], random: np.random.Generator) -> list[DrawnElement]:
    """Shapes that no other equals, and copies of the structures' own shapes, anywhere."""
    every = [_irregular(random) for _ in range(18)] + [shapes[0]] * 6 + [shapes[3]] * 6
    elements: list[DrawnElement] = []
    for shape in every:
        placed = np.array([[0.0, 0.0, random.uniform(-180, 180), random.uniform(0.6, 1.5), 1.0]])
        placed[0, :2] = random.uniform(10, 390), random.uniform(10, 290)
        paint = Style(fill=COLORS[int(random.integers(len(COLORS)))])
        elements += copies(shape, placed, paint)
    return [elements[index] for index in random.permutation(len(elements)).tolist()]


def _paint_order(
    lengths: list[int], order: Order, random: np.random.Generator
) -> NDArray[np.int64]:
    """Element numbers in the order in which they are painted."""
    if order == "shuffled":
        return np.asarray(random.permutation(sum(lengths)))
    if order == "contiguous":
        return np.arange(sum(lengths))
    turns = np.concatenate([np.arange(lengths[0]), np.arange(lengths[1])])
    alternate = np.argsort(turns, kind="stable")
    return np.concatenate([alternate, np.arange(len(alternate), sum(lengths))])


# ------------------------------------------------------------------------ scoring


def inferred(planted: Planted, symmetrized: bool = False) -> Inference:
    """What is inferred from the drawing, written to a file as a user would have it.

    `symmetrized` asks for the regular grammar beside which no residual is kept.
    """
    with tempfile.TemporaryDirectory(prefix="ipmlang-planted-") as folder:
        path = Path(folder) / "planted.svg"
        path.write_text(write_svg(planted.drawing), encoding="utf-8")
        return infer(path, symmetrize=True) if symmetrized else infer(path)


def can_symmetrize() -> bool:
    """Whether inference has the regular form yet."""
    return "symmetrize" in inspect.signature(infer).parameters


def score(planted: Planted, found: Inference) -> Score:
    """Recall and precision of the elements under rules.

    A rule counts when it repeats (a repeat with places by a rule, a recursion), for mirrored
    structure also when it is used twice or more. Its elements are found where it holds at least
    three of their structure.
    """
    boxes = boxes_of(planted.drawing)
    count = len(planted.member)
    found_there, ruled = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    for site in _sites(found):
        if not counts(site, planted.kind):
            continue
        below = _known_again(site.boxes, boxes, planted.near)
        ruled[below[planted.member[below] != ALONE]] = True
        members = planted.member[below]
        often = np.bincount(members[members >= 0], minlength=2) >= LEAST
        found_there[below[(members >= 0) & often[members]]] = True
    return Score(int((planted.member >= 0).sum()), int(found_there.sum()), int(ruled.sum()))


def _sites(found: Inference) -> list[Site]:
    with tempfile.TemporaryDirectory(prefix="ipmlang-planted-") as folder:
        found.save(Path(folder) / f"{found.stem}.ipm")
        return sites(found.grammar, Path(folder))


def counts(site: Site, kind: Kind) -> bool:
    """Whether a rule says how a structure of this kind is made."""
    return site.repeats or (kind == "mirrored" and site.shared)


def _known_again(derived: Floats, drawn: Floats, near: float) -> NDArray[np.int64]:
    """The elements drawn that derived ones stand for: the nearest box, if it is near."""
    if not len(derived):
        return np.zeros(0, np.int64)
    apart = np.abs(derived[:, None] - drawn[None]).max(axis=2)
    nearest = apart.argmin(axis=1)
    close = apart[np.arange(len(derived)), nearest] <= near
    known: NDArray[np.int64] = np.unique(nearest[close])
    return known
