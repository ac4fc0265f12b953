"""The split tree of the 2016 paper: boxes in boxes, equal subtrees, subdivisions, and back."""

from __future__ import annotations

import numpy as np
import pytest
from inverse.box_models import Boxes, same

from ipmlang.edit.buildings.contacts import neighbours
from ipmlang.inverse.split.expansion import expand
from ipmlang.inverse.split.paper.labelling import labelled, rule_labels
from ipmlang.inverse.split.paper.raw_form import raw_form
from ipmlang.inverse.split.paper.subdivisions import lattices
from ipmlang.inverse.split.paper.tree import point_splits, split_tree
from ipmlang.inverse.split.scheme import Array, Octant, Rule

SMALL = 1e-9


def two_wings() -> Boxes:
    """Walls with windows in them, panes in the windows; one wing stands across the other."""
    model = Boxes({"wall": (10, 0.4, 3), "window": (1.2, 0.2, 1.5), "pane": (0.5, 0.1, 0.7)})
    for floor in range(4):
        model.put("wall", (0, 0, 3.0 * floor))
        model.put("wall", (10, 0, 3.0 * floor), 1)
        for bay in range(4):
            along, up = 1 + 2.2 * bay, 3.0 * floor
            model.put("window", (along, 0.05, up + 0.9))
            model.put("pane", (along + 0.3, 0.1, up + 1.1))
            model.put("window", (10.4 - 0.05 - 0.2, along, up + 0.9), 1)
            model.put("pane", (10.4 - 0.1 - 0.1, along + 0.3, up + 1.1), 1)
    return model


@pytest.mark.parametrize("seed", range(4))
def test_wings_come_back_as_two_rules_that_repeat(seed: int) -> None:
    parts = two_wings().parts(seed)
    scheme = raw_form(parts, SMALL)
    assert same(scheme, parts)
    rules = [each for each in scheme.symbols if isinstance(each, Rule)]
    assert len(rules) == 3  # a window with its pane, a wall with its windows, all of it
    counts = sorted(
        item.counts for rule in rules for item in rule.items if isinstance(item, Octant)
    )
    assert counts == [(1, 1, 1), (1, 1, 4), (1, 1, 4), (4, 1, 1)]


def test_tightest_box_encloses() -> None:
    model = two_wings()
    parts = model.parts()
    tree = split_tree(parts.low, parts.high, SMALL)
    names = ["root", *(name for name, _ in model.placed)]
    above = {"wall": "root", "window": "wall", "pane": "window"}
    assert all(names[tree.parent[node]] == above[names[node]] for node in range(1, len(names)))


def test_subtree_that_differs_gets_its_own_label() -> None:
    model = two_wings()
    model.put("pane", (1.1, 0.1, 0.95))
    parts = model.parts()
    tree = split_tree(parts.low, parts.high, SMALL)
    labels = labelled(tree, parts, SMALL)
    walls = labels.label[1:][parts.shape == 0]
    assert sorted(np.unique(walls, return_counts=True)[1].tolist()) == [1, 7]


def test_labels_bubble_up_to_parents() -> None:
    """Every window with its pane stands alone in its frame: the frame is the rule."""
    model = Boxes({"frame": (2, 1, 2), "window": (1.2, 0.5, 1.5), "pane": (0.5, 0.1, 0.7)})
    for x in (0.0, 3.0, 7.0):
        model.put("frame", (x, 0, 0))
        model.put("window", (x + 0.4, 0.2, 0.2))
        model.put("pane", (x + 0.6, 0.3, 0.4))
    parts = model.parts()
    tree = split_tree(parts.low, parts.high, SMALL)
    labels = labelled(tree, parts, SMALL)
    assert len(rule_labels(tree, labels)) == 1
    assert same(raw_form(parts, SMALL), parts)


def test_neighbours_touch_or_overlap() -> None:
    draw = np.random.default_rng(3)
    low = draw.integers(0, 12, (80, 3)).astype(float)
    high = low + draw.integers(1, 4, (80, 3))
    expected = [
        [i, j] for i in range(80) for j in range(i + 1, 80)
        if (np.maximum(low[i], low[j]) <= np.minimum(high[i], high[j])).all()
    ]  # fmt: skip
    assert neighbours(low, high, 0.0).tolist() == expected


@pytest.mark.parametrize("seed", range(3))
def test_point_splits_take_the_box_out(seed: int) -> None:
    draw = np.random.default_rng(seed)
    for _ in range(200):
        outer = np.zeros(3), draw.integers(1, 5, 3).astype(float)
        low = np.floor(draw.random(3) * outer[1])
        high = low + np.ceil(draw.random(3) * (outer[1] - low))
        taken = point_splits(outer, (low, high), SMALL)
        assert len(taken.cuts) <= 2
        begin, size = outer
        for cut in taken.cuts:
            beyond = (cut.octant - 1 >> np.arange(3) & 1).astype(bool)
            begin = begin + np.where(beyond, cut.point, 0)
            size = np.where(beyond, size - cut.point, cut.point)
        assert begin.tolist() == low.tolist() == taken.low.tolist()
        assert size.tolist() == (high - low).tolist() == taken.size.tolist()


