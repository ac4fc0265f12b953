"""Images on surfaces: PNG and JPEG files as they are, carried between files, never decoded.

Takes bytes or a path; gives a `Texture`. What kind of image it is, its content says and not its
name. A file that another file refers to must lie in that file's own folder or below. What is no
image, or lies elsewhere, is a `FormatError`. Pixels are never looked at.
"""

from __future__ import annotations

import os
import struct
from dataclasses import dataclass, field
from pathlib import Path

from ipmlang.formats import FormatError

PNG, JPEG = ".png", ".jpg"
MIME_TYPES = {PNG: "image/png", JPEG: "image/jpeg"}
_HEAD = 4096  # bytes that hold all that is asked of an image before its pixels


@dataclass(frozen=True, slots=True)
class Texture:
    """An image: `name` without suffix, `suffix` (.png or .jpg) as its content says, and `source`,
    its bytes or the file that holds them.
    """

    name: str
    suffix: str
    source: Path | bytes = field(repr=False)


def texture_of(name: str, content: bytes) -> Texture:
    """The image of those bytes."""
    return Texture(name, _suffix(content[:_HEAD], name), content)


def texture_at(path: Path) -> Texture:
    """The image in a file, of which only the beginning is read now."""
    return Texture(path.stem, _suffix(_head(path), path.name), path)


def texture_beside(folder: Path, reference: str) -> Texture:
    """The image that a file in `folder` refers to; it must lie in that folder or below.

    Links are followed before this is judged, so nothing that a model names can lead elsewhere.
    """
    name = reference.replace("\\", "/")
    root = os.path.realpath(folder)
    try:
        found = os.path.realpath(os.path.join(root, name))
        inside = os.path.commonpath([root, found]) == root and not os.path.isabs(name)
    except ValueError:  # another drive, or a name that no file can have
        inside = False
    if not inside or name[1:2] == ":":
        raise FormatError(f"the image {reference[:80]} lies outside the model's folder")
    return texture_at(Path(found))


def texture_bytes(texture: Texture) -> bytes:
    """The whole image as it stands in its file."""
    if isinstance(texture.source, bytes):
        return texture.source
    try:
        content = texture.source.read_bytes()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise FormatError(f"cannot read the image {texture.source.name}: {reason}") from error
    if _suffix(content[:_HEAD], texture.source.name) != texture.suffix:
        raise FormatError(f"the image {texture.source.name} was changed while it was used")
    return content


def has_alpha(texture: Texture) -> bool:
    """Whether an image has an opacity of its own: by colour type, or by an entry for it."""
    if texture.suffix != PNG:
        return False
    source = texture.source
    head = source[:_HEAD] if isinstance(source, bytes) else _head(source)
    if head[25] in (4, 6):
        return True
    place = 8
    while place + 8 <= len(head):
        size, kind = struct.unpack_from(">I4s", head, place)
        if kind in (b"tRNS", b"IDAT"):
            return bool(kind == b"tRNS")
        place += 12 + size
    return False


def _head(path: Path) -> bytes:
    """The beginning of a file; a pipe or a device is none."""
    try:
        if path.exists() and not (path.is_file() or path.is_dir()):
            raise FormatError(f"the image {path.name} is no file")
        with path.open("rb") as file:
            return file.read(_HEAD)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise FormatError(f"cannot read the image {path.name}: {reason}") from error


def _suffix(head: bytes, name: str) -> str:
    """The kind of image that begins like this."""
    if head[:8] == b"\x89PNG\r\n\x1a\n" and head[12:16] == b"IHDR" and len(head) > 32:
        if 0 in struct.unpack_from(">II", head, 16):
            raise FormatError(f"the image {name} has no pixels")
        return PNG
    if head[:3] == b"\xff\xd8\xff":
        return JPEG
    what = "is empty" if not head else "is neither a PNG nor a JPEG"
    raise FormatError(f"the image {name} {what}", hint="save it as .png or .jpg")
