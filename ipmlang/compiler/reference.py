"""The operation table as the language reference: a Markdown page, and entries for hover and help.

In go records, out comes text; `python -m ipmlang.compiler.reference` writes stdlib/REFERENCE.md.
What is not said by a record (items, and how to read the page) is said at its beginning.
"""

from __future__ import annotations

from collections.abc import Iterable

from ipmlang.compiler.checking.arguments import signature
from ipmlang.compiler.ops import (
    ALL_OPERATIONS,
    CONSTANTS,
    FUNCTIONS,
    OPERATIONS,
    OPERATORS,
    PREFIXES,
    QUERIES,
    SETTINGS,
)
from ipmlang.compiler.ops.record import Family, Function, Operation, Query, SettingRecord

FAMILIES: dict[Family, str] = {
    "turtle": "The turtle",
    "pen": "The pen",
    "scope": "The scope",
    "split": "Splitting",
    "solid": "Solids",
    "docking": "Docking",
    "marching": "Marching",
}

ITEMS = {
    "ipm 1": "The language version, and with it the random scheme. The first line of a file.",
    'import "std/plants" as p': "Another file: of the standard library, or beside this one. Its "
    "names "
    "are `p.Leaf`; without `as` the last word of the path goes in front.",
    'import "std/plants" style Old': "The file in one of its styles.",
    'style Night extends Dusk "lamps"': "A style: this file with some of its rules and values "
    "replaced. What it does not replace is as in the style that it extends, or as in the file. "
    "`run --style Night` derives the whole grammar so; `Night.House` in a body derives `House` so, "
    "with all that comes of it.",
    "Night.Window(w) --> body": "Under a dotted name, an item replaces what a style or an import "
    "has under that name: all rules of a symbol with as many parameters (`interpret` rules apart), "
    "or a symbol that has none and would draw itself; `attr Night.lit = 0.9`, `const`, `fn`, "
    "`asset`, `table` and `context` do the same, and of an `attr` what is left out (type, range, "
    "meaning) stays. `plants.Leaf --> body` gives the library another leaf wherever it makes one, "
    "here and in all that this file imports; the library imported once more under another name "
    "stays as it is, and is where to find the old rule. `Night.plants.Leaf` does so in a style, "
    "`streets.plants.Leaf` in what `streets` imports alone. In a rule of a style, names are those "
    "of the style; in a rule for an import, those of the file that it is written in.",
    'asset win = "house.glb#window_2"': "Terminal geometry from an svg, glb, obj, ply or stl "
    "file, by "
    "node or id.",
    'asset A, B in "x.parts.svg"': "Several at once: the ids are the names.",
    'asset A, B in "x.parts.obj" stretch (1.5, 1, 1)': "Drawn so many times as large as in the "
    "file, along their own x, y and z and from their own origins: what takes parts of a model.",
    'table T = "x.parts.svg#T"': "Rows of named columns in a parts file.",
    "table T(x, y) = 1, 2": "The same written out, a line for each row. A row ends where no comma "
    "follows a cell; a row in brackets, `(a + 1, 2)`, may hold more than numbers and texts.",
    'surface wall = "statue.obj" atlas 1024': "A surface to march on.",
    'context mask = "mask.png" over (0, 0, 200, 100)': "A picture (png, jpg) that rules ask with "
    "`fetch`, and left, bottom, width and height of the part of the ground that it covers, which "
    "constants and attributes may say; without `over` it covers the unit square, (0, 0, 1, 1). Its "
    "lowest row of pixels lies at the bottom, each channel goes from 0 to 1. With `nearest` at the "
    "end each texel is one value to its edges: kinds of zones, and what decides something. At most "
    "67 million pixels.",
    'context height : scalar = "ground.npy" over (0, 0, 9, 9)': "A field of numbers as they are, "
    "from an array that `numpy.save` wrote, (rows, columns), or from a grey picture, 0 to 1. The "
    "first row lies at the top, as in a picture.",
    'context wind : vector = "wind.npy" over (0, 0, 9, 9)': "A field of vectors, (rows, columns, 2 "
    "or 3); of a picture, red, green and blue stand for x, y and z, from -1 for black to 1 for "
    "white.",
    'attr floors : int = 6 in 1..60 "storeys"': "What a user may set: type (int, float, bool, "
    "string), "
    "default, range or `{ … }` choices, meaning.",
    "const module = 2.4": "A value.",
    "fn bays(w) = max(1, floor(w / module))": "A pure function.",
    "turtle angle 25.7 step 1": "What the turtle takes where a rule says nothing.",
    "limit shapes 2000000 depth 1000": "Where a derivation stops with an error.",
    "tropism (0, 0, -1) 0.22": "What bends segments, and how strongly.",
    "ignore + - F": "Symbols that contexts look through.",
    'canvas (0, 0, 640, 480) width "10in"': "The sheet of a drawing: lower left corner and size. "
    "`decimals 2` behind it rounds the points of what is drawn, as the program did that wrote it.",
    "axes y-up": "The up axis that OBJ, STL and PLY are written with.",
    "residual T": "What no rule explains: row k of the table adjusts the k-th terminal that is "
    "drawn, in the order of the derivation; a segment of `F`, an asset, a polygon, a path are "
    "terminals. "
    "Columns: `x`, `y`, `z` move it along the axes of the file; `angle` turns it about its own z, "
    "`scale` multiplies it (a polygon or a path, about its first corner); `color`, `fill`, "
    "`stroke`, `css` "
    'stand in for those of its pen, `""` leaves them; `layer` is its paint order. A column may be '
    "left out. There must be a row for each terminal, or a column `of` that says which terminal "
    "a row adjusts, from 0: then `layer` is its number in the paint order, and terminals without a "
    "row take the numbers that no row gives. In a run with a seed or attributes of its own, a "
    "residual that does not fit is left out, which is said.",
    'site S1 = "castle.glb#S1" radius 0.26': "A docking site.",
    "Head(a, b) : guard : 30% --> body": "A rule. The guard, the percentage or `weight w`, and the "
    "parameters may be left out; `else` is taken when it is reached. `A < B(x) > C` looks at what "
    "stands before and behind; a string above is its documentation. What is compared with "
    "something that is not a number (0 / 0, the root of less than 0) is neither true nor false, "
    "nor is what hangs on it by `and`, `or`, `not` or `if`: a guard that is neither is an error, "
    "and so is an argument that is not a finite number.",
    "Lot --> split x { ~1: House | 2: Tree(5) }": "Rules of all kinds in one file. What rules "
    "without operations on scopes make, such as "
    "`Tree`, is a string of its own where it has to be: where a symbol moves the turtle for "
    "what stands behind it, where rules look at their neighbours, with `cut`, polygons, paths and "
    "`tropism`. Its turtle starts in the frame and with the pen of the scope (heading along x: "
    "turn it up with `^(90)`), and it is what it would be alone. Such things cannot stand in a "
    "rule that itself works on scopes: make a rule of its own of them.",
    "interpret Leaf --> F(1)": "A rule that is applied once, when the derivation is done.",
    "start Lot on box(8, 11, 0) steps 7": "The axiom, what it stands on, and for how many steps "
    "rules "
    "apply; without `steps` until none applies.",
    'start Row(24) choices "Leaf:24:4Kd"': "Which productions were drawn, so that a run without a "
    "seed draws them again; with `--seed` it draws anew. A part for each symbol that draws "
    "(`Leaf/2` with its number of parameters where symbols of one name draw, `interpret-Leaf` for "
    "`interpret` rules): its name, how many decisions, and their code. A decision is the number, "
    "from 0 and in the order of the file, of the production that was taken among those of the "
    "symbol that have a percentage or a weight; one more than the last says that none was. "
    "Decisions stand generation by generation, and from left to right in the string within one; a "
    "string of its own among scopes is derived whole where it begins. A "
    "text of another length than the derivation asks for is an error; with `--set` it holds as far "
    "as it goes and fits, and seed 0 draws the rest. Symbols that are not named draw from seed 0, "
    "and so do `rand` and its like. `ipmlang.runtime.choices.encode` writes such texts.",
}

