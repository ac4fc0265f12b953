"""ipmlang: a grammar language for procedural modelling, and the way back from drawings to grammars.

The tour, from a text to a picture:

>>> import ipmlang
>>> fence = ipmlang.parse('''
... ipm 1
... attr pickets : int = 4 in 1..99 "how many"
... Fence --> repeat(i < pickets) { [F(30)] -(90) f(8) +(90) }
... start +(90) Fence
... ''')
>>> scene = fence.run(attrs={"pickets": 3})
>>> len(scene.instances)
3
>>> ipmlang.save(scene, "fence.svg")  # doctest: +SKIP

A file is `ipmlang.load("fence.ipm")`; `ipmlang.infer("fence.svg")` turns a drawing into a grammar;
`ipmlang.edit` changes one into another: values set, numbers randomised, symbols replaced.
Every error is an `ipmlang.IpmError`, whose `diagnostics` say what, where and how to mend it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from ipmlang.compiler.diagnostics import Diagnostic, IpmError

if TYPE_CHECKING:
    from ipmlang.compiler.checked import Checked
    from ipmlang.compiler.ir import Limits, Program
    from ipmlang.inverse import Inference, Weights
    from ipmlang.runtime.scene import Scene

__all__ = ["Grammar", "IpmError", "infer", "load", "parse", "render", "save"]
__version__ = "0.1.0"


@dataclass(frozen=True, slots=True)
class Grammar:
    """A checked grammar, ready to run. `warnings` are what the checker had to say."""

    checked: Checked
    program: Program
    warnings: tuple[Diagnostic, ...] = ()

    def run(
        self,
        *,
        seed: int | None = None,
        attrs: Mapping[str, int | float | bool | str] | None = None,
        backend: str = "cpu",
        limits: Limits | None = None,
        on: Path | str | None = None,
    ) -> Scene:
        """Derive the grammar into a scene: a table of instances in derivation order. Without a
        seed, which is seed 0, `start … choices` draws what it drew when it was written. `on` is a
        file whose faces or closed paths it starts on, instead of what its `start` names. `backend`:
        `cpu`, `gpu` (the graphics card, as far as it can) or `auto`: the card if there is one.

        Raises IpmError for an unknown attribute, a value out of range, a limit that was reached,
        and with `gpu` for a card that is not there, is full or fails.
        """
        from ipmlang.runtime import derive

        return derive(self.program, seed=seed, attrs=attrs, backend=backend, limits=limits, on=on)

    def format(self) -> str:
        """The grammar's text in the one layout of the language."""
        from ipmlang.compiler.format import format_grammar

        return format_grammar(self.checked.grammar)


def load(path: str | Path, *, allow_outside: bool = False, style: str | None = None) -> Grammar:
    """Read, check and lower the grammar in a file, in one of its styles if one is named.

    `allow_outside` lets assets and imports lie outside the grammar's own folder.
    Raises IpmError with every error of the file.
    """
    from ipmlang.compiler import compile_file

    return Grammar(*compile_file(Path(path), allow_outside=allow_outside, style=style))


def parse(text: str, *, folder: str | Path = ".", style: str | None = None) -> Grammar:
    """The same for a text; `folder` is where its assets and imports are looked for."""
    from ipmlang.compiler import compile_text

    return Grammar(*compile_text(text, folder=Path(folder), style=style))


def infer(
    path: str | Path,
    *,
    method: str = "auto",
    flat: bool = False,
    weights: Weights | None = None,
    similarity: float = 1.0,
    within: float | None = None,
    symmetrize: bool = False,
    paper: bool = False,
    explain: bool = False,
    up: Literal["auto", "y", "z"] = "auto",
) -> Inference:
    """Read a drawing or a model and find the grammar a person would have written for it.

    `flat` keeps one placement per element. `weights` (`ipmlang.inverse.Weights`) say what to prefer
    where groups compete; shapes at least so similar (0.6 to 1) are one; `within` is the share of
    the diagonal that the grammar may be off; `symmetrize` gives the regular grammar of a drawing
    with noise; `paper` also prints rules that do not pay; `explain` keeps what won in each round;
    `up` is the up axis in the file of a model. The result has the grammar, a report, the
    explanation and `save(path)`.
    """
    from ipmlang.inverse import infer as infer_file

    return infer_file(
        Path(path),
        method=method,
        flat=flat,
        weights=weights,
        similarity=similarity,
        within=within,
        symmetrize=symmetrize,
        paper=paper,
        explain=explain,
        up=up,
    )


def render(
    scene: Scene,
    path: str | Path,
    *,
    size: tuple[int, int] | None = None,
    view: str = "iso",
    ground: bool = True,
    background: str = "studio",
    lines: bool = False,
    turntable: int | None = None,
) -> None:
    """Draw a picture of a scene, lit and seen through a camera; the suffix says which format.

    `view`: front, back, left, right, top, iso, or "AZIMUTH,ELEVATION" in degrees; `turntable`: so
    many pictures all around it, in one .webp, .gif or .apng, or in name-%03d.png. Raises IpmError,
    also where there is no OpenGL; then it names the packages to install.
    """
    from ipmlang.studio import Look, draw
    from ipmlang.studio.look import parse_background, parse_view

    look = Look(size, parse_view(view), ground, parse_background(background), lines)
    draw(scene, look, Path(path), turntable)


def save(scene: Scene, path: str | Path) -> None:
    """Write a scene as svg, png, obj, glb, ply or stl, by the suffix; whole or not at all."""
    from ipmlang.runtime.export import save as save_scene

    save_scene(scene, Path(path))
