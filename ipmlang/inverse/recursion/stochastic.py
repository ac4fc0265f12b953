"""Branching structures whose rule is drawn from a few alternatives, with the draws they took.

In come strokes and their styles; out comes a program with the alternatives, their percentages and
the decisions, generation by generation and from left to right. What tells the levels apart are the
straight pieces between branches, which grow by a whole factor each step. Where several alternatives
draw the same, the first is taken. Nothing is proven here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import TypeAlias

from ipmlang.inverse.recursion.program import (
    Alternative,
    Body,
    Branch,
    Command,
    Recursion,
    Symbol,
    Turn,
)
from ipmlang.inverse.recursion.sizes import FASTEST_GROWTH, FEWEST_STEPS, MOST_STEPS
from ipmlang.inverse.recursion.strokes import Integers, Strokes
from ipmlang.inverse.recursion.tree import Tree, grow_tree

MOST_ALTERNATIVES = 8
MOST_PARTS = 40
LAST_READ = 2  # steps left down to which straight runs of two levels may touch
FEWEST_DRAWS = 4  # for each alternative, on average
COPY, PIECE = "copy0", "piece"

Shape: TypeAlias = "tuple[tuple[float, Shape | None], ...]"
"""What grows at a node, in order: the turn to each child and, if it is a piece and not the symbol,
what grows at its end."""


@dataclass(frozen=True, slots=True)
class _Read:
    """What was read of one body: its shape if it was not known; the first segments of the symbols
    in it and of its pieces, in order.
    """

    shape: Shape
    inner: tuple[int, ...]
    pieces: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class _Kind:
    """An alternative: its shape and the styles of its pieces while they are new."""

    shape: Shape
    styles: tuple[int, ...]


class _UnreadError(Exception):
    """The tree is no body at this level."""


def stochastic_programs(strokes: Strokes, styles: Integers) -> Iterator[Recursion]:
    """Programs with alternatives, the ones with most steps first. styles: (n,) of the segments, all
    0 where they are to be left out.
    """
    tree = grow_tree(strokes)
    if tree is None:
        return
    longest = max(tree.straight)
    for growth in range(2, FASTEST_GROWTH + 1):
        most = next(k for k in range(MOST_STEPS) if growth**k > longest)
        for steps in range(most, FEWEST_STEPS - 1, -1):
            try:
                yield _program(tree, styles.tolist(), growth, steps)
            except _UnreadError:
                continue
            break


def _program(tree: Tree, styles: list[int], growth: int, steps: int) -> Recursion:
    start = _body(tree, tree.children[-1], growth**steps)
    shapes = _shapes(tree, start.inner, growth, steps)
    generations = _generations(tree, start.inner, shapes, growth, steps)
    kinds, last = _kinds(generations[-1], shapes, styles)
    first = {kind.shape: number for number, kind in reversed(list(enumerate(kinds)))}
    before = [first[shapes[min(found)]] for found in chain.from_iterable(generations[:-1])]
    chances = _chances(generations, shapes, kinds, last)
    choices = (*before, *last)
    return _written(start.shape, steps, growth, kinds, chances, choices, styles)


def _shapes(tree: Tree, inner: tuple[int, ...], growth: int, steps: int) -> list[Shape]:
    """The shapes of the symbols' bodies, by first appearance, as far down as they can be read
    without knowing them.
    """
    seen: Counter[Shape] = Counter()
    for left in range(steps, LAST_READ, -1):
        bodies = [_body(tree, [segment], growth ** (left - 1)) for segment in inner]
        if any(body.shape[0][1] is None for body in bodies):
            raise _UnreadError
        seen.update(((0.0, body.shape[0][1]),) for body in bodies)
        inner = tuple(segment for body in bodies for segment in body.inner)
        if len(seen) > MOST_ALTERNATIVES:
            raise _UnreadError
    if FEWEST_DRAWS * len(seen) > seen.total():
        raise _UnreadError
    return list(seen)


def _body(tree: Tree, children: list[int], piece: int) -> _Read:
    """What grows at a node where pieces have so many segments."""
    shape: list[tuple[float, Shape | None]] = []
    inner: list[int] = []
    for child in children:
        if tree.straight[child] >= piece:
            rest = _body(tree, tree.children[child + piece - 1], piece)
            shape.append((tree.turn[child], rest.shape))
            inner += rest.inner
        else:
            shape.append((tree.turn[child], None))
            inner.append(child)
        if len(shape) + len(inner) > MOST_PARTS:
            raise _UnreadError
    return _Read(tuple(shape), tuple(inner))


def _generations(
    tree: Tree, inner: tuple[int, ...], shapes: list[Shape], growth: int, steps: int
) -> list[list[dict[int, _Read]]]:
    """For each symbol of each generation the shapes that it can have taken, by number."""
    generations = []
    for left in range(steps, 0, -1):
        found = [
            _fitting(tree, shapes, segment, growth ** (left - 1), left > 1) for segment in inner
        ]
        if not all(found):
            raise _UnreadError
        generations.append(found)
        inner = tuple(segment for fits in found for segment in fits[min(fits)].inner)
    return generations


def _fitting(
    tree: Tree, shapes: list[Shape], segment: int, piece: int, symbols: bool
) -> dict[int, _Read]:
    """The shapes that what begins with a segment can have. symbols: whether they draw anything."""
    found: dict[int, _Read] = {}
    if tree.straight[segment] < piece:
        return found
    children = tree.children[segment + piece - 1]
    for index, ((_, rest),) in enumerate(shapes):
        read = None if rest is None else _match(tree, rest, children, piece, symbols)
        if read is not None:
            found[index] = _Read(read.shape, read.inner, (segment, *read.pieces))
    return found


def _match(
    tree: Tree, shape: Shape, children: list[int], piece: int, symbols: bool
) -> _Read | None:
    """What grows at a node read as this shape, None if it has another."""
    wanted = [part for part in shape if symbols or part[1] is not None]
    if len(wanted) != len(children):
        return None
    inner: list[int] = []
    pieces: list[int] = []
    for child, (turn, rest) in zip(children, wanted, strict=True):
        if turn != tree.turn[child] or (rest is not None and tree.straight[child] < piece):
            return None
        if rest is None:
            inner.append(child)
            continue
        more = _match(tree, rest, tree.children[child + piece - 1], piece, symbols)
        if more is None:
            return None
        inner += more.inner
        pieces += [child, *more.pieces]
    return _Read(shape, tuple(inner), tuple(pieces))


def _kinds(
    generation: list[dict[int, _Read]], shapes: list[Shape], styles: list[int]
) -> tuple[list[_Kind], list[int]]:
    """The alternatives, those that the last generation shows with their styles, and which of them
    each of its symbols took; where several fit, one that is known, else the first.
    """
    seen: dict[_Kind, int] = {}
    taken: dict[int, int] = {}
    order = sorted(range(len(generation)), key=lambda index: (len(generation[index]) > 1, index))
    for index in order:
        fits = [
            _Kind(shapes[shape], tuple(styles[piece] for piece in read.pieces))
            for shape, read in sorted(generation[index].items())
        ]
        kind = next((each for each in fits if each in seen), fits[0])
        taken[index] = seen.setdefault(kind, len(seen))
    usual = Counter(styles).most_common(1)[0][0]
    for shape in shapes:
        if all(kind.shape != shape for kind in seen):
            seen[_Kind(shape, (usual,) * _pieces(shape))] = len(seen)
    if len(seen) > MOST_ALTERNATIVES:
        raise _UnreadError
    return list(seen), [taken[index] for index in range(len(generation))]


def _pieces(shape: Shape) -> int:
    """How many pieces a shape has."""
    return sum(1 + _pieces(inner) for _, inner in shape if inner is not None)


def _chances(
    generations: list[list[dict[int, _Read]]],
    shapes: list[Shape],
    kinds: list[_Kind],
    last: list[int],
) -> list[int]:
    """The percentages of the alternatives: how often each shape was taken in the generations that
    leave no doubt, and how often each kind of a shape in the last one.
    """
    sure = [each for each in generations if all(len(found) == 1 for found in each)]
    often = Counter(min(found) for found in chain.from_iterable(sure or generations))
    within = Counter(kinds[number].shape for number in last)
    counts = []
    for number, kind in enumerate(kinds):
        share = last.count(number) / within[kind.shape] if within[kind.shape] else 1.0
        counts.append(often[shapes.index(kind.shape)] * share)
    return percentages(counts)


def percentages(counts: list[float]) -> list[int]:
    """Whole percentages that add up to 100, by largest remainder; at least 1 each.

    >>> percentages([1, 1, 1])
    [34, 33, 33]
    """
    total = sum(counts)
    exact = [100 * count / total for count in counts]
    result = [max(1, int(each)) for each in exact]
    order = sorted(range(len(counts)), key=lambda index: int(exact[index]) - exact[index])
    for index in order[: max(0, 100 - sum(result))]:
        result[index] += 1
    while sum(result) > 100:
        result[result.index(max(result))] -= 1
    return result


def _written(
    start: Shape,
    steps: int,
    growth: int,
    kinds: list[_Kind],
    chances: list[int],
    choices: tuple[int, ...],
    styles: list[int],
) -> Recursion:
    """The program. A piece of another style than most is a symbol of its own while it is new."""
    usual = Counter(styles).most_common(1)[0][0]
    used = sorted({style for kind in kinds for style in kind.styles} - {usual})
    names = {usual: PIECE, **{style: f"{PIECE}{style}" for style in used}}
    bodies = [
        _commands(kind.shape, iter([names[style] for style in kind.styles])) for kind in kinds
    ]
    rules: dict[str, Body] = {}
    alternatives = {}
    if len(kinds) == 1:
        rules[COPY] = bodies[0]
    else:
        pairs = zip(chances, bodies, strict=True)
        alternatives[COPY] = tuple(Alternative(percent, body) for percent, body in pairs)
    rules |= {name: (Symbol(PIECE),) * growth for name in names.values()}
    pieces = frozenset(names.values())
    return Recursion(
        rules,
        _commands(start, iter(())),
        steps,
        pieces,
        1.0,
        pieces=pieces,
        alternatives=alternatives,
        choices=choices if alternatives else (),
        styles={name: style for style, name in names.items()},
    )


def _commands(shape: Shape, pieces: Iterator[str]) -> Body:
    """The turtle's commands, with the fewest brackets."""
    body: list[Command] = []
    for number, (turn, inner) in enumerate(shape):
        part: list[Command] = [Turn(turn)] if turn else []
        if inner is None:
            part.append(Symbol(COPY))
        else:
            part.append(Symbol(next(pieces, PIECE)))
            part += _commands(inner, pieces)
        body += part if number == len(shape) - 1 else [Branch(tuple(part))]
    return tuple(body)
