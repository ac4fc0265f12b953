"""OBJ files to meshes: polygons as they are, objects, groups and materials kept by name.

Takes a path; gives one mesh whose faces know the names they go by. Indices that point nowhere are
errors with their line; lines, points, curves and smoothing are passed over. Materials are looked up
in libraries beside the file, never elsewhere.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats import FormatError
from ipmlang.formats.coloring import with_vertex_colors
from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh_types import Mesh, MeshScene, face_normals, single, without_bad_faces
from ipmlang.formats.mtl import Library, Shade, read_library

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_Number = TypeVar("_Number", np.float64, np.int64)
_FARTHEST = 2**40  # of an index
_PAINTED = 6  # numbers of a point with a colour
_NAMES = ("o", "g", "usemtl", "mtllib")


@dataclass(slots=True)
class _Lines:
    """The lines of a file by what they say: numbers of lines (from 0) and their texts."""

    points: tuple[Ints, list[str]]
    textures: tuple[Ints, list[str]]
    normals: tuple[Ints, list[str]]
    faces: tuple[Ints, list[str]]
    named: list[tuple[int, str, str]]


def read_obj(path: Path) -> MeshScene:
    """The mesh of an OBJ file, every face with its object, group and material."""
    text = _text(path.read_bytes())
    lines = _sorted_lines(text)
    vertices = _numbers(*lines.points, 3)
    textures = _numbers(*lines.textures, 2)
    normals = _numbers(*lines.normals, 3)
    counts, corners = _corners(lines, (len(vertices), len(textures), len(normals)))
    material, group, groups, named = _labels(lines)
    library = _libraries(lines, path.parent)
    if "\nnewmtl " in text:  # materials may stand in the file itself
        library.shades.update(read_library(path.parent, text).shades)
    shades = [library.shades.get(each, Shade()) for each in named]
    mesh = Mesh(
        vertices,
        corners[:, 0],
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        material,
        group,
        tuple(shade.material(name) for name, shade in zip(named, shades, strict=True)),
        groups,
        _uv(textures, corners[:, 1], np.repeat(material, counts), shades),
    )
    mesh = replace(mesh, normals=_normals(mesh, normals, corners[:, 2]))
    mesh, painted = _painted(mesh, lines)
    mesh, notes = without_bad_faces(mesh)
    return single(mesh, path.stem, (*library.notes, *painted, *notes, *_remarks(mesh)))


def _painted(mesh: Mesh, lines: _Lines) -> tuple[Mesh, tuple[Note, ...]]:
    """The mesh with the colours that points have behind their places: `v x y z r g b`."""
    texts = lines.points[1]
    if not texts or len(texts[0].split()) != _PAINTED or len(texts[-1].split()) != _PAINTED:
        return mesh, ()
    try:
        colors = _numbers(*lines.points, _PAINTED)[:, 3:]
    except FormatError:
        return mesh, ()
    colors = colors / 255.0 if colors.max(initial=0.0) > 1.0 else colors
    return with_vertex_colors(mesh, colors)


def obj_names(path: Path) -> list[str]:
    """The names of objects and groups, in order, without reading geometry."""
    names: dict[str, None] = {}
    for line in _text(path.read_bytes()).split("\n"):
        if line[:2] in ("o ", "g "):
            names.update(dict.fromkeys(_given_names(line[0], line[2:].strip())))
    return list(names)


def _text(data: bytes) -> str:
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    return text.replace("\\\n", " ") if "\\\n" in text else text


def _sorted_lines(text: str) -> _Lines:
    lines = text.split("\n")
    kept: dict[str, tuple[list[int], list[str]]] = {
        word: ([], []) for word in ("v", "vt", "vn", "f")
    }
    named: list[tuple[int, str, str]] = []
    for number, line in enumerate(lines):
        word, _, rest = line.partition(" ")
        own = kept.get(word)
        if own is None:
            # Rare lines may be indented or part their words by tabs.
            word, _, rest = line.strip().replace("\t", " ").partition(" ")
            own = kept.get(word)
        if own is not None:
            own[0].append(number)
            own[1].append(rest)
        elif word in _NAMES:
            named.append((number, word, rest.strip()))
    columns = {word: (np.array(at, np.int64), texts) for word, (at, texts) in kept.items()}
    return _Lines(columns["v"], columns["vt"], columns["vn"], columns["f"], named)


def _numbers(at: Ints, texts: Sequence[str], width: int) -> Floats:
    """The first `width` numbers of each line."""
    if not texts:
        return np.zeros((0, width))
    try:
        table = _parsed(" ".join(texts), np.float64)
        if len(table) % len(texts) == 0 and len(table) // len(texts) >= width:
            columns = len(table) // len(texts)
            if len(texts[0].split()) == columns and len(texts[-1].split()) == columns:
                return table.reshape(len(texts), columns)[:, :width]
    except ValueError:
        pass
    return np.array([_row(n, t, width) for n, t in zip(at.tolist(), texts, strict=True)])


def _parsed(text: str, kind: type[_Number]) -> NDArray[_Number]:
    """All numbers of a text; a `ValueError` if something else stands among them."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return np.fromstring(text, dtype=kind, sep=" ")
        except DeprecationWarning as warning:
            raise ValueError(str(warning)) from warning


