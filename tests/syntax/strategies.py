"""Random syntax trees: every kind of node, in the form that the parser gives it."""

from __future__ import annotations

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from ipmlang.compiler import ast

NAMES = st.sampled_from(["A", "B", "Floor", "m", "n", "x1", "roofs.Hip", "r.x", "Größe", "steps2"])
PLAIN = st.sampled_from(["a", "bay", "T", "S1", "w"])
MARKS = st.sampled_from(["+", "-", "*", "/", "&", "^", "\\", "$", "!"])
SYMBOLS = NAMES | MARKS
# Characters of every kind that a string may hold; surrogates are no characters.
TEXTS = st.text(st.characters(exclude_categories=("Cs",)), max_size=12) | st.text(
    'a "\\/{\n\t', max_size=6
)
WIDE = st.text("abcdef ", min_size=30, max_size=60)


def tuples(each: SearchStrategy, least: int = 0, most: int = 3) -> SearchStrategy:
    """Tuples of something."""
    return st.lists(each, min_size=least, max_size=most).map(tuple)


def numbers() -> SearchStrategy:
    """Literals, large, small and negative."""
    values = st.floats(allow_nan=False, allow_infinity=False) | st.integers(-999, 9999).map(float)
    return values.map(ast.Number)


def _call(expressions: SearchStrategy) -> SearchStrategy:
    return st.builds(ast.Call, NAMES, arguments(expressions))


def arguments(expressions: SearchStrategy) -> SearchStrategy:
    """Arguments, some by name."""
    return tuples(st.builds(ast.Argument, expressions, st.none() | PLAIN))


def _compound(inner: SearchStrategy) -> SearchStrategy:
    operators = st.sampled_from(["+", "-", "*", "/", "<", "<=", ">", ">=", "==", "!=", "and", "or"])
    # A minus before a literal that has none belongs to the literal.
    negatable = inner.filter(lambda value: not (isinstance(value, ast.Number) and value.value >= 0))
    return st.one_of(
        _call(inner),
        st.builds(ast.Unary, st.just("not"), inner),
        st.builds(ast.Unary, st.just("-"), negatable),
        st.builds(ast.Binary, operators, inner, inner),
        st.builds(ast.If, inner, inner, inner),
        st.builds(ast.Tuple, tuples(inner)),
    )


EXPRESSIONS = st.recursive(
    numbers()
    | st.builds(ast.Text, TEXTS)
    | st.builds(ast.Truth, st.booleans())
    | st.builds(ast.Name, NAMES),
    _compound,
    max_leaves=8,
)

MODULES = st.builds(ast.Module, SYMBOLS, arguments(EXPRESSIONS))
COUNTS = st.builds(ast.Count, PLAIN, EXPRESSIONS)
ROWS = st.builds(ast.Rows, PLAIN, PLAIN)
AT_ROWS = st.builds(ast.Rows, st.just("at"), PLAIN, st.just(True))
SIZES = st.builds(ast.Size, st.sampled_from(["absolute", "relative", "floating"]), EXPRESSIONS)


def _elements(inner: SearchStrategy) -> SearchStrategy:
    bodies = tuples(inner)
    labelled = st.builds(ast.Part, EXPRESSIONS, bodies)
    bare = st.builds(ast.Part, st.none(), tuples(inner, 1))
    parts = tuples(labelled | bare)
    split_parts = st.recursive(
        st.builds(ast.SplitPart, SIZES, bodies),
        lambda below: st.builds(ast.SplitGroup, tuples(below, 1), st.sampled_from(["*", "+"])),
        max_leaves=3,
    )
    values = tuples(EXPRESSIONS)
    return st.one_of(
        st.builds(ast.Bracket, bodies),
        st.builds(ast.Repeat, COUNTS | ROWS | AT_ROWS, bodies, values, values, st.none() | ROWS),
        st.builds(ast.Split, PLAIN, tuples(split_parts, 1), arguments(EXPRESSIONS)),
        st.builds(ast.Block, NAMES, arguments(EXPRESSIONS), parts),
        st.builds(ast.Each, MODULES, PLAIN, parts),
        st.builds(ast.Assign, NAMES, EXPRESSIONS),
        st.builds(ast.Local, PLAIN, EXPRESSIONS),
    )


ELEMENTS = st.recursive(MODULES, _elements, max_leaves=8)
BODIES = tuples(ELEMENTS)

