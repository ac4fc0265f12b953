"""From simplified rules to a syntax tree: the grammar that a person would have written.

Takes a book of rules with the observation behind it; gives the tree and what the parts file has to
hold. Numbers get as many digits as they need and no more. Nothing here decides which rules exist.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.boards import Printed, printed_block
from ipmlang.inverse.lattices.formula import Formula
from ipmlang.inverse.lattices.printing import PLAIN, Handles, printed, whole
from ipmlang.inverse.lsystem.frames import Frames, Row
from ipmlang.inverse.moves import around, call, even_place, placing, polar_place, turtle_step
from ipmlang.inverse.naming import Names
from ipmlang.inverse.numbers import ROOM, linear, number, settled, shortest
from ipmlang.inverse.reach import Reach
from ipmlang.inverse.recursion import branching_rules
from ipmlang.inverse.score import TABLE_ROWS
from ipmlang.inverse.simplify import AXIOM, Body, Book, Loop
from ipmlang.inverse.tapers import Taper, taper_at
from ipmlang.inverse.wording import Wording, arrangement, plain_row, worded, worded_lattice

LABELS = ("x", "y", "angle", "scale")
VARIABLES = ("i", "j", "k")  # of sequences in sequences
LIFTED = 4  # of how many sequences the counts and steps become attributes,
LEAST_LIFTED = 4  # copies that are worth an attribute
ATTRIBUTES = 6  # as long as there are no more than these


@dataclass(frozen=True, slots=True)
class Painted:
    """A terminal that differs from another, its base, in these declarations only."""

    base: int
    css: str


@dataclass(eq=False)
class Builder:
    """Prints one book. names: of every terminal, group and family; effects: the reference of each
    group's effect; axiom: the name of the start rule; painted: terminals that are drawn by another
    one's asset.
    """

    book: Book
    reach: Reach
    names: dict[int, str]
    effects: Mapping[int, str]
    given: Names
    axiom: str
    painted: Mapping[int, Painted] = field(default_factory=dict)
    use_tables: bool = True

    attributes: list[ast.Attr] = field(default_factory=list)
    tables: list[ast.Table] = field(default_factory=list)
    boards: list[Printed] = field(default_factory=list)
    _inlined: set[int] = field(default_factory=set)
    _nested: set[int] = field(default_factory=set)
    _counts: dict[int, str] = field(default_factory=dict)
    _steps: dict[int, str] = field(default_factory=dict)

    def rules(self) -> list[ast.Rule]:
        """All rules, from the axiom downwards."""
        self._inlined = self.book.inlined()
        self._nested = self.nested()
        self._lift()
        body = tuple(self._body(AXIOM)) or (ast.Module("nil"),)
        made = [ast.Rule(ast.Head(self.axiom), body)]
        for rule in self._order()[1:]:
            if rule in self._inlined or rule in self._nested:
                continue
            if rule in self.book.lattices:
                made.append(self._lattice_rule(rule))
            elif rule in self.book.trees:
                made += self._tree_rules(rule)
            elif rule in self.book.loops:
                made.append(self._loop_rule(rule))
            else:
                made.append(ast.Rule(ast.Head(self.names[rule]), tuple(self._body(rule))))
        return [*made, *(rule for board in self.boards for rule in board.rules)]

    def _body(self, rule: int) -> Iterator[ast.Element]:
        """What a group's rule says; a group under an effect brings its own bracket."""
        if rule in self.effects:
            yield ast.Bracket(self._wrapped(rule))
            return
        body = self.book.bodies[rule]
        yield from self._run(rule, body.parts.tolist(), body.places)

    def _wrapped(self, rule: int) -> tuple[ast.Element, ...]:
        """`effect("x.parts.svg#clip") A B`, for a bracket."""
        body = self.book.bodies[rule]
        pen = call("effect", ast.Text(self.effects[rule]))
        return (pen, *self._run(rule, body.parts.tolist(), body.places))

    def _order(self) -> list[int]:
        """Rules by their distance from the axiom, in the order of their first use."""
        order, known, rules = [AXIOM], {AXIOM}, set(self.book.rules())
        for rule in order:
            for part in self._named_in(rule):
                if part not in known and part in rules:
                    known.add(part)
                    order.append(part)
        return order

    def _named_in(self, rule: int) -> list[int]:
        family = self.book.family
        if rule not in self.book.bodies:
            part = self.book.repeats()[rule]
            return [family.get(part, part)]
        parts = self.book.bodies[rule].parts.tolist()
        return list(dict.fromkeys(family.get(part, part) for part in parts))

    # ---------------------------------------------------------------- placements

    def placed(self, rule: int, part: int, place: Row, alone: bool) -> Iterator[ast.Element]:
        """`[at(x, y, angle, scale) mirror A]`, without what is not needed."""
        moves = self._moves(rule, part, place)
        if part in self._inlined:
            yield ast.Bracket((*moves, *self._wrapped(part)))
            return
        if part in self.painted and self.painted[part].css:
            moves = (*moves, call("css", ast.Text(self.painted[part].css)))
        if moves or not (alone or self._stays(part)):
            yield ast.Bracket((*moves, self._module(part)))
        else:
            yield self._module(part)

    def _stays(self, part: int) -> bool:
        """Whether a symbol leaves the turtle where it was: assets and groups do, loops may not."""
        return part not in self.book.family

    def _asset(self, part: int) -> int:
        """The terminal whose asset draws a symbol, the symbol itself if it is none."""
        return self.painted[part].base if part in self.painted else part

    def _module(self, part: int) -> ast.Module:
        part = self._asset(part)
        if part in self.book.trees:
            depth = ast.Number(float(self.book.trees[part].branching.depth))
            return ast.Module(self.names[part], (ast.Argument(depth),))
        family = self.book.family.get(part, part)
        if part in self.book.family and self._parametric(family):
            count = ast.Argument(ast.Number(float(self.book.count[part])))
            return ast.Module(self.names[family], (count,))
        return ast.Module(self.names[family])

    def _moves(self, rule: int, part: int, place: Row) -> tuple[ast.Element, ...]:
        return placing(place, self._errors(rule, part, place[3]))

    def _errors(self, rule: int, part: int, scale: float) -> tuple[float, float, float]:
        """What positions, angles and factors of a place may be off."""
        size = self.reach.error / max(self.reach.gain.get(rule, 1.0), 1e-12)
        arm = max(self.reach.radius[part], size)
        return size, min(1e-4, math.degrees(size / (scale * arm))), min(1e-6, size / arm)

    # ---------------------------------------------------------------------- runs

    def _run(self, rule: int, parts: list[int], places: Frames) -> Iterator[ast.Element]:
        """Placements in paint order, long runs of one symbol as tables."""
        start, alone = 0, len(parts) == 1
        body, rows = Body(np.array(parts, np.int64), places), places.rows()
        while start < len(parts):
            if rule == AXIOM and start in self.book.boards:
                yield self._board(start)
                start = self.book.boards[start].stop
                continue
            taper = taper_at(self.book, body, start, 30 * self.book.small)
            if taper is not None:
                yield self._tapered(rule, parts[start : start + taper.rows], taper)
                start += taper.rows
                continue
            end = start + 1
            asset, hand = self._asset(parts[start]), rows[start][4]
            while end < len(parts) and self._asset(parts[end]) == asset:
                if rows[end][4] != hand or (rule == AXIOM and end in self.book.boards):
                    break
                end += 1
            if self.use_tables and end - start >= TABLE_ROWS:
                yield self._table(rule, parts[start:end], places[start:end])
            else:
                for row in range(start, end):
                    yield from self.placed(rule, parts[row], rows[row], alone)
            start = end

    def _board(self, start: int) -> ast.Element:
        block, error = self.book.boards[start], self.reach.error
        self.boards.append(printed_block(block, self.names, self.given, error, self.boards))
        return self.boards[-1].loop

    def _tapered(self, rule: int, parts: list[int], taper: Taper) -> ast.Element:
        """`repeat(i < 9) { [at(11 + 14 * i, 11 + 12 * i) Row(20 - 2 * i)] }`"""
        errors = self._errors(rule, parts[0], float(taper.at(0).scale[0]))
        x, y, angle, scale = (
            linear(first, step, VARIABLES[0], (error, error / taper.rows))
            for first, step, error in zip(
                taper.first, taper.step, (errors[0], *errors), strict=True
            )
        )
        turned, scaled = angle != ast.Number(0.0), scale != ast.Number(1.0)
        more = [angle] * (turned or scaled) + [scale] * scaled
        mirror = [ast.Module("mirror")] * (taper.handedness < 0)
        count = linear(float(taper.count), float(taper.slope), VARIABLES[0], (0.0, 0.0))
        row = ast.Module(self._module(parts[0]).name, (ast.Argument(count),))
        body = ast.Bracket((call("at", x, y, *more), *mirror, row))
        return ast.Repeat(ast.Count(VARIABLES[0], number(float(taper.rows))), (body,))

    def _table(self, rule: int, parts: list[int], places: Frames) -> ast.Element:
        """`repeat(r in T) { [at(r.x, r.y) A] }`."""
        rounded = self._rounded(rule, parts[0], places)
        name = self.given.give("Places")
        last = 3 if set(rounded[3]) != {1.0} else 2 if set(rounded[2]) != {0.0} else 1
        varying = [len(set(column)) > 1 for column in rounded]
        columns = [LABELS[k] for k in range(4) if varying[k]]
        cells: list[list[ast.Expr]] = [
            [number(value) for value in rounded[k]] for k in range(4) if varying[k]
        ]
        arguments = [
            ast.Name(f"r.{LABELS[k]}") if varying[k] else number(rounded[k][0])
            for k in range(last + 1)
        ]
        place: list[ast.Element] = [call("at", *arguments)]
        if places.handedness[0] < 0:
            place.append(ast.Module("mirror"))
        if parts[0] in self.painted:
            columns.append("css")
            cells.append([ast.Text(self.painted[part].css) for part in parts])
            place.append(call("css", ast.Name("r.css")))
        rows = tuple(zip(*cells, strict=True))
        self.tables.append(ast.Table(name, None, tuple(columns), rows))
        return ast.Repeat(ast.Rows("r", name), (ast.Bracket((*place, self._module(parts[0]))),))

    def _rounded(self, rule: int, part: int, places: Frames) -> list[list[float]]:
        """x, y, angle and scale of many places as short numbers."""
        size, turn, factor = self._errors(rule, part, float(places.scale.max()))
        return [
            [shortest(float(value), error) for value in column]
            for column, error in zip(
                (places.x, places.y, places.angle, places.scale),
                (size, size, turn, factor),
                strict=True,
            )
        ]

    # --------------------------------------------------------------------- trees

    def _tree_rules(self, rule: int) -> tuple[ast.Rule, ...]:
        """`R(m) : m > 0 --> A [+(17) f(64) R(m - 1)] …`"""
        tree = self.book.trees[rule]
        node: ast.Element = self._module(tree.part)
        if not self._stays(tree.part):
            node = ast.Bracket((node,))
        return branching_rules(tree.branching, self.names[rule], (node,))

    def _lattice_rule(self, symbol: int) -> ast.Rule:
        rule = self.book.lattices[symbol]
        node: ast.Element = self._module(rule.part)
        if not self._stays(rule.part):
            node = ast.Bracket((node,))
        scale = float(rule.formula.frames().scale.max())
        errors = self._errors(symbol, rule.part, scale)
        handles = self._handles(symbol, rule.formula) if whole(rule) else PLAIN
        name = self.given.give("Rest")
        loop, table = printed(rule, (node,), errors, name, handles)
        if table is not None:
            self.tables.append(table)
        return ast.Rule(ast.Head(self.names[symbol]), (loop,))

    # --------------------------------------------------------------------- loops

    def _parametric(self, family: int) -> bool:
        return len(self._sizes(family)) > 1

    def _sizes(self, family: int) -> list[int]:
        """The counts with which a sequence is used."""
        return self._used_counts.get(family, [])

    @cached_property
    def _used_counts(self) -> dict[int, list[int]]:
        """The same of every family; nothing in the book changes while it is printed."""
        parts = {part for body in self.book.bodies.values() for part in body.parts.tolist()}
        counts: dict[int, set[int]] = {}
        for part in parts | set(self.book.repeated()):
            if part in self.book.family:
                counts.setdefault(self.book.family[part], set()).add(self.book.count[part])
        return {family: sorted(own) for family, own in counts.items()}

    def _loop_rule(self, family: int) -> ast.Rule:
        parameters = (ast.Parameter("n"),) if self._parametric(family) else ()
        return ast.Rule(
            ast.Head(self.names[family], parameters), (self._loop(family, VARIABLES[0]),)
        )

    def _loop(self, family: int, variable: str) -> ast.Repeat:
        """`repeat(i < n) { … }`."""
        loop, sizes = self.book.loops[family], self._sizes(family)
        limit: ast.Expr = number(float(sizes[-1]))
        if self._parametric(family):
            limit = ast.Name("n")
        elif family in self._counts:
            limit = ast.Name(self._counts[family])
        body = self._loop_body(family, loop, sizes, limit, variable)
        steps = tuple(number(each, self._step_error(family, loop)) for each in loop.pattern.steps)
        return ast.Repeat(ast.Count(variable, limit), body, steps=steps)

    def nested(self) -> set[int]:
        """Sequences that only one other sequence repeats: a row of rows is one rule."""
        used = self.book.uses()
        families = {
            self.book.family[loop.part]
            for loop in self.book.loops.values()
            if loop.part in self.book.family
        }
        plain = {family for family in families if used[family] == 1}
        plain = {family for family in plain if not self._parametric(family)}
        return {family for family in plain if self._depth(family, plain) < len(VARIABLES)}

    def _depth(self, family: int, plain: set[int]) -> int:
        """How many sequences a sequence stands in, if all of them are written in one."""
        for outer, loop in self.book.loops.items():
            if self.book.family.get(loop.part) == family:
                return 1 + (self._depth(outer, plain) if outer in plain else 0)
        return 0

    def _step_error(self, family: int, loop: Loop) -> float:
        return self._errors(family, loop.part, 1.0)[0] / max(1, len(loop.pattern.steps))

    def _loop_body(
        self, family: int, loop: Loop, sizes: Sequence[int], limit: ast.Expr, variable: str
    ) -> tuple[ast.Element, ...]:
        pattern = loop.pattern
        if pattern.kind == "polar":
            return (self._polar_copy(family, loop, sizes, limit, variable),)
        if pattern.kind == "listed":
            return (ast.Bracket(self._copy(family, loop, variable)),)
        if pattern.kind == "even":
            return self._even_copy(family, loop, sizes, limit, variable)
        error, radius = self._errors(family, loop.part, 1.0)[0], self.reach.radius[loop.part]
        step = turtle_step(pattern, sizes[-1], error, radius, variable)
        return (ast.Bracket(self._copy(family, loop, variable)), *step)

    def _copy(self, family: int, loop: Loop, variable: str) -> tuple[ast.Element, ...]:
        """What is repeated, in the frame that the pattern gives it."""
        moves = self._moves(family, loop.part, loop.pattern.inside.rows()[0])
        inner = self.book.family.get(loop.part)
        if inner is not None and inner in self._nested:
            return (*moves, self._loop(inner, VARIABLES[VARIABLES.index(variable) + 1]))
        return (*moves, self._module(loop.part))

    def _polar_copy(
        self, family: int, loop: Loop, sizes: Sequence[int], limit: ast.Expr, variable: str
    ) -> ast.Element:
        """`[+(360 / n * i) f(r) A]`."""
        count, turn = sizes[-1], loop.pattern.base[0]
        errors = self._errors(family, loop.part, 1.0)
        arm = float(np.abs(loop.pattern.radii(np.arange(count, dtype=np.float64))).max())
        arm = max(arm + self.reach.radius[loop.part], errors[0])
        error = min(1e-4, float(np.rad2deg(errors[0] / arm))) / count
        about = around(turn, error, count, limit if len(sizes) == 1 else None, variable)
        place = polar_place(loop.pattern, count, errors, about, variable)
        return ast.Bracket((*place, *self._copy(family, loop, variable)))

    def _even_copy(
        self, family: int, loop: Loop, sizes: Sequence[int], limit: ast.Expr, variable: str
    ) -> tuple[ast.Element, ...]:
        count, (x, y, angle, growth) = sizes[-1], loop.pattern.base
        errors = self._errors(family, loop.part, 1.0)
        size, turn, factor = (error / count for error in errors)
        copy = self._copy(family, loop, variable)
        if arrangement(loop.pattern) == "stack" and abs(angle) > turn and abs(growth) <= factor:
            about = around(angle, turn, count, limit if len(sizes) == 1 else None, variable)
            return (ast.Bracket((call("+", about), *copy)),)
        if abs(angle) > turn or abs(growth) > factor or not loop.pattern.constant:
            place = even_place(loop.pattern, count, errors, variable)
            return (ast.Bracket((*place, *copy)),)
        if abs(x) <= size and abs(y) <= size:
            return (ast.Bracket(copy),)
        return (ast.Bracket(copy), self._straight(family, x, y, size))

    def _straight(self, family: int, x: float, y: float, error: float) -> ast.Element:
        """The step of a row: ahead where it can be."""
        if abs(y) <= ROOM * error:
            if family in self._steps:
                return call("f", ast.Name(self._steps[family]))
            return call("f", number(x, error))
        if abs(x) <= ROOM * error and family in self._steps:
            step: ast.Expr = ast.Name(self._steps[family])
            return call("at", ast.Number(0.0), step)
        return call("at", number(settled(x, error)), number(y, error))

    # ---------------------------------------------------------------- attributes

    def _handles(self, symbol: int, formula: Formula) -> Handles:
        """Attributes for the counts and steps of a lattice, as many as there is room for."""
        part = self.names[self.book.lattices[symbol].part]
        kind = "ring" if formula.polar is not None else formula.line
        said = worded_lattice(self.names[symbol], part, kind, bool(formula.across))
        made: list[ast.Expr | None] = []
        counts = (formula.length, formula.count // formula.length)
        for wording, count in zip(said, counts, strict=True):
            made.append(self._counted(wording, count) if count >= LEAST_LIFTED else None)
        for wording, step in zip(said, formula.steps, strict=True):
            made.append(self._stepped(wording, step) if step else None)
        return Handles(*made)

    def _counted(self, said: Wording, count: int) -> ast.Expr | None:
        if len(self.attributes) >= ATTRIBUTES:
            return None
        name = self.given.give(said.count)
        span = ast.Range(ast.Number(1.0), None)
        self.attributes.append(ast.Attr(name, "int", ast.Number(float(count)), span, said.counted))
        return ast.Name(name)

    def _stepped(self, said: Wording, step: float) -> ast.Expr | None:
        if len(self.attributes) >= ATTRIBUTES:
            return None
        name = self.given.give(said.step)
        self.attributes.append(ast.Attr(name, "float", number(step), None, said.stepped))
        return ast.Name(name)

    def _lift(self) -> None:
        """Counts and steps of the sequences that draw most become attributes."""
        used = self.book.uses()
        sizes = {family: self._sizes(family) for family in self.book.loops}
        plain = [
            family
            for family, counts in sizes.items()
            if len(counts) == 1
            and counts[0] >= LEAST_LIFTED
            and not self.book.loops[family].pattern.steps
        ]
        weight = {family: int(self._drawn(family)) * used[family] for family in plain}
        for family in sorted(plain, key=lambda f: (-weight[f], f))[:LIFTED]:
            said = worded(self.book, self.names, self._nested, family)
            if len(self.attributes) < ATTRIBUTES:
                name = self._counts[family] = self.given.give(said.count)
                count, least = ast.Number(float(sizes[family][0])), ast.Number(1.0)
                attribute = ast.Attr(name, "int", count, ast.Range(least, None), said.counted)
                self.attributes.append(attribute)
            if len(self.attributes) < ATTRIBUTES:
                self._lift_step(family, said)

    def _lift_step(self, family: int, said: Wording) -> None:
        loop, count = self.book.loops[family], self._sizes(family)[0]
        x, y, _, _ = loop.pattern.base
        if not plain_row(loop.pattern):
            return
        size = self._errors(family, loop.part, 1.0)[0] / count
        room = ROOM * size
        step = x if abs(y) <= room else y if abs(x) <= room else 0.0
        if abs(step) <= size:
            return
        name = self._steps[family] = self.given.give(said.step)
        self.attributes.append(ast.Attr(name, "float", number(step, size), None, said.stepped))

    def _drawn(self, family: int) -> int:
        return sum(
            int(self.book.size[part]) for part, own in self.book.family.items() if own == family
        )
