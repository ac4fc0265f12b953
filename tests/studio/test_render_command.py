"""The command `render` as a person types it: files, words, and what it says when it cannot."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from PIL import Image

import ipmlang
from ipmlang.cli import run_command_line
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.studio.context import gl_context

TREE = """\
ipm 1
attr height : float = 3 in 1..9
Tree --> !(0.4) F(height) [&(40) F(2)] [^(40) F(1)]
start Tree
"""
FLAT = 'ipm 1\nstart color("#ff0000") !(1) F(10) +(90) F(5)\n'
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a tree, a drawing and a model, where the command runs."""
    monkeypatch.chdir(tmp_path)
    for name, text in (("tree.ipm", TREE), ("flat.ipm", FLAT), ("square.obj", SQUARE)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def render(*words: str) -> int:
    return run_command_line(["render", *words, "--size", "80x50"])


@pytest.mark.usefixtures("opengl", "no_device")
def test_a_context_is_released_and_its_errors_are_explained() -> None:
    with pytest.raises(IpmError) as caught, gl_context() as context:
        context.framebuffer([context.texture((10**6, 10**6), 4)])
    assert caught.value.diagnostics[0].code == "cannot-draw"
    assert "Invalid" in type(context.mglo).__name__


@pytest.mark.usefixtures("opengl")
class TestWithOpenGL:
    """What needs a picture to be drawn."""

    @pytest.mark.parametrize("suffix", ["png", "webp", "jpg"])
    def test_a_grammar_becomes_a_picture(self, folder: Path, suffix: str) -> None:
        assert render("tree.ipm", "-o", f"x.{suffix}") == 0
        with Image.open(folder / f"x.{suffix}") as image:
            assert image.size == (80, 50)

    def test_a_model_becomes_a_picture(
        self, folder: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert render("square.obj", "-o", "x.png", "--up", "y", "--json") == 0
        report = json.loads(capsys.readouterr().out)
        assert report["size"] == [80, 50]
        assert report["pictures"] == 1

    def test_which_way_is_up_may_be_said(self, folder: Path) -> None:
        words = ("--view", "front", "--no-ground", "--background", "transparent")
        for up in "yz":
            assert render("square.obj", "-o", f"{up}.png", "--up", up, *words) == 0
        drawn = [(folder / f"{up}.png") for up in "yz"]
        standing, lying = (Image.open(each).getchannel("A").getbbox() for each in drawn)
        assert standing is not None
        assert standing[3] - standing[1] > 30
        assert lying is None or lying[3] - lying[1] < 5

    @pytest.mark.parametrize("suffix", ["webp", "gif", "apng"])
    def test_a_turn_is_one_moving_picture(self, folder: Path, suffix: str) -> None:
        assert render("tree.ipm", "-o", f"x.{suffix}", "--turntable", "3") == 0
        with Image.open(folder / f"x.{suffix}") as image:
            assert image.n_frames == 3  # type: ignore[attr-defined]

    def test_a_turn_may_be_numbered_pictures(self, folder: Path) -> None:
        assert render("tree.ipm", "-o", "t-%03d.png", "--turntable", "3") == 0
        found = sorted(path.name for path in folder.glob("*.png"))
        assert found == ["t-000.png", "t-001.png", "t-002.png"]

    def test_an_attribute_changes_the_picture(self, folder: Path) -> None:
        assert render("tree.ipm", "-o", "a.png") == 0
        assert render("tree.ipm", "-o", "b.png", "--set", "height=9") == 0
        assert (folder / "a.png").read_bytes() != (folder / "b.png").read_bytes()

    def test_python_draws_too(self, folder: Path) -> None:
        scene = ipmlang.load("tree.ipm").run()
        ipmlang.render(scene, "x.png", size=(80, 50), view="10,20", background="white")
        with Image.open(folder / "x.png") as image:
            assert image.getpixel((0, 0)) == (255, 255, 255)


@pytest.mark.usefixtures("no_device")
def test_a_drawing_needs_no_opengl(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ipmlang.runtime.gpu.context._context", _without_opengl)
    assert render("flat.ipm", "-o", "x.png") == 0
    with Image.open(folder / "x.png") as image:
        assert image.size == (80, 50)
        assert image.getpixel((0, 0)) == (255, 255, 255)
        colors = image.convert("RGB").getcolors()
        assert colors is not None
        assert (255, 0, 0) in [color for _, color in colors]
    assert render("flat.ipm", "-o", "x.gif", "--turntable", "2") == 0


@pytest.mark.usefixtures("no_device")
def test_without_opengl_the_packages_are_named(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("ipmlang.runtime.gpu.context._context", _without_opengl)
    assert render("tree.ipm", "-o", "x.png") == 1
    said = capsys.readouterr().err
    assert "error[no-opengl]" in said
    assert "libEGL.so.1 not loaded" in said
    assert "apt-get install -y libegl1" in said
    assert not list(folder.glob("*.png"))


@pytest.mark.usefixtures("no_device")
def test_without_moderngl_pip_is_named(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "moderngl", None)
    assert render("tree.ipm", "-o", "x.png") == 1
    assert "pip install moderngl" in capsys.readouterr().err


def _without_opengl(version: int, **settings: str) -> None:
    raise Exception("libEGL.so.1 not loaded")  # what the library raises is no better


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("tree.ipm", "-o", "x.svg"), 2, ".png, .webp"),
        (("tree.ipm", "-o", "x.gif"), 2, ".png, .webp"),
        (("tree.ipm", "-o", "x.png", "--turntable", "4"), 2, "name-%03d.png"),
        (("tree.ipm", "-o", "x.png", "--turntable", "1"), 2, "2<=x<=360"),
        (("tree.ipm", "-o", "no/x.png"), 1, "there is no folder"),
        (("tree.ipm", "-o", "x.png", "--view", "botom"), 2, "is no view"),
        (("tree.ipm", "-o", "x.png", "--background", "pinkish"), 2, "is no colour"),
        (("tree.ipm", "-o", "x.png", "--set", "heigth=3"), 2, "height"),
        (("square.obj", "-o", "x.png", "--seed", "3"), 2, "for grammars"),
        (("absent.ipm", "-o", "x.png"), 1, "absent.ipm"),
        (("absent.glb", "-o", "x.png"), 1, "no such file"),
        (("flat.txt", "-o", "x.png"), 1, "no model"),
        (("broken.obj", "-o", "x.png"), 1, "no faces"),
        (("broken.glb", "-o", "x.png"), 1, "bad-model"),
    ],
)
def test_bad_input_is_explained(
    folder: Path, words: tuple[str, ...], code: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "broken.obj").write_text("v 0 0 0\n", encoding="utf-8")
    (folder / "broken.glb").write_bytes(b"glTF and no more")
    (folder / "flat.txt").write_text(FLAT, encoding="utf-8")
    assert render(*words) == code
    assert said in capsys.readouterr().err
    assert not [path for path in folder.iterdir() if path.name.startswith("x.")]


def test_a_wrong_size_is_explained(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command_line(["render", "tree.ipm", "-o", "x.png", "--size", "big"]) == 2
    assert "1600x1000" in capsys.readouterr().err


def test_what_is_read_is_not_written_over(folder: Path) -> None:
    (folder / "x.png").symlink_to("square.obj")
    assert render("square.obj", "-o", "x.png") == 2
    assert (folder / "square.obj").read_text(encoding="utf-8") == SQUARE