ELEMENTS = {
    "Leaf(2) F +(30)": "Symbols and operations, one after the other, with blanks between them.",
    "Card(Heart, 5)": "A rule may take symbols as it takes numbers: in `Card(s, n) --> "
    "repeat(i < n) { [s] f(12) }`, s stands for what it was given. A parameter is a symbol where "
    "some rule of its symbol places it, alone in its body, or hands it on to a parameter that is "
    "one. What may be given is an asset, a rule without parameters, a terminal, such a parameter, "
    "`at.shape` or `r.shape` of a table's row, and a choice of these, `Card(if n > 2 then Heart "
    "else s, n)`, which is made where it stands. A name means what it means where it is written, "
    "in another file, too. A symbol is no value: nothing compares, computes or `set`s it, "
    "operations and symbols that take arguments need a rule to be given, and a rule that takes "
    "symbols is no neighbour in a context. Keys, and so random numbers, are those of the same "
    "rule written out for each symbol.",
    "[ - F ] F": "A group: what follows it starts where the group did.",
    "repeat(i < n) { [Picket(i)] f(13) }": "Copies, numbered from 0; `except (3, 7)` leaves some "
    "out, `steps (1, 2)` moves on between them, `with r in T` or `repeat(r in T)` reads a table.",
    "repeat(at T) { Tree }": "A copy at the place of each row of a table, by itself: as `repeat(r "
    "in T) { [translate(r.x, r.y, r.z) rotate(r.rx, r.ry, r.rz) *(r.scale) Tree] }`; a column that "
    "the table has not moves nothing. The row is called `at`: further columns are `at.color`. In a "
    "column `shape` of any table stand symbols, assets or rules without parameters, that "
    "`at.shape` in the body is; under another name of the row, as in `repeat(r in T)` and `with r "
    "in T`, it is `r.shape`.",
    "with w = rand(1, 2)": "From here to the end of the body, the group, the braces or the copy "
    "that it stands in, `w` is this value. It is computed once, where it stands: a random number "
    "is drawn once however often `w` is read, `scope.sx` is the extent here. In a function, a "
    "parameter of another function does the same.",
    "set width = 0.7 * width": "From here to the end of the body, the group, the braces or the "
    "copy that it stands in, the attribute `width` has this value: in expressions behind it, and "
    "for all descendants of what stands behind it, with their guards, chances, counts and `turtle` "
    "settings. What stands before it or beside the body keeps the old value; so do other "
    "attributes whose defaults read it. The range of an `attr` is for its users, not for rules.",
}

