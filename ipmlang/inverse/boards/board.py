"""Things of any size on the nodes of a grid, painted line by line: a halftone, a dot plot, a punch
card. Takes the rules of a drawing that has none; gives them with boards in place of stretches of
the axiom.

What changes from node to node are sizes and shapes, which a table lists; where a node lies is a
formula. A size of 0 and below says that another shape stands there, or nothing. Nothing here
prints.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence, Set
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from ipmlang.formats.drawing import Outline
from ipmlang.inverse.boards.coordinates import Coordinate, coordinate
from ipmlang.inverse.boards.raster import Raster, rasters
from ipmlang.inverse.lsystem.curves import evaluate
from ipmlang.inverse.lsystem.frames import Floats, Frames, compose, frames
from ipmlang.inverse.lsystem.symbols import Integers
from ipmlang.inverse.score import SMALL
from ipmlang.inverse.simplify import AXIOM, Book, regauge
from ipmlang.inverse.terminals import Terminal

CODED = 4  # shapes beside the one with sizes that a size may stand for
MANY = 1 / 16  # of the things are as many sizes as make them irregular
ALONG = 9  # points of a segment by which the box of a shape is measured
PLAIN = 9  # decimals of how far off its middle a shape of size 1 is placed
LONGEST = 6  # decimals of a size
ROOM = 2e-7  # of the diagonal: what a place on a board may be off

# By nodes and how many of them are on a line, places, sizes, which of these are bound, and `by`.
Formulas: TypeAlias = "dict[tuple[bytes, int, bytes, bytes, bytes, float], Coordinate | None]"
Anchor: TypeAlias = "tuple[float, float] | None"  # where in the box of a shape, from 0 to 1
# The middle, the upper left corner, the ends of the axes, the other corners.
ANCHORS: tuple[Anchor, ...] = (
    *(None, (0, 1)),
    *((0.5, 1), (0.5, 0), (0, 0.5), (1, 0.5)),
    *((0, 0), (1, 1), (1, 0)),
)


@dataclass(frozen=True, slots=True, eq=False)
class Board:
    """Rows `raster.start` to `raster.stop` of the axiom as things on nodes.

    part: (n,) symbol on each node that has one; x, y: where they stand; size: (n,) of things;
    sized: the only symbol with sizes, None where there are none or several; codes: which size says
    that another symbol stands there, None for nothing.
    """

    raster: Raster
    part: Integers
    x: Coordinate
    y: Coordinate
    size: Floats
    sized: int | None
    codes: dict[int | None, float]

    @property
    def start(self) -> int:
        """The first row of the axiom that stands on it."""
        return self.raster.start

    @property
    def stop(self) -> int:
        """The row after the last one."""
        return self.raster.stop

    @property
    def nodes(self) -> Integers:
        """(n,) node of each thing, from 0."""
        return np.asarray(self.raster.node - self.raster.node[0])

    @property
    def irregular(self) -> bool:
        """Whether what stands on the nodes is of so many sizes that no rule says them shorter."""
        return len(np.unique(self.size)) >= max(MANY * len(self.size), 2)

    @property
    def count(self) -> int:
        """All nodes."""
        return int(self.nodes[-1]) + 1

    @property
    def full(self) -> bool:
        """Whether the same thing in one size stands on all nodes of whole lines."""
        whole = self.raster.node[0] == 0 and self.count % self.raster.across == 0
        alike = len(np.unique(self.part)) == 1 and bool((self.size == 1).all())
        return bool(whole) and len(self.part) == self.count and alike

    @property
    def plain(self) -> bool:
        """Whether it is a grid and no more, which rules say as a repeat of a repeat."""
        return self.full and self.x.even and self.y.even


@dataclass(frozen=True, slots=True, eq=False)
class _Kind:
    """One symbol on a board: how its frame is changed, whether it comes in sizes, and by how much
    the point that is placed lies off its middle, for each unit of size; least: the smallest size.
    """

    part: int
    change: Frames
    sized: bool
    off: complex
    least: float


def with_boards(
    book: Book,
    terminals: Sequence[Terminal],
    bound: Set[int],
    diagonal: float,
    known: Formulas,
) -> list[Board]:
    """The boards among what stands in the axiom, whose symbols are given the frames that make them
    short. bound: symbols that no board may have; diagonal: units; known: formulas of places of this
    drawing, looked for once, which are added to.
    """
    body = book.bodies[AXIOM]
    made: list[Board] = []
    done = set(bound) | book.inlined()  # what is written where it stands has no name for a cell
    for raster in rasters(body.places.position, _styles(body.parts, terminals)):
        own = set(body.parts[raster.start : raster.stop].tolist())
        board = None if own & done else _board(book, terminals, raster, ROOM * diagonal, known)
        if board is not None and not board.plain:
            made.append(board)
            done |= own  # their frames are bound to this board
    return made


def _styles(parts: Integers, terminals: Sequence[Terminal]) -> Integers:
    """(n,) a number for the style of each symbol."""
    known: dict[object, int] = {}
    number = [known.setdefault(each.style, len(known)) for each in terminals]
    own = np.full(int(parts.max(initial=-1)) + 1, -1, np.int64)
    own[: len(number)] = number[: len(own)]
    return np.asarray(own[parts])


def _board(
    book: Book, terminals: Sequence[Terminal], raster: Raster, room: float, known: Formulas
) -> Board | None:
    """The shortest board for the places of a raster, its symbols' frames changed."""
    rows = slice(raster.start, raster.stop)
    parts, places = book.bodies[AXIOM].parts[rows], book.bodies[AXIOM].places[rows]
    best: tuple[int, Board, list[_Kind]] | None = None
    for anchor in ANCHORS:
        kinds = _kinds(parts, places, terminals, anchor, room)
        if kinds is None:
            return None
        board = _placed(raster, parts, places, kinds, room, known)
        if board is not None:
            tokens = board.x.tokens + board.y.tokens
            if best is None or tokens < best[0]:
                best = tokens, board, kinds
            if tokens == 0:
                break
    if best is None:
        return None
    for kind in best[2]:
        regauge(book, kind.part, kind.change)
    return best[1]


