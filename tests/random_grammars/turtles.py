"""Random turtles: rules whose bodies move, turn, draw and change the pen.

What is written here expands independently: a symbol that may move the turtle stands in brackets, or
last in its body. `threads` of a writer leaves the brackets out now and then, so that what follows
starts where the symbol left the turtle, and adds what only strings can do: polygons across symbols,
`cut`, rules that look at their neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass

from tests.random_grammars.values import Value
from tests.random_grammars.writing import Place, Symbol, Writer

ANGLES = ("17", "30", "45", "90", "137.5", "-22.5")
TILTS = ("41.3", "23.7", "68.9")  # no pitch of ANGLES undoes them: `$` must know what lies level
PLANE = ("move", "draw", "draw", "turn", "turn", "grow", "mirror", "pen", "pen", "place", "asset")
SPACE = (*PLANE, "pitch", "pitch", "roll", "level", "set", "material")


@dataclass(slots=True)
class Turtles(Writer):
    """`space`: leaves the plane; `threads`: what follows a symbol sees where it left the turtle."""

    space: bool = False
    threads: bool = False
    scoped: bool = False
    known: tuple[Symbol, ...] = ()

    def grammar(self) -> str:
        """A whole file."""
        self.lines.append("ipm 1")
        self.prepare()
        self.declare()
        self.plant(self.draw.choice((1, 2, 2, 3)), self.largest)
        interpreted = self._interpreted()
        place = Place(tuple(self.names), self.largest * 2)
        steps = f" steps {self.draw.randint(1, 4)}" if self.draw.random() < 0.25 else ""
        self.lines.append(f"start {self._axiom(place, interpreted)}{steps}")
        return "\n".join([*self.lines, ""])

    def prepare(self) -> None:
        """Settings and assets, before what reads them."""
        draw = self.draw
        if self.scoped:
            self.dropped = (*self.dropped, "effect")  # a rule with it is no string of its own
        if draw.random() < 0.5:
            frame = " frame abop" if self.space and draw.random() < 0.5 else ""
            self.lines.append(f"turtle angle {draw.choice((25.7, 60, 90))} step 1.5{frame}")
        if self.space and not self.scoped and draw.random() < 0.12:
            self.lines.append("tropism (0.1, 0, -1) 0.22")
        self.lines.append('asset leaf, star in "pieces.parts.svg"')
        self.given = () if self.scoped else ("leaf", "star", "Tip")

    def plant(self, count: int, budget: int) -> list[Symbol]:
        """Write some symbols; later ones call earlier ones."""
        first = len(self.symbols)
        for number in range(count):
            name = f"{'P' if self.scoped else 'A'}{number}"
            self.symbol(name, max(4, budget // (count - number)))
        return self.symbols[first:]

    def _axiom(self, place: Place, interpreted: bool) -> str:
        draw = self.draw
        steps = ("f(2) +(15)", "at(3, 1)", "&(20) f(3)" if self.space else "-(40) f(3)")
        found = [self.several(place, draw.choice(steps)) for _ in range(draw.randint(1, 3))]
        extra = " X(2)" if interpreted else ""
        return " ".join(each for each in found if each) + f" F{extra}"

    def _interpreted(self) -> bool:
        """A symbol that is read when the derivation is done."""
        if self.draw.random() < 0.7:
            return False
        names = (*self.names, Value("n", 0, 4))
        length = self.values.number(0.2, 3, names)
        self.lines.append(f"interpret X(n) : n > 1 : 60% --> F({length}) [+(30) F(n)]")
        self.lines.append("interpret X(n) : else --> f(1) F(0.5)")
        self.symbols.append(Symbol("X", (Value("n", 0, 4),), 2, 4))
        return True

    # --------------------------------------------------------------------------- bodies

    def body(self, place: Place) -> str:
        """Elements; the last one may be a symbol that moves."""
        draw = self.draw
        elements = [self.element(place) for _ in range(draw.choice((1, 2, 2, 3, 4)))]
        if place.share == 1 and draw.random() < 0.6:
            elements.append(self.call(place))
        elif draw.random() < 0.5:
            elements.append(self.draws(place))
        return " ".join(each for each in elements if each)

    def element(self, place: Place) -> str | None:
        """One element."""
        draw = self.draw
        kind = draw.random()
        if kind < 0.5 or place.budget < 2:
            return self.draws(place) if place.budget > 0 else None
        if kind < 0.62 and place.depth < 3:
            return f"[{self._inside(place)}]"
        if kind < 0.74 and place.depth < 3:
            head, inner = self.copies(place)
            found = f"{head} {{ {self.body(inner) or 'nil'} }}"
            place.settle(inner)
            return found
        if kind < 0.8:
            return self.named(place)
        if kind < 0.85:
            return self.setting(place)
        found = self.call(place)
        if found is None or (self.threads and draw.random() < 0.6):
            return found
        return f"[{found}]"

    def _inside(self, place: Place) -> str:
        inner = place.inner()
        body = self.body(inner) or "F"
        place.settle(inner)
        if self.threads and self.draw.random() < 0.06:
            body += " cut F"
        return body

    def draws(self, place: Place) -> str | None:
        """An operation of the turtle or of its pen."""
        draw = self.draw
        kind = draw.choice(SPACE if self.space else PLANE)
        kind = "pitch" if kind == "level" and self.scoped else kind
        if draw.random() < 0.06 and not self.scoped and place.budget > 1:
            place.budget -= 1
            return self.choice((self._polygon(place),))
        if kind in ("draw", "asset"):
            place.budget -= 1
        return getattr(self, f"_{kind}")(place)

    def _polygon(self, place: Place) -> str:
        corners = [
            f"F({self._length(place)}) +({self.draw.choice(ANGLES)})"
            for _ in range(self.draw.randint(3, 5))
        ]
        kind = "path" if len(corners) == 4 else "polygon"
        return f"[{kind} {{ {' '.join(corners)} }}]"

    def _length(self, place: Place) -> str:
        return self.values.number(0.2, 4, place.names)

    def _angle(self, place: Place) -> str:
        draw = self.draw
        if draw.random() < 0.5:
            return draw.choice(ANGLES)
        return self.values.number(-180, 180, place.names)

    def _move(self, place: Place) -> str:
        return f"f({self._length(place)})" if self.draw.random() < 0.8 else "f"

    def _draw(self, place: Place) -> str:
        return f"F({self._length(place)})" if self.draw.random() < 0.8 else "F"

    def _asset(self, place: Place) -> str:
        return self.draw.choice(("leaf", "star"))

    def _turn(self, place: Place) -> str:
        draw = self.draw
        return draw.choice((f"{draw.choice('+-')}({self._angle(place)})", "+", "-", "turn"))

    def _pitch(self, place: Place) -> str:
        return f"{self.draw.choice('&^')}({self._angle(place)})"

    def _roll(self, place: Place) -> str:
        turn = self.draw.choice(("\\", "/", "rollleft"))
        return f"{turn}({self._angle(place)})"

    def _level(self, place: Place) -> str | None:
        return self.choice((f"&({self.draw.choice(TILTS)}) $",))

    def _grow(self, place: Place) -> str:
        return f"*({self.values.number(0.6, 1.3, place.names)})"

    def _mirror(self, place: Place) -> str:
        return "mirror"

    def _place(self, place: Place) -> str:
        x, y = (self.values.number(-3, 3, place.names) for _ in range(2))
        draw = self.draw
        return draw.choice(
            (
                f"at({x}, {y})",
                f"at({x}, {y}, {self._angle(place)})",
                f"at({x}, {y}, {self._angle(place)}, {self.values.number(0.6, 1.3, place.names)})",
            )
        )

    def _set(self, place: Place) -> str:
        """A place in space."""
        x = self.values.number(-3, 3, place.names)
        turn = self.draw.choice(("0.6, 0, 0.8, 0", "1, 0, 0, 0", "0.5, 0.5, -0.5, 0.5"))
        scale = self.draw.choice(("", ", 0.9", ", 1.25"))
        return f"at({x}, 1, 0.5, {turn}{scale})"

    def _pen(self, place: Place) -> str | None:
        draw, values = self.draw, self.values
        return self.choice(
            (
                f"!({values.number(0.2, 4, place.names)})",
                f"color({values.text(place.names)})",
                f"fill({values.text(place.names)})",
                f'stroke("{draw.choice(("#123", "gold"))}")',
                f'css("stroke-dasharray:{draw.randint(1, 3)} 1")',
                f"layer({values.number(-2, 2, place.names)})",
                'effect("pieces.parts.svg#shade")',
            )
        )

    def _material(self, place: Place) -> str:
        return f'material("{self.draw.choice(("brick", "slate"))}")'
