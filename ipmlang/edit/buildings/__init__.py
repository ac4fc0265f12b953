"""Edits that keep the structure of a building: its parts are stretched, copied, joined and re-used.

In go drafts of split grammars, out come drafts; what touched still touches, or the edit is refused.
After Demir, Aliaga and Benes, "Proceduralization for Editing 3D Architectural Models" (2016),
section 4. Nothing here reads files that the draft does not name, and nothing writes.

>>> from ipmlang import edit
>>> from ipmlang.edit.buildings import Wanted, resize
>>> gate = edit.read_text('''ipm 1
... Gate --> [size(1, 1, 4) cube Pier] [translate(1, 0, 3) size(3, 1, 1) cube Beam]
... start Gate
... ''')
>>> print(resize(gate, "Pier", Wanted(x=2.0)).text.splitlines()[1])
Gate --> [size(2, 1, 4) cube Pier] [translate(2, 0, 3) size(3, 1, 1) cube Beam]
"""

from __future__ import annotations

from ipmlang.edit.buildings.dividing import add, cut, join, remove, scale, split
from ipmlang.edit.buildings.pasting import Copying, mixed, paste, transfer
from ipmlang.edit.buildings.resizing import Wanted, resize

__all__ = [
    "Copying",
    "Wanted",
    "add",
    "cut",
    "join",
    "mixed",
    "paste",
    "remove",
    "resize",
    "scale",
    "split",
    "transfer",
]
