"""The reader: a file in, a `Drawing` out; or one node of it by id, for assets.

The steps: parse, resolve styles, count, walk, place all outlines in one batch, settle the effects.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from ipmlang.formats import FormatError
from ipmlang.formats.drawing import Drawing, DrawnElement, Effect, Outline
from ipmlang.formats.svg.bounds import transform_segments
from ipmlang.formats.svg.cascade import Cascade, Computed
from ipmlang.formats.svg.conditions import CONDITIONS, holds
from ipmlang.formats.svg.context import Context, Placed, Source
from ipmlang.formats.svg.counting import count_elements
from ipmlang.formats.svg.effects import settle
from ipmlang.formats.svg.limits import Limits, Notes
from ipmlang.formats.svg.transforms import IDENTITY, Box
from ipmlang.formats.svg.units import length
from ipmlang.formats.svg.viewports import parse_view_box
from ipmlang.formats.svg.walk import Walk
from ipmlang.formats.svg.xml import Document, Node, read_document

_DEFAULT_SIZE = (300.0, 150.0)
"""What browsers give a drawing that has neither size nor viewBox."""
_CONTAINERS = frozenset({"symbol", "svg", "marker", "pattern", "clipPath", "mask", "defs"})
_LOST = Outline(
    np.zeros(0, np.uint8), np.zeros((0, 4, 2)), np.zeros(1, np.int32), np.zeros(0, np.bool_)
)
"""Stands for an outline whose coordinates cannot be used."""
_BATCH = 500_000
_FARTHEST = 1e100
"""Coordinates beyond this are as good as infinite: their squares and roundings overflow."""


def read_svg(source: Path | str | bytes, *, limits: Limits | None = None) -> Drawing:
    """All that a file draws, in the coordinates of its outermost viewBox.

    `source` is a path or the bytes of a file (gzip is unpacked). Raises `FormatError`, with the
    line where there is one, for what is not SVG or is past a limit; whatever else is wrong is
    skipped and counted in the drawing's notes.

    >>> drawing = read_svg(b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9">'
    ...                    b'<g fill="red"><rect width="50%" height="2"/></g></svg>')
    >>> drawing.elements[0].style.fill, drawing.elements[0].outline.coords[0, 1].tolist()
    ('#ff0000', [4.5, 0.0])
    """
    opened = _open(source, limits or Limits())
    return _drawings(opened, [opened.document.root])[0]


def read_node(path: Path | str, node_id: str, *, limits: Limits | None = None) -> Drawing:
    """What one element of a file draws, with its own transform but none of its parents', styles
    inherited. A container that is not drawn itself (symbol, marker, pattern) gives its content.

    Raises `FormatError` if there is no such element, as for `read_svg`.
    """
    return read_nodes(path, [node_id], limits=limits)[node_id]


def read_nodes(
    path: Path | str | bytes, node_ids: Iterable[str], *, limits: Limits | None = None
) -> dict[str, Drawing]:
    """The same for many elements of one file, which is taken apart once."""
    opened = _open(path, limits or Limits())
    nodes = {}
    for node_id in node_ids:
        node = opened.document.by_id.get(node_id)
        if node is None:
            where = "the file" if isinstance(path, bytes) else path
            raise FormatError(f"no element in {where} has the id `{node_id}`", hint=_known(opened))
        nodes[node_id] = node
    return dict(zip(nodes, _drawings(opened, list(nodes.values())), strict=True))


def svg_ids(path: Path | str, *, limits: Limits | None = None) -> set[str]:
    """The ids of a file's elements; raises `FormatError` if it cannot be read."""
    return set(read_document(path, limits or Limits(), Notes()).by_id)


def _known(source: Source) -> str | None:
    ids = sorted(source.document.by_id)
    if not ids:
        return "the file gives no element an id"
    more = f" and {len(ids) - 8} more" if len(ids) > 8 else ""
    return f"it has {', '.join(ids[:8])}{more}"


def _open(source: Path | str | bytes, limits: Limits) -> Source:
    notes = Notes()
    document = read_document(source, limits, notes)
    cascade = Cascade(document, limits, notes)
    left_out = (
        node
        for node in document.nodes
        if any(name in node.attributes for name in CONDITIONS) and not holds(node)
    )
    blends = any("mix-blend-mode" in cascade.specified(node) for node in document.nodes)
    return Source(document, cascade, limits, notes, frozenset(left_out), blends)


def _drawings(source: Source, nodes: Sequence[Node]) -> list[Drawing]:
    """The drawing of each node: of the whole file if it is the root."""
    document, root = source.document, source.document.root
    box, viewport = _root_box(document)
    width, height = (root.attributes.get(name) for name in ("width", "height"))
    walk = Walk(source)
    walked = [_walked(walk, source, node, viewport) for node in nodes]
    moved = iter(_moved(source, [one for found in walked for one in found]))
    made = []
    for found in walked:
        elements, effects = _settled(found, [next(moved) for _ in found])
        notes = source.notes.listed()
        made.append(Drawing(elements, box, width, height, effects, notes, document.source_bytes))
    return made


