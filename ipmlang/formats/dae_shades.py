"""The materials of DAE files: what a material's effect says of its colour and image.

Takes the elements of a file by id; gives materials for the symbols that geometry uses. Images lie
in the model's folder or below. Shine, opacity and bumps are passed over.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote

from ipmlang.formats import FormatError
from ipmlang.formats.dae_xml import children, descend, first, local_name, numbers, target
from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh_types import Color, Material
from ipmlang.formats.textures import Texture, texture_beside

if TYPE_CHECKING:
    from lxml.etree import _Element

_LIGHTINGS = ("phong", "lambert", "blinn", "constant")


@dataclass(slots=True)
class Shades:
    """The materials of a file, each read once."""

    by_id: dict[str, _Element]
    folder: Path
    notes: list[Note] = field(default_factory=list)
    known: dict[str, Material] = field(default_factory=dict)

    def bound(self, targets: dict[str, str]) -> Callable[[str], Material | None]:
        """What symbols stand for where an instance binds them; a symbol may be a material's id."""

        def shade(symbol: str) -> Material | None:
            return self._material(targets.get(symbol, f"#{symbol}")[1:], symbol) if symbol else None

        return shade

    def _material(self, name: str, symbol: str) -> Material:
        if name not in self.known:
            element = self.by_id.get(name)
            if element is None or local_name(element) != "material":
                return Material(symbol)
            self.known[name] = self._read(element, element.get("name") or name)
        return self.known[name]

    def _read(self, material: _Element, name: str) -> Material:
        instance = first(material, "instance_effect")
        effect = target(instance, self.by_id) if instance is not None else None
        profile = first(effect, "profile_COMMON") if effect is not None else None
        technique = first(profile, "technique") if profile is not None else None
        if profile is None or technique is None:
            return Material(name)
        lighting = next((each for each in technique if local_name(each) in _LIGHTINGS), None)
        diffuse = first(lighting, "diffuse") if lighting is not None else None
        if diffuse is None:
            return Material(name)
        texture = self._texture(diffuse, profile)
        color = _color(first(diffuse, "color"))
        return Material(name, color if texture is None else None, texture)

    def _texture(self, diffuse: _Element, profile: _Element) -> Texture | None:
        """The image of a diffuse colour, by way of its sampler and surface."""
        used = first(diffuse, "texture")
        if used is None:
            return None
        given = {each.get("sid", ""): each for each in children(profile, "newparam")}
        name = used.get("texture", "")
        for step in (("sampler2D", "source"), ("surface", "init_from")):
            holder = given.get(name)
            found = descend(holder, *step) if holder is not None else None
            name = found.strip() if found else name
        image = self.by_id.get(name)
        source = first(image, "init_from") if image is not None else None
        inner = descend(source, "ref") if source is not None else None
        reference = (inner or (source.text if source is not None else "") or "").strip()
        if not reference:
            return None
        try:
            return texture_beside(self.folder, unquote(reference.removeprefix("file://")))
        except FormatError as error:
            self.notes.append(Note("texture", f"{error.message}; it was left out"))
            return None


def _color(element: _Element | None) -> Color | None:
    if element is None:
        return None
    values = numbers(element)
    red, green, blue = (float(min(max(each, 0.0), 1.0)) for each in [*values, 0.0, 0.0, 0.0][:3])
    return red, green, blue, 1.0
