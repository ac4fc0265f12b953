"""Assets of a model: each one a mesh, read from its file once.

In go references, out come meshes in their own space and what the readers noted. An asset that is no
model, or whose file is wrong, is an `IpmError`. Where copies stand is not known here.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ipmlang.compiler.diagnostics import fail
from ipmlang.formats import FormatError
from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh_types import Mesh, stretched
from ipmlang.runtime.scene import AssetRef


def model_assets(assets: Iterable[AssetRef]) -> tuple[dict[AssetRef, Mesh], tuple[Note, ...]]:
    """The meshes of the assets; a file that several are parts of is read once for all."""
    files: dict[Path, list[AssetRef]] = {}
    for asset in assets:
        _check_model(asset)
        files.setdefault(asset.path, []).append(asset)
    meshes: dict[AssetRef, Mesh] = {}
    notes: dict[Note, None] = {}
    for path, parts in files.items():
        for asset, (mesh, said) in zip(parts, _read(path, parts), strict=True):
            meshes[asset] = mesh
            notes.update(dict.fromkeys(said))
    return meshes, tuple(notes)


def _check_model(asset: AssetRef) -> None:
    if asset.path.suffix.lower() in (".svg", ".svgz"):
        raise fail(
            "not-a-model",
            f"the asset `{asset.name}` is a drawing: {asset.path.name}",
            hint="write .svg or .png; a model takes assets from glb, obj, ply and stl files",
        )


def _read(path: Path, assets: list[AssetRef]) -> list[tuple[Mesh, tuple[Note, ...]]]:
    from ipmlang.formats.known_parts import part_meshes

    try:
        found = part_meshes(path, [asset.node for asset in assets])
    except FormatError as error:
        place = f"{path.name}:{error.line}" if error.line else path.name
        raise fail("bad-asset", f"{place}: {error.message}", hint=error.hint) from error
    return [
        (stretched(mesh, asset.stretch), tuple(_of_file(path, note) for note in notes))
        for asset, (mesh, notes) in zip(assets, found, strict=True)
    ]


def _of_file(path: Path, note: Note) -> Note:
    return Note(note.code, f"{path.name}: {note.message}", note.count)
