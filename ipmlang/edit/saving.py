"""From a draft to files: what goes beside the grammar, the check, and the writing.

The grammar is laid out, loaded again with all its files in a folder of its own, checked, and
derived unless the edit did that; only then is anything written, all of it or nothing. Files of its
own (`x.parts.svg` of `x.ipm`) bear the new name; other files keep theirs and never replace a
different file.
"""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from ipmlang.compiler import ast
from ipmlang.compiler.check import check
from ipmlang.compiler.checked import Checked
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, Source, fail
from ipmlang.compiler.load import SUFFIX, load_source
from ipmlang.compiler.lower import lower
from ipmlang.compiler.verify import verify
from ipmlang.edit.draft import Content, Draft
from ipmlang.edit.files import files_with, with_file_names
from ipmlang.edit.symbols import needed_names, without_names
from ipmlang.formats import FormatError

RESIDUAL, CHOICES = "residual-rows", "bad-choices"
OUTDATED = {
    RESIDUAL: "the residual was of the drawing as it was before this edit: it is left out",
    CHOICES: "the choices after `start` were of the grammar before this edit: they are left out",
}


@dataclass(frozen=True, slots=True, eq=False)
class Finished:
    """A checked result. text: the grammar; files: what stands beside it, by path, without the
    grammar itself; terminals: how many it draws with seed 0, None if no executor runs it yet.
    """

    text: str
    files: Mapping[Path, bytes]
    terminals: int | None
    warnings: tuple[Diagnostic, ...]


def save(draft: Draft, path: Path | str) -> Finished:
    """Check a draft and write it to `path` with the files that it needs there, all or none."""
    from ipmlang.formats.atomic import write_files

    path = Path(path)
    finished = finish(draft, path)
    contents: dict[Path, bytes] = {path: finished.text.encode("utf-8")}
    contents.update(finished.files)
    try:
        for each in finished.files:
            if each.parent != path.parent and path.parent.is_dir():
                each.parent.mkdir(parents=True, exist_ok=True)
        write_files(contents)
    except FormatError as error:
        raise fail("cannot-write", error.message, hint=error.hint) from error
    except OSError as error:
        raise fail("cannot-write", f"cannot write `{path}`: {error.strerror}") from error
    return finished


def finish(draft: Draft, path: Path) -> Finished:
    """What `save` would write to `path`, checked and derived. Raises IpmError for what is wrong
    with the result, and for a file that it would have to replace.
    """
    _check_name(path)
    while True:
        try:
            with staged(draft, path) as made:
                terminals, warnings = _proven(made, path, draft)
                files = _new_files(made.files, path)
                return Finished(made.text, files, terminals, draft.notes + warnings)
        except IpmError as error:
            draft = _without_outdated(draft, error)


def _without_outdated(draft: Draft, error: IpmError) -> Draft:
    """The draft without a record of the drawing as it was, if that alone is what is wrong: a
    residual of other terminals, choices of other rules. Raises the error for anything else.
    """
    code = error.diagnostics[0].code
    if code not in OUTDATED or not draft.changes:
        raise error
    items = tuple(
        replace(item, choices=None) if isinstance(item, ast.Start) and code == CHOICES else item
        for item in draft.grammar.items
        if not (isinstance(item, ast.Residual) and code == RESIDUAL)
    )
    grammar = replace(draft.grammar, items=items)
    unneeded = needed_names(draft.grammar) - needed_names(grammar)
    note = Diagnostic("outdated", OUTDATED[code], severity="warning")
    grammar = without_names(grammar, unneeded)
    if grammar == draft.grammar:
        raise error
    return replace(draft, grammar=grammar, notes=(*draft.notes, note))


def _check_name(path: Path) -> None:
    if path.suffix != SUFFIX:
        raise fail("bad-command", f"a grammar is written to a .ipm file, not `{path.name}`")
    if any(letter in path.stem for letter in '"\\#'):
        hint = 'choose a name without ", \\ and #'
        raise fail("bad-command", f"`{path.name}` cannot name its parts file", hint=hint)


# --------------------------------------------------------------------- files beside it


