"""The commands `run`, `check` and `fmt`, and where all commands come together: the only code that
exits. `infer`, `edit`, `vary` and `render` stand in files of their own.

Each command reads files, calls the library, and prints either a few lines for a person or, with
`--json`, one object for a machine. Exit codes: 0 fine, 1 the user's file is wrong, 2 the command is
wrong. Libraries are imported inside the commands, so that each starts in a blink.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ipmlang import options
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, fail
from ipmlang.edit_building_commands import edit
from ipmlang.infer_command import infer_file
from ipmlang.render_command import render_file
from ipmlang.telling import findings_record, report_lines, show, working
from ipmlang.vary_command import vary_file

if TYPE_CHECKING:
    from ipmlang.runtime.scene import Scene

USER_FILE_WRONG, COMMAND_WRONG = 1, 2
COMMAND_CODES = frozenset(
    {"unknown-attribute", "wrong-attribute-type", "attribute-out-of-range", "no-such-backend",
     "unknown-format", "unknown-method", "unknown-style", "bad-command", "nothing-selected"}
)  # fmt: skip


def run_command_line(arguments: Sequence[str]) -> int:
    """Run one command and return its exit code; nothing but diagnostics reaches the user."""
    try:
        code = commands.main(args=list(arguments), prog_name="ipmlang", standalone_mode=False)
        return code if isinstance(code, int) else 0
    except click.ClickException as error:
        error.show()
        return COMMAND_WRONG
    except IpmError as error:
        return tell_errors(error.diagnostics, "--json" in arguments)
    except (KeyboardInterrupt, click.Abort):  # click turns the first into the second
        click.echo("stopped: no file was left half written", err=True)
        return COMMAND_WRONG
    except SystemExit:  # what click makes of a pipe that nobody reads any more
        return 0
    except OSError as error:  # files are explained where they are opened: this is printing
        reason = (error.strerror or str(error)).lower()
        what = f"use `{error.filename}`" if error.filename else "print the result"
        click.echo(f"error[system]: cannot {what}: {reason}", err=True)
        return USER_FILE_WRONG
    except MemoryError:
        click.echo("error[memory]: there is no memory left for it; nothing was written", err=True)
        return USER_FILE_WRONG


def tell_errors(diagnostics: Sequence[Diagnostic], as_json: bool) -> int:
    """Print the errors that ended a command, as one object too if that was asked for; the code."""
    show(diagnostics)
    if as_json:
        click.echo(json.dumps(findings_record(diagnostics)))
    return exit_code(diagnostics)


def exit_code(diagnostics: Sequence[Diagnostic]) -> int:
    """2 when the command itself asked for something that does not exist, else 1."""
    command = any(each.code in COMMAND_CODES for each in diagnostics)
    return COMMAND_WRONG if command else USER_FILE_WRONG


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 96})
@click.version_option(package_name="ipmlang", prog_name="ipmlang")
def commands() -> None:
    """A grammar language for procedural modelling.

    \b
    ipmlang infer garden.svg -o garden.ipm     read a drawing, print its grammar
    ipmlang run garden.ipm -o new.svg          derive a grammar into a drawing or a model
    """


commands.add_command(infer_file)
commands.add_command(edit)
commands.add_command(vary_file)
commands.add_command(render_file)


@commands.command()
@click.argument("file", type=click.Path(path_type=Path, readable=False))
@click.option(
    "-o",
    "--output",
    required=True,
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
@click.option(
    "--backend",
    type=click.Choice(["auto", "cpu", "gpu"]),
    default="auto",
    show_default=True,
    help="what derives the grammar",
)
@options.LIMIT
@options.ALLOW_OUTSIDE
@click.option("--instancing", is_flag=True, help="write glb instances with EXT_mesh_gpu_instancing")
@options.JSON
def run(
    file: Path,
    output: Path,
    seed: int | None,
    settings: tuple[str, ...],
    style: str | None,
    on: str | None,
    backend: str,
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
    from ipmlang.runtime.export import check_output, save

    check_output(output)
    grammar = load(file, allow_outside=allow_outside, style=style)
    stood_on = [] if on is None else [Path(on), Path(on.rpartition("#")[0])]
    keep_apart([output], [*grammar.checked.loaded.paths, *stood_on])
    show(grammar.warnings)
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
    for note in scene.notes:
        click.echo(f"note: {note}", err=True)
    with working(f"writing {output.name}"):
        notes = save(scene, output, instancing=instancing)
    for note in notes:
        click.echo(f"note: {note}", err=True)
    report = run_report(scene, derived - started, time.process_time() - derived, output)
    if as_json:
        click.echo(json.dumps(report))
    else:
        click.echo(f"{output}: {len(scene.instances)} terminals in {report['seconds']:.3g} s")
        for line in report_lines(scene.reports):
            click.echo(line)


@commands.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path, readable=False))
@options.ALLOW_OUTSIDE
@options.JSON
def check(files: tuple[Path, ...], allow_outside: bool, as_json: bool) -> None:
    """Report every error of each grammar in FILES.

    \b
    Example:
      ipmlang check garden.ipm
    """
    from ipmlang.compiler import check as check_grammar
    from ipmlang.compiler import load

    found: list[Diagnostic] = []
    for path in files:
        try:
            found += check_grammar(load(path, allow_outside=allow_outside)).diagnostics
        except IpmError as error:
            found += error.diagnostics
    errors = [each for each in found if each.severity == "error"]
    if as_json:
        click.echo(json.dumps({"files": len(files)} | findings_record(found)))
    else:
        show(found)
        numbers = ((len(files), "file"), (len(errors), "error"),
                   (len(found) - len(errors), "warning"))  # fmt: skip
        told = [f"{number} {word}{'s' * (number != 1)}" for number, word in numbers]
        click.echo(f"{told[0]}: {told[1]}, {told[2]}")
    if errors:
        raise click.exceptions.Exit(USER_FILE_WRONG)


@commands.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path, readable=False))
@click.option("--check", "only_check", is_flag=True, help="change nothing; exit 1 if it would")
@click.option("--stdout", is_flag=True, help="print the result instead of rewriting the file")
@options.JSON
def fmt(files: tuple[Path, ...], only_check: bool, stdout: bool, as_json: bool) -> None:
    """Lay out the grammars in FILES in the one way of the language; comments are kept.

    \b
    Example:
      ipmlang fmt garden.ipm
    """
    if stdout and as_json:
        raise fail("bad-command", "--stdout and --json both print: choose one")
    changed: list[str] = []
    problems: list[Diagnostic] = []
    for path in files:
        try:
            before, after = formatted(path)
            if before != after:
                changed.append(str(path))
            if stdout:
                click.echo(after, nl=False)
            elif before != after and not only_check:
                write_text(path, after)
        except IpmError as error:
            problems += error.diagnostics
    if as_json:
        click.echo(json.dumps({"files": len(files), "changed": changed}
                              | findings_record(problems)))  # fmt: skip
    else:
        show(problems)
    for name in () if as_json or stdout else changed:
        click.echo(f"{'would change' if only_check else 'formatted'} {name}")
    if problems or (only_check and changed):
        raise click.exceptions.Exit(USER_FILE_WRONG)


def formatted(path: Path) -> tuple[str, str]:
    """A file's text as it is and as it should be; a file with syntax errors is left alone."""
    from ipmlang.compiler.format import format_grammar
    from ipmlang.compiler.load import read_source
    from ipmlang.compiler.parse import parse

    source = read_source(path)
    grammar, diagnostics = parse(source)
    if diagnostics:
        raise IpmError(diagnostics)
    return source.text, format_grammar(grammar)


def write_text(path: Path, text: str) -> None:
    """Replace a text file as a whole."""
    from ipmlang.formats import FormatError
    from ipmlang.formats.atomic import write_files

    try:
        write_files({path: text.encode("utf-8")})
    except FormatError as error:
        raise fail("cannot-write", error.message, hint=error.hint) from error


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
