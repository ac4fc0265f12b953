"""The turtle's operations: moving, turning, drawing segments, polygons and paths.

Records only. A meaning is straight-line IR over the operation's own parameters; lowering fills in
what was left out from `defaults`. Signs follow the frame: local x is the heading, y left, z up.
"""

from __future__ import annotations

from ipmlang.compiler.ops.record import Operation, Param, Step

_ANGLE = ((Param("angle", optional=True),),)
_BY_ANGLE = (("angle", "angle"),)
_PLACE = tuple(Param(name) for name in ("x", "y", "z", "qw", "qx", "qy", "qz"))


def _turn(name: str, synonym: str, axis: str, angle: str, doc: str) -> Operation:
    return Operation(
        name,
        "turtle",
        "motion",
        doc,
        forms=_ANGLE,
        synonyms=(synonym,),
        defaults=_BY_ANGLE,
        meaning=((Step("rotate", (angle,), axis),),),
        leaves_plane=axis != "z",
        examples=(f"{name}", f"{name}(30)", f"[{synonym}(2 * 15) F]"),
        refused=(f'{name}("north")', f"{name}(1, 2)"),
    )


TURNS = (
    _turn("+", "left", "z", "angle", "Turn left by `angle` degrees, about the local up."),
    _turn("-", "right", "z", "-angle", "Turn right by `angle` degrees, about the local up."),
    _turn("&", "down", "y", "angle", "Pitch down by `angle` degrees, about the local left."),
    _turn("^", "up", "y", "-angle", "Pitch up by `angle` degrees, about the local left."),
    _turn("\\", "rollleft", "x", "-angle", "Roll left by `angle` degrees, about the heading."),
    _turn("/", "rollright", "x", "angle", "Roll right by `angle` degrees, about the heading."),
    Operation(
        "turn",
        "turtle",
        "motion",
        "Turn around: 180 degrees about the local up.",
        meaning=((Step("rotate", (180.0,), "z"),),),
        examples=("turn F", "[turn]"),
        refused=("turn(90)",),
    ),
    Operation(
        "$",
        "turtle",
        "motion",
        "Roll about the heading until the local left lies in the horizontal plane.",
        synonyms=("level",),
        meaning=((Step("level"),),),
        examples=("$ F", "[&(30) level F]"),
        refused=("$(90)",),
    ),
)

MOVES = (
    Operation(
        "f",
        "turtle",
        "motion",
        "Move forward by `distance` without drawing.",
        forms=((Param("distance", optional=True),),),
        synonyms=("move",),
        defaults=(("distance", "step"),),
        meaning=((Step("move", ("distance", 0.0, 0.0)),),),
        examples=("f", "f(64)", "move(2 * 3.5) F"),
        refused=('f("far")', "f(1, 2)"),
    ),
    Operation(
        "F",
        "turtle",
        "motion",
        "Move forward by `distance` and draw a segment of the pen's width.",
        forms=((Param("distance", optional=True),),),
        synonyms=("draw",),
        defaults=(("distance", "step"),),
        meaning=((Step("segment", ("distance",)),),),
        examples=("F", "F(64) + F(32)", "draw(3)"),
        refused=('F("far")', "F(1, 2)"),
    ),
    Operation(
        "*",
        "turtle",
        "motion",
        "Multiply the frame's scale by `factor`, and so every later length and asset.",
        forms=((Param("factor", above=0),),),
        synonyms=("grow",),
        meaning=((Step("scale", ("factor",)),),),
        examples=("*(0.8) F", "grow(1.5)"),
        refused=("*", '*("big")', "*(0)", "*(-1)"),
    ),
    Operation(
        "mirror",
        "turtle",
        "motion",
        "Flip the handedness of the frame: local x is mirrored first; `+` still turns left.",
        meaning=((Step("mirror"),),),
        examples=("[mirror F + F]",),
        refused=("mirror(1)",),
    ),
)

PLACING = (
    Operation(
        "at",
        "turtle",
        "motion",
        "Move to a place in the local frame, then turn and scale: in the plane by `angle` degrees, "
        "in space by the unit quaternion (qw, qx, qy, qz).",
        forms=(
            (Param("x"), Param("y")),
            (Param("x"), Param("y"), Param("angle")),
            (Param("x"), Param("y"), Param("angle"), Param("scale", above=0)),
            _PLACE,
            (*_PLACE, Param("scale", above=0)),
        ),
        meaning=(
            (Step("move", ("x", "y", 0.0)),),
            (Step("move", ("x", "y", 0.0)), Step("rotate", ("angle",), "z")),
            (
                Step("move", ("x", "y", 0.0)),
                Step("rotate", ("angle",), "z"),
                Step("scale", ("scale",)),
            ),
            (Step("move", ("x", "y", "z")), Step("orient", ("qw", "qx", "qy", "qz"))),
            (
                Step("move", ("x", "y", "z")),
                Step("orient", ("qw", "qx", "qy", "qz")),
                Step("scale", ("scale",)),
            ),
        ),
        examples=("[at(3, 4) F]", "[at(3, 4, 90, 0.5) F]", "[at(0, 0, 4.1, 1, 0, 0, 0) F]"),
        refused=("at(1)", "at(1, 2, 3, 4, 5)", 'at(1, "2")'),
    ),
)

DRAWING = (
    Operation(
        "polygon",
        "turtle",
        "draw",
        "Fill the polygon whose corners are the ends of the `F` and `f` inside, and the places "
        "marked by `vertex` (the book's braces). Moves inside carry on behind it.",
        labels=("",),
        meaning=((Step("polygon_open"), Step("body"), Step("polygon_close")),),
        examples=("polygon { F + F + F }", "[polygon { vertex f(2) vertex +(90) f(2) vertex }]"),
        refused=("polygon(3) { F }", "polygon { side: F }"),
    ),
    Operation(
        "path",
        "turtle",
        "draw",
        "Draw one open line through all that the `F` inside draw: one terminal, with the pen that "
        "holds behind the braces. An `F` that does not start where the line has ended begins a new "
        "part of it, behind `f` or a bracket; to a place marked by `vertex` the line goes on "
        "straight. Moves inside carry on behind it.",
        labels=("",),
        meaning=((Step("path_open"), Step("body"), Step("path_close")),),
        examples=("path { F + F f F }", 'color("teal") path { F [+ F] F }'),
        refused=("path(3) { F }", "path { side: F }"),
    ),
    Operation(
        "vertex",
        "turtle",
        "draw",
        "Mark the turtle's place as a corner of the polygon around it (the book's full stop), or "
        "as a point of the path.",
        meaning=((Step("vertex"),),),
        examples=("polygon { vertex f vertex + f vertex }", "path { F at(3, 1) vertex }"),
        refused=("vertex(1)",),
    ),
    Operation(
        "cut",
        "turtle",
        "structure",
        "Cut the rest of the branch away, up to the closing bracket (the book's %).",
        meaning=((Step("cut"),),),
        examples=("F [+ F cut F] F",),
        refused=("cut(1)",),
    ),
)

TABLE = TURNS + MOVES + PLACING + DRAWING
