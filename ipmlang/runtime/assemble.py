"""From what an executor drew to a scene: numbers of texts become styles, colours and references.

In go rows of equal length in derivation order, whichever executor made them; out comes the scene
that exporters read. Nothing here derives, and no geometry is read.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import fail
from ipmlang.formats.distinct import distinct_rows
from ipmlang.runtime.residual import adjusted
from ipmlang.runtime.rows import TEXT_FIELDS, Rows
from ipmlang.runtime.scene import AssetRef, Groups, Instances, Origin, PenStyle, Scene

Framed = TypeVar("Framed", "Rows", Groups)


def scene(
    program: ir.Program,
    rows: Rows,
    polygons: tuple[NDArray[np.float64], ...] = (),
    *,
    seed: int,
    generations: int,
    shapes: int,
) -> Scene:
    """The scene of a derivation that made `shapes` shapes in `generations` steps."""
    if program.abop and program.flat:
        rows, polygons = _in_book_axes(rows, polygons)
    rows, polygons, notes = adjusted(program, rows, polygons)
    styles, style = _styles(program, rows)
    axiom = len(program.productions)
    instances = Instances(
        rows.position,
        rows.rotation,
        rows.scale,
        rows.size,
        rows.asset,
        rows.shape,
        style,
        rows.width,
        _colors(program, rows.color),
        rows.layer,
        rows.symbol,
        np.where(rows.rule < 0, np.int32(axiom), rows.rule),
        rows.key,
    )
    return Scene(
        instances,
        tuple(AssetRef(each.name, each.path, each.node, each.stretch) for each in program.assets),
        styles,
        tuple(symbol.name for symbol in program.symbols),
        tuple(_origin(program, each) for each in (*program.productions, program.axiom)),
        program.flat,
        polygons,
        program.canvas,
        program.canvas_size,
        program.up,
        generations,
        shapes,
        seed,
        notes=notes,
        groups=rows.groups,
        texture_maps=rows.texture_maps,
        decimals=program.decimals,
    )


def _in_book_axes(
    rows: Rows, polygons: tuple[NDArray[np.float64], ...]
) -> tuple[Rows, tuple[NDArray[np.float64], ...]]:
    """Mirrored in x: the published end points are those of a turtle whose left is along -y. In
    space it starts like that; in the plane it is a mirrored frame.
    """
    axes = np.array((1.0, -1.0, 1.0))
    groups = None if rows.groups is None else _mirrored(rows.groups, axes)
    made = replace(_mirrored(rows, axes), groups=groups)
    return made, tuple(corners * axes[: corners.shape[1]] for corners in polygons)


def _mirrored(framed: Framed, axes: NDArray[np.float64]) -> Framed:
    w, x, y, z = framed.rotation.T
    return replace(
        framed,
        position=framed.position * axes + 0.0,
        rotation=np.stack((z, x, y, w), axis=1),
        scale=-framed.scale,
    )


def _origin(program: ir.Program, production: ir.Production) -> Origin:
    name = "start" if production.symbol < 0 else program.symbols[production.symbol].name
    return Origin(production.path or program.path, name, production.line)


def _styles(program: ir.Program, rows: Rows) -> tuple[tuple[PenStyle, ...], NDArray[np.int32]]:
    """The distinct styles, the plain one first, and each row's number among them."""
    count = len(rows.scale)
    if not rows.texts:
        return (PenStyle(),), np.broadcast_to(np.int32(0), (count,))
    fields = [name for name in TEXT_FIELDS if name in rows.texts]
    plain = np.full((1, len(fields)), -1, np.int32)
    table = np.concatenate((plain, np.stack([rows.texts[name] for name in fields], axis=1)))
    first, number = distinct_rows(table.astype(np.float64))
    texts = [
        {name: program.strings[i] for name, i in zip(fields, row, strict=True) if i >= 0}
        for row in table[first].tolist()
    ]
    folder = Path(program.path).parent
    return tuple(_style(each, folder) for each in texts), number[1:].astype(np.int32)


def _style(texts: dict[str, str], folder: Path) -> PenStyle:
    declared = [texts.get("css", "").strip().rstrip(";")]
    declared += [f"{name}:{texts[name]}" for name in ("fill", "stroke") if name in texts]
    return PenStyle(
        ";".join(each for each in declared if each),
        texts.get("material", ""),
        folder / texts["texture"] if texts.get("texture") else None,
    )


def _colors(program: ir.Program, numbers: NDArray[np.int32]) -> NDArray[np.uint32]:
    """0xRRGGBBAA of each row, 0 where the pen sets none."""
    if numbers.max(initial=-1) < 0:
        return np.broadcast_to(np.uint32(0), (len(numbers),))
    distinct, place = np.unique(numbers, return_inverse=True)
    values = [color(program.strings[i]) if i >= 0 else 0 for i in distinct.tolist()]
    return np.array(values, np.uint32)[place.reshape(-1)]


def color(text: str) -> int:
    """0xRRGGBBAA of `#rgb`, `#rrggbb` or a CSS colour name.

    >>> hex(color("#2a6f4e")), hex(color("teal"))
    ('0x2a6f4eff', '0x8080ff')
    """
    from tinycss2.color3 import parse_color

    parsed = parse_color(text)
    if parsed is None or isinstance(parsed, str):
        raise fail("bad-color", f"`{text}` is no colour", hint="write `#rrggbb` or a CSS name")
    red, green, blue, alpha = (int(part * 255 + 0.5) for part in parsed)
    return red << 24 | green << 16 | blue << 8 | alpha
