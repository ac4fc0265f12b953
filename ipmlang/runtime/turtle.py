"""The turtle: its frame and pen at every place of a stream of acts.

In goes a stream, out come the states that drawing acts find. Each part of the state is one scan
over the branches: scale and handedness as products, headings as sums of angles in the plane and as
products of quaternions in space, places as sums of turned moves, pens as the last that was set.
Levelling and tropism look at the heading itself and so go in lockstep. Makes no scene.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import fail
from ipmlang.runtime import scan
from ipmlang.runtime.ancestry import ModuleError
from ipmlang.runtime.bend import BEND, LEVEL, Bending
from ipmlang.runtime.branches import Branches, Path
from ipmlang.runtime.choose import told
from ipmlang.runtime.fields import first_rotation
from ipmlang.runtime.interpret import Act, Stream
from ipmlang.runtime.scan import Columns, Frames, Real, Whole
from ipmlang.runtime.values import Value


def _check_factors(program: ir.Program, act: Act) -> None:
    factors = np.broadcast_to(act.args[0], (len(act.at),))
    bad = np.flatnonzero(~(factors > 0))
    if len(bad):
        row = int(bad[0] if act.rows is None else act.rows[bad[0]])
        number = int(np.broadcast_to(act.modules.rule, (act.modules.count,))[row])
        production = program.axiom if number < 0 else program.productions[number]
        name, factor = told(program, production), factors[bad[0]]
        error = fail("out-of-range", f"{name}: `*` needs a factor above 0, and got {factor:g}")
        raise ModuleError(error, act.modules.symbol, row)


class Turtle:
    """All states of a turtle that walks a stream."""

    def __init__(self, program: ir.Program, stream: Stream) -> None:
        self._program = program
        self._branches = Branches(stream.length, stream.opens, stream.closes)
        self._stream = stream
        sized = stream.of("scale", "mirror")
        self._scale = self._sizes(sized) if sized else None
        bends = stream.of("level") or (program.tropism is not None and stream.of("segment"))
        self._planar = program.flat and not bends
        if self._planar:
            self._angle = self._sums(stream.of("rotate"), self._signed_angles)
        else:
            self._turns = Path(self._branches, [act.at for act in self._turning()])
            self._rotation = self._rotations()
        stream.drop("rotate", "orient", "level", "scale", "mirror")
        self._moving = stream.of("move", "segment")
        self._moves = Path(self._branches, [act.at for act in self._moving])
        self._position = self._positions()
        del self._moving

    def frames(self, at: Whole) -> Frames:
        """The frames that the acts at some places find (n rows)."""
        position = self._position[self._moves.before(at)]
        if self._planar:
            path, angle = self._angle
            rotation = scan.about_z(angle[path.before(at)])
            position = np.column_stack((position, np.zeros(len(at))))
        else:
            rows = self._turns.before(at)
            rotation = np.stack([column[rows] for column in self._rotation], axis=1)
        return Frames(position, rotation, self._sizes_at(at))

    def places(self, at: Whole, *, after: bool) -> Real:
        """Where the turtle stands, (n, 3), before or after the acts at some places."""
        rows = self._moves.rows(at) if after else self._moves.before(at)
        if self._planar:
            return np.column_stack((self._position[rows], np.zeros(len(at))))
        return self._position[rows]

    def layers(self, at: Whole) -> Real:
        """The paint order, (n,), at some places."""
        acts = self._stream.of("layer")
        if not acts:
            return np.zeros(len(at))
        path, total = self._sums(acts, lambda act: act.args[0])
        return total[path.rows(at)]

    def last(
        self, acts: list[tuple[Act, Value]], start: float, at: Whole, *, before: bool = False
    ) -> Real:
        """The value, (n,), that the last of some acts before each place has set; an act at the
        place itself counts unless it is `before`.
        """
        if not acts:
            return np.full(len(at), start)
        path = Path(self._branches, [act.at for act, _ in acts])
        column = np.full(path.count, start)
        for act, value in acts:
            column[path.rows(act.at)] = value
        rows = path.before(at) if before else path.rows(at)
        return path.resolve((column,), None)[0][rows]

    def _sums(self, acts: list[Act], value: Callable[[Act], Value]) -> tuple[Path, Real]:
        path = Path(self._branches, [act.at for act in acts])
        column = np.zeros(path.count)
        for act in acts:
            column[path.rows(act.at)] = value(act)
        path.resolve((column,), lambda part, rows: (scan.running_sum(part[0], rows),))
        return path, column

    def _sizes(self, acts: list[Act]) -> tuple[Path, Real]:
        path = Path(self._branches, [act.at for act in acts])
        column = np.ones(path.count)
        for act in acts:
            if act.op == "scale":
                _check_factors(self._program, act)
            column[path.rows(act.at)] = act.args[0] if act.op == "scale" else -1.0
        path.resolve((column,), lambda part, rows: (scan.running_product(part[0], rows),))
        return path, column

    def _sizes_at(self, at: Whole) -> Real:
        """The signed scale (n,) at some places."""
        if self._scale is None:
            return np.ones(len(at))
        path, column = self._scale
        return column[path.rows(at)]

    def _hand(self, act: Act) -> Real | float:
        return 1.0 if self._scale is None else np.sign(self._sizes_at(act.at))

    def _signed_angles(self, act: Act) -> Value:
        return act.args[0] * self._hand(act)

    def _turning(self) -> list[Act]:
        bent = ("segment",) if self._program.tropism is not None else ()
        return self._stream.of("rotate", "orient", "level", *bent)

    def _rotations(self) -> Columns:
        path, acts = self._turns, self._turning()
        own = tuple(np.full(path.count, 1.0 if axis == 0 else 0.0) for axis in range(4))
        kind = np.zeros(path.count)
        for act in acts:
            rows = path.rows(act.at)
            if act.op in ("level", "segment"):
                kind[rows] = LEVEL if act.op == "level" else BEND
                continue
            for column, value in zip(own, self._turn(act), strict=True):
                column[rows] = value
        for column, value in zip(own, first_rotation(self._program), strict=True):
            column[0] = value
        if not kind.any():
            path.resolve(own, lambda part, rows: scan.scan(part, rows, scan.quaternion_product))
            return scan.normalised(own)
        hand = self._hands(acts, path)
        bending = Bending(self._tropism())
        path.resolve((*own, kind, hand), lambda part, rows: scan.walked(part, rows, bending))
        return scan.normalised(own)

    def _tropism(self) -> tuple[float, float, float, float] | None:
        """The tropism in the turtle's own axes: a flat scene is mirrored at the end."""
        tropism = self._program.tropism
        if tropism is None or not (self._program.flat and self._program.abop):
            return tropism
        x, y, z, elasticity = tropism
        return x, -y, z, elasticity

    def _hands(self, acts: list[Act], path: Path) -> Real:
        hand = np.ones(path.count)
        for act in acts:
            hand[path.rows(act.at)] = self._hand(act)
        return hand

    def _turn(self, act: Act) -> tuple[Value, ...]:
        """The quaternion of a turn in the frame it acts in: mirrored frames turn about y and z the
        other way.
        """
        hand = self._hand(act)
        if act.op == "orient":
            w, x, y, z = act.args
            length = np.sqrt(np.square(w) + np.square(x) + np.square(y) + np.square(z))
            return w / length, x / length, y * hand / length, z * hand / length
        cosine, sine = scan.unit(np.atleast_1d(act.args[0]) / 2)
        match act.const:
            case "x":
                return cosine, sine, 0.0, 0.0
            case "y":
                return cosine, 0.0, sine * hand, 0.0
            case _:
                return cosine, 0.0, 0.0, sine * hand

    def _positions(self) -> Real:
        """Places after each move, (n, 2) in the plane, else (n, 3)."""
        path = self._moves
        column = np.zeros((path.count, 2 if self._planar else 3))
        for act in self._moving:
            column[path.rows(act.at)] = self._displacement(act)
        path.resolve((column,), lambda part, rows: (scan.running_sum(part[0], rows),))
        return column

    def _displacement(self, act: Act) -> Real:
        x, y, z = act.args if act.op == "move" else (act.args[0], 0.0, 0.0)
        if self._scale is not None:
            found = self._sizes_at(act.at)
            x, y, z = x * found, y * np.abs(found), z * np.abs(found)
        if self._planar:
            path, angle = self._angle
            cosine, sine = scan.unit(angle[path.rows(act.at)])
            return np.column_stack((cosine * x - sine * y, sine * x + cosine * y))
        rows = self._turns.before(act.at)
        vector = tuple(np.broadcast_to(value, (len(rows),)) for value in (x, y, z))
        rotation = tuple(column[rows] for column in self._rotation)
        return np.column_stack(scan.turned(rotation, vector))
