"""A model on the graphics card, and pictures of it: many passes, each through a slightly different
spot of every pixel and under other lights, added up.

Takes a `Model` once, perhaps copies that are made on the card for each camera, and cameras one
after the other; gives pixels. A pass draws what is seen, then a shadow for each of its lights, then
the light. The same model gives the same pixels each time; only among copies made on the card may
faces that lie in each other win by turns.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ipmlang.studio.camera import Camera
from ipmlang.studio.card import Drawn, bind, columns, image_on, program_of, set_values
from ipmlang.studio.lights import BOUNCE, SKIES, SKY, SUN, Lights, shadow_matrix
from ipmlang.studio.look import Look
from ipmlang.studio.surfaces import Model

if TYPE_CHECKING:
    import moderngl

    from ipmlang.studio.card_copies import CardCopies

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]

_SUN_SIDE, _SKY_SIDE = 1.0, 0.4  # of a shadow's picture, as shares of the picture's longer side
_REACH, _FADE = 4.4, 2.0  # how far the ground goes, and where its shadows begin to fade
_SHARP = 1.15  # pixels that the passes of one spread over: a little more looks smoother
_TEN_BITS = 0x8059  # GL_RGB10_A2: fine enough for normals, and two bits for the kind of surface


class Stage:
    """What lies on the card; lives no longer than its context, which releases it."""

    def __init__(
        self,
        context: moderngl.Context,
        model: Model,
        look: Look,
        copies: CardCopies | None = None,
    ) -> None:
        self.context = context
        self.copies = copies
        self.model = model
        self.look = look
        self.size = look.pixels(None)
        self.level = float(model.outline[:, 2].min())
        self.programs = {
            "surface": program_of(context, "surface", "surface"),
            "shadow": program_of(context, "surface", "shadow" if model.clear else "depth"),
            "line": program_of(context, "line", "line"),
            "ground": program_of(context, "ground", "ground"),
            "light": program_of(context, "screen", "light"),
            "finish": program_of(context, "screen", "finish"),
        }
        images = [image_on(context, each) for each in model.images]
        self.drawn = [Drawn(context, self.programs, each, images) for each in model.surfaces]
        if copies is not None:
            self.drawn += copies.drawn(self.programs)
        self.plain = {
            name: context.vertex_array(self.programs[name], [])
            for name in ("ground", "light", "finish")
        }
        self._make_frames(self.size)

    def picture(self, camera: Camera, lights: Lights) -> Pixels:
        """Pixels (height, width, 4) of the model, the upper row first."""
        if self.copies is not None:
            self.copies.see(camera, self.size[0])
        passes = len(lights.direction)
        turns = _turns(passes)
        self.sum.clear()
        for number in range(passes):
            shift = _shift(number, self.size)
            self._draw_seen(camera, camera.matrix(shift), turns[0, number], passes)
            matrices = [
                shadow_matrix(each, self.model.outline) for each in lights.direction[number]
            ]
            self._draw_shadows(matrices, turns[1, number], passes)
            self._add_light(camera, camera.rays(shift), np.stack(matrices), lights, number)
        return self._finished()

    def _make_frames(self, size: tuple[int, int]) -> None:
        """The pictures that passes draw into."""
        context = self.context
        self.seen = {
            "depths": context.depth_texture(size),
            "facings": context.texture(size, 4, internal_format=_TEN_BITS),
            "colors": context.texture(size, 4),
        }
        self.seen["depths"].compare_func = ""
        total = context.texture(size, 4, dtype="f4")
        for each in (*self.seen.values(), total):
            each.filter = context.NEAREST, context.NEAREST
        seen = [self.seen["facings"], self.seen["colors"]]
        self.seen_frame = context.framebuffer(seen, self.seen["depths"])
        self.sum = context.framebuffer([total])
        self.total = {"light": total}
        self.result = context.simple_framebuffer(size)
        shares = (_SUN_SIDE, *[_SKY_SIDE] * SKIES)
        sides = [min(max(round(share * max(size)), 256), 4096) for share in shares]
        shadows = [context.depth_texture((side, side)) for side in sides]
        for shadow in shadows:
            shadow.repeat_x = shadow.repeat_y = False
        self.shadows = {f"shadow_{number}": shadow for number, shadow in enumerate(shadows)}
        self.shadow_frames = [context.framebuffer(depth_attachment=each) for each in shadows]

    def _draw_seen(self, camera: Camera, matrix: Floats, turn: float, passes: int) -> None:
        context, programs = self.context, self.programs
        self.seen_frame.use()
        self.seen_frame.clear(depth=1.0)
        context.enable_only(context.DEPTH_TEST)
        place = {"projection": columns(matrix), "eye": camera.eye}
        set_values(programs["surface"], {**place, "turn": turn, "passes": passes})
        for each in self.drawn:
            each.draw("surface")
        if self.look.lines:
            set_values(programs["line"], place)
            for each in self.drawn:
                each.draw_edges(context.LINES)
        if self.look.ground and camera.eye[2] > self.level:
            set_values(programs["ground"], {**place, "level": self.level, "reach": _REACH})
            # Faces that lie on the ground would flicker into it: it stands back.
            context.polygon_offset = 1.0, 64.0
            self.plain["ground"].render(context.TRIANGLE_STRIP, vertices=4)
            context.polygon_offset = 0.0, 0.0

    def _draw_shadows(self, matrices: list[Floats], turn: float, passes: int) -> None:
        context, program = self.context, self.programs["shadow"]
        context.polygon_offset = 1.5, 4.0
        for frame, matrix in zip(self.shadow_frames, matrices, strict=True):
            frame.use()
            frame.clear(depth=1.0)
            set_values(program, {"projection": columns(matrix), "turn": turn, "passes": passes})
            for each in self.drawn:
                # Of what is closed, the faces on either side cast the whole shadow.
                half = each.closed and not self.model.clear
                context.enable_only(context.DEPTH_TEST | (context.CULL_FACE if half else 0))
                each.draw("shadow")
        context.polygon_offset = 0.0, 0.0

    def _add_light(
        self, camera: Camera, rays: Floats, into_shadow: Floats, lights: Lights, number: int
    ) -> None:
        context, program = self.context, self.programs["light"]
        sides = np.array([shadow.width for shadow in self.shadows.values()])
        depth = camera.far - camera.near
        set_values(
            program,
            {
                "rays": columns(rays),
                "eye": camera.eye,
                "planes": (camera.far * camera.near / depth, camera.far / depth),
                "into_shadow": columns(into_shadow),
                "texel": 2 / np.linalg.norm(into_shadow[:, :2, :3], axis=2).min(axis=1) / sides,
                "direction": lights.direction[number],
                "sun_light": SUN,
                "sky_light": SKY,
                "sky_share": lights.share[number],
                "bounce": BOUNCE,
                "open_ground": lights.open_ground,
                "fade": _FADE,
                "share": 1 / len(lights.direction),
            },
        )
        bind(program, {**self.seen, **self.shadows})
        self.sum.use()
        context.enable_only(context.BLEND)
        context.blend_func = context.ONE, context.ONE
        self.plain["light"].render(context.TRIANGLES, vertices=3)

    def _finished(self) -> Pixels:
        context, program = self.context, self.programs["finish"]
        behind = self.look.background
        set_values(program, {"backdrop": behind is None, "background": behind or (0.0,) * 4})
        bind(program, self.total)
        self.result.use()
        context.enable_only(context.NOTHING)
        self.plain["finish"].render(context.TRIANGLES, vertices=3)
        across, down = self.size
        pixels = np.frombuffer(self.result.read(components=4, alignment=1), np.uint8)
        return pixels.reshape(down, across, 4)[::-1].copy()


def _shift(number: int, size: tuple[int, int]) -> tuple[float, float]:
    """Where in a pixel a pass looks, in half pictures: evenly spread, however many there are."""
    x, y = (
        2 * _SHARP * ((0.5 + share * (number + 1)) % 1.0 - 0.5) / side
        for share, side in zip((0.7548776662466927, 0.5698402909980532), size, strict=True)
    )  # powers of the plastic number, the golden ratio of the plane
    return x, y


def _turns(passes: int) -> Floats:
    """(2, p) the opacity that a surface needs to be seen in each pass, and to cast a shadow: in
    another order, so that what is seen through a surface may still lie in its shadow.
    """
    order = np.argsort(np.argsort(np.arange(passes) * 0.6180339887498949 % 1.0))
    return (np.stack([np.arange(passes), order]) + 0.5) / passes
