"""What inference makes of real models: the columns of Figure 6 of Demir and Aliaga 2016, and more.

    python tests/bench/bench_buildings.py [--save] [--flat] [NAME …]

Every model of shared/data/mesh that has several components is inferred, each in a process of its
own after a tiny one that pays for the imports, and compared once more with what the saved grammar
draws. `--save` keeps the table in RESULTS-buildings.md beside this file.
"""

from __future__ import annotations

import json
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

import ipmlang
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.inverse import infer

RESULTS = Path(__file__).with_name("RESULTS-buildings.md")
MODELS = Path(__file__).parents[2] / ".." / "shared" / "data" / "mesh"
PACK = {
    "barracks.obj", "building_F_nobase.obj", "building_H.obj", "castle.obj", "market.obj",
    "scaffolding.obj", "tower_A.obj", "wall_straight.obj", "warehouse_boxes.glb",
    "warehouse_roof.glb", "warehouse_shelf.glb", "windmill_fan.obj",
}  # fmt: skip
ARCHITECTURE = PACK | {"fzk_haus.obj", "recast_nav_test.obj"}
TINY = "\n".join(
    [f"v {x} {y} {k % 2}" for k in range(2) for x, y in ((k * 5, 0), (k * 5 + 1, 0), (k * 5, 1))]
    + ["f 1 2 3", "f 4 5 6"]
)
HEAD = """# Real models

Every model of shared/data/mesh that has several components, as `bench_buildings.py --save` found
it. Components, labels (shapes up to a rigid motion or a mirror), rules (in brackets:
drawn twice or more) and terminals are those of the paper's Figure 6. Bytes: of the file, and of the
grammar with its terminals beside them as a share of it. Tokens: of one placement per component, and
of the grammar. Under rules: share of the components with a twin that stand under something that
repeats. Error: share of the diagonal. Seconds of CPU time on a machine on which
`sum(i * i for i in range(10**6))` takes {loop:.3f} s; all of it: reading, proof and printing.

"""
COLUMNS = (
    "model", "triangles", "components", "labels", "rules", "terminals", "bytes", "share",
    "tokens flat", "tokens", "ratio", "under rules", "error", "seconds", "MB",
)  # fmt: skip


def measured(name: str, flat: bool) -> dict[str, object]:
    """The report of a model as a record; what could not be inferred has its message."""
    with tempfile.TemporaryDirectory(prefix="ipmlang-bench-") as folder:
        tiny = Path(folder) / "tiny.obj"
        tiny.write_text(TINY, encoding="utf-8")
        infer(tiny)
        before = time.process_time()
        try:
            found = infer(MODELS / name, flat=flat)
        except IpmError as error:
            return {"name": name, "message": str(error).splitlines()[0]}
        seconds = time.process_time() - before
        found.save(Path(folder) / "found.ipm")
        assert not ipmlang.load(Path(folder) / "found.ipm").warnings
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {"name": name, "cpu": seconds, "peak": peak, **found.report.as_record()}


def in_its_own_process(name: str, flat: bool) -> dict[str, object]:
    """The record of a model that was measured alone."""
    words = [sys.executable, __file__, "--one", name, *(["--flat"] if flat else [])]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode:
        return {"name": name, "message": done.stderr.strip().splitlines()[-1]}
    return dict(json.loads(done.stdout))


def row(record: dict[str, object]) -> tuple[str, ...]:
    """A line of the table."""
    if "message" in record:
        return (str(record["name"]), str(record["message"]))
    size = _number(record, "grammar_bytes") + _number(record, "parts_bytes")
    return (
        str(record["name"]),
        f"{record['triangles']}",
        f"{record['elements']}",
        f"{record['labels']}",
        f"{record['rules']} ({record['rules_twice']})",
        f"{record['terminals']}",
        f"{record['source_bytes']}",
        f"{size / _number(record, 'source_bytes'):.2f}",
        f"{record['tokens_flat']}",
        f"{record['tokens']}",
        f"{_number(record, 'ratio'):.2f}",
        f"{_number(record, 'explained_repeated'):.0%}",
        f"{_number(record, 'max_error'):.1e}",
        f"{_number(record, 'cpu'):.1f}",
        f"{_number(record, 'peak'):.0f}",
    )


def _number(record: dict[str, object], key: str) -> float:
    return float(str(record[key]))


def summary(records: list[dict[str, object]]) -> list[str]:
    """The medians that are asked for."""
    told = [each for each in records if "message" not in each]
    sizes = [
        (_number(each, "grammar_bytes") + _number(each, "parts_bytes"))
        / _number(each, "source_bytes")
        for each in told
        if each["name"] in PACK
    ]
    ratios = [_number(each, "ratio") for each in told if each["name"] in ARCHITECTURE]
    covered = [_number(each, "explained_repeated") for each in told if each["name"] in ARCHITECTURE]
    lines = []
    if sizes:
        lines.append(f"Asset packs ({len(sizes)}): median share {statistics.median(sizes):.2f}.")
    if ratios:
        lines.append(f"Architecture ({len(ratios)}): median ratio {statistics.median(ratios):.2f}.")
    if covered:
        under = statistics.median(covered)
        lines.append(
            f"Components with a twin that stand under rules, architecture: median {under:.0%}."
        )
    return lines


def table(records: list[dict[str, object]]) -> str:
    """The whole page."""
    started = time.process_time()
    sum(i * i for i in range(10**6))
    head = HEAD.format(loop=time.process_time() - started)
    lines = ["| " + " | ".join(COLUMNS) + " |", "|---|" + "--:|" * (len(COLUMNS) - 1)]
    lines += ["| " + " | ".join(row(each)) + " |" for each in records]
    return head + "\n".join([*lines, "", *summary(records)]) + "\n"


def main(words: list[str]) -> None:
    """The command."""
    names = [word for word in words if not word.startswith("--")]
    flat = "--flat" in words
    if "--one" in words:
        print(json.dumps(measured(names[0], flat)))
        return
    records = []
    for path in sorted(MODELS.glob("*")):
        if names and path.name not in names and path.stem not in names:
            continue
        record = in_its_own_process(path.name, flat)
        if "message" in record and not names:
            continue
        records.append(record)
        print(" ".join(row(record)), flush=True)
    text = table(records)
    print(text)
    if "--save" in words:
        RESULTS.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
