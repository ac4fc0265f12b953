"""Every invariant of the IR, one small function each, run between lowering and executing.

In go a program, out come sentences about what is wrong with it; none for a program that executors
may trust. A broken invariant is a fault of the compiler, never of the user's file.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from ipmlang.compiler import ir
from ipmlang.compiler.ops import FUNCTIONS, QUERIES

ARGUMENTS: dict[str, int] = {
    "move": 3, "rotate": 1, "orient": 4, "scale": 1, "mirror": 0, "level": 0, "layer": 1, "cut": 0,
    "slab": 2, "slab_along": 3, "part": 0, "join": 0, "resize": 3, "center": 1, "report": 2,
    "phase": 1, "snap": 3, "piece": 3, "snapped": 3, "segment": 1, "polygon_open": 0,
    "polygon_close": 0, "path_open": 0, "path_close": 0, "vertex": 0, "open": 0, "close": 0,
}  # fmt: skip
BODIES = ir.VALUE_OPS | ir.BODY_OPS  # what stands in bodies
RESERVED = 0x40000000  # sites from here on are not a production's own


def verify(program: ir.Program) -> list[str]:
    """What is wrong with a program."""
    found = [
        problem for production in _productions(program) for problem in _one(program, production)
    ]
    for symbol in program.symbols:
        found += _alternatives(program, symbol)
        found += _meaning(program, symbol)
    for number, attr in enumerate(program.attrs):
        found += _attribute(program, number, attr)
    return found + _tables(program) + list(_late(program))


def _productions(program: ir.Program) -> Iterator[ir.Production]:
    yield program.axiom
    yield from program.productions


def _one(program: ir.Program, production: ir.Production) -> Iterator[str]:
    where = _where(program, production)
    code = [production.body]
    if production.guard is not None:
        code.append(production.guard[0])
        yield from _result(where, "guard", *production.guard)
    if production.chance is not None:
        code.append(production.chance[1])
        yield from _result(where, "chance", *production.chance[1:])
    for part in code:
        yield from _registers(where, production.registers, part, set())
    everything = [each for part in code for each in _all(part)]
    yield from _written_once(where, everything)
    yield from _sites(where, everything)
    yield from _brackets(where, production.body)
    yield from _repeats(where, production.body, ())
    for each in everything:
        yield from _instruction(where, program, each, production.parameters)
        if each.op not in BODIES:
            yield f"{where}: {each.op} stands in a body, not in a meaning"


def _where(program: ir.Program, production: ir.Production) -> str:
    name = "start" if production.symbol < 0 else program.symbols[production.symbol].name
    return f"{name} ({production.path}:{production.line})"


def _all(code: Iterable[ir.Instruction]) -> Iterator[ir.Instruction]:
    """All instructions, those of repeats after the repeat."""
    for each in code:
        yield each
        if each.body:
            yield from _all(each.body)


def _result(where: str, part: str, code: Sequence[ir.Instruction], register: int) -> Iterator[str]:
    if all(each.out != register for each in code):
        yield f"{where}: nothing writes the {part}'s register {register}"


def _registers(
    where: str, count: int, code: Sequence[ir.Instruction], known: set[int]
) -> Iterator[str]:
    """Registers are in range, written once, and read only after that, in the block or around it."""
    known = set(known)
    for each in code:
        for register in each.args:
            if register not in known:
                yield f"{where}: {each.op} reads register {register} before it is written"
        if each.body:
            yield from _registers(where, count, each.body, known)
        if each.out >= count:
            yield f"{where}: register {each.out} is beyond the {count} of the production"
        if each.out >= 0:
            known.add(each.out)


def _written_once(where: str, code: Iterable[ir.Instruction]) -> Iterator[str]:
    known: set[int] = set()
    for each in code:
        if each.out >= 0 and each.out in known:
            yield f"{where}: register {each.out} is written twice"
        known.add(each.out)


def _sites(where: str, code: Iterable[ir.Instruction]) -> Iterator[str]:
    """Children and draws have sites of their own, below the reserved ones."""
    used: set[int] = set()
    for each in code:
        if each.op not in ("module", "uniform", "query"):
            continue
        if not 0 <= each.site < RESERVED:
            yield f"{where}: {each.op} has site {each.site:#x}, out of range"
        elif each.site in used:
            yield f"{where}: site {each.site:#x} is used twice"
        used.add(each.site)


def _brackets(where: str, code: Sequence[ir.Instruction]) -> Iterator[str]:
    depth = 0
    for each in code:
        depth += (each.op == "open") - (each.op == "close")
        if depth < 0:
            yield f"{where}: a bracket closes that never opened"
            depth = 0
        if each.body:
            yield from _brackets(where, each.body)
    if depth:
        yield f"{where}: {depth} brackets stay open"


def _repeats(
    where: str, code: Sequence[ir.Instruction], around: tuple[object, ...]
) -> Iterator[str]:
    """A copy's number is read only within its repeat; repeats have numbers of their own."""
    for each in code:
        if each.op in ("index", "count") and each.const not in around:
            yield f"{where}: the number of repeat {each.const} is read outside it"
        if each.op in ("pieces", "snapped"):
            assert isinstance(each.const, tuple)
            yield from _repeats(where, each.body, (*around, each.const[1]))
        elif each.op != "repeat":
            yield from _repeats(where, each.body, around)
        if each.op == "repeat":
            if each.const in around:
                yield f"{where}: repeat {each.const} stands within itself"
            if not each.args:
                yield f"{where}: repeat {each.const} has no count"
            yield from _repeats(where, each.body, (*around, each.const))


