"""From a path to parsed files: the grammar, all that it imports, and what it refers to.

Every file is read once, whatever the ways to it; its names are qualified by the shortest one. What
is wrong is collected, not raised, apart from a main file that cannot be read at all. Nothing leaves
the grammar's own folder unless that is allowed. No name inside a rule is looked up here.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache as remember
from pathlib import Path

from ipmlang.compiler import ast, collector
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, Source, fail, nearest
from ipmlang.compiler.parse import ItemCache, new_cache, parse
from ipmlang.compiler.references import References, Seen, is_inside, no_such_file

MAX_BYTES = 64_000_000
SUFFIX = ".ipm"


@dataclass(slots=True, eq=False)
class File:
    """One parsed file. `prefix` is `""` for the main file, `roofs.` for an imported one; `imports`
    finds other files by their names here; `references` answers for files that this one names.
    `problems` are of its syntax, its imports and the files that its items name.
    """

    source: Source
    grammar: ast.Grammar
    references: References
    prefix: str = ""
    imports: dict[str, File] = field(default_factory=dict)
    problems: list[Diagnostic] = field(default_factory=list)

    def problem(
        self,
        item: int,
        span: ast.Span,
        code: str,
        message: str,
        *,
        hint: str | None = None,
        suggestions: tuple[str, ...] = (),
    ) -> None:
        """Note what is wrong at a place of an item."""
        offset = self.grammar.offsets[item] if item < len(self.grammar.offsets) else 0
        self.problems.append(
            Diagnostic(
                code,
                message,
                source=self.source,
                start=offset + span.start,
                end=offset + span.end,
                hint=hint,
                suggestions=suggestions,
            )
        )


@dataclass(slots=True, eq=False)
class Cache:
    """What loading remembers from one time to the next: parsed items, and what stands in the files
    that grammars refer to, each for as long as it is unchanged.
    """

    items: ItemCache = field(default_factory=new_cache)
    seen: Seen = field(default_factory=Seen)


@dataclass(frozen=True, slots=True, eq=False)
class Loaded:
    """All files of a grammar, the main one first."""

    files: tuple[File, ...]

    @property
    def main(self) -> File:
        """The file that was asked for."""
        return self.files[0]

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """What was wrong so far, file by file."""
        return tuple(problem for file in self.files for problem in file.problems)

    @property
    def paths(self) -> tuple[Path, ...]:
        """Every file that was read or that the grammar refers to."""
        read = tuple(Path(file.source.path) for file in self.files)
        return read + tuple(path for file in self.files for path in file.references.found())


@remember
def shared_cache() -> Cache:
    """The cache of this process, which is what loading takes when none is given."""
    return Cache()


def load(path: str | Path, allow_outside: bool = False, cache: Cache | None = None) -> Loaded:
    """Read and parse a grammar and what it imports.

    Raises IpmError when the file itself cannot be read; all else is in the diagnostics.
    """
    source = read_source(Path(path))
    return load_source(source, Path(path).parent, allow_outside, cache)


def load_text(
    text: str, folder: Path = Path("."), allow_outside: bool = False, cache: Cache | None = None
) -> Loaded:
    """The same for a text; `folder` is where its assets and imports are looked for."""
    source = Source(str(folder / "<text>"), text)
    return load_source(source, folder, allow_outside, cache)


def load_source(
    source: Source, folder: Path, allow_outside: bool = False, cache: Cache | None = None
) -> Loaded:
    """The same for a source that was read already."""
    with collector.held():
        return _Loading(allow_outside, cache or shared_cache()).load(source, folder)


def read_source(path: Path) -> Source:
    """The text of a grammar file; raises IpmError when it is not one."""
    try:
        if path.is_dir():
            raise fail("is-a-folder", f"{path} is a folder, not a grammar file")
        if path.stat().st_size > MAX_BYTES:
            message = f"{path} is larger than {MAX_BYTES // 1_000_000} MB"
            raise fail("file-too-large", message, hint="keep bulk numbers in the parts file")
        return Source(str(path), _decoded(path, path.read_bytes()))
    except FileNotFoundError:
        raise no_such_file(path, f"there is no file {path}", f"*{SUFFIX}") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise fail("cannot-read", f"{path} cannot be read: {reason}") from error


def _decoded(path: Path, content: bytes) -> str:
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        message = f"{path} is not UTF-8: byte {error.start} on line {line} is wrong"
        raise fail("not-utf-8", message, hint="save the file as UTF-8 text") from error


@remember
def standard_library() -> Path:
    """The folder of `std/`: inside the installed package, or beside it in the source tree."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "stdlib"
    return inside if inside.is_dir() else package.parent / "stdlib"


