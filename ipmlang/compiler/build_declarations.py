"""Makes the nodes of top-level items other than rules: one function per alias of `grammar.lark`.

Like `build.py`, which holds what a successor is made of; numbers and words that the language fixes
are checked here, where their places are still known.
"""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

from ipmlang.compiler import ast
from ipmlang.compiler.ast import Span
from ipmlang.compiler.automaton import Members
from ipmlang.compiler.build import once
from ipmlang.compiler.build_expressions import UnbuildableError, build_literals_list, unquote
from ipmlang.compiler.diagnostics import nearest

FieldKind: TypeAlias = Literal["texture", "scalar", "vector"]
Options: TypeAlias = "list[tuple[str, Any, int, int]]"

FIELD_KINDS: tuple[FieldKind, ...] = ("texture", "scalar", "vector")

MOST_DECIMALS = 12  # of the points of a drawing


def build_version(members: Members, start: int, end: int) -> ast.Version:
    return ast.Version(_whole(members[1], start, end), span=Span(start, end))


def build_import_plain(members: Members, start: int, end: int) -> ast.Import:
    return ast.Import(unquote(members[1], end - len(members[1])), span=Span(start, end))


def build_import_as(members: Members, start: int, end: int) -> ast.Import:
    return ast.Import(unquote(members[1], start), members[3], span=Span(start, end))


def build_import_style(members: Members, start: int, end: int) -> ast.Import:
    return ast.Import(unquote(members[1], start), None, members[3], span=Span(start, end))


def build_import_as_style(members: Members, start: int, end: int) -> ast.Import:
    return ast.Import(unquote(members[1], start), members[3], members[5], span=Span(start, end))


def build_style(members: Members, start: int, end: int) -> ast.Style:
    return ast.Style(members[1], None, members[2] or None, span=Span(start, end))


def build_style_extends(members: Members, start: int, end: int) -> ast.Style:
    return ast.Style(members[1], members[3], members[4] or None, span=Span(start, end))


def build_asset_reference(members: Members, start: int, end: int) -> ast.Asset:
    if len(members[1]) > 1:
        raise UnbuildableError(
            "several-names",
            "one reference cannot be the shape of several assets",
            start,
            end,
            'assets named like their ids are listed with `in`: asset A, B in "x.parts.svg"',
        )
    return _asset(members, False, start, end)


def build_asset_by_name(members: Members, start: int, end: int) -> ast.Asset:
    return _asset(members, True, start, end)


def _asset(members: Members, by_name: bool, start: int, end: int) -> ast.Asset:
    stretch = tuple(members[4])
    reference = unquote(members[3], start if stretch else end - len(members[3]))
    return ast.Asset(tuple(members[1]), reference, by_name, stretch, span=Span(start, end))


def build_asset_stretch(members: Members, start: int, end: int) -> list[ast.Number]:
    factors = [each for each in members[1] if isinstance(each, ast.Number) and each.value > 0]
    if len(factors) != 3 or len(members[1]) != 3:
        message = "an asset is stretched by three numbers above 0: along its x, y and z"
        raise UnbuildableError("out-of-range", message, start, end, "stretch (1.5, 1, 1)")
    return factors


def build_table_reference(members: Members, start: int, end: int) -> ast.Table:
    reference = unquote(members[3], end - len(members[3]))
    return ast.Table(members[1], reference, span=Span(start, end))


def build_row(members: Members, start: int, end: int) -> tuple[tuple[ast.Expr, ...], int, int]:
    return tuple(members[1]), start, end


def build_row_literals(
    members: Members, start: int, end: int
) -> tuple[tuple[ast.Expr, ...], int, int]:
    return tuple(build_literals_list(members, start, end)), start, end


def build_row_plain(
    members: Members, start: int, end: int
) -> tuple[tuple[ast.Expr, ...], int, int]:
    return tuple(members[0]), start, end


def build_table_inline(members: Members, start: int, end: int) -> ast.Table:
    columns, rows = tuple(members[3]), members[6]
    for values, row_start, row_end in rows:
        if len(values) != len(columns):
            raise UnbuildableError(
                "uneven-row",
                f"this row has {len(values)} values, the table {len(columns)} columns",
                row_start,
                row_end,
            )
    return ast.Table(
        members[1], None, columns, tuple(values for values, _, _ in rows), span=Span(start, end)
    )


