"""Random scope rules: splits, parts of solids, frames and sizes, roofs, textures and reports.

Every symbol expects a form of geometry: `flat` (one polygon that fills its scope), `box` (a solid
that fills its scope) or any; bodies follow what their operations make of it, so that roofs come to
stand on polygons. Turtles of `turtles` stand in scopes as symbols of their own. Symbols make only
symbols that were written before, or themselves with less.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from tests.random_grammars.turtles import Turtles
from tests.random_grammars.values import Value
from tests.random_grammars.writing import Place, Symbol, Writer

SIZES = ("0.71", "1.13", "1.37", "2", "2.29", "3.17")
SHARES = ("0.13", "0.25", "0.27", "0.41", "0.5")
SIDES = ("front", "back", "left", "right", "side", "top", "bottom", "vertical", "horizontal", "all")
SCOPE = tuple(Value(f"scope.s{axis}", 0, 12) for axis in "xyz")
PIECE = (Value("split.index", 0, 20), Value("split.count", 0, 20))
CORNERS = (
    "(0, 0), (9, 0), (9, 7), (0, 7)",
    "(0, 0), (11, 0), (11, 4), (5, 4), (5, 9), (0, 9)",
    "(1, 0), (8, 1), (10, 6), (3, 9), (-1, 4)",
)
ROOFS = ("Gable(35)", "Hip(30)", "Hip(25, overhang: 0.2)", "Shed(12)", "Pyramid(1.7)",
         "Mansard(70, 0.4, 25)")  # fmt: skip
KINDS = {
    "shape": 4, "split": 5, "comp": 2, "frame": 3, "solid": 3, "bracket": 2, "repeat": 2,
    "set": 1, "named": 1, "pen": 2, "texture": 1, "apart": 1, "report": 1, "turtle": 1,
}  # fmt: skip


@dataclass(slots=True)
class Scopes(Writer):
    """`grown`: symbols of turtles that may stand in scopes; `phased`: rules ask about phases."""

    plants: list[Symbol] = field(default_factory=list)
    phased: bool = False

    def grammar(self, turtles: Turtles | None = None) -> str:
        """A whole file; with turtles, on whose lines it goes on."""
        draw = self.draw
        if turtles is None:
            self.lines.append("ipm 1")
            self.lines.append('asset block = "pieces.obj"')
            self.declare()
        else:
            self.lines, self.names, self.tables = turtles.lines, turtles.names, turtles.tables
            self.settable, self.values = turtles.settable, turtles.values
            self.plants = turtles.symbols
            self.lines.append('asset block = "pieces.obj"')
        self.given = ("block", "Panel")
        self.phased = draw.random() < 0.12
        count = draw.choice((1, 2, 2, 3, 4))
        for number in range(count):
            form = draw.choice(("", "flat", "box"))
            self.symbol(f"A{number}", max(4, self.largest // (count - number)), form)
        self._start()
        return "\n".join([*self.lines, ""])

    def _start(self) -> None:
        draw = self.draw
        place = Place(tuple(self.names), self.largest * 2)
        sizes = ", ".join(draw.choice(("8", "11", "5.3")) for _ in range(2))
        ground, form = draw.choice(
            (
                (f"box({sizes}, 0)", "flat"),
                (f"box({sizes}, 0)", "flat"),
                (f"box({sizes}, {draw.choice(('6', '9.1'))})", "box"),
                (f"polygon [{draw.choice(CORNERS)}]", "polygon"),
                ('"lots.obj"', "polygon"),
            )
        )
        place = place.inner(4 if "obj" in ground else 1, form=form)
        first = ""
        if form == "polygon" or (form == "flat" and draw.random() < 0.3):
            place.form, first = "box", f"extrude({draw.choice(SIZES)}) "
        elif form == "box" and draw.random() < 0.5:
            first = f"size(scope.sx, scope.sy, {draw.choice(SIZES)}) "
        step = draw.choice(("translate(2, 0.3, 0)", "rotate(0, 0, 20)", "translate(0, 1, 2)"))
        calls = [self.several(place, step) for _ in range(draw.randint(1, 3))]
        body = " ".join(f"[{each}]" for each in calls if each)
        last = self._later() if self.phased else self.shape(place)
        self.lines.append(f"Z --> {first}{body} {last}")
        steps = f" steps {draw.randint(2, 6)}" if draw.random() < 0.15 else ""
        self.lines.append(f"start Z on {ground}{steps}")

    def _later(self) -> str:
        """A symbol of a later phase, or one that asks what stands around it."""
        draw = self.draw
        if draw.random() < 0.3:
            asked = draw.choice(
                (
                    'overlaps("T")',
                    'touches("U")',
                    "inside()",
                    'distance("V") < 2',
                    'overlaps("bay")',
                )
            )
            self.lines.append(f"Q : {asked} --> U")
            self.lines.append(f"Q : else --> {draw.choice(('T', 'split x { ~1: V | ~2: U }'))}")
            return "repeat(k < 3) { [translate(k, 0.5, 0) size(2, 1, 1) cube Q] }"
        asked = draw.choice(
            ('count("T") > 3', 'rank("bay") == 0', 'total("cost") > 2', 'share("area", 7) > 0')
        )
        reach = draw.choice(("", ", reach: 0.4"))
        self.lines.append(f"Q : {asked} --> split y {{ {{ ~1.5: T }}* | ~1: V }}")
        self.lines.append(f'Q : else --> split x(snap: "sill"{reach}) {{ {{ ~1.3: U }}* }}')
        return "phase(2) split y { ~1: Q | ~2: Q }"

    # --------------------------------------------------------------------------- bodies

    def body(self, place: Place) -> str:
        """Elements, with a shape at the end where something was changed before."""
        draw = self.draw
        if place.depth == 0:
            place.names = (*place.names, *SCOPE, *PIECE)
        elements = [self.element(place) for _ in range(draw.choice((1, 1, 1, 2, 3)))]
        spread = elements and elements[-1] and elements[-1].endswith("}")
        if not spread or draw.random() < 0.3:
            elements.append(self.shape(place))
        return " ".join(each for each in elements if each)

    def element(self, place: Place) -> str | None:
        """One element; what the geometry is then is noted in the place."""
        draw = self.draw
        kind = draw.choices(tuple(KINDS), KINDS.values())[0]
        if place.budget < 4 or place.depth > draw.choice((0, 1, 1, 2)):
            kind = draw.choice(("shape", "frame", "pen"))
        match kind:
            case "named":
                return self.named(place)
            case "set":
                return self.setting(place)
            case _:
                return getattr(self, f"_{kind}")(place)

    def shape(self, place: Place) -> str:
        """A symbol, or a terminal."""
        if self.draw.random() < 0.75:
            found = self.call(place)
            if found:
                return found
        place.budget -= 1
        return self.draw.choice(("T", "U", "V", "T", "U", "V", "block", "nil"))

    _shape = shape

    def _turtle(self, place: Place) -> str | None:
        """A plant that stands here."""
        found = self.call(place, self.plants) if self.plants else None
        return f"[{self.draw.choice(('^(90) ', '', '*(0.4) '))}{found}]" if found else None

    def _bracket(self, place: Place) -> str:
        draw = self.draw
        inner = place.inner()
        body = self.body(inner)
        place.settle(inner)
        moved = draw.choice(("", "", "", "mirror ", "*(0.8) ", "at(0.7, 0.3, 20) ", "+(30) "))
        return f"[{moved}{body}]"

    def _repeat(self, place: Place) -> str:
        head, inner = self.copies(place)
        step = ""
        if self.draw.random() < 0.6:
            step = f"translate({self.number(place)}, {self.draw.choice(('0', '0.3'))}, 0) "
        body = f"{step}[{self.body(inner)}]"
        place.settle(inner)
        return f"[{head} {{ {body} }}]" if step else f"{head} {{ {body} }}"

    def _split(self, place: Place) -> str:
        draw = self.draw
        if "split" in self.dropped and draw.random() < 0.8:
            return self.shape(place)
        axes = {"box": "xxyyz", "flat": "xxxyyyuv"}
        axis = draw.choice(axes.get(place.form, "xyz"))
        return f"split {axis} {{ {self._parts(place, axis)} }}"

    def _parts(self, place: Place, axis: str, nested: int = 0) -> str:
        draw = self.draw
        found = []
        for _ in range(draw.randint(1, 3 - nested)):
            if nested < 2 and draw.random() < 0.4:
                inner = place.inner(3)
                parts = self._parts(inner, axis, nested + 1)
                place.settle(inner)
                found.append(f"{{ {parts} }}{draw.choice('***+')}")
            else:
                inner = place.inner()
                found.append(f"{self._size(inner, axis)}: {self.body(inner)}")
                place.settle(inner)
        return " | ".join(found)

    def _size(self, place: Place, axis: str) -> str:
        """A size of a piece; along texture coordinates a side is 1 long."""
        draw = self.draw
        if axis in "uv":
            return draw.choice(("0.3", "~0.4", "'0.5", "~1"))
        return draw.choice(
            (
                draw.choice(SIZES),
                f"'{draw.choice(SHARES)}",
                f"~{draw.choice(SIZES)}",
                f"~({self.number(place)})",
                f"({self.number(place)})",
                "~1",
                "~scope.sx * 0.3",
            )
        )

    def _comp(self, place: Place) -> str:
        """Faces; a box has six, of which a label takes some."""
        draw = self.draw
        parts = []
        for _ in range(draw.randint(1, 3)):
            label = draw.choice(SIDES)
            label = draw.choice(
                (
                    label, label, label, str(draw.randint(0, 5)), f"not {label}",
                    f"{label} or {draw.choice(SIDES)}", f"{label} and not {draw.randint(0, 5)}",
                )
            )  # fmt: skip
            inner = place.inner(4 if label in ("side", "all", "vertical") else 1, form="flat")
            parts.append(f"{label}: {self.body(inner)}")
            place.settle(inner)
        return f"comp {{ {' | '.join(parts)} }}"

    def _frame(self, place: Place) -> str | None:
        draw = self.draw
        number = self.number(place)
        return self.choice(
            (
                f"translate({number}, {draw.choice(SIZES)}, -{draw.choice(SIZES)})",
                f"rotate({draw.choice(('0', '20', '90'))}, 33, {number})",
                f"rotate(0, 0, 40, about: {draw.choice(('bottom', 'middle', 'top'))})",
                f"rotateScope(0, {draw.choice(('30', '90'))}, 0)",
                f"size(scope.sx * 0.7, {number}, scope.sz)",
                f"size(max(1, scope.sx), scope.sy, scope.sz * {draw.choice(SHARES)})",
                f"center({draw.choice(('x', 'y', 'z', 'xy', 'xz', 'yz', 'xyz'))})",
                f"mirrorScope({draw.choice('xyz')})",
                f"alignScopeToAxes{draw.choice(('', '(y)', '(x)'))}",
            )
        )

    def _solid(self, place: Place) -> str | None:
        """Another geometry of the shape's own."""
        draw = self.draw
        flat = place.form == "flat"
        made = draw.choice(
            ("extrude", "extrude", "extrude", "roof", "roof", "taper", "inset", "making")
            if flat
            else ("making", "making", "quad", "octant")
        )
        match made:
            case "extrude":
                place.form = "box"
                along = draw.choice(("", "", ", along: up" if place.depth == 0 else ""))
                return f"extrude({self.number(place)}{along})"
            case "roof":
                place.form = "solid"
                return self.choice([f"roof{each}" for each in ROOFS])
            case "taper":
                place.form = "solid"
                return self.choice((f"taper({self.number(place)}{draw.choice(('', ', 0.1'))})",))
            case "inset":
                inner = draw.choice(("", " innerRect"))
                return self.choice((f"offset(-0.04 * min(scope.sx, scope.sy)){inner}",))
            case "octant":
                x, y, z = (draw.choice(("0.3 * scope.sx", "0.5")) for _ in range(3))
                return self.choice((f"octant({x}, {y}, {z}, {draw.randint(1, 8)})",))
            case "quad":
                place.form = "flat"
                return f"size({self.number(place)}, {self.number(place)}, 0) quad"
            case _:
                sizes = ", ".join(self.number(place) for _ in range(3))
                name = self.choice(("cube", "cube", "cylinder(6)", "cone(5)", "sphere(6)"))
                place.form = "box" if name == "cube" else "solid"
                return f"size({sizes}) {name}"

    def _apart(self, place: Place) -> str | None:
        """What takes a shape apart in other ways."""
        draw = self.draw
        cells = 2 * draw.randint(1, 3)
        inner = place.inner(6, form=place.form)
        body = self.body(inner)
        made = f"subdivide(2, {cells // 2}, 1) [{body}]"
        if place.form == "flat":
            made = self.choice(
                (
                    f"setback(0.1) {{ shape: {body} | border: T }}",
                    f"offset(-0.1) {{ inside: {body} | border: U }}",
                    f"shapeL(0.3 * scope.sx, 0.3 * scope.sy) {{ shape: T | rest: {body} }}",
                    f"scatter({cells}, over: scope) [{body}]",
                    made,
                )
            )
        else:
            edges = f"comp(edges) {{ {draw.choice(SIDES)}: size(scope.sx, 0.2, 0.2) cube T }}"
            made = self.choice((made, edges))
        place.settle(inner)
        return f"[{made}]" if made else None

    def _pen(self, place: Place) -> str | None:
        draw, values = self.draw, self.values
        return self.choice(
            (
                f"color({values.text(place.names)})",
                'material("brick")',
                f"layer({draw.randint(-1, 2)})",
                f'tag("{draw.choice(("street", "yard"))}")',
                f'label("{draw.choice(("door", "bay"))}")',
            )
        )

    def _texture(self, place: Place) -> str | None:
        draw = self.draw
        return self.choice(
            (
                'texture("brick.png")',
                "setupProjection(xy, 2, 1) projectUV",
                f"tileUV({draw.choice(SIZES)}, 1)",
                "translateUV(0.5, 0.25) rotateUV(30)",
                "scaleUV(2, 1.5)",
            )
        )

    def _report(self, place: Place) -> str | None:
        draw = self.draw
        if self.phased and draw.random() < 0.7:
            return f'snap("sill", {draw.choice("xy")}{draw.choice(("", ", at: both"))})'
        return self.choice((f'report("{draw.choice(("area", "cost"))}", {self.number(place)})',))

    def number(self, place: Place) -> str:
        """An expression well above 0."""
        return self.values.number(0.3, 4, place.names)
