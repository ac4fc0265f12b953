"""The command `render`: a picture of what a grammar derives or of a model in a file.

Reads a grammar or a model, has it drawn, writes the picture or the turn around it, and prints a
line for a person or, with `--json`, one object for a machine.
"""

from __future__ import annotations

import json
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ipmlang import options
from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.telling import device_record, show, tell_notes, working

if TYPE_CHECKING:
    from ipmlang import Grammar
    from ipmlang.formats.mesh_types import MeshScene
    from ipmlang.runtime.gpu.table import Table
    from ipmlang.runtime.scene import Scene


@click.command("render")
@click.argument("file", type=click.Path(path_type=Path, readable=False))
@click.option(
    "-o",
    "--output",
    required=True,
    type=click.Path(path_type=Path, readable=False),
    help="the picture to write: .png .webp .jpg; a turn: .webp .gif .apng or name-%03d.png",
)
@click.option(
    "--size",
    metavar="WIDTHxHEIGHT",
    help="pixels of the picture  [default: 1600x1000, for a turn 800x500]",
)
@click.option(
    "--view",
    default="iso",
    show_default=True,
    metavar="NAME|AZIMUTH,ELEVATION",
    help="front, back, left, right, top, iso, or degrees around from the front and above",
)
@click.option("--turntable", type=click.IntRange(2, 360), help="so many pictures all around it")
@click.option("--ground/--no-ground", default=True, help="a ground that takes the shadow")
@click.option(
    "--background",
    default="studio",
    show_default=True,
    metavar="COLOR",
    help="a colour, transparent, or studio",
)
@click.option("--lines", is_flag=True, help="draw the edges of the model")
@click.option(
    "--up",
    type=click.Choice(["y", "z"]),
    default="z",
    show_default=True,
    help="which axis points up in an obj, ply or stl file",
)
@click.option("--seed", type=click.IntRange(0, 2**64 - 1), help="the seed of a grammar")
@options.SET
@options.STYLE
@options.BACKEND
@options.LIMIT
@options.ALLOW_OUTSIDE
@options.JSON
def render_file(
    file: Path,
    output: Path,
    size: str | None,
    view: str,
    turntable: int | None,
    ground: bool,
    background: str,
    lines: bool,
    up: str,
    seed: int | None,
    settings: tuple[str, ...],
    style: str | None,
    backend: str,
    limits: tuple[str, ...],
    allow_outside: bool,
    as_json: bool,
) -> None:
    """Draw a picture of what the grammar in FILE derives, or of a model: glb, obj, ply, stl.

    \b
    Example:
      ipmlang render tree.ipm -o tree.png --seed 3 --view 30,15
      ipmlang render castle.glb -o castle.webp --turntable 36
    """  # fmt: skip
    from ipmlang import load
    from ipmlang.arguments import keep_apart
    from ipmlang.formats.mesh_types import MeshScene
    from ipmlang.runtime.gpu.device import is_of_card
    from ipmlang.studio import Look, as_seen, check_picture, draw
    from ipmlang.studio.look import parse_background, parse_size, parse_view

    check_picture(output, turntable)
    pixels = None if size is None else parse_size(size)
    look = Look(pixels, parse_view(view), ground, parse_background(background), lines)
    derived: Scene | Table | None = None
    with working(f"reading {file.name}") as say:
        if file.suffix.lower() == ".ipm":
            grammar = load(file, allow_outside=allow_outside, style=style)
            derived = _derived(grammar, output, seed, settings, backend, limits)
            seen = as_seen(derived)
        elif seed is not None or settings or limits or style or backend != "cpu":
            message = (
                "--seed, --set, --style, --backend and --limit are for grammars, not for models"
            )
            raise fail("bad-command", message)
        else:
            keep_apart([output], [file])
            seen = _model(file, up)
        for note in seen.notes if isinstance(seen, MeshScene) else ():
            many = f" ({note.count:,})" if note.count > 1 else ""
            click.echo(f"note: {note.message}{many}", err=True)
        started = time.process_time()
        try:
            draw(seen, look, output, turntable, say)
        except IpmError as error:
            if derived is None or backend != "auto" or not is_of_card(error):
                raise
            tell_notes([f"derived on the CPU: {error.diagnostics[0].message}"])
            derived = _derived(grammar, output, seed, settings, "cpu", limits)
            draw(as_seen(derived), look, output, turntable, say)
    ran = "cpu" if derived is None else derived.backend
    seconds = time.process_time() - started
    across, down = look.pixels(turntable)
    if as_json:
        report = {
            "output": str(output),
            "pictures": turntable or 1,
            "size": [across, down],
            "seconds": round(seconds, 6),
            "backend": ran,
            "device": device_record(ran),
        }
        click.echo(json.dumps(report))
    else:
        told = "a picture" if turntable is None else f"{turntable} pictures"
        click.echo(f"{output}: {told} of {across}x{down} in {seconds:.3g} s")


def _derived(
    grammar: Grammar,
    output: Path,
    seed: int | None,
    settings: tuple[str, ...],
    backend: str,
    limits: tuple[str, ...],
) -> Scene | Table:
    """What a grammar derives: a scene, or with a graphics card perhaps what lies there."""
    from ipmlang.arguments import keep_apart, parse_limits, parse_settings
    from ipmlang.runtime import derive_table

    keep_apart([output], grammar.checked.loaded.paths)
    show(grammar.warnings)
    attrs = parse_settings(settings, grammar.program.attrs)
    most = parse_limits(grammar.program.limits, limits)
    program = grammar.program
    table = derive_table(program, seed=seed, attrs=attrs, backend=backend, limits=most)
    if table is not None:
        tell_notes(table.notes)
        return table
    scene = grammar.run(seed=seed, attrs=attrs, backend=backend, limits=most)
    tell_notes(scene.notes)
    return scene


def _model(file: Path, up: str) -> MeshScene:
    """What a file holds, z up."""
    from ipmlang.formats import FormatError
    from ipmlang.formats.mesh import read_meshes
    from ipmlang.formats.mesh_types import Z_TO_Y

    try:
        scene = read_meshes(file)
    except FormatError as error:
        place = f"{file.name}:{error.line}: " if error.line else ""
        raise fail("bad-model", place + error.message, hint=error.hint) from error
    if up == "y" and file.suffix.lower() != ".glb":  # which is turned where it is read
        scene = replace(scene, matrix=Z_TO_Y.T @ scene.matrix)
    return scene
