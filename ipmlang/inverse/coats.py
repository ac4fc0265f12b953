"""Shapes that come in many styles: one asset, and declarations where each copy stands.

Takes the rules and their terminals; says which terminals another one's asset can draw, and with
which declarations. Only copies that no rule explains are merged: a rule names a style by its asset.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from ipmlang.formats.drawing import Style
from ipmlang.formats.numbers import decimal_text
from ipmlang.inverse.build import Painted
from ipmlang.inverse.simplify import Book
from ipmlang.inverse.terminals import Terminal

LEAST = 12  # styles of one shape before its assets are merged
OFTEN = 3  # copies of one style, on average, that make it worth an asset of its own


def merged_styles(book: Book, terminals: Sequence[Terminal]) -> dict[int, Painted]:
    """Terminals by number that the asset of another one, or their own, draws with declarations."""
    free = _only_in_axiom(book)
    often: Counter[int] = Counter()
    for rule in book.written_once():
        often.update({part: len(rows) for part, rows in book.bodies[rule].rows.items()})
    groups: dict[tuple[int, frozenset[str]], list[int]] = {}
    for number, terminal in enumerate(terminals):
        if number in free and _is_plain(terminal):
            keys = frozenset(name for name, _ in terminal.style.more)
            groups.setdefault((id(terminal.shape), keys), []).append(number)
    merged: dict[int, Painted] = {}
    for numbers in groups.values():
        uses = sum(often[number] for number in numbers)
        if len(numbers) >= LEAST and uses < OFTEN * len(numbers):
            base = terminals[numbers[0]].style
            for number in numbers:
                merged[number] = Painted(numbers[0], declarations(base, terminals[number].style))
    return merged


def _only_in_axiom(book: Book) -> set[int]:
    """Symbols that the axiom alone names, or groups written out in it."""
    once = book.written_once()
    inner = {part for rule, body in book.bodies.items() if rule not in once for part in body.rows}
    inner |= set(book.repeated())
    return {part for rule in once for part in book.bodies[rule].rows} - inner


def _is_plain(terminal: Terminal) -> bool:
    style = terminal.style
    paints = isinstance(style.fill, str) and isinstance(style.stroke, str)
    return terminal.fragment is None and paints and style.stroke_matrix is None


def declarations(base: Style, style: Style) -> str:
    """What turns one plain style into another with the same properties.

    >>> declarations(Style(stroke="#000000"), Style(stroke="#ff0000", stroke_width=2.5))
    'stroke:#ff0000;stroke-width:2.5'
    """
    paints = (("fill", base.fill, style.fill), ("stroke", base.stroke, style.stroke))
    changed = [(name, str(new)) for name, old, new in paints if old != new]
    if base.stroke_width != style.stroke_width:
        changed.append(("stroke-width", decimal_text(style.stroke_width, 12)))
    if base.dashes != style.dashes:
        dashes = ",".join(decimal_text(each, 12) for each in style.dashes)
        changed.append(("stroke-dasharray", dashes or "none"))
    if base.dash_offset != style.dash_offset:
        changed.append(("stroke-dashoffset", decimal_text(style.dash_offset, 12)))
    before = dict(base.more)
    changed += [(name, value) for name, value in style.more if before.get(name) != value]
    return ";".join(f"{name}:{value}" for name, value in changed)