REPORT = {
    "terminals": "What is drawn: segments, assets, polygons, paths.",
    "shapes": "What was derived: the start, every module made whose symbol has rules (one that "
    "stays as it is counts anew in each generation), and every terminal. Operations, brackets and "
    "what stands in a hole of a `repeat` do not count, however a grammar is derived.",
    "generations": "How many parallel steps of rules it took, `interpret` rules apart.",
    "reports": "For each key that something was reported under, the `sum` and the `count`.",
}

OPENING = """\
# Language reference

Every operation, function and setting of ipm, version 1. This page is made from the tables in
`ipmlang/compiler/ops` by `python -m ipmlang.compiler.reference`; mend it there.

Angles are degrees, lengths are the file's units. `[x]` may be left out; `x, …` may be repeated.
Comparisons snap: two numbers are equal when they differ by no more than 1e-9 of the larger one.
Operations marked *planned* parse and check, and `run` says that they are not executable yet.
"""


def reference() -> str:
    """The whole page."""
    parts = [
        OPENING,
        "## Items\n",
        _table(("item", "what it does"), ((f"`{item}`", text) for item, text in ITEMS.items())),
        "## In a body\n",
        _table(("written", "what it is"), ((f"`{name}`", text) for name, text in ELEMENTS.items())),
        "## Settings\n",
        _table(
            ("item", "word", "without it", "what it does"),
            (_setting(each) for each in SETTINGS.values()),
        ),
    ]
    parts += [
        "## What `run --json` counts\n",
        _table(("number", "of what"), ((f"`{name}`", text) for name, text in REPORT.items())),
    ]
    for family, title in FAMILIES.items():
        records = [each for each in ALL_OPERATIONS if each.family == family]
        parts += [f"## {title}\n", *(entry(each) for each in records)]
        queries = [each for each in QUERIES.values() if each.family == family]
        if queries:
            rows = ((f"`{_query(each)}`", each.doc) for each in queries)
            parts.append(_table(("question", "answer"), rows))
    parts += [
        "## Functions\n",
        _table(
            ("function", "what it gives"),
            (
                *((f"`{_function(each)}`", _told(each)) for each in FUNCTIONS.values()),
                *((f"`{name}`", doc) for name, (_, doc) in CONSTANTS.items()),
            ),
        ),
    ]
    return "\n".join(parts)


