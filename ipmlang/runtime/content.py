"""What a body says, whatever numbers its symbols, assets and tables have in their program.

In go the setting of a run and a body, out come a key that is equal for bodies whose source is the
same, and the names by which that source speaks of what is numbered. An edit shifts numbers and
changes few bodies, and in many that it changes sizes and places alone, which have names, too: what
was written for one program serves the next. Nothing is written here.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Hashable, Sequence
from dataclasses import replace
from itertools import count
from threading import Lock
from types import CodeType
from typing import TypeAlias, TypeGuard

from ipmlang.compiler import ir
from ipmlang.runtime.naming import Setting, length_name
from ipmlang.runtime.runs import Run, Runs, Standing, runs_name

Content: TypeAlias = tuple[Hashable, ...]
LENGTH = ("length",)  # in place of a number that has a name
NAMING = frozenset({"const", "module", "attr", "emit", "row", "pen"})
MOST = 20_000  # instructions of all the bodies that are kept: some 20 MB


class Numbered:
    """The names of the symbols, assets and tables of one body, in the order it names them."""

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._symbols: dict[int, str] = {}
        self._assets: dict[int, str] = {}
        self._tables: dict[int, str] = {}
        self._runs: dict[int, Sequence[Run]] = {}
        self.lengths: list[float] = []  # the constants and attributes of a body that have names
        self.size = 0  # instructions seen so far

    def symbol(self, number: int) -> str:
        """What source calls a symbol."""
        return self._symbols.setdefault(number, f"symbol{len(self._symbols)}")

    def asset(self, number: int) -> str:
        """What source calls an asset; what is none, and below 0, is the same in all programs."""
        if number < 0:
            return str(number)
        return self._assets.setdefault(number, f"asset{len(self._assets)}")

    def table(self, number: int) -> str:
        """What source calls the columns of a table."""
        return self._tables.setdefault(number, f"table{len(self._tables)}")

    def space(self) -> dict[str, object]:
        """What the names stand for in this program."""
        tables = self._setting.data.tables
        runs = {number: Standing(each, tables) for number, each in self._runs.items()}
        return {
            **{runs_name(number): standing for number, standing in runs.items()},
            **{name: number for number, name in self._symbols.items()},
            **{name: number for number, name in self._assets.items()},
            **{
                name: tables[number] if number >= 0 else runs[number].columns
                for number, name in self._tables.items()
            },
            **{length_name(place): value for place, value in enumerate(self.lengths)},
        }

    def content(self, code: Sequence[ir.Instruction], apart: bool = False) -> Content:
        """All that the source of code depends on, but for what is the same in a whole run; `apart`:
        its lengths have names, as in what `named` makes of it.
        """
        self.size += len(code)
        found: list[Content] = []
        for each in code:
            const: Hashable = each.const
            if isinstance(each, Runs):
                self._runs[each.table] = each.runs
            if each.op in NAMING or not (const is None or isinstance(const, str)):
                const = self._const(each, apart)
            op = "runs" if isinstance(each, Runs) else each.op
            own = (op, each.out, each.args, const, each.site)
            found.append((*own, self.content(each.body, apart)) if each.body else own)
        return tuple(found)

    def _const(self, each: ir.Instruction, apart: bool) -> Hashable:
        """What an instruction has beside its registers; numbers by their bits: 0 is not -0."""
        const = each.const
        match each.op:
            case "const" if apart and is_length(const):
                self.lengths.append(const)
                return LENGTH
            case "module":
                assert isinstance(const, int)
                return self._named(const)
            case "attr" if apart and is_length(value := self._attr(each)):
                self.lengths.append(value)
                return LENGTH
            case "attr":
                return repr(self._attr(each))
            case "emit":
                assert isinstance(const, int)
                return self.asset(const)
            case "row":
                assert isinstance(const, tuple)
                return self.table(const[0]), const[1]  # type: ignore[arg-type]
            case "pen":
                assert isinstance(const, tuple)
                text = const[1]
                if each.args or text is None:
                    return const
                return const, self._setting.program.strings.index(str(text))
            case _:
                return repr(const)

    def _attr(self, each: ir.Instruction) -> float:
        return self._setting.attrs[int(str(each.const))]

    def named(self, code: Sequence[ir.Instruction], first: int) -> tuple[ir.Instruction, ...]:
        """Code whose lengths are parameters, the first of that number, in the order of the code."""
        places = count(first)

        def inner(body: Sequence[ir.Instruction]) -> tuple[ir.Instruction, ...]:
            return tuple(
                ir.Instruction("param", each.out, const=next(places))
                if self._is_named(each)
                else replace(each, body=inner(each.body)) if each.body else each
                for each in body
            )  # fmt: skip

        return inner(code)

    def _is_named(self, each: ir.Instruction) -> bool:
        if each.op == "attr":
            return is_length(self._attr(each))
        return each.op == "const" and is_length(each.const)

    def _named(self, number: int) -> Content:
        """The symbol of a module; what it does where that is written out, told once."""
        known = number in self._symbols
        name = self.symbol(number)
        return (name,) if known else (name, self.meaning(number))

    def meaning(self, number: int) -> Content:
        """What source says of a symbol: of one that expands nothing but its name."""
        symbol = self._setting.program.symbols[number]
        if symbol.productions or symbol.interpretation:
            return ()
        return (symbol.name, symbol.arity, self.content(symbol.meaning or ()))


def is_length(const: ir.Const) -> TypeGuard[float]:
    """Whether a constant is no whole number: what source makes of it does not depend on its value,
    and it is no number of a text or an asset.
    """
    return isinstance(const, float) and math.isfinite(const) and not const.is_integer()


class Kept:
    """Compiled bodies by what they say, those used last; large ones push out many."""

    def __init__(self, most: int = MOST) -> None:
        self._most = most
        self._total = 0
        self._lock = Lock()
        self._found: OrderedDict[Content, tuple[int, CodeType]] = OrderedDict()

    def get(self, content: Content) -> CodeType | None:
        """The code of a body, None if it is not known."""
        with self._lock:
            found = self._found.get(content)
            if found is None:
                return None
            self._found.move_to_end(content)
            return found[1]

    def keep(self, content: Content, size: int, code: CodeType) -> None:
        """Note the code of a body of so many instructions."""
        with self._lock:
            if size > self._most or content in self._found:
                return
            self._found[content] = (size, code)
            self._total += size
            while self._total > self._most:
                self._total -= self._found.popitem(last=False)[1][0]


KEPT = Kept()
