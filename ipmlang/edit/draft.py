"""A grammar being edited: its tree, where its files lie, and what was done to it so far.

Each edit takes a draft and gives a new one; `save` in `saving.py` checks and writes the last.
Nothing is changed in place, and nothing here writes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache as remember
from pathlib import Path
from typing import TypeAlias

from ipmlang.compiler import ast
from ipmlang.compiler.check import check
from ipmlang.compiler.checked import Checked
from ipmlang.compiler.diagnostics import Diagnostic, IpmError
from ipmlang.compiler.format import format_expression, format_grammar
from ipmlang.compiler.load import Loaded, load, load_text
from ipmlang.edit.places import Found, Place, with_changes

Content: TypeAlias = "Path | bytes"


@dataclass(frozen=True, slots=True)
class Change:
    """One thing that an edit did: where, what stood there, what stands there now."""

    where: str
    before: str
    after: str


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """That a grammar was derived with all its files, and how many terminals it draws with seed 0:
    it holds for these very trees and files, not for what an edit makes of them.
    """

    grammar: ast.Grammar
    added: Mapping[str, Content]
    terminals: int


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """A grammar being edited. path: the file it was read from, whose folder its references start
    from; added: files that edits brought, by the name that the tree uses for them (a file to copy,
    or the content of one that was made); allow_outside: whether references may leave the folder;
    notes: what a person should know, as warnings; drawn: what was derived of it, or of a draft that
    it comes of.
    """

    path: Path
    grammar: ast.Grammar
    changes: tuple[Change, ...] = ()
    added: Mapping[str, Content] = field(default_factory=dict)
    allow_outside: bool = False
    notes: tuple[Diagnostic, ...] = ()
    drawn: Drawn | None = None

    @property
    def terminals(self) -> int | None:
        """How many terminals it draws with seed 0; None where nobody has derived it yet."""
        known = self.drawn
        if known is None or known.grammar is not self.grammar or known.added is not self.added:
            return None
        return known.terminals

    @property
    def text(self) -> str:
        """The grammar as it would be written now."""
        known = (text for grammar, text in tuple(_last_texts()) if grammar is self.grammar)
        found = next(known, None)
        if found is None:
            found = format_grammar(self.grammar)
            _last_texts().append((self.grammar, found))
        return found

    @property
    def folder(self) -> Path:
        """Where references start."""
        return self.path.parent


@remember
def _last_texts() -> deque[tuple[ast.Grammar, str]]:
    """The texts that were asked for last: what an edit was derived from is written, too."""
    return deque(maxlen=4)


def read(path: Path | str, *, allow_outside: bool = False) -> Draft:
    """The draft of a grammar file. Raises IpmError with every error of the file."""
    loaded = load(path, allow_outside)
    return Draft(Path(path), _checked(loaded).grammar, allow_outside=allow_outside)


def read_text(text: str, *, folder: Path | str = ".") -> Draft:
    r"""The same for a text whose files lie in `folder`.

    >>> read_text("ipm 1\nA --> F(1)   F\nstart A").text.splitlines()
    ['ipm 1', 'A --> F(1) F', 'start A']
    """
    loaded = load_text(text, Path(folder))
    return Draft(Path(folder) / "grammar.ipm", _checked(loaded).grammar)


def _checked(loaded: Loaded) -> Checked:
    checked = check(loaded)
    errors = [each for each in checked.diagnostics if each.severity == "error"]
    if errors:
        raise IpmError(errors)
    return checked


def with_parameters(
    draft: Draft, found: Mapping[int, Found], made: Mapping[int, ast.Expr]
) -> Draft:
    """The draft with places replaced, each noted as a change unless it stays as it was."""
    different = {number: expr for number, expr in made.items() if expr != found[number][1]}
    changes = tuple(
        Change(_where(found[number][0]), _shown(found[number][1]), _shown(expr))
        for number, expr in different.items()
    )
    grammar = with_changes(draft.grammar, different)
    return replace(draft, grammar=grammar, changes=draft.changes + changes)


def with_items(draft: Draft, items: Mapping[int, ast.Item], changes: list[Change]) -> Draft:
    """The draft with items replaced, by their numbers."""
    kept = tuple(items.get(k, item) for k, item in enumerate(draft.grammar.items))
    grammar = replace(draft.grammar, items=kept)
    return replace(draft, grammar=grammar, changes=(*draft.changes, *changes))


def _where(place: Place) -> str:
    """`Row: f distance`."""
    same = place.operation == place.parameter
    return f"{place.rule}: {place.operation}{'' if same else f' {place.parameter}'}"


def _shown(expr: ast.Expr) -> str:
    return format_expression(expr)
