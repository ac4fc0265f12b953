"""Truncated, huge, cyclic and hostile input: a clear message with the place, exit code 1, nothing
half-written, memory and time bounded.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.commands import bounded, ipmlang

SVG = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '


def use_bomb() -> str:
    levels = "".join(
        f'<g id="g{k}">' + f'<use xlink:href="#g{k - 1}"/>' * 10 + "</g>" for k in range(1, 12)
    )
    body = f'<defs><rect id="g0" width="1" height="1"/>{levels}</defs><use xlink:href="#g11"/>'
    return f'{SVG} viewBox="0 0 9 9">{body}</svg>'


def deep_groups() -> str:
    return f'{SVG} viewBox="0 0 9 9">' + "<g>" * 200_000 + "</g>" * 200_000 + "</svg>"


def pattern_cycle() -> str:
    return (
        f'{SVG} viewBox="0 0 9 9"><pattern id="p" width="1" height="1" xlink:href="#q">'
        '<rect width="1" height="1" fill="url(#p)"/></pattern><pattern id="q" xlink:href="#p"/>'
        '<marker id="m"><path d="M0 0h3" marker-end="url(#m)"/></marker>'
        '<path d="M0 0h5" marker-end="url(#m)"/><rect width="5" height="5" fill="url(#p)"/></svg>'
    )


def gradient_cycle() -> str:
    return (
        f'{SVG} viewBox="0 0 9 9"><linearGradient id="a" xlink:href="#b"/>'
        '<linearGradient id="b" xlink:href="#a"/><rect width="5" height="5" fill="url(#a)"/></svg>'
    )


def style_bomb() -> str:
    rules = "".join(f"{'g ' * 40}.c{k} {{ fill: red }}" for k in range(500))
    groups = "<g>" * 60 + '<rect class="c1" width="1" height="1"/>' * 200 + "</g>" * 60
    return f'{SVG} viewBox="0 0 9 9"><style>{rules}</style>{groups}</svg>'


DRAWINGS: dict[str, Callable[[], str]] = {
    "empty": lambda: "",
    "not xml": lambda: "a house and a tree",
    "no drawing": lambda: "<html><body/></html>",
    "nothing drawn": lambda: f"{SVG}/>",
    "cut off": lambda: f'{SVG} viewBox="0 0 9 9"><g><path d="M0 0 L',
    "use bomb": use_bomb,
    "deep groups": deep_groups,
    "pattern and marker cycles": pattern_cycle,
    "gradient cycle": gradient_cycle,
    "style bomb": style_bomb,
    "not a number": lambda: f'{SVG} viewBox="0 0 nan 9"><rect width="inf" height="1e400"/></svg>',
    "huge coordinates": lambda: f'{SVG} viewBox="0 0 9 9"><path d="M1e300 0 2e300 1 Z"/></svg>',
    "far away": lambda: f'{SVG} viewBox="0 1e39 9 9"><rect width="3" height="3"/></svg>',
    "empty box": lambda: f'{SVG} viewBox="0 0 0 0"><rect width="1" height="1"/></svg>',
    "singular": lambda: f'{SVG}><g transform="scale(0)"><rect width="1" height="1"/></g></svg>',
}  # fmt: skip


@pytest.mark.parametrize("name", DRAWINGS)
def test_a_bad_drawing_ends_cleanly(name: str, tmp_path: Path) -> None:
    (tmp_path / "bad.svg").write_text(DRAWINGS[name](), encoding="utf-8")
    done = bounded("infer", "bad.svg", "-o", "bad.ipm", folder=tmp_path)
    left = sorted(path.name for path in tmp_path.iterdir() if path.name != "bad.svg")
    if done.returncode:
        assert "bad.svg" in done.stderr
        assert left == []
    else:
        assert bounded("run", "bad.ipm", "-o", "again.svg", folder=tmp_path).returncode == 0


def test_the_collected_hostile_drawings_end_cleanly(data: Path, tmp_path: Path) -> None:
    for path in sorted((data / "hostile").glob("*.svg")):
        out = tmp_path / f"{path.stem}.ipm"
        done = bounded("infer", path, "-o", out, folder=tmp_path)
        assert out.exists() == (done.returncode == 0), path.name
        if done.returncode:
            assert path.name in done.stderr
    assert not list(tmp_path.glob("*.tmp*"))


GRAMMARS = {
    "grows wide": "A --> F(1) [+(9) A] [-(9) A]\nstart A",
    "grows long": "A --> F(1) A\nstart A",
    "grows as a string": "F --> F + F - F F\nstart F steps 1000000",
    "huge count": "A --> repeat(i < 1e15) { F(1) }\nstart A",
    "deep repeats": "A --> repeat(i < 1e5) { repeat(j < 1e5) { F(1) } }\nstart A",
    "not a number": "A(x) --> F(sqrt(x)) A(x - 1)\nstart A(3)",
    "divided by zero": "A(x) --> F(1 / x)\nstart A(0)",
    "too far": "A(x) : x < 1e308 --> *(1e200) F(1) A(x + 1)\nstart A(0)",
    "no production": "A(x) : x > 0 --> F(x)\nstart A(-1)",
    "missing asset": 'asset a = "nowhere.svg#a"\nstart a',
    "missing node": 'asset a = "parts.svg#b"\nstart a',
    "outside": 'asset a = "../../../../etc/passwd"\nstart a',
    "absolute": 'asset a = "/etc/passwd.svg"\nstart a',
    "import of itself": 'import "bad"\nstart F',
    "import from outside": 'import "../elsewhere"\nstart F',
    "missing import": 'import "nowhere"\nstart F',
    "deep brackets": "start " + "[" * 100_000 + "F" + "]" * 100_000,
    "deep expression": "start F(" + "(" * 100_000 + "1" + ")" * 100_000 + ")",
    "control characters": "start \x00\x01 F",
    "number too large": "start F(1e999)",
    "solids": "Lot --> extrude(9) comp { side: Facade | top: Roof }\nstart Lot on box(8, 11, 0)",
}


@pytest.mark.parametrize("name", GRAMMARS)
def test_a_bad_grammar_says_why(name: str, tmp_path: Path) -> None:
    (tmp_path / "parts.svg").write_text(
        f'{SVG}><rect id="a" width="1" height="1"/></svg>', encoding="utf-8"
    )
    (tmp_path / "bad.ipm").write_text(f"ipm 1\n{GRAMMARS[name]}\n", encoding="utf-8")
    done = bounded("run", "bad.ipm", "-o", "out.svg", "--limit", "memory=500000000",
                   "--limit", "shapes=2000000", folder=tmp_path)  # fmt: skip
    assert done.returncode == 1, name
    assert "error[" in done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.ipm", "parts.svg"]


def test_a_long_name_is_only_long(tmp_path: Path) -> None:
    name = "A" * 1_000_000
    (tmp_path / "long.ipm").write_text(f"ipm 1\n{name}B --> F\nstart {name}\n", encoding="utf-8")
    assert bounded("run", "long.ipm", "-o", "long.svg", folder=tmp_path).returncode == 0


@pytest.mark.parametrize(
    ("content", "says"),
    [(b"\xff\xfe\x00start F", "UTF-8"), (b"", "start"), (b"ipm 99\nstart F\n", "99")],
)
def test_a_file_that_is_no_grammar(content: bytes, says: str, tmp_path: Path) -> None:
    (tmp_path / "bad.ipm").write_bytes(content)
    done = ipmlang("check", "bad.ipm", folder=tmp_path)
    assert done.returncode == 1
    assert says in done.stderr


def test_what_is_not_executable_yet_is_named(tmp_path: Path) -> None:
    ivy = "Ivy --> march(1, 0) { top: Ivy | extruded: Bark }\nBark --> tube(0.1)\nstart Ivy"
    (tmp_path / "ivy.ipm").write_text(f"ipm 1\n{ivy}\n", encoding="utf-8")
    assert ipmlang("check", "ivy.ipm", folder=tmp_path).returncode == 0
    done = ipmlang("run", "ivy.ipm", "-o", "ivy.obj", folder=tmp_path)
    assert done.returncode == 1
    assert "march" in done.stderr and "tube" in done.stderr
