"""Every record of the operation table holds what it says: its examples check, the refused do not,
and both bodies of a function give the same bits.
"""

from __future__ import annotations

import itertools
import math
import warnings
from pathlib import Path

import numpy as np
import pytest

from ipmlang.compiler.check import Cache, check
from ipmlang.compiler.diagnostics import Diagnostic
from ipmlang.compiler.load import load_text
from ipmlang.compiler.ops import ALL_OPERATIONS, FUNCTIONS, OPERATIONS, QUERIES, leaves_plane
from ipmlang.compiler.ops.record import Function, Operation, Query

AROUND = (
    'ipm 1\nasset win = "parts/fence.parts.svg#rail"\n'
    'context mask = "parts/mask.png" over (0, 0, 10, 10)\n'
)
FOLDER = Path(__file__).resolve().parents[1] / "errors"


def troubles(rule: str) -> list[Diagnostic]:
    found = check(load_text(f"{AROUND}Any --> {rule}\nstart Any\n", FOLDER), Cache()).diagnostics
    return [each for each in found if each.severity == "error"]


def cases(records: object, field: str) -> list[tuple[str, str]]:
    assert isinstance(records, tuple)
    return [(record.name, text) for record in records for text in getattr(record, field)]


@pytest.mark.parametrize(("name", "text"), cases(ALL_OPERATIONS, "examples"))
def test_an_example_of_an_operation_checks(name: str, text: str) -> None:
    assert troubles(text) == []


@pytest.mark.parametrize(("name", "text"), cases(ALL_OPERATIONS, "refused"))
def test_a_refused_use_of_an_operation_is_an_error(name: str, text: str) -> None:
    assert troubles(text)


ASKED = (*FUNCTIONS.values(), *QUERIES.values())


@pytest.mark.parametrize(("name", "text"), cases(ASKED, "examples"))
def test_an_example_of_a_function_checks(name: str, text: str) -> None:
    assert troubles(f"Leaf({text})") == []


@pytest.mark.parametrize(("name", "text"), cases(ASKED, "refused"))
def test_a_refused_call_of_a_function_is_an_error(name: str, text: str) -> None:
    assert troubles(f"Leaf({text})")


@pytest.mark.parametrize("record", ASKED, ids=lambda record: record.name)
def test_a_function_has_an_example(record: Function | Query) -> None:
    assert record.examples and record.doc.endswith(".")


@pytest.mark.parametrize("record", ALL_OPERATIONS, ids=lambda record: record.name)
def test_a_record_is_whole(record: Operation) -> None:
    """One meaning a form, defaults for all that may be left out, steps over known parameters."""
    assert record.doc.endswith(".") and record.refused
    assert len(record.meaning) in (0, len(record.forms))
    for form, steps in zip(record.forms, record.meaning, strict=False):
        names = {param.name for param in form}
        optional = {param.name for param in form if param.optional}
        assert optional <= dict(record.defaults).keys()
        used = {
            arg.removeprefix("-") for step in steps for arg in step.args if isinstance(arg, str)
        }
        assert used <= names


def test_no_name_has_two_meanings() -> None:
    names = [name for each in ALL_OPERATIONS for name in (each.name, *each.synonyms)]
    assert len(names) == len(set(names)) == len(OPERATIONS)
    assert len(ALL_OPERATIONS) == len({each.name for each in ALL_OPERATIONS})
    assert not FUNCTIONS.keys() & QUERIES.keys()


def test_which_forms_leave_the_plane() -> None:
    at = OPERATIONS["at"]
    assert [leaves_plane(at, form) for form in range(len(at.forms))] == [False] * 3 + [True] * 2
    assert leaves_plane(OPERATIONS["down"], 0) and not leaves_plane(OPERATIONS["left"], 0)


VALUES = (0.0, -0.0, 1.0, -1.0, 2.5, -2.5, 9.6 / 3.2, 3 * 3.2, 9.6, 3.2, 1e-12, -1e-12, 90.0, 30.0,
          180.0, 1e9, 1e300, -1e300, math.inf, -math.inf, math.nan, 0.1, -3.7)  # fmt: skip


def combinations(record: Function) -> list[tuple[float, ...]]:
    """Argument lists that visit every special value in every place."""
    count = sum(not (param.optional or param.many) for param in record.params)
    count = (
        max(count, 2) if record.random or (record.params[-1:] and record.params[-1].many) else count
    )
    product = itertools.product(VALUES, repeat=min(count, 2))
    rows = [(*row, *([row[0]] * max(0, count - 2)))[:count] for row in product]
    if record.random:
        return [(u, *row) for u in (0.0, 0.25, 1 - 2**-24) for row in rows]
    return rows