def entry(record: Operation) -> str:
    """One operation: how it is written, what it does, an example."""
    forms = " or ".join(f"`{signature(record.name, form)}`" for form in record.forms)
    if record.synonyms:
        forms += ", also " + ", ".join(f"`{name}`" for name in record.synonyms)
    lines = [f"**{forms}**{'' if record.meaning else ' *planned*'}  ", record.doc]
    taken = ", ".join(
        f"`{name}` from `turtle {word}`" for name, word in record.defaults if isinstance(word, str)
    )
    if taken:
        lines.append(f"Left out: {taken}.")
    labels = [f"`{each}`" for each in record.labels or () if each.isalpha()]
    if labels:
        lines.append(f"Parts: {', '.join(labels)}.")
    if record.axes:
        lines.append(f"Knows {', '.join(f'`{each}`' for each in record.axes)}.")
    if record.examples:
        lines.append(f"Example: `{record.examples[0]}`")
    return "\n".join(lines) + "\n"


def describe(name: str) -> str | None:
    """What a name of the language is, for hover and help; None when it is none."""
    if name in OPERATIONS:
        return entry(OPERATIONS[name])
    if name in FUNCTIONS:
        return f"`{_function(FUNCTIONS[name])}`\n{FUNCTIONS[name].doc}\n"
    if name in QUERIES:
        return f"`{_query(QUERIES[name])}`\n{QUERIES[name].doc}\n"
    return f"`{name}`\n{CONSTANTS[name][1]}\n" if name in CONSTANTS else None


def _function(record: Function) -> str:
    """How a function is written: an operator between its sides."""
    names = [param.name for param in record.params]
    for sign, name in OPERATORS.items():
        if name == record.name:
            return f"{names[0]} {sign} {names[1]}"
    for sign, name in PREFIXES.items():
        if name == record.name:
            return f"{sign} {names[0]}" if sign.isalpha() else f"{sign}{names[0]}"
    return signature(record.name, record.params) if record.params else f"{record.name}()"


def _told(record: Function) -> str:
    notes = " Random." if record.random else ""
    return record.doc + notes + ("" if record.exact else " *Inexact: not for guards.*")


def _query(record: Query) -> str:
    return record.name if record.params is None else signature(record.name, record.params)


def _setting(record: SettingRecord) -> tuple[str, ...]:
    default = (
        ""
        if record.default is None
        else (f"{record.default:,.12g}" if isinstance(record.default, float) else record.default)
    )
    return f"`{record.item}`", f"`{record.name}`", default, record.doc


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [" | ".join(head), " | ".join("---" for _ in head)]
    lines += [" | ".join(cell.replace("|", "\\|") for cell in row) for row in rows]
    return "\n".join(f"| {line} |" for line in lines) + "\n"


def main() -> None:
    """Write the page beside the standard library."""
    from ipmlang.compiler.load import standard_library

    path = standard_library() / "REFERENCE.md"
    path.write_text(reference(), encoding="utf-8")


if __name__ == "__main__":
    main()
