"""The command `run`: derive a grammar and write what it draws, on the CPU or the graphics card.

Reads a grammar, has it derived and exported, and prints a line for a person or, with `--json`, one
object for a machine. With `--explain` it tells which rules the graphics card leaves to the CPU.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ipmlang import options
from ipmlang.compiler.diagnostics import fail
from ipmlang.telling import device_record, report_lines, show, tell_notes, working

if TYPE_CHECKING:
    from ipmlang.runtime.scene import Scene

_ALONE = "only --explain needs no file"


@click.command("run")
@click.argument("file", type=click.Path(path_type=Path, readable=False))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, readable=False),
    help="where to write: .svg .png .obj .glb .ply .stl",
)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**64 - 1),
    help="the number all randomness comes from; without one it is 0, and the choices that a "
    "grammar brings along are replayed",
)
@options.SET
@options.STYLE
@click.option(
    "--on",
    metavar="FILE",
    help="start on every closed path or face of a file: lots.svg, town.obj, town.svg#lots",
)
@options.BACKEND
@click.option("--explain", is_flag=True, help="tell which rules run on the CPU alone, and why")
@options.LIMIT
@options.ALLOW_OUTSIDE
@click.option("--instancing", is_flag=True, help="write glb instances with EXT_mesh_gpu_instancing")
@options.JSON
def run_file(
    file: Path,
    output: Path | None,
    seed: int | None,
    settings: tuple[str, ...],
    style: str | None,
    on: str | None,
    backend: str,
    explain: bool,
    limits: tuple[str, ...],
    allow_outside: bool,
    instancing: bool,
    as_json: bool,
) -> None:
    """Derive the grammar in FILE and write what it draws.

    \b
    Example:
      ipmlang run garden.ipm -o garden.svg --seed 3 --set pickets=30
    """  # fmt: skip
    from ipmlang import load
    from ipmlang.arguments import keep_apart, parse_limits, parse_settings
    from ipmlang.rule_table import rule_lines, rule_rows
    from ipmlang.runtime.export import check_output, save

    if output is not None:
        check_output(output)
    elif not explain:
        raise fail("bad-command", "say where to write it: -o or --output", hint=_ALONE)
    grammar = load(file, allow_outside=allow_outside, style=style)
    stood_on = [] if on is None else [Path(on), Path(on.rpartition("#")[0])]
    outputs = [] if output is None else [output]
    keep_apart(outputs, [*grammar.checked.loaded.paths, *stood_on])
    show(grammar.warnings)
    report: dict[str, object] = {}
    if explain:
        report["explain"] = rows = rule_rows(grammar.program)
        for line in () if as_json else rule_lines(rows):
            click.echo(line)
    if output is not None:
        started = time.process_time()
        with working(f"deriving {file.name}"):
            scene = grammar.run(
                seed=seed,
                attrs=parse_settings(settings, grammar.program.attrs),
                backend=backend,
                limits=parse_limits(grammar.program.limits, limits),
                on=on,
            )
        derived = time.process_time()
        tell_notes(scene.notes)
        with working(f"writing {output.name}"):
            tell_notes(save(scene, output, instancing=instancing))
        report |= run_report(scene, derived - started, time.process_time() - derived, output)
        for line in () if as_json else scene_lines(scene, output):
            click.echo(line)
    if as_json:
        click.echo(json.dumps(report))


def scene_lines(scene: Scene, output: Path) -> list[str]:
    """What `run` tells a person about what it wrote."""
    where = "" if scene.backend == "cpu" else f" on {scene.backend}"
    told = f"{output}: {len(scene.instances)} terminals in {scene.seconds:.3g} s{where}"
    return [told, *report_lines(scene.reports)]


def run_report(scene: Scene, seconds: float, writing: float, output: Path) -> dict[str, object]:
    """What `run --json` prints; seconds are CPU seconds of deriving, start-up not counted."""
    return {
        "output": str(output),
        "terminals": len(scene.instances),
        "shapes": scene.shapes,
        "generations": scene.generations,
        "seconds": round(seconds, 6),
        "seconds_writing": round(writing, 6),
        "peak_memory_bytes": peak_memory(),
        "seed": scene.seed,
        "backend": scene.backend,
        "device": device_record(scene.backend),
        "reports": {
            key: {"sum": total, "count": count} for key, (total, count) in scene.reports.items()
        },
    }


def peak_memory() -> int:
    """The most memory this process ever held, in bytes; 0 where the system does not tell."""
    try:
        import resource
    except ImportError:  # Windows
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024