def _instruction(
    where: str, program: ir.Program, each: ir.Instruction, parameters: int
) -> Iterator[str]:
    """What an instruction names exists, and it has as many arguments as it takes."""
    if (each.op in ir.VALUE_OPS) != (each.out >= 0):
        yield f"{where}: {each.op} and its register {each.out} do not go together"
    match each.op:
        case "param":
            yield from _below(where, "parameter", each.const, parameters)
        case "attr":
            yield from _below(where, "attribute", each.const, len(program.attrs))
        case "module":
            yield from _below(where, "symbol", each.const, len(program.symbols))
            yield from _arity(where, program, each)
        case "call":
            if each.const not in FUNCTIONS:
                yield f"{where}: there is no function {each.const}"
        case "query":
            if each.const not in QUERIES:
                yield f"{where}: there is no query {each.const}"
        case "row":
            yield from _cell(where, program, each)
        case "fetch":
            yield from _sample(where, program, each)
        case "emit":
            if isinstance(each.const, int) and each.const >= len(program.assets):
                yield f"{where}: there is no asset {each.const}"
        case _ if each.op in ARGUMENTS and len(each.args) != ARGUMENTS[each.op]:
            yield f"{where}: {each.op} takes {ARGUMENTS[each.op]} arguments, not {len(each.args)}"


def _arity(where: str, program: ir.Program, each: ir.Instruction) -> Iterator[str]:
    if not (isinstance(each.const, int) and each.const < len(program.symbols)):
        return
    arity = program.symbols[each.const].arity
    if arity != len(each.args):
        yield f"{where}: symbol {each.const} takes {arity} arguments, not {len(each.args)}"


def _below(where: str, what: str, number: object, count: int) -> Iterator[str]:
    if not (isinstance(number, int) and 0 <= number < count):
        yield f"{where}: there is no {what} {number}"


def _cell(where: str, program: ir.Program, each: ir.Instruction) -> Iterator[str]:
    assert isinstance(each.const, tuple)
    table, column = each.const
    known = isinstance(table, int) and table < len(program.tables)
    if not known or column not in range(len(program.tables[int(str(table))].columns)):
        yield f"{where}: there is no cell {each.const}"


def _sample(where: str, program: ir.Program, each: ir.Instruction) -> Iterator[str]:
    assert isinstance(each.const, tuple)
    number, channel = each.const
    yield from _below(where, "context", number, len(program.contexts))
    if isinstance(number, int) and 0 <= number < len(program.contexts):
        yield from _below(where, "channel", channel, program.contexts[number].channels)
    if len(each.args) != 2:
        yield f"{where}: fetch takes 2 arguments, not {len(each.args)}"


def _alternatives(program: ir.Program, symbol: ir.Symbol) -> Iterator[str]:
    for number in symbol.productions + symbol.interpretation:
        if number >= len(program.productions):
            yield f"{symbol.name}: there is no production {number}"
        elif program.symbols[program.productions[number].symbol].name != symbol.name:
            yield f"{symbol.name}: production {number} is of another symbol"


def _meaning(program: ir.Program, symbol: ir.Symbol) -> Iterator[str]:
    code = symbol.meaning or ()
    where = f"meaning of {symbol.name}"
    yield from _registers(where, symbol.meaning_registers, code, set())
    for each in code:
        yield from _instruction(where, program, each, symbol.arity)
        if each.op in ir.BODY_OPS:
            yield f"{where}: {each.op} stands in a meaning"


def _attribute(program: ir.Program, number: int, attr: ir.Attribute) -> Iterator[str]:
    code, register = attr.default
    where = f"attribute {attr.name}"
    yield from _result(where, "default", code, register)
    yield from _registers(where, attr.registers, code, set())
    for each in code:
        yield from _instruction(where, program, each, 0)
        if each.op == "attr" and isinstance(each.const, int) and each.const >= number:
            yield f"{where}: its default reads an attribute that comes after it"


def _late(program: ir.Program) -> Iterator[str]:
    if program.late is None:
        return
    code = program.late.code
    yield from _registers("settings", program.late.registers, code, set())
    for register in (*(program.late.tropism or ()), *(each for _, each in program.late.limits)):
        yield from _result("settings", "setting", code, register)
    for each in code:
        yield from _instruction("settings", program, each, 0)


def _tables(program: ir.Program) -> list[str]:
    residual = program.residual
    if residual is not None and not 0 <= residual.table < len(program.tables):
        return [f"there is no table {residual.table} for the residual"]
    return [
        f"table {table.name}: a row has {len(row)} cells, not {len(table.columns)}"
        for table in program.tables
        for row in table.rows
        if len(row) != len(table.columns)
    ]
