"""The command `bench`: how fast the CPU and the graphics card derive here, side by side.

Reads no file: the grammars of the tasks come with the package. Has them measured, prints a table
for a person, and writes all numbers with the device, the driver and the versions to a file if asked
to.
"""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.telling import working

if TYPE_CHECKING:
    from ipmlang.bench import Measured
    from ipmlang.runtime.gpu.device import Device

_HEADINGS = ("task", "terminals", "cpu s", "gpu s", "first", "edited", "resident", "cpu M/s",
             "gpu M/s", "gpu M tri/s", "cpu/gpu", "cpu/resident", "")  # fmt: skip
_SMALL = 0.01

Backend = Literal["cpu", "gpu"]


@dataclass(frozen=True, slots=True)
class Row:
    """One derivation, on the back ends that it was measured on."""

    name: str
    cpu: Measured | None
    gpu: Measured | None

    @property
    def ratio(self) -> float | None:
        """How many times quicker the card is, its table on the CPU too, if both were measured."""
        return None if self.cpu is None or self.gpu is None else self.cpu.best / self.gpu.best

    @property
    def resident_ratio(self) -> float | None:
        """The same where the table stays on the card."""
        if self.cpu is None or self.gpu is None or self.gpu.resident is None:
            return None
        return self.cpu.best / self.gpu.resident

    @property
    def remark(self) -> str:
        """What to know before reading the numbers: who else had a part, or that they differ."""
        if self.gpu is None:
            return ""
        if self.cpu is not None and self.cpu.terminals != self.gpu.terminals:
            return f"the CPU made {self.cpu.terminals:,} terminals"
        return "" if self.gpu.ran == "gpu" else f"derived by {self.gpu.ran}"

    def record(self) -> dict[str, object]:
        """The same as JSON."""
        sides = {"cpu": self.cpu, "gpu": self.gpu}
        measured = {name: each.record() for name, each in sides.items() if each is not None}
        return {
            "task": self.name,
            **measured,
            "ratio": self.ratio,
            "resident_ratio": self.resident_ratio,
        }


@click.command("bench")
@click.argument("tasks", nargs=-1, metavar="[TASK]...")
@click.option(
    "--backend",
    type=click.Choice(["both", "cpu", "gpu"]),
    default="both",
    show_default=True,
    help="who derives",
)
@click.option(
    "--scale",
    type=click.FloatRange(1e-6, 1000),
    help="so many times the work  [default: 1, without a graphics card 0.01]",
)
@click.option(
    "--repeat",
    type=click.IntRange(1, 1000),
    default=3,
    show_default=True,
    help="derivations after the first, of which the quickest counts",
)
@click.option(
    "--json",
    "output",
    type=click.Path(path_type=Path, readable=False),
    help="write all numbers to this file",
)
def bench(
    tasks: tuple[str, ...],
    backend: Literal["both", "cpu", "gpu"],
    scale: float | None,
    repeat: int,
    output: Path | None,
) -> None:
    """Measure how fast grammars are derived here. TASKs: facade, town, towers, tree, seeds.

    Seconds are the best of several runs, `first` and `edited` (an attribute changed) apart; those
    of the GPU end with the table of terminals in numpy, `resident` ones with it on the card.

    \b
    Example:
      ipmlang bench
      ipmlang bench facade town --scale 0.1 --json bench.json
    """  # fmt: skip
    from ipmlang.bench import machine, runs_of, warmed

    runs_of(tasks, _SMALL)  # a wrong name is told before a card is warmed up
    report: dict[str, object] = {"machine": machine()}
    card, ready = (None, 0.0) if backend == "cpu" else _card(required=backend == "gpu")
    if card is not None:
        seconds = {"ready_s": round(ready, 3), "compile_s": round(card.compile_seconds, 3)}
        report["device"] = card.info.record() | seconds
        click.echo(f"{card.info.renderer}, {card.info.driver}: ready in {ready:.3g} s")
    report["scale"] = scale = scale or _scale(card)
    backends: list[Backend] = ["cpu"] if backend != "gpu" else []
    backends += ["gpu"] if card is not None else []
    if "cpu" in backends:
        warmed("cpu")  # whose modules would be imported in the first task's time
    rows = _measured(tasks, scale, backends, repeat)
    report["tasks"] = [row.record() for row in rows]
    for line in _table(rows):
        click.echo(line)
    if output is not None:
        _write(output, report)


def _card(*, required: bool) -> tuple[Device | None, float]:
    """The device, and in how many seconds it was ready; None and a note where there is none."""
    from ipmlang.bench import warmed
    from ipmlang.runtime.gpu.device import device

    begun = time.perf_counter()
    try:
        card = device()
    except IpmError as error:
        if required:
            raise
        click.echo(f"note: only the CPU is measured: {error.diagnostics[0].message}", err=True)
        return None, 0.0
    with working("compiling the shader"):
        warmed("gpu")
    return card, time.perf_counter() - begun


def _scale(card: Device | None) -> float:
    """How much of the work is measured where nobody says."""
    if card is not None and not card.is_software:
        return 1.0
    why = "no graphics card" if card is None else f"{card.info.renderer} is no graphics card"
    told = f"note: {why}: {_SMALL:g} of the work is measured; --scale 1 for all of it"
    click.echo(told, err=True)
    return _SMALL


def _measured(
    tasks: Sequence[str], scale: float, backends: Sequence[Backend], repeat: int
) -> list[Row]:
    """Every derivation on every back end, one after the other."""
    from ipmlang.bench import measure, runs_of

    rows = []
    for run in runs_of(tasks, scale):
        with working(f"measuring {run.name}"):
            found = {backend: measure(run, backend, repeat) for backend in backends}
        rows.append(Row(run.name, found.get("cpu"), found.get("gpu")))
    return rows


def _table(rows: Sequence[Row]) -> list[str]:
    """What a person reads: a line a task, columns under each other."""
    columns = zip(_HEADINGS, *(_cells(row) for row in rows), strict=True)
    shown = [column for column in columns if any(column[1:])]
    wide = [max(map(len, column)) for column in shown]
    return [
        "  ".join([f"{name:<{wide[0]}}", *map(str.rjust, numbers, wide[1:])]).rstrip()
        for name, *numbers in zip(*shown, strict=True)
    ]


def _cells(row: Row) -> tuple[str, ...]:
    """The numbers of a task; blanks for a back end that was not measured."""
    known = row.gpu or row.cpu
    assert known is not None  # some back end is always measured
    sides = row.cpu, row.gpu
    return (
        row.name,
        f"{known.terminals:,}",
        *("" if each is None else _short(each.best) for each in sides),
        _short(known.first),
        _short(known.edited),
        _short(None if row.gpu is None else row.gpu.resident),
        *("" if each is None else _short(each.terminals_per_s / 1e6) for each in sides),
        "" if row.gpu is None else _short(row.gpu.triangles_per_s / 1e6),
        _short(row.ratio),
        _short(row.resident_ratio),
        row.remark,
    )


def _short(number: float | None) -> str:
    return "" if number is None else f"{number:.3g}"


def _write(output: Path, report: dict[str, object]) -> None:
    from ipmlang.formats import FormatError
    from ipmlang.formats.atomic import write_files

    try:
        write_files({output: (json.dumps(report, indent=2) + "\n").encode("utf-8")})
    except FormatError as error:
        raise fail("cannot-write", error.message, hint=error.hint) from error
