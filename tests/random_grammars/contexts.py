"""Random L-systems whose rules look at their neighbours, across brackets, for a number of steps.

Symbols are few and rules many, so that contexts are met; successors are mostly as long as what they
replace, so that strings grow slowly.
"""

from __future__ import annotations

from random import Random

from tests.random_grammars.values import Value, Values

SYMBOLS = (("A", ""), ("B", ""), ("C", "n"))
MARKS = ("F", "+", "-", "f", "F(0.5)", "+(17)")


class Contexts:
    """One grammar. `risk`: of conditions that hang on NaN."""

    def __init__(self, draw: Random, risk: float = 0.0) -> None:
        self.draw = draw
        self.values = Values(draw, risk)

    def grammar(self) -> str:
        """A whole file."""
        draw = self.draw
        lines = ["ipm 1", f"turtle angle {draw.choice((22.5, 60, 90))}"]
        if draw.random() < 0.7:
            lines.append("ignore + - F f")
        rules = dict(self._rule() for _ in range(draw.randint(2, 6)))
        lines += [f"{head} --> {rules[head]}" for head in sorted(rules, key=_always)]
        for name, parameter in SYMBOLS:
            if draw.random() < 0.6:
                head = f"{name}({parameter})" if parameter else name
                length = self.values.number(0.2, 3, self._names(parameter))
                lines.append(f"interpret {head} --> F({length}) {draw.choice(('', '[+ F]', '+'))}")
        axiom = " ".join(self._word(4) for _ in range(draw.randint(5, 12)))
        return "\n".join([*lines, f"start {axiom} steps {draw.randint(1, 6)}", ""])

    def _rule(self) -> tuple[str, str]:
        """A head with its conditions, and a successor."""
        draw = self.draw
        name, parameter = draw.choice(SYMBOLS)
        head = f"{name}({parameter})" if parameter else name
        names = self._names(parameter)
        for side in "<>":
            if draw.random() < 0.5:
                other, has = draw.choice(SYMBOLS)
                own = {"<": "l", ">": "r"}[side]
                context = f"{other}({own})" if has else other
                names = (*names, *((Value(own, 0, 9),) if has else ()))
                head = f"{context} < {head}" if side == "<" else f"{head} > {context}"
        guard = self.values.condition(names) if draw.random() < 0.4 else ""
        chance = draw.choice(("", "", "30%"))
        before = "".join(f" : {each}" for each in (guard, chance) if each)
        return f"{head}{before}", self._successor(names)

    def _successor(self, names: tuple[Value, ...]) -> str:
        draw = self.draw
        count = draw.choice((1, 1, 1, 1, 2, 2, 3))
        words = [self._word(2, names) for _ in range(count)]
        if draw.random() < 0.2:
            words.append(f"[{draw.choice('+-')} {self._word(0, names)}]")
        return " ".join(words)

    def _word(self, marks: int, names: tuple[Value, ...] = ()) -> str:
        draw = self.draw
        if draw.randrange(10) < marks:
            return draw.choice(MARKS)
        if marks == 4 and draw.random() < 0.2:
            return f"[{draw.choice('+-')} {self._word(3)} {self._word(0)}]"
        name, parameter = draw.choice(SYMBOLS)
        return f"{name}({self.values.whole(0, 6, names)})" if parameter else name

    @staticmethod
    def _names(parameter: str) -> tuple[Value, ...]:
        return (Value(parameter, 0, 9),) if parameter else ()


def _always(head: str) -> int:
    """How surely a rule is taken; those that surely are stand last."""
    return 0 if ":" in head else 3 - head.count("<") - head.count(">")
