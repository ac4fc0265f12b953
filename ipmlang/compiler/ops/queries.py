"""Queries: names and functions that ask where a shape stands, and about other shapes.

Records only; executors answer them: none is answered yet but those that are marked as ready.
"""

from __future__ import annotations

from ipmlang.compiler.ops.record import Family, Param, Query, ValueType

HERE = "here"  # `here.mask` is the context `mask` where the walker stands, not where it goes


def _names(family: Family, kind: ValueType, docs: dict[str, str]) -> tuple[Query, ...]:
    return tuple(
        Query(
            name,
            doc,
            kind,
            family,
            ready=family != "marching",
            examples=(name,),
            refused=(f"{name}()",),
        )
        for name, doc in docs.items()
    )


NAMES = (
    *_names("split", "int", {
        "split.index": "The number, from 0, of this piece among those of its split.",
        "split.count": "How many pieces the split made.",
    }),
    *_names("scope", "number", {
        "scope.sx": "The scope's extent along its own x.",
        "scope.sy": "The scope's extent along its own y.",
        "scope.sz": "The scope's extent along its own z.",
        "scope.x": "The x of the scope's origin in the world.",
        "scope.y": "The y of the scope's origin in the world.",
        "scope.z": "The z of the scope's origin in the world.",
        "geometry.area": "The area of the geometry's faces.",
        "geometry.volume": "The volume of a closed solid, else 0.",
        "geometry.sides": "How many edges a polygon has; of a solid, all its faces together.",
    }),
    *_names("scope", "string", {"shape.label": "The label that the shape was given last."}),
    *_names("marching", "number", {
        "here.u": "Where on the surface the walker stands: first texture coordinate.",
        "here.v": "Where on the surface the walker stands: second texture coordinate.",
        "here.steps": "How many steps the walker made.",
        "surface.slope": "The surface's slope against the ground, in degrees, at the destination.",
        "surface.height": "The destination's height above the ground.",
    }),
)  # fmt: skip

FAR = 1e9  # what `distance` gives where there is no such shape

_WITHIN = Param("within", "string", optional=True)


def _asked(
    name: str,
    result: ValueType,
    doc: str,
    params: tuple[Param, ...],
    examples: tuple[str, ...],
    refused: tuple[str, ...],
) -> Query:
    return Query(name, doc, result, "scope", params, ready=True, examples=examples, refused=refused)


_PASSES = (
    " A program that asks is derived twice: the first time the answer is {first}, the second time "
    "it is about what the first made, so that it does not depend on the order of rules. A shape "
    "is never tested against itself, what it descends from, or what descends from it; parts, "
    "copies of a `repeat` and brackets that ask are shapes of their own. Where no production "
    "applies in the first pass, the shape ends there."
)
_OTHERS = (
    " Without a label all shapes are meant that are drawn or were given a label with `label`; with "
    "one, those that were given it, and those whose symbol is called so. A shape without geometry "
    "is its scope, perhaps a point; a mesh of over 2000 triangles is its convex hull."
)
_PHASES = " It is about shapes of phases before the one that asks (see `phase`)"

FUNCTIONS = (
    _asked("inside", "bool",
           "Whether all of the shape lies within another one that is closed, or in its plane "
           "within a polygon; the boundary belongs to it." + _OTHERS + _PASSES.format(first="no"),
           (Param("label", "string", optional=True),),
           ('inside("tower")', "inside()"), ("inside(1)", 'inside("a", "b")')),
    _asked("overlaps", "bool",
           "Whether the shape and another one have more than boundary in common: volume, area of "
           "one plane, or a polygon that passes through." + _OTHERS + _PASSES.format(first="no"),
           (Param("label", "string", optional=True),), ('overlaps("tree")',), ("overlaps(1, 2)",)),
    _asked("touches", "bool",
           "Whether the shape and another one have boundary in common and nothing more, to 1e-9 "
           "of their size." + _OTHERS + _PASSES.format(first="no"),
           (Param("label", "string", optional=True),), ('touches("wall")',), ("touches(1, 2)",)),
    _asked("distance", "number",
           "The distance to the nearest shape of a label, 0 where they overlap, and 1e9 where "
           "there is none." + _PASSES.format(first="1e9"),
           (Param("label", "string"),), ('distance("street")',), ("distance()", "distance(1)")),
    _asked("count", "int",
           "How many shapes of a label there are; with a second label only those that descend "
           "from the same shape of that label as this one." + _PHASES + ".",
           (Param("label", "string"), _WITHIN), ('count("door")', 'count("door", "facade")'),
           ("count(1)", "count()")),
    _asked("total", "number",
           "The sum that was reported under a key; with a label only by what descends from the "
           "same shape of that label as this one." + _PHASES + ".",
           (Param("key", "string"), _WITHIN), ('total("storeys")', 'total("area", "tower")'),
           ("total(1)",)),
    _asked("rank", "int",
           "The number, from 0, of this shape among all of a label: of the nearest one that it is "
           "or descends from, in an order drawn from the seed; -1 where it has none. So "
           '`rank("bay") == 0` holds for exactly one. With a second label only those count that '
           "descend from the same shape of that label." + _PHASES + ".",
           (Param("label", "string"), _WITHIN), ('rank("bay") == 0', 'rank("bay", "facade")'),
           ("rank()", "rank(1)")),
    _asked("share", "int",
           "This shape's part of a whole number that is dealt out to all that reported under a "
           "key, in proportion to what each reported: whole numbers that add up to it exactly. 0 "
           "for a shape that neither reported nor descends from one that did. With a label it is "
           "dealt out among what descends from the same shape of that label." + _PHASES + ".",
           (Param("key", "string"), Param("whole"), _WITHIN),
           ('share("wish", 30)', 'share("wish", 30, "block")'), ('share("wish")', "share(1, 2)")),
    Query(
        "fetch",
        "What a `context` is at x and y of the ground, of a picture from 0 for black to 1 for "
        "white, of a field its number. Without x and y it is asked where the shape's scope has its "
        "origin. The channel is 0, 1, 2, 3 for red, green, blue and opacity, or a vector's x, y "
        "and z; left out, it is 0: of a grey picture its grey. Between the middles of four texels "
        "it is interpolated, with `nearest` it is that of the texel that x and y lie in; beyond "
        "its edges a context goes on as it is there.",
        "number",
        "scope",
        (
            Param("context", "context"),
            Param("x", optional=True),
            Param("y", optional=True),
            Param("channel", "int", optional=True),
        ),
        ready=True,
        examples=("fetch(mask, 3, 4)", "fetch(mask)", "fetch(mask, scope.x, scope.y, 0)"),
        refused=("fetch()", "fetch(1, 2, 3)", "fetch(mask, 1)", "fetch(mask, 1, 2, 1)"),
    ),
)  # fmt: skip

OCCLUSION = frozenset({"inside", "overlaps", "touches", "distance"})  # what takes two passes

TABLE = NAMES + FUNCTIONS
