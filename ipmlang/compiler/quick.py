"""Frozen dataclasses of which there are many thousands, made in half the time.

In goes a class, out comes the class: what it means, compares and hashes is as before.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, fields
from typing import TypeVar

Kind = TypeVar("Kind")


def quick(kind: type[Kind]) -> type[Kind]:
    """A frozen dataclass with slots, whose objects are filled by the slots themselves: what
    `dataclass` writes asks `object` to look each of them up by its name.

    >>> from dataclasses import dataclass
    >>> @quick
    ... @dataclass(frozen=True, slots=True)
    ... class Pair:
    ...     one: int
    ...     other: int = 2
    >>> Pair(1), Pair(other=3, one=1) == Pair(1, 3)
    (Pair(one=1, other=2), True)
    """
    space: dict[str, object] = {}
    given, lines = [], []
    for each in fields(kind):  # type: ignore[arg-type]
        assert each.init and each.default_factory is MISSING
        default = "" if each.default is MISSING else f"=default_{each.name}"
        space[f"default_{each.name}"] = each.default
        space[f"set_{each.name}"] = getattr(kind, each.name).__set__
        given.append(f"{each.name}{default}")
        lines.append(f"    set_{each.name}(self, {each.name})")
    head = f"def __init__(self, {', '.join(given)}):"
    exec("\n".join([head, *lines]), space)
    made = space["__init__"]
    assert isinstance(made, Callable)  # type: ignore[arg-type]
    kind.__init__ = made  # type: ignore[assignment]
    return kind
