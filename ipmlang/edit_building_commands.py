"""The commands of `edit` for buildings: parts are stretched, copied, joined, and stay attached.

Each reads a file, calls the library and tells what changed; how that is written and printed is
`edit_commands.py`'s to say. Nothing is decided here.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import click

from ipmlang.compiler.diagnostics import fail
from ipmlang.edit_commands import edit, edits, finish_edit

Command = TypeVar("Command", bound=Callable[..., None])
NUMBER = click.option(
    "--number", type=click.IntRange(1), help="only the n-th, in the order of derivation"
)


def selects_part(command: Command) -> Command:
    """The options that choose shapes of a building."""
    options = (
        click.option("--select", required=True, help="a rule's symbol, or a terminal"),
        NUMBER,
    )
    for option in reversed(options):
        command = option(command)
    return command


@edit.command("resize")
@edits
@click.option("--select", help="a rule's symbol, or a terminal; without it the whole")
@NUMBER
@click.option("--x", type=float, help="the size along its own x")
@click.option("--y", type=float, help="the size along its own y")
@click.option("--z", type=float, help="the size along its own z")
@click.option("--scale", is_flag=True, help="the numbers are factors: --x 1.5")
@click.option("--places", is_flag=True, help="change places and sizes, no attribute and no lot")
def resize_part(
    file: Path,
    output: Path | None,
    allow_outside: bool,
    as_json: bool,
    select: str | None,
    number: int | None,
    x: float | None,
    y: float | None,
    z: float | None,
    scale: bool,
    places: bool,
) -> None:
    """Give a part of FILE another size; all that touches it stays attached.

    One number of the grammar is changed where that is enough. Else the rest is
    moved and stretched along: parts beyond 1.8 times their size become rows,
    neighbours below 0.4 times are joined; a whole model beyond 1.8 times
    stands there several times. Without --number all parts change that are as
    large as the first.

    \b
    Examples:
      ipmlang edit resize house.ipm --x 24 -o wide.ipm
      ipmlang edit resize house.ipm --select Facade --x 18 -o wide.ipm
      ipmlang edit resize house.ipm --select Bay --number 3 --x 1.5 --scale -o new.ipm
    """
    from ipmlang.edit import read
    from ipmlang.edit.buildings import Wanted, resize

    wanted = Wanted(x, y, z, factors=scale)
    draft = read(file, allow_outside=allow_outside)
    made = resize(draft, select, wanted, number=number, parameters=not places)
    finish_edit(made, output, as_json)


@edit.command("split")
@edits
@selects_part
@click.option("--axis", type=click.Choice(["x", "y", "z"]), default="x", show_default=True)
@click.option("--into", "count", type=int, default=2, show_default=True, help="how many copies")
def split_part(
    file: Path,
    output: Path | None,
    allow_outside: bool,
    as_json: bool,
    select: str,
    number: int | None,
    axis: str,
    count: int,
) -> None:
    """Split a part of FILE into copies of itself along one of its own axes.

    \b
    Example:
      ipmlang edit split house.ipm --select Window --number 2 --into 3 -o new.ipm
    """
    from ipmlang.edit import read
    from ipmlang.edit.buildings import split

    draft = read(file, allow_outside=allow_outside)
    made = split(draft, select, "xyz".index(axis), count, number=number)
    finish_edit(made, output, as_json)


@edit.command("cut")
@edits
@selects_part
@click.option("--x", type=float, multiple=True, help="planes across its x, from its low side")
@click.option("--y", type=float, multiple=True, help="planes across its y")
@click.option("--z", type=float, multiple=True, help="planes across its z")
def cut_part(
    file: Path,
    output: Path | None,
    allow_outside: bool,
    as_json: bool,
    select: str,
    number: int | None,
    x: tuple[float, ...],
    y: tuple[float, ...],
    z: tuple[float, ...],
) -> None:
    """Cut a part of FILE by planes: each piece is the part again, in its room.

    \b
    Example:
      ipmlang edit cut house.ipm --select Wall --number 1 --x 3 --x 5 -o new.ipm
    """
    from ipmlang.edit import read
    from ipmlang.edit.buildings import cut

    given = [(axis, places) for axis, places in enumerate((x, y, z)) if places]
    if len(given) != 1:
        raise fail("bad-command", "planes across one axis are needed", hint="--x 3 --x 5, say")
    draft = read(file, allow_outside=allow_outside)
    finish_edit(cut(draft, select, *given[0], number=number), output, as_json)


@edit.command("join")
@edits
@click.option("--select", required=True, help="a rule's symbol, or a terminal")
@click.option("--number", "numbers", type=click.IntRange(1), multiple=True, help="each of them")
@click.option("--name", help="what the new rule is called")
def join_parts(
    file: Path,
    output: Path | None,
    allow_outside: bool,
    as_json: bool,
    select: str,
    numbers: tuple[int, ...],
    name: str | None,
) -> None:
    """Join parts of FILE under a new rule; a row of them becomes a repeat.

    \b
    Example:
      ipmlang edit join house.ipm --select Bay --number 1 --number 2 --number 3 -o new.ipm
    """
    from ipmlang.edit import read
    from ipmlang.edit.buildings import join

    draft = read(file, allow_outside=allow_outside)
    finish_edit(join(draft, select, numbers, name=name), output, as_json)


@edit.command("remove")
@edits
@selects_part
def remove_part(
    file: Path,
    output: Path | None,
    allow_outside: bool,
    as_json: bool,
    select: str,
    number: int | None,
) -> None:
    """Take a part of FILE away, or all of its kind.

    \b
    Example:
      ipmlang edit remove house.ipm --select Chimney --number 1 -o new.ipm
    """
    from ipmlang.edit import read
    from ipmlang.edit.buildings import remove

    draft = read(file, allow_outside=allow_outside)
    finish_edit(remove(draft, select, number=number), output, as_json)


@edit.command("add")
@edits
@selects_part
@click.option("--part", required=True, help="what is added: a symbol, a terminal, an asset")
@click.option("--at", required=True, type=(float, float, float), help="where, in what is selected")
@click.option("--size", type=(float, float, float), help="how large; else as it is elsewhere")
def add_part(
    file: Path,
    output: Path | None,
    allow_outside: bool,
    as_json: bool,
    select: str,
    number: int | None,
    part: str,
    at: tuple[float, float, float],
    size: tuple[float, float, float] | None,
) -> None:
    """Add a part to shapes of FILE, in their coordinates.

    \b
    Example:
      ipmlang edit add house.ipm --select Bay --number 3 --part Window --at 1 0.8 0 -o new.ipm
    """
    import numpy as np

    from ipmlang.edit import read
    from ipmlang.edit.buildings import add

    draft = read(file, allow_outside=allow_outside)
    extent = None if size is None else np.array(size)
    made = add(draft, part, select, np.array(at), extent, number=number)
    finish_edit(made, output, as_json)


@edit.command("scale")
@edits
@click.option("--terminal", required=True, help="the terminal to scale")
@click.option("--x", type=float, default=1.0, help="times as large along its x")
@click.option("--y", type=float, default=1.0, help="times as large along its y")
@click.option("--z", type=float, default=1.0, help="times as large along its z")
def scale_terminal(
    file: Path,
    output: Path | None,
    allow_outside: bool,
    as_json: bool,
    terminal: str,
    x: float,
    y: float,
    z: float,
) -> None:
    """Scale a terminal of FILE about its middle wherever it stands; later edits keep that.

    \b
    Example:
      ipmlang edit scale house.ipm --terminal Sill --x 1.1 -o new.ipm
    """
    import numpy as np

    from ipmlang.edit import read
    from ipmlang.edit.buildings import scale

    draft = read(file, allow_outside=allow_outside)
    finish_edit(scale(draft, terminal, np.array([x, y, z])), output, as_json)


@edit.command("paste")
@edits
@selects_part
@click.option("--part", required=True, help="what is copied: a symbol or a terminal")
@click.option("--part-number", type=click.IntRange(1), default=1, help="the n-th of these")
@click.option("--insert", is_flag=True, help="keep what stands there, in each part of the copy")
@click.option("--fill", is_flag=True, help="as often as it fits, rather than once, stretched")
def paste_part(
    file: Path,
    output: Path | None,
    allow_outside: bool,
    as_json: bool,
    select: str,
    number: int | None,
    part: str,
    part_number: int,
    insert: bool,
    fill: bool,
) -> None:
    """Copy a part of FILE to where others stand, fitted to their boxes and turned as they are.

    \b
    Examples:
      ipmlang edit paste house.ipm --part Door --select Window --number 3 -o new.ipm
      ipmlang edit paste house.ipm --part Window --select Blank --fill -o new.ipm
    """
    from ipmlang.edit import read
    from ipmlang.edit.buildings import Copying, paste

    draft = read(file, allow_outside=allow_outside)
    how = Copying(insert, fill)
    made = paste(draft, part, select, how, number=number, source_number=part_number)
    finish_edit(made, output, as_json)


@edit.command("transfer")
@edits
@selects_part
@click.option(
    "--from", "other", required=True, type=click.Path(path_type=Path), help="the other building"
)
@click.option("--rule", required=True, help="its rule, or terminal")
@click.option("--fill", is_flag=True, help="as often as it fits, rather than once, stretched")
def transfer_rule(
    file: Path,
    output: Path | None,
    allow_outside: bool,
    as_json: bool,
    select: str,
    number: int | None,
    other: Path,
    rule: str,
    fill: bool,
) -> None:
    """Put a rule of another building where parts of FILE stand: the style of one for another.

    \b
    Example:
      ipmlang edit transfer flats.ipm --select Window --from villa.ipm --rule Window -o new.ipm
    """
    from ipmlang.edit import read
    from ipmlang.edit.buildings import Copying, transfer

    draft, theirs = (read(each, allow_outside=allow_outside) for each in (file, other))
    made = transfer(draft, theirs, rule, select, Copying(fill=fill), number=number)
    finish_edit(made, output, as_json)


@edit.command("mix")
@edits
@click.option("--among", multiple=True, required=True, help="each part that may stand there")
@click.option("--name", help="what the new rule is called")
def mix_parts(
    file: Path,
    output: Path | None,
    allow_outside: bool,
    as_json: bool,
    among: tuple[str, ...],
    name: str | None,
) -> None:
    """Let chance choose among parts of FILE wherever one of them stands: random floors.

    \b
    Example:
      ipmlang edit mix house.ipm --among Floor --among Attic -o wild.ipm
    """
    from ipmlang.edit import read
    from ipmlang.edit.buildings import mixed

    draft = read(file, allow_outside=allow_outside)
    finish_edit(mixed(draft, among, name=name), output, as_json)


__all__ = ["edit"]
