"""What the words of a command mean, and which combinations of files are refused.

Takes the texts after `--set` and `--limit` and the paths of a command; gives values, limits, or the
`IpmError` of a wrong command. Nothing is read or written here.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ipmlang.compiler.diagnostics import fail

if TYPE_CHECKING:
    from ipmlang.compiler.ir import Attribute, Limits

Value = int | float | bool | str
_KINDS = ("shapes", "steps", "depth", "memory")


def parse_settings(settings: Sequence[str], attrs: Sequence[Attribute]) -> dict[str, Value]:
    """`floors=6` to values by name: a text for an attribute that is one, else what it looks like.

    Names and ranges are not checked here.
    """
    texts = {each.name for each in attrs if each.type == "string"}
    values: dict[str, Value] = {}
    for setting in settings:
        name, equals, text = (part.strip() for part in setting.partition("="))
        if not equals or not name:
            missing = "name" if equals else "value"
            raise fail("bad-command", f"`--set {setting}` has no {missing}",
                       hint="write --set name=value, for example --set pickets=30")  # fmt: skip
        values[name] = _unquoted(text) if name in texts else parse_value(text)
    return values


def parse_value(text: str) -> Value:
    """The value a person means by a word on the command line.

    >>> [parse_value(text) for text in ("6", "2.5", "true", "red", '"6"')]
    [6, 2.5, True, 'red', '6']
    """
    if text in ("true", "false"):
        return text == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return _unquoted(text)


def _unquoted(text: str) -> str:
    return text[1:-1] if len(text) > 1 and text[0] == text[-1] == '"' else text


def parse_limits(limits: Limits, words: Sequence[str]) -> Limits:
    """The grammar's own limits with those of the command line over them."""
    from dataclasses import replace

    for word in words:
        kind, _, number = word.partition("=")
        try:
            value = int(float(number))
        except (ValueError, OverflowError):
            value = -1
        if kind not in _KINDS or value < 0:
            hint = f"write --limit kind=number; kinds are {', '.join(_KINDS)}"
            raise fail("bad-command", f"`--limit {word}` is not a limit", hint=hint)
        limits = replace(limits, **{kind: value})
    return limits


def check_inference(file: Path, output: Path | None) -> None:
    """Refuse, before any work, names that no grammar can bear or hold, and the loss of `file`."""
    for path in (file, *([output] if output else [])):
        if any("\ud800" <= letter <= "\udfff" for letter in str(path)):
            hint = "rename it: its name is not encoded as this system expects"
            raise fail("bad-command", f"no grammar can hold the name `{path.name}`", hint=hint)
    if file.is_dir():
        raise fail("is-a-folder", f"{file} is a folder, not a drawing or a model")
    if output is None:
        return
    if output.suffix != ".ipm":
        raise fail("bad-command", f"a grammar is written to a .ipm file, not `{output.name}`")
    if not output.absolute().parent.is_dir():
        message = f"cannot write `{output}`: there is no folder `{output.parent}`"
        raise fail("cannot-write", message, hint="make the folder first, or name one that exists")
    beside = [output.with_name(f"{output.stem}.parts{each}") for each in (".svg", ".obj", ".glb")]
    keep_apart([output, *beside], [file])


def keep_apart(outputs: Iterable[Path], inputs: Iterable[Path]) -> None:
    """Refuse to write over what is read."""
    taken = {path.resolve() for path in inputs}
    for path in outputs:
        if path.resolve() in taken:
            message = f"writing `{path}` would destroy what this command reads"
            raise fail("bad-command", message, hint="choose another name for the output")