def test_lattices_need_not_follow_the_axes() -> None:
    steps = np.array([[2.0, 1, 0], [-1, 3, 0.5], [0, 0.2, 4]])
    digits = np.indices((4, 3, 2)).reshape(3, -1).T
    places = np.random.default_rng(1).permutation(digits @ steps)
    (found,), rest = lattices(places, SMALL)
    assert sorted(found.counts) == [2, 3, 4] and not len(rest)


def test_row_is_found_among_others() -> None:
    places = np.array([[1.5 * i, 0.0, 0.0] for i in range(5)] + [[0.7, 2.0, 9.0], [3.1, 5.0, 1.0]])
    found, rest = lattices(places, SMALL)
    assert [each.counts for each in found] == [(5,)] and rest.tolist() == [5, 6]


def test_cells_begin_before_their_contents_where_there_is_no_room_behind() -> None:
    model = Boxes({"wall": (10, 0.4, 3), "window": (1, 0.2, 1)})
    model.put("wall", (0, 0, 0))
    for k in range(4):
        model.put("window", (1.9 + 2.3 * k, 0.1, 1))
    parts = model.parts()
    scheme = raw_form(parts, SMALL)
    assert same(scheme, parts)
    counts = [i.counts for s in scheme.symbols if isinstance(s, Rule) for i in s.items
              if isinstance(i, Octant)]  # fmt: skip
    assert (4, 1, 1) in counts


@pytest.mark.parametrize("seed", range(20))
def test_random_boxes_in_boxes_come_back(seed: int) -> None:
    """Rules for what stands in boxes that are turned by quarters, and rows of them."""
    draw = np.random.default_rng(seed)
    model = Boxes({"hall": (8, 6, 4), "room": (3, 2, 2), "box": (1, 0.5, 0.7), "lid": (1, 0.5, 0)})
    for hall in range(int(draw.integers(1, 4))):
        corner = np.array([9.0 * hall, 0, 0])
        model.put("hall", tuple(corner))
        for room in range(int(draw.integers(0, 3))):
            inner = corner + np.array([0.2 + 3.5 * room, 0.5, 0.5 * draw.integers(3)])
            model.put("room", tuple(inner), int(draw.integers(4)))
            for k in range(int(draw.integers(0, 4))):
                name = str(draw.choice(["box", "lid"]))
                low = inner + np.array([0.1, 0.1, 0.1 + 0.4 * k])
                model.put(name, tuple(low), int(draw.integers(4)))
    parts = model.parts(seed)
    scheme = raw_form(parts, SMALL)
    shape, _ = expand(scheme)
    assert len(shape) == len(parts.shape)
    assert same(scheme, parts, 1e-7)


def test_skewed_rows_are_arrays() -> None:
    model = Boxes({"house": (20, 20, 5), "post": (0.3, 0.3, 3)})
    model.put("house", (0, 0, 0))
    for i in range(6):
        model.put("post", (1.0 + 2.1 * i, 2 + 1.3 * i, 0.1))
    parts = model.parts(2)
    scheme = raw_form(parts, SMALL)
    assert same(scheme, parts)
    assert any(isinstance(item, Array) for item in scheme.symbols[-1].items)


def test_flat_parts_stay() -> None:
    """Splits leave nothing of a box without thickness: its place is told in the box around it."""
    model = Boxes({"slab": (4, 4, 1), "sheet": (2, 0, 1), "lid": (4, 4, 0)})
    model.put("slab", (0, 0, 0))
    model.put("sheet", (1, 2, 0))
    model.put("lid", (0, 0, 1))
    parts = model.parts()
    scheme = raw_form(parts, SMALL)
    assert same(scheme, parts)
    octants = [i for s in scheme.symbols if isinstance(s, Rule) for i in s.items]
    assert all((item.size > 0).all() for item in octants if isinstance(item, Octant))


def test_growth_is_close_to_linear() -> None:
    model = Boxes({"wall": (9, 0.4, 3), "window": (1.2, 0.2, 1.5)})
    for block in range(40):
        for floor in range(25):
            model.put("wall", (10.0 * block, 0, 3.0 * floor))
            for bay in range(4):
                model.put("window", (10.0 * block + 1 + 2 * bay, 0.1, 3.0 * floor + 0.9))
    parts = model.parts(1)
    scheme = raw_form(parts, SMALL)
    shape, _ = expand(scheme)
    assert len(shape) == len(parts.shape) == 5000
    assert len([each for each in scheme.symbols if isinstance(each, Rule)]) == 2
