"""A program as text, for goldens and for people: a line an instruction, names where there are any.

In goes a program, out come lines. Nothing reads them back.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ipmlang.compiler import ir


def dump(program: ir.Program) -> str:
    r"""The whole program.

    >>> from ipmlang.compiler import compile_text
    >>> _, program, _ = compile_text("F --> F + F\nstart F steps 2\n")
    >>> print(dump(program))
    threaded flat steps
    symbol 0 F/0 moves productions 0
        r0 = const 1.0
        segment r0
    symbol 1 +/0 moves
        r0 = const 90.0
        rotate r0 z
    start
        F @0
    production 0 F
        F @0
        + @1
        F @2
    """
    flags = {
        "threaded": program.threaded,
        "flat": program.flat,
        "abop": program.abop,
        "steps": program.steps is not None,
        "tropism": program.tropism is not None,
    }
    lines = [" ".join(name for name, flag in flags.items() if flag) or "plain"]
    for number, attr in enumerate(program.attrs):
        lines += [f"attr {number} {attr.name} : {attr.type}", *_code(program, attr.default[0], 1)]
    for number, table in enumerate(program.tables):
        lines.append(
            f"table {number} {table.name} {' '.join(table.columns)}: {len(table.rows)} rows"
        )
    if program.late is not None:
        lines += ["late", *_code(program, program.late.code, 1)]
        lines += [f"    limit {name} r{register}" for name, register in program.late.limits]
        if program.late.tropism is not None:
            lines.append(f"    tropism {' '.join(f'r{each}' for each in program.late.tropism)}")
    if program.residual is not None:
        lines.append(f"residual {program.tables[program.residual.table].name}")
    for number, asset in enumerate(program.assets):
        stretch = "".join(f" {each:g}" for each in asset.stretch)
        lines.append(f"asset {number} {asset.name} {asset.path.name}#{asset.node or ''}{stretch}")
    for number, context in enumerate(program.contexts):
        lines.append(f"context {number} {context.name} : {context.kind} {context.path.name}")
    for number, symbol in enumerate(program.symbols):
        lines += _symbol(program, number, symbol)
    lines += ["start", *_code(program, program.axiom.body, 1)]
    for number, production in enumerate(program.productions):
        lines += _production(program, number, production)
    return "\n".join(lines)


def _symbol(program: ir.Program, number: int, symbol: ir.Symbol) -> Iterator[str]:
    words = [f"symbol {number} {symbol.name}/{symbol.arity}"]
    words += ["moves"] * symbol.moves + ["apart"] * symbol.apart
    words += [f"carries {symbol.carried}"] * bool(symbol.carried)
    for word, alternatives in (
        ("productions", symbol.productions),
        ("interpretation", symbol.interpretation),
    ):
        if alternatives:
            words.append(f"{word} {', '.join(map(str, alternatives))}")
    yield " ".join(words)
    yield from _code(program, symbol.meaning or (), 1)


def _production(program: ir.Program, number: int, production: ir.Production) -> Iterator[str]:
    own = program.symbols[production.symbol]
    arguments = f"({', '.join(f'p{i}' for i in range(production.parameters))})"
    yield f"production {number} {own.name}{arguments if production.parameters else ''}"
    for word, patterns in (("left", production.left), ("right", production.right)):
        if patterns:
            yield f"    {word} {' '.join(_pattern(program, each) for each in patterns)}"
    if production.guard is not None:
        yield f"    guard r{production.guard[1]}"
        yield from _code(program, production.guard[0], 2)
    if production.otherwise:
        yield "    else"
    if production.chance is not None:
        kind, code, register = production.chance
        yield f"    {kind} r{register}"
        yield from _code(program, code, 2)
    yield from _code(program, production.body, 1)


def _pattern(program: ir.Program, pattern: ir.Pattern) -> str:
    if pattern.branch:
        return f"[{' '.join(_pattern(program, each) for each in pattern.branch)}]"
    name = "*" if pattern.symbol < 0 else program.symbols[pattern.symbol].name
    return f"{name}/{pattern.arity}"


def _code(program: ir.Program, code: Sequence[ir.Instruction], depth: int) -> Iterator[str]:
    for each in code:
        if each.op == "close":
            depth -= 1
        yield "    " * depth + _line(program, each)
        yield from _code(program, each.body, depth + 1)
        if each.op == "open":
            depth += 1


def _line(program: ir.Program, each: ir.Instruction) -> str:
    args = " ".join(f"r{register}" for register in each.args)
    match each.op:
        case "open" | "close":
            return "[" if each.op == "open" else "]"
        case "module":
            name = program.symbols[int(str(each.const))].name
            return " ".join(filter(None, (name, args, f"@{each.site}")))
        case "param" | "attr" | "index":
            words: list[object] = [each.op, each.const]
        case "uniform":
            words = ["uniform", f"@{each.site:#x}"]
        case "call":
            words = [each.const, args]
        case _:
            const = each.const
            shown = " ".join(map(str, const)) if isinstance(const, tuple) else const
            words = [each.op, args, shown]
    text = " ".join(str(word) for word in words if word not in (None, ""))
    return f"r{each.out} = {text}" if each.out >= 0 else text
