"""Textbook L-systems recovered from drawings of one path: a table by decimals of the coordinates.

    python tests/bench/bench_paths.py [--save] [NAME …]

Each system is drawn as one `<path>` with 0 to 6 decimals on a page 430 wide, inferred, and counted
where rules draw it within 1e-6 of the diagonal. `--save` also writes the table to RESULTS-paths.md
beside this file.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from inverse.textbook import SYSTEMS, drawn

from ipmlang.compiler.diagnostics import IpmError
from ipmlang.inverse import infer

DECIMALS = (0, 1, 2, 3, 4, 6)
SIZE = 431.7
RESULTS = Path(__file__).with_name("RESULTS-paths.md")
HEAD = (
    f"| system | segments | {' | '.join(f'{each} decimals' for each in DECIMALS)} |\n"
    f"|---|--:|{'--:|' * len(DECIMALS)}"
)


def page(name: str, decimals: int) -> tuple[str, int]:
    """The drawing of a system, and of how many segments it is."""
    start, end = drawn(SYSTEMS[name])
    every = np.concatenate([start, end])
    scale = SIZE / max(np.ptp(every.real), np.ptp(every.imag))
    corner = complex(every.real.min(), every.imag.max())
    start, end = (np.conj(each - corner) * scale + 10 + 10j for each in (start, end))
    anew = np.concatenate([[True], np.abs(start[1:] - end[:-1]) > 1e-6])

    def told(point: complex) -> str:
        return f"{point.real:.{decimals}f} {point.imag:.{decimals}f}"

    pairs = zip(start.tolist(), end.tolist(), anew.tolist(), strict=True)
    data = "".join((f"M{told(a)}" if lifts else "") + f"L{told(b)}" for a, b, lifts in pairs)
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIZE + 20:g} {SIZE + 20:g}">'
    return f'{head}<path fill="none" stroke="#000" d="{data}"/></svg>', len(start)


def cell(name: str, decimals: int, folder: Path) -> tuple[str, bool]:
    """Tokens and seconds, or a dash; whether the system was recovered."""
    path = folder / "drawn.svg"
    path.write_text(page(name, decimals)[0], encoding="utf-8")
    began = time.process_time()
    try:
        found = infer(path)
    except IpmError:
        return "error", False
    seconds = time.process_time() - began
    good = "asset" not in found.text and "-->" in found.text and found.report.max_error < 1e-6
    return (f"{found.report.tokens} in {seconds:.1f} s" if good else f"– {seconds:.1f} s"), good


def main() -> None:
    """Print the table and how many were recovered."""
    names = [each for each in sys.argv[1:] if each != "--save"] or list(SYSTEMS)
    print(HEAD)
    lines, recovered = [], dict.fromkeys(DECIMALS, 0)
    with tempfile.TemporaryDirectory(prefix="ipmlang-") as folder:
        for name in names:
            cells = {each: cell(name, each, Path(folder)) for each in DECIMALS}
            for each, (_, good) in cells.items():
                recovered[each] += good
            told = " | ".join(text for text, _ in cells.values())
            lines.append(f"| {name} | {page(name, 0)[1]} | {told} |")
            print(lines[-1], flush=True)
    each_of = ", ".join(f"{count} with {each}" for each, count in recovered.items())
    summary = f"Recovered of {len(names)}: {each_of} decimals. Cells are tokens and CPU seconds."
    print(f"\n{summary}")
    if "--save" in sys.argv:
        text = [
            "# L-systems recovered from drawings of one path",
            "",
            summary,
            "",
            HEAD,
            *lines,
            "",
        ]
        RESULTS.write_text("\n".join(text), encoding="utf-8")


if __name__ == "__main__":
    main()
