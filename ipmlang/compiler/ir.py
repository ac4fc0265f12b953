"""The typed intermediate representation: symbols, productions and straight-line code.

Lowering ends every rule family here; executors know nothing else. Registers are numbered per
production and written once. A production's body is a list of instructions that compute numbers and
list child modules; what a module without productions does to the turtle or draws is its symbol's
`meaning`, a body of state and drawing instructions over the module's own parameters. The batched
frontier inlines meanings; threaded strings keep the modules and interpret at the end.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias

from ipmlang.compiler.diagnostics import Source
from ipmlang.compiler.quick import quick

Opcode: TypeAlias = Literal[
    # values: write register `out`
    "const",  # const: float
    "param",  # const: i, the shape's i-th parameter (after left context's, before right context's)
    "attr",  # const: i into Program.attrs, the value bound for this run
    "index",  # const: repeat number; the copy's index
    "row",  # args (index,); const (table number, column number)
    "call",  # const: name of a pure function record; args
    "uniform",  # site; the 24-bit number in [0, 1) of (seed, key, site)
    "state",  # const: sx, sy, sz (the scope's extents), x, y, z (its origin), label
    "measure",  # const: area, volume or sides of the geometry; axis, step or length of u or v
    "count",  # const: repeat number; how many copies there are
    "fetch",  # args (x, y) on the ground; const (context number, channel)
    "query",  # args: labels or keys, and what goes with them; const: name of a query; site
    "self",  # a number that tells the shapes of a batch apart
    # children and structure of a body
    "module",  # const: symbol number; args: its parameters; site
    "open",  # [
    "close",  # ]
    "repeat",  # args (count, *holes); const: repeat number; site; body
    "slab",  # args (low, size); const axis 0, 1 or 2; body: of the part of the scope between
    "slab_along",  # args (low, size, axis); const u or v: the same, the axis differs; 3 is aslant
    "pieces",  # args; const (operation, number); body: "part"s, each for what its selector takes
    "piece",  # args (self, low, size); const (number, part, stretches): one of a split that snaps
    "snapped",  # args (name, within, reach); const (axis, number): such a split; body: "part"s
    "part",  # const: a selector; body
    "join",  # const: union, subtract or intersect; body: "part"s, whose solids it makes one of
    # state, in meanings only
    "move",  # args (x, y, z) along the local axes, in frame units
    "rotate",  # args (degrees,); const "x", "y" or "z": about the local axis
    "orient",  # args (w, x, y, z): multiply by a quaternion
    "scale",  # args (factor,)
    "mirror",  # flip the handedness (local x first)
    "level",  # the book's $
    "resize",  # args (sx, sy, sz): the scope's extents
    "solid",  # args; const: the operation that makes another geometry of the shape's own
    "center",  # args (axes,): move the scope to the middle of the one that the body began with
    "report",  # args (key, value): add to the sum under a key
    "phase",  # args (number,): the shapes made from here on wait for those of earlier phases
    "lay",  # args; const: the operation that says how textures lie on what follows
    "snap",  # args (name, axis, place): make a line for splits of later phases
    "pen",  # args (value,) or (); const (field, text or None): width, color, css, effect, material
    "layer",  # args (d,): raise the paint order of what follows
    "cut",  # the book's %
    # drawing, in meanings only
    "segment",  # args (length,): draw along local x and move to its end
    "emit",  # args (sx, sy, sz) or (); const: asset number, or -1 for a terminal's own scope
    "polygon_open",
    "polygon_close",
    "path_open",
    "path_close",
    "vertex",
]

Const: TypeAlias = "float | int | str | tuple[object, ...] | None"
Chance: TypeAlias = "tuple[Literal['percent', 'weight'], tuple[Instruction, ...], int]"

VALUE_OPS = frozenset({
    "const", "param", "attr", "index", "row", "call", "uniform", "fetch", "state", "measure",
    "count", "query", "self",
})  # fmt: skip
BODY_OPS = frozenset({
    "module", "open", "close", "repeat", "slab", "slab_along", "pieces", "piece", "snapped", "part",
    "join",
})  # fmt: skip
SCOPE_OPS = frozenset({
    "state", "measure", "query", "slab", "slab_along", "pieces", "resize", "solid", "center",
    "report", "phase", "lay", "join", "snap", "snapped",
})  # fmt: skip
RESIDUAL_TEXTS = ("css", "color", "fill", "stroke")
RESIDUAL_COLUMNS = ("of", "x", "y", "z", "angle", "scale", "layer", *RESIDUAL_TEXTS)


@quick
@dataclass(frozen=True, slots=True)
class Instruction:
    """One instruction. `out` is the register it writes or -1; `args` the registers it reads; `site`
    a number unique within the production for random draws and children (-1: none); `span` where it
    was written, relative to its item.
    """

    op: Opcode
    out: int = -1
    args: tuple[int, ...] = ()
    const: Const = None
    site: int = -1
    body: tuple[Instruction, ...] = ()
    span: tuple[int, int] = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Pattern:
    """One module of a context: symbol number or -1 for any, arity to match, or a branch."""

    symbol: int
    arity: int = 0
    branch: tuple[Pattern, ...] = ()


@dataclass(frozen=True, slots=True)
class Production:
    """One alternative of a symbol.

    `guard`: instructions and the register with the truth value, None when there is none.
    `chance`: None, or kind, instructions and the register with percent or weight.
    `parameters` counts left-context, own and right-context parameters, in this order.
    """

    symbol: int
    body: tuple[Instruction, ...]
    registers: int
    parameters: int = 0
    guard: tuple[tuple[Instruction, ...], int] | None = None
    otherwise: bool = False
    chance: Chance | None = None
    left: tuple[Pattern, ...] = ()
    right: tuple[Pattern, ...] = ()
    item: int = -1  # index into Grammar.items, for messages
    path: str = ""
    line: int = 0


@dataclass(frozen=True, slots=True)
class Symbol:
    """A name with an arity.

    `productions`: numbers of its alternatives in source order (empty: terminal or operation).
    `interpretation`: numbers of `interpret` alternatives. `meaning`: what a module of it that is
    left over does, None for nothing. `moves`: expanding or interpreting it can change the state for
    what follows (computed as a fixed point over productions). `carried`: how many parameters, the
    last ones of `arity`, are attributes that some `set` changes: nobody wrote them. `held`: what
    its meaning does to the state ends with the body it stands in. `apart`: in a program with
    scopes, a module of it is derived as a string of its own, whose turtle starts where it stands.
    `given`: the names of the symbols that it is told, by argument, None for those that are values;
    nothing where it takes no symbols.
    """

    name: str
    arity: int
    productions: tuple[int, ...] = ()
    interpretation: tuple[int, ...] = ()
    meaning: tuple[Instruction, ...] | None = None
    meaning_registers: int = 0
    moves: bool = False
    carried: int = 0
    held: bool = False
    apart: bool = False
    given: tuple[str | None, ...] = ()


@dataclass(frozen=True, slots=True)
class Attribute:
    """A settable number, truth value or text, with its default as code over earlier attributes
    (register `default[1]`), evaluated once per run with the seed's root key. `hidden`: nobody
    wrote it and nobody may set it from outside.
    """

    name: str
    type: Literal["int", "float", "bool", "string"]
    default: tuple[tuple[Instruction, ...], int]
    registers: int
    low: float | None = None
    high: float | None = None
    choices: tuple[str | float, ...] = ()
    doc: str | None = None
    hidden: bool = False


@dataclass(frozen=True, slots=True)
class AssetFile:
    """A terminal's geometry: name, absolute path, node or id (None: the whole file), and how many
    times as large it is along x, y and z; () for as large as in the file.
    """

    name: str
    path: Path
    node: str | None
    stretch: tuple[float, ...] = ()


Rectangle: TypeAlias = "tuple[float, float, float, float]"


@dataclass(frozen=True, slots=True)
class ContextFile:
    """A picture or field that code samples: name, absolute path, kind, and left, bottom, width and
    height of what it covers of the ground. `late`: code over the attributes and the registers of
    these four, where it decides them; `place` is None until a run starts. `nearest`: single texels
    are given. `channels`: how many must be there. `source`, `start`, `end`: its item, for messages.
    """

    name: str
    path: Path
    kind: Literal["texture", "scalar", "vector"]
    place: Rectangle | None = (0.0, 0.0, 1.0, 1.0)
    late: tuple[tuple[Instruction, ...], tuple[int, ...]] | None = None
    nearest: bool = False
    channels: int = 1
    source: Source | None = field(default=None, compare=False, repr=False)
    start: int = 0
    end: int = 0


@dataclass(frozen=True, slots=True)
class TableData:
    """Rows of numbers. Text cells are numbers of Program.strings."""

    name: str
    columns: tuple[str, ...]
    text_columns: frozenset[str]
    rows: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, slots=True)
class Residual:
    """Row k of the table with this number adjusts the k-th drawn terminal, or that with the number
    in its column `of`, by its columns of RESIDUAL_COLUMNS. `strict`: another number of rows than
    terminals, or a row for none, is an error.
    """

    table: int
    strict: bool = True


@dataclass(frozen=True, slots=True)
class Limits:
    """Where a derivation stops with an error: shapes (all ever made), steps (generations), depth
    (of the derivation tree), memory in bytes beyond the process as it was.
    """

    shapes: int = 50_000_000
    steps: int = 200_000
    depth: int = 200_000
    memory: int = 8_000_000_000


@dataclass(frozen=True, slots=True)
class Late:
    """Settings whose numbers attributes decide: code over them, run once when a run starts, and the
    registers of a tropism (x, y, z, elasticity) and of limits by name. They take the places of
    Program.tropism and of fields of Program.limits.
    """

    code: tuple[Instruction, ...]
    registers: int
    tropism: tuple[int, int, int, int] | None = None
    limits: tuple[tuple[str, int], ...] = ()


@dataclass(frozen=True, slots=True)
class Ground:
    """What a derivation starts on: a box (3 registers), a polygon (2 or 3 registers a corner; the
    number of coordinates is `width`), or the faces and closed paths of a file (or of a node of it),
    one shape each.
    """

    kind: Literal["box", "polygon", "file"]
    code: tuple[Instruction, ...] = ()
    registers: int = 0
    outputs: tuple[int, ...] = ()
    width: int = 3
    path: Path | None = None
    node: str | None = None


@dataclass(frozen=True, slots=True)
class Program:
    """A whole grammar, lowered.

    `axiom` is a production of no symbol (-1). `steps`: None rewrites until no module has
    productions. `threaded`: some module that moves is followed by something that reads the turtle
    in its bracket, or a production has context: derive as a string. `flat`: nothing leaves z = 0.
    `strings`: interned text values; a text in a register is its number. `scoped`: shapes have a
    scope and geometry; `ground`: what the start stands on, None for a turtle or a unit square;
    `varied`: the attributes whose defaults are drawn for each first shape of a file: they are the
    axiom's parameters, in this order. `contexts`: what `fetch` samples.
    """

    symbols: tuple[Symbol, ...]
    productions: tuple[Production, ...]
    axiom: Production
    attrs: tuple[Attribute, ...] = ()
    tables: tuple[TableData, ...] = ()
    assets: tuple[AssetFile, ...] = ()
    strings: tuple[str, ...] = ()
    steps: tuple[tuple[Instruction, ...], int] | None = None
    threaded: bool = False
    flat: bool = True
    abop: bool = False
    tropism: tuple[float, float, float, float] | None = None
    ignore: frozenset[int] = frozenset()
    limits: Limits = Limits()
    canvas: tuple[float, float, float, float] | None = None
    canvas_size: tuple[str | None, str | None] = (None, None)
    decimals: int | None = None
    up: Literal["y-up", "z-up"] = "z-up"
    pen_width: float | None = None
    choices: str | None = None
    residual: Residual | None = None
    late: Late | None = None
    path: str = ""
    scoped: bool = False
    ground: Ground | None = None
    varied: tuple[int, ...] = ()
    contexts: tuple[ContextFile, ...] = ()
