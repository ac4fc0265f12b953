"""Pictures of flat scenes: the drawing that `run` would write, as large as it fits.

Takes a derived scene and a `Look`; gives pixels. There is no camera here, and no light: a drawing
has its own colours.
"""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import fail
from ipmlang.formats import FormatError
from ipmlang.formats.png import png_bytes
from ipmlang.formats.svg.write import fitted_box
from ipmlang.runtime.export.sheet import drawing_of
from ipmlang.runtime.scene import Scene
from ipmlang.studio.look import Look

Pixels = NDArray[np.uint8]

_PAPER = (1.0, 1.0, 1.0, 1.0)


def flat_picture(scene: Scene, look: Look) -> Pixels:
    """Pixels (height, width, 4) of a drawing in the middle of the picture; white behind it, unless
    the look says otherwise. An `IpmError` if it cannot be drawn.
    """
    from PIL import Image

    drawing = drawing_of(scene)
    across, down = look.pixels(None)
    box = drawing.box if drawing.box is not None else fitted_box(drawing.elements)
    tall = box[3] / box[2] if box[2] > 0 else 1.0
    wide = max(1, min(across, round(down / tall) if tall > 0 else across))
    try:
        content = png_bytes(drawing, wide, transparent=True)
    except FormatError as error:
        raise fail("cannot-draw", error.message, hint=error.hint) from error
    behind = tuple(round(255 * part) for part in look.background or _PAPER)
    sheet = Image.new("RGBA", (across, down), behind)
    with Image.open(io.BytesIO(content)) as image:
        drawn = image.convert("RGBA").crop(
            (0, 0, min(image.width, across), min(image.height, down))
        )
        sheet.alpha_composite(drawn, ((across - drawn.width) // 2, (down - drawn.height) // 2))
    return np.array(sheet)
