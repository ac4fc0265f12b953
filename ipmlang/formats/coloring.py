"""Colours of vertices and faces as materials: a colour for each face, named by what it is.

In go a mesh and the colours that its file gives its vertices or faces, out comes the mesh with a
material for each colour, and notes of what that leaves out. Faces that have a material keep it.
Nothing is read here.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh_types import Floats, Material, Mesh

MOST = 256  # colours that are materials; a file with more is shaded or scanned, not painted
_STEPS = 255  # of a colour's parts


def with_face_colors(mesh: Mesh, colors: Floats) -> tuple[Mesh, tuple[Note, ...]]:
    """A mesh whose faces without a material get one of their colours (f, 3) or (f, 4): red, green,
    blue and opacity, 0 to 1, as shown on a screen.
    """
    bare = mesh.material < 0
    if not bare.any() or len(colors) != len(mesh.material):
        return mesh, ()
    opaque = np.ones((len(colors), 1))
    shares = colors if colors.shape[1] == 4 else np.concatenate([colors[:, :3], opaque], axis=1)
    whole = np.where(np.isfinite(shares), np.clip(shares, 0.0, 1.0), 1.0)
    steps = np.round(whole * _STEPS).astype(np.int64)
    code = steps @ (256 ** np.arange(3, -1, -1))
    kinds, first, kind = np.unique(code[bare], return_index=True, return_inverse=True)
    if len(kinds) > MOST:
        message = f"colours of vertices were left out: there are more than {MOST}"
        return mesh, (Note("colors-left-out", message),)
    found = steps[bare][first].tolist()
    materials = tuple(_material(*row) for row in found)
    material = mesh.material.copy()
    material[bare] = len(mesh.materials) + kind.reshape(-1)
    return replace(mesh, material=material, materials=(*mesh.materials, *materials)), ()


def with_vertex_colors(mesh: Mesh, colors: Floats) -> tuple[Mesh, tuple[Note, ...]]:
    """The same for colours of vertices (v, 3) or (v, 4); faces get the mean of theirs."""
    sizes = np.diff(mesh.offsets)
    if not len(sizes) or len(colors) != len(mesh.vertices):
        return mesh, ()
    own = np.where(np.isfinite(colors), colors, 1.0)[mesh.corners]
    begins = mesh.offsets[:-1]
    mean = np.add.reduceat(own, begins, axis=0) / sizes[:, None]
    least, most = np.minimum.reduceat(own, begins), np.maximum.reduceat(own, begins)
    varied = int(((most - least).max(axis=1) > 1.5 / _STEPS).sum())
    made, notes = with_face_colors(mesh, mean)
    if varied and made is not mesh:
        message = "colours that vary within a face were made one"
        notes = (*notes, Note("colors-averaged", message, varied))
    return made, notes


def is_color_name(name: str) -> bool:
    """Whether a material has the name of a colour that its file gave no name.

    >>> is_color_name("color_de5078"), is_color_name("color of brick")
    (True, False)
    """
    return re.fullmatch(r"color_([0-9a-f]{2}){3,4}", name) is not None


def screen(linear: Floats) -> Floats:
    """Linear light as a screen shows it (sRGB), 0 to 1."""
    light = np.clip(linear, 0.0, 1.0)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def _material(red: int, green: int, blue: int, opacity: int) -> Material:
    alpha = "" if opacity == _STEPS else f"{opacity:02x}"
    shares = (red / _STEPS, green / _STEPS, blue / _STEPS, opacity / _STEPS)
    return Material(f"color_{red:02x}{green:02x}{blue:02x}{alpha}", shares)
