"""Which rules of a program ask how large their scope is: those fill whatever scope they get.

In goes a program, out come answers for its bodies and symbols. Nothing is derived.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ipmlang.compiler import ir


@dataclass(slots=True, eq=False)
class Asking:
    """The answers of one program."""

    program: ir.Program
    _known: dict[int, bool] = field(default_factory=dict)

    def symbol_asks(self, symbol: int) -> bool:
        if symbol not in self._known:
            self._known[symbol] = False  # while a recursive rule is looked at
            program = self.program
            self._known[symbol] = any(
                self.body_asks(program.productions[number].body)
                for number in program.symbols[symbol].productions
            )
        return self._known[symbol]

    def body_asks(self, body: tuple[ir.Instruction, ...], sized: bool = False) -> bool:
        """Whether a body asks how large its scope is before it says so."""
        saved: list[bool] = []
        for each in body:
            if each.op == "open":
                saved.append(sized)
            elif each.op == "close":
                sized = saved.pop()
            elif each.op == "module":
                assert isinstance(each.const, int)
                if not sized and self._module_asks(each.const):
                    return True
                steps = self.program.symbols[each.const].meaning or ()
                sized = sized or any(step.op == "resize" for step in steps)
            elif not sized and (
                each.op in ("slab", "pieces", "snapped", "measure")
                or (each.op == "state" and each.const in ("sx", "sy", "sz"))
                or (each.op == "repeat" and self.body_asks(each.body))
            ):
                return True
        return False

    def _module_asks(self, number: int) -> bool:
        """Whether a module takes the scope that it is given for its own."""
        symbol = self.program.symbols[number]
        ops = {step.op: step.const for step in symbol.meaning or ()}
        if "resize" in ops:
            return False
        drawn = ops.get("emit", 0) == -1 or "solid" in ops
        return drawn or (bool(symbol.productions) and self.symbol_asks(number))
