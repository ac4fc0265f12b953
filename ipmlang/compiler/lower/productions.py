"""Rules to productions: guards, chances and bodies, each with sites of its own.

In go a rule and the unit it stands in, out comes a production. The numbers of random call sites
start afresh in the guard, in the chance and in the body of every production, so that an edit of one
leaves the draws of all others alone.
"""

from __future__ import annotations

from collections.abc import Sequence

from ipmlang.compiler import ast, ir
from ipmlang.compiler.lower.carrying import Changes
from ipmlang.compiler.lower.expr import Binding, Code, Counter, Environment, Load, Pool
from ipmlang.compiler.lower.lsystem import Body, Namer
from ipmlang.compiler.lower.names import Place, Unit
from ipmlang.compiler.lower.symbols import Bound

GUARD_SITE = 0x10000000  # the first site of guards; bodies start at 0, the choice is 0x40000000
CHANCE_SITE = 0x20000000


def production(
    pool: Pool, namer: Namer, place: Place, symbol: int, rule: ast.Rule, bound: Bound = ()
) -> tuple[ir.Production, Changes]:
    """The production of a rule, some of whose parameters are `bound` to symbols, and which of its
    modules stand behind a `set`.
    """
    unit, item = place.unit, place.item
    counter = Counter()
    modules: list[ast.ContextModule | ast.Head] = [
        *_modules(rule.head.left),
        rule.head,
        *_modules(rule.head.right),
    ]
    given = {
        each.name: named
        for each, named in zip(rule.head.parameters, bound, strict=False)
        if named is not None
    }
    parameters = [
        each.name
        for module in modules
        for each in module.parameters
        if module is not rule.head or each.name not in given
    ]
    names: dict[str, Binding] = dict(given)
    names |= {name: Load("param", number) for number, name in enumerate(parameters)}
    guard, chance = None, None
    if rule.guard is not None and not isinstance(rule.guard, ast.Otherwise):
        counter.site = GUARD_SITE
        guard = _value(Code(pool, unit, item, counter), rule.guard, names)
    if rule.chance is not None:
        counter.site = CHANCE_SITE
        chance = (
            rule.chance.kind,
            *_value(Code(pool, unit, item, counter), rule.chance.value, names),
        )
    counter.site = 0
    code = Code(pool, unit, item, counter)
    Body(namer).write(code, rule.body, names)
    made = ir.Production(
        symbol,
        tuple(code.instructions),
        counter.register,
        len(parameters),
        guard,
        isinstance(rule.guard, ast.Otherwise),
        chance,
        _patterns(namer, unit, rule.head.left),
        _patterns(namer, unit, rule.head.right),
        item,
        unit.source.path,
        unit.line(item),
    )
    return made, counter.changes


def axiom(
    pool: Pool, namer: Namer, unit: Unit, item: int, elements: Sequence[ast.Element]
) -> tuple[ir.Production, Changes]:
    """The production of the start, and which of its modules stand behind a `set`."""
    code = Code(pool, unit, item)
    Body(namer).write(code, elements, {})
    made = ir.Production(
        -1,
        tuple(code.instructions),
        code.counter.register,
        item=item,
        path=unit.source.path,
        line=unit.line(item),
    )
    return made, code.counter.changes


def _value(
    code: Code, expr: ast.Expr, names: Environment
) -> tuple[tuple[ir.Instruction, ...], int]:
    register = code.register(code.value(expr, names))
    return tuple(code.instructions), register


def _modules(context: ast.Context | None) -> list[ast.ContextModule]:
    """The modules of a context in the order in which they are written."""
    found: list[ast.ContextModule] = []
    waiting = list(reversed(context.modules)) if context is not None else []
    while waiting:
        each = waiting.pop()
        if isinstance(each, ast.ContextModule):
            found.append(each)
        else:
            waiting += reversed(each.modules)
    return found


def _patterns(namer: Namer, unit: Unit, context: ast.Context | None) -> tuple[ir.Pattern, ...]:
    return () if context is None else tuple(_pattern(namer, unit, each) for each in context.modules)


def _pattern(namer: Namer, unit: Unit, module: ast.ContextModule | ast.ContextBranch) -> ir.Pattern:
    if isinstance(module, ast.ContextBranch):
        return ir.Pattern(-1, 0, tuple(_pattern(namer, unit, each) for each in module.modules))
    arity = len(module.parameters)
    if module.name == "*":
        return ir.Pattern(-1, arity)
    symbol = namer.symbol(unit, module.name, arity)
    return ir.Pattern(-2 if symbol is None else symbol, arity)
