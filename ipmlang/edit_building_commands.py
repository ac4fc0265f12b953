"""The commands of `edit` for buildings: parts are stretched, copied, joined, and stay attached.

Each reads a file, calls the library and tells what changed; how that is written and printed is
`edit_commands.py`'s to say. Nothing is decided here.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import click

from ipmlang.edit_commands import edit, edits, finish_edit

Command = TypeVar("Command", bound=Callable[..., None])


def selects_part(command: Command) -> Command:
    """The options that choose shapes of a building."""
    options = (
        click.option("--select", required=True, help="a rule's symbol, or a terminal"),
        click.option(
            "--number", type=click.IntRange(1), help="only the n-th, in the order of derivation"
        ),
    )
    for option in reversed(options):
        command = option(command)
    return command


@edit.command("resize")
@edits
@selects_part
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
    select: str,
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
    neighbours below 0.4 times are joined. Without --number all parts change
    that are as large as the first.

    \b
    Examples:
      ipmlang edit resize house.ipm --select Facade --x 18 -o wide.ipm
      ipmlang edit resize house.ipm --select Bay --number 3 --x 1.5 --scale -o new.ipm
    """
    from ipmlang.edit import read
    from ipmlang.edit.buildings.resizing import Wanted, resize

    wanted = Wanted(x, y, z, factors=scale)
    draft = read(file, allow_outside=allow_outside)
    made = resize(draft, select, wanted, number=number, parameters=not places)
    finish_edit(made, output, as_json)


__all__ = ["edit"]
