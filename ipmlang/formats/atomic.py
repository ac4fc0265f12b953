"""Writing files so that a result appears whole or not at all.

Takes the contents of all files of one result; each is written beside its target under a temporary
name, and only when all are complete do they take their places. Trouble is a `FormatError` with a
hint, and then no temporary file stays and no earlier file is lost. Makes no folder but one that
belongs to the result: beside another file of it.
"""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TypeAlias

from ipmlang.formats import FormatError

Content: TypeAlias = "bytes | str | Iterable[bytes | str]"


def write_file(path: Path | str, content: Content) -> None:
    """Write one file whole or not at all; text is UTF-8."""
    write_files({Path(path): content})


def write_files(contents: Mapping[Path, Content]) -> None:
    """Write the files of one result together: all of them or none.

    Contents may be lazy (an iterable of parts); an error raised while making them leaves nothing
    behind either. A target that is a device or a pipe is written directly. A folder that is not
    there is made if it stands beside another of the files.
    """
    staged: list[tuple[Path, Path]] = []
    made: list[Path] = []
    try:
        for folder in _missing_folders(contents):
            with _explained(folder):
                folder.mkdir()
            made.append(folder)
        for path, content in contents.items():
            with _explained(path):
                target = Path(os.path.realpath(path))
                if _is_special(target):
                    _write_through(target, content)
                else:
                    staged.append(_stage(target, content))
        _place(staged)
    finally:
        for temporary, _ in staged:
            temporary.unlink(missing_ok=True)
        for folder in made:
            with contextlib.suppress(OSError):  # it holds files: the result is complete
                folder.rmdir()


def _missing_folders(contents: Mapping[Path, Content]) -> list[Path]:
    """The folders to make: each beside a file of the same result."""
    beside = {path.parent for path in contents}
    parents = dict.fromkeys(path.parent for path in contents)
    return [each for each in parents if each.parent in beside - {each} and not each.exists()]


@contextlib.contextmanager
def _explained(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise FormatError(
            f"cannot write `{path}`: {reason}",
            hint="name a file in a folder that exists and that you may write to",
        ) from error


def _is_special(target: Path) -> bool:
    """Whether a target is a device or a pipe; a folder or a protected file is an error."""
    try:
        mode = target.stat().st_mode
    except OSError:
        return False
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, "it is a folder")
    if not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, "it may not be changed")
    return not stat.S_ISREG(mode)


def _write_through(target: Path, content: Content) -> None:
    with target.open("wb") as file:
        for part in _parts(content):
            file.write(part)


def _stage(target: Path, content: Content) -> tuple[Path, Path]:
    """Write a complete temporary file beside the target, with the permissions it will have."""
    descriptor, name = tempfile.mkstemp(prefix=f".{target.name[:80]}.", dir=target.parent)
    temporary = Path(name)
    try:
        with os.fdopen(descriptor, "wb") as file:
            for part in _parts(content):
                file.write(part)
            file.flush()
            os.fsync(file.fileno())
        temporary.chmod(_permissions(target))
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    return temporary, target


def _parts(content: Content) -> Iterator[bytes]:
    pieces = [content] if isinstance(content, bytes | str) else content
    for piece in pieces:
        yield piece.encode("utf-8") if isinstance(piece, str) else piece


def _permissions(target: Path) -> int:
    """Those of the file that is replaced, else what the user's mask gives a new file."""
    try:
        return stat.S_IMODE(target.stat().st_mode)
    except OSError:
        mask = os.umask(0)
        os.umask(mask)
        return 0o666 & ~mask


def _place(staged: list[tuple[Path, Path]]) -> None:
    """Move the complete files to their places; if one fails, put the earlier ones back."""
    undo: list[tuple[Path, Path | None]] = []
    try:
        for temporary, target in staged:
            with _explained(target):
                undo.append((target, _kept(target) if len(staged) > 1 else None))
                os.replace(temporary, target)
    except BaseException:
        # The last entry is the one that failed: its target was never touched.
        for target, kept in undo[:-1]:
            if kept is None:
                target.unlink(missing_ok=True)
            else:
                os.replace(kept, target)
        raise
    finally:
        for _, kept in undo:
            if kept is not None:
                kept.unlink(missing_ok=True)


def _kept(target: Path) -> Path | None:
    """A second name for the file that is about to be replaced, None if there is none yet."""
    if not target.exists():
        return None
    descriptor, name = tempfile.mkstemp(prefix=f".{target.name[:80]}.", dir=target.parent)
    with os.fdopen(descriptor, "wb") as file:
        file.write(target.read_bytes())
    return Path(name)
