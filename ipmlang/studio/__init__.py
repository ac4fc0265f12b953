"""Pictures of models: what a grammar derives or a file holds, lit and seen through a camera.

Takes a scene or meshes and a `Look`; gives pixels and picture files. OpenGL draws without a window,
on a graphics card or in software; where there is neither, an `IpmError` says what to install.
Nothing is derived here, and nothing is printed.
"""

from __future__ import annotations

from ipmlang.studio.files import check_picture
from ipmlang.studio.look import Look, View
from ipmlang.studio.render import as_seen, draw, pictures_of

__all__ = ["Look", "View", "as_seen", "check_picture", "draw", "pictures_of"]
