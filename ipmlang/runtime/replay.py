"""Draws of productions that are known beforehand, or noted while they are made.

In go the batches of modules that choose, with their places in the string; out comes what each
takes. `Replay` follows the text after `start … choices`, `Recording` writes such a text of what a
seed draws. Both work on strings, generation by generation; nothing here rewrites.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, fail, nearest
from ipmlang.runtime.choices import Decisions, Lazy, encode, read
from ipmlang.runtime.choose import Choice, Match, Taken, module, told
from ipmlang.runtime.scan import Whole
from ipmlang.runtime.values import Batch, Flags

Chosen = tuple[list[Taken], Whole]
NOTHING = -1


class Deciding(Choice):
    """A choice that knows which modules drew, and can be told what they take instead."""

    def __init__(self, batch: Batch, numbers: Sequence[int], match: Match | None) -> None:
        super().__init__(batch, numbers, match)
        self._drawing = [number for number, each in self._productions if each.chance is not None]
        self._drew = np.zeros(batch.count, np.bool_)
        self._closing = np.full(batch.count, NOTHING, np.int64)  # what is taken if no draw hits

    def _try(self, number: int, production: ir.Production) -> None:
        super()._try(number, production)
        rows = self._tried[number].rows
        if production.chance is not None:
            self._drew[rows] = True
        else:
            self._closing[rows[self._closing[rows] == NOTHING]] = number

    def drew(self, place: Whole) -> Whole:
        """The rows that drew, from left to right."""
        rows = np.flatnonzero(self._drew)
        return rows[np.argsort(place[rows], kind="stable")]

    def decisions(self, rows: Whole) -> Whole:
        """The number of what each of these rows took among the productions with a chance."""
        found = np.full(len(rows), len(self._drawing), np.int64)
        for place, number in enumerate(self._drawing):
            found[self._taken[rows] == number] = place
        return found

    def decide(self, rows: Whole, decisions: Whole) -> Whole:
        """Let these rows take what was decided; those among them that cannot, (m,)."""
        refused = np.zeros(len(rows), np.bool_)
        for place, number in enumerate(self._drawing):
            wanted = decisions == place
            fits = wanted & self._may(number)[rows]
            refused |= wanted & ~fits
            self._taken[rows[fits]] = number
        rest = decisions == len(self._drawing)
        self._taken[rows[rest]] = self._closing[rows[rest]]
        return rows[refused]

    def module(self, symbol: int, row: int) -> str:
        """One of the modules as its grammar would write it."""
        return module(self._batch, symbol, row)

    def _may(self, number: int) -> Flags:
        """For which rows a production's context and guard hold."""
        may = np.zeros(self._batch.count, np.bool_)
        if number in self._tried:
            may[self._tried[number].rows] = True
        return may


class Recording:
    """Draws as ever, and notes them."""

    def __init__(self, program: ir.Program) -> None:
        self._names = names_of(program)
        self._program = program
        self._taken: dict[str, list[int]] = {}

    def choose(
        self, batch: Batch, numbers: tuple[int, ...], match: Match | None, place: Whole
    ) -> Chosen:
        """What a batch takes, whose modules stand at some places of the string."""
        if numbers not in self._names:
            return Choice(batch, numbers, match).walk()
        choice = Deciding(batch, numbers, match)
        choice.draw()
        found = choice.decisions(choice.drew(place)).tolist()
        self._taken.setdefault(self._names[numbers], []).extend(found)
        return choice.result()

    def restart(self) -> None:
        """The derivation begins again."""
        self._taken.clear()

    def finish(self) -> None:
        """The derivation is done."""

    def text(self) -> str:
        """What `choices` says to draw the same again."""
        counts = {name: _chances(self._program, numbers) for numbers, name in self._names.items()}
        return encode(Decisions(name, counts[name], own) for name, own in self._taken.items())


