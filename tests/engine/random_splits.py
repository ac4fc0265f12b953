"""Random split grammars, well formed and the same for a seed: what the scope oracle understands.

Symbols make only symbols of later numbers, or themselves with less, so that every derivation ends;
sizes are taken from lists without round ratios, so that no count hangs on the last bit.
"""

from __future__ import annotations

import random
from collections.abc import Callable

TERMINALS = ("T", "U", "V")
SIZES = ("0.71", "1.13", "1.37", "2.29", "3.17")
SHARES = ("0.13", "0.27", "0.41", "0.59")
LABELS = ("front", "back", "left", "right", "side", "top", "bottom", "vertical", "horizontal")


class Splits:
    """One grammar."""

    def __init__(self, seed: int) -> None:
        self.draw = random.Random(seed)
        self.count = self.draw.randint(3, 6)
        self.arities = [self.draw.randint(0, 1) for _ in range(self.count)]
        self.parameter = False
        self.copies: list[str] = []

    def text(self) -> str:
        """The whole file."""
        draw = self.draw
        rules = "".join(self.rules(number) for number in range(self.count))
        box = ", ".join(draw.choice(("8", "11", "5.3")) for _ in range(2))
        height = draw.choice(("6", "6", "9.1", "0"))
        steps = draw.choice(("", "", "", f" steps {draw.randint(1, 4)}"))
        given = "" if not self.arities[0] else f"({draw.randint(1, 3)})"
        return (
            f"ipm 1\nattr a = {draw.choice(SIZES)}\nattr b = {draw.choice(SIZES)}\n{rules}"
            f"start A0{given} on box({box}, {height}){steps}\n"
        )

    # ---------------------------------------------------------------------------- rules

    def rules(self, number: int) -> str:
        """All rules of a symbol."""
        self.parameter = bool(self.arities[number])
        head = f"A{number}" + ("(n)" if self.parameter else "")
        kind = self.draw.choice(("one", "guard", "percent", "weight", "again", "both"))
        if kind == "again":
            return self.recursive(head, number)
        bodies = [self.body(number, 0) for _ in range(3)]
        guards = {
            "one": ("",),
            "guard": (f" : {self.guard()}", " : else"),
            "percent": (" : 35%", f" : {self.guard()} : 30%", " : else"),
            "weight": (" : weight 2", f" : weight {self.number()}"),
            "both": (f" : {self.guard()}", f" : {self.guard()} : 50%", " : else"),
        }[kind]
        pairs = zip(guards, bodies, strict=False)
        return "".join(f"{head}{guard} --> {body}\n" for guard, body in pairs)

    def recursive(self, head: str, number: int) -> str:
        """A symbol that makes itself until its parameter or its room is used up."""
        axis = self.draw.choice("xyz")
        size = self.draw.choice((*SIZES, "'0.41", f"~{self.number()}"))
        other = self.body(number, 1)
        if self.parameter:
            guard, again = "n > 0", f"A{number}(n - 1)"
        else:
            guard, again = f"scope.s{axis} > 3.01", f"A{number}"
        step = self.draw.choice(
            (
                f"split {axis} {{ {size}: {other} | ~1: {again} }}",
                f"[{other}] rotate(0, 0, 17) size(scope.sx * 0.8, scope.sy, 0.9) {again}",
                f"{again} split {axis} {{ ~1: {other} }}",
                f"split {axis} {{ '0.31: {again} | ~1: {other} }}",
            )
        )
        turns = " rotate" in step and not self.parameter  # its room would never be used up
        if turns or (step.startswith("A") and not self.parameter):
            step = f"split {axis} {{ '0.31: {again} | ~1: {other} }}"
        return f"{head} : {guard} --> {step}\n{head} : else --> {self.body(number, 1)}\n"

    def guard(self) -> str:
        draw = self.draw
        choices: list[Callable[[], str]] = [
            lambda: f"scope.s{draw.choice('xyz')} > {draw.choice(SIZES)}",
            lambda: f"scope.{draw.choice('xyz')} < {draw.choice(SIZES)}",
            lambda: f"split.index == {draw.randint(0, 2)}",
            lambda: "split.index == split.count - 1",
            lambda: f"rand() < {draw.choice(SHARES)}",
            lambda: f"a > b or scope.sx > {draw.choice(SIZES)}",
            lambda: f"not irand(0, 2) == {draw.randint(0, 2)}",
        ]
        if self.parameter:
            choices.append(lambda: f"n > {draw.randint(0, 2)}")
        return draw.choice(choices)()

    # --------------------------------------------------------------------------- bodies

    def body(self, number: int, depth: int) -> str:
        """Some elements; symbols in them come after `number`."""
        elements = [self.element(number, depth) for _ in range(self.draw.choice((0, 1, 1, 2)))]
        makes = " ".join(elements).count(" ") > 3 and self.draw.random() < 0.5
        return " ".join(elements if makes else [*elements, self.shape(number)])

    def element(self, number: int, depth: int) -> str:
        draw = self.draw
        kind = draw.choice(
            (
                "shape",
                "shape",
                "split",
                "split",
                "comp",
                "frame",
                "frame",
                "bracket",
                "repeat",
                "set",
            )
        )
        if depth > draw.randint(0, 2) and kind in ("split", "comp", "repeat", "bracket"):
            kind = "shape"
        match kind:
            case "shape":
                return self.shape(number)
            case "split":
                return f"split {draw.choice('xyz')} {{ {self.parts(number, depth)} }}"
            case "comp":
                labels = [self.label() for _ in range(draw.randint(1, 3))]
                parts = [f"{label}: {self.body(number, depth + 1)}" for label in labels]
                return f"comp {{ {' | '.join(parts)} }}"
            case "bracket":
                return f"[{self.body(number, depth + 1)}]"
            case "repeat":
                return self.repeat(number, depth)
            case "set":
                return f"set {draw.choice('ab')} = {self.number()}"
            case _:
                return self.frame()

    def shape(self, number: int) -> str:
        draw = self.draw
        if number + 1 < self.count and draw.random() < 0.6:
            chosen = draw.randint(number + 1, self.count - 1)
            given = f"({draw.choice(('1', '2', 'irand(0, 3)'))})" if self.arities[chosen] else ""
            return f"A{chosen}{given}"
        return draw.choice((*TERMINALS, *TERMINALS, *TERMINALS, "nil"))

    def parts(self, number: int, depth: int, nested: int = 0) -> str:
        found = []
        for _ in range(self.draw.randint(1, 3 - nested)):
            if nested < 2 and self.draw.random() < 0.35:
                mode = self.draw.choice("**+")
                found.append(f"{{ {self.parts(number, depth, nested + 1)} }}{mode}")
            else:
                found.append(f"{self.size()}: {self.body(number, depth + 1)}")
        return " | ".join(found)

    def size(self) -> str:
        draw = self.draw
        return draw.choice(
            (
                draw.choice(SIZES),
                f"'{draw.choice(SHARES)}",
                f"~{draw.choice(SIZES)}",
                f"~({self.number()})",
                f"({self.number()})",
                f"~{draw.choice('ab')}",
                draw.choice(("0 * a", "a - 1.37", "~1")),
            )
        )

    def repeat(self, number: int, depth: int) -> str:
        draw = self.draw
        name = f"i{depth}"
        count = draw.choice(("2", "3", "irand(0, 3)", "scope.sx / 3.3"))
        extra = draw.choice(("", "", " except (1)", f" except (0, {draw.randint(1, 2)})"))
        steps = " steps (1.1, 0.7)" if count == "3" and draw.random() < 0.3 else ""
        self.copies.append(name)
        body = self.body(number, depth + 1)
        self.copies.pop()
        found = f"repeat({name} < {count}){extra}{steps} {{ {body} }}"
        return f"[{found}]" if steps else found  # a turtle's moves must not leave the rule

    def label(self) -> str:
        draw = self.draw
        plain = draw.choice(("all", str(draw.randint(0, 5)), *LABELS))
        return draw.choice(
            (
                plain,
                plain,
                f"not {draw.choice(LABELS)}",
                f"{draw.choice(LABELS)} or {draw.choice(LABELS)}",
                f"{draw.choice(LABELS)} and not {draw.randint(0, 5)}",
            )
        )

    def frame(self) -> str:
        draw = self.draw
        return draw.choice(
            (
                f"translate({self.number()}, {draw.choice(SIZES)}, -{self.number()})",
                f"rotate({draw.choice(('0', '20', '90'))}, 33, {self.number()})",
                f"size(scope.sx * 0.7, {self.number()}, scope.sz)",
                f"size({draw.choice(SIZES)}, scope.sy, {draw.choice(('0', 'scope.sz * 0.5'))})",
                f"center({draw.choice(('x', 'y', 'z', 'xy', 'xz', 'yz', 'xyz'))})",
                f"mirrorScope({draw.choice('xyz')})",
            )
        )

    def number(self) -> str:
        """An expression above 0."""
        draw = self.draw
        choices = [
            draw.choice(SIZES),
            f"rand({draw.choice(SHARES)}, 2.3)",
            f"pick({draw.choice(SIZES)}, {draw.choice(SIZES)})",
            f"{draw.choice('ab')} * {draw.choice(SHARES)} + 0.3",
            f"max(0.9, scope.s{draw.choice('xyz')} * {draw.choice(SHARES)})",
            f"(if a > 1.3 then {draw.choice(SIZES)} else 0.77)",
        ]
        choices += [f"{name} * 0.6 + 0.5" for name in self.copies]
        if self.parameter:
            choices.append("n * 0.3 + 0.6")
        return draw.choice(choices)


class Named(Splits):
    """One whose bodies name values, and read them in sizes, counts and arguments."""

    def body(self, number: int, depth: int) -> str:
        if self.draw.random() < 0.5:
            return super().body(number, depth)
        name = f"w{len(self.copies)}"
        value = self.number()
        self.copies.append(name)
        body = super().body(number, depth)
        self.copies.pop()
        return f"with {name} = {value} {body}"