class _Loading:
    """One call of `load`: the files found so far, by their real paths."""

    def __init__(self, allow_outside: bool, cache: Cache) -> None:
        self._allow_outside = allow_outside
        self._cache = cache
        self._files: dict[Path, File] = {}
        self._waiting: deque[File] = deque()

    def load(self, source: Source, folder: Path) -> Loaded:
        main = self._add(Path(source.path).resolve(), source, folder.resolve(), "")
        while self._waiting:
            self._import_all(self._waiting.popleft())
        for file in self._files.values():
            _refer(file)
        _report_cycles(main)
        return Loaded(tuple(self._files.values()))

    def _add(self, path: Path, source: Source, root: Path, prefix: str) -> File:
        grammar, problems = parse(source, self._cache.items)
        folder = Path(source.path).parent
        references = References(folder, root, self._allow_outside, self._cache.seen)
        file = File(source, grammar, references, prefix, problems=list(problems))
        self._files[path] = file
        self._waiting.append(file)
        return file

    def _import_all(self, file: File) -> None:
        for index, item in enumerate(file.grammar.items):
            if isinstance(item, ast.Import):
                self._import(file, index, item)

    def _import(self, file: File, index: int, item: ast.Import) -> None:
        name = item.alias or import_name(item.path)
        if name in file.imports:
            file.problem(
                index,
                item.span,
                "duplicate-name",
                f"another import is called `{name}` already",
                hint=f'give it a name of its own: import "{item.path}" as other',
            )
            return
        found = self._find(file, index, item)
        if found is None:
            return
        path, root = found
        if path.resolve() not in self._files:
            try:
                source = read_source(path)
            except IpmError as error:
                first = error.diagnostics[0]
                file.problem(index, item.span, first.code, first.message, hint=first.hint)
                return
            self._add(path.resolve(), source, root, f"{file.prefix}{name}.")
        file.imports[name] = self._files[path.resolve()]

    def _find(self, file: File, index: int, item: ast.Import) -> tuple[Path, Path] | None:
        """The path of an import and the folder that its own references must not leave."""
        standard = item.path.startswith("std/")
        root = standard_library() if standard else file.references.root
        folder = root if standard else file.references.folder
        words = item.path.removeprefix("std/") if standard else item.path
        path = folder / (words if words.endswith(SUFFIX) else words + SUFFIX)
        if (standard or not self._allow_outside) and not is_inside(path, root):
            file.problem(
                index,
                item.span,
                "outside-folder",
                f'"{item.path}" lies outside the folder of the grammar',
                hint="move it beside the grammar, or allow it with --allow-outside",
            )
            return None
        if not path.is_file():
            known = [_import_path(each, folder, standard) for each in folder.glob(f"*{SUFFIX}")]
            where = "the standard library" if standard else "the folder of this file"
            file.problem(
                index,
                item.span,
                "no-such-import",
                f'there is no "{item.path}" in {where}',
                suggestions=_near(item.path, known),
            )
            return None
        return path, root


def _near(path: str, known: Iterable[str]) -> tuple[str, ...]:
    """The nearest paths in the same folder: only their last words count."""
    folder, slash, name = path.rpartition("/")
    beside = [each for each in known if each.rpartition("/")[0] == folder]
    if not beside:
        return nearest(path, known)
    words = nearest(name, [each.rpartition("/")[2] for each in beside])
    return tuple(f"{folder}{slash}{word}" for word in words)


def import_name(path: str) -> str:
    """What an import without `as` is called: the last word of its path."""
    return path.rpartition("/")[2].removesuffix(SUFFIX)


def _import_path(path: Path, folder: Path, standard: bool) -> str:
    words = path.relative_to(folder).with_suffix("").as_posix()
    return f"std/{words}" if standard else words


def _refer(file: File) -> None:
    """Look for the files that the items of one file name."""
    for index, item in enumerate(file.grammar.items):
        for found in file.references.problems(item):
            file.problem(
                index,
                item.span,
                found.code,
                found.message,
                hint=found.hint,
                suggestions=found.suggestions,
            )


def _report_cycles(main: File) -> None:
    """Files that import each other, reported once a cycle at the import that closes it."""
    done: set[int] = set()
    trail: list[tuple[File, list[File]]] = []

    def enter(file: File) -> None:
        trail.append((file, list(file.imports.values())))

    enter(main)
    while trail:
        file, rest = trail[-1]
        if not rest:
            done.add(id(file))
            trail.pop()
            continue
        following = rest.pop(0)
        names = [each for each, _ in trail]
        if following in names:
            _report_cycle(file, following, names[names.index(following) :])
        elif id(following) not in done:
            enter(following)


def _report_cycle(file: File, following: File, cycle: list[File]) -> None:
    shown = [Path(each.source.path).name for each in (*cycle, following)]
    for index, item in enumerate(file.grammar.items):
        if isinstance(item, ast.Import) and _imported(file.imports, item) is following:
            file.problem(
                index,
                item.span,
                "import-cycle",
                f"these files import each other: {' > '.join(shown)}",
                hint="move what both need into a third file",
            )
            return


def _imported(imports: Mapping[str, File], item: ast.Import) -> File | None:
    return imports.get(item.alias or import_name(item.path))
