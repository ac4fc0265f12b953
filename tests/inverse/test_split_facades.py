"""Façades as splits: what is drawn stays, floors and bays become one number, rules do not grow."""

from __future__ import annotations

import numpy as np
import pytest
from inverse.box_models import Boxes, same

from ipmlang.inverse.frames import Frames, compose, moved_to
from ipmlang.inverse.parts.observation import Parts
from ipmlang.inverse.split.cost import scheme_tokens
from ipmlang.inverse.split.facades.splitting import as_splits
from ipmlang.inverse.split.scheme import Cell, Place, Rule, Scheme, Split, Terminal

SMALL = 1e-7


def listed(parts: Parts) -> Scheme:
    """Every part by itself, all in one rule."""
    low = parts.low.min(axis=0)
    here = moved_to(-low)
    terminals = tuple(Terminal(each.name, each.size, k) for k, each in enumerate(parts.classes))
    items = tuple(
        Place(k, compose(here, parts.frames[parts.shape == k]))
        for k in range(len(terminals))
        if (parts.shape == k).any()
    )
    rule = Rule("House", parts.high.max(axis=0) - low, items)
    return Scheme((*terminals, rule), moved_to(low))


def splits(scheme: Scheme) -> list[Split]:
    rules = [symbol for symbol in scheme.symbols if isinstance(symbol, Rule)]
    return [item for rule in rules for item in rule.items if isinstance(item, Split)]


def shape(split: Split) -> tuple[str, tuple[int, ...]]:
    """The axis, and the counts of its cells; 0: nothing is in the cell."""
    counts = tuple(0 if cell.symbol is None else cell.count for cell in split.cells)
    return "xyz"[split.axis], counts


def front(bays: int, floors: int, width: float = 0.0) -> Boxes:
    """A wall with a door, floors of bays with sills, and a cornice that stands out."""
    width = width or 2.8 * bays + 1
    model = Boxes({
        "wall": (width, 0.4, 4.6 + 3.2 * floors), "window": (1.2, 0.2, 1.5),
        "sill": (1.4, 0.3, 0.1), "door": (1.2, 0.2, 2.2), "cornice": (width + 0.4, 0.6, 0.6),
    })  # fmt: skip
    model.put("wall", (0, 0.1, 0))
    model.put("door", (width / 2 - 0.6, 0, 0))
    model.put("cornice", (-0.2, -0.2, 4 + 3.2 * floors))
    for floor in range(floors):
        for bay in range(bays):
            x, z = (width - 2.8 * bays) / 2 + 2.8 * bay, 4 + 3.2 * floor
            model.put("window", (x + 0.8, 0, z + 0.9))
            model.put("sill", (x + 0.7, -0.1, z + 0.8))
    return model


@pytest.mark.parametrize(("bays", "floors"), [(5, 3), (3, 6), (9, 12)])
def test_front_is_ground_floors_and_cornice(bays: int, floors: int) -> None:
    parts = front(bays, floors).parts(seed=bays)
    scheme = as_splits(listed(parts), SMALL)
    assert same(scheme, parts, SMALL)
    assert sorted(map(shape, splits(scheme))) == [("x", (0, bays, 0)), ("z", (1, floors, 1))]
    names = [symbol.name for symbol in scheme.symbols if isinstance(symbol, Rule)]
    assert {"House", "Floor", "Bay"} <= set(names)


def test_splits_pay() -> None:
    before = listed(front(9, 6).parts())
    assert scheme_tokens(as_splits(before, SMALL), SMALL) < 0.5 * scheme_tokens(before, SMALL)


def test_walls_beside_bays_are_alike_and_give_way() -> None:
    (floor,) = [
        each for each in splits(as_splits(listed(front(5, 3).parts()), SMALL)) if each.axis == 0
    ]
    left, bays, right = floor.cells
    assert left.length == pytest.approx(right.length) and left.elastic and right.elastic
    assert bays.elastic and bays.length == pytest.approx(2.8)


def test_walls_and_cornices_follow_their_scope() -> None:
    """So that a façade with more bays has a wall behind them."""
    parts = front(5, 3).parts()
    scheme = as_splits(listed(parts), SMALL)
    followed = {}
    for symbol in scheme.symbols:
        for item in symbol.items if isinstance(symbol, Rule) else ():
            if isinstance(item, Place) and item.margins is not None:
                name = scheme.symbols[item.symbol].name
                followed[name] = item.margins[0]
                extent = np.where(np.isfinite(item.margins), item.margins + item.stretch, np.nan)
                assert np.nanmax(np.abs(extent - symbol.size)) < 1e-9
    assert set(followed) == {"wall", "cornice"}
    assert np.isfinite(followed["wall"]).tolist() == [True, False, True]
    assert np.isfinite(followed["cornice"]).tolist() == [True, False, False]


def test_what_does_not_repeat_is_left_alone() -> None:
    draw = np.random.default_rng(5)
    model = Boxes({f"part{k}": tuple(draw.random(3) + 0.2) for k in range(12)})
    for k in range(12):
        model.put(f"part{k}", tuple(9 * draw.random(3)))
    scheme = listed(model.parts())
    assert as_splits(scheme, SMALL) is scheme


def test_two_equal_parts_are_no_split() -> None:
    model = Boxes({"post": (1, 1, 4), "lintel": (6, 1, 1)})
    model.put("post", (0, 0, 0))
    model.put("post", (5, 0, 0))
    model.put("lintel", (0, 0, 4))
    assert not splits(as_splits(listed(model.parts()), SMALL))


