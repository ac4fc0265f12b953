"""The commands `check` and `fmt`, and where all commands come together: the only code that exits.
The others stand in files of their own.

Each command reads files, calls the library, and prints either a few lines for a person or, with
`--json`, one object for a machine. Exit codes: 0 fine, 1 the user's file is wrong, 2 the command is
wrong. Libraries are imported inside the commands, so that each starts in a blink.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import click

from ipmlang import options
from ipmlang.bench_command import bench
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, fail
from ipmlang.edit_building_commands import edit
from ipmlang.infer_command import infer_file
from ipmlang.render_command import render_file
from ipmlang.run_command import run_file
from ipmlang.telling import findings_record, show
from ipmlang.vary_command import vary_file

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
commands.add_command(run_file)
commands.add_command(edit)
commands.add_command(vary_file)
commands.add_command(render_file)
commands.add_command(bench)


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
    from ipmlang.compiler import diagnose, load

    found: list[Diagnostic] = []
    for path in files:
        try:
            found += diagnose(load(path, allow_outside=allow_outside))
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
