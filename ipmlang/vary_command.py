"""The command `vary`: a contact sheet of what a grammar draws with other seeds and attributes.

Reads a grammar, has it derived seed by seed, writes one page, and prints a line for a person or,
with `--json`, one object for a machine. A seed that breaks is told and spoils no other.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ipmlang import options
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, fail
from ipmlang.telling import findings_record, show, working

if TYPE_CHECKING:
    from ipmlang.edit.variations import Sweep, Variation

CAPTION = 6  # lines under a variation


@click.command("vary")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("-n", "count", default=16, show_default=True, help="how many variations")
@click.option(
    "-o",
    "--output",
    required=True,
    type=click.Path(path_type=Path),
    help="the sheet to write: .svg or .png",
)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**64 - 1),
    default=0,
    show_default=True,
    help="the first seed",
)
@click.option("--set", "settings", multiple=True, metavar="NAME=VALUE", help="fix an attribute")
@click.option(
    "--vary",
    "sweeps",
    multiple=True,
    metavar="NAME=LOW..HIGH",
    help="one seed, and this attribute from low to high; twice: columns and rows",
)
@options.STYLE
@click.option("--attributes", is_flag=True, help="draw all attributes within their ranges too")
@click.option("--columns", type=click.IntRange(1), help="variations beside each other")
@click.option("--width", default=1600, show_default=True, help="pixels of a .png from side to side")
@click.option(
    "--limit",
    "limits",
    multiple=True,
    metavar="KIND=NUMBER",
    help="stop a variation at so many shapes, steps, depth or bytes of memory",
)
@options.ALLOW_OUTSIDE
@options.JSON
def vary_file(
    file: Path,
    count: int,
    output: Path,
    seed: int,
    settings: tuple[str, ...],
    sweeps: tuple[str, ...],
    style: str | None,
    attributes: bool,
    columns: int | None,
    width: int,
    limits: tuple[str, ...],
    allow_outside: bool,
    as_json: bool,
) -> None:
    """Draw a contact sheet of FILE: one variation a seed, all in one scale, seeds under them.

    \b
    Examples:
      ipmlang vary bush.ipm -n 16 -o sheet.png
      ipmlang vary bush.ipm --vary age=1..6 -o ages.svg
    """  # fmt: skip
    from ipmlang.arguments import keep_apart, parse_limits, parse_settings
    from ipmlang.compiler import compile_file
    from ipmlang.edit import variations

    check_sheet(output)
    checked, program, warnings = compile_file(file, allow_outside=allow_outside, style=style)
    keep_apart([output], checked.loaded.paths)
    swept = [_sweep(word) for word in sweeps]
    wanted = variations.wishes(
        program,
        count,
        seed=seed,
        sweeps=swept,
        draw_attributes=attributes,
        fixed=parse_settings(settings, program.attrs),
    )
    made = []
    with working(f"deriving {file.name}") as say:
        for each in variations.vary(program, wanted, parse_limits(program.limits, limits)):
            made.append(each)
            say(f"deriving {file.name}: {len(made)} of {len(wanted)}")
        show(warnings)
        say(f"writing {output.name}")
        write_sheet(made, output, columns or variations.columns_of(swept, wanted), width)
    tell_sheet(made, output, as_json)


def check_sheet(output: Path) -> None:
    """Refuse, before any work, a sheet that could not be written."""
    from ipmlang.runtime.export import check_output

    if output.suffix.lower() not in (".svg", ".png"):
        hint = "name a file that ends in .svg or .png"
        raise fail("unknown-format", f"a sheet is no `{output.suffix}` file", hint=hint)
    check_output(output)


def write_sheet(made: Sequence[Variation], output: Path, columns: int | None, width: int) -> None:
    """Write the page of all variations. Raises the first problem if no variation was derived."""
    from ipmlang.edit.contact_sheet import Cell, contact_sheet
    from ipmlang.formats import FormatError
    from ipmlang.formats.atomic import write_file
    from ipmlang.formats.png import png_bytes
    from ipmlang.formats.svg.write import write_svg

    if all(each.drawing is None for each in made):
        raise IpmError(made[0].problems)
    page = contact_sheet([Cell(each.drawing, caption(each)) for each in made], columns)
    try:
        drawn = output.suffix.lower() == ".svg"
        write_file(output, write_svg(page) if drawn else png_bytes(page, width))
    except FormatError as error:
        raise fail("cannot-write", error.message, hint=error.hint) from error


def caption(variation: Variation) -> tuple[str, ...]:
    """The lines under a variation: its seed, and the attributes that make it different."""
    told = variation.wish.told
    lines = [f"seed {variation.wish.seed}", *(f"{name} {_shown(told[name])}" for name in told)]
    if len(lines) > CAPTION:
        lines = [*lines[: CAPTION - 1], "…"]
    if variation.drawing is None:
        lines.insert(1, variation.problems[0].code)
    return tuple(lines)


def _shown(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def tell_sheet(made: Sequence[Variation], output: Path, as_json: bool) -> None:
    """What was drawn, what was not, and whether anything varies at all."""
    from ipmlang.edit.variations import same_for_all

    failed = [each for each in made if each.drawing is None]
    found = [
        replace(each.problems[0], severity="warning", message=_of_seed(each)) for each in failed
    ]
    if same_for_all(made):
        found.append(_constant(made))
    show(found)
    if as_json:
        click.echo(json.dumps(sheet_record(made, output) | findings_record(found)))
        return
    count, different = len(made) - len(failed), len({each.print for each in made if each.drawing})
    bad = f", {len(failed)} failed" if failed else ""
    click.echo(f"{output}: {count} variations, {different} different{bad}")


def sheet_record(made: Sequence[Variation], output: Path) -> dict[str, object]:
    """A sheet as JSON."""
    return {
        "output": str(output),
        "different": len({each.print for each in made if each.drawing is not None}),
        "variations": [
            {
                "seed": each.wish.seed,
                "attributes": dict(each.wish.values),
                "terminals": each.terminals,
                "error": each.problems[0].message if each.problems else None,
            }
            for each in made
        ],
    }


def _of_seed(failed: Variation) -> str:
    told = "".join(f", {name} {_shown(value)}" for name, value in failed.wish.told.items())
    return f"seed {failed.wish.seed}{told}: {failed.problems[0].message}"


def _constant(made: Sequence[Variation]) -> Diagnostic:
    swept = any(each.wish.told for each in made)
    what = "these attributes" if swept else "the seed"
    hint = "let parameters vary: ipmlang edit randomise FILE --by 10% -o new.ipm"
    return Diagnostic(
        "does-not-vary",
        f"all {len(made)} variations look the same: nothing in this grammar depends on {what}",
        severity="warning",
        hint=None if swept else hint,
    )


def _sweep(word: str) -> Sweep:
    """`age=1..6`."""
    from ipmlang.edit.variations import Sweep

    name, _, ends = word.partition("=")
    low, dots, high = ends.partition("..")
    try:
        if name.strip() and dots:
            found = Sweep(name.strip(), float(low), float(high))
            if math.isfinite(found.low) and math.isfinite(found.high):
                return found
    except ValueError:
        pass
    hint = "write --vary name=low..high, for example --vary age=1..6"
    raise fail("bad-command", f"`--vary {word}` is no range", hint=hint)
