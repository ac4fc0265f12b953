"""Operations that make and take apart polygons and solids: extrude, comp, split, roofs, booleans.

Records only. What makes another geometry of a shape's own is one instruction `solid`, what takes
it apart one instruction `pieces`. `split` with its sizes has a syntax of its own; its record says
which axes it knows. A record without a meaning is one that no executor runs yet.
"""

from __future__ import annotations

from ipmlang.compiler.ops.record import Operation, Param
from ipmlang.compiler.ops.scope import number, scoped, words

_SIDES = (
    "front", "back", "left", "right", "side", "top", "bottom", "vertical", "horizontal", "aslant",
    "inside", "all", "eave", "ridge", "hip", "valley", "slope", "gable", "lower", "upper",
    "border", "*", '""',
)  # fmt: skip
_ARMS = ("shape", "rest", "remainder")


def _solid(
    name: str,
    doc: str,
    forms: tuple[tuple[Param, ...], ...],
    examples: tuple[str, ...],
    refused: tuple[str, ...],
    *,
    labels: tuple[str, ...] | None = None,
    bare: bool = False,
    spreads: bool = False,
    synonyms: tuple[str, ...] = (),
) -> Operation:
    act = "pieces" if spreads or (labels is not None and not bare) else "solid"
    return scoped(name, doc, forms, examples, refused, act=act, family="solid", labels=labels,
                  bare=bare, spreads=spreads, synonyms=synonyms)  # fmt: skip


_DISTANCE = (Param("distance"),)
_SLOPE = (Param("angle"), number("overhang"), number("ridge"))
_HEIGHT_ALONG = (
    Param("height"),
    words("along", "normal", "x", "y", "z", "up", named=True, optional=True),
)

MAKING = (
    _solid("extrude", "Raise a polygon into a solid: along its normal, an axis or the world's up.",
           (_HEIGHT_ALONG,), ("extrude(9) Mass", "extrude(9, along: up) Mass"),
           ("extrude", 'extrude("high")', "extrude(9, along: q)")),
    _solid("taper", "Raise a polygon into a solid that draws in toward the top.",
           ((Param("height"), Param("inset")), (Param("height"),)), ("taper(4, 0.5) Tower",),
           ("taper",)),
    _solid("roofGable", "Put a gable roof on a polygon: slope in degrees, overhang, ridge "
                        "direction.",
           (_SLOPE,), ("roofGable(35) comp { slope: Tiles | gable: Wall }",), ("roofGable",)),
    _solid("roofHip", "Put a hip roof on a polygon.", (_SLOPE,),
           ("roofHip(30, overhang: 0.4) Roof",), ("roofHip", 'roofHip("steep")')),
    _solid("roofShed", "Put a roof of one slope on a polygon.", (_SLOPE,), ("roofShed(12) Roof",),
           ("roofShed",)),
    _solid("roofPyramid", "Put a pyramid of a height on a polygon.", ((Param("height"),),),
           ("roofPyramid(4) Roof",), ("roofPyramid",)),
    _solid("roofMansard", "Put a roof of two slopes on a polygon; the lower ends at a height.",
           ((Param("lower"), Param("height"), Param("upper"), number("overhang")),),
           ("roofMansard(70, 3, 25) Roof",), ("roofMansard(70)",)),
    _solid("envelope", "Make the largest solid that building lines and slopes allow.",
           ((Param("height"), number("front"), number("side"), number("back"), number("angle")),),
           ("envelope(18, front: 3, angle: 60) Mass",), ("envelope",)),
    _solid("cube", "Fill the scope with a box.", ((),), ("cube Crate",), ("cube(1)",)),
    _solid("cylinder", "Fill the scope with a cylinder.", ((), (Param("sides", "int", above=2),)),
           ("cylinder(24) Column",), ("cylinder(2)",)),
    _solid("cone", "Fill the scope with a cone.", ((), (Param("sides", "int", above=2),)),
           ("cone(12) Spire",), ('cone("a")',)),
    _solid("sphere", "Fill the scope with a sphere.", ((), (Param("sides", "int", above=2),)),
           ("sphere(16) Dome",), ('sphere("a")',)),
    _solid("quad", "Fill the scope's xy plane with a rectangle.", ((),), ("quad Pane",),
           ("quad(1)",)),
    _solid("disk", "Fill the scope's xy plane with a disk.",
           ((), (Param("sides", "int", above=2),)), ("disk(32) Clock",), ("disk(1)",)),
    _solid("insert", "Put an asset into the scope.",
           ((Param("asset", "asset"),
             words("fit", "scope", "inside", "none", named=True, optional=True),
             Param("keepAspect", "bool", optional=True, named=True),
             words("align", "corner", "bottom", "middle", "top", named=True, optional=True)),),
           ("insert(win)", "insert(win, fit: inside, align: middle)"),
           ("insert", "insert(3)", "insert(win, fit: q)"), synonyms=("i",)),
)  # fmt: skip

