"""How fast models are made and written: `python tests/bench/bench_models.py`.

Prints one JSON object: for each case what was drawn, how many triangles and meshes that is, and CPU
seconds of deriving, of finding meshes with their copies, and of the bytes of each file. Each runs
in a process of its own. Timings are kept, never asserted; real models are left out where they are
absent.
"""

from __future__ import annotations

import struct
import sys
import tempfile
import time
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))
MODELS = ROOT.parent / "shared" / "data" / "mesh"

from processes import report  # noqa: E402

import ipmlang  # noqa: E402
from ipmlang.formats.glb_write import glb_bytes  # noqa: E402
from ipmlang.formats.mesh_types import MeshScene, triangulated  # noqa: E402
from ipmlang.formats.obj_write import obj_contents  # noqa: E402
from ipmlang.runtime.export.models import mesh_scene_of  # noqa: E402

WALL = """ipm 1
start Lot on box(400, 8, 250)
Lot --> {texture}comp {{ front: Front }}
Front --> {setup}split y {{ {{ ~0.5: Row }}* }}
Row --> split x {{ {{ ~0.4: Part }}* }}
Part --> split x {{ ~1: {project}A | 0.1: {plain}B }}
"""
LAID = {
    "texture": 'texture("brick.png") ',
    "setup": "setupProjection(xy, 3, 0.9) ",
    "project": "projectUV ",
    "plain": 'texture("") ',
}
COPIES = """ipm 1
asset model = "{model}"
start repeat(i < {side}) {{ repeat(j < {side}) {{ [at(i * 60, j * 60, 0, 1, 0, 0, 0) model] }} }}
"""
LOTS = """ipm 1
start Town on box(1000, 1000, 0)
Town --> split x { { ~10: split y { { ~10: Lot }* } }* }
Lot --> size(rand(4, 9), rand(4, 9), 0) extrude(rand(3, 12)) House
House --> comp { top: roofHip(30) Roof | side: Wall }
"""
CASES = {
    "1,600 copies of a castle": (COPIES.format(model="castle.obj", side=40), ("glb",)),
    "2,500 copies of a textured chess set": (
        COPIES.format(model="chess_board.glb", side=50),
        ("glb",),
    ),
    "400 copies of a castle": (COPIES.format(model="castle.obj", side=20), ("glb", "obj")),
    "1,000,000 parts": (WALL.format(**dict.fromkeys(LAID, "")), ("glb", "instanced")),
    "1,000,000 parts, half of them textured": (WALL.format(**LAID), ("glb", "instanced")),
    "10,000 houses that all differ": (LOTS, ("glb", "obj")),
}
WRITERS: dict[str, Callable[[MeshScene], int]] = {
    "glb": lambda scene: len(glb_bytes(scene)),
    "instanced": lambda scene: len(glb_bytes(scene, instancing=True)),
    "obj": lambda scene: sum(
        len(part)
        for content in obj_contents(scene, Path("a.obj")).values()
        for part in ([content] if isinstance(content, bytes | str) else content)
    ),
}


def image() -> bytes:
    """A grey PNG of one pixel."""
    parts = ((b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 0, 0, 0, 0)),
             (b"IDAT", zlib.compress(b"\0\x7f")), (b"IEND", b""))  # fmt: skip
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        for name, data in parts
    )


def measure(name: str) -> dict[str, float]:
    """One case in this process."""
    text, kinds = CASES[name]
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        (folder / "brick.png").write_bytes(image())
        for model in ("castle.obj", "chess_board.glb"):
            if model in text:
                (folder / model).write_bytes((MODELS / model).read_bytes())
        program = ipmlang.parse(text, folder=folder)
        found: dict[str, float] = {}
        start = time.process_time()
        scene = program.run(seed=1)
        found["derive_s"] = round(time.process_time() - start, 3)
        start = time.process_time()
        model_scene = mesh_scene_of(scene)
        found["meshes_s"] = round(time.process_time() - start, 3)
        triangles = np.array([len(triangulated(mesh)[0]) for mesh in model_scene.meshes])
        found["copies"] = len(model_scene.mesh)
        found["meshes"] = len(model_scene.meshes)
        found["triangles"] = int(triangles[model_scene.mesh].sum())
        for kind in kinds:
            start = time.process_time()
            found[f"{kind}_mb"] = round(WRITERS[kind](model_scene) / 1e6, 1)
            found[f"{kind}_s"] = round(time.process_time() - start, 3)
    return found


if __name__ == "__main__":
    there = [name for name, (text, _) in CASES.items() if "asset" not in text or MODELS.is_dir()]
    report(__file__, there, measure, {})
