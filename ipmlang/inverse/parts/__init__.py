"""Parts: what a model is made of, as placed copies of shape classes.

`observe` reads a model, welds it, takes it apart into connected pieces and finds which of them are
the same up to a rigid motion or a mirror. Nothing here looks for patterns or writes grammars.
"""

from __future__ import annotations

from ipmlang.inverse.parts.observation import PartClass, Parts
from ipmlang.inverse.parts.observing import observe, observe_with_faces, parts_of

__all__ = ["PartClass", "Parts", "observe", "observe_with_faces", "parts_of"]