def _row(number: int, text: str, width: int) -> list[float]:
    words = text.split("#")[0].split()[:width]
    try:
        values = [float(word) for word in words]
    except ValueError:
        raise FormatError(f"`{text.strip()[:60]}` are not {width} numbers", number + 1) from None
    if width == 2 and len(values) == 1:
        values.append(0.0)
    if len(values) < width:
        raise FormatError(f"`{text.strip()[:60]}` are not {width} numbers", number + 1)
    return values


def _corners(lines: _Lines, sizes: tuple[int, int, int]) -> tuple[Ints, Ints]:
    """Corners of each face (f,), and their vertex, texture and normal (c, 3), -1 for none."""
    at, texts = lines.faces
    counts = np.array([len(text.split()) for text in texts], np.int64)
    if "#" in "".join(texts):
        texts = [text.split("#")[0] for text in texts]
        counts = np.array([len(text.split()) for text in texts], np.int64)
    if not counts.sum():
        return counts, np.zeros((0, 3), np.int64)
    table = _index_table(" ".join(texts), int(counts.sum()))
    if table is None:
        table = _sorted_table(texts, counts)
    if table is None:
        table = _mixed_table(at, texts)
    line = np.repeat(at, counts)
    places = (lines.points[0], lines.textures[0], lines.normals[0])
    for column, (place, size) in enumerate(zip(places, sizes, strict=True)):
        _resolve(table[:, column], line, place, size, column)
    return counts, table


def _index_table(text: str, count: int) -> Ints | None:
    """The indices where all corners are written alike, 0 for none; None where they are not."""
    first = text.split(None, 1)[0]
    slashes = first.count("/")
    if text.count("/") != slashes * count:
        return None
    empty = "//" in first
    if (empty and text.count("//") != count) or (not empty and "//" in text):
        return None
    columns = [0, 2] if empty else list(range(slashes + 1))
    try:
        values = _parsed(text.replace("/", " "), np.int64)
    except ValueError:
        return None
    if len(values) != count * len(columns) or len(columns) > 3:
        return None
    table = np.zeros((count, 3), np.int64)
    table[:, columns] = values.reshape(count, -1)
    if (table[:, columns] == 0).any():
        return None
    return table


def _sorted_table(texts: Sequence[str], counts: Ints) -> Ints | None:
    """The indices where the corners of each face are written alike, but not those of all faces;
    None where they are not.
    """
    styles: dict[tuple[int, bool], list[int]] = {}
    for face, (text, count) in enumerate(zip(texts, counts.tolist(), strict=True)):
        if count:
            first = text.split(None, 1)[0]
            styles.setdefault((first.count("/"), "//" in first), []).append(face)
    table = np.zeros((int(counts.sum()), 3), np.int64)
    begin = np.cumsum(counts) - counts
    for faces in styles.values():
        many = counts[faces]
        own = _index_table(" ".join(texts[face] for face in faces), int(many.sum()))
        if own is None:
            return None
        first_row = np.repeat(begin[faces] - np.cumsum(many) + many, many)
        table[first_row + np.arange(len(own))] = own
    return table


def _mixed_table(at: Ints, texts: Sequence[str]) -> Ints:
    """The same where corners are written in several ways."""
    words = " ".join(texts).split()
    slashes = np.array([word.count("/") for word in words], np.int64)
    text = " ".join(words)
    try:
        values = _parsed(text.replace("//", "/0/").replace("/", " "), np.int64)
    except ValueError:
        return _one_by_one(at, texts)
    given = slashes + 1
    far = np.abs(values).max(initial=0) > _FARTHEST
    if given.max() > 3 or len(values) != given.sum() or far:
        return _one_by_one(at, texts)
    if np.count_nonzero(values == 0) != text.count("//"):  # a 0 that was written out
        return _one_by_one(at, texts)
    table = np.zeros((len(words), 3), np.int64)
    table[np.arange(3) < given[:, None]] = values
    return table


def _one_by_one(at: Ints, texts: Sequence[str]) -> Ints:
    """The same, corner by corner, which finds what is wrong with one."""
    faces = zip(at.tolist(), texts, strict=True)
    return np.array(
        [_corner(line, word) for line, text in faces for word in text.split()], np.int64
    )


