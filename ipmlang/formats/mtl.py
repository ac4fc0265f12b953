"""Material libraries of OBJ files: colours, opacity and images by material name, read and written.

Takes a library beside a model; gives the shades that it names and notes on images that cannot be
used. Images lie in the library's folder or below. Light, shine and bumps are passed over.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ipmlang.formats import FormatError
from ipmlang.formats.atomic import Content
from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh_types import UNCOLORED, Alpha, Color, Material
from ipmlang.formats.numbers import decimal_text
from ipmlang.formats.textures import Texture, texture_beside, texture_bytes

_ONE = ("-blendu", "-blendv", "-bm", "-boost", "-cc", "-clamp", "-colorspace", "-imfchan",
        "-texres", "-type")  # fmt: skip
_VALUES = {**dict.fromkeys(_ONE, 1), "-mm": 2, "-o": 3, "-s": 3, "-t": 3}
"""How many values may follow an option of an image."""


@dataclass(slots=True)
class Shade:
    """What a library says of one material. `scale` and `offset` make its texture coordinates:
    those of a corner times `scale`, plus `offset`.
    """

    diffuse: tuple[float, float, float] | None = None
    opacity: float = 1.0
    texture: Texture | None = None
    alpha: Alpha = ""
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)

    def color(self) -> Color | None:
        """Its colour with opacity, None if nothing says either."""
        if self.diffuse is None and self.opacity == 1.0:
            return None
        plain = (1.0, 1.0, 1.0) if self.texture else UNCOLORED[:3]
        return (*(self.diffuse or plain), self.opacity)

    def material(self, name: str) -> Material:
        """The material by that name."""
        return Material(name, self.color(), self.texture, self.alpha)


@dataclass(slots=True)
class Library:
    """All shades of a file by name."""

    shades: dict[str, Shade] = field(default_factory=dict)
    notes: list[Note] = field(default_factory=list)


def read_library(folder: Path, text: str) -> Library:
    """The shades that a library's text describes; its images lie in `folder`."""
    library = Library()
    shade = Shade()
    for line in text.split("\n"):
        word, _, rest = line.strip().replace("\t", " ").partition(" ")
        rest = rest.strip()
        try:
            match word:
                case "newmtl":
                    shade = library.shades[rest] = Shade()
                case "Kd":
                    shade.diffuse = _diffuse(rest) or shade.diffuse
                case "d":
                    shade.opacity = _share(rest.removeprefix("-halo"))
                case "Tr":
                    shade.opacity = 1.0 - _share(rest)
                case "map_Kd":
                    _read_map(shade, folder, rest)
                case "map_d":
                    shade.alpha = "MASK"
        except ValueError:
            continue
        except FormatError as error:
            library.notes.append(Note("texture", f"{error.message}; it was left out"))
    for shade in library.shades.values():
        shade.alpha = shade.alpha if shade.texture else ""
    return library


def _share(text: str) -> float:
    """A number from 0 to 1."""
    value = float(text)
    if value != value:
        raise ValueError(text)
    return min(max(value, 0.0), 1.0)


def _diffuse(text: str) -> tuple[float, float, float] | None:
    """Red, green, blue; one number is all three. None for spectra, which are no colours here."""
    words = text.split()
    if len(words) not in (1, 3):
        return None
    red, green, blue = (_share(each) for each in (words if len(words) == 3 else words * 3))
    return red, green, blue


def _read_map(shade: Shade, folder: Path, text: str) -> None:
    """An image with its options: `-s 2 2 1 brick wall.png`."""
    head, _, rest = text.partition(" ")
    while head in _VALUES:
        values: list[str] = []
        while len(values) < _VALUES[head] and rest.strip():
            word, _, after = rest.lstrip().partition(" ")
            if not after.strip() or (values and not _is_number(word)):
                break
            values.append(word)
            rest = after
        if head in ("-s", "-o") and values:
            usual = 1.0 if head == "-s" else 0.0
            u, v = (*(float(each) for each in values), usual)[:2]
            shade.scale, shade.offset = ((u, v), shade.offset) if head == "-s" else (
                shade.scale, (u, v))  # fmt: skip
        text = rest.strip()
        head, _, rest = text.partition(" ")
    if text:
        shade.texture = texture_beside(folder, text)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def library_contents(
    materials: Mapping[str, Material], path: Path
) -> tuple[str, dict[Path, Content]]:
    """The text of the library of a model at `path`, and the images to write beside the model: in
    the folder `house.textures` for `house.obj`, each named by its content, so that two never meet
    and none stands in the place of another file.
    """
    lines = ["# written by ipmlang"]
    images: dict[Path, Content] = {}
    places: dict[Texture, str] = {}
    for name, material in materials.items():
        white = (1.0, 1.0, 1.0, 1.0) if material.texture else UNCOLORED
        red, green, blue, opacity = material.color or white
        color = " ".join(decimal_text(each, 7) for each in (red, green, blue))
        lines += [f"newmtl {name}", f"Kd {color}", f"d {decimal_text(opacity, 7)}"]
        texture = material.texture
        if texture is not None:
            if texture not in places:
                places[texture] = _placed(texture, path, images)
            lines.append(f"map_Kd {places[texture]}")
            lines += [f"map_d {places[texture]}"] if material.alpha else []
    return "\n".join(lines) + "\n", images


def _placed(texture: Texture, path: Path, images: dict[Path, Content]) -> str:
    """Where an image stands beside a model, as its library says it."""
    content = texture_bytes(texture)
    digest = hashlib.blake2b(content, digest_size=4).hexdigest()
    stem = _file_stem(texture.name.removesuffix(f".{digest}"))
    folder = f"{path.stem}.textures"
    target = path.parent / folder / f"{stem}.{digest}{texture.suffix}"
    if not _is_there(target, content):
        images[target] = content
    return f"{folder}/{target.name}"


def _is_there(target: Path, content: bytes) -> bool:
    """Whether the image stands in its place already; anything else there is in the way."""
    try:
        found = target.read_bytes()
    except FileNotFoundError:
        return False
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise FormatError(f"cannot write `{target}`: {reason}") from error
    if found != content:
        message = f"cannot write `{target}`: another file stands there"
        raise FormatError(message, hint="move it away, or write the model under another name")
    return True


def _file_stem(name: str) -> str:
    """A name that is one on every system, without its suffix."""
    kept = "".join(each if each.isalnum() or each in "-_." else "_" for each in name)
    return kept.strip(".")[:60] or "texture"
