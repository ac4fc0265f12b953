"""The syntax tree of one `.ipm` file: frozen dataclasses without behaviour.

Parsing makes these, inference builds them directly, `format.py` alone prints them. Spans and
comments take no part in equality, so `parse(format(g)) == g` is the round-trip test. A span is
relative to the start of the top-level item it stands in: an item that did not change keeps its tree
when text above it is edited. An item starts where the one before it ends, so that the empty lines
and comments above its code are its own; `blank_before` says whether it has an empty line above.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, NamedTuple, TypeAlias

from ipmlang.compiler.quick import quick


class Span(NamedTuple):
    """Half-open character range, relative to the start of the enclosing top-level item."""

    start: int
    end: int


NOWHERE = Span(0, 0)


@dataclass(frozen=True, slots=True)
class Comment:
    """One `//` comment: its text after the slashes, its place, whether code stands before it on its
    line, and whether an empty line stands above it.
    """

    text: str
    span: Span = field(default=NOWHERE, compare=False)
    trailing: bool = False
    blank_before: bool = False


# ---------------------------------------------------------------- expressions


@quick
@dataclass(frozen=True, slots=True)
class Number:
    """A literal; `text` is how it was written (`0.10`), kept by the formatter, ignored by ==."""

    value: float
    text: str = field(default="", compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@quick
@dataclass(frozen=True, slots=True)
class Text:
    """A string literal, `value` without quotes and with escapes resolved."""

    value: str
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Truth:
    """`true` or `false`."""

    value: bool
    span: Span = field(default=NOWHERE, compare=False)


@quick
@dataclass(frozen=True, slots=True)
class Name:
    """A parameter, attribute, constant, column or context: `w`, `roofs.pitch`, `r.x`."""

    id: str
    span: Span = field(default=NOWHERE, compare=False)


@quick
@dataclass(frozen=True, slots=True)
class Call:
    """A function in an expression: `max(1, w)`, `rand(-5, 5)`."""

    name: str
    args: tuple[Argument, ...]
    span: Span = field(default=NOWHERE, compare=False)


@quick
@dataclass(frozen=True, slots=True)
class Unary:
    """`-x`, `not x`; a minus before a literal belongs to the literal: `-5` is Number(-5)."""

    op: Literal["-", "not"]
    value: Expr
    span: Span = field(default=NOWHERE, compare=False)


BinaryOp: TypeAlias = Literal["+", "-", "*", "/", "<", "<=", ">", ">=", "==", "!=", "and", "or"]


@quick
@dataclass(frozen=True, slots=True)
class Binary:
    """`a op b`; comparisons do not chain."""

    op: BinaryOp
    left: Expr
    right: Expr
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class If:
    """`if condition then value else other`."""

    condition: Expr
    value: Expr
    other: Expr
    span: Span = field(default=NOWHERE, compare=False)


@quick
@dataclass(frozen=True, slots=True)
class Tuple:
    """`(2.4, 0, 0)`: a vector or point. A bracketed single expression is not a tuple."""

    items: tuple[Expr, ...]
    span: Span = field(default=NOWHERE, compare=False)


Expr: TypeAlias = "Number | Text | Truth | Name | Call | Unary | Binary | If | Tuple"


@quick
@dataclass(frozen=True, slots=True)
class Argument:
    """One argument; `sides: 12` has the name `sides`."""

    value: Expr
    name: str | None = None
    span: Span = field(default=NOWHERE, compare=False)


# ------------------------------------------------------- elements of a successor


@quick
@dataclass(frozen=True, slots=True)
class Module:
    r"""A shape or an operation without braces: `Window(2)`, `f(64)`, `+(17)`, `extrude(9)`.

    Whether `name` is an operation or a symbol is the checker's to say (a head may bear an
    operation's name). Turtle marks are names too: `+ - * & ^ \ / $ !`.
    """

    name: str
    args: tuple[Argument, ...] = ()
    span: Span = field(default=NOWHERE, compare=False)
    comments: tuple[Comment, ...] = field(default=(), compare=False)


@quick
@dataclass(frozen=True, slots=True)
class Bracket:
    """`[ … ]`: saves and restores the whole state."""

    body: tuple[Element, ...]
    span: Span = field(default=NOWHERE, compare=False)
    comments: tuple[Comment, ...] = field(default=(), compare=False)


@dataclass(frozen=True, slots=True)
class Count:
    """The head `i < n` of a repeat: i runs over 0 .. n-1."""

    variable: str
    limit: Expr
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Rows:
    """The head `r in T` of a repeat, or its `with r in T`: r names a row of table T. The head
    `at T` names it `at`, and each copy stands alone, at the place that its row says.
    """

    variable: str
    table: str
    places: bool = False
    span: Span = field(default=NOWHERE, compare=False)


@quick
@dataclass(frozen=True, slots=True)
class Repeat:
    """`repeat(head) except (3, 7) steps (0.8, 0.7) with r in T { body }`.

    `steps`: between copy k and k+1 the turtle moves forward by the k-th step. `rows`: copy k also
    sees row k of a table. `holes`: copies that move the turtle but draw nothing.
    """

    head: Count | Rows
    body: tuple[Element, ...]
    holes: tuple[Expr, ...] = ()
    steps: tuple[Expr, ...] = ()
    rows: Rows | None = None
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Size:
    """A size in a split: absolute `4.4`, relative `'0.618`, floating `~3.2`."""

    kind: Literal["absolute", "relative", "floating"]
    value: Expr
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class SplitPart:
    """`~3.2: Floor`."""

    size: Size
    body: tuple[Element, ...]
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class SplitGroup:
    """`{ ~1: A | ~2: B }*` (whole repeats) or `}+` (a cut last piece too)."""

    parts: tuple[SplitPart | SplitGroup, ...]
    mode: Literal["*", "+"]
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Split:
    """`split y { 4.4: Ground | { ~3.2: Floor }* | 0.6: Cornice }`; args may follow the axis."""

    axis: str
    parts: tuple[SplitPart | SplitGroup, ...]
    args: tuple[Argument, ...] = ()
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Part:
    """One part in braces: `side: Facade`, `11: corner`, or a bare `leaf` (label None)."""

    label: Expr | None
    body: tuple[Element, ...]
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Block:
    """An operation with parts in braces: `comp { … }`, `march(step, 0) { … }`, `polygon { … }`."""

    name: str
    args: tuple[Argument, ...]
    parts: tuple[Part, ...]
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Each:
    """`tube(0.01) at each segment { leaf }`: what `target` makes places the parts."""

    target: Module
    feature: str
    parts: tuple[Part, ...]
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Assign:
    """`set name = value`: holds for the descendants of this body. The value is the longest
    expression that follows; `set (name = value)` ends it before a turtle mark.
    """

    name: str
    value: Expr
    span: Span = field(default=NOWHERE, compare=False)
    comments: tuple[Comment, ...] = field(default=(), compare=False)


@dataclass(frozen=True, slots=True)
class Local:
    """`with name = value`: what follows in this body calls the value so. It is computed once, where
    this stands; `with (name = value)` ends the value before a turtle mark.
    """

    name: str
    value: Expr
    span: Span = field(default=NOWHERE, compare=False)
    comments: tuple[Comment, ...] = field(default=(), compare=False)


Element: TypeAlias = "Module | Bracket | Repeat | Split | Block | Each | Assign | Local"


# ------------------------------------------------------------------- items


@dataclass(frozen=True, slots=True)
class Parameter:
    name: str
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Context:
    """One side of a context-sensitive head: modules with parameter names, brackets allowed."""

    modules: tuple[ContextModule | ContextBranch, ...]
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class ContextModule:
    """`B(x)` in a context; the name `*` matches any module."""

    name: str
    parameters: tuple[Parameter, ...] = ()
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class ContextBranch:
    """`[H]` in a right context."""

    modules: tuple[ContextModule | ContextBranch, ...]
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Head:
    """`A < B(x) > C`."""

    name: str
    parameters: tuple[Parameter, ...] = ()
    left: Context | None = None
    right: Context | None = None
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Chance:
    """`30%` (kind percent, value 30) or `weight w`."""

    kind: Literal["percent", "weight"]
    value: Expr
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Otherwise:
    """The guard `else`."""

    span: Span = field(default=NOWHERE, compare=False)


@quick
@dataclass(frozen=True, slots=True)
class Rule:
    """`Head : guard : chance --> body`; `interpret` marks an interpretation rule.

    `: guard`, `: 30%`, `: guard : 30%`, `: weight w`, `: guard : weight w`, `: else` are legal.
    """

    head: Head
    body: tuple[Element, ...]
    guard: Expr | Otherwise | None = None
    chance: Chance | None = None
    interpret: bool = False
    doc: str | None = None
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Version:
    """`ipm 1`."""

    number: int
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Import:
    """`import "std/roofs" as roofs style Old`; without `as` the last word of the path is the name,
    without `style` the file is taken as it is.
    """

    path: str
    alias: str | None = None
    style: str | None = None
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Style:
    """`style Night extends Dusk "lamps are lit"`: the file with what is defined under names such as
    `Night.Window` in the place of what is called so here, or in the style that it extends.
    """

    name: str
    parent: str | None = None
    doc: str | None = None
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Asset:
    """`asset win = "house.glb#window_2"`, or `asset A, B in "x.parts.svg"` (ids are the names).
    `stretch (1.5, 1, 1)` behind it draws them so many times as large along their own axes.
    """

    names: tuple[str, ...]
    reference: str
    by_name: bool = False
    stretch: tuple[Number, ...] = ()
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@quick
@dataclass(frozen=True, slots=True)
class Table:
    """`table T = "x.parts.svg#T"`, or inline: `table T(x, y) =` and rows `1, 2`, or
    `(a + 1, 2)` where a cell is more than a number or a text.

    `row_comments` are pairs of a row's index and a comment above it or behind it.
    """

    name: str
    reference: str | None = None
    columns: tuple[str, ...] = ()
    rows: tuple[tuple[Expr, ...], ...] = ()
    row_comments: tuple[tuple[int, Comment], ...] = field(default=(), compare=False)
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Surface:
    """`surface wall = "statue.obj" atlas 1024`."""

    name: str
    reference: str
    atlas: int | None = None
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Field:
    """`context mask = "mask.png" over (0, 0, 200, 100)`, `context wind : vector = "wind.npy"`;
    kind is texture, scalar or vector. `place`: left, bottom, width and height of the rectangle of
    the ground that it covers; `nearest`: single texels, nothing between them.
    """

    name: str
    reference: str
    kind: Literal["texture", "scalar", "vector"] = "texture"
    place: tuple[Expr, ...] | None = None
    nearest: bool = False
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Range:
    """`1..60`, `1..`, `..60`."""

    low: Expr | None
    high: Expr | None
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Choices:
    """`{ "brick", "stone" }` as the range of an attribute."""

    values: tuple[Expr, ...]
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Attr:
    """`attr floors : int = 6 in 1..60 "storeys above ground"`; type int, float, bool or string."""

    name: str
    type: str | None
    default: Expr
    allowed: Range | Choices | None = None
    doc: str | None = None
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Const:
    name: str
    value: Expr
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Function:
    """`fn bays(w) = max(1, floor(w / module))`."""

    name: str
    parameters: tuple[Parameter, ...]
    value: Expr
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Setting:
    """One word and value of a `turtle` or `limit` item: `angle 25.7`, `frame abop`."""

    key: str
    value: Expr
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Turtle:
    """`turtle angle 25.7 step 1 width 2 frame abop`."""

    settings: tuple[Setting, ...]
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Limit:
    """`limit shapes 2000000 depth 1000 steps 50 memory 4e9` (memory in bytes)."""

    settings: tuple[Setting, ...]
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Tropism:
    """`tropism (0, 0, -1) 0.22`."""

    vector: Expr
    elasticity: Expr
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Ignore:
    """`ignore + - F`: symbols that context matching looks through."""

    names: tuple[str, ...]
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Residual:
    """`residual T`: row k of the table adjusts the k-th terminal that is drawn."""

    table: str
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Canvas:
    """`canvas (0, 0, 640, 480) width "10in" height "7.5in"`: lower left corner and size of a
    drawing, y up; the numbers are those of the SVG viewBox, which is flipped about its middle.
    `decimals 2` rounds the points of what is drawn.
    """

    box: tuple[Expr, ...]
    width: str | None = None
    height: str | None = None
    decimals: int | None = None
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Axes:
    """`axes y-up`: the up axis that OBJ, STL and PLY are written with."""

    up: Literal["y-up", "z-up"]
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Site:
    """`site S1 = "castle.parts.glb#S1" radius 0.26`."""

    name: str
    reference: str
    radius: Expr | None = None
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Place:
    """What stands after `on`: `box(8, 11, 0)`, `polygon [(0,0), …]`, `"lots.svg"`, a surface."""

    kind: Literal["box", "polygon", "file", "surface"]
    args: tuple[Expr, ...] = ()
    reference: str | None = None
    span: Span = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Start:
    """`start Ivy(0) on wall seeds 1000 direction uniform steps 200`."""

    axiom: tuple[Element, ...]
    place: Place | None = None
    steps: Expr | None = None
    seeds: Expr | None = None
    direction: str | None = None
    sites: tuple[str, ...] = ()
    avoiding: str | None = None
    retries: Expr | None = None
    choices: str | None = None
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    blank_before: bool = field(default=False, compare=False)
    span: Span = field(default=NOWHERE, compare=False)


Item: TypeAlias = (
    Version
    | Import
    | Style
    | Asset
    | Table
    | Surface
    | Field
    | Attr
    | Const
    | Function
    | Turtle
    | Limit
    | Tropism
    | Residual
    | Ignore
    | Canvas
    | Axes
    | Site
    | Start
    | Rule
)


@dataclass(frozen=True, slots=True)
class Grammar:
    """A whole file. `offsets[i]` is where item i starts in the source, in characters.

    `header` are the comments above the first item; `trailer` those after the last.
    """

    items: tuple[Item, ...]
    header: tuple[Comment, ...] = field(default=(), compare=False)
    trailer: tuple[Comment, ...] = field(default=(), compare=False)
    offsets: tuple[int, ...] = field(default=(), compare=False)
