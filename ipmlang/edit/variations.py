"""Variations of one grammar: the same program with other seeds and attributes, one after the other.

In go a program and which variations are wanted; out come drawings, or what went wrong with one,
which spoils no other. Only flat grammars have drawings. Nothing is written here.
"""

from __future__ import annotations

import hashlib
import math
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from ipmlang.compiler.diagnostics import Diagnostic, IpmError, fail, nearest
from ipmlang.compiler.ir import Attribute, Limits, Program
from ipmlang.formats.drawing import Drawing

Value: TypeAlias = "int | float | bool | str"
MOST = 400  # variations on one sheet
ELEMENTS = 1_000_000  # drawn on one sheet


@dataclass(frozen=True, slots=True)
class Sweep:
    """An attribute that goes from `low` to `high` in equal steps."""

    name: str
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Wish:
    """One variation that is wanted. told: the attributes that make it different, for its caption;
    values: all that are given.
    """

    seed: int
    told: Mapping[str, Value] = field(default_factory=dict)
    values: Mapping[str, Value] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Variation:
    """What became of a wish: a drawing, or the problems that it met. print: equal for results that
    look the same.
    """

    wish: Wish
    drawing: Drawing | None
    terminals: int = 0
    print: str = ""
    problems: tuple[Diagnostic, ...] = ()


# ---------------------------------------------------------------------- what is wanted


def wishes(
    program: Program,
    count: int,
    *,
    seed: int = 0,
    sweeps: Sequence[Sweep] = (),
    draw_attributes: bool = False,
    fixed: Mapping[str, Value] | None = None,
) -> list[Wish]:
    """Which variations to make: `count` seeds from the first; or, with sweeps, one seed and other
    values of one attribute, or of two (the first changes along a row, the second from row to row).
    """
    fixed = dict(fixed or {})
    _check(program, count, sweeps, fixed)
    grid = _swept(program, count, sweeps) if sweeps else [{}] * count
    found = []
    for number, told in enumerate(grid):
        own = seed if sweeps else seed + number
        drawn = _drawn(program, own, {*fixed, *told}) if draw_attributes else {}
        found.append(Wish(own, {**told, **drawn}, {**fixed, **drawn, **told}))
    return found


def columns_of(sweeps: Sequence[Sweep], found: Sequence[Wish]) -> int | None:
    """How many columns a sheet of two sweeps has."""
    if len(sweeps) != 2:
        return None
    return len({wish.told[sweeps[0].name] for wish in found})


def _check(
    program: Program, count: int, sweeps: Sequence[Sweep], fixed: Mapping[str, Value]
) -> None:
    if not 1 <= count <= MOST:
        raise fail("bad-command", f"a sheet has 1 to {MOST} variations, not {count}")
    if len(sweeps) > 2:
        hint = "sweep one attribute, or two for rows and columns; --attributes draws them all"
        raise fail("bad-command", f"{len(sweeps)} sweeps do not fit on a sheet", hint=hint)
    known = {each.name: each for each in program.attrs}
    for sweep in sweeps:
        if sweep.name not in known:
            missing = f"there is no attribute `{sweep.name}`"
            meant = nearest(sweep.name, known)
            raise IpmError([Diagnostic("unknown-attribute", missing, suggestions=meant)])
        if known[sweep.name].type not in ("int", "float"):
            raise fail("bad-command", f"`{sweep.name}` is no number, so it has no range to sweep")
        if sweep.name in fixed:
            raise fail("bad-command", f"`{sweep.name}` is both set and swept")


