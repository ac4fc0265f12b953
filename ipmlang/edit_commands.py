"""The command `edit` with its edits: a grammar in, another grammar out.

Each reads a file, calls the library and prints a few lines for a person or, with `--json`, one
object for a machine. The command line of `cli` takes them in; errors are rendered there.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from ipmlang import options as shared
from ipmlang.compiler.diagnostics import fail
from ipmlang.telling import findings_record, show, working

if TYPE_CHECKING:
    from ipmlang.edit import Draft

Command = TypeVar("Command", bound=Callable[..., None])
SHOWN = 12  # changes told to a person


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
        shared.ALLOW_OUTSIDE,
        shared.JSON,
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