PARAMETERS = tuples(st.builds(ast.Parameter, PLAIN))
CONTEXT_MODULES = st.builds(ast.ContextModule, SYMBOLS, PARAMETERS)
CONTEXT_ENTRIES = st.recursive(
    CONTEXT_MODULES, lambda below: st.builds(ast.ContextBranch, tuples(below, 1)), max_leaves=3
)
CONTEXTS = st.none() | st.builds(ast.Context, tuples(CONTEXT_ENTRIES, 1))
HEADS = st.builds(ast.Head, SYMBOLS, PARAMETERS, CONTEXTS, CONTEXTS)
CHANCES = st.builds(ast.Chance, st.sampled_from(["percent", "weight"]), EXPRESSIONS)
RULES = st.one_of(
    st.builds(
        ast.Rule,
        HEADS,
        BODIES,
        st.none() | EXPRESSIONS,
        st.none() | CHANCES,
        st.booleans(),
        st.none() | TEXTS,
    ),
    st.builds(ast.Rule, HEADS, BODIES, st.builds(ast.Otherwise)),
)


def _unique(pairs: dict[str, ast.Expr]) -> tuple[ast.Setting, ...]:
    return tuple(ast.Setting(key, value) for key, value in pairs.items())


SETTINGS = st.dictionaries(PLAIN, EXPRESSIONS, min_size=1, max_size=3).map(_unique)
ALLOWED = st.one_of(
    st.none(),
    st.builds(ast.Range, EXPRESSIONS, st.none() | EXPRESSIONS),
    st.builds(ast.Range, st.none(), EXPRESSIONS),
    st.builds(ast.Choices, tuples(EXPRESSIONS, 1)),
)
PLACES = st.one_of(
    st.builds(ast.Place, st.just("box"), tuples(EXPRESSIONS, 2)),
    st.builds(ast.Place, st.just("polygon"), tuples(EXPRESSIONS, 1)),
    st.builds(ast.Place, st.just("file"), st.just(()), TEXTS),
    st.builds(ast.Place, st.just("surface"), st.just(()), PLAIN),
)
CELLS = EXPRESSIONS.filter(lambda value: isinstance(value, ast.Number | ast.Text))
TABLES = st.integers(1, 3).flatmap(
    lambda columns: st.builds(
        ast.Table,
        PLAIN,
        st.none(),
        tuples(PLAIN, columns, columns),
        tuples(tuples(EXPRESSIONS, columns, columns)) | tuples(tuples(CELLS, columns, columns)),
    )
)
DECLARATIONS = st.one_of(
    st.builds(ast.Version, st.integers(0, 99)),
    st.builds(ast.Import, TEXTS, st.none() | PLAIN, st.none() | PLAIN),
    st.builds(ast.Style, PLAIN, st.none() | PLAIN, st.none() | TEXTS.filter(bool)),
    st.builds(ast.Asset, tuples(PLAIN, 1, 1), TEXTS),
    st.builds(ast.Asset, tuples(PLAIN, 1, 40), TEXTS, st.just(True)),
    st.builds(ast.Table, PLAIN, TEXTS),
    TABLES,
    st.builds(ast.Surface, PLAIN, TEXTS, st.none() | st.integers(1, 4096)),
    st.builds(
        ast.Field,
        PLAIN,
        TEXTS,
        st.sampled_from(["texture", "scalar", "vector"]),
        st.none() | tuples(EXPRESSIONS, 4, 4),
        st.booleans(),
    ),
    st.builds(ast.Attr, NAMES, st.none() | PLAIN, EXPRESSIONS, ALLOWED, st.none() | TEXTS | WIDE),
    st.builds(ast.Const, PLAIN, EXPRESSIONS),
    st.builds(ast.Function, PLAIN, PARAMETERS, EXPRESSIONS),
    st.builds(ast.Turtle, SETTINGS),
    st.builds(ast.Limit, SETTINGS),
    st.builds(ast.Tropism, EXPRESSIONS, EXPRESSIONS),
    st.builds(ast.Ignore, tuples(SYMBOLS, 1)),
    st.builds(ast.Residual, NAMES),
    st.builds(ast.Canvas, tuples(EXPRESSIONS, 4, 4), st.none() | TEXTS, st.none() | TEXTS),
    st.builds(ast.Axes, st.sampled_from(["y-up", "z-up"])),
    st.builds(ast.Site, PLAIN, TEXTS, st.none() | EXPRESSIONS),
)
STARTS = st.builds(
    ast.Start,
    tuples(ELEMENTS, 1),
    st.none() | PLACES,
    st.none() | EXPRESSIONS,
    st.none() | EXPRESSIONS,
    st.none() | PLAIN,
    tuples(PLAIN),
    st.none() | PLAIN,
    st.none() | EXPRESSIONS,
    st.none() | TEXTS,
)
ITEMS = RULES | RULES | DECLARATIONS | STARTS
GRAMMARS = st.builds(ast.Grammar, tuples(ITEMS, 0, 5))
