"""Types of values: which fits where, what a person calls them, and what a colour may be.

A type is a word of `ops.record.ValueType`. Nothing here looks at trees or reports trouble.
"""

from __future__ import annotations

import re

from ipmlang.compiler.ops.record import ValueType

PHRASES: dict[ValueType, str] = {
    "number": "a number",
    "int": "a whole number",
    "bool": "true or false",
    "string": "a text",
    "color": "a colour",
    "vector": "a vector such as (1, 0, 0)",
    "asset": "an asset",
    "symbol": "a symbol",
    "context": "a context",
    "any": "a value",
}
ATTR_TYPES: dict[str, ValueType] = {
    "int": "int",
    "float": "number",
    "bool": "bool",
    "string": "string",
}
NUMERIC: frozenset[ValueType] = frozenset({"any", "int", "number"})
_HEX = re.compile(r"#(?:[0-9a-fA-F]{3,4}|[0-9a-fA-F]{6}|[0-9a-fA-F]{8})")

# The named colours of CSS Color Module Level 4, section 6.1, and the two words that are no colour.
COLOR_WORDS = frozenset(
    [
        "none",
        "transparent",
        "aliceblue",
        "antiquewhite",
        "aqua",
        "aquamarine",
        "azure",
        "beige",
        "bisque",
        "black",
        "blanchedalmond",
        "blue",
        "blueviolet",
        "brown",
        "burlywood",
        "cadetblue",
        "chartreuse",
        "chocolate",
        "coral",
        "cornflowerblue",
        "cornsilk",
        "crimson",
        "cyan",
        "darkblue",
        "darkcyan",
        "darkgoldenrod",
        "darkgray",
        "darkgreen",
        "darkgrey",
        "darkkhaki",
        "darkmagenta",
        "darkolivegreen",
        "darkorange",
        "darkorchid",
        "darkred",
        "darksalmon",
        "darkseagreen",
        "darkslateblue",
        "darkslategray",
        "darkslategrey",
        "darkturquoise",
        "darkviolet",
        "deeppink",
        "deepskyblue",
        "dimgray",
        "dimgrey",
        "dodgerblue",
        "firebrick",
        "floralwhite",
        "forestgreen",
        "fuchsia",
        "gainsboro",
        "ghostwhite",
        "gold",
        "goldenrod",
        "gray",
        "green",
        "greenyellow",
        "grey",
        "honeydew",
        "hotpink",
        "indianred",
        "indigo",
        "ivory",
        "khaki",
        "lavender",
        "lavenderblush",
        "lawngreen",
        "lemonchiffon",
        "lightblue",
        "lightcoral",
        "lightcyan",
        "lightgoldenrodyellow",
        "lightgray",
        "lightgreen",
        "lightgrey",
        "lightpink",
        "lightsalmon",
        "lightseagreen",
        "lightskyblue",
        "lightslategray",
        "lightslategrey",
        "lightsteelblue",
        "lightyellow",
        "lime",
        "limegreen",
        "linen",
        "magenta",
        "maroon",
        "mediumaquamarine",
        "mediumblue",
        "mediumorchid",
        "mediumpurple",
        "mediumseagreen",
        "mediumslateblue",
        "mediumspringgreen",
        "mediumturquoise",
        "mediumvioletred",
        "midnightblue",
        "mintcream",
        "mistyrose",
        "moccasin",
        "navajowhite",
        "navy",
        "oldlace",
        "olive",
        "olivedrab",
        "orange",
        "orangered",
        "orchid",
        "palegoldenrod",
        "palegreen",
        "paleturquoise",
        "palevioletred",
        "papayawhip",
        "peachpuff",
        "peru",
        "pink",
        "plum",
        "powderblue",
        "purple",
        "rebeccapurple",
        "red",
        "rosybrown",
        "royalblue",
        "saddlebrown",
        "salmon",
        "sandybrown",
        "seagreen",
        "seashell",
        "sienna",
        "silver",
        "skyblue",
        "slateblue",
        "slategray",
        "slategrey",
        "snow",
        "springgreen",
        "steelblue",
        "tan",
        "teal",
        "thistle",
        "tomato",
        "turquoise",
        "violet",
        "wheat",
        "white",
        "whitesmoke",
        "yellow",
        "yellowgreen",
    ]
)


def fits(actual: ValueType, expected: ValueType) -> bool:
    """Whether a value of type `actual` may stand where `expected` is wanted."""
    if actual == expected or "any" in (actual, expected):
        return True
    return (actual, expected) in _WIDER


# A text may turn out to be a colour or an asset's name only when it is known: literals are looked
# at by `is_color`. A number in a whole number's place is rounded by nobody, but may be whole.
_WIDER = frozenset(
    [
        ("int", "number"),
        ("number", "int"),
        ("string", "color"),
        ("color", "string"),
        ("asset", "symbol"),
    ]
)


def common(first: ValueType, second: ValueType) -> ValueType | None:
    """The type of a value that is either of two; None when no value can be both."""
    if first == second:
        return first
    if "any" in (first, second):
        return "any"
    if {first, second} == {"int", "number"}:
        return "number"
    if {first, second} == {"asset", "symbol"}:
        return "symbol"
    return "string" if {first, second} == {"string", "color"} else None


def is_color(text: str) -> bool:
    """Whether a text is a colour: `#rgb`, `#rrggbb`, either with alpha, or a CSS name or `none`."""
    return _HEX.fullmatch(text) is not None or text.lower() in COLOR_WORDS
