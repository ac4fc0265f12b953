"""The commands `edit` and `vary`: grammars changed, and contact sheets of what they draw.

Each reads a file, calls the library and prints a few lines for a person or, with `--json`, one
object for a machine. The command line of `cli` takes them in; errors are rendered there.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from ipmlang.compiler.diagnostics import Diagnostic, IpmError, fail
from ipmlang.telling import findings_record, show, working

if TYPE_CHECKING:
    from ipmlang.edit import Draft
    from ipmlang.edit.variations import Sweep, Variation

Command = TypeVar("Command", bound=Callable[..., None])
SHOWN = 12  # changes told to a person
CAPTION = 6  # lines under a variation


@click.group()
def edit() -> None:
    """Change a grammar and write the result as a new one.

    \b
    Comments stay, the result is checked and derived before it is written, and
    the files that it needs go along:
      ipmlang edit set garden.ipm picket_row_count=24 -o wide.ipm
      ipmlang edit randomise garden.ipm --operation f --by 10% -o wild.ipm
    """


def edits(command: Command) -> Command:
    """The argument and the options that every edit takes."""
    options = (
        click.argument("file", type=click.Path(path_type=Path)),
        click.option(
            "-o",
            "--output",
            type=click.Path(path_type=Path),
            help="the grammar to write, .ipm; without it the text is printed",
        ),
        click.option(
            "--allow-outside", is_flag=True, help="let assets lie outside the grammar's folder"
        ),
        click.option("--json", "as_json", is_flag=True, help="print one JSON object"),
    )
    for option in reversed(options):
        command = option(command)
    return command


def selects(command: Command) -> Command:
    """The options that choose parameters of rules."""
    options = (
        click.option("--rule", help="only in this rule; `start` is the axiom"),
        click.option("--operation", help="only of this operation or symbol, or of `repeat`"),
        click.option("--parameter", help="only this parameter: distance, angle, x, count, …"),
        click.option("--number", type=click.IntRange(1), help="only the n-th of those that match"),
    )
    for option in reversed(options):
        command = option(command)
    return command


@edit.command("set")
@edits
@click.argument("values", nargs=-1, metavar="[NAME=VALUE]...")
@selects
@click.option("--to", help="a number or an expression for the chosen parameters")
@click.option("--factor", type=float, help="multiply the chosen parameters")
def set_parameters(
    file: Path,
    output: Path | None,
    allow_outside: bool,
    as_json: bool,
    values: tuple[str, ...],
    rule: str | None,
    operation: str | None,
    parameter: str | None,
    number: int | None,
    to: str | None,
    factor: float | None,
) -> None:
    """Set attributes and constants of FILE, or parameters of its rules.

    \b
    Examples:
      ipmlang edit set garden.ipm picket_row_count=24 turtle.angle=30 -o wide.ipm
      ipmlang edit set garden.ipm --rule Flowers --operation + --to 60 -o new.ipm
      ipmlang edit set garden.ipm --rule Windows --factor 1.1 -o new.ipm
    """  # fmt: skip
    from ipmlang.edit import Selection, change, read, set_values

    selection = Selection(rule, operation, parameter, number)
    chosen = to is not None or factor is not None
    if not (values or chosen) or (chosen and selection.is_empty):
        hint = "write name=value, or choose parameters: --rule Row --operation f --to 13"
        raise fail("bad-command", "nothing says what to set", hint=hint)
    draft = set_values(read(file, allow_outside=allow_outside), _pairs(values))
    if chosen:
        draft = change(draft, selection, to=to, factor=factor)
    finish_edit(draft, output, as_json)


@edit.command("randomise")
@edits
@click.argument("names", nargs=-1, metavar="[ATTRIBUTE]...")
@selects
@click.option("--by", required=True, help="how far to both sides: 1.5, or 10%")
@click.option("--whole", is_flag=True, help="draw whole numbers; counts always are")
def randomise_parameters(
    file: Path,
    output: Path | None,
    allow_outside: bool,
    as_json: bool,
    names: tuple[str, ...],
    rule: str | None,
    operation: str | None,
    parameter: str | None,
    number: int | None,
    by: str,
    whole: bool,
) -> None:
    """Let parameters of FILE vary with the seed: `f(13)` becomes `f(13 + rand(-1, 1))`.

    Attributes are drawn once a run, parameters of rules for each copy. Without names and choices,
    all that moves, turns or scales varies.

    \b
    Examples:
      ipmlang edit randomise garden.ipm --rule PetalRing --operation + --by 8 -o wild.ipm
      ipmlang edit randomise garden.ipm picket_row_count --by 10% -o wild.ipm
    """  # fmt: skip
    from ipmlang.edit import Selection, amount, randomise, randomise_values, read

    selection = Selection(rule, operation, parameter, number)
    draft = read(file, allow_outside=allow_outside)
    if names:
        draft = randomise_values(draft, names, amount(by))
    if not names or not selection.is_empty:
        draft = randomise(draft, selection, amount(by), whole=whole)
    finish_edit(draft, output, as_json)


@edit.command("symmetrise")
@edits
@click.option("--length", type=float, help="what lengths may differ by [0.2 % of the largest]")
@click.option("--angle", type=float, default=0.5, show_default=True, help="the same in degrees")
@click.option("--scale", type=float, default=0.005, show_default=True, help="the same as a share")
def symmetrise_parameters(
    file: Path,
    output: Path | None,
    allow_outside: bool,
    as_json: bool,
    length: float | None,
    angle: float,
    scale: float,
) -> None:
    """Make nearly equal steps, angles and scales of FILE equal, and drop offsets from tables.

    \b
    Example:
      ipmlang edit symmetrise hand_drawn.ipm --length 2 --angle 3 -o regular.ipm
    """  # fmt: skip
    from ipmlang.edit import Tolerances, read, symmetrise

    draft = read(file, allow_outside=allow_outside)
    finish_edit(symmetrise(draft, Tolerances(length, angle, scale)), output, as_json)


@edit.command("replace")
@edits
@click.option("--terminal", required=True, help="the terminal to replace")
@click.option("--by", required=True, help="a symbol, an asset (flower.svg#f1), or another .ipm")
@click.option("--scale", type=float, help="scale what comes instead")
@click.option("--fit", is_flag=True, help="fill the box of what stood there")
def replace_symbol(
    file: Path,
    output: Path | None,
    allow_outside: bool,
    as_json: bool,
    terminal: str,
    by: str,
    scale: float | None,
    fit: bool,
) -> None:
    """Put another terminal, or another grammar's axiom, where a terminal of FILE stands.

    What comes stands in the same frame; files from elsewhere come along.

    \b
    Examples:
      ipmlang edit replace garden.ipm --terminal petal --by flower.svg#f1 --fit -o new.ipm
      ipmlang edit replace garden.ipm --terminal heart --by star.ipm --scale 0.2 -o new.ipm
    """  # fmt: skip
    from ipmlang.edit import read, replace_terminal

    draft = read(file, allow_outside=allow_outside)
    finish_edit(replace_terminal(draft, terminal, by, scale=scale, fit=fit), output, as_json)


@edit.command("flatten")
@edits
@click.option("--rule", required=True, help="the rule to replace, with arguments if it has any")
@click.option("--by", help="what to put there; without it, what the rule draws")
@click.option("--scale", type=float, help="scale what comes instead")
@click.option("--fit", is_flag=True, help="fill the box of what stood there")
@click.option(
    "--seed", type=click.IntRange(0, 2**64 - 1), default=0, help="for what the rule draws"
)
def flatten_rule(
    file: Path,
    output: Path | None,
    allow_outside: bool,
    as_json: bool,
    rule: str,
    by: str | None,
    scale: float | None,
    fit: bool,
    seed: int,
) -> None:
    """Put a terminal where a rule of FILE stands: any level of the hierarchy becomes one thing.

    \b
    Examples:
      ipmlang edit flatten garden.ipm --rule Flowers -o flat.ipm
      ipmlang edit flatten garden.ipm --rule Windows --by shutter.svg --fit -o new.ipm
    """  # fmt: skip
    from ipmlang.edit import flatten, read, replace_rule, symbol

    draft = read(file, allow_outside=allow_outside)
    if by is None and (fit or scale is not None):
        raise fail("bad-command", "--scale and --fit need --by, what to put there")
    if by is None:
        draft = flatten(draft, symbol(rule), seed=seed)
    else:
        draft = replace_rule(draft, symbol(rule), by, scale=scale, fit=fit)
    finish_edit(draft, output, as_json)


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
@click.option("--allow-outside", is_flag=True, help="let assets lie outside the grammar's folder")
@click.option("--json", "as_json", is_flag=True, help="print one JSON object")
def vary_file(
    file: Path,
    count: int,
    output: Path,
    seed: int,
    settings: tuple[str, ...],
    sweeps: tuple[str, ...],
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
    checked, program, warnings = compile_file(file, allow_outside=allow_outside)
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
    lines = [f"seed {variation.wish.seed}", *(f"{name} {told[name]}" for name in told)]
    if len(lines) > CAPTION:
        lines = [*lines[: CAPTION - 1], "…"]
    if variation.drawing is None:
        lines.insert(1, variation.problems[0].code)
    return tuple(lines)


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
    told = "".join(f", {name} {value}" for name, value in failed.wish.told.items())
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


def _pairs(words: tuple[str, ...]) -> dict[str, str]:
    """`columns=30` as names and values."""
    found: dict[str, str] = {}
    for word in words:
        name, equals, value = (part.strip() for part in word.partition("="))
        if not (name and equals and value):
            hint = "write name=value, for example columns=30"
            raise fail("bad-command", f"`{word}` sets nothing", hint=hint)
        found[name] = value
    return found


def finish_edit(draft: Draft, output: Path | None, as_json: bool) -> None:
    """Check and write a draft, and tell what was changed."""
    from ipmlang.edit import finish, save

    with working(f"checking {draft.path.name}"):
        finished = finish(draft, draft.path) if output is None else save(draft, output)
    if output is None and finished.files:
        names = ", ".join(each.name for each in finished.files)
        raise fail("bad-command", f"this edit also makes {names}", hint="say where with -o")
    show(finished.warnings)
    if as_json:
        record: dict[str, object] = {
            "output": None if output is None else str(output),
            "files": [str(each) for each in finished.files],
            "terminals": finished.terminals,
            "changes": [
                {"where": each.where, "before": each.before, "after": each.after}
                for each in draft.changes
            ],
        }
        click.echo(json.dumps(record | findings_record(finished.warnings)))
    elif output is None:
        click.echo(finished.text, nl=False)
    else:
        tell_changes(draft, output)


def tell_changes(draft: Draft, output: Path) -> None:
    """The changes, for a person."""
    for each in draft.changes[:SHOWN]:
        click.echo(f"  {each.where}: {each.before} -> {each.after}")
    if len(draft.changes) > SHOWN:
        click.echo(f"  … and {len(draft.changes) - SHOWN} more")
    count = len(draft.changes)
    click.echo(f"{output}: {count} change{'s' * (count != 1)}")