# ----------------------------------------------------------------------------- kinds


def _kinds(
    parts: Integers, places: Frames, terminals: Sequence[Terminal], anchor: Anchor, room: float
) -> list[_Kind] | None:
    """What stands on a board, None where copies of one symbol are turned differently; the symbol
    that comes in sizes first, then the most frequent one.
    """
    made = []
    for part, _ in Counter(parts.tolist()).most_common():
        own = places[parts == part]
        if np.abs(own.angle - own.angle[0]).max() > SMALL or np.ptp(own.handedness):
            return None
        terminal = terminals[part] if part < len(terminals) else None
        radius = 0.0 if terminal is None else terminal.shape.radius
        sized = float(np.ptp(own.scale)) * radius > room
        at = _anchor(terminal, anchor)
        hand = int(own.handedness[0])
        unit = _unit(terminal, own.scale, room) if sized and terminal is not None else 1.0
        change = frames(np.array([at]), -hand * own.angle[:1], unit, hand)
        one = compose(own[:1], change)
        off = complex(one.position[0] - own.position[0]) / float(one.scale[0])
        made.append(_Kind(part, change, sized, off, float(own.scale.min()) * unit))
    return sorted(made, key=lambda each: not each.sized)


def _anchor(terminal: Terminal | None, anchor: Anchor) -> complex:
    """The point of a shape, in its own frame, that a file may have rounded: its origin, or one of
    its box.
    """
    if anchor is None or terminal is None or terminal.shape.outline is None:
        return 0j
    low, high = _box(terminal.shape.kind, terminal.shape.outline)
    x, y = (low + np.array(anchor) * (high - low)).tolist()
    return complex(x, y)


def _box(kind: str, outline: Outline) -> tuple[Floats, Floats]:
    """(2,) least and largest x and y of a shape."""
    if kind == "ellipse":
        half = np.hypot(outline.coords[0, 1], outline.coords[0, 2])
        return -half, half
    points = outline.coords[..., 0] + 1j * outline.coords[..., 1]
    along = evaluate(outline.kind, points, np.linspace(0, 1, ALONG)).ravel()
    both = np.stack([along.real, along.imag])
    return both.min(axis=1), both.max(axis=1)