def _beside(draft: Draft, path: Path) -> dict[str, tuple[str, Content]]:
    """All files that the grammar needs, by the name that the tree has for them now: the name beside
    the new grammar, and what they hold.
    """
    moves = path.parent.resolve() != draft.folder.resolve()
    found: dict[str, tuple[str, Content]] = {}
    for name, file in files_with(draft.grammar, draft.folder, draft.added).items():
        found[name] = (_name_elsewhere(name, draft.path, path) if moves else name, file)
    for name, content in draft.added.items():
        found[name] = (f"{path.stem}.{name}" if isinstance(content, bytes) else name, content)
    return found


def _name_elsewhere(name: str, before: Path, after: Path) -> str:
    """A file's name beside a grammar in another folder: `x.parts.svg` of `x.ipm` becomes
    `y.parts.svg` of `y.ipm`; what lay outside the folder lies in it now.
    """
    if name.startswith(before.stem + ".parts."):
        return after.stem + name.removeprefix(before.stem)
    outside = ".." in Path(name).parts or Path(name).is_absolute()
    return Path(name).name if outside else name


def _bytes(content: Content) -> bytes:
    if isinstance(content, bytes):
        return content
    try:
        return content.read_bytes()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise fail("cannot-read", f"cannot read {content}: {reason}") from error


def _new_files(contents: Mapping[str, bytes], path: Path) -> dict[Path, bytes]:
    """Those that are not there yet; one that would replace a different file is refused, unless it
    is the grammar's own.
    """
    found: dict[Path, bytes] = {}
    for name, content in contents.items():
        target = path.parent / name
        if target.is_file() and target.read_bytes() == content:
            continue
        own = name.startswith(path.stem + ".")
        if (target.exists() and not own) or target.resolve() == path.resolve():
            message = f"`{target}` is there already and differs from the file to put there"
            raise fail("would-overwrite", message, hint="write the grammar to another folder")
        found[target] = content
    return found


# ----------------------------------------------------------------------------- proof


@dataclass(frozen=True, slots=True, eq=False)
class Staged:
    """A result in a folder of its own: the grammar's path there and its text, and all other files
    by their names beside it.
    """

    path: Path
    text: str
    files: Mapping[str, bytes]


@contextlib.contextmanager
def staged(draft: Draft, path: Path) -> Iterator[Staged]:
    """A folder that holds what would be written to `path`, while the block runs."""
    beside = _beside(draft, path)
    grammar = with_file_names(draft.grammar, lambda name: beside[name][0])
    text = replace(draft, grammar=grammar).text
    files = {name: _bytes(content) for name, content in beside.values()}
    with tempfile.TemporaryDirectory(prefix="ipmlang-") as made:
        for name, content in {path.name: text.encode("utf-8"), **files}.items():
            target = Path(made) / name
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
        yield Staged(Path(made) / path.name, text, files)


def _proven(made: Staged, path: Path, draft: Draft) -> tuple[int | None, tuple[Diagnostic, ...]]:
    """How many terminals the staged grammar draws, and warnings; errors are about `path`."""
    folder = made.path.parent
    with about(made, path):
        loaded = load_source(Source(str(made.path), made.text), folder, draft.allow_outside)
        checked = check(loaded)
        errors = [each for each in checked.diagnostics if each.severity == "error"]
        if errors:
            raise IpmError(errors)
        terminals = draft.terminals
        if terminals is None and not checked.not_ready:
            terminals = _count(checked)
    return terminals, tuple(_moved(each, folder, path.parent) for each in checked.diagnostics)


@contextlib.contextmanager
def about(made: Staged, path: Path) -> Iterator[None]:
    """Has errors of a staged grammar speak of the path that it stands for."""
    try:
        yield
    except IpmError as error:
        moved = [_moved(each, made.path.parent, path.parent) for each in error.diagnostics]
        raise IpmError(moved) from error


def _count(checked: Checked) -> int:
    from ipmlang.runtime import derive

    program = lower(checked)
    faults = verify(program)
    if faults:
        raise fail("compiler-fault", faults[0], hint="this is a fault of ipmlang: please report it")
    return len(derive(program).instances)


def _moved(diagnostic: Diagnostic, staged: Path, folder: Path) -> Diagnostic:
    """A diagnostic about a staged file, as one about the file that it stands for."""
    message = diagnostic.message.replace(f"{staged}{os.sep}", "")
    diagnostic = replace(diagnostic, message=message)
    source = diagnostic.source
    if source is None or not Path(source.path).is_relative_to(staged):
        return diagnostic
    path = folder / Path(source.path).relative_to(staged)
    return replace(diagnostic, source=Source(str(path), source.text))
