"""What a person would call an arrangement: rows of stars, leaves in a ring.

Takes patterns and names; gives words for the names of rules, and for the names and descriptions of
attributes. Nothing here decides which attributes there are.
"""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass

from ipmlang.inverse.lsystem.patterns import Pattern
from ipmlang.inverse.naming import capital
from ipmlang.inverse.score import SMALL
from ipmlang.inverse.simplify import Book

ACROSS = {"row": "column", "column": "row"}  # what the members of a grid's lines make up


@dataclass(frozen=True, slots=True)
class Wording:
    """Names for the count and the step of a sequence, and what they are described as."""

    count: str
    counted: str
    step: str
    stepped: str


def worded(book: Book, names: Mapping[int, str], nested: Set[int], family: int) -> Wording:
    """The words for a sequence; those for a grid speak of its rows and columns. nested: sequences
    that are written in the one that repeats them.
    """
    inner, kind = _inner(book, family), arrangement(book.loops[family].pattern)
    one, own = names[_member(book, family)], stem(names[family])
    things, single, count = several(one), noun(one), f"{own}_count"
    if inner in nested:
        line, one = arrangement(book.loops[inner].pattern), names[_member(book, inner)]
        things, single = f"{line}s of {several(one)}", line
        if _is_grid(book, family, inner):
            own = f"{stem(one)}_{line}"
            return Wording(f"{own}s", things, f"{own}_step", f"from one {line} to the next")
    outer = [each for each in book.loops if _inner(book, each) == family and family in nested]
    if outer and _is_grid(book, outer[0], family):
        own = f"{stem(one)}_{ACROSS[kind]}"
        count = f"{own}s"
    return Wording(count, f"{things} in a {kind}", f"{own}_step", f"from one {single} to the next")


def worded_lattice(name: str, one: str, line: str, several_lines: bool) -> tuple[Wording, Wording]:
    """The words for the members of a lattice's lines, and for the lines; name: of its rule."""
    own, step = f"{stem(name)}_count", f"{stem(name)}_step"
    if several_lines:
        across = f"{stem(one)}_{ACROSS[line]}" if line in ACROSS else f"{stem(one)}_in_{line}"
        own, step = f"{across}s" if line in ACROSS else across, f"{across}_step"
    members = Wording(own, f"{several(one)} in a {line}", step, f"from one {noun(one)} to the next")
    lines = f"{stem(one)}_{line}"
    things = f"{line}s of {several(one)}"
    return members, Wording(f"{lines}s", things, f"{lines}_step", f"from one {line} to the next")


def _member(book: Book, family: int) -> int:
    """What a sequence repeats, as it is named."""
    part = book.loops[family].part
    return book.family.get(part, part)


def _inner(book: Book, family: int) -> int:
    """The sequence that a sequence repeats, -1 if it repeats something else."""
    return book.family.get(book.loops[family].part, -1)


def _is_grid(book: Book, outer: int, inner: int) -> bool:
    """Whether a sequence of sequences is one of straight rows or columns of single things."""
    straight = all(plain_row(book.loops[each].pattern) for each in (outer, inner))
    return straight and _inner(book, inner) < 0


def arrangement(pattern: Pattern) -> str:
    """What the copies of a pattern stand in.

    >>> arrangement(Pattern("even", (0.0, 2.0, 0.0, 0.0)))
    'column'
    """
    x, y, _, _ = pattern.base
    if pattern.kind == "listed":
        return "row"
    if pattern.kind == "polar":
        return "ring" if abs(pattern.base[2]) <= SMALL else "spiral"
    if pattern.kind == "even":
        if pattern.constant and abs(x) <= SMALL and abs(y) <= SMALL:
            return "stack"
        return "column" if abs(x) < abs(y) else "row"
    if pattern.mirrored:
        return "zigzag"
    turning = any(abs(each[0] + each[3]) > SMALL for each in (pattern.base, pattern.delta))
    return "spiral" if turning else "row"


def plain_row(pattern: Pattern) -> bool:
    """A straight row or column of members that stand alike."""
    return (
        pattern.kind == "even"
        and pattern.constant
        and all(abs(each) <= SMALL for each in pattern.base[2:])
    )


def several(name: str) -> str:
    """More than one of what a name names.

    >>> several("us_star"), several("Motif"), several("leaf_2"), several("arch"), several("entry")
    ('us stars', 'motifs', 'copies of leaf_2', 'arches', 'entries')
    """
    single = noun(name)
    if single == name and not name.isalpha():
        return f"copies of {name}"
    if single.endswith("s") and not single.endswith("ss"):
        return single  # groups are often named by what is in them: flowers, windows
    if single.endswith(("ss", "x", "z", "ch", "sh")):
        return f"{single}es"
    if single.endswith("y") and single[-2:-1] not in "aeiou":
        return f"{single[:-1]}ies"
    return f"{single}s"


def noun(name: str) -> str:
    """What a name names; names with numbers stay as they are.

    >>> noun("LeafRow"), noun("leaf_2")
    ('leaf row', 'leaf_2')
    """
    plain = name.replace("_", "").isalpha()
    return lowered(name).replace("_", " ") if plain else name


def stem(name: str) -> str:
    """A name as the beginning of an attribute's.

    >>> stem("LeafRow"), stem("Motif_2")
    ('leaf_row', 'motif2')
    """
    return lowered(capital(name))


def lowered(name: str) -> str:
    """`LeafRow` as `leaf_row`."""
    return "".join(f"_{c.lower()}" if c.isupper() else c for c in name).strip("_")
