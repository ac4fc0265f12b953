"""The pen's operations: width, colours, styles, effects and the order of painting.

Records only. What the pen sets holds for everything that follows in the same bracket; an asset
keeps its own style wherever the pen sets none.
"""

from __future__ import annotations

from ipmlang.compiler.ops.record import Operation, Param, Step, ValueType


def _pen(
    name: str, kind: ValueType, doc: str, examples: tuple[str, ...], refused: tuple[str, ...]
) -> Operation:
    return Operation(
        name,
        "pen",
        "pen",
        doc,
        forms=((Param("value", kind),),),
        meaning=((Step("pen", ("value",), name),),),
        examples=examples,
        refused=refused,
    )


TABLE = (
    Operation(
        "!",
        "pen",
        "pen",
        "Set the width of what is drawn, in file units, whatever the frame's scale.",
        forms=((Param("width", optional=True),),),
        synonyms=("width",),
        defaults=(("width", "width"),),
        meaning=((Step("pen", ("width",), "width"),),),
        examples=("!(0.5) F", "! F", "width(2) F"),
        refused=('!("thick")', "!(1, 2)"),
    ),
    _pen(
        "color",
        "color",
        "Set the colour of what is drawn, outline and inside: `#rgb`, `#rrggbb` or a CSS name. As "
        "all of the pen, it carries on behind a rule of turtles; in a program with scopes it ends "
        "with the rule's body.",
        ('color("#2a6f4e") F', 'color("teal") F'),
        ("color", "color(3)", 'color("#12")', 'color("gren")'),
    ),
    _pen(
        "fill",
        "color",
        'Set the colour of the inside alone; `"none"` leaves it empty.',
        ('fill("#fa0") polygon { F + F + F }', 'fill("none") F'),
        ("fill", "fill(3)", 'fill("#12345")'),
    ),
    _pen(
        "stroke",
        "color",
        'Set the colour of the outline alone; `"none"` draws no outline.',
        ('stroke("#333") F', 'stroke("none") F'),
        ("stroke", "stroke(0.5)"),
    ),
    _pen(
        "css",
        "string",
        "Set SVG style declarations that override the asset's own.",
        ('css("stroke-dasharray:2 1") F',),
        ("css", "css(3)"),
    ),
    Operation(
        "effect",
        "pen",
        "pen",
        "Wrap what follows in the same bracket in a group of a parts file, with its clip, mask, "
        'filter or opacity: `[effect("fence.parts.svg#g1") A B]`. The group lies in the frame in '
        "which the operation stands; each time it is met, it begins a group of its own.",
        forms=((Param("value", "string", suffixes=(".svg",)),),),
        meaning=((Step("pen", ("value",), "effect"),),),
        refused=("effect", "effect(1)", 'effect("nowhere.parts.svg#g1")'),
    ),
    _pen(
        "material",
        "string",
        "Set the material, by name, of what is drawn in 3-D.",
        ('material("brick") F',),
        ("material", "material(4)"),
    ),
    Operation(
        "layer",
        "pen",
        "pen",
        "Raise the paint order of all that follows by `steps`; ties keep derivation order. A group "
        "that `effect` makes is painted whole, where it began; layers inside order what is in it.",
        forms=((Param("steps"),),),
        meaning=((Step("layer", ("steps",)),),),
        examples=("layer(1) F", "layer(-2) F"),
        refused=("layer", 'layer("top")'),
    ),
)