def _corner(number: int, word: str) -> list[int]:
    parts = word.split("/")
    try:
        indices = [int(part) if part else 0 for part in parts]
    except ValueError:
        raise FormatError(f"`{word[:40]}` is no corner of a face", number + 1) from None
    # 0 stands for "not given" further on: written out, it is an index that points nowhere.
    if len(indices) > 3 or 0 in [i for i, part in zip(indices, parts, strict=True) if part]:
        raise FormatError(f"`{word[:40]}` is no corner of a face: indices begin at 1", number + 1)
    if not parts[0] or any(abs(index) > _FARTHEST for index in indices):
        raise FormatError(f"`{word[:40]}` is no corner of a face", number + 1)
    return ([*indices, 0, 0])[:3]


def _resolve(column: Ints, line: Ints, place: Ints, size: int, which: int) -> None:
    """Turn indices as written (from 1, or backwards from the line) into ones from 0, in place."""
    behind = column < 0
    if behind.any():
        column[behind] += np.searchsorted(place, line[behind]) + 1
        bad = behind & (column <= 0)
    else:
        bad = behind
    bad = bad | (column > size)
    if bad.any():
        what = ("vertex", "texture point", "normal")[which]
        number = int(line[np.argmax(bad)]) + 1
        raise FormatError(f"a face names a {what} that is not among the {size}", number)
    column -= 1


def _labels(lines: _Lines) -> tuple[Ints, Ints, tuple[tuple[str, ...], ...], list[str]]:
    """Material and group of each face, from the lines that stand before it; all groups, and the
    names of all materials.
    """
    materials: dict[str, int] = {}
    groups: dict[tuple[str, ...], int] = {}
    marks, states = [-1], [(-1, groups.setdefault((), 0))]
    name: tuple[str, ...] = ()
    parts: tuple[str, ...] = ()
    material = -1
    for number, word, rest in lines.named:
        match word:
            case "mtllib":
                continue
            case "usemtl":
                material = materials.setdefault(rest, len(materials)) if rest else -1
            case "o":
                name, parts = tuple(_given_names("o", rest)), ()
            case _:
                parts = tuple(_given_names("g", rest))
        marks.append(number)
        states.append((material, groups.setdefault((*name, *parts), len(groups))))
    row = np.searchsorted(np.array(marks), lines.faces[0]) - 1
    table = np.array(states, np.int64)[row].reshape(-1, 2)
    return table[:, 0], table[:, 1], tuple(groups), list(materials)


def _normals(mesh: Mesh, normals: Floats, chosen: Ints) -> Floats | None:
    """Normals of all corners (c, 3), the face's own for those without; None if all are without."""
    if not len(chosen) or chosen.max() < 0:
        return None
    missing = chosen < 0
    found = normals[chosen]
    if missing.any():
        own = face_normals(mesh)
        own /= np.maximum(np.linalg.norm(own, axis=1, keepdims=True), 1e-300)
        found[missing] = np.repeat(own, np.diff(mesh.offsets), axis=0)[missing]
    return found


def _uv(textures: Floats, chosen: Ints, material: Ints, shades: list[Shade]) -> Floats | None:
    """Texture coordinates of all corners (c, 2), 0 for those without; None if all are without."""
    if not len(chosen) or chosen.max() < 0:
        return None
    uv = np.where(chosen[:, None] < 0, 0.0, textures[chosen])
    if any((shade.scale, shade.offset) != (Shade().scale, Shade().offset) for shade in shades):
        scale = np.array([*(shade.scale for shade in shades), (1.0, 1.0)])
        offset = np.array([*(shade.offset for shade in shades), (0.0, 0.0)])
        uv = uv * scale[material] + offset[material]
    return uv


def _given_names(word: str, rest: str) -> list[str]:
    """An object's name may hold blanks, a group line lists names."""
    if word == "o":
        return [rest] if rest else []
    return [each for each in rest.split() if each != "default"]


def _libraries(lines: _Lines, folder: Path) -> Library:
    """All libraries that the file names; of a name given twice the later counts."""
    found = Library()
    for rest in dict.fromkeys(rest for _, word, rest in lines.named if word == "mtllib"):
        one = _library(folder, rest)
        found.shades.update(one.shades)
        found.notes += one.notes
    return found


def _library(folder: Path, name: str) -> Library:
    """The material library of that name beside the model; nothing if it is not there."""
    path = folder / name
    if not name or Path(name).name != name or not path.is_file():
        return Library()
    return read_library(folder, _text(path.read_bytes()))


def _remarks(mesh: Mesh) -> tuple[Note, ...]:
    """A warning where coordinates are so large that detail may be lost."""
    if not len(mesh.vertices) or not len(mesh.corners):
        return ()
    used = mesh.vertices[mesh.corners]
    spread = float(np.ptp(used, axis=0).max())
    if float(np.abs(used).max()) > 1e9 * max(spread, 1e-300):
        message = "the model lies so far from the origin that detail is lost"
        return (Note("precision", message),)
    return ()
