"""Options that several commands have: spelled, named and explained once.

Each is a decorator of click; what the words after them mean is read in `arguments`.
"""

from __future__ import annotations

import click

SET = click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    help="give an attribute a value; may be repeated",
)
BACKEND = click.option(
    "--backend",
    type=click.Choice(["auto", "cpu", "gpu"]),
    default="cpu",
    show_default=True,
    help="what derives the grammar; auto: the graphics card if there is one",
)
LIMIT = click.option(
    "--limit",
    "limits",
    multiple=True,
    metavar="KIND=NUMBER",
    help="stop at so many shapes, steps, depth or bytes of memory",
)
ALLOW_OUTSIDE = click.option(
    "--allow-outside", is_flag=True, help="let assets lie outside the grammar's folder"
)
STYLE = click.option("--style", metavar="NAME", help="derive the grammar in one of its styles")
JSON = click.option("--json", "as_json", is_flag=True, help="print one JSON object")