def _unit(terminal: Terminal, scale: Floats, room: float) -> float:
    """What a size of 1 is: the radius, width or height, whichever gives sizes of few decimals."""
    outline = terminal.shape.outline
    if outline is None:
        return 1.0
    low, high = _box(terminal.shape.kind, outline)
    width, height = (high - low).tolist()
    own = (width / 2,) if terminal.shape.kind == "ellipse" else ()
    wanted = [each for each in (*own, width, height, terminal.shape.radius, 1.0) if each > 0]
    return float(min(wanted, key=lambda each: _decimals(scale * each, room)))


def _decimals(sizes: Floats, room: float) -> int:
    """Decimals with which all sizes are written."""
    for decimals in range(LONGEST):
        if np.abs(sizes - np.round(sizes, decimals)).max() <= room / 2:
            return decimals
    return LONGEST


# --------------------------------------------------------------------------- formulas


def _placed(
    raster: Raster,
    parts: Integers,
    places: Frames,
    kinds: Sequence[_Kind],
    room: float,
    known: Formulas,
) -> Board | None:
    """The board of things of these kinds; many anchors lie above each other, so that formulas are
    known.
    """
    sized = [each for each in kinds if each.sized]
    coded = len(sized) == 1 and len(kinds) <= 1 + CODED
    off = sized[0].off if sized else 0j
    # What a size is multiplied by is 1 or a half rather than nearly that.
    off = complex(round(off.real, PLAIN), round(off.imag, PLAIN))
    moved = (each.off if each.sized or coded else 0j for each in kinds)
    if not coded and any(abs(each - off) > SMALL for each in moved):
        return None
    codes = _codes(raster, parts, kinds) if coded else {}
    at, size = places.position, np.ones(len(parts))
    for kind in kinds:
        own = parts == kind.part
        placed = compose(places[own], kind.change)
        at[own] = placed.position
        size[own] = codes.get(kind.part, placed.scale)
    size = np.round(size, _decimals(size, room))
    still = ~np.isin(parts, [each.part for each in sized])
    pull = np.maximum(size, 0.0)
    nodes = raster.node.tobytes(), raster.across

    def said(value: Floats, size: Floats, by: float) -> Coordinate | None:
        key = (*nodes, value.tobytes(), size.tobytes(), still.tobytes(), by)
        if key not in known:
            known[key] = coordinate(raster, value, size, still, by, room)
        return known[key]

    x = said(at.real, pull, off.real)
    y = None if x is None else said(at.imag, x.size, off.imag)
    if x is None or y is None or (x.rest is not None and y.rest is not None):
        return None
    x = replace(x, size=y.size)
    if np.abs(x.at(raster) - at.real).max() > room:
        return None
    size = np.where(still, size, y.size)
    return Board(raster, parts, x, y, size, sized[0].part if coded else None, codes)


def _codes(raster: Raster, parts: Integers, kinds: Sequence[_Kind]) -> dict[int | None, float]:
    """The size that says that another shape than the sized one stands on a node, or none: how far
    off the middle it is placed, if it is a shape that small, else 0 for what is most frequent.
    """
    often: dict[int | None, int] = {
        each.part: int((parts == each.part).sum()) for each in kinds if not each.sized
    }
    empty = int(raster.node[-1] - raster.node[0]) + 1 - len(parts)
    own = _own_sizes(kinds)
    if own is not None:
        return {**own, **({None: -1.0} if empty else {})}
    often |= {None: empty} if empty else {}
    order = sorted(often, key=lambda part: -often[part])
    return {part: -float(k) for k, part in enumerate(order)}


def _own_sizes(kinds: Sequence[_Kind]) -> dict[int | None, float] | None:
    """The sizes of shapes without sizes, where they are placed off their middle by these."""
    sized, *others = kinds
    if sized.off == 0:
        return None
    sizes = {each.part: each.off / sized.off for each in others}
    if any(abs(each.imag) > SMALL or each.real < -SMALL for each in sizes.values()):
        return None
    made: dict[int | None, float] = {
        part: round(each.real, LONGEST) + 0.0 for part, each in sizes.items()
    }
    distinct = len(set(made.values())) == len(made)
    return made if distinct and max(made.values(), default=0.0) < sized.least else None
