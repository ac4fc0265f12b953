"""A resize by the grammar's own parameters: the number that decides how large a shape is.

In go a tree, the shapes meant and the size that they shall have; out comes the draft with one
number changed, or nothing where no single number does it. The lot, attributes, constants and the
lengths in the rules above the shape are tried, in this order; each by deriving with it. What came
apart by that is no solution.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.format import format_expression
from ipmlang.edit.arithmetic import literal, number_of
from ipmlang.edit.buildings.deciding import Key, deciding
from ipmlang.edit.buildings.growing import grown, tree_of
from ipmlang.edit.buildings.measuring import Measured
from ipmlang.edit.buildings.rebuilding import MOST
from ipmlang.edit.buildings.soundness import came_apart, follows, kinds_of, out_of_line, runs_into
from ipmlang.edit.buildings.tree import Tree
from ipmlang.edit.buildings.units import is_whole, tolerance
from ipmlang.edit.draft import Change, Draft, with_items, with_parameters
from ipmlang.edit.places import Place
from ipmlang.inverse.frames import Floats, linear

STEPS = 6  # of the secant
TRIALS = 40  # parameters that are looked at, at most
RATHER = 4.0  # times more than the size that a number may change
LEAST = 0.02  # of its size that everything keeps
FIT = 1e-9  # of the size, that a solution may be off
ALONE = ("size", "translate")  # operations whose numbers are those of one part
NEARLY = math.log(1.3)  # what is left to a stretch at most
TRY = 1.07  # times a number, to see what it does


@dataclass(frozen=True, slots=True)
class Knob:
    """A number of the grammar. where: as a person reads it; place: what tells it from all others;
    value: now; put: the draft with another one; whole: it counts something; low, high: what it may
    be; alone: it sizes or moves one part, which what lies in one plane with it may not follow;
    attr: the attribute that it is the default of, so that it can be tried without another text.
    """

    where: str
    place: tuple[str, int, int]
    value: float
    put: Callable[[float], Draft]
    whole: bool = False
    low: float = -math.inf
    high: float = math.inf
    alone: bool = False
    attr: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Aim:
    """What a resize wants. keys: the shapes that get the size; others: those of the same symbol
    that keep theirs; refused: what attributes would have had to be, had their ranges allowed it.
    """

    keys: Sequence[Key]
    others: Sequence[Key]
    size: Floats
    along: Sequence[int]
    refused: list[str] = field(default_factory=list)


def driven(tree: Tree, aim: Aim) -> Draft | None:
    """The draft in which shapes have the size wanted, by one parameter for each axis; None if there
    is none.
    """
    for axis in aim.along:
        found = _one(tree, aim, axis)
        if found is None:
            return None
        tree = found
    return tree.draft


def counted(tree: Tree, aim: Aim, axis: int, rest: bool) -> Draft | None:
    """The draft in which a shape comes nearest to the size wanted along an axis by the number of
    copies that an attribute counts, and a lot that is stretched by what is left; None if there is
    none, or nearly as much were left. rest: the lot need not do it.
    """
    now, wanted = size_of(tree, aim.keys[0], axis), float(aim.size[axis])
    # A lot that was stretched is counted as it was before, so that the way back leads there.
    bare = _on_lot(tree, axis, 1.0)
    if now is None or bare is None:
        return None
    for knob in _knobs(bare, aim, axis):
        found = _by_count(bare, aim, axis, knob) if knob.whole else None
        reached = None if found is None else size_of(found, aim.keys[0], axis)
        if found is None or reached is None:
            continue
        if abs(math.log(wanted / reached)) > min(NEARLY, abs(math.log(wanted / now)) / 2):
            continue
        sizes = np.where(np.arange(3) == axis, reached, aim.size)
        if _is_meant(tree, found, replace(aim, size=sizes), axis):
            made = _on_lot(found, axis, wanted / reached)
            if made is not None and _is_meant(tree, made, aim, axis):
                return made.draft
            return found.draft if rest else None
    return None


def _by_count(tree: Tree, aim: Aim, axis: int, knob: Knob) -> Tree | None:
    """The tree in which something is counted so often that the size is nearly as wanted."""
    now, wanted = size_of(tree, aim.keys[0], axis), float(aim.size[axis])
    size, _ = _size_with(tree, aim, axis, knob, knob.value + 1)
    if now is None or size is None or abs(size - now) <= FIT * now:
        return None
    count = float(round(knob.value + (wanted - now) / (size - now)))
    if not knob.low <= count <= knob.high or count > MOST * max(1.0, abs(knob.value)):
        return None
    return tree if count == knob.value else _tried(replace(knob, attr=None), count, tree)


def _on_lot(tree: Tree, axis: int, factor: float) -> Tree | None:
    """The tree with a box for its lot so many times as large as it is without what stretched it
    before; the tree itself where it has none, or that changes nothing.
    """
    items = dict(enumerate(tree.draft.grammar.items))
    for number, item in items.items():
        if not isinstance(item, ast.Start) or item.place is None or item.place.kind != "box":
            continue
        args = list(item.place.args)
        if axis >= len(args):
            continue
        before, args[axis] = args[axis], _times(args[axis], factor)
        if args[axis] == before:
            return tree
        own = replace(item, place=replace(item.place, args=tuple(args)))
        change = Change(
            f"the lot's {'xyz'[axis]}", format_expression(before), format_expression(args[axis])
        )
        try:
            return grown(with_items(tree.draft, {number: own}, [change]), like=tree)
        except IpmError:
            return None
    return tree


def _times(expr: ast.Expr, factor: float) -> ast.Expr:
    """`w * factor`, in place of a factor near 1 that stands there already."""
    match expr:
        case ast.Binary("*", rest, ast.Number(before)) if abs(math.log(before or 2)) <= NEARLY:
            expr = rest
    plain = math.isclose(factor, 1.0, rel_tol=1e-9)
    return expr if plain or number_of(expr) is not None else ast.Binary("*", expr, literal(factor))


def _one(tree: Tree, aim: Aim, axis: int) -> Tree | None:
    for number, knob in enumerate(_knobs(tree, aim, axis)):
        if number >= TRIALS:
            return None
        solved = _solved(tree, aim, axis, knob)
        if solved is None or not _is_meant(tree, solved[0], aim, axis):
            continue
        if knob.alone and out_of_line(tree, solved[0], tolerance(tree)):
            continue
        found = _written(tree, knob, *solved)
        if found is not None:
            return found
    return None


def _is_meant(before: Tree, after: Tree, aim: Aim, axis: int) -> bool:
    """Whether what was selected has its size, and nothing else of its kind, nothing vanished, and
    what touched still does.
    """
    wanted = float(aim.size[axis])
    for key in aim.keys:
        size = size_of(after, key, axis)
        if size is not None and abs(size - wanted) > FIT * max(wanted, 1.0):
            return False
    for key in aim.others:
        size, own = size_of(after, key, axis), size_of(before, key, axis)
        if size is not None and own is not None and abs(size - own) > FIT * max(own, 1.0):
            return False
    if not _draws_it(before, after, aim, axis):
        return False
    near = tolerance(before)
    if _vanished(before, after) or runs_into(before, after, near):
        return False
    return not came_apart(before, after, near)


def _draws_it(before: Tree, after: Tree, aim: Aim, axis: int) -> bool:
    """Whether a whole that is selected is drawn larger, too."""
    kind, key = aim.keys[0]
    rows = np.flatnonzero(before.lineage.key == np.uint64(key))
    if kind != "shape" or not is_whole(before, (kind, int(rows[0]))):
        return True
    own = before.frames[rows]
    axes = (linear(own)[0] / own.scale[0]).T
    size = size_of(before, aim.keys[0], axis)
    assert size is not None
    return follows(before, after, axes, axis, float(aim.size[axis]) - size)


def _vanished(before: Tree, after: Tree) -> bool:
    """Whether a kind of terminal is no more: counts may change, but not to nothing; or anything
    that is in both has almost no size left where it had one.
    """
    if not set(kinds_of(before)) <= set(kinds_of(after)):
        return True
    one, other = before.scene.instances.key, after.scene.instances.key
    _, mine, theirs = np.intersect1d(one, other, return_indices=True)
    first, last = before.extents[mine], after.extents[theirs]
    return bool(((first > 0) & (last < LEAST * first)).any())


def _solved(tree: Tree, wanted: Aim, axis: int, knob: Knob) -> tuple[Tree, float] | None:
    """The tree with a number such that the size is right, and that number, by secants."""
    key, aim = wanted.keys[0], float(wanted.size[axis])
    now = size_of(tree, key, axis)
    assert now is not None
    x, y = knob.value, now
    guess = x + 1 if knob.whole else (x * TRY if x else 0.1)
    looking = True
    if not knob.whole and math.isclose(x, y, rel_tol=1e-9):
        guess, looking = aim, False  # the number is the size
    elif not knob.low <= guess <= knob.high:
        guess = x - 1 if knob.whole else x / TRY
    far = RATHER * max(aim / y, y / aim) if y > 0 else RATHER
    for _ in range(STEPS):
        if x and not 1 / far <= abs(guess / knob.value) <= far:
            return None
        if knob.whole and abs(guess) > MOST * max(1.0, abs(knob.value)):
            return None
        if not knob.low <= guess <= knob.high:
            if not looking:
                wanted.refused.append(f"`{knob.where}` would have to be {guess:.6g}")
            return None
        size, made = _size_with(tree, wanted, axis, knob, guess)
        if size is None:
            return None
        if made is not None and abs(size - aim) <= FIT * max(aim, 1.0):
            return made, guess
        if abs(size - y) <= 1e-12 * max(aim, 1.0):
            return None
        following = guess + (aim - size) * (guess - x) / (size - y)
        if knob.whole:
            following = float(round(following))
        if following == guess or not math.isfinite(following):
            return None
        x, y, guess, looking = guess, size, following, False
    return None


def _size_with(
    tree: Tree, wanted: Aim, axis: int, knob: Knob, value: float
) -> tuple[float | None, Tree | None]:
    """How large the shape is with another number, None if it is not there; and the tree, but where
    an edit before this one has tried that number, and it is not the one that is sought.
    """
    key, aim = wanted.keys[0], float(wanted.size[axis])
    trial = (*key, axis, *knob.place, value)
    if trial in tree.trials:
        size = tree.trials[trial]
        if size is None or abs(size - aim) > FIT * max(aim, 1.0):
            return size, None
    made = _tried(knob, value, tree)
    size = tree.trials[trial] = None if made is None else size_of(made, key, axis)
    return size, made


def _tried(knob: Knob, value: float, like: Tree) -> Tree | None:
    """The tree with another number; of an attribute by giving it to the program that is known."""
    try:
        if not _is_given_to(like, knob):
            return grown(knob.put(value), like=like)
        given = int(value) if knob.whole else value
        return tree_of(like.draft, like.program, attrs={str(knob.attr): given}, like=like)
    except IpmError:
        return None


def _is_given_to(tree: Tree, knob: Knob) -> bool:
    """Whether a number is an attribute of the program of a tree, whose files still lie there."""
    known = any(each.name == knob.attr for each in tree.program.attrs)
    return known and not tree.draft.added


def _written(tree: Tree, knob: Knob, made: Tree, value: float) -> Tree | None:
    """The tree with a number, as the text with that number says it."""
    return _tried(replace(knob, attr=None), value, tree) if _is_given_to(tree, knob) else made


def size_of(tree: Tree, key: Key, axis: int) -> float | None:
    """How large the shape of a key is along its own axis; None if it is not there."""
    kind, own = key
    row = tree.rows_of(kind).get(own)
    if row is None or (kind == "shape" and tree.first[row] >= len(tree.owner)):
        return None
    return float(Measured(tree).extent((kind, row))[axis])


# ---------------------------------------------------------------------------- parameters


def _knobs(tree: Tree, aim: Aim, axis: int) -> Iterator[Knob]:
    """The numbers that may decide: the lot, attributes and constants, rules from the shape up."""
    draft = tree.draft
    for number, item in enumerate(draft.grammar.items):
        if isinstance(item, ast.Start) and item.place is not None and Measured(tree).reads_lot():
            yield from _lot(draft, number, item)
    for number, item in enumerate(draft.grammar.items):
        if isinstance(item, ast.Attr) and item.type in ("int", "float", None):
            value = number_of(item.default)
            if value is not None:
                yield _named(draft, number, item, value, item.type == "int")
        elif isinstance(item, ast.Const) and number_of(item.value) is not None:
            yield _constant(draft, number, item, float(number_of(item.value) or 0.0))
    for number, found in deciding(tree, aim.keys[0], aim.others, axis):
        yield _length(draft, number, found, float(number_of(found[1]) or 0.0))


def _lot(draft: Draft, number: int, start: ast.Start) -> Iterator[Knob]:
    """The extents of the box, or of the polygon along x and y."""
    place = start.place
    assert place is not None
    if place.kind == "box":
        for k, expr in enumerate(place.args):
            value = number_of(expr)
            if value:
                yield _lot_knob(draft, number, start, (k,), f"the lot's {'xyz'[k]}", value)
    elif place.kind == "polygon":
        corners = [each for each in place.args if isinstance(each, ast.Tuple)]
        for axis in (0, 1):
            values = [number_of(each.items[axis]) for each in corners]
            known = [value for value in values if value is not None]
            if known and len(known) == len(values) and max(known) > min(known):
                yield _polygon_knob(draft, number, start, axis, max(known) - min(known))


def _lot_knob(
    draft: Draft, number: int, start: ast.Start, at: tuple[int, ...], where: str, value: float
) -> Knob:
    def put(new: float) -> Draft:
        place = start.place
        assert place is not None
        args = tuple(literal(new) if k in at else each for k, each in enumerate(place.args))
        change = Change(where, f"{value:g}", f"{literal(new).value:g}")
        item = replace(start, place=replace(place, args=args))
        return with_items(draft, {number: item}, [change])

    return Knob(where, ("lot", number, at[0]), value, put)


def _polygon_knob(draft: Draft, number: int, start: ast.Start, axis: int, value: float) -> Knob:
    where = f"the lot along {'xy'[axis]}"

    def put(new: float) -> Draft:
        place = start.place
        assert place is not None
        args = tuple(_scaled(each, axis, new / value) for each in place.args)
        change = Change(where, f"{value:g}", f"{literal(new).value:g}")
        item = replace(start, place=replace(place, args=args))
        return with_items(draft, {number: item}, [change])

    return Knob(where, ("lot", number, axis), value, put)


def _scaled(corner: ast.Expr, axis: int, factor: float) -> ast.Expr:
    assert isinstance(corner, ast.Tuple)
    items = tuple(
        literal((number_of(each) or 0.0) * factor) if k == axis else each
        for k, each in enumerate(corner.items)
    )
    return replace(corner, items=items)


def _named(draft: Draft, number: int, item: ast.Attr, value: float, whole: bool) -> Knob:
    def put(new: float) -> Draft:
        made = literal(new)
        change = Change(item.name, format_expression(item.default), format_expression(made))
        return with_items(draft, {number: replace(item, default=made)}, [change])

    low, high = -math.inf, math.inf
    if isinstance(item.allowed, ast.Range):
        low = _bound(item.allowed.low, low)
        high = _bound(item.allowed.high, high)
    return Knob(item.name, ("item", number, 0), value, put, whole, low, high, attr=item.name)


def _bound(expr: ast.Expr | None, default: float) -> float:
    value = None if expr is None else number_of(expr)
    return default if value is None else value


def _constant(draft: Draft, number: int, item: ast.Const, value: float) -> Knob:
    def put(new: float) -> Draft:
        made = literal(new)
        change = Change(item.name, format_expression(item.value), format_expression(made))
        return with_items(draft, {number: replace(item, value=made)}, [change])

    return Knob(item.name, ("item", number, 0), value, put)


def _length(draft: Draft, number: int, found: tuple[Place, ast.Expr], value: float) -> Knob:
    def put(new: float) -> Draft:
        return with_parameters(draft, {number: found}, {number: literal(new)})

    where = f"{found[0].rule}: {found[0].operation}"
    return Knob(where, ("length", number, 0), value, put, alone=found[0].operation in ALONE)
