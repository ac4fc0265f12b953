"""Random grammars for property tests: rules with guards, chances, copies, brackets, pens and draws.

In goes a number, out comes the text of a grammar that ends: every call counts its first argument
down. Nothing in it threads, so every executor can derive it. With `Setting` or `Written` rules
change an attribute: by `set`, or by hand through a parameter of every rule, which must be the same.
"""

from __future__ import annotations

from random import Random

PLANE = ("F", "turn", "mirror", "*(0.9)", "F({})", "f({})", "+({})", "-({} * 10)", "!({})")
PENS = ('color("#f00")', 'color("teal")', 'fill("red")', 'css("a:1")', "layer({})")
SPACE = ("&({})", "^({})", "/({} * 20)", "at(1, 2, 0.5, 0.6, 0, 0.8, 0.1)", "at({}, 1, 7, 0.8)")


class Grammar:
    """One grammar under construction. `_attribute`: how the attribute is read here, if any."""

    def __init__(self, seed: int) -> None:
        self._attribute: str | None = None
        self._random = Random(seed)
        self._commands = PLANE + PENS + (SPACE if self._random.random() < 0.5 else ())
        self._rules = "ABC"[: self._random.randrange(1, 4)]

    def text(self) -> str:
        """The whole grammar."""
        lines = ["ipm 1", *(["attr v = 3"] if self._attribute else [])]
        for name in self._rules:
            lines += self._alternatives(name)
        if self._random.random() < 0.3:
            lines.append(f"interpret {self._head('A')} --> F({self._attribute or 'n'}) [+(x) F]")
        calls = " ".join(
            f"[{name}({self._random.randrange(1, 5)}, 2{self._passed()})]" for name in self._rules
        )
        steps = " steps 3" if self._random.random() < 0.3 else ""
        return "\n".join([*lines, f"start {calls} F{steps}", ""])

    def _alternatives(self, name: str) -> list[str]:
        head = self._head(name)
        match self._random.randrange(3):
            case 0:
                guards = ["n > 0", "else"]
            case 1:
                guards = ["n > 0 : 40%", "n > 0 : 40%", "else"]
            case _:
                guards = ["n > 0 : weight 2", "n > 0 : weight abs(x) + 1", "n <= 0"]
        last = self._random.choice(["nil", "F(x)", "[F] f(2)"])
        bodies = [" ".join(self._body(["n", "x"], 0)) for _ in guards[1:]]
        return [
            f"{head} : {guard} --> {body}"
            for guard, body in zip(guards, [*bodies, last], strict=True)
        ]

    def _head(self, name: str) -> str:
        return f"{name}(n, x)"

    def _passed(self) -> str:
        """The attribute as one more argument, where it is handed on by hand."""
        return ""

    def _set(self, value: str) -> str:
        """What changes the attribute for the rest of a body."""
        return f"set (v = {value})"

    def _body(self, names: list[str], depth: int, copies: bool = False) -> list[str]:
        before = self._attribute
        parts = []
        for _ in range(self._random.randrange(1, 4)):
            if self._attribute and self._random.random() < 0.3:
                parts.append(self._set(f"({self._attribute} * 0.5 + n)"))
            parts.append(self._part(names, depth))
        if not copies and self._random.random() < 0.5:
            parts.append(self._call(names))  # in tail position, so that it may move
        self._attribute = before
        return parts

    def _part(self, names: list[str], depth: int) -> str:
        kind = self._random.random()
        if kind < 0.55:
            return self._random.choice(self._commands).format(self._value(names))
        if kind < 0.75 and depth < 2:
            return f"[{' '.join(self._body(names, depth + 1))}]"
        if kind < 0.85 and depth < 2:
            copy = f"i{depth}"
            holes = self._random.choice(["", "", f" except ({self._random.randrange(3)})"])
            count = self._random.choice(["2", "3", "n", "irand(0, 2)"])
            body = " ".join(self._body([*names, copy], depth + 1, copies=True))
            return f"repeat({copy} < {count}){holes} {{ {body} }}"
        return f"[{self._call(names)}]"

    def _call(self, names: list[str]) -> str:
        name = self._random.choice(self._rules)
        down = self._random.choice([1, 1, 1, 2])
        return f"{name}(n - {down}, {self._value(names)}{self._passed()})"

    def _value(self, names: list[str], depth: int = 0) -> str:
        kind = self._random.random()
        if depth > 1 or kind < 0.35:
            return str(self._random.choice([0.5, 1, 2, 3, 1.5, 7]))
        if kind < 0.65:
            return self._random.choice([*names, *([self._attribute] if self._attribute else [])])
        if kind < 0.8:
            return self._random.choice(["rand(0, 4)", "rand(-3, 2)", "irand(0, 3)"])
        parts = [self._value(names, depth + 1) for _ in range(2)]
        return f"({parts[0]} {self._random.choice('+-*')} {parts[1]})"


class Setting(Grammar):
    """A grammar whose rules set an attribute."""

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._attribute = "v"


class Written(Setting):
    """The same with the attribute as a parameter."""

    def _head(self, name: str) -> str:
        return f"{name}(n, x, v)"

    def _passed(self) -> str:
        return f", {self._attribute}"

    def _set(self, value: str) -> str:
        self._attribute = value
        return ""


class Naming(Grammar):
    """A grammar whose bodies name values."""

    def _body(self, names: list[str], depth: int, copies: bool = False) -> list[str]:
        if self._random.random() < 0.4:
            return super()._body(names, depth, copies)
        name = f"w{len(names)}"
        given = f"with ({name} = {self._value(names)})"
        return [given, *super()._body([*names, name, name], depth, copies)]