def build_table_empty(members: Members, start: int, end: int) -> ast.Table:
    return ast.Table(members[1], None, tuple(members[3]), span=Span(start, end))


def build_surface_plain(members: Members, start: int, end: int) -> ast.Surface:
    reference = unquote(members[3], end - len(members[3]))
    return ast.Surface(members[1], reference, span=Span(start, end))


def build_surface_atlas(members: Members, start: int, end: int) -> ast.Surface:
    return ast.Surface(
        members[1],
        unquote(members[3], start),
        _whole(members[5], start, end),
        span=Span(start, end),
    )


def build_field_plain(members: Members, start: int, end: int) -> ast.Field:
    return _field(members[1], "texture", members[3], members[4], start, end)


def build_field_kind(members: Members, start: int, end: int) -> ast.Field:
    _known(members[3], FIELD_KINDS, "kind of context", start, end)
    return _field(members[1], members[3], members[5], members[6], start, end)


def _field(
    name: str, kind: FieldKind, text: str, options: Options, start: int, end: int
) -> ast.Field:
    found = once(options)
    place = found.get("over")
    if place is not None and len(place) != 4:
        raise UnbuildableError(
            "wrong-count",
            "what a context lies over has four numbers: left, bottom, width, height",
            start,
            end,
        )
    nearest = bool(found.get("nearest"))
    return ast.Field(name, unquote(text, start), kind, place, nearest, span=Span(start, end))


def build_range_closed(members: Members, start: int, end: int) -> ast.Range:
    return ast.Range(members[0], members[2], Span(start, end))


def build_range_from(members: Members, start: int, end: int) -> ast.Range:
    return ast.Range(members[0], None, Span(start, end))


def build_range_to(members: Members, start: int, end: int) -> ast.Range:
    return ast.Range(None, members[1], Span(start, end))


def build_choices(members: Members, start: int, end: int) -> ast.Choices:
    return ast.Choices(tuple(members[1]), Span(start, end))


def build_attr_rest(
    members: Members, start: int, end: int
) -> tuple[ast.Range | ast.Choices | None, str | None]:
    """What may be set, and what it means."""
    allowed = members[1] if len(members) > 1 else None
    doc = unquote(members[2], end - len(members[2])) if len(members) > 2 else None
    return allowed, doc


def build_attr_doc(members: Members, start: int, end: int) -> tuple[None, str]:
    return None, unquote(members[0], start)


def build_attr_untyped(members: Members, start: int, end: int) -> ast.Attr:
    allowed, doc = members[4]
    return ast.Attr(members[1], None, members[3], allowed, doc, span=Span(start, end))


def build_attr_typed(members: Members, start: int, end: int) -> ast.Attr:
    allowed, doc = members[6]
    return ast.Attr(members[1], members[3], members[5], allowed, doc, span=Span(start, end))


def build_const(members: Members, start: int, end: int) -> ast.Const:
    return ast.Const(members[1], members[3], span=Span(start, end))


def build_function(members: Members, start: int, end: int) -> ast.Function:
    return ast.Function(members[1], members[2], members[4], span=Span(start, end))


def build_setting(members: Members, start: int, end: int) -> ast.Setting:
    return ast.Setting(members[0], members[1], Span(start, end))


def build_setting_text(members: Members, start: int, end: int) -> ast.Setting:
    begin = end - len(members[1])
    value = ast.Text(unquote(members[1], begin), Span(begin, end))
    return ast.Setting(members[0], value, Span(start, end))


def build_turtle(members: Members, start: int, end: int) -> ast.Turtle:
    return ast.Turtle(_settings(members[1]), span=Span(start, end))


def build_limit(members: Members, start: int, end: int) -> ast.Limit:
    return ast.Limit(_settings(members[1]), span=Span(start, end))


def build_tropism(members: Members, start: int, end: int) -> ast.Tropism:
    return ast.Tropism(members[1], members[2], span=Span(start, end))


def build_tropism_comma(members: Members, start: int, end: int) -> ast.Tropism:
    return ast.Tropism(members[1], members[3], span=Span(start, end))


