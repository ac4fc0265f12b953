"""Assets that an edit draws larger: one item says how many times, and rules go on to use the name.

In go assets with factors along their own axes, out come names, and at the end the grammar with the
items of those that are used. The files stay as they are, so what is stretched can be told from what
it was, and comes back to it. Where anything stands is said elsewhere.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from ipmlang.compiler import ast
from ipmlang.edit.symbols import Asked

Factors: TypeAlias = tuple[float, float, float]
NONE: Factors = (1.0, 1.0, 1.0)
WORD = "_sized"  # what the name of a variant ends with
WORDS = re.compile(rf"{WORD}(_\d+)?$")


@dataclass(slots=True, eq=False)
class Stretched:
    """The variants of assets: names by asset and factors; own: the part of a file that each asset
    of the grammar is, and how many times as large; `named` gives names that nothing bears.
    """

    named: Callable[[str], str]
    own: dict[str, tuple[str, Factors]] = field(default_factory=dict)
    names: dict[str, dict[Factors, str]] = field(default_factory=dict)

    @staticmethod
    def of(grammar: ast.Grammar, named: Callable[[str], str]) -> Stretched:
        """None yet; of the assets of a grammar that can have some: those that it names once."""
        own: dict[str, tuple[str, Factors]] = {}
        twice: set[str] = set()
        for item in grammar.items:
            if isinstance(item, ast.Asset):
                twice |= own.keys() & set(item.names)
                own |= {name: (_part(item, name), factors_of(item)) for name in item.names}
        kept = {name: each for name, each in own.items() if "." not in name and name not in twice}
        return Stretched(named, kept)

    def factors(self, asset: str) -> Factors | None:
        """How many times as large as in its file an asset is; None for one that has no variants."""
        return self.own[asset][1] if asset in self.own else None

    def name(self, asset: str, factors: Factors) -> str:
        """What an asset is called that is drawn so many times as large as it is in its file."""
        part, before = self.own[asset]
        if factors == before:
            return asset
        for other, known in self.own.items():
            if known == (part, factors):
                return other
        variants = self.names.setdefault(asset, {})
        if factors not in variants:
            variants[factors] = self.named(f"{WORDS.sub('', asset)}{WORD}")
        return variants[factors]

    def near(self, value: float, error: float) -> float | None:
        """A factor that is used already and as good."""
        for known in self.names.values():
            for factors in known:
                for each in factors:
                    if abs(each - value) <= error:
                        return each
        return None

    def taking_over(
        self, called: set[str], drawn: Sequence[object], asked: Asked
    ) -> dict[str, str]:
        """The variants that bear the name of their asset, which nothing else draws any more: of
        several the one that is used most.
        """
        uses: dict[str, int] = {}
        for tree in drawn:
            for name in asked.every(tree):
                uses[name] = uses.get(name, 0) + 1
        found = {}
        for asset, variants in self.names.items():
            used = [name for name in variants.values() if name in uses]
            if used and asset not in called:
                found[max(used, key=lambda name: uses[name])] = asset
        return found

    def with_items(self, grammar: ast.Grammar, renamed: Mapping[str, str]) -> ast.Grammar:
        """The grammar with the items of the variants, each behind that of its asset; renamed: those
        that bear another name.
        """
        items: list[ast.Item] = []
        for item in grammar.items:
            if not isinstance(item, ast.Asset):
                items.append(item)
                continue
            made = {
                renamed.get(name, name): (asset, factors)
                for asset in item.names
                for factors, name in self.names.get(asset, {}).items()
            }
            left = tuple(name for name in item.names if name not in made)
            new = _items(item, made)
            if left:
                items.append(replace(item, names=left))
            elif new:
                new[0] = replace(new[0], comments=item.comments, blank_before=item.blank_before)
            items += new
        return replace(grammar, items=tuple(_joined(items)))


def factors_of(item: ast.Asset) -> Factors:
    """How many times as large as in its file an asset is."""
    x, y, z = (each.value for each in item.stretch) if item.stretch else NONE
    return x, y, z


def _items(item: ast.Asset, made: Mapping[str, tuple[str, Factors]]) -> list[ast.Asset]:
    """The items of variants, (asset, factors) by name: those that are called like a part of the
    file together, one for each size.
    """
    listed: dict[Factors, list[str]] = {}
    alone: list[ast.Asset] = []
    for name, (asset, factors) in made.items():
        if item.by_name and name == asset:
            listed.setdefault(factors, []).append(name)
            continue
        alone.append(ast.Asset((name,), _part(item, asset), stretch=_stretch(factors)))
    together = [
        ast.Asset(tuple(names), item.reference, True, _stretch(factors))
        for factors, names in listed.items()
    ]
    return [*together, *alone]


def _part(item: ast.Asset, name: str) -> str:
    """The part of a file that an asset is, as one is referred to."""
    return f"{item.reference}#{name}" if item.by_name else item.reference


def _stretch(factors: Factors) -> tuple[ast.Number, ...]:
    return () if factors == NONE else tuple(map(ast.Number, factors))


def _joined(items: Sequence[ast.Item]) -> list[ast.Item]:
    """Items with lists of assets that say the same of other names joined to the first of them."""
    found: list[ast.Item] = []
    known: dict[object, int] = {}
    for item in items:
        if isinstance(item, ast.Asset) and item.by_name:
            key = item.reference, factors_of(item)
            if key in known:
                first = found[known[key]]
                assert isinstance(first, ast.Asset)
                names = (*first.names, *item.names)
                found[known[key]] = replace(first, names=names)
                continue
            known[key] = len(found)
        found.append(item)
    return found
