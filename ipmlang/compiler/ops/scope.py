"""Operations on a shape's scope: its frame, size, labels and appearance, as architects know them.

Records only. What they do ends with the body of the rule they stand in. A record without a meaning
is one that no executor runs yet: `run` names it.
"""

from __future__ import annotations

from dataclasses import replace

from ipmlang.compiler.ops.record import (
    NOT_GIVEN,
    Effect,
    Family,
    Operation,
    Param,
    Step,
    ValueType,
)

_XYZ = (Param("x"), Param("y"), Param("z"))
_AXIS = Param("axis", "string", words=("x", "y", "z"))
_AXES = ("x", "y", "z", "xy", "xz", "yz", "xyz")


def scoped(
    name: str,
    doc: str,
    forms: tuple[tuple[Param, ...], ...] = ((),),
    examples: tuple[str, ...] = (),
    refused: tuple[str, ...] = (),
    *,
    act: str | None = None,
    meaning: tuple[Step, ...] = (),
    family: Family = "scope",
    effect: Effect = "scope",
    synonyms: tuple[str, ...] = (),
    labels: tuple[str, ...] | None = None,
    bare: bool = False,
    spreads: bool = False,
    axes: tuple[str, ...] = (),
) -> Operation:
    """A record whose meaning is `meaning`, or one instruction `act` with all that it is given."""
    made = tuple(
        (Step(act, tuple(param.name for param in form), name),) if act else meaning
        for form in forms
    )
    return Operation(
        name,
        family,
        effect,
        doc,
        forms=forms,
        synonyms=synonyms,
        defaults=tuple((name, NOT_GIVEN) for name in _optional(forms)),
        meaning=made if act or meaning else (),
        labels=labels,
        bare=bare,
        spreads=spreads,
        axes=axes,
        leaves_plane=family != "pen",
        examples=examples,
        refused=refused,
    )


def _optional(forms: tuple[tuple[Param, ...], ...]) -> dict[str, None]:
    """The parameters that may be left out: the operation knows best what it does then."""
    return dict.fromkeys(param.name for form in forms for param in form if param.optional)


def words(name: str, *choices: str, named: bool = False, optional: bool = False) -> Param:
    """A parameter that is one of a few bare words."""
    return Param(name, "string", named=named, optional=optional, words=choices)


def number(name: str, kind: ValueType = "number") -> Param:
    """A parameter that may be left out and is given by name."""
    return Param(name, kind, optional=True, named=True)


PLACE = (
    scoped("translate", "Move the scope along its own axes.", (_XYZ,),
            ("translate(1, 0, 0) Window",), ("translate(1, 0)", 'translate("x", 0, 0)'),
            synonyms=("t",), meaning=(Step("move", ("x", "y", "z")),)),
    replace(
        scoped("rotate", "Turn the scope about its own x, then y, then z axis, in degrees: about "
               "its origin, or the middle of its bottom, of its box or of its top.",
               (_XYZ, (*_XYZ, words("about", "bottom", "middle", "top", named=True))),
               ("rotate(0, 0, 90) Window", "rotate(0, 0, 45, about: middle) Vane"),
               ("rotate(90)", "rotate(0, 0, 45, about: q)"), synonyms=("r",)),
        meaning=(tuple(Step("rotate", (axis,), axis) for axis in "xyz"),
                 (Step("solid", ("x", "y", "z", "about"), "rotate"),))),
    scoped("rotateScope", "Turn the scope about its own axes and leave the geometry where it is.",
            (_XYZ,), ("rotateScope(0, 90, 0) Wall",), ("rotateScope(1)",), act="solid"),
    scoped("size", "Set the scope's extent along x, y and z; its geometry is scaled with it.",
            (_XYZ,), ("size(scope.sx, 2, 0.1) Sill",), ("size(1)",), synonyms=("s",),
            meaning=(Step("resize", ("x", "y", "z")),)),
    scoped("center", "Move the scope to the middle of its parent along the axes named.",
            ((words("axes", *_AXES),),), ("center(xy) Lamp",), ("center(q)", "center(1)"),
            act="center"),
    scoped("mirrorScope", "Mirror the scope and its geometry along one of its axes.", ((_AXIS,),),
            ("mirrorScope(x) Wing",), ("mirrorScope(q)",), act="solid"),
    scoped("alignScopeToAxes", "Turn the scope so that its y axis is the world's, or all axes.",
            ((), (words("axis", "x", "y", "z"),)), ("alignScopeToAxes(y) Mass",),
            ("alignScopeToAxes(3)",), act="solid"),
    scoped("alignScopeToGeometry", "Fit the scope to its geometry: z out of the largest face, x "
                                    "along "
            "its lowest or longest edge.",
            ((), (words("edge", "lowest", "longest", "first"),)),
            ("alignScopeToGeometry Roof",), ("alignScopeToGeometry(3)",), act="solid"),
)  # fmt: skip

