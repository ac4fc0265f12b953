"""DAE (COLLADA) files to meshes and their copies, turned to z-up as the file says.

Takes a path; gives one mesh for each geometry with its materials and one copy for each node that
shows it. Lengths stay as they are; a note says what one is where that is not a metre. Animation,
light and cameras are passed over; a skinned shape is read as it was before it was posed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats import FormatError
from ipmlang.formats.dae_geometry import read_geometry
from ipmlang.formats.dae_shades import Shades
from ipmlang.formats.dae_xml import (
    children,
    descend,
    first,
    indexed,
    local_name,
    numbers,
    open_dae,
    target,
)
from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh_types import Mesh, MeshScene

if TYPE_CHECKING:
    from lxml.etree import _Element

Floats = NDArray[np.float64]

_UP = {
    "Y_UP": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "Z_UP": np.eye(3),
    "X_UP": np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]]),
}
"""What turns a file's axes to z-up."""
_DEEPEST, _MOST = 200, 1_000_000  # nodes in each other, copies in all


def read_dae(path: Path) -> MeshScene:
    """The scene of a DAE file."""
    root = open_dae(path.read_bytes())
    by_id = indexed(root)
    reader = _Reader(by_id, Shades(by_id, path.parent))
    turned = np.eye(4)
    turned[:3, :3] = _UP.get((descend(root, "asset", "up_axis") or "Y_UP").strip(), _UP["Y_UP"])
    for node in _roots(root, reader.by_id):
        reader.walk(node, turned, 0)
    return reader.scene(path.stem, (*_unit(root), *reader.shades.notes, *reader.notes.values()))


def _roots(root: _Element, by_id: dict[str, _Element]) -> Iterator[_Element]:
    """The nodes of the scene that is shown; of all scenes where none is named."""
    shown = first(root, "scene", "instance_visual_scene")
    scene = target(shown, by_id) if shown is not None else None
    libraries = children(root, "library_visual_scenes")
    every = [each for library in libraries for each in children(library, "visual_scene")]
    scenes = [scene] if scene is not None else every
    for each in scenes:
        yield from children(each, "node")


def _unit(root: _Element) -> tuple[Note, ...]:
    unit = first(root, "asset", "unit")
    metres = unit.get("meter", "1") if unit is not None else "1"
    try:
        plain = float(metres) == 1.0
    except ValueError:
        plain = True
    return () if plain else (Note("unit", f"a length of 1 is {metres} metres in the file"),)


@dataclass(slots=True)
class _Reader:
    """The copies found so far, in the order of the file's nodes."""

    by_id: dict[str, _Element]
    shades: Shades
    meshes: list[Mesh] = field(default_factory=list)
    number: dict[tuple[str, tuple[tuple[str, str], ...]], int] = field(default_factory=dict)
    copies: list[tuple[int, Floats, str]] = field(default_factory=list)
    notes: dict[str, Note] = field(default_factory=dict)

    def walk(self, node: _Element, outer: Floats, depth: int) -> None:
        """A node and all below it; one that holds itself is an error."""
        if depth > _DEEPEST or len(self.copies) > _MOST:
            raise FormatError("nodes of the file are nested too deeply, or hold themselves")
        matrix = outer @ _local(node)
        name = node.get("name") or node.get("id") or ""
        for each in node:
            match local_name(each):
                case "instance_geometry":
                    self._show(each, target(each, self.by_id), matrix, name)
                case "instance_controller":
                    self._pose(each, matrix, name)
                case "instance_node":
                    found = target(each, self.by_id)
                    if found is not None:
                        self.walk(found, matrix, depth + 1)
                case "node":
                    self.walk(each, matrix, depth + 1)

    def _pose(self, instance: _Element, matrix: Floats, name: str) -> None:
        controller = target(instance, self.by_id)
        skin = first(controller, "skin") if controller is not None else None
        if skin is None:
            return
        message = "skinned shapes were read as they are before they are posed"
        self.notes["skin"] = Note("skin", message)
        self._show(instance, self.by_id.get(skin.get("source", "")[1:]), matrix, name)

    def _show(
        self, instance: _Element, geometry: _Element | None, matrix: Floats, name: str
    ) -> None:
        if geometry is None:
            raise FormatError(f"a node shows `{instance.get('url', '')[:60]}`, which is not there")
        bound = tuple(
            (each.get("symbol", ""), each.get("target", ""))
            for holder in children(instance, "bind_material")
            for common in children(holder, "technique_common")
            for each in children(common, "instance_material")
        )
        key = (geometry.get("id", ""), bound)
        if key not in self.number:
            self.number[key] = len(self.meshes)
            mesh, notes = read_geometry(geometry, self.shades.bound(dict(bound)))
            self.meshes.append(mesh)
            for note in notes:
                old = self.notes.get(note.code)
                self.notes[note.code] = Note(
                    note.code, note.message, note.count + (old.count if old else 0)
                )
        self.copies.append((self.number[key], matrix, name or geometry.get("name", "")))

    def scene(self, stem: str, notes: tuple[Note, ...]) -> MeshScene:
        """All copies in columns."""
        names = list(dict.fromkeys(name for _, _, name in self.copies)) or [stem]
        where = {name: place for place, name in enumerate(names)}
        count = len(self.copies)
        return MeshScene(
            tuple(self.meshes),
            np.array([number for number, _, _ in self.copies], np.int64),
            np.array([matrix[:3] for _, matrix, _ in self.copies]).reshape(count, 3, 4),
            np.array([where[name] for _, _, name in self.copies], np.int64),
            np.full(count, -1, np.int64),
            tuple(names),
            notes=notes,
        )


def _local(node: _Element) -> Floats:
    """A node's own transform (4, 4): its steps, the first outermost."""
    whole = np.eye(4)
    for each in node:
        step = np.eye(4)
        match local_name(each):
            case "matrix":
                step = numbers(each, 16).reshape(4, 4)
            case "translate":
                step[:3, 3] = numbers(each, 3)
            case "scale":
                step[:3, :3] = np.diag(numbers(each, 3))
            case "rotate":
                step[:3, :3] = _rotation(numbers(each, 4))
            case _:
                continue
        whole = whole @ step
    return whole


def _rotation(values: Floats) -> Floats:
    """The turn by an angle in degrees about an axis: x, y, z, angle."""
    length = float(np.linalg.norm(values[:3])) or 1.0
    x, y, z = values[:3] / length
    angle = np.radians(values[3])
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return np.asarray(turn)
