"""Files that a grammar names: whether they exist, may be read, and hold the node that is asked for.

In go references such as `house.parts.glb#window_2`, out come paths, names of nodes and columns, or
what is wrong. What stands in a file is asked of `formats` once, and again only when it changed. No
geometry is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias, TypeVar

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, fail, nearest

DRAWINGS = (".svg",)
MESHES = (".glb", ".obj", ".ply", ".stl")
NAMED = (".svg", ".glb", ".obj")
TABLES = (".svg", ".glb")
PICTURES = (".png", ".jpg", ".jpeg")
FIELDS = (".npy",)


def no_such_file(path: Path, message: str, kind: str = "*") -> IpmError:
    """The error for a path that is no file: it is a folder, or else `message`, with the names of
    this kind (`*.ipm`) that may have been meant.
    """
    if path.is_dir():
        return fail("is-a-folder", f"{path} is a folder, not a file")
    return IpmError([Diagnostic("no-such-file", message, suggestions=files_like(path, kind))])


def files_like(path: Path, kind: str = "*") -> tuple[str, ...]:
    """The files in the folder of a path whose names are near its own."""
    folder = path.absolute().parent
    names = [each.name for each in folder.glob(kind) if each.is_file()] if folder.is_dir() else []
    return nearest(path.name, names)


@dataclass(frozen=True, slots=True)
class Problem:
    """What is wrong with a reference."""

    code: str
    message: str
    hint: str | None = None
    suggestions: tuple[str, ...] = ()


Names: TypeAlias = "frozenset[str] | Problem | None"
Columns: TypeAlias = "tuple[str, ...] | Problem | None"
Channels: TypeAlias = "int | Problem"
_Kept = TypeVar("_Kept")
_Stamp: TypeAlias = tuple[str, str, int, int]


@dataclass(slots=True, eq=False)
class Seen:
    """What stood in files, by path, size and time of change; emptied when it grows large."""

    names: dict[_Stamp, Names] = field(default_factory=dict)
    columns: dict[_Stamp, Columns] = field(default_factory=dict)
    channels: dict[_Stamp, Channels] = field(default_factory=dict)
    limit: int = 1000


def is_inside(path: Path, folder: Path) -> bool:
    """Whether a path, links followed, lies in a folder."""
    try:
        return path.resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):
        return False


@dataclass(slots=True, eq=False)
class References:
    """References of one grammar file, relative to `folder`, not leaving `root` unless allowed."""

    folder: Path
    root: Path
    allow_outside: bool
    seen: Seen
    _files: dict[tuple[str, tuple[str, ...]], Path | Problem] = field(default_factory=dict)
    _stamps: dict[Path, tuple[str, int, int]] = field(default_factory=dict)

    def problems(self, item: ast.Item) -> Iterator[Problem]:
        """What is wrong with the files that an item names."""
        match item:
            case ast.Asset(reference=reference, stretch=(_, *_)) if _is_drawing(reference):
                message = f"{reference} is a drawing, and only parts of models are stretched"
                yield Problem("wrong-file-type", message, "`*(2)` before its name scales it")
            case ast.Asset(names, reference, by_name=True):
                for name in names:
                    yield from _problem(self.node(f"{reference}#{name}", DRAWINGS + MESHES))
            case ast.Asset(reference=reference):
                yield from _problem(self.node(reference, DRAWINGS + MESHES))
            case ast.Surface(reference=reference) | ast.Site(reference=reference):
                yield from _problem(self.node(reference, MESHES))
            case ast.Field(reference=reference, kind=kind):
                yield from _problem(self.channels(reference, kind))
            case ast.Table(reference=str(reference)):
                yield from _problem(self.table(reference))
            case ast.Start(place=ast.Place(kind="file", reference=str(reference))):
                yield from _problem(self.node(reference, DRAWINGS + MESHES))
            case _:
                pass

    def node(self, reference: str, suffixes: tuple[str, ...]) -> Path | Problem:
        """The path of a reference whose file exists, has a fitting suffix and holds the node."""
        name, mark, node = reference.partition("#")
        path = self.file(name, suffixes)
        if isinstance(path, Problem) or not mark:
            return path
        if path.suffix.lower() not in NAMED:
            return Problem("no-such-node", f"{name} has no named parts, so `#{node}` is not in it")
        known = self._remembered(self.seen.names, path, "", lambda: _names_in(path))
        if isinstance(known, Problem):
            return known
        if known is not None and node not in known:
            return Problem(
                "no-such-node", f"there is no `{node}` in {name}", suggestions=nearest(node, known)
            )
        return path

    def table(self, reference: str) -> Columns:
        """The columns of a table of a parts file; None where nothing can read it yet."""
        name, _, node = reference.partition("#")
        path = self.file(name, TABLES)
        if isinstance(path, Problem):
            return path
        return self._remembered(self.seen.columns, path, node, lambda: _columns_in(path, node))

    def channels(self, reference: str, kind: str) -> Channels:
        """How many channels a picture or a field has that fits a kind of context."""
        path = self.node(reference, PICTURES + FIELDS)
        if isinstance(path, Problem):
            return path
        found = self._remembered(self.seen.channels, path, "", lambda: _channels_in(path))
        if isinstance(found, Problem):
            return found
        return _unfit(path, kind, found) or found

    def file(self, name: str, suffixes: tuple[str, ...]) -> Path | Problem:
        """The path of a file that exists, lies in the folder and has a known suffix."""
        key = (name, suffixes)
        if key not in self._files:
            self._files[key] = self._look(name, suffixes)
        return self._files[key]

    def found(self) -> Iterator[Path]:
        """The files that were asked for and exist."""
        return (path for path in self._files.values() if isinstance(path, Path))

    def _look(self, name: str, suffixes: tuple[str, ...]) -> Path | Problem:
        path = self.folder / name
        if not self.allow_outside and not is_inside(path, self.root):
            return Problem(
                "outside-folder",
                f"{name} lies outside the folder of the grammar",
                "move it beside the grammar, or allow it with --allow-outside",
            )
        if path.suffix.lower() not in suffixes:
            return Problem("wrong-file-type", f"{name} is not a {_list(suffixes)} file")
        try:
            if path.is_file():
                return path
            meant = files_like(path)
        except OSError as error:
            return Problem("cannot-read", f"{name} cannot be read: {error.strerror}")
        return Problem(
            "no-such-file",
            f"there is no file {name} beside the grammar",
            suggestions=meant,
        )

    def _remembered(
        self, kept: dict[_Stamp, _Kept], path: Path, node: str, ask: Callable[[], _Kept]
    ) -> _Kept:
        if path not in self._stamps:
            stat = path.stat()
            self._stamps[path] = str(path.resolve()), stat.st_mtime_ns, stat.st_size
        where, changed, size = self._stamps[path]
        stamp = (where, node, changed, size)
        if stamp not in kept:
            if len(kept) >= self.seen.limit:
                kept.clear()
            kept[stamp] = ask()
        return kept[stamp]


def _problem(found: object) -> Iterator[Problem]:
    if isinstance(found, Problem):
        yield found


def _is_drawing(reference: str) -> bool:
    return reference.partition("#")[0].lower().endswith(DRAWINGS)


def _list(suffixes: tuple[str, ...]) -> str:
    return ", ".join(suffixes[:-1]) + f" or {suffixes[-1]}" if len(suffixes) > 1 else suffixes[0]


def _names_in(path: Path) -> Names:
    from ipmlang.formats import FormatError

    try:
        if path.suffix.lower() in DRAWINGS:
            from ipmlang.formats.svg import svg_ids

            return frozenset(svg_ids(path))
        from ipmlang.formats.known_parts import part_names

        return frozenset(part_names(path))
    except FormatError as error:
        return Problem("bad-file", f"{path.name}: {error.message}", error.hint)
    except ImportError:
        return None


def _columns_in(path: Path, node: str) -> Columns:
    from ipmlang.formats import FormatError

    if path.suffix.lower() not in DRAWINGS:
        return None
    try:
        from ipmlang.formats.svg import read_table

        return tuple(read_table(path, node).columns)
    except FormatError as error:
        return Problem("bad-table", f"{path.name}: {error.message}", error.hint)
    except ImportError:
        return None


def _channels_in(path: Path) -> Channels:
    from ipmlang.formats import FormatError
    from ipmlang.formats.pixels import pixel_extent

    try:
        return pixel_extent(path).channels
    except FormatError as error:
        return Problem("bad-file", error.message, error.hint)


def _unfit(path: Path, kind: str, channels: int) -> Problem | None:
    """Why a file cannot be a context of a kind."""
    picture = path.suffix.lower() in PICTURES
    name = f"{path.name} has {channels} channel{'s' * (channels > 1)}"
    if kind == "texture" and not picture:
        wanted = "scalar" if channels == 1 else "vector"
        message, hint = f"{path.name} is a field, not a picture", f"write `context … : {wanted} =`"
    elif kind == "scalar" and channels > 1:
        message = f"{name}, and a scalar field has one"
        hint = "save it as a picture in grey" if picture else "write `context … : vector =`"
    elif kind == "vector" and channels < (3 if picture else 2):
        message = f"{name}, and a vector field has {'red, green and blue' if picture else 'two'}"
        hint = "write `context … : scalar =`"
    else:
        return None
    return Problem("wrong-channels", message, hint)