TAKING_APART = (
    _solid("comp", "Take a solid apart: each part's label selects faces (edges, vertices), as "
           "`side`, `top`, an index, a text tag, and `and`, `or`, `not` of them. Faces, edges or "
           "vertices may be a text that is computed; labels are words and texts as they are "
           "written: rules choose between them.",
           ((), (words("of", "faces", "edges", "vertices"),)),
           ("comp { side: Facade | top: Roof }", "comp(edges) { all: Gutter }",
            'comp { front and not "street": Wall | 3: Door }'),
           ("comp { sde: Facade }", "comp(3) { top: Roof }", "comp { Facade }", "comp"),
           labels=_SIDES),
    scoped("split", "Cut the shape along an axis into pieces of absolute `4.4`, relative `'0.5` "
            "and floating `~3` sizes; `{ … }*` repeats whole pieces, `{ … }+` a cut one too. "
            "`area` cuts along x into pieces of given areas. `u` and `v` cut along the texture "
            "coordinates that the shape has here, from where they are least: sizes are in images, "
            "so that 1 is one image of `projectUV` or `tileUV`, and without these a whole side, or "
            "what a mesh brings. They must run evenly over the shape, as they do over a side that "
            "`comp` gave, but over all sides of a solid together only in a projection. Where they "
            "run aslant to the scope, pieces take the boxes of what they are. With `snap:` the "
            "lengths are shared out as always, and then each cut moves to the nearest of the lines "
            "that `snap` made under that name in phases before, across the same direction, "
            "wherever they were made; with `within` a label, of those alone that descend from the "
            "same shape of that label as this one. Floating and relative pieces on either side of "
            "a cut give way; absolute ones keep their size, so that they and the cuts around them "
            "move together, or not at all where nothing on one of their sides gives way: of the "
            "moves that bring one of these cuts to a line next to it, by the one that brings the "
            "most of them to lines, then the shortest. Of moves that are equally long the one "
            "toward the start counts. A cut moves by less than half of the piece that it moves "
            "into, and by no more than `reach`: so pieces keep their order and none vanishes. "
            "Copies of repeats snap like other pieces, and the ends of the shape never move. An "
            "empty name snaps to nothing.",
            ((), (Param("snap", "string", named=True), number("within", "string"),
                  number("reach"))),
            ("split y { 4.4: Ground | { ~3.2: Floor }* | 0.6: Cornice }",
             "split x { ~1: Wall | '0.25: Pier | ~1: Wall }",
             'split x(snap: "bay", within: "facade", reach: 0.5) { { ~3: Bay }* }',
             "setupProjection(xy, 2, 1) projectUV split u { { ~1: Panel }* }"),
            ("split q { 1: A }", 'split x { "big": A }', "split x { -2: A }", "split",
             "split x(snap: 3) { ~1: A }", "split x(reach: 1) { ~1: A }",
             'split area(snap: "bay") { 3: A }'),
            act="pieces", family="split", axes=("x", "y", "z", "u", "v", "area")),
    _solid("setback", "Cut a strip off along the edges; `shape` takes the rest, `border` the "
                      "strips. The rest keeps the axes of the shape; a strip's x runs along its "
                      "edge, its y inward from it.",
           ((Param("distance"), number("front"), number("side"), number("back"), number("area")),),
           ("setback(2) { shape: Mass | border: Lawn }", "setback(2, front: 4) { shape: Mass }"),
           ("setback { shape: Mass }", "setback(2) { middle: Mass }"), labels=(*_SIDES, *_ARMS)),
    _solid("offset", "Move all edges of a polygon outward, or inward where negative.",
           (_DISTANCE,), ("offset(-0.5) { inside: Bed | border: Path }", "offset(1) Plate"),
           ("offset",), labels=(*_SIDES, *_ARMS), bare=True),
    _solid("innerRect", "Cut the largest rectangle out of a polygon.", ((),),
           ("innerRect { shape: Court | rest: Paving }", "innerRect Court"), ("innerRect(1)",),
           labels=_ARMS, bare=True),
    _solid("shapeL", "Cut an L from the scope's plane: widths of the front and left arms.",
           ((Param("front"), Param("left")),), ("shapeL(8, 6) { shape: Mass | rest: Yard }",),
           ("shapeL(8) { shape: Mass }",), labels=_ARMS),
    _solid("shapeU", "Cut a U from the scope's plane: widths of its three arms.",
           ((Param("front"), Param("left"), Param("right")),),
           ("shapeU(8, 6, 6) { shape: Mass | rest: Yard }",), ("shapeU(8) { shape: Mass }",),
           labels=_ARMS),
    _solid("shapeO", "Cut a ring from the scope's plane: widths of its four arms.",
           ((Param("front"), Param("left"), Param("right"), Param("back")),),
           ("shapeO(8, 6, 6, 8) { shape: Mass | rest: Court }",), ("shapeO(8) { shape: Mass }",),
           labels=_ARMS),
    _solid("trim", "Cut the shape by the planes that halve the angles between the face it came of "
                   "and those beside it, at all its edges or those that stand or lie.",
           ((), (words("edges", "vertical", "horizontal"),)),
           ("extrude(0.3) trim Wall", "extrude(-0.3) trim(vertical) Wall"), ("trim(1)",)),
    scoped("union", "Make one solid of those that the parts draw, each from the shape as it is.",
           ((),), ("union { Mass | Wing }",), ("union(3) { Mass }",), labels=("",),
           family="solid", act="join"),
    scoped("subtract", "Take the solids that the later parts draw from those of the first.", ((),),
           ("subtract { Mass | Passage }",), ("subtract(3) { Mass }",), labels=("",),
           family="solid", act="join"),
    scoped("intersect", "Keep what the solids of all parts share.", ((),),
           ("intersect { Mass | Dome }",), ("intersect(3) { Mass }",), labels=("",),
           family="solid", act="join"),
    _solid("reverseNormals", "Turn all faces inside out.", ((),), ("reverseNormals Room",),
           ("reverseNormals(1)",)),
    _solid("convert", "Turn the geometry into its box, its outline or its faces' plane.",
           ((words("to", "box", "outline", "plane"),),), ("convert(box) Mass",), ("convert(9)",)),
    _solid("scatter", "Place points at random on the surface, in the volume or in the scope. A "
                      "point has the axes of the shape, no extent and no geometry: a symbol that "
                      "nothing defines draws nothing there, so insert an asset, or give it both: "
                      "size(1, 1, 1) cube Crate.",
           ((Param("count", "int"), words("over", "surface", "volume", "scope", named=True,
                                          optional=True)),),
           ("scatter(20, over: surface) Tree",), ("scatter",), spreads=True),
    _solid("octant", "Take the eighth of the shape beyond the point (x, y, z): 1 to 8, counted "
                     "x, y, z.",
           ((Param("x"), Param("y"), Param("z"), Param("octant", "int")),),
           ("octant(4, 0, 3, 7) Tower",), ("octant(4, 0, 3)",), spreads=True),
    _solid("subdivide", "Fill the box with nx by ny by nz equal cells.",
           (tuple(Param(name, "int", above=0) for name in ("nx", "ny", "nz")),),
           ("subdivide(3, 2, 1) Window",), ("subdivide(3)", "subdivide(0, 1, 1)"), spreads=True),
)  # fmt: skip

TABLE = MAKING + TAKING_APART