FLOW = (
    Operation("nil", "scope", "structure", "Make nothing: the shape ends here.", meaning=((),),
              examples=("nil",), refused=("nil(1)",)),
    scoped("tag", "Give the shape's faces a tag that `comp` can select by.",
            ((Param("name", "string"),),), ('tag("street") Wall',), ("tag", "tag(1)"),
            effect="structure", act="solid"),
    scoped("label", "Give the shape a label that queries can ask for, with the geometry that it "
            "has here. A shape's symbol is a label of it, too.",
            ((Param("name", "string"),),), ('label("door") Door',), ("label(3)",),
            effect="structure", meaning=(Step("pen", ("name",), "label"),)),
    scoped("report", "Add a number to the report's sum under a key.",
            ((Param("key", "string"), Param("value")),), ('report("area", 12) Wall',),
            ('report("area")', 'report("area", "big")'), effect="structure", act="report"),
    scoped("snap", "Make a snap line, which draws nothing: the endless plane across an axis of the "
            "scope, where the scope begins along it, or `at` its middle, its end or both. Splits "
            "of later phases along that direction can snap to it by its name (see `split` and "
            "`phase`).",
            ((Param("name", "string"), _AXIS,
              words("at", "start", "middle", "end", "both", named=True, optional=True)),),
            ('snap("sill", y) Window', 'snap("bay", x, at: both) Bay'),
            ('snap("sill")', 'snap("sill", q)', "snap(1, y)"),
            effect="structure", act="snap"),
    scoped("phase", "Expand the shapes that follow, and all that they make, only when all of "
            "earlier phases are done: their guards and bodies can ask for `count`, `total`, "
            "`rank` and `share` of what those made. Phases have numbers; a derivation starts in "
            "phase 1, and a shape never goes back to an earlier one. What stands behind `phase` in "
            "the same body is worked on at once: let the shape that follows ask.",
            ((Param("number", "int", above=0),),), ("phase(2) Door",),
            ("phase", "phase(0)", "phase(1.5)"), effect="structure", act="phase"),
)  # fmt: skip

LOOK = (
    scoped("texture", "Lay an image on what is drawn in 3-D: a file beside the grammar. Each side "
                       "of a scope is one image; geometry that brings texture coordinates keeps "
                       "them, and `projectUV`, `tileUV` and their like say otherwise. An empty "
                       "name lays none.",
            ((Param("file", "string", suffixes=(".png", ".jpg", ".jpeg")),),), (),
            ("texture(1)", 'texture("nowhere.png") Wall'),
            family="pen", effect="pen", meaning=(Step("pen", ("file",), "texture"),)),
    scoped("setupProjection", "Ready a projection of textures: onto this plane of the scope, from "
                               "its origin, in images of the given size in the scope's units. It "
                               "holds for all that follows, so that an image runs on over the "
                               "parts that splits make, once `projectUV` stands in them.",
            ((words("plane", "xy", "xz", "yz"), Param("width", above=0),
              Param("height", above=0)),),
            ("setupProjection(xy, 2, 1) projectUV Wall",),
            ("setupProjection(2, 1)", "setupProjection(xy, 0, 1)"), act="lay"),
    scoped("projectUV", "Lay textures as the last `setupProjection` says.", ((),),
            ("setupProjection(xy, 2, 1) split x { ~1: projectUV Wall }",), ("projectUV(1, 2)",),
            act="lay"),
    scoped("tileUV", "Repeat the texture: images of this size in the scope's units, on each side "
                      "of a scope or in a projection.",
            ((Param("width", above=0), Param("height", above=0)),),
            ("tileUV(2, 1) Wall",), ("tileUV(2)", "tileUV(0, 1)"), act="lay"),
    scoped("translateUV", "Move the texture coordinates, in images.",
            ((Param("u"), Param("v")),), ("translateUV(0.5, 0) Wall",), ("translateUV(1)",),
            act="lay"),
    scoped("scaleUV", "Multiply the texture coordinates: by 2 an image is half as large.",
            ((Param("u"), Param("v")),), ("scaleUV(2, 2) Wall",), ("scaleUV(1)",), act="lay"),
    scoped("rotateUV", "Turn the texture coordinates about their origin, in degrees, "
                        "counter-clockwise: the image turns clockwise.",
            ((Param("angle"),),), ("rotateUV(90) Wall",), ("rotateUV",), act="lay"),
)  # fmt: skip

TABLE = PLACE + FLOW + LOOK
