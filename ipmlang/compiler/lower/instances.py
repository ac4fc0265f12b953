"""From loaded files to units: one for each file as it is, and one more for each way it is changed.

A file is changed by a style of its own, and by items of files that import it whose names lead into
it: `roofs.Hip --> …` puts another rule in the place of `Hip`, for the file that says so and in all
that it imports. The same changes are one unit. Nothing here makes code.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import fail, nearest
from ipmlang.compiler.load import File, Loaded, import_name
from ipmlang.compiler.lower.names import Place, Unit
from ipmlang.compiler.ops import OPERATIONS
from ipmlang.compiler.styles import lineage, names_of, styles_of


@dataclass(frozen=True, slots=True)
class Change:
    """An item that redefines, and the way to the name from the unit that it changes."""

    path: tuple[str, ...]
    place: Place


Layer: TypeAlias = tuple[Change, ...]  # what stands in one file for one style; later ones win
Layers: TypeAlias = tuple[Layer, ...]
Below: TypeAlias = Mapping[int, Layers]  # what changes files that are imported further down
Told: TypeAlias = tuple[tuple[tuple[tuple[str, ...], int, int], ...], ...]
Key: TypeAlias = tuple[int, str | None, Told, tuple[tuple[int, Told], ...]]


def units_of(loaded: Loaded, style: str | None) -> list[Unit]:
    """All units of a program, the main one first, as a style of the main file if one is chosen."""
    known = styles_of(loaded.main.grammar)
    if style is not None and style not in known:
        message = f"`{loaded.main.source.path}` has no style `{style}`"
        close = nearest(style, known)
        hint = f"its styles: {', '.join(known)}" if known else "it has none"
        hint = f"did you mean `{close[0]}`?" if close else hint
        raise fail("unknown-style", message, hint=hint)
    instances = _Instances(loaded)
    instances.of(loaded.main, style, (), {}, "", "")
    units = instances.all()
    if len(units) > len(loaded.files):
        _share(units)
    return units


class _Instances:
    """The units made so far, by what they are made of."""

    def __init__(self, loaded: Loaded) -> None:
        self._asked = _asked(loaded)
        self._made: dict[Key, Unit] = {}
        self._waiting: deque[tuple[Unit, File, str | None, Layers, Below, str]] = deque()
        self._reached: dict[int, frozenset[int]] = {}

    def of(
        self,
        file: File,
        style: str | None,
        layers: Layers,
        below: Below,
        prefix: str,
        root: str,
    ) -> Unit:
        """The unit of a file in a style and with changes, of itself and of what it imports; `root`
        is the prefix of its styles.
        """
        reached = self._reach(file)
        below = {number: each for number, each in below.items() if number in reached}
        deeper = tuple((number, _told(each)) for number, each in sorted(below.items()))
        key = (id(file), style, _told(layers), deeper)
        if key not in self._made:
            styles = frozenset(styles_of(file.grammar))
            self._made[key] = Unit(file.grammar, file.source, prefix, own_styles=styles)
            self._waiting.append((self._made[key], file, style, layers, below, root))
        return self._made[key]

    def _reach(self, file: File) -> frozenset[int]:
        """The files that a file imports, and those that they import."""
        if id(file) not in self._reached:
            others = file.imports.values()
            self._reached[id(file)] = frozenset(map(id, others)).union(*map(self._reach, others))
        return self._reached[id(file)]

    def all(self) -> list[Unit]:
        """Every unit that can be reached from those asked for."""
        while self._waiting:
            self._fill(*self._waiting.popleft())
        return list(self._made.values())

    def _fill(
        self, unit: Unit, file: File, style: str | None, outer: Layers, below: Below, root: str
    ) -> None:
        styles = styles_of(file.grammar)
        written = []
        for number, item in enumerate(file.grammar.items):
            for name in names_of(item):
                path = tuple(name.split("."))
                if len(path) > 1:
                    written.append(Change(path, Place(unit, number)))
                else:
                    _define(unit, name, Place(unit, number))
        layers = _layers((tuple(written), *outer), styles, lineage(styles, style))
        for layer in layers:
            _redefine(unit, [each for each in layer if len(each.path) == 1])
        chosen = {
            item.alias or import_name(item.path): item.style
            for item in file.grammar.items
            if isinstance(item, ast.Import)
        }
        own = {alias: _within(layers, alias) for alias in file.imports}
        deeper = dict(below)
        for alias, other in file.imports.items():
            deeper[id(other)] = own[alias] + deeper.get(id(other), ())
        for alias, other in file.imports.items():
            prefix = f"{unit.prefix}{alias}."
            changes = own[alias] + below.get(id(other), ())
            unit.imports[alias] = self.of(other, chosen[alias], changes, deeper, prefix, prefix)
        for name in styles:
            if name in self._asked:
                unit.styles[name] = self.of(file, name, outer, below, f"{root}{name}.", root)


def _told(layers: Layers) -> Told:
    """Layers as a key: the same items of the same units are the same."""
    return tuple(
        tuple((each.path, id(each.place.unit), each.place.item) for each in layer)
        for layer in layers
    )


def _layers(given: Layers, styles: Mapping[str, ast.Style], chosen: Sequence[str]) -> list[Layer]:
    """Changes in the order in which they apply: of each layer first those of no style, then those
    of the chosen one and of what it extends; those of other styles are left out.
    """
    found: list[Layer] = []
    for layer in given:
        found.append(tuple(each for each in layer if each.path[0] not in styles))
        for name in chosen:
            inner = tuple(
                Change(each.path[1:], each.place) for each in layer if each.path[0] == name
            )
            found.append(inner)
    return [layer for layer in found if layer]


def _within(layers: Sequence[Layer], alias: str) -> Layers:
    """The changes of what is imported under a name."""
    found = (
        tuple(
            Change(each.path[1:], each.place)
            for each in layer
            if len(each.path) > 1 and each.path[0] == alias
        )
        for layer in layers
    )
    return tuple(layer for layer in found if layer)


# ------------------------------------------------------------------------- definitions


def _define(unit: Unit, name: str, place: Place) -> None:
    item = place.unit.grammar.items[place.item]
    if isinstance(item, ast.Rule):
        named = unit.interpretations if item.interpret else unit.rules
        named.setdefault(name, []).append(place)
    else:
        unit.defined[name] = place


def _redefine(unit: Unit, changes: Sequence[Change]) -> None:
    """Put what a layer defines in the place of what bore its names: all alternatives of a symbol
    with so many parameters, a symbol for an asset, an asset for a symbol.
    """
    for change in changes:
        _remove(unit, change.path[0], change.place.unit.grammar.items[change.place.item])
    for change in changes:
        _define(unit, change.path[0], change.place)


def _remove(unit: Unit, name: str, by: ast.Item) -> None:
    if not isinstance(by, ast.Rule | ast.Asset):
        return
    arity = len(by.head.parameters) if isinstance(by, ast.Rule) else 0
    interpret = isinstance(by, ast.Rule) and by.interpret
    named = unit.interpretations if interpret else unit.rules
    record = OPERATIONS.get(name)
    for spelling in (name,) if record is None else (record.name, *record.synonyms):
        kept = [each for each in named.get(spelling, ()) if _arity(each) != arity]
        if kept:
            named[spelling] = kept
        else:
            named.pop(spelling, None)
    before = unit.defined.get(name)
    if before is not None and isinstance(before.unit.grammar.items[before.item], ast.Asset):
        del unit.defined[name]


def _arity(place: Place) -> int:
    rule = place.unit.grammar.items[place.item]
    assert isinstance(rule, ast.Rule)
    return len(rule.head.parameters)


# ------------------------------------------------------------------- what units share


def _share(units: Sequence[Unit]) -> None:
    """Attributes that are the same in several units of a file, whatever they read included, are
    one: that of the first unit.
    """
    meanings = _Meanings()
    first: dict[int, Place] = {}
    for unit in units:
        for name, place in unit.defined.items():
            if isinstance(place.unit.grammar.items[place.item], ast.Attr):
                unit.defined[name] = first.setdefault(meanings.of(place), place)


class _Meanings:
    """Numbers of definitions: the same number for the same item whose names lead to the same."""

    def __init__(self) -> None:
        self._numbers: dict[tuple[object, ...], int] = {}
        self._known: dict[tuple[int, int], int] = {}

    def of(self, place: Place) -> int:
        """The number of a definition. One that is defined by itself is an error elsewhere."""
        key = (id(place.unit), place.item)
        if key not in self._known:
            self._known[key] = -1
            item = place.unit.grammar.items[place.item]
            read = [place.unit.find(name) for name in _used(item)]
            parts = (self.of(each) for each in read if each is not None)
            meaning = (id(place.unit.grammar), place.item, *parts)
            self._known[key] = self._numbers.setdefault(meaning, len(self._numbers))
        return self._known[key]


def _asked(loaded: Loaded) -> frozenset[str]:
    """The words before dots in names that are used: which styles somebody asks for."""
    if not any(isinstance(each, ast.Style) for file in loaded.files for each in file.grammar.items):
        return frozenset()
    used = (name for file in loaded.files for item in file.grammar.items for name in _used(item))
    return frozenset(word for name in used for word in name.split(".")[:-1])


def _used(item: ast.Item) -> Iterator[str]:
    """Every name that an item uses, in its own words."""
    waiting: list[object] = [item]
    while waiting:
        node = waiting.pop()
        match node:
            case tuple():
                waiting.extend(node)
                continue
            case ast.Name(id=name) | ast.Module(name=name) | ast.Call(name=name):
                yield name
            case ast.Block(name=name) | ast.Rows(table=name) | ast.Assign(name=name):
                yield name
            case ast.ContextModule(name=name):
                yield name
            case _:
                pass
        fields = getattr(node, "__dataclass_fields__", ())
        waiting.extend(getattr(node, name) for name in fields if name not in ("span", "comments"))
