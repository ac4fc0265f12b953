"""Operations on a shape's scope: its frame, size, labels and appearance, as architects know them.

Records only. What they do ends with the body of the rule they stand in. None has a meaning yet: no
executor runs them, and `run` names them.
"""

from __future__ import annotations

from ipmlang.compiler.ops.record import Effect, Family, Operation, Param, ValueType

_XYZ = (Param("x"), Param("y"), Param("z"))
_AXIS = Param("axis", "string", words=("x", "y", "z"))
_AXES = ("x", "y", "z", "xy", "xz", "yz", "xyz")


def planned(
    name: str,
    doc: str,
    forms: tuple[tuple[Param, ...], ...] = ((),),
    examples: tuple[str, ...] = (),
    refused: tuple[str, ...] = (),
    *,
    family: Family = "scope",
    effect: Effect = "scope",
    synonyms: tuple[str, ...] = (),
    labels: tuple[str, ...] | None = None,
    bare: bool = False,
    axes: tuple[str, ...] = (),
) -> Operation:
    """A record of an operation that parses and checks, and that no executor runs yet."""
    return Operation(
        name,
        family,
        effect,
        doc,
        forms=forms,
        synonyms=synonyms,
        labels=labels,
        bare=bare,
        axes=axes,
        leaves_plane=family != "pen",
        examples=examples,
        refused=refused,
    )


def words(name: str, *choices: str, named: bool = False, optional: bool = False) -> Param:
    """A parameter that is one of a few bare words."""
    return Param(name, "string", named=named, optional=optional, words=choices)


def number(name: str, kind: ValueType = "number") -> Param:
    """A parameter that may be left out and is given by name."""
    return Param(name, kind, optional=True, named=True)


PLACE = (
    planned("translate", "Move the scope along its own axes.", (_XYZ,),
            ("translate(1, 0, 0) Window",), ("translate(1, 0)", 'translate("x", 0, 0)'),
            synonyms=("t",)),
    planned("rotate", "Turn the scope about its own x, then y, then z axis, in degrees.", (_XYZ,),
            ("rotate(0, 0, 90) Window",), ("rotate(90)",), synonyms=("r",)),
    planned("rotateScope", "Turn the scope about its own axes and leave the geometry where it is.",
            (_XYZ,), ("rotateScope(0, 90, 0) Wall",), ("rotateScope(1)",)),
    planned("size", "Set the scope's extent along x, y and z; its geometry is scaled with it.",
            (_XYZ,), ("size(scope.sx, 2, 0.1) Sill",), ("size(1)",), synonyms=("s",)),
    planned("center", "Move the scope to the middle of its parent along the axes named.",
            ((words("axes", *_AXES),),), ("center(xy) Lamp",), ("center(q)", "center(1)")),
    planned("mirrorScope", "Mirror the scope and its geometry along one of its axes.", ((_AXIS,),),
            ("mirrorScope(x) Wing",), ("mirrorScope(q)",)),
    planned("alignScopeToAxes", "Turn the scope so that its y axis is the world's, or all axes.",
            ((), (words("axis", "x", "y", "z"),)), ("alignScopeToAxes(y) Mass",),
            ("alignScopeToAxes(3)",)),
    planned("alignScopeToGeometry", "Fit the scope to its geometry: z out of the largest face, x "
                                    "along "
            "its lowest or longest edge.",
            ((), (words("edge", "lowest", "longest", "first"),)),
            ("alignScopeToGeometry Roof",), ("alignScopeToGeometry(3)",)),
    planned("pivot", "Put the scope's origin at a corner, an edge's middle or the middle of its "
                     "box.",
            ((words("place", "corner", "bottom", "middle", "top"),),), ("pivot(middle) Lamp",),
            ("pivot(9)",)),
)  # fmt: skip

FLOW = (
    Operation("nil", "scope", "structure", "Make nothing: the shape ends here.", meaning=((),),
              examples=("nil",), refused=("nil(1)",)),
    planned("tag", "Give the shape's faces a tag that `comp` can select by.",
            ((Param("name", "string"),),), ('tag("street") Wall',), ("tag", "tag(1)"),
            effect="structure"),
    planned("label", "Give the shape a label that queries can ask for.",
            ((Param("name", "string"),),), ('label("door") Door',), ("label(3)",),
            effect="structure"),
    planned("report", "Add a number to the report's sum under a key.",
            ((Param("key", "string"), Param("value")),), ('report("area", 12) Wall',),
            ('report("area")', 'report("area", "big")'), effect="structure"),
    planned("phase", "Expand what follows only when all shapes of earlier phases are done, so "
                     "that it "
            "can ask for totals.", ((Param("number", "int"),),), ("phase(2) Door",), ("phase",),
            effect="structure"),
)  # fmt: skip

LOOK = (
    planned("texture", "Set the texture of what is drawn: an image beside the grammar.",
            ((Param("file", "string", suffixes=(".png", ".jpg", ".jpeg")),),), (),
            ("texture(1)", 'texture("nowhere.png") Wall'),
            family="pen", effect="pen"),
    planned("setupProjection", "Lay texture coordinates on the scope's plane, tiles of the given "
                               "size.",
            ((words("plane", "xy", "xz", "yz"), Param("width"), Param("height")),),
            ("setupProjection(xy, 2, 1) Wall",), ("setupProjection(2, 1)",)),
    planned("projectUV", "Apply the projection that was set up.", ((),), ("projectUV Wall",),
            ("projectUV(1, 2)",)),
    planned("rotateUV", "Turn the texture coordinates, in degrees.", ((Param("angle"),),),
            ("rotateUV(90) Wall",), ("rotateUV",)),
    planned("tileUV", "Repeat the texture at this size.", ((Param("width"), Param("height")),),
            ("tileUV(2, 1) Wall",), ("tileUV(2)",)),
    planned("translateUV", "Move the texture coordinates.", ((Param("u"), Param("v")),),
            ("translateUV(0.5, 0) Wall",), ("translateUV(1)",)),
    planned("scaleUV", "Scale the texture coordinates.", ((Param("u"), Param("v")),),
            ("scaleUV(2, 2) Wall",), ("scaleUV(1)",)),
)  # fmt: skip

TABLE = PLACE + FLOW + LOOK
