"""From simplified rules to a syntax tree: the grammar that a person would have written.

Takes a book of rules with the observation behind it; gives the tree and what the parts file has to
hold. Numbers get as many digits as they need and no more. Nothing here decides which rules exist.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.lsystem.frames import Frames
from ipmlang.inverse.moves import call, even_place, turns, turtle_step
from ipmlang.inverse.naming import Names
from ipmlang.inverse.numbers import ROOM, number, settled, shortest
from ipmlang.inverse.reach import Reach
from ipmlang.inverse.score import SMALL
from ipmlang.inverse.simplify import AXIOM, Book, Loop, ring_centre

LABELS = ("x", "y", "angle", "scale")
TABLE_ROWS = 8  # fewer placements of one symbol are written out
LIFTED = 4  # how many counts, and how many steps, become attributes


@dataclass(frozen=True, slots=True)
class Wrap:
    """The reference of each effect that wraps a run, outermost first."""

    references: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Painted:
    """A terminal that differs from another, its base, in these declarations only."""

    base: int
    css: str


@dataclass(slots=True, eq=False)
class Builder:
    """Prints one book. names: of every terminal, group and family; wraps: by effects number; axiom:
    the name of the start rule; painted: terminals that are drawn by another one's asset.
    """

    book: Book
    reach: Reach
    names: dict[int, str]
    wraps: Sequence[Wrap]
    given: Names
    axiom: str
    painted: Mapping[int, Painted] = field(default_factory=dict)
    use_tables: bool = True

    attributes: list[ast.Attr] = field(default_factory=list)
    tables: list[ast.Table] = field(default_factory=list)
    _counts: dict[int, str] = field(default_factory=dict)
    _steps: dict[int, str] = field(default_factory=dict)

    def rules(self) -> list[ast.Rule]:
        """All rules, from the axiom downwards."""
        self._lift()
        made = [ast.Rule(ast.Head(self.axiom), self._axiom_body())]
        for rule in self._order()[1:]:
            if rule in self.book.loops:
                made.append(self._loop_rule(rule))
            else:
                body = self.book.bodies[rule]
                elements = list(self._members(rule, body.parts.tolist(), body.places))
                made.append(ast.Rule(ast.Head(self.names[rule]), tuple(elements)))
        return made

    def _order(self) -> list[int]:
        """Rules by their distance from the axiom, in the order of their first use."""
        order, known = [AXIOM], {AXIOM}
        for rule in order:
            for part in self._named_in(rule):
                if part not in known and (part in self.book.bodies or part in self.book.loops):
                    known.add(part)
                    order.append(part)
        return order

    def _named_in(self, rule: int) -> list[int]:
        family = self.book.family
        if rule in self.book.loops:
            part = self.book.loops[rule].part
            return [family.get(part, part)]
        parts = self.book.bodies[rule].parts.tolist()
        return list(dict.fromkeys(family.get(part, part) for part in parts))

    # ---------------------------------------------------------------- placements

    def _members(self, rule: int, parts: Sequence[int], places: Frames) -> Iterator[ast.Element]:
        alone = len(parts) == 1
        for index, part in enumerate(parts):
            yield from self._placed(rule, part, places[index : index + 1], alone)

    def _placed(self, rule: int, part: int, place: Frames, alone: bool) -> Iterator[ast.Element]:
        """`[at(x, y, angle, scale) mirror A]`, without what is not needed."""
        moves = self._moves(rule, part, place)
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
        family = self.book.family.get(part, part)
        if part in self.book.family and self._parametric(family):
            count = ast.Argument(ast.Number(float(self.book.count[part])))
            return ast.Module(self.names[family], (count,))
        return ast.Module(self.names[family])

    def _moves(self, rule: int, part: int, place: Frames) -> tuple[ast.Element, ...]:
        errors = self._errors(rule, part, float(place.scale[0]))
        x, y = (settled(float(each[0]), errors[0]) for each in (place.x, place.y))
        angle = settled(float(place.angle[0]), errors[1])
        scale = settled(float(place.scale[0]), errors[2], 1.0)
        made: list[ast.Element] = []
        if x or y:
            numbers = [x, y] + ([angle] if angle or scale != 1 else [])
            numbers += [scale] if scale != 1 else []
            made.append(call("at", *(number(each) for each in numbers)))
        else:
            made += turns(angle, scale)
        if place.handedness[0] < 0:
            made.append(ast.Module("mirror"))
        return tuple(made)

    def _errors(self, rule: int, part: int, scale: float) -> tuple[float, float, float]:
        """What positions, angles and factors of a place may be off."""
        size = self.reach.error / max(self.reach.gain.get(rule, 1.0), 1e-12)
        arm = max(self.reach.radius[part], size)
        return size, min(1e-4, float(np.rad2deg(size / (scale * arm)))), min(1e-6, size / arm)

    # --------------------------------------------------------------------- axiom

    def _axiom_body(self) -> tuple[ast.Element, ...]:
        body, wrap = self.book.bodies[AXIOM], self.book.wrap
        made: list[ast.Element] = []
        edges = np.flatnonzero(np.diff(wrap)) + 1
        bounds = [0, *edges.tolist(), len(wrap)] if len(wrap) else [0]
        for start, end in pairwise(bounds):
            inner = list(self._run(body.parts[start:end].tolist(), body.places[start:end]))
            references = self.wraps[int(wrap[start])].references
            if references:
                pens = [call("effect", ast.Text(each)) for each in references]
                made.append(ast.Bracket((*pens, *inner)))
            else:
                made += inner
        return tuple(made) or (ast.Module("nil"),)

    def _run(self, parts: list[int], places: Frames) -> Iterator[ast.Element]:
        """Placements in paint order, long runs of one symbol as tables."""
        start = 0
        while start < len(parts):
            end = start + 1
            asset, hand = self._asset(parts[start]), places.handedness[start]
            while end < len(parts) and self._asset(parts[end]) == asset:
                if places.handedness[end] != hand:
                    break
                end += 1
            if self.use_tables and end - start >= TABLE_ROWS:
                yield self._table(parts[start:end], places[start:end])
            else:
                yield from self._members(AXIOM, parts[start:end], places[start:end])
            start = end

    def _table(self, parts: list[int], places: Frames) -> ast.Element:
        """`repeat(r in T) { [at(r.x, r.y) A] }`."""
        rounded = self._rounded(parts[0], places)
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

    def _rounded(self, part: int, places: Frames) -> list[list[float]]:
        """x, y, angle and scale of many places as short numbers."""
        size, turn, factor = self._errors(AXIOM, part, float(places.scale.max()))
        return [
            [shortest(float(value), error) for value in column]
            for column, error in zip(
                (places.x, places.y, places.angle, places.scale),
                (size, size, turn, factor),
                strict=True,
            )
        ]

    # --------------------------------------------------------------------- loops

    def _parametric(self, family: int) -> bool:
        return len(self._sizes(family)) > 1

    def _sizes(self, family: int) -> list[int]:
        """The counts with which a sequence is used."""
        parts = {part for body in self.book.bodies.values() for part in body.parts.tolist()}
        parts |= {loop.part for loop in self.book.loops.values()}
        own = {self.book.count[part] for part in parts if self.book.family.get(part) == family}
        return sorted(own)

    def _loop_rule(self, family: int) -> ast.Rule:
        loop = self.book.loops[family]
        sizes = self._sizes(family)
        limit: ast.Expr
        parameters: tuple[ast.Parameter, ...] = ()
        if self._parametric(family):
            limit, parameters = ast.Name("n"), (ast.Parameter("n"),)
        elif family in self._counts:
            limit = ast.Name(self._counts[family])
        else:
            limit = ast.Number(float(sizes[-1]))
        body = self._loop_body(family, loop, sizes, limit)
        head = ast.Head(self.names[family], parameters)
        steps = tuple(number(each, self._step_error(family, loop)) for each in loop.pattern.steps)
        return ast.Rule(head, (ast.Repeat(ast.Count("i", limit), body, steps=steps),))

    def _step_error(self, family: int, loop: Loop) -> float:
        return self._errors(family, loop.part, 1.0)[0] / max(1, len(loop.pattern.steps))

    def _loop_body(
        self, family: int, loop: Loop, sizes: Sequence[int], limit: ast.Expr
    ) -> tuple[ast.Element, ...]:
        pattern = loop.pattern
        if self._is_centred(loop):
            return (self._ring_copy(family, loop, sizes, limit),)
        if pattern.kind == "listed":
            angle = shortest(pattern.base[0], self._errors(family, loop.part, 1.0)[1])
            return (ast.Bracket((*turns(angle, 1.0), self._module(loop.part))),)
        if pattern.kind == "even":
            return self._even_copy(family, loop, sizes[-1])
        error, radius = self._errors(family, loop.part, 1.0)[0], self.reach.radius[loop.part]
        step = turtle_step(pattern, sizes[-1], error, radius)
        return (ast.Bracket((self._module(loop.part),)), *step)

    def _is_centred(self, loop: Loop) -> bool:
        """Whether a loop is a ring about its own origin."""
        centre = ring_centre(loop.pattern)
        if centre is None:
            return False
        # Re-centring has moved the first copy away from the origin.
        return not _is_identity(loop.where) or abs(centre) <= self.book.small

    def _ring_copy(
        self, family: int, loop: Loop, sizes: Sequence[int], limit: ast.Expr
    ) -> ast.Element:
        """`[+(360 / n * i) f(r) A]`."""
        count = sizes[-1]
        turn = loop.pattern.base[0] + loop.pattern.base[3]
        size, error, _ = self._errors(family, loop.part, 1.0)
        arm = abs(complex(loop.where.position[0])) + self.reach.radius[loop.part]
        error = min(1e-4, float(np.rad2deg(size / max(arm, size)))) / count
        closed = len(sizes) == 1 and abs(abs(turn) * count - 360) <= error * count
        angle: ast.Expr = number(turn, error)
        if closed:
            angle = ast.Binary("/", number(360.0 if turn > 0 else -360.0), limit)
        elif isinstance(limit, ast.Name) and not isinstance(angle, ast.Number | ast.Unary):
            angle = number(turn)
        around = call("+", ast.Binary("*", angle, ast.Name("i")))
        return ast.Bracket((around, *self._radial(family, loop), self._module(loop.part)))

    def _radial(self, family: int, loop: Loop) -> tuple[ast.Element, ...]:
        place = loop.where
        size, angle_error, scale_error = self._errors(family, loop.part, float(place.scale[0]))
        ahead = abs(float(place.y[0])) <= size and float(place.x[0]) > size
        if not ahead:
            return self._moves(family, loop.part, place)
        turned = turns(
            shortest(float(place.angle[0]), angle_error),
            shortest(float(place.scale[0]), scale_error),
        )
        hand = (ast.Module("mirror"),) if place.handedness[0] < 0 else ()
        return (call("f", number(float(place.x[0]), size)), *turned, *hand)

    def _even_copy(self, family: int, loop: Loop, count: int) -> tuple[ast.Element, ...]:
        x, y, angle, growth = loop.pattern.base
        errors = self._errors(family, loop.part, 1.0)
        size, turn, factor = (error / count for error in errors)
        copy = self._module(loop.part)
        if abs(angle) > turn or abs(growth) > factor:
            return (ast.Bracket((*even_place(loop.pattern, count, errors), copy)),)
        if abs(x) <= size and abs(y) <= size:
            return (ast.Bracket((copy,)),)
        return (ast.Bracket((copy,)), self._straight(family, x, y, size))

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

    def _lift(self) -> None:
        """Counts and steps of the sequences that draw most become attributes."""
        used = self.book.uses()
        sizes = {family: self._sizes(family) for family in self.book.loops}
        plain = [
            family
            for family, counts in sizes.items()
            if len(counts) == 1 and counts[0] >= 4 and not self.book.loops[family].pattern.steps
        ]
        weight = {family: int(self._drawn(family)) * used[family] for family in plain}
        for family in sorted(plain, key=lambda f: (-weight[f], f))[:LIFTED]:
            loop, count = self.book.loops[family], sizes[family][0]
            part = self.names[self.book.family.get(loop.part, loop.part)]
            stem = _lowered(self.names[family])
            self._counts[family] = self.given.give(f"{stem}_count")
            doc = f"copies of {part} in {self.names[family]}"
            self.attributes.append(
                ast.Attr(
                    self._counts[family],
                    "int",
                    ast.Number(float(count)),
                    ast.Range(ast.Number(1.0), None),
                    doc,
                )
            )
            self._lift_step(family, loop, count, f"{stem}_step", part)

    def _lift_step(self, family: int, loop: Loop, count: int, wish: str, part: str) -> None:
        x, y, angle, growth = loop.pattern.base
        if loop.pattern.kind != "even" or abs(angle) > SMALL or abs(growth) > SMALL:
            return
        size = self._errors(family, loop.part, 1.0)[0] / count
        room = ROOM * size
        step = x if abs(y) <= room else y if abs(x) <= room else 0.0
        if abs(step) <= size:
            return
        self._steps[family] = self.given.give(wish)
        doc = f"from one {part} to the next"
        self.attributes.append(
            ast.Attr(self._steps[family], "float", number(step, size), None, doc)
        )

    def _drawn(self, family: int) -> int:
        return sum(
            int(self.book.size[part]) for part, own in self.book.family.items() if own == family
        )


def _is_identity(place: Frames) -> bool:
    return bool(
        abs(place.x[0]) == 0
        and abs(place.y[0]) == 0
        and place.angle[0] == 0
        and place.scale[0] == 1
        and place.handedness[0] > 0
    )


def _lowered(name: str) -> str:
    """`LeafRow` as `leaf_row`."""
    return "".join(f"_{c.lower()}" if c.isupper() else c for c in name).strip("_")