def build_ignore(members: Members, start: int, end: int) -> ast.Ignore:
    return ast.Ignore(tuple(members[1]), span=Span(start, end))


def build_residual(members: Members, start: int, end: int) -> ast.Residual:
    return ast.Residual(members[1], span=Span(start, end))


def build_canvas(members: Members, start: int, end: int) -> ast.Canvas:
    for word, value, begin, finish in members[2]:
        _known(word, ("width", "height", "decimals"), "measure of a canvas", begin, finish)
        if word == "decimals" and not (value.isdigit() and int(value) <= MOST_DECIMALS):
            message = f"`decimals` is a whole number from 0 to {MOST_DECIMALS}"
            raise UnbuildableError("out-of-range", message, begin, finish)
        if word != "decimals" and not value.startswith('"'):
            message = f'the {word} of a page is a text, as `{word} "{value}mm"`'
            raise UnbuildableError("wrong-type", message, begin, finish)
    sizes = once(members[2])
    if len(members[1]) != 4:
        raise UnbuildableError(
            "wrong-count", "a canvas has four numbers: left, bottom, width, height", start, end
        )
    return ast.Canvas(
        tuple(members[1]),
        unquote(sizes["width"], start) if "width" in sizes else None,
        unquote(sizes["height"], start) if "height" in sizes else None,
        int(sizes["decimals"]) if "decimals" in sizes else None,
        span=Span(start, end),
    )


def build_axes(members: Members, start: int, end: int) -> ast.Axes:
    up = f"{members[1]}-{members[3]}"
    if up == "y-up":
        return ast.Axes("y-up", span=Span(start, end))
    _known(up, ("y-up", "z-up"), "direction of axes", start, end)
    return ast.Axes("z-up", span=Span(start, end))


def build_site_plain(members: Members, start: int, end: int) -> ast.Site:
    reference = unquote(members[3], end - len(members[3]))
    return ast.Site(members[1], reference, span=Span(start, end))


def build_site_radius(members: Members, start: int, end: int) -> ast.Site:
    return ast.Site(members[1], unquote(members[3], start), members[5], span=Span(start, end))


def build_place_box(members: Members, start: int, end: int) -> ast.Place:
    if len(members[1]) not in (2, 3):
        raise UnbuildableError(
            "wrong-count", "a box has two or three sizes: x, y and z", start, end
        )
    return ast.Place("box", tuple(members[1]), None, Span(start, end))


def build_place_polygon(members: Members, start: int, end: int) -> ast.Place:
    return ast.Place("polygon", tuple(members[2]), None, Span(start, end))


def build_place_file(members: Members, start: int, end: int) -> ast.Place:
    return ast.Place("file", (), unquote(members[0], start), Span(start, end))


def build_place_surface(members: Members, start: int, end: int) -> ast.Place:
    return ast.Place("surface", (), members[0], Span(start, end))


def build_start(members: Members, start: int, end: int) -> ast.Start:
    options = once(members[2] if len(members) > 2 else [])
    return ast.Start(
        axiom=tuple(members[1]),
        place=options.get("on"),
        steps=options.get("steps"),
        seeds=options.get("seeds"),
        direction=options.get("direction"),
        sites=options.get("with", ()),
        avoiding=options.get("avoiding"),
        retries=options.get("retries"),
        choices=options.get("choices"),
        span=Span(start, end),
    )


# ------------------------------------------------------------------------ checks


def _settings(settings: list[ast.Setting]) -> tuple[ast.Setting, ...]:
    once([(each.key, each, each.span.start, each.span.end) for each in settings])
    return tuple(settings)


def _whole(text: str, start: int, end: int) -> int:
    if not text.isdigit() or len(text) > 9:
        raise UnbuildableError("bad-number", f"`{text}` is not a whole number", start, end)
    return int(text)


def _known(word: str, words: tuple[str, ...], what: str, start: int, end: int) -> None:
    if word not in words:
        close = nearest(word, words)
        hint = f"did you mean `{close[0]}`?" if close else f"known are {', '.join(words)}"
        raise UnbuildableError("unknown-word", f"`{word}` is no {what}", start, end, hint)
