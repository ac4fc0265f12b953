"""Materials of GLB files: base colours and their images, read from a file's JSON and written to it.

Reading gives a `Material` and how its texture coordinates are laid; an image is taken as it stands,
from the file, a `data:` address, or a file beside the model. Writing gives the JSON's entries and
the bytes of images, each once. Light is linear in glTF and shown colours are not. Of metal, shine
and bumps nothing is kept.
"""

from __future__ import annotations

import base64
import binascii
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote, unquote_to_bytes

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats import FormatError
from ipmlang.formats.drawing import Note
from ipmlang.formats.glb_data import Container, Json, Object, view_bytes, whole
from ipmlang.formats.mesh_types import Alpha, Color, Material
from ipmlang.formats.textures import (
    MIME_TYPES,
    Texture,
    texture_beside,
    texture_bytes,
    texture_of,
)

Floats = NDArray[np.float64]
Entry = dict[str, object]

_TRANSFORM = "KHR_texture_transform"
_GLOSSINESS = "KHR_materials_pbrSpecularGlossiness"
_REPEATED = {"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}


@dataclass(frozen=True, slots=True, eq=False)
class Shade:
    """A material, which of a mesh's texture coordinates its image goes by, and the map (2, 3) that
    these pass through, with v pointing down.
    """

    material: Material
    uv_set: int
    uv_matrix: Floats


@dataclass(slots=True)
class Shades:
    """The materials of a file whose images may lie in `folder`; each is read once."""

    file: Container
    folder: Path
    notes: list[Note] = field(default_factory=list)
    _shades: dict[int, Shade] = field(default_factory=dict)
    _textures: dict[int, Texture | None] = field(default_factory=dict)

    def shade(self, index: Json) -> Shade | None:
        """The material of that number; None for none."""
        if index is None:
            return None
        entry = self.file.item("materials", index)
        number = whole(index)
        if number not in self._shades:
            self._shades[number] = self._read(entry, number)
        return self._shades[number]

    def _read(self, entry: Object, number: int) -> Shade:
        color, image = _base(entry)
        texture, uv_set, matrix = None, 0, np.eye(2, 3)
        if isinstance(image, dict):
            texture = self._texture(image.get("index"))
            uv_set, matrix = _laid(image)
        mode = entry.get("alphaMode")
        alpha: Alpha = ""
        if texture is not None and mode in ("MASK", "BLEND"):
            alpha = "MASK" if mode == "MASK" else "BLEND"
        name = str(entry.get("name") or f"material_{number}")
        return Shade(Material(name, color, texture, alpha), uv_set, matrix)

    def _texture(self, index: Json) -> Texture | None:
        """The image of a texture; one that cannot be used is noted and left out."""
        source = self.file.item("textures", index).get("source")
        if source is None:
            self._left_out("an image of a kind that is known to extensions alone")
            return None
        image = self.file.item("images", source)
        number = whole(source)
        if number not in self._textures:
            try:
                self._textures[number] = self._image(image, number)
            except FormatError as error:
                self._left_out(error.message)
                self._textures[number] = None
        return self._textures[number]

    def _left_out(self, message: str) -> None:
        self.notes.append(Note("texture", f"{message}; it was left out"))

    def _image(self, image: Object, number: int) -> Texture:
        uri = image.get("uri")
        given = image.get("name")
        name = given if isinstance(given, str) and given else f"image_{number}"
        if not isinstance(uri, str):
            return texture_of(name, view_bytes(self.file, image.get("bufferView"))[0])
        if uri.startswith("data:"):
            return texture_of(name, _embedded(uri))
        return texture_beside(self.folder, unquote(uri))


def _base(entry: Object) -> tuple[Color | None, Json]:
    """Base colour and image of a material, of whichever model of light."""
    extensions = entry.get("extensions")
    metal = entry.get("pbrMetallicRoughness")
    glossy = extensions.get(_GLOSSINESS) if isinstance(extensions, dict) else None
    if isinstance(metal, dict):
        factor, image = metal.get("baseColorFactor"), metal.get("baseColorTexture")
    elif isinstance(glossy, dict):
        factor, image = glossy.get("diffuseFactor"), glossy.get("diffuseTexture")
    else:
        return None, None
    if not isinstance(factor, list) or len(factor) != 4:
        return None, image
    red, green, blue, opacity = (_number(each) for each in factor)
    if entry.get("alphaMode", "OPAQUE") == "OPAQUE":
        opacity = 1.0
    return (shown(red), shown(green), shown(blue), opacity), image


def _number(value: Json) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise FormatError(f"the file has `{str(value)[:40]}` where a number belongs")
    return float(value)


def _laid(image: Object) -> tuple[int, Floats]:
    """Which texture coordinates an image goes by, and their map (2, 3): T R S of the extension."""
    uv_set = whole(image.get("texCoord"))
    extensions = image.get("extensions")
    change = extensions.get(_TRANSFORM) if isinstance(extensions, dict) else None
    if not isinstance(change, dict):
        return uv_set, np.eye(2, 3)
    offset, scale = _pair(change.get("offset"), 0.0), _pair(change.get("scale"), 1.0)
    angle = _number(change.get("rotation", 0.0))
    cos, sin = math.cos(angle), math.sin(angle)
    linear = np.array([[cos, sin], [-sin, cos]]) * scale
    matrix = np.concatenate([linear, np.array(offset)[:, None]], axis=1)
    return whole(change.get("texCoord"), uv_set), matrix


def _pair(value: Json, usual: float) -> tuple[float, float]:
    if value is None:
        return usual, usual
    if not isinstance(value, list) or len(value) != 2:
        raise FormatError("a texture's offset and scale have two numbers each")
    return _number(value[0]), _number(value[1])


def _embedded(uri: str) -> bytes:
    """The content of a `data:` address."""
    head, comma, text = uri.partition(",")
    if not comma:
        raise FormatError("an image's `data:` address has no content")
    if not head.endswith(";base64"):
        return unquote_to_bytes(text)
    try:
        return base64.b64decode(unquote(text), validate=True)
    except (binascii.Error, ValueError) as error:
        raise FormatError(f"an image's `data:` address cannot be read: {error}") from error


def shown(linear: float) -> float:
    """A linear light value as sRGB, rounded so that `#rrggbb` colours come back as they were."""
    value = 12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055
    return round(min(max(value, 0.0), 1.0), 6)


def linear_light(share: float) -> float:
    """An sRGB value as linear light."""
    value = share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4
    return round(value, 8)


def shade_entries(
    materials: Iterable[Material], add_view: Callable[[bytes], int]
) -> dict[str, list[Entry]]:
    """The JSON's lists for materials, textures, images and samplers, in the order given; `add_view`
    takes the bytes of an image and gives the number of a view on them.
    """
    numbers: dict[Texture, int] = {}
    contents: dict[bytes, int] = {}
    images: list[Entry] = []
    entries: list[Entry] = []
    for material in materials:
        texture = material.texture
        if texture is not None and texture not in numbers:
            content = texture_bytes(texture)
            if content not in contents:
                contents[content] = len(images)
                kind = MIME_TYPES[texture.suffix]
                view = add_view(content)
                images.append({"name": texture.name, "mimeType": kind, "bufferView": view})
            numbers[texture] = contents[content]
        entries.append(_entry(material, None if texture is None else numbers[texture]))
    textures: list[Entry] = [{"sampler": 0, "source": number} for number in range(len(images))]
    samplers: list[Entry] = [dict(_REPEATED)] if images else []
    return {"materials": entries, "textures": textures, "images": images, "samplers": samplers}


def _entry(material: Material, texture: int | None) -> Entry:
    """Matt and seen from both sides."""
    entry: Entry = {"name": material.name, "doubleSided": True}
    metal: Entry = {"metallicFactor": 0, "roughnessFactor": 0.9}
    mode: str = material.alpha if texture is not None else ""
    if texture is not None:
        metal["baseColorTexture"] = {"index": texture}
    if material.color is not None:
        linear = [linear_light(each) for each in material.color[:3]]
        metal["baseColorFactor"] = [*linear, round(material.color[3], 6)]
        mode = "BLEND" if material.color[3] < 1 else mode
    return {**entry, **({"alphaMode": mode} if mode else {}), "pbrMetallicRoughness": metal}
