"""Queries: names and functions that ask where a shape stands. Records only; executors answer them.

None is answered yet except what a record marks as ready.
"""

from __future__ import annotations

from ipmlang.compiler.ops.record import Family, Param, Query, ValueType

HERE = "here"  # `here.mask` is the context `mask` where the walker stands, not where it goes
_LABEL = (Param("label", "any", optional=True),)


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

FUNCTIONS = (
    Query("inside", "Whether the shape lies inside another one (of a label).", "bool", "scope",
          _LABEL, examples=('inside("tower")', "inside()"), refused=("inside(1, 2)",)),
    Query("overlaps", "Whether the shape overlaps another one (of a label).", "bool", "scope",
          _LABEL, examples=('overlaps("tree")',), refused=("overlaps(1, 2)",)),
    Query("touches", "Whether the shape touches another one (of a label).", "bool", "scope",
          _LABEL, examples=('touches("wall")',), refused=("touches(1, 2)",)),
    Query("distance", "The distance to the nearest shape of a label.", "number", "scope",
          (Param("label", "string"),), examples=('distance("street")',),
          refused=("distance()", "distance(1)")),
    Query("count", "How many shapes of a label earlier phases made.", "int", "scope",
          (Param("label", "string"),), examples=('count("door")',), refused=("count(1)",)),
    Query("total", "The sum that earlier phases reported under a key.", "number", "scope",
          (Param("key", "string"),), examples=('total("storeys")',), refused=("total(1)",)),
)  # fmt: skip

TABLE = NAMES + FUNCTIONS
