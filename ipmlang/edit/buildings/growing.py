"""A draft is derived into its tree, once for as long as neither it nor its files change.

In goes a draft, out comes the tree of what it draws: shapes with their scopes, terminals with the
boxes of their geometry. The trees that were used last are remembered. Nothing is judged here.
"""

from __future__ import annotations

import operator
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cache as remember
from typing import TYPE_CHECKING

import numpy as np

from ipmlang.compiler import ast, collector, compile_file, compile_loaded, ir
from ipmlang.compiler.diagnostics import fail
from ipmlang.compiler.load import load_text
from ipmlang.edit.buildings.placements import terminals_of
from ipmlang.edit.buildings.tree import Tree
from ipmlang.edit.draft import Draft, Drawn
from ipmlang.edit.files import files_with
from ipmlang.edit.saving import about, staged
from ipmlang.runtime import derive
from ipmlang.runtime.lineage import Lineage
from ipmlang.runtime.scene import AssetRef, Scene

if TYPE_CHECKING:
    from ipmlang.formats.mesh_types import Mesh


def grown(
    draft: Draft,
    *,
    seed: int = 0,
    attrs: Mapping[str, float] | None = None,
    like: Tree | None = None,
) -> Tree:
    """Derive a draft with its tree; like: a tree that has some of its assets already. Raises
    IpmError for what cannot be derived, and for grammars whose shapes do not expand independently.
    """
    plain = seed == 0 and not attrs
    if plain:
        known = next((each for each in tuple(_last_trees()) if _is_of(each, draft)), None)
        if known is not None and _stamps(draft) == known.stamps:
            _note(known)
            drawn = known.draft.drawn
            own = None if drawn is None else Drawn(draft.grammar, draft.added, drawn.terminals)
            return known.of(replace(draft, drawn=own))
    stamps = _stamps(draft)
    with collector.held():
        tree = _derived(draft, seed, attrs, like)
    if plain:
        if not any(map(_replays, draft.grammar.items)):
            drawn = Drawn(draft.grammar, draft.added, len(tree.scene.instances))
            draft = replace(draft, drawn=drawn)
        tree = replace(tree, draft=draft, stamps=stamps)
        _note(tree, like)
    return tree


def _note(tree: Tree, like: Tree | None = None) -> None:
    """Note that a tree was used; what it is like was, too, if that is known."""
    trees = _last_trees()
    if like is not None and any(each.scene is like.scene for each in tuple(trees)):
        trees.append(like)
    if not trees or trees[-1] is not tree:
        trees.append(tree)


def _derived(draft: Draft, seed: int, attrs: Mapping[str, float] | None, like: Tree | None) -> Tree:
    """The tree of a draft as its text says it."""
    if not draft.added:
        loaded = load_text(draft.text, draft.folder, draft.allow_outside)
        return tree_of(draft, compile_loaded(loaded)[1], seed=seed, attrs=attrs, like=like)
    with staged(draft, draft.path) as made, about(made, draft.path):
        program = compile_file(made.path, allow_outside=draft.allow_outside)[1]
        return tree_of(draft, program, seed=seed, attrs=attrs)


@remember
def _last_trees() -> deque[Tree]:
    """The trees that were used last: an edit goes on from what the one before it derived, and a
    file that is read again from what was derived of it.
    """
    return deque(maxlen=2)


def _is_of(tree: Tree, draft: Draft) -> bool:
    """Whether a tree was derived of the very items of a draft, where those lie: one that is read
    again has them from the cache of parsing for as long as its text is the same.
    """
    own, one, other = tree.draft, tree.draft.grammar.items, draft.grammar.items
    same = len(one) == len(other) and all(map(operator.is_, one, other))
    same &= own.added is draft.added or not (own.added or draft.added)
    return same and own.path == draft.path and own.allow_outside == draft.allow_outside


def _stamps(draft: Draft) -> tuple[tuple[str, int, int], ...]:
    """By which a change of the files is seen that lie beside a grammar."""
    found = []
    for name, path in files_with(draft.grammar, draft.folder, draft.added).items():
        with suppress(OSError):  # one that is not there is for others to tell
            stat = path.stat()
            found.append((name, stat.st_mtime_ns, stat.st_size))
    return tuple(found)


def _replays(item: ast.Item) -> bool:
    """Whether an item speaks of what was drawn without a seed."""
    return isinstance(item, ast.Residual) or (
        isinstance(item, ast.Start) and item.choices is not None
    )


def tree_of(
    draft: Draft,
    program: ir.Program,
    *,
    seed: int = 0,
    attrs: Mapping[str, float] | None = None,
    like: Tree | None = None,
) -> Tree:
    """The tree of a program that a draft was compiled to."""
    told: list[Lineage] = []
    scene = derive(program, seed=seed, attrs=attrs, tell=told.append)
    if not told or scene.flat:
        raise fail(
            "not-a-building",
            "this grammar draws no building: its shapes thread a turtle, or lie in one plane",
            hint="edits of buildings take grammars of scopes: split, comp, translate, insert",
        )
    meshes = _meshes(scene, {} if like is None else _read_before(like))
    own = {scene.assets[number] for number in meshes}
    known = {} if like is None else like.outlines
    outlines = {asset: known[asset] for asset in own & known.keys()}
    terminals = terminals_of(scene, meshes)
    return Tree(draft, program, scene, told[0], terminals, meshes, outlines=outlines)


def _read_before(tree: Tree) -> dict[AssetRef, Mesh]:
    """The meshes of a tree by what they were read for."""
    return {tree.scene.assets[number]: mesh for number, mesh in tree.meshes.items()}


def _meshes(scene: Scene, known: Mapping[AssetRef, Mesh]) -> dict[int, Mesh]:
    from ipmlang.runtime.export.model_assets import model_assets

    numbers = np.unique(scene.instances.asset[scene.instances.asset >= 0]).tolist()
    assets = {number: scene.assets[number] for number in numbers}
    read, _ = model_assets(each for each in assets.values() if each not in known)
    return {number: known[each] if each in known else read[each] for number, each in assets.items()}


__all__ = ["grown", "tree_of"]
