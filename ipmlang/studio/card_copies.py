"""Copies of meshes made on the graphics card, of terminals that a derivation left there.

Takes a `Table`; gives what a stage draws: for each camera the copies that its picture can show, in
a buffer of the same card, so that no terminal ever comes to the CPU. What comes back are counts and
a hundred points that say how far the table reaches.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.mesh_types import Material
from ipmlang.runtime.gpu import isa
from ipmlang.runtime.gpu.memory import Rows
from ipmlang.runtime.gpu.storage import Storage
from ipmlang.runtime.gpu.table import Table
from ipmlang.runtime.scene import SEGMENT
from ipmlang.studio.camera import Camera
from ipmlang.studio.card import COPY, Drawn, image_on
from ipmlang.studio.kinds import Kinds

if TYPE_CHECKING:
    import moderngl

Floats = NDArray[np.float64]
Counts = NDArray[np.uint32]

GROUP = 64  # threads of a work group
LEAST = 0.5  # pixels that the largest side of a copy has in a picture, or chance decides
FEW = 2.0  # pixels across of a mesh that a box may stand for
_ACROSS = 1 << 14  # work groups side by side
_SURVEYORS = 256  # work groups that go over a whole table
POINT = 16  # bytes of a point that a thread found
WAYS = 24  # along which a table is measured at a time
TERMINALS, KINDS, COLORS, COUNTS, OUTPUT = range(5)  # bindings


class CardCopies:
    """The copies of a table for one camera after the other."""

    def __init__(
        self,
        table: Table,
        kinds: Kinds,
        images: tuple[Material, ...],
        middle: Floats,
        size: float,
    ) -> None:
        self.table = table
        self.card = table.card
        self.kinds = kinds
        self.images = images
        self.middle, self.size = middle, size
        self._shader = self.card.compile(source("copies"), "copies")
        self._parts = [_Part(rows) for rows in table.parts]
        self._kinds = self.card.buffer(kinds.numbers.tobytes())
        self._colors = self.card.buffer(kinds.colors.tobytes())
        self._counts = self.card.buffer(4 * len(kinds.numbers))

    def drawn(self, programs: Mapping[str, moderngl.Program]) -> list[Drawn]:
        """What draws the copies; there are none before `see`."""
        images = [image_on(self.card.context, each) for each in self.images]
        for part in self._parts:
            part.drawn = [
                Drawn(self.card.context, programs, surface, images)
                for surface in self.kinds.surfaces
            ]
        return [each for part in self._parts for each in part.drawn]

    def counts(self, camera: Camera, across: int) -> NDArray[np.int64]:
        """How many copies (p, k) of each kind a camera sees, in each part of the table."""
        seen = _seen_from(camera, across)
        return np.array([self._run(part, self._none(), seen) for part in self._parts], np.int64)

    def see(self, camera: Camera, across: int) -> None:
        """Make the copies that a camera sees in a picture that is so many pixels wide."""
        seen = _seen_from(camera, across)
        for part, counts in zip(self._parts, self.counts(camera, across), strict=True):
            starts = np.cumsum(counts) - counts
            self._make_room(part, int(counts.sum()))
            self._run(part, starts.astype(np.uint32), seen, part.copies)
            for kind, drawn in zip(self.kinds.used, part.drawn, strict=True):
                drawn.show(int(counts[kind]), int(starts[kind]))

    def _none(self) -> Counts:
        return np.zeros(len(self.kinds.numbers), np.uint32)

    def _make_room(self, part: _Part, count: int) -> None:
        """A buffer for so many copies, the old one if it is large enough."""
        if part.copies is not None and part.copies.size >= count * COPY:
            return
        part.copies = self.card.buffer(max(count, 1) * COPY)
        for drawn in part.drawn:
            drawn.take_copies(part.copies.raw)

    def _run(
        self,
        part: _Part,
        starts: Counts,
        values: Mapping[str, object],
        output: Storage | None = None,
    ) -> Counts:
        """Count the copies of each kind, or write them from `starts` on; the counts after it."""
        self._counts.write(starts)
        set_all(self._shader, {**values, "size": self.size, "counting": output is None})
        bind_table(self._shader, self.table, part.rows, self.middle, self.kinds.thin)
        for binding, storage in (
            (KINDS, self._kinds), (COLORS, self._colors), (COUNTS, self._counts),
            (OUTPUT, output or self._counts),
        ):  # fmt: skip
            storage.bind(binding)
        groups = -(-part.rows.count // GROUP)
        self.card.dispatch(self._shader, (min(groups, _ACROSS), -(-groups // _ACROSS)), "copies")
        return self._counts.array(np.uint32)


def _seen_from(camera: Camera, across: int) -> dict[str, object]:
    """What the shader must know of a camera whose picture is so many pixels wide."""
    return {
        "eye": tuple(camera.eye.tolist()),
        "forward": tuple(camera.axes[2].tolist()),
        "near": camera.near,
        "focal": across / (2 * float(camera.lens[0])),
    }


@dataclass(slots=True, eq=False)
class _Part:
    """A part of the table, its copies, and what draws them, kind by kind."""

    rows: Rows
    copies: Storage | None = None
    drawn: list[Drawn] = field(default_factory=list)


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """What a table holds: how many of each kind, which texts are colours, whether a segment has no
    width of its own; reach (w, 2): how far it goes along each way that was asked and against it,
    from the middle, and points (w, 2, 3) where.
    """

    counts: NDArray[np.int64]
    colors: NDArray[np.int64]
    unset: bool
    reach: Floats
    points: Floats


def survey(table: Table, kinds: Kinds, middle: Floats, ways: Floats) -> Survey:
    """Go over a table once; ways (WAYS, 3) are unit vectors."""
    card, known, texts = table.card, len(kinds.numbers), len(table.program.strings)
    shader = card.compile(source("survey"), "survey")
    numbers = card.buffer(kinds.numbers.tobytes())
    colors = card.buffer(np.zeros(max(texts, 1), np.uint32).tobytes())
    found = np.zeros(known + 1 + texts, np.int64)
    points = []
    for rows in table.parts:
        most = card.limits.block_bytes // (GROUP * 2 * WAYS * POINT)
        groups = max(1, min(-(-rows.count // GROUP), _SURVEYORS, most))
        counts = card.buffer(np.zeros(len(found), np.uint32).tobytes())
        reaches = card.buffer(groups * GROUP * 2 * WAYS * POINT)
        set_all(shader, {"kinds_known": known})
        shader["directions"].write(ways.astype(np.float32).tobytes())  # type: ignore[union-attr]
        bind_table(shader, table, rows, middle, 0.0)
        for binding, storage in (
            (KINDS, numbers), (COLORS, colors), (COUNTS, counts), (OUTPUT, reaches),
        ):  # fmt: skip
            storage.bind(binding)
        card.dispatch(shader, groups, "survey")
        found += counts.array(np.uint32)
        points.append(reaches.array(np.float32).reshape(-1, WAYS, 2, 4))
        for storage in (counts, reaches):
            storage.release()
    for storage in (numbers, colors):
        storage.release()
    used = np.flatnonzero(found[known + 1 :])
    return Survey(found[:known], used, bool(found[known]), *_farthest(np.concatenate(points), ways))


def first_place(table: Table) -> Floats:
    """(3,) where some terminal stands."""
    rows = table.parts[0]
    words = [table.word(name) or 0 for name in "xyz"]
    found = [
        rows.storage.array(np.uint32, 1, (word + half) * rows.room * 4)
        for word in words
        for half in (0, 1)
    ]
    place: Floats = np.concatenate(found).view(np.float64)
    return place


def bind_table(
    shader: moderngl.ComputeShader, table: Table, rows: Rows, middle: Floats, thin: float
) -> None:
    """Let a shader read a part of a table."""
    rows.storage.bind(TERMINALS)
    words = {
        "place": table.word("x"),
        "turn": table.word("w"),
        "scale": table.word("scale"),
        "width": table.word("width"),
        "color": table.word("color"),
    }
    values = {f"word_{name}": isa.NONE if word is None else word for name, word in words.items()}
    place = tuple(middle.tolist())
    set_all(
        shader, {**values, "rows": rows.count, "room": rows.room, "middle": place, "thin": thin}
    )


def set_all(shader: moderngl.ComputeShader, values: Mapping[str, object]) -> None:
    """Uniforms by name; those that the shader does not use are left out."""
    for name, value in values.items():
        if name in shader:
            shader[name] = value


def source(name: str) -> str:
    """The text of one of the compute shaders."""
    folder = files("ipmlang.studio") / "shaders"
    head = f"#version 430\n#define GROUP {GROUP}\n#define SEGMENT ({SEGMENT})\n"
    head += f"#define DIRECTIONS {WAYS}u\n#define LEAST {LEAST}\n#define FEW {FEW}\n"
    texts = [
        (folder / each).read_text(encoding="utf-8") for each in ("terminals.glsl", f"{name}.comp")
    ]
    return "".join([head, isa.macros(), *texts])


def _farthest(reached: NDArray[np.float32], ways: Floats) -> tuple[Floats, Floats]:
    """How far (w, 2) and which points (w, 2, 3), of what each thread found (t, w, 2, 4): points,
    and 0 where it found none.
    """
    points = reached[..., :3].astype(np.float64)
    along = np.einsum("tvsi,vi->tvs", points, ways) * np.array([1.0, -1.0])
    along[reached[..., 3] == 0] = -np.inf
    best = along.argmax(axis=0)
    way, side = np.indices(best.shape)
    return along[best, way, side], points[best, way, side]
