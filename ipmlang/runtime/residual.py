"""What no rule explains, terminal by terminal: the table of a `residual` applied to what was drawn.

In go rows in derivation order, whichever executor made them, and the outlines among them; out come
both with row k moved, turned, scaled and painted as row k of the table says, or that whose column
`of` says k. It happens before anything is joined or written, so each segment of a line is a
terminal of its own. Nothing is derived here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.runtime import scan
from ipmlang.runtime.rows import Rows
from ipmlang.runtime.scene import OUTLINES

Numbers: TypeAlias = NDArray[np.float64]
Polygons: TypeAlias = tuple[Numbers, ...]
Columns: TypeAlias = Mapping[str, Numbers]


def adjusted(
    program: ir.Program, rows: Rows, polygons: Polygons
) -> tuple[Rows, Polygons, tuple[str, ...]]:
    """Rows, polygons and what is to be said about them. Raises IpmError where the table does not
    fit what is drawn, unless a user changed that: then it is said, and no more.
    """
    if program.residual is None:
        return rows, polygons, ()
    table = program.tables[program.residual.table]
    cells = np.array(table.rows, np.float64).reshape(len(table.rows), len(table.columns))
    columns: Columns = dict(zip(table.columns, cells.T, strict=True))
    note = _misfit(table.name, columns, len(cells), len(rows.scale))
    if note is not None:
        if program.residual.strict:
            raise _error(note)
        return rows, polygons, (f"{note}: it is left out",)
    if "scale" in columns and not (columns["scale"] > 0).all():
        number = int(np.argmin(columns["scale"] > 0))
        raise fail(
            "out-of-range",
            f"row {number + 1:,} of the residual `{table.name}` has the scale "
            f"{columns['scale'][number]:g}, which must be above 0",
        )
    if "of" in columns:
        columns = _spread(columns, len(rows.scale))
    moved = _placed(rows, columns)
    return _painted(program, moved, columns), _outlines(moved, polygons, columns), ()


def _misfit(name: str, columns: Columns, given: int, drawn: int) -> str | None:
    """What is wrong with a residual of so many rows, for so many terminals drawn."""
    if "of" not in columns:
        if given == drawn:
            return None
        return f"the residual `{name}` has {given:,} rows, and {drawn:,} terminals are drawn"
    wanted = columns["of"]
    _, first = np.unique(wanted, return_index=True)
    wrong = (wanted < 0) | (wanted >= drawn) | (wanted != np.floor(wanted))
    wrong[np.setdiff1d(np.arange(given), first)] = True
    if not wrong.any():
        return None
    row = int(np.argmax(wrong))
    return (
        f"row {row + 1:,} of the residual `{name}` is of terminal {wanted[row]:g}, and {drawn:,} "
        "terminals are drawn, each of which has one row at most"
    )


def _spread(columns: Columns, drawn: int) -> Columns:
    """The columns with a row for each terminal; those that are not named are as they are, and take
    the numbers of the paint order that no row gives.
    """
    rows = columns["of"].astype(np.int64)
    made: dict[str, Numbers] = {}
    for name, column in columns.items():
        if name in ir.RESIDUAL_TEXTS:
            full = np.full(drawn, -1.0)
        elif name == "layer":
            full = np.zeros(drawn)
            others = np.setdiff1d(np.arange(drawn), rows)
            full[others] = np.setdiff1d(np.arange(drawn), column)[: len(others)]
        else:
            full = np.full(drawn, 1.0 if name == "scale" else 0.0)
        full[rows] = column
        made[name] = full
    return made


def _error(note: str) -> IpmError:
    return fail(
        "residual-rows",
        note,
        hint="a residual has a row for each terminal, in the order of the derivation, or a column "
        "`of` that numbers them from 0; without its line the drawing is regular",
    )


def _placed(rows: Rows, columns: Columns) -> Rows:
    """Moved in the axes of the file; turned and scaled each in its own frame."""
    move = np.stack([columns.get(axis, np.zeros(len(rows.scale))) for axis in "xyz"], axis=1)
    frames = ~np.isin(
        rows.asset, OUTLINES
    )  # corners are in world coordinates: they move by themselves
    position = rows.position + np.where(frames[:, None], move, 0.0)
    scale = rows.scale * np.where(frames, columns.get("scale", 1.0), 1.0)
    rotation = rows.rotation
    if "angle" in columns:
        turned = np.where(frames, columns["angle"] * np.sign(rows.scale), 0.0)
        rotation = _turned(rotation, turned)
    return replace(rows, position=position, rotation=rotation, scale=scale)


def _turned(rotation: Numbers, degrees: Numbers) -> Numbers:
    """Quaternions (n, 4) turned about their own z."""
    cosine, sine = scan.unit(degrees / 2)
    w, x, y, z = rotation.T
    return np.stack(
        (
            w * cosine - z * sine,
            x * cosine + y * sine,
            y * cosine - x * sine,
            z * cosine + w * sine,
        ),
        axis=1,
    )


def _painted(program: ir.Program, rows: Rows, columns: Columns) -> Rows:
    """Pen fields of a residual stand in for those of the pen; an empty text leaves them."""
    empty = program.strings.index("") if "" in program.strings else -1
    given = {
        name: np.where(columns[name] == empty, -1, columns[name]).astype(np.int32)
        for name in ir.RESIDUAL_TEXTS
        if name in columns
    }
    color, texts = rows.color, dict(rows.texts)
    if "color" in given:  # a colour is for both
        told = given.pop("color")
        color = np.where(told >= 0, told, color)
        for name in {"fill", "stroke"} & texts.keys():
            texts[name] = np.where(told >= 0, np.int32(-1), texts[name])
    for name, told in given.items():
        texts[name] = np.where(told >= 0, told, texts.get(name, np.int32(-1)))
    return replace(rows, color=color, texts=texts, layer=columns.get("layer", rows.layer))


def _outlines(rows: Rows, polygons: Polygons, columns: Columns) -> Polygons:
    """Polygons and paths moved, and turned and scaled about their first corners."""
    found = list(polygons)
    for row in np.flatnonzero(np.isin(rows.asset, OUTLINES)).tolist():
        number = int(rows.shape[row])
        corners = found[number]
        own = {name: float(column[row]) for name, column in columns.items()}
        angle = np.array([own.get("angle", 0.0)])
        turn = scan.about_z(angle)[0]
        cosine, sine = turn[0] ** 2 - turn[3] ** 2, 2 * turn[0] * turn[3]
        matrix = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        width = corners.shape[1]
        move = np.array([own.get(axis, 0.0) for axis in "xyz"])[:width]
        spread = (corners - corners[0]) @ matrix[:width, :width].T * own.get("scale", 1.0)
        found[number] = corners[0] + spread + move
    return tuple(found)
