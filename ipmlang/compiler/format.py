"""The only printer of `.ipm` text: a syntax tree goes in, its one canonical text comes out.

The text parses to the same tree, formatting it again changes nothing, and no comment is lost. Lines
have at most 100 columns (a longer string stands alone), rules of one symbol have their colons and
arrows below each other, and an empty line stays where the author had one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import assert_never

from ipmlang.compiler import ast
from ipmlang.compiler.layout import INDENT, WIDTH, Page, comment_text, fill, flat, flat_body
from ipmlang.compiler.spelling import (
    bound_words,
    clause_text,
    comma_separated,
    enclosed,
    expression_words,
    format_expression,
    head_text,
    parameters_text,
    quote,
    row_words,
)

__all__ = ["format_expression", "format_grammar"]

# A head or a column wider than this is not what others are aligned to.
ALIGNED = 32


def format_grammar(grammar: ast.Grammar) -> str:
    """The text of a whole file.

    >>> fork = ast.Rule(ast.Head("A"), (ast.Bracket((ast.Module("B"),)), ast.Module("B")))
    >>> print(format_grammar(ast.Grammar((fork,), header=(ast.Comment("a fork"),))), end="")
    // a fork
    A --> [B] B
    """
    lines: list[str] = []
    behind: dict[int, str] = {}
    _comments(lines, grammar.header)
    for run in _runs(grammar.items):
        for item, text in zip(run, _run_texts(run), strict=True):
            _item(lines, behind, item, text)
    _comments(lines, grammar.trailer)
    _add_behind(lines, behind)
    return "\n".join(lines) + "\n" if lines else ""


def _comments(lines: list[str], comments: Sequence[ast.Comment]) -> None:
    for comment in comments:
        if comment.blank_before and lines:
            lines.append("")
        lines.append(comment_text(comment))


def _item(lines: list[str], behind: dict[int, str], item: ast.Item, text: list[str]) -> None:
    """Adds an item: comments above it, its lines; one comment goes behind the last of them."""
    trailing = [comment for comment in item.comments if comment.trailing]
    leading = [comment for comment in item.comments if not comment.trailing]
    _comments(lines, leading + trailing[:-1])
    if item.blank_before and lines:
        lines.append("")
    lines += text
    for comment in trailing[-1:]:
        behind[len(lines) - 1] = comment_text(comment)


def _add_behind(lines: list[str], behind: dict[int, str]) -> None:
    """Adds comments behind lines, those of neighbours below each other."""
    for _, numbered in groupby(enumerate(sorted(behind)), lambda pair: pair[1] - pair[0]):
        block = [at for _, at in numbered]
        width = _width([lines[at] for at in block], WIDTH // 2)
        for at in block:
            lines[at] = f"{lines[at]:<{width}}  {behind[at]}"


# -------------------------------------------------------------------- alignment


def _runs(items: Sequence[ast.Item]) -> Iterator[list[ast.Item]]:
    """Neighbours that are aligned with each other: rules of one symbol, rules without clauses,
    attributes; nothing across an empty line or a comment.
    """
    run: list[ast.Item] = []
    for item in items:
        apart = item.blank_before or any(not comment.trailing for comment in item.comments)
        if run and (apart or not _belongs(run, item)):
            yield run
            run = []
        run.append(item)
    if run:
        yield run


def _belongs(run: list[ast.Item], item: ast.Item) -> bool:
    last = run[-1]
    if isinstance(last, ast.Attr):
        return isinstance(item, ast.Attr)
    if not isinstance(last, ast.Rule) or not isinstance(item, ast.Rule):
        return False
    if last.interpret != item.interpret or item.doc is not None:
        return False
    if last.head.name == item.head.name:
        return len(run) == 1 or run[-2].head.name == item.head.name  # type: ignore[union-attr]
    alone = len(run) == 1 or run[-2].head.name != last.head.name  # type: ignore[union-attr]
    return alone and not clause_text(last) and not clause_text(item)


def _run_texts(run: list[ast.Item]) -> list[list[str]]:
    """The lines of each item of a run."""
    if isinstance(run[0], ast.Rule):
        return _rules([item for item in run if isinstance(item, ast.Rule)])
    if isinstance(run[0], ast.Attr):
        return _attrs([item for item in run if isinstance(item, ast.Attr)])
    return [_item_lines(item, "") for item in run]


def _rules(rules: list[ast.Rule]) -> list[list[str]]:
    heads = [("interpret " if rule.interpret else "") + head_text(rule.head) for rule in rules]
    clauses = [clause_text(rule) for rule in rules]
    with_clause = [head for head, clause in zip(heads, clauses, strict=True) if clause]
    width = _width(with_clause)
    lefts = [
        f"{head:<{width}} {clause}" if clause else head
        for head, clause in zip(heads, clauses, strict=True)
    ]
    whole = _width(lefts)
    return [
        _item_lines(rule, f"{left:<{whole}} -->") for rule, left in zip(rules, lefts, strict=True)
    ]


def _width(texts: list[str], limit: int = ALIGNED) -> int:
    return max((len(text) for text in texts if len(text) <= limit), default=0)


def _attrs(attrs: list[ast.Attr]) -> list[list[str]]:
    rows = [_attr_cells(attr) for attr in attrs]
    widths = [_width([row[column] for row in rows]) for column in range(4)]
    found = []
    for attr, row in zip(attrs, rows, strict=True):
        cells = [
            f"{cell:<{width}}"
            for cell, width in zip(row, [*widths, 0], strict=True)
            if width or cell
        ]
        line = " ".join(cells).rstrip()
        fits = len(line) <= WIDTH
        found.append([line] if fits else _item_lines(attr, ""))
    return found


def _attr_cells(attr: ast.Attr) -> list[str]:
    return [
        f"attr {attr.name}",
        f": {attr.type}" if attr.type is not None else "",
        f"= {format_expression(attr.default)}",
        f"in {' '.join(_allowed_words(attr.allowed))}" if attr.allowed is not None else "",
        quote(attr.doc) if attr.doc is not None else "",
    ]


def _allowed_words(allowed: ast.Range | ast.Choices) -> list[str]:
    if isinstance(allowed, ast.Choices):
        values = comma_separated([expression_words(value) for value in allowed.values])
        return ["{", *values, "}"]
    low = " ".join(bound_words(allowed.low)) if allowed.low is not None else ""
    high = " ".join(bound_words(allowed.high)) if allowed.high is not None else ""
    return [f"{low}..{high}"]


# ------------------------------------------------------------------------- items


def _item_lines(item: ast.Item, left: str) -> list[str]:
    """The lines of one item; `left` is the aligned head of a rule."""
    match item:
        case ast.Rule():
            return _rule(item, left or _rule_left(item))
        case ast.Start():
            return _start(item)
        case ast.Table() if item.reference is None:
            return _inline_table(item)
        case _:
            page = Page()
            page.words(_declaration(item), INDENT)
            return page.finish()


def _rule_left(rule: ast.Rule) -> str:
    head = ("interpret " if rule.interpret else "") + head_text(rule.head)
    return " ".join(part for part in (head, clause_text(rule), "-->") if part)


def _rule(rule: ast.Rule, left: str) -> list[str]:
    docs = [] if rule.doc is None else [quote(line) for line in rule.doc.split("\n")]
    page = _rule_page(rule, left)
    body = flat_body(rule.body, WIDTH - len(page.line) - 1)
    if body is None and not any(_opens(each) for each in rule.body):
        page.break_line(INDENT)
    fill(page, rule.body, INDENT)
    return docs + page.finish()


def _opens(element: ast.Element) -> bool:
    """Whether an element has parts that stand on lines of their own."""
    blocks = ast.Split | ast.Block | ast.Each | ast.Repeat
    if not isinstance(element, blocks):
        return False
    text = flat(element, WIDTH - INDENT)
    return text is None or len(text) > WIDTH - INDENT


def _rule_page(rule: ast.Rule, left: str) -> Page:
    """A page that begins with the head of a rule, broken where it is longer than a line."""
    if len(left) <= WIDTH:
        return Page(left)
    page = Page()
    page.words(_rule_left(rule).split(" "), INDENT)
    return page


def _start(start: ast.Start) -> list[str]:
    page = Page("start")
    fill(page, start.axiom, INDENT)
    page.words(_start_words(start), INDENT)
    return page.finish()


def _start_words(start: ast.Start) -> list[str]:
    words = _place_words(start.place) if start.place is not None else []
    if start.seeds is not None:
        words += ["seeds", *expression_words(start.seeds)]
    if start.direction is not None:
        words.append(f"direction {start.direction}")
    if start.sites:
        words += ["with", "{", *comma_separated([[name] for name in start.sites]), "}"]
    if start.avoiding is not None:
        words += ["avoiding", start.avoiding + ("," if start.retries is not None else "")]
    if start.retries is not None:
        words += ["retries", *expression_words(start.retries)]
    if start.steps is not None:
        words += ["steps", *expression_words(start.steps)]
    if start.choices is not None:
        words += ["choices", quote(start.choices)]
    return words


def _place_words(place: ast.Place) -> list[str]:
    reference = place.reference or ""
    match place.kind:
        case "box":
            values = comma_separated([expression_words(value) for value in place.args])
            return ["on", *enclosed("box(", values, ")")]
        case "polygon":
            points = comma_separated([expression_words(point) for point in place.args])
            return ["on", "polygon", *enclosed("[", points, "]")]
        case "file":
            return ["on", quote(reference)]
        case "surface":
            return ["on", reference]
        case _:
            assert_never(place.kind)


def _inline_table(table: ast.Table) -> list[str]:
    """One row per line, in brackets only where a cell is more than a number, a text or a name."""
    cells = (cell for row in table.rows for cell in row)
    plain = all(isinstance(cell, ast.Number | ast.Text | ast.Name) for cell in cells)
    page = Page(f"table {table.name}({', '.join(table.columns)}) =")
    by_row: dict[int, list[ast.Comment]] = {}
    for index, comment in table.row_comments:
        by_row.setdefault(index, []).append(comment)
    if plain and table.rows and len(table.columns) == 1 and not by_row:
        page.break_line(INDENT)
        page.words([word for (cell,) in table.rows for word in expression_words(cell)], INDENT)
        return page.finish()
    for index, row in enumerate(table.rows):
        comments = by_row.get(index, [])
        for comment in comments:
            if not comment.trailing:
                page.comment(comment, INDENT)
        page.break_line(INDENT)
        words = comma_separated([expression_words(cell) for cell in row])
        page.words(words if plain else enclosed("(", words, ")"), 2 * INDENT)
        for comment in comments:
            if comment.trailing:
                page.comment(comment, INDENT)
    return page.finish()


def _declaration(item: ast.Item) -> list[str]:
    """The words of an item that is neither a rule nor a start nor a table of rows."""
    match item:
        case ast.Version(number=number):
            return [f"ipm {number}"]
        case ast.Import(path=path, alias=alias, style=style):
            called = [] if alias is None else ["as", alias]
            return ["import", quote(path), *called, *([] if style is None else ["style", style])]
        case ast.Style(name=name, parent=parent, doc=doc):
            extended = [] if parent is None else ["extends", parent]
            return ["style", name, *extended, *([] if doc is None else [quote(doc)])]
        case ast.Asset(names=names, reference=reference, by_name=by_name, stretch=stretch):
            listed = comma_separated([[name] for name in names])
            tail = ["stretch", *row_words(stretch)] if stretch else []
            return ["asset", *listed, "in" if by_name else "=", quote(reference), *tail]
        case ast.Table(name=name, reference=reference):
            return ["table", name, "=", quote(reference or "")]
        case ast.Surface(name=name, reference=reference, atlas=atlas):
            return ["surface", name, "=", quote(reference), *([f"atlas {atlas}"] if atlas else [])]
        case ast.Field():
            return _field_words(item)
        case ast.Attr():
            return _attr_words(item)
        case ast.Const(name=name, value=value):
            return ["const", name, "=", *expression_words(value)]
        case ast.Function(name=name, parameters=parameters, value=value):
            head = name + (parameters_text(parameters) or "()")
            return ["fn", head, "=", *expression_words(value)]
        case ast.Turtle(settings=settings):
            return ["turtle", *_setting_words(settings)]
        case ast.Limit(settings=settings):
            return ["limit", *_setting_words(settings)]
        case ast.Tropism():
            return _tropism_words(item)
        case ast.Ignore(names=names):
            return ["ignore", *names]
        case ast.Residual(table=table):
            return ["residual", table]
        case ast.Canvas():
            return _canvas_words(item)
        case ast.Axes(up=up):
            return [f"axes {up}"]
        case ast.Site(name=name, reference=reference, radius=radius):
            tail = [] if radius is None else ["radius", *expression_words(radius)]
            return ["site", name, "=", quote(reference), *tail]
        case ast.Rule() | ast.Start():
            raise AssertionError("rules and starts have layouts of their own")
        case _:
            assert_never(item)


def _field_words(field: ast.Field) -> list[str]:
    kinds = [] if field.kind == "texture" else [":", field.kind]
    words = ["context", field.name, *kinds, "=", quote(field.reference)]
    if field.place is not None:
        words += ["over", *row_words(field.place)]
    return [*words, "nearest"] if field.nearest else words


def _attr_words(attr: ast.Attr) -> list[str]:
    words = ["attr", attr.name]
    if attr.type is not None:
        words.append(f": {attr.type}")
    words += ["=", *expression_words(attr.default)]
    if attr.allowed is not None:
        words += ["in", *_allowed_words(attr.allowed)]
    return words if attr.doc is None else [*words, quote(attr.doc)]


def _setting_words(settings: tuple[ast.Setting, ...]) -> list[str]:
    return [f"{each.key} {_setting_value(each.value)}" for each in settings]


def _setting_value(value: ast.Expr) -> str:
    return quote(value.value) if isinstance(value, ast.Text) else " ".join(bound_words(value))


def _tropism_words(tropism: ast.Tropism) -> list[str]:
    """With a comma where a bracket behind the vector would be its call."""
    vector, elasticity = bound_words(tropism.vector), bound_words(tropism.elasticity)
    if elasticity[0].startswith("("):
        vector[-1] += ","
    return ["tropism", *vector, *elasticity]


def _canvas_words(canvas: ast.Canvas) -> list[str]:
    words = ["canvas", *row_words(canvas.box)]
    if canvas.width is not None:
        words.append(f"width {quote(canvas.width)}")
    if canvas.height is not None:
        words.append(f"height {quote(canvas.height)}")
    if canvas.decimals is not None:
        words.append(f"decimals {canvas.decimals}")
    return words
