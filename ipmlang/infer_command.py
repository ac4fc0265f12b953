"""The command `infer`: from a drawing or a model to a grammar, with what a person may ask of it.

Reads a file, has its grammar found and proven, writes it, and prints a line for a person or,
with `--json`, one object for a machine. Why a grammar is as it is goes to standard error.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from ipmlang import options
from ipmlang.telling import working

if TYPE_CHECKING:
    from ipmlang.inverse import Inference, Up

Command = TypeVar("Command", bound=Callable[..., None])
WEIGHTS = {
    "near": "what counts when groups compete, 0 to 10: elements near each other",
    "similar": "similar elements, flipped ones too",
    "long": "long sequences",
    "many": "many places",
}


def weight_options(command: Command) -> Command:
    """The four weights of the paper's equation 5."""
    for name, doc in reversed(WEIGHTS.items()):
        command = click.option(
            f"--weight-{name}",
            f"weight_{name}",
            type=float,
            default=1.0,
            show_default=True,
            help=doc,
        )(command)
    return command


@click.command("infer")
@click.argument("file", type=click.Path(path_type=Path, readable=False))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, readable=False),
    help="the grammar to write, .ipm; its parts file goes beside it",
)
@click.option(
    "--method",
    type=click.Choice(["auto", "lsystem", "split", "docking"]),
    default="auto",
    show_default=True,
    help="which inverse method",
)
@click.option("--flat", is_flag=True, help="one placement per element, no rules: the baseline")
@click.option(
    "--up",
    type=click.Choice(["auto", "y", "z"]),
    default="auto",
    show_default=True,
    help="which axis is up in the file of a model",
)
@weight_options
@click.option(
    "--similarity",
    type=float,
    default=1.0,
    show_default=True,
    help="shapes at least so similar are one, 0.6 to 1",
)
@click.option(
    "--within",
    type=float,
    metavar="SHARE",
    help="how far the grammar may be off, 1e-6 to 0.1 of the file's diagonal",
)
@click.option(
    "--symmetrize",
    is_flag=True,
    help="the regular grammar of a drawing with noise; without --within, steps say how much",
)
@click.option(
    "--paper",
    is_flag=True,
    help="as the paper: for drawings rules for pairs that do not pay, too; for models octants",
)
@click.option("--explain", is_flag=True, help="tell what won in each round of the search, and why")
@options.JSON
def infer_file(
    file: Path,
    output: Path | None,
    method: str,
    flat: bool,
    up: Up,
    weight_near: float,
    weight_similar: float,
    weight_long: float,
    weight_many: float,
    similarity: float,
    within: float | None,
    symmetrize: bool,
    paper: bool,
    explain: bool,
    as_json: bool,
) -> None:
    """Read the drawing or model in FILE and write the grammar a person would have written.

    The grammar is derived and compared with the file before it is written. Of a model (.obj, .glb,
    .ply, .stl, .off) that is made of components, the split grammar is found; its terminals go to
    a .parts.obj or .parts.glb beside the grammar. Weights, similarity and symmetry are for
    drawings: a weight of 1 leaves choices to the length of the grammar; more prefers, less avoids.

    \b
    Example:
      ipmlang infer garden.svg -o garden.ipm
      ipmlang infer house.obj -o house.ipm
      ipmlang infer facade.svg -o facade.ipm --symmetrize
      ipmlang infer scene.svg -o scene.ipm --weight-near 4 --explain
    """  # fmt: skip
    from ipmlang.arguments import check_inference
    from ipmlang.inverse import Weights, infer

    check_inference(file, output)
    with working(f"reading {file.name}") as say:
        found = infer(
            file,
            method=method,
            flat=flat,
            up=up,
            weights=Weights(weight_near, weight_similar, weight_long, weight_many),
            similarity=similarity,
            within=within,
            symmetrize=symmetrize,
            paper=paper,
            explain=explain,
            progress=say,
        )
    if output is not None:
        found.save(output)
    tell_inference(found, output, as_json)


def tell_inference(found: Inference, output: Path | None, as_json: bool) -> None:
    """Print an inference: its report as JSON, its summary, or, without an output, the grammar."""
    if as_json:
        record = found.report.as_record()
        if found.explanation is not None:
            record["explanation"] = found.explanation.as_records()
        click.echo(json.dumps(record))
        return
    if found.explanation is not None:
        click.echo(found.explanation.text, nl=False, err=True)
    if output is None:
        click.echo(found.text, nl=False)
    else:
        click.echo(f"{output}: {found.report.summary()}")
