"""Parts in frames as the elements of a body: regular ones as repeats, tables, others one by one.

In go frames with what stands in each, out come elements as inference prints them, and the tables
that they read. Numbers are as short as what touches allows. Nothing is derived here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.compiler import ast
from ipmlang.edit.buildings.regularity import Arranged, Part, said
from ipmlang.edit.symbols import Elements
from ipmlang.inverse.frames import Floats, Frames, join
from ipmlang.inverse.split.placing import Precision, Spot, placed, spots
from ipmlang.inverse.split.wording import all_nothing, call, is_nothing

FEWEST, MANY, MIXED = 3, 4, 5  # parts of a row, rows of a table, and of one of several symbols
COLUMNS = ("x", "y", "z", "rx", "ry", "rz")
SHAPE = "shape"


@dataclass(frozen=True, slots=True)
class Room:
    """How exactly parts are written. near: units within which things touch."""

    near: float

    @property
    def precision(self) -> Precision:
        """Places and sizes, some of them multiplied, are off by far less than what touches."""
        return Precision(self.near / 80)

    def spots(self, frames: Frames) -> list[Spot]:
        """Where parts stand; what stands there reaches no further than a building does. Those that
        stand upright are told together, and so are the others.
        """
        precision, reach = self.precision, 1e6 * self.near
        askew = np.asarray(frames.rotation[:, 1:3].any(axis=1))
        if askew.all() or not askew.any():
            return spots(frames, precision, reach)
        rest = iter(spots(frames[~askew], precision, reach))
        turned = iter(spots(frames[askew], precision, reach))
        return [next(turned if own else rest) for own in askew.tolist()]


def laid_out(
    parts: Sequence[Part],
    room: Room,
    title: Callable[[str], str],
    owner: str,
    known: Sequence[ast.Table] = (),
) -> tuple[Elements, list[ast.Table]]:
    """The elements that draw parts at frames of one row each, and their tables; title: gives a free
    name like a wish; owner: the symbol whose body it is; known: tables that are there already, of
    which equal ones serve.
    """
    body: list[ast.Element] = []
    tables: list[ast.Table] = []
    frames = join([frame for frame, _ in parts])
    home = _home(frames, room)
    if home is not None:
        body.append(call("translate", *room.precision.vector(home)))
        frames = Frames(frames.position - home, frames.rotation, frames.hand, frames.scale)
        parts = [(frames[k : k + 1], elements) for k, (_, elements) in enumerate(parts)]
    at = room.spots(frames)
    if len(parts) < FEWEST:
        return tuple(placed(spot, own[1]) for spot, own in zip(at, parts, strict=True)), tables
    arranged, begin = Arranged(parts, frames, room.near), 0
    while begin < len(parts):
        sequence = arranged.regular(begin)
        if sequence is not None:
            body.append(said(sequence, parts, begin, room.precision, 1e6 * room.near))
            begin += sequence.parts
            continue
        end = _alike_end(arranged, begin)
        mixed = _symbols_end(arranged, at, begin)
        if (end - begin >= MANY and end == mixed) or mixed - begin < MIXED:
            found = _listed(parts[begin:end], at[begin:end]) if end - begin >= MANY else None
        else:
            end = mixed
            wish = f"{owner.rpartition('.')[2].lower()}_parts"
            found = _mixed(parts[begin:end], at[begin:end], wish)
        if found is None:
            end = begin + 1
            body.append(placed(at[begin], parts[begin][1]))
        else:
            table = next((each for each in (*known, *tables) if found.is_in(each)), None)
            if table is None:
                table = ast.Table(title(found.wish), columns=found.columns, rows=found.rows)
                tables.append(table)
            body.append(ast.Repeat(ast.Rows("at", table.name, places=True), found.elements))
        begin = end
    return tuple(body), tables


def _home(frames: Frames, room: Room) -> Floats | None:
    """(3,) where so many parts stand that all are sooner told from there."""
    if len(frames.position) < FEWEST:
        return None
    places = [tuple(row) for row in np.round(frames.position / room.near).tolist()]
    count = Counter(places)
    often = max(count.values())
    if often < FEWEST or often <= count[0.0, 0.0, 0.0] + 1:
        return None
    first = min(place for place, own in count.items() if own == often)
    return np.asarray(frames.position[places.index(first)])


def _alike_end(arranged: Arranged, begin: int) -> int:
    """Behind the last of equal parts of one hand that follow each other, up to where a row or a
    ring begins.
    """
    kinds = arranged.kinds
    end = begin + 1
    while end < len(kinds) and kinds[end] == kinds[begin]:
        if arranged.regular(end) is not None:
            break
        end += 1
    return end


def _symbols_end(arranged: Arranged, at: Sequence[Spot], begin: int) -> int:
    """Behind the last of parts that follow each other and are but symbols, moved or turned, of one
    hand, up to where a row of them begins, or a symbol comes again: a table draws all of a symbol
    where it first names it.
    """
    parts, end = arranged.parts, begin
    before: list[str] = []
    while end < len(parts):
        elements = parts[end][1]
        only = elements[0] if len(elements) == 1 else None
        if not isinstance(only, ast.Module) or only.args or "." in only.name:
            break
        spot = at[end]
        home = all_nothing(spot.place) and all_nothing(spot.turn)
        if home or spot.scale is not None or spot.mirrored != at[begin].mirrored:
            break
        if end > begin and arranged.regular(end) is not None:
            break
        if only.name in before[:-1] and only.name != before[-1]:
            break
        before.append(only.name)
        end += 1
    return end


@dataclass(frozen=True, slots=True)
class Listed:
    """A table to be: what it would be called, its columns and rows, and what each row draws."""

    wish: str
    columns: tuple[str, ...]
    rows: tuple[tuple[ast.Expr, ...], ...]
    elements: Elements

    def is_in(self, table: ast.Table) -> bool:
        """Whether a table says the same."""
        return table.columns == self.columns and table.rows == self.rows


def _listed(parts: Sequence[Part], found: Sequence[Spot]) -> Listed | None:
    """Equal parts at the places of a table; None where they are more than moved and turned."""
    columns, rows = _cells(found)
    if not columns or any(spot.scale is not None for spot in found):
        return None
    elements = parts[0][1]
    last = elements[-1]
    name = last.name if isinstance(last, ast.Module) else "part"
    return Listed(f"{name.lower()}_places", columns, rows, (*_mirror(found[0]), *elements))


def _mixed(parts: Sequence[Part], found: Sequence[Spot], wish: str) -> Listed:
    """Symbols at the places of a table, which names them."""
    columns, cells = _cells(found)
    names = [
        each.name for _, elements in parts for each in elements if isinstance(each, ast.Module)
    ]
    rows = tuple((ast.Name(name), *row) for name, row in zip(names, cells, strict=True))
    elements = (*_mirror(found[0]), ast.Module(f"at.{SHAPE}"))
    return Listed(wish, (SHAPE, *columns), rows, elements)


def _mirror(spot: Spot) -> Elements:
    """What mirrors, as all spots of a table do or do not."""
    return (ast.Module("mirror"),) if spot.mirrored else ()


def _cells(found: Sequence[Spot]) -> tuple[tuple[str, ...], tuple[tuple[ast.Expr, ...], ...]]:
    """The columns that say something of spots, and their rows."""
    cells = [(*spot.place, *spot.turn) for spot in found]
    named = [k for k in range(len(COLUMNS)) if not all(is_nothing(row[k]) for row in cells)]
    return tuple(COLUMNS[k] for k in named), tuple(tuple(row[k] for k in named) for row in cells)
