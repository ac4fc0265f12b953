"""Programs, columns and images on the graphics card.

Takes shader names, a `Surface`, a material; gives what OpenGL holds of them, which lives as long as
its context. What is drawn with these, in which order, is the stage's to say.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import fail
from ipmlang.formats.mesh_types import Material
from ipmlang.studio.surfaces import Surface

if TYPE_CHECKING:
    import moderngl

Pixels = NDArray[np.uint8]
Value: TypeAlias = "NDArray[np.float64] | tuple[float, ...] | float | bool"

_SIDE = 4096  # pixels of an image on a surface: more are not seen in a picture
COPY = 52  # bytes of a copy
_COPIES = "4f 4f 4f 4f1/i", "row_x", "row_y", "row_z", "paint"


def program_of(context: moderngl.Context, vertex: str, fragment: str) -> moderngl.Program:
    """The program of two of the files in `shaders`."""
    folder = files("ipmlang.studio") / "shaders"
    return context.program(
        vertex_shader=(folder / f"{vertex}.vert").read_text(encoding="utf-8"),
        fragment_shader=(folder / f"{fragment}.frag").read_text(encoding="utf-8"),
    )


def set_values(program: moderngl.Program, values: Mapping[str, Value]) -> None:
    """Uniforms by name: numbers, arrays, matrices; those that the program does not use are left
    out. A matrix, or a row of them, is (…, k, k).
    """
    import moderngl

    for name, value in values.items():
        member = program.get(name, None)
        if not isinstance(member, moderngl.Uniform):
            continue
        if isinstance(value, np.ndarray):
            member.write(value.astype(np.float32).tobytes())
        else:
            member.value = value


def columns(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrices (…, k, k) in the order that OpenGL keeps them in."""
    return np.swapaxes(matrix, -1, -2)


def bind(program: moderngl.Program, textures: Mapping[str, moderngl.Texture]) -> None:
    """Textures by the names that the program gives them."""
    for unit, (name, texture) in enumerate(textures.items()):
        texture.use(unit)
        set_values(program, {name: unit})


class Drawn:
    """A surface on the card, ready for the programs that draw it: `surface`, `shadow`, `line`. Its
    copies are its own, or lie in a buffer that others are in as well.
    """

    def __init__(
        self,
        context: moderngl.Context,
        programs: Mapping[str, moderngl.Program],
        surface: Surface,
        images: Sequence[moderngl.Texture],
    ) -> None:
        self.parts = surface.parts
        self.closed = surface.closed
        self.images = images
        self.count = len(surface.matrix)
        self.programs = programs
        self.commands: moderngl.Buffer | None = None
        self._context = context
        self._corners = context.buffer(_corner_table(surface))
        self._index = context.buffer(surface.triangles.tobytes())
        self._ends = context.buffer(surface.edges.tobytes()) if len(surface.edges) else None
        self._vertices = 2 * len(surface.edges)
        self.take_copies(context.buffer(_copy_table(surface)))

    def take_copies(self, buffer: moderngl.Buffer) -> None:
        """Draw copies that lie in this buffer from now on, 52 bytes each."""
        context, programs, copies = self._context, self.programs, (buffer, *_COPIES)
        corners = (self._corners, "3f 4f2 4f1 2f", "position", "normal", "color", "uv")
        self.arrays = {
            name: context.vertex_array(
                programs[name], [corners, copies], self._index, skip_errors=True
            )
            for name in ("surface", "shadow")
        }
        if self._ends is not None:
            ends = (self._ends, "3f", "position")
            array = context.vertex_array(programs["line"], [ends, copies], skip_errors=True)
            self.arrays["line"] = array

    def show(self, count: int, begin: int) -> None:
        """Draw so many copies, those from `begin` on in their buffer. Needs OpenGL 4.3."""
        self.count = count
        triangles = [(3 * many, count, 3 * first, 0, begin) for first, many, _ in self.parts]
        edges = [(self._vertices, count, 0, begin, 0)]
        table = np.array([*triangles, *edges], np.uint32)
        self.commands = self._context.buffer(table.tobytes())

    def draw(self, name: str) -> None:
        """Draw all copies with one of the programs, image by image."""
        program = self.programs[name]
        for number, (first, count, image) in enumerate(self.parts if self.count else ()):
            set_values(program, {"textured": image >= 0})
            if image >= 0:
                bind(program, {"image": self.images[image]})
            array = self.arrays[name]
            if self.commands is not None:
                array.render_indirect(self.commands, count=1, first=number)
            else:
                array.render(vertices=3 * count, first=3 * first, instances=self.count)

    def draw_edges(self, mode: int) -> None:
        """Draw the edges of all copies."""
        array = self.arrays.get("line")
        if array is None or not self.count:
            return
        if self.commands is not None:
            array.render_indirect(self.commands, mode, count=1, first=len(self.parts))
        else:
            array.render(mode, instances=self.count)


def image_on(context: moderngl.Context, material: Material) -> moderngl.Texture:
    """The image on a material, also for the smallest of its faces."""
    pixels = image_pixels(material)
    down, across = pixels.shape[:2]
    texture = context.texture((across, down), 4, pixels.tobytes())
    texture.build_mipmaps()
    texture.filter = context.LINEAR_MIPMAP_LINEAR, context.LINEAR
    return texture


def image_pixels(material: Material) -> Pixels:
    """The image (height, width, 4) on a material, its lowest row first. Its own opacity counts as
    the material says. An `IpmError` if it cannot be read.
    """
    from PIL import Image

    from ipmlang.formats import FormatError
    from ipmlang.formats.textures import texture_bytes

    if material.texture is None:
        return np.full((1, 1, 4), 255, np.uint8)
    try:
        with Image.open(io.BytesIO(texture_bytes(material.texture))) as image:
            image.thumbnail((_SIDE, _SIDE))
            pixels = np.array(image.convert("RGBA"))
    except FormatError as error:
        raise fail("bad-asset", error.message, hint=error.hint) from error
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        message = f"the image {material.texture.name} cannot be read: {error}"
        raise fail("bad-asset", message) from error
    if material.alpha == "":
        pixels[:, :, 3] = 255
    elif material.alpha == "MASK":
        pixels[:, :, 3] = np.where(pixels[:, :, 3] >= 128, 255, 0)
    return np.ascontiguousarray(pixels[::-1])


def _corner_table(surface: Surface) -> bytes:
    """The corners' columns side by side, 32 bytes a corner."""
    kinds = [("position", "3f4"), ("normal", "4f2"), ("color", "4u1"), ("uv", "2f4")]
    table = np.zeros(len(surface.position), kinds)
    table["position"], table["normal"] = surface.position, surface.normal
    table["color"], table["uv"] = surface.color, surface.uv
    return table.tobytes()


def _copy_table(surface: Surface) -> bytes:
    """The copies' matrices and paints side by side, 52 bytes a copy."""
    table = np.zeros(len(surface.matrix), [("matrix", "12f4"), ("paint", "4u1")])
    table["matrix"] = surface.matrix.reshape(-1, 12)
    table["paint"] = surface.paint
    return table.tobytes()