def _swept(program: Program, count: int, sweeps: Sequence[Sweep]) -> list[dict[str, Value]]:
    whole = {each.name: each.type == "int" for each in program.attrs}
    if len(sweeps) == 1:
        sweep = sweeps[0]
        return [{sweep.name: value} for value in _steps(sweep, count, whole[sweep.name])]
    across = _steps(sweeps[0], math.ceil(math.sqrt(count)), whole[sweeps[0].name])
    down = _steps(sweeps[1], max(1, count // len(across)), whole[sweeps[1].name])
    return [{sweeps[0].name: x, sweeps[1].name: y} for y in down for x in across]


def _steps(sweep: Sweep, count: int, whole: bool) -> list[Value]:
    values = np.linspace(sweep.low, sweep.high, count)
    if whole:
        return [int(each) for each in dict.fromkeys(np.round(values).astype(int).tolist())]
    return [float(f"{each:.6g}") for each in values.tolist()]


def _drawn(program: Program, seed: int, taken: set[str]) -> dict[str, Value]:
    """A value for every attribute that has a range, drawn with the seed; where only one end of the
    range is given, the other is as far from the default.
    """
    from ipmlang.runtime.bind import bind
    from ipmlang.runtime.keys import root, uniform_single

    k0, k1 = root(seed)
    _, defaults = bind(program, None, seed)
    found: dict[str, Value] = {}
    for attr, default in zip(program.attrs, defaults, strict=True):
        if attr.name in taken:
            continue
        share = uniform_single(k0, k1, zlib.crc32(attr.name.encode()) & 0x3FFFFFFF)
        value = _within(attr, default, share)
        if value is not None:
            found[attr.name] = value
    return found


def _within(attr: Attribute, default: float, share: float) -> Value | None:
    if attr.choices:
        return attr.choices[int(share * len(attr.choices))]
    if attr.type == "bool":
        return share < 0.5
    if attr.type == "string" or (attr.low is None and attr.high is None):
        return None
    low = 2 * default - (attr.high or 0.0) if attr.low is None else attr.low
    high = 2 * default - low if attr.high is None else attr.high
    if attr.type == "int":
        return math.floor(low + share * (high - low + 1))
    return float(f"{low + share * (high - low):.6g}")


# ------------------------------------------------------------------------- what came out


def vary(
    program: Program, wanted: Sequence[Wish], limits: Limits | None = None
) -> Iterator[Variation]:
    """The variations one by one. Raises IpmError if the grammar leaves the plane, or if they get
    too many elements for one sheet.
    """
    total = 0
    for wish in wanted:
        made = _variation(program, wish, limits)
        total += len(made.drawing.elements) if made.drawing is not None else 0
        if total > ELEMENTS:
            hint = "ask for fewer variations with -n, or for smaller ones with --set"
            what = f"the sheet would have over {ELEMENTS:,} elements"
            raise fail("sheet-too-large", what, hint=hint)
        yield made


def _variation(program: Program, wish: Wish, limits: Limits | None) -> Variation:
    from ipmlang.runtime import derive
    from ipmlang.runtime.export.sheet import drawing_of

    try:
        scene = derive(program, seed=wish.seed, attrs=wish.values, limits=limits)
        if scene.flat:
            drawing = drawing_of(scene)
            return Variation(wish, drawing, len(scene.instances), _print(drawing))
    except IpmError as error:
        return Variation(wish, None, problems=error.diagnostics)
    hint = "derive it seed by seed into .glb; pictures of 3-D come with `render`"
    raise fail("not-flat", "this grammar leaves the plane, so it has no contact sheet", hint=hint)


def _print(drawing: Drawing) -> str:
    """Equal for drawings that look the same."""
    digest = hashlib.blake2b(digest_size=16)
    styles: dict[int, bytes] = {}
    for element in drawing.elements:
        style = styles.get(id(element.style))
        if style is None:
            style = styles[id(element.style)] = repr(element.style).encode()
        digest.update(style)
        if element.outline is not None:
            digest.update(element.outline.coords.tobytes())
        if element.fragment is not None:
            digest.update(repr(element.fragment).encode())
    return digest.hexdigest()


def same_for_all(variations: Sequence[Variation]) -> bool:
    """Whether there are several, and they all look the same."""
    made = [each for each in variations if each.drawing is not None]
    return len(made) > 1 and len({each.print for each in made}) == 1
