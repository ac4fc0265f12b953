"""From a scene to picture files: one picture, or a turn around the model.

Takes meshes, a derived scene or what lies on the graphics card, and a `Look`; draws picture by
picture and writes what is asked for, whole or not at all. A flat drawing is handed to the writer
of drawings. Nothing is derived here.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from contextlib import closing
from dataclasses import replace
from itertools import repeat
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import fail
from ipmlang.formats import FormatError
from ipmlang.formats.atomic import write_files
from ipmlang.formats.mesh_types import MeshScene
from ipmlang.studio.camera import Camera, fitted, orbit
from ipmlang.studio.files import check_picture, contents
from ipmlang.studio.lights import SKIES, lights
from ipmlang.studio.look import Look
from ipmlang.studio.surfaces import Model, model_of

if TYPE_CHECKING:
    from ipmlang.runtime.gpu.table import Table
    from ipmlang.runtime.scene import Scene
    from ipmlang.studio.card_copies import CardCopies

Pixels = NDArray[np.uint8]

_STANDING, _MOVING = 8, 6  # passes of a picture that stands, and of one of many
_LEAST = 3
_WORK = 12_000_000  # triangles that a picture may cost before it is made with fewer passes


def draw(
    seen: MeshScene | Scene | Table,
    look: Look,
    path: Path,
    count: int | None = None,
    say: Callable[[str], None] | None = None,
) -> None:
    """Write one picture of a model or of what a grammar derived, or `count` of a turn around it.

    Raises IpmError for a name that says no format, where there is nothing to see, where a file is
    broken or cannot be written, and where there is no OpenGL.
    """
    check_picture(path, count)

    def told() -> Generator[Pixels, None, None]:
        for number, picture in enumerate(pictures_of(seen, look, count), start=1):
            if say is not None:
                say(f"drawing {path.name}: {number} of {count or 1}")
            yield picture

    try:
        with closing(told()) as pictures:  # and with it the context
            write_files(contents(path, pictures, count))
    except FormatError as error:
        raise fail("cannot-write", error.message, hint=error.hint) from error


def pictures_of(
    seen: MeshScene | Scene | Table, look: Look, count: int | None = None
) -> Iterator[Pixels]:
    """Pixels (height, width, 4) of one picture, or of each of `count` of a turn.

    A drawing is the same from all sides, and needs no OpenGL.
    """
    look = replace(look, size=look.pixels(count))
    from ipmlang.runtime.scene import Scene

    seen = as_seen(seen)
    if not isinstance(seen, Scene):
        return _pictures(seen, look, count)
    from ipmlang.studio.flat import flat_picture

    return repeat(flat_picture(seen, look), count or 1)


def as_seen(seen: MeshScene | Scene | Table) -> MeshScene | Scene | Table:
    """A derived scene as the model that is drawn, unless it is a drawing; all else as it is."""
    from ipmlang.runtime.scene import Scene

    if not isinstance(seen, Scene) or _is_drawing(seen):
        return seen
    from ipmlang.runtime.export.models import mesh_scene_of

    return mesh_scene_of(seen)


def _is_drawing(scene: Scene) -> bool:
    """Flat, and of drawn things alone: what is flat may also be models beside each other."""
    drawn = (".svg", ".svgz")
    return scene.flat and all(asset.path.suffix.lower() in drawn for asset in scene.assets)


def _pictures(seen: MeshScene | Table, look: Look, count: int | None) -> Iterator[Pixels]:
    from ipmlang.studio.context import gl_context
    from ipmlang.studio.stage import Stage

    with gl_context() as context:
        model, copies = _modelled(seen, look)
        size = look.pixels(count)
        if count is None:
            cameras = [fitted(model.outline, look.view, size)]
        else:
            cameras = orbit(model.outline, look.view, size, count)
        stage = Stage(context, model, look, copies)
        passes = _passes(model, copies, cameras[0], look, count)
        for number, camera in enumerate(cameras):
            azimuth = look.view.azimuth + 360 * number / len(cameras)
            yield stage.picture(camera, lights(azimuth, passes))


def _modelled(seen: MeshScene | Table, look: Look) -> tuple[Model, CardCopies | None]:
    """The model, and the copies of what lies on the card."""
    if isinstance(seen, MeshScene):
        return model_of(seen, lines=look.lines), None
    from ipmlang.studio.table_model import model_of_table

    return model_of_table(seen, lines=look.lines)


def _passes(
    model: Model, copies: CardCopies | None, camera: Camera, look: Look, count: int | None
) -> int:
    """How often a picture is drawn: less often what has very many triangles."""
    triangles = model.triangles
    if copies is not None:
        counts = copies.counts(camera, look.pixels(count)[0])
        triangles += int((counts * copies.kinds.triangles).sum())
    wanted = _STANDING if count is None else _MOVING
    return max(_LEAST, min(wanted, _WORK // (max(triangles, 1) * (2 + SKIES))))
