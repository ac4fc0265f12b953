"""Operations of marching rules: walking on a surface, and the tubes drawn behind.

Records only; no executor runs them yet.
"""

from __future__ import annotations

from ipmlang.compiler.ops.record import Param
from ipmlang.compiler.ops.scope import number, scoped, words

TABLE = (
    scoped("march", "Walk over the surface by a length in a direction (degrees to the left of the "
            "present one), where a condition holds; `search` is the angle to look around in. `top` "
            "goes on from the end, `extruded` is drawn along the way.",
            ((Param("length"), Param("angle"), Param("when", "bool", optional=True, named=True),
              number("search")),),
            ("march(2, 0) { top: Ivy | extruded: Bark }",
             "march(2, rand(-90, 90), when: 2 > 1, search: 180) { top: Ivy }"),
            ("march(2) { top: Ivy }", "march(2, 0) { side: Ivy }", 'march(2, 0, when: "always") '
            '{ top: A }'),
            family="marching", effect="structure", labels=("top", "extruded")),
    scoped("tube", "Draw a tube of a radius along the way; `at each segment` places what is in "
                    "braces.",
            ((Param("radius", above=0), Param("sides", "int", optional=True, named=True, above=2),
              words("smooth", "C0", "C1", "C2", named=True, optional=True)),),
            ("tube(0.01)", "tube(0.01, sides: 12, smooth: C1) at each segment { leaf }"),
            ("tube", "tube(0)", "tube(0.01, smooth: C9)"),
            family="marching", effect="draw", labels=("",), bare=True, axes=("segment", "point")),
    scoped("scatterOn", "Start a number of walkers at random places of the surface.",
            ((Param("count", "int"),),), ("scatterOn(20) Moss",), ("scatterOn",),
            family="marching", effect="structure"),
    scoped("paint", "Write a value into a context under the shape.",
            ((Param("context", "context"), Param("value")),), (), ("paint(3, 1)",),
            family="marching", effect="structure"),
)  # fmt: skip