def _walked(
    walk: Walk, source: Source, node: Node, viewport: tuple[float, float]
) -> Sequence[Placed]:
    """What a node draws, in its own space."""
    root = source.document.root
    walk.begin(count_elements(source, node))
    if node is root or node.name in _CONTAINERS:
        style = source.cascade.in_document(node)
        if node is root:
            _note_root(source, style)
        if style.own.get("display") != "none":
            context = walk.inside(node, Context(style, viewport))
            walk.run((child, context) for child in node.children)
    else:
        above = node.parent or root
        walk.run([(node, Context(source.cascade.in_document(above), viewport))])
    return walk.placed


def _note_root(source: Source, style: Computed) -> None:
    root = source.document.root
    line = root.line
    if "background" in style.own or "background-color" in style.own:
        source.notes.add("background", "the background of the page is no part of the drawing", line)
    fitting = root.attributes.get("preserveAspectRatio", "").split()
    if fitting not in ([], ["xMidYMid"], ["xMidYMid", "meet"]):
        note = "the preserveAspectRatio of <svg> itself is left out"
        source.notes.add("root-fitting", note, line)
    if "transform" in style.own:
        source.notes.add("root-transform", "the transform of <svg> itself is left out", line)


def _root_box(document: Document) -> tuple[Box | None, tuple[float, float]]:
    """The drawing's box, and the size of the viewport that percentages refer to."""
    root = document.root
    box = parse_view_box(root.attributes.get("viewBox"))
    if box is not None and box[2] > 0 and box[3] > 0:
        return box, (box[2], box[3])
    sizes = [_root_size(root, name) for name in ("width", "height")]
    width, height = (
        usual if size is None else size for size, usual in zip(sizes, _DEFAULT_SIZE, strict=True)
    )
    known = None not in sizes and width > 0 and height > 0
    return ((0.0, 0.0, width, height) if known else None), (width, height)


def _root_size(root: Node, name: str) -> float | None:
    """An absolute size in pixels; None for percentages and what cannot be read."""
    text = root.attributes.get(name, "")
    return None if "%" in text else length(text)


def _moved(source: Source, found: Sequence[Placed]) -> list[Outline | None]:
    """The outlines in the world, None for what has none; _LOST where no coordinate is usable."""
    outlines: list[Outline | None] = [None] * len(found)
    shapes = [index for index, one in enumerate(found) if one.outline is not None]
    for first, last in _batches([_segments(found[index]) for index in shapes]):
        batch = shapes[first:last]
        moved, finite = _placed_batch([found[index] for index in batch])
        for index, outline, is_finite in zip(batch, moved, finite, strict=True):
            outlines[index] = outline if is_finite else _LOST
            if not is_finite:
                line = found[index].line
                source.notes.add("not-finite", "coordinates without a usable value: left out", line)
    return outlines


def _settled(
    found: Sequence[Placed], outlines: Sequence[Outline | None]
) -> tuple[tuple[DrawnElement, ...], dict[str, Effect]]:
    """The elements with their styles, those without usable coordinates left out."""
    kept = [index for index, outline in enumerate(outlines) if outline is not _LOST]
    if len(kept) < len(found):
        found, outlines = [found[index] for index in kept], [outlines[index] for index in kept]
    styles, effects = settle(found, outlines)
    elements = (
        DrawnElement(outline, style, one.fragment, one.source, _space(one))
        for one, outline, style in zip(found, outlines, styles, strict=True)
    )
    return tuple(elements), effects


def _space(one: Placed) -> tuple[float, float, float, float] | None:
    """The linear part of an element's map; None for that of numbers which are the drawing's."""
    linear = one.matrix[:4]
    return None if linear == IDENTITY[:4] or one.fragment is not None else linear


def _segments(one: Placed) -> int:
    return 0 if one.outline is None else len(one.outline.kind)


def _batches(sizes: Sequence[int]) -> list[tuple[int, int]]:
    """Runs of elements that are placed together, so that memory stays bounded."""
    bounds, start, total = [], 0, 0
    for index, size in enumerate(sizes):
        total += size
        if total >= _BATCH:
            bounds.append((start, index + 1))
            start, total = index + 1, 0
    return [*bounds, (start, len(sizes))] if start < len(sizes) else bounds


def _placed_batch(found: Sequence[Placed]) -> tuple[list[Outline], list[bool]]:
    """Outlines mapped by their matrices in one pass, and which of them are finite."""
    outlines = [one.outline for one in found if one.outline is not None]
    counts = np.array([len(outline.kind) for outline in outlines])
    ends = np.cumsum(counts)
    kind = np.concatenate([outline.kind for outline in outlines])
    coords = np.concatenate([outline.coords for outline in outlines])
    matrices = np.repeat(np.array([one.matrix for one in found]), counts, axis=0)
    with np.errstate(invalid="ignore", over="ignore"):
        moved = transform_segments(kind, coords, matrices)
        usable = (np.abs(moved) < _FARTHEST).all(axis=(1, 2))
    finite = np.logical_and.reduceat(usable, ends - counts)
    placed = [
        Outline(outline.kind, moved[end - len(outline.kind) : end], outline.starts, outline.closed)
        for outline, end in zip(outlines, ends.tolist(), strict=True)
    ]
    return placed, finite.tolist()
