"""A scene to a file by its suffix: drawings as svg and png, models as obj, glb, ply and stl.

Takes a scene and a path; the file appears whole or not at all. What cannot be written is an
`IpmError` that says why. Nothing is derived here, and nothing is printed.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ipmlang.compiler.diagnostics import fail, nearest
from ipmlang.formats import FormatError
from ipmlang.formats.atomic import Content, write_files
from ipmlang.formats.drawing import Note
from ipmlang.runtime.scene import Scene

__all__ = ["SUFFIXES", "check_output", "save"]

SUFFIXES = (".svg", ".png", ".obj", ".glb", ".ply", ".stl")


def check_output(path: Path | str) -> None:
    """Refuse, before any work, a file that `save` could not write."""
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        known = f"{', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}"
        meant = nearest(suffix, SUFFIXES)
        raise fail(
            "unknown-format",
            f"`{path.name}` does not say what to write",
            hint=f"name a file that ends in {f'`{meant[0]}`, say, or ' if meant else ''}{known}",
        )
    if not path.absolute().parent.is_dir():
        raise fail(
            "cannot-write",
            f"cannot write `{path}`: there is no folder `{path.parent}`",
            hint="make the folder first, or name a file in one that exists",
        )


def save(scene: Scene, path: Path | str, *, instancing: bool = False) -> tuple[str, ...]:
    """Write a scene to `path`; its suffix says how. Gives a sentence for each thing that assets of
    a model hold and that was left out.

    `instancing`: let a glb use EXT_mesh_gpu_instancing, which is smaller but which fewer programs
    read. Raises `IpmError` for an unknown suffix, a scene that the format cannot hold, an asset
    that cannot be read, and a file that cannot be written.
    """
    path = Path(path)
    check_output(path)
    try:
        contents, notes = _contents(scene, path, instancing)
        write_files(contents)
    except FormatError as error:
        raise fail("cannot-write", error.message, hint=error.hint) from error
    return tuple(_sentence(note) for note in notes)


def _sentence(note: Note) -> str:
    return note.message + (f" ({note.count:,})" if note.count > 1 else "")


def _contents(
    scene: Scene, path: Path, instancing: bool
) -> tuple[Mapping[Path, Content], tuple[Note, ...]]:
    """The files of the result, by path, and notes on the assets of a model."""
    suffix = path.suffix.lower()
    if suffix in (".svg", ".png"):
        from ipmlang.runtime.export.sheet import drawing_of

        drawing = drawing_of(scene)
        if suffix == ".svg":
            from ipmlang.formats.svg.write import write_svg

            return {path: write_svg(drawing)}, ()
        from ipmlang.formats.png import png_bytes

        return {path: png_bytes(drawing)}, ()
    from ipmlang.formats.mesh import mesh_contents
    from ipmlang.runtime.export.models import mesh_scene_of

    model = mesh_scene_of(scene)
    return mesh_contents(model, path, up=scene.up, instancing=instancing), model.notes