@pytest.mark.parametrize("record", FUNCTIONS.values(), ids=lambda record: record.name)
def test_both_bodies_give_the_same_bits_and_no_warning(record: Function) -> None:
    rows = combinations(record)
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        batch = np.broadcast_to(np.asarray(record.batch(*columns), np.float64), len(rows))
        single = np.array([record.single(*row) for row in rows])
    same = (batch.view(np.uint64) == single.view(np.uint64)) | (np.isnan(batch) & np.isnan(single))
    wrong = [(rows[index], batch[index], single[index]) for index in np.flatnonzero(~same)[:3]]
    assert not wrong


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("floor", (3, 9.6 / 3.2)), ("ceil", (3, 9.6 / 3.2)), ("floor", (2, 2.999)),
        ("round", (3, 2.5)), ("round", (-3, -2.5)), ("sin", (1, 90)), ("cos", (0, 90)),
        ("sin", (0, 180)), ("cos", (-1, 540)), ("sin", (0.5, 30)), ("mod", (0, 9.6, 3.2)),
        ("mod", (2, -1, 3)), ("gt", (0, 3 * 3.2, 9.6)), ("ge", (1, 9.6, 3 * 3.2)),
        ("eq", (1, 3 * 3.2, 9.6)), ("eq", (0, 0, 1e-12)), ("clamp", (5, 7, 0, 5)),
        ("atan2", (135, 1, -1)), ("sign", (-1, -4)), ("lerp", (5, 0, 10, 0.5)),
    ],
)  # fmt: skip
def test_values(text: str, value: tuple[float, ...]) -> None:
    assert FUNCTIONS[text].single(*value[1:]) == pytest.approx(value[0], abs=1e-15)


NONE = math.nan
KLEENE = {  # what two truth values make: true, false and neither
    "and": {(1, 1): 1, (1, 0): 0, (1, NONE): NONE, (0, 0): 0, (0, NONE): 0, (NONE, NONE): NONE},
    "or": {(1, 1): 1, (1, 0): 1, (1, NONE): 1, (0, 0): 0, (0, NONE): NONE, (NONE, NONE): NONE},
}


def alike(one: float, other: float) -> bool:
    return one == other or (math.isnan(one) and math.isnan(other))


@pytest.mark.parametrize("name", KLEENE)
def test_truth_that_hangs_on_nan_is_nan(name: str) -> None:
    record = FUNCTIONS[name]
    for (a, b), wanted in KLEENE[name].items():
        for given in ((float(a), float(b)), (float(b), float(a))):
            assert alike(record.single(*given), wanted), given
            assert alike(float(record.batch(*map(np.array, given))), wanted), given


@pytest.mark.parametrize("name", ["lt", "le", "gt", "ge", "eq", "ne"])
def test_what_is_compared_with_nan_is_nan(name: str) -> None:
    record = FUNCTIONS[name]
    for other in (0.0, -3.0, math.inf, -math.inf, NONE):
        assert math.isnan(record.single(NONE, other)) and math.isnan(record.single(other, NONE))
    columns = np.array([NONE, 1.0, math.inf, math.inf]), np.array([1.0, NONE, math.inf, -math.inf])
    assert np.isnan(record.batch(*columns)).tolist() == [True, True, False, False]


def test_a_choice_by_nan_is_nan() -> None:
    select, negation = FUNCTIONS["select"], FUNCTIONS["not"]
    assert math.isnan(select.single(NONE, 1.0, 1.0)) and math.isnan(negation.single(NONE))
    chosen = select.batch(np.array([1.0, 0.0, NONE]), np.array([1.0, NONE, 1.0]), 2.0)
    assert [alike(*each) for each in zip(chosen, (1, 2, NONE), strict=True)] == [True] * 3


def test_random_numbers_stay_in_their_bounds() -> None:
    u = np.linspace(0, 1 - 2**-24, 10_001)
    whole = FUNCTIONS["irand"].batch(u, 1, 6)
    assert set(whole) == {1, 2, 3, 4, 5, 6}
    drawn = FUNCTIONS["rand"].batch(u, -5, 5)
    assert drawn.min() == -5 and drawn.max() < 5
    normal = FUNCTIONS["gauss"].batch(u, 10, 2)
    assert abs(normal.mean() - 10) < 0.01 and abs(normal.std() - 2) < 0.01
