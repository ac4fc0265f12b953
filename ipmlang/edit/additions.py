"""Things brought into a grammar: assets from files, assets made here, and other grammars.

Takes drafts and gives drafts with one more asset or import, and the name it got. A file in the
grammar's folder is referred to where it is; one from elsewhere will be copied beside the grammar.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import fail
from ipmlang.compiler.load import SUFFIX
from ipmlang.compiler.references import DRAWINGS, MESHES, is_inside, no_such_file
from ipmlang.edit.draft import Content, Draft
from ipmlang.edit.files import file_names, files_with
from ipmlang.edit.symbols import free_name

PARTS = ".parts.svg"
_HEADS = (ast.Version, ast.Import, ast.Asset, ast.Canvas, ast.Axes)


def with_asset(draft: Draft, reference: str) -> tuple[Draft, str]:
    """The draft with an asset for `flower.svg` or `flower.svg#f1`, and its name. The file is looked
    for from here, then from the grammar's folder.
    """
    file, mark, node = reference.partition("#")
    path = found_file(draft, file)
    if path.suffix.lower() not in DRAWINGS + MESHES:
        known = ", ".join((*DRAWINGS, *MESHES))
        hint = f"assets stand in files that end in {known}"
        raise fail("wrong-file-type", f"{path.name} is no asset", hint=hint)
    draft, name = _referred(draft, path)
    called = free_name(draft.grammar, node or path.stem.split(".")[0])
    return _with_item(draft, ast.Asset((called,), name + mark + node)), called


def with_made_asset(draft: Draft, name: str, content: bytes) -> tuple[Draft, str]:
    """The draft with an asset that was made here, and its name, which must be free: `content` is an
    SVG with a node of that name. Its file will have the grammar's name in front.
    """
    taken = {*file_names(draft.grammar), *draft.added}
    file, number = f"{name}{PARTS}", 2
    while file in taken or f"{draft.path.stem}.{file}" in taken:
        file, number = f"{name}_{number}{PARTS}", number + 1
    draft = replace(draft, added={**draft.added, file: content})
    return _with_item(draft, ast.Asset((name,), file, by_name=True)), name


def with_import(draft: Draft, other: Draft, content: bytes | None) -> tuple[Draft, str]:
    """The draft with another grammar imported, and the name before its symbols. `content` is its
    text where it had to be adapted.
    """
    alias = free_name(draft.grammar, other.path.stem)
    inside = is_inside(other.path, draft.folder)
    name = _relative(other.path, draft.folder) if inside else other.path.name
    needed: dict[str, Content] = {}
    if content is not None or not inside:
        beside = files_with(other.grammar, other.folder)
        needed = {key: path for key, path in beside.items() if not _is_there(draft, key, path)}
        needed[other.path.name] = other.path if content is None else content
        name = other.path.name
    clash = sorted(key for key in needed if _differs(draft, key, needed[key]))
    if clash:
        message = f"both grammars have a file called {clash[0]}, with different contents"
        raise fail("name-clash", message, hint="rename the file of one of them")
    item = ast.Import(name.removesuffix(SUFFIX), alias)
    return _with_item(replace(draft, added={**draft.added, **needed}), item), alias


def found_file(draft: Draft, name: str) -> Path:
    """A file given on the command line: from here, else beside the grammar."""
    for path in (Path(name), draft.folder / name):
        if path.is_file():
            return path
    raise no_such_file(draft.folder / name, f"there is no file {name}")


def _referred(draft: Draft, path: Path) -> tuple[Draft, str]:
    """The name that a file has for the grammar; from elsewhere it comes along."""
    if is_inside(path, draft.folder):
        return draft, _relative(path, draft.folder)
    name, number = path.name, 2
    while _differs(draft, name, path):
        name, number = f"{path.stem}-{number}{path.suffix}", number + 1
    return replace(draft, added={**draft.added, name: path}), name


def _relative(path: Path, folder: Path) -> str:
    return path.resolve().relative_to(folder.resolve()).as_posix()


def _is_there(draft: Draft, name: str, path: Path) -> bool:
    return (draft.folder / name).resolve() == path.resolve()


def _differs(draft: Draft, name: str, content: Content) -> bool:
    """Whether another file of that name is there already, or will be."""
    if name in draft.added:
        return _read(draft.added[name]) != _read(content)
    there = draft.folder / name
    made = isinstance(content, bytes)  # it will bear the name of the new grammar in front
    return not made and there.is_file() and there.read_bytes() != _read(content)


def _read(content: Content) -> bytes:
    return content if isinstance(content, bytes) else content.read_bytes()


def _with_item(draft: Draft, item: ast.Item) -> Draft:
    """The item behind the last of its kind, else behind what a file begins with."""
    items = draft.grammar.items
    same = [k for k, each in enumerate(items) if isinstance(each, type(item))]
    first = _HEADS if isinstance(item, ast.Asset) else (ast.Version,)
    heads = same or [k for k, each in enumerate(items) if isinstance(each, first)]
    place = heads[-1] + 1 if heads else 0
    grammar = replace(draft.grammar, items=(*items[:place], item, *items[place:]))
    return replace(draft, grammar=grammar)