def test_merlons_and_gaps_are_a_row() -> None:
    model = Boxes({"wall": (20.2, 1, 5), "merlon": (0.8, 1, 1.2)})
    model.put("wall", (0, 0, 0))
    for k in range(13):
        model.put("merlon", (0.5 + 1.55 * k, 0, 5))
    parts = model.parts(1)
    scheme = as_splits(listed(parts), SMALL)
    assert same(scheme, parts, SMALL)
    assert any(cell.count == 13 for split in splits(scheme) for cell in split.cells)


def test_rows_with_counts_that_differ_have_scopes_of_their_own() -> None:
    """Cells that repeat share what is left by their lengths: five and three in one split would
    come out as four and four.
    """
    model = Boxes({"arch": (2, 1, 3), "slit": (0.4, 1, 3)})
    for k in range(5):
        model.put("arch", (2.5 * k, 0, 0))
    for k in range(9):
        model.put("slit", (14 + 1.1 * k, 0, 0))
    parts = model.parts(2)
    scheme = as_splits(listed(parts), SMALL)
    assert same(scheme, parts, SMALL)
    for split in splits(scheme):
        assert len({cell.count for cell in split.cells if cell.count > 1}) < 2


def test_turned_scheme_stays_where_it_is() -> None:
    parts = front(5, 3).parts()
    before = listed(parts)
    turn = np.array([[np.cos(0.2), 0, 0, np.sin(0.2)]])
    askew = Scheme(
        before.symbols, Frames(np.array([[4.0, 5, 6]]), turn, np.array([-1.0]), np.ones(1))
    )
    after = as_splits(askew, SMALL)
    assert len(splits(after)) == 2
    from ipmlang.inverse.split.expansion import expand
    from ipmlang.inverse.split.facades.matching import matched

    assert matched(expand(askew), expand(after), SMALL)


# -------------------------------------------------------------------- random façades


class Planted:
    """A façade from a random tree of splits: its parts, and where cells were elastic does not
    matter, as everything is at its first size.
    """

    def __init__(self, seed: int) -> None:
        self.draw = np.random.default_rng(seed)
        kinds = {f"part{k}": tuple(np.round(0.3 + self.draw.random(3), 2)) for k in range(4)}
        self.model = Boxes(kinds)

    def cell(self, depth: int) -> tuple[np.ndarray, list[tuple[str, np.ndarray]]]:
        """The size of a cell and what stands in it."""
        if depth == 0:
            return self._leaf()
        axis = int(self.draw.integers(3))
        at, rows, size = 0.0, [], np.zeros(3)
        for _ in range(int(self.draw.integers(1, 4))):
            own, inner = self.cell(depth - 1)
            count = int(self.draw.choice([1, 1, 3, 4]))
            length = own[axis] + round(float(self.draw.choice([0, 0.4, 0.7])), 2)
            for k in range(count):
                shift = np.eye(3)[axis] * (at + k * length)
                rows += [(name, place + shift) for name, place in inner]
            at += count * length
            size = np.maximum(size, own)
        size[axis] = at
        return size, rows

    def _leaf(self) -> tuple[np.ndarray, list[tuple[str, np.ndarray]]]:
        name = f"part{self.draw.integers(4)}"
        own = np.array(self.model.sizes[name])
        margin = np.round(self.draw.random(3) * 0.3, 2)
        return own + 2 * margin, [(name, margin)]

    def parts(self) -> Parts:
        """Everything, in any order."""
        _, rows = self.cell(3)
        for name, place in rows:
            self.model.put(name, tuple(place))
        return self.model.parts(seed=1)


@pytest.mark.parametrize("seed", range(40))
def test_planted_facades_draw_the_same_and_do_not_grow(seed: int) -> None:
    parts = Planted(seed).parts()
    before = listed(parts)
    after = as_splits(before, SMALL)
    assert same(after, parts, 4 * SMALL)
    bonus = 8 * len(splits(after)) + scheme_tokens(after, SMALL) // 8
    assert scheme_tokens(after, SMALL) <= scheme_tokens(before, SMALL) + bonus
    for rule in after.symbols:
        for item in rule.items if isinstance(rule, Rule) else ():
            if isinstance(item, Split):
                assert_fills(item.cells, float(rule.size[item.axis]))
                assert_repeats_come_out(item.cells, float(rule.size[item.axis]))


def assert_fills(cells: tuple[Cell, ...], length: float) -> None:
    """Cells fill their scope: engines would stretch them otherwise."""
    assert sum(cell.length * cell.count for cell in cells) == pytest.approx(length, abs=1e-9)
    assert any(cell.elastic for cell in cells)


def assert_repeats_come_out(cells: tuple[Cell, ...], length: float) -> None:
    """The arithmetic of sizes: every repeat takes its share by the length of its cell, and as
    often as comes nearest (the count whose cells are nearest to the length asked for).
    """
    repeats = [cell for cell in cells if cell.count > 1]
    room = length - sum(cell.length for cell in cells if cell.count == 1)
    period = sum(cell.length for cell in repeats)
    for cell in repeats:
        share = room * cell.length / period
        assert min(range(1, 99), key=lambda n: abs(share / n - cell.length)) == cell.count
