"""The elements of bodies and meanings as bytecode: values, frames, slabs, copies, children.

In go instructions of the IR, out come words. What a bracket or a part of the scope restores is kept
in registers, and only the fields that something in it changes. An instruction without a body on the
GPU raises `UnsupportedError`; nothing is guessed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from ipmlang.compiler import ir
from ipmlang.compiler.ops import FUNCTIONS
from ipmlang.runtime.code import SOUND, doubtful
from ipmlang.runtime.fields import FRAME, SCOPE
from ipmlang.runtime.gpu import shaping
from ipmlang.runtime.gpu.functions import calls
from ipmlang.runtime.gpu.isa import NONE, Op
from ipmlang.runtime.gpu.registers import Names, Room, ending, inside, last_uses
from ipmlang.runtime.gpu.unsupported import UnsupportedError
from ipmlang.runtime.gpu.words import Words
from ipmlang.runtime.grouping import FIELD as GROUP
from ipmlang.runtime.queries.questions import read_inside
from ipmlang.runtime.scene import SCOPE as SCOPE_ASSET
from ipmlang.runtime.scene import SEGMENT

MOST = 64  # numbers that one symbol or one block may be given
OWN = None  # the site of what is drawn under the shape's own key


class Elements:
    """Writes the elements of one body."""

    def __init__(self, words: Words, room: Room) -> None:
        self.words = words
        self.room = room
        self._last: ir.Instruction | None = None  # the child that ends a body
        self._sound: set[int] = set()  # registers of the body whose numbers are finite
        self._breaks = 0  # whether it may be broken off: not while productions are chosen
        self._slots = {name: number for number, name in enumerate(room.fields)}

    # ------------------------------------------------------------------------- entry points

    def values(self, code: Sequence[ir.Instruction], out: int) -> int:
        """Code for values alone; the register with the one that is wanted."""
        names = Names(self.room.own())
        for each in code:
            self._value(each, names)
        return names.registers[out]

    def production(self, body: Sequence[ir.Instruction]) -> None:
        """The body of a production."""
        self._last = ending(body, self.words.calls == "forks")
        self._breaks = 1
        self.body(body, Names(self.room.own()))
        self.words.need(self.room.most - len(self.room.fields))

    def acts(
        self, meaning: Sequence[ir.Instruction], symbol: int, site: int | None, names: Names
    ) -> None:
        """What a module of a symbol without productions does; `names` are its own. `site`: where it
        stands, OWN: it is a shape of its own.
        """
        doubt = doubtful(meaning)
        threads = self.words.calls == "threads"
        borrowed = {*names.params, *(own for _, own in names.copies), *names.many.values()}
        for each in meaning:
            if each.op == "uniform" and site is not OWN:
                raise UnsupportedError("uniform", "what it draws is another module's")
            if each.op in ir.VALUE_OPS:
                self._value(each, names)
                continue
            given = [names.registers[arg] for arg in each.args]
            for arg in each.args if threads or each.op == "pen" else ():
                if arg in doubt:
                    self.words.put(Op.CHECK, a=names.registers[arg], n=threads)
            if each.op in ("segment", "emit"):
                self._draw(each, given, symbol, site, names)
            known = {
                place: names.known[arg] for place, arg in enumerate(each.args) if arg in names.known
            }
            self._act(each, given, known)
        self.room.free(set(names.registers.values()) - borrowed)

    # ------------------------------------------------------------------------------ bodies

    def body(self, elements: Sequence[ir.Instruction], names: Names) -> None:
        """The elements of a body. Registers of its own are free again after it."""
        last = last_uses(elements)
        own: set[int] = set()
        saved: list[dict[str, int]] = []
        for number, each in enumerate(elements):
            if each.op == "open":
                saved.append(self._saved(self._touched(inside(elements, number))))
            elif each.op == "close":
                self._restored(saved.pop())
            elif each.op in _STRUCTURE:
                _STRUCTURE[each.op](self, each, names)
            elif each.op in ir.VALUE_OPS:
                if self._value(each, names):
                    own.add(each.out)
            else:
                raise UnsupportedError(each.op, "it has no body on the GPU")
            ended = [out for out in own if last.get(out, number) <= number]
            own.difference_update(ended)
            self.room.free(names.registers.pop(out) for out in ended)
        self.room.free(names.registers.pop(out) for out in own)

    def _touched(self, elements: Iterable[ir.Instruction]) -> frozenset[str]:
        """The fields of the state that elements change for what follows them."""
        found: set[str] = set()
        depth = 0
        for each in elements:
            depth += (each.op == "open") - (each.op == "close")
            if depth:
                continue
            if each.op == "module":
                assert isinstance(each.const, int)
                symbol = self.words.program.symbols[each.const]
                if not (symbol.productions or symbol.interpretation):
                    for own in symbol.meaning or ():
                        found |= shaping.changes(own)
                elif self.words.calls == "threads" and symbol.moves:
                    found.update(self.room.fields)
            elif each.op == "repeat":
                found |= self._touched(each.body) - set(SCOPE)
        return frozenset(found)

    def _saved(self, touched: Iterable[str]) -> dict[str, int]:
        """Copies of fields of the state."""
        made = {}
        for name in sorted(touched):
            if name in self._slots:
                made[name] = self.room.new()
                self.words.put(Op.COPY, out=made[name], a=self._slots[name])
        return made

    def _restored(self, saved: Mapping[str, int], *, keep: bool = False) -> None:
        for name, register in saved.items():
            self.words.put(Op.COPY, out=self._slots[name], a=register)
        if not keep:
            self.room.free(saved.values())

    # ------------------------------------------------------------------------------ values

    def _check(self, registers: Iterable[int], names: Names) -> None:
        """Code that looks whether what is given is finite, where that is not known. Numpy looks at
        what stands in a hole where modules thread, and not elsewhere.
        """
        for register in registers:
            known = names.known.get(register)
            if register not in self._sound and (known is None or not math.isfinite(known)):
                threads = self.words.calls == "threads"
                self.words.put(Op.CHECK, a=names.registers[register], n=threads)

    def _value(self, each: ir.Instruction, names: Names) -> bool:
        """Code for one value; whether it takes a register of its own."""
        if each.op in SOUND:
            self._sound.add(each.out)
        if each.out in names.registers:
            return False
        if each.op == "param":
            number = int(str(each.const))
            names.registers[each.out] = names.params[number]
            if number in names.given:
                names.known[each.out] = names.given[number]
            return False
        if each.op == "index":
            names.registers[each.out] = dict(names.copies)[int(str(each.const))]
            return False
        if each.op == "count":
            names.registers[each.out] = names.many[int(str(each.const))]
            return False
        out = self.room.new()
        args = [names.registers[arg] for arg in each.args]
        self._computed(each, out, args, names)
        names.registers[each.out] = out
        return True

    def _computed(self, each: ir.Instruction, out: int, args: Sequence[int], names: Names) -> None:
        words = self.words
        match each.op:
            case "const":
                value = float(str(each.const))
                names.known[each.out] = value
                words.put(Op.LOAD, out=out, z=words.constant(value))
            case "attr":
                words.put(Op.LOAD, out=out, z=int(str(each.const)))
            case "row":
                assert isinstance(each.const, tuple)
                place, rows = words.column(int(str(each.const[0])), int(str(each.const[1])))
                words.put(Op.ROW, out=out, a=args[0], z=place, w=rows)
            case "uniform":
                self._key(each.site ^ 0x80000000, names)
                words.put(Op.UNIFORM, out=out)
            case "state":
                slot = self._slots.get(str(each.const))
                if slot is None:
                    words.put(Op.LOAD, out=out, z=words.constant(-1.0))
                else:
                    words.put(Op.COPY, out=out, a=slot)
            case "measure" if " " not in str(each.const):
                words.put(Op.MEASURE, out=out, z=("area", "volume", "sides").index(str(each.const)))
            case "call":
                self.called(str(each.const), out, args)
            case "fetch":
                assert isinstance(each.const, tuple)
                context, channel = (int(str(part)) for part in each.const)
                words.fetch(out, context, channel, args[0], args[1])
            case _:
                raise UnsupportedError(each.op, "only the CPU can answer it")

    def called(self, name: str, out: int, args: Sequence[int]) -> None:
        if FUNCTIONS[name].passing == "choice":
            self.words.pick(out, args[0], args[1:])
            return
        for call in calls(name, args):
            loaded = []
            given = []
            for kind, value in call.args:
                if kind == "number":
                    loaded.append(self.room.new())
                    self.words.put(Op.LOAD, out=loaded[-1], z=self.words.constant(float(value)))
                    value = loaded[-1]
                given.append(out if kind == "result" else int(value))
            self.words.call(call.function, out, given)
            self.room.free(loaded)

    def _key(self, site: int, names: Names) -> None:
        """The key of a site, in the copies around it."""
        self.words.put(Op.KEY, z=site, n=self._breaks)
        for _, register in names.copies:
            self.words.put(Op.MIX, a=register)

    # --------------------------------------------------------------------------- the state

    def _act(self, each: ir.Instruction, args: Sequence[int], known: Mapping[int, float]) -> None:
        words = self.words
        match each.op:
            case "move":
                words.put(Op.MOVE, a=args[0], b=args[1], c=args[2])
            case "segment":
                zero = self.zero()
                words.put(Op.MOVE, a=args[0], b=zero, c=zero)
                self.room.free([zero])
            case "rotate":
                words.put(Op.TURN, a=args[0], z="xyz".index(str(each.const)))
            case "orient":
                words.put(Op.ORIENT, a=args[0], b=args[1], c=args[2], d=args[3])
            case "scale":
                words.put(Op.SCALE, a=args[0])
            case "mirror":
                words.put(Op.MIRROR)
            case "level":
                words.put(Op.LEVEL)
            case "resize":
                words.put(Op.SIZE, a=args[0], b=args[1], c=args[2])
            case "layer":
                slot = self._slots["layer"]
                self.called("add", slot, (slot, args[0]))
            case "pen":
                self._pen(each, args)
            case "solid":
                shaping.solid(self, each, args, known)
            case "emit":
                pass
            case _:
                raise UnsupportedError(each.op, "it has no body on the GPU")

    def _pen(self, each: ir.Instruction, args: Sequence[int]) -> None:
        assert isinstance(each.const, tuple)
        name = str(each.const[0])
        if name == GROUP:
            raise UnsupportedError("effect", "groups are made on the CPU")
        if args:
            self.words.put(Op.COPY, out=self._slots[name], a=args[0])
        else:
            number = float(self.words.program.strings.index(str(each.const[1])))
            self.words.put(Op.LOAD, out=self._slots[name], z=self.words.constant(number))
        if name == "color":  # a colour is for both
            for other in ("fill", "stroke"):
                if other in self._slots:
                    place = self.words.constant(-1.0)
                    self.words.put(Op.LOAD, out=self._slots[other], z=place)

    def zero(self) -> int:
        """A register that holds 0."""
        out = self.room.new()
        self.words.put(Op.LOAD, out=out, z=self.words.constant(0.0))
        return out

    def slot(self, name: str) -> int:
        """The register of a field of the state."""
        return self._slots[name]

    # ---------------------------------------------------------------------------- children

    def _draw(
        self, each: ir.Instruction, args: Sequence[int], symbol: int, site: int | None, names: Names
    ) -> None:
        if site is OWN:
            self.words.put(Op.KEY, z=NONE)
        else:
            self._key(site, names)
        if each.op == "segment":
            zero = self.zero()
            self.words.put(Op.EMIT, z=SEGMENT, w=symbol, n=1, a=args[0], b=zero, c=zero)
            self.room.free([zero])
            return
        assert isinstance(each.const, int)
        asset = each.const if each.const >= 0 else SCOPE_ASSET
        a, b, c = args if len(args) == 3 else (0, 0, 0)
        self.words.put(Op.EMIT, z=asset, w=symbol, n=len(args) == 3, a=a, b=b, c=c)

    def _module(self, each: ir.Instruction, names: Names) -> None:
        assert isinstance(each.const, int)
        symbol = self.words.program.symbols[each.const]
        args = tuple(names.registers[register] for register in each.args)
        inlined = not (symbol.productions or symbol.interpretation)
        if inlined or self.words.calls == "threads":
            self._check(each.args, names)
        if inlined:
            known = {
                number: names.known[register]
                for number, register in enumerate(each.args) if register in names.known
            }  # fmt: skip
            inner = Names(args, {}, names.copies, names.many, names.shown, {}, known)
            self.acts(symbol.meaning or (), each.const, each.site, inner)
            return
        if len(args) > MOST:
            raise UnsupportedError(symbol.name, f"it has more than {MOST} parameters")
        self._key(each.site, names)
        self.words.child(each.const, args, last=each is self._last)

    # -------------------------------------------------------------------- parts and copies

    def _slab(self, each: ir.Instruction, names: Names) -> None:
        assert isinstance(each.const, int)
        if each.const > 2:
            raise UnsupportedError("split area", "areas are measured on the CPU")
        low, size = (names.registers[arg] for arg in each.args)
        moved = {*"xyz", ("sx", "sy", "sz")[each.const], "geo"}
        saved = self._saved(moved | self._touched(each.body))
        at = self.words.put(Op.SLAB, a=low, b=size, z=each.const)
        self.body(each.body, replace(names, registers=dict(names.registers)))
        self._restored(saved)
        self.words.patch(at, 3)

    def _repeat(self, each: ir.Instruction, names: Names) -> None:
        count = self.room.new()
        self.words.put(Op.COUNT, out=count, a=names.registers[each.args[0]])
        touched = self._touched(each.body)
        if touched - set(SCOPE) or self.words.calls != "none":
            self._loop(each, names, count, touched)
        else:
            self._block(each, names, count)
        self.room.free([count])

    def _block(self, each: ir.Instruction, names: Names, count: int) -> None:
        """Copies that leave the state alone: a block, which knows what it reads."""
        assert isinstance(each.const, int)
        read = read_inside(each.body) | set(each.args[1:])
        kept = {out: own for out, own in names.registers.items() if out in read}
        given = list(dict.fromkeys([
            *names.params, *kept.values(), *(own for _, own in names.copies), *names.many.values(),
            *(() if names.shown is None else (names.shown,)),
        ]))  # fmt: skip
        if len(given) > MOST:
            raise UnsupportedError("repeat", f"a copy needs more than {MOST} numbers")
        _, jump = self.words.copies(count, given)
        first = len(self.room.fields)
        places = {own: first + place for place, own in enumerate(given)}
        inner = Elements(self.words, Room(self.room.fields, len(given), reserved=1))
        inner._sound = set(self._sound)
        inner._breaks = 1
        index = first + len(given)
        own = Names(
            tuple(places[param] for param in names.params),
            {out: places[register] for out, register in kept.items()},
            (*((number, places[register]) for number, register in names.copies),
             (each.const, index)),
            {number: places[register] for number, register in names.many.items()},
            None,
            dict(names.known),
        )  # fmt: skip
        shown = inner.clear(each, own)
        inner.body(each.body, replace(own, shown=shown))
        self.words.need(inner.room.most - len(inner.room.fields))
        self.words.put(Op.END)
        self.words.patch(jump, 2)

    def _loop(
        self, each: ir.Instruction, names: Names, count: int, touched: frozenset[str]
    ) -> None:
        """Copies of which each begins where the one before it ended."""
        assert isinstance(each.const, int)
        index = self.zero()
        at = self.words.put(Op.ZERO, a=count)
        saved = self._saved(touched & set(SCOPE))
        start = self.words.here
        inner = replace(
            names, registers=dict(names.registers), copies=(*names.copies, (each.const, index))
        )
        inner.shown = self.clear(each, inner)
        self.body(each.body, inner)
        self._restored(saved, keep=True)
        self.words.put(Op.LOOP, a=index, b=count, z=start)
        self.words.patch(at, 2)
        if inner.shown != names.shown:
            self._show(names.shown)
            if inner.shown is not None:
                self.room.free([inner.shown])
        self.room.free([index, *saved.values()])
        self.words.resumable = True

    def clear(self, each: ir.Instruction, names: Names) -> int | None:
        """Code that shows a copy unless it is a hole; the register that says so."""
        shown = names.shown
        index = names.copies[-1][1]
        for hole in each.args[1:]:
            self.words.put(Op.CHECK, a=names.registers[hole], n=1)
            differs = self.room.new()
            self.words.put(Op.DIFFER, out=differs, a=names.registers[hole], b=index)
            if shown is not None:
                self.called("and", differs, (differs, shown))
            shown = differs
        if shown is not None:
            self._show(shown)
        return shown

    def _show(self, shown: int | None) -> None:
        if shown is not None:
            self.words.put(Op.SHOW, a=shown)
            return
        one = self.room.new()
        self.words.put(Op.LOAD, out=one, z=self.words.constant(1.0))
        self.words.put(Op.SHOW, a=one)
        self.room.free([one])

    def _pieces(self, each: ir.Instruction, names: Names) -> None:
        """The faces of a box, part by part."""
        number = shaping.face_split(each, names.known)
        parts = [part for part in each.body if part.op == "part"]
        selectors = tuple(part.const for part in parts)
        for place, part in enumerate(parts):
            table = self.words.faces(selectors, place)
            many, index = self.room.new(), self.zero()
            self.words.put_faces(Op.FACES, table, out=many)
            at = self.words.put(Op.ZERO, a=many)
            moved = {*FRAME, *SCOPE} - {"scale", "angle"}
            saved = self._saved(moved | self._touched(part.body))
            start = self.words.here
            self.words.put_faces(Op.FACE, table, a=index)
            inner = replace(
                names, registers=dict(names.registers), copies=(*names.copies, (number, index)),
                many={**names.many, number: many},
            )  # fmt: skip
            self.body(part.body, inner)
            self._restored(saved, keep=True)
            self.words.put(Op.LOOP, a=index, b=many, z=start, n=1)
            self.words.patch(at, 2)
            self.room.free([many, index, *saved.values()])


_STRUCTURE = {
    "module": Elements._module,
    "slab": Elements._slab,
    "repeat": Elements._repeat,
    "pieces": Elements._pieces,
}
