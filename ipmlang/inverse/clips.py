"""Clip paths as outlines: what a group is cut to, wherever the file says so.

In go effects, out comes the one outline that an effect clips to and its fill rule, in the effect's
own space, or None for all that is more than such a clip: several shapes, text, clips of clips,
units of a bounding box. Nothing here compares or places.
"""

from __future__ import annotations

import re
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ipmlang.formats import FormatError
from ipmlang.formats.drawing import Effect, Outline
from ipmlang.formats.svg import read_nodes
from ipmlang.formats.svg.bounds import transform_segments

KEPT = 2048  # clips whose outlines are remembered
_REFERENCE = re.compile(r"url\(#([\w.:-]+)\)")
_CLIP = re.compile(r"<clipPath\b([^>]*)>")
_OWN = re.compile(r"\b(transform|clip-path|mask|style|objectBoundingBox)\b")
_RELATIVE = re.compile(r"\d\s*(%|em|ex|rem|ch|vw|vh)\b|\d%")
_EVEN_ODD = re.compile(r"clip-rule\s*[:=]\s*[\"']?\s*evenodd")
_HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">'


def clip_outline(effect: Effect) -> tuple[Outline, str] | None:
    """The outline in the effect's own space, y down, and the rule that says what is inside."""
    if [name for name, _ in effect.attributes] != ["clip-path"]:
        return None
    return _parsed(effect.attributes[0][1], effect.definitions)


def placed_clip(effect: Effect) -> tuple[Outline, str] | None:
    """The same in the drawing's coordinates."""
    found = clip_outline(effect)
    if found is None:
        return None
    outline, rule = found
    coords = transform_segments(outline.kind, outline.coords, np.array(effect.matrix))
    return replace(outline, coords=coords), rule


@lru_cache(KEPT)
def _parsed(reference: str, definitions: str) -> tuple[Outline, str] | None:
    name = _REFERENCE.fullmatch(reference.strip())
    heads = _CLIP.findall(definitions)
    # Anything else that is referred to may change what is clipped.
    if name is None or len(heads) != 1 or _OWN.search(heads[0]):
        return None
    if not definitions.lstrip().startswith("<clipPath") or "url(" in definitions:
        return None
    if _RELATIVE.search(definitions):  # to a viewport that is not known here
        return None
    try:
        drawn = read_nodes(f"{_HEAD}{definitions}</svg>".encode(), [name[1]])[name[1]]
    except FormatError:
        return None
    if len(drawn.elements) != 1 or drawn.effects or drawn.elements[0].outline is None:
        return None
    return drawn.elements[0].outline, "evenodd" if _EVEN_ODD.search(definitions) else "nonzero"