class Replay:
    """Draws what a text says; symbols that it does not name draw from the seed.

    `strict`: the text must be of as many decisions as there are. Else, for users who set attributes
    of their own, it holds as far as it goes and fits, and the seed draws the rest.
    """

    def __init__(self, program: ir.Program, text: str, *, strict: bool) -> None:
        self._program = program
        self._strict = strict
        self._names = names_of(program)
        try:
            self._parts = read(text)
            self._check()
        except IpmError as error:
            raise self._at_start(error) from error
        self._waiting: dict[str, Lazy] = {}
        self.restart()

    def restart(self) -> None:
        """The derivation begins, or begins again."""
        counts = {name: _chances(self._program, own) for own, name in self._names.items()}
        self._waiting = {each.symbol: Lazy(each, counts[each.symbol]) for each in self._parts}

    def choose(
        self, batch: Batch, numbers: tuple[int, ...], match: Match | None, place: Whole
    ) -> Chosen:
        """What a batch takes, whose modules stand at some places of the string."""
        waiting = self._waiting.get(self._names.get(numbers, ""))
        if waiting is None:
            return Choice(batch, numbers, match).walk()
        choice = Deciding(batch, numbers, match)
        choice.draw()
        self._follow(choice, waiting, choice.drew(place), numbers[0])
        return choice.result()

    def finish(self) -> None:
        """The derivation is done: a text that holds more is of another grammar."""
        for each in self._waiting.values() if self._strict else ():
            try:
                each.finish()
            except IpmError as error:
                raise self._at_start(error) from error

    def _follow(self, choice: Deciding, waiting: Lazy, rows: Whole, first: int) -> None:
        decisions = np.array(waiting.take(len(rows)), np.int64)
        if len(decisions) < len(rows) and self._strict:
            raise self._at_start(waiting.short())
        refused = choice.decide(rows[: len(decisions)], decisions)
        if len(refused) and self._strict:
            symbol = self._program.productions[first].symbol
            raise self._at_start(
                fail(
                    "bad-choices",
                    f"the choices of `{waiting.symbol}` take a production of "
                    f"{choice.module(symbol, int(refused[0]))} whose condition is false",
                    hint="the grammar was changed since they were written: run it with --seed",
                )
            )

    def _check(self) -> None:
        known = list(self._names.values())
        for each in self._parts:
            if each.symbol not in known:
                message = f"`choices` names `{each.symbol}`, which draws no production"
                suggestions = nearest(each.symbol, known)
                raise IpmError([Diagnostic("bad-choices", message, suggestions=suggestions)])

    def _at_start(self, error: IpmError) -> IpmError:
        """An error with the place of the `start`."""
        (found,) = error.diagnostics
        place = told(self._program, self._program.axiom)
        return IpmError([replace(found, message=f"{place}: {found.message}")])


def names_of(program: ir.Program) -> Mapping[tuple[int, ...], str]:
    """What each set of alternatives that draws is called: by its symbol, with the number of its
    parameters where symbols of one name draw, and `interpret-` before it for its `interpret` rules.
    """
    found = list(_drawing(program))
    plain = [name for _, name, _ in found]
    full = [name if plain.count(name) == 1 else f"{name}/{arity}" for _, name, arity in found]
    # rules of one name and arity from several imported files are numbered as they are reached
    names = [
        name if full.count(name) == 1 else f"{name}/{full[:place].count(name)}"
        for place, name in enumerate(full)
    ]
    return {numbers: name for (numbers, _, _), name in zip(found, names, strict=True)}


def _drawing(program: ir.Program) -> Iterator[tuple[tuple[int, ...], str, int]]:
    for symbol in program.symbols:
        for numbers, prefix in ((symbol.productions, ""), (symbol.interpretation, "interpret-")):
            if _chances(program, numbers):
                yield numbers, prefix + symbol.name, symbol.arity - symbol.carried


def _chances(program: ir.Program, numbers: Sequence[int]) -> int:
    """How many of these productions have a percentage or a weight."""
    return sum(program.productions[number].chance is not None for number in numbers)
