"""What stops a derivation by the frontier: limits, numbers that are none, no rule that applies."""

from __future__ import annotations

import pytest

import ipmlang
from ipmlang.compiler.diagnostics import Diagnostic
from ipmlang.compiler.ir import Limits


def failure(text: str, limits: Limits | None = None, **attrs: object) -> Diagnostic:
    grammar = ipmlang.parse("ipm 1\n" + text)
    with pytest.raises(ipmlang.IpmError) as caught:
        grammar.run(attrs=attrs, limits=limits)  # type: ignore[arg-type]
    return caught.value.diagnostics[0]


ENDLESS = "A --> [F(1) A] [F(2) A] A\nstart A\n"


def test_growth_stops_at_the_limit_of_shapes_and_names_the_rule() -> None:
    found = failure(ENDLESS, Limits(shapes=100_000))
    assert found.code == "limit-shapes"
    assert "rule A" in found.message and "100,000 shapes" in found.message
    assert found.trail is not None and found.trail.startswith("start > A > A")


def test_memory_is_bounded_before_it_is_used() -> None:
    import resource

    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    found = failure(ENDLESS, Limits(memory=50_000_000))
    assert found.code == "limit-memory"
    assert (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024 < 100_000_000


def test_a_repeat_without_bound_is_refused_before_it_is_made() -> None:
    assert failure("start repeat(i < 1e12) { F }\n").code == "limit-shapes"


@pytest.mark.parametrize(
    "text",
    [
        "A(n) : n > 0 --> F(1) A(n + 1)\nA(n) : else --> nil\nstart A(1)\n",  # a chain
        "A(n) --> F(1) [B(n)]\nB(n) --> [+ A(n)]\nstart A(1)\n",  # single shapes
    ],
)
def test_depth_is_bounded(text: str) -> None:
    found = failure(text, Limits(depth=5000))
    assert found.code == "limit-depth"
    assert "5,001" in found.message


def test_a_number_that_is_none_names_the_way_to_its_shape() -> None:
    found = failure(
        "A(n) : n > 0 --> [B(1 / (n - 3))] [A(n - 1)]\nA(n) : else --> nil\n"
        "B(x) --> F(1) C(x)\nC(x) --> F(x)\nstart A(5)\n"
    )
    assert found.code == "not-a-number"
    assert found.trail == "start > A > A > A > B"


def test_a_place_that_is_none_is_an_error_too() -> None:
    found = failure(
        "A(n) : n > 0 --> f(1 / (n - 3)) F A(n - 1)\nA(n) : else --> nil\nstart A(90)\n"
    )
    assert found.code == "not-a-number"
    assert "rule A" in found.message


def test_the_trail_counts_copies() -> None:
    found = failure("Lot --> repeat(i < 9) { [Floor(i)] }\nFloor(i) : i < 3 --> F\nstart Lot\n")
    assert found.code == "no-production"
    assert "Floor(3)" in found.message
    assert found.trail == "start > Lot > Floor[3]"
    assert found.hint == "write `Floor : else --> nil` to end silently"


def test_many_shapes_without_a_production_are_counted() -> None:
    found = failure(
        "A(n) : n > 0 --> [A(n - 1)] [B(n)] A(n - 1)\nA(n) : else --> nil\n"
        "B(n) : n > 1 --> F(1)\nstart A(9)\n"
    )
    assert "nor of 255 more" in found.message


def test_percentages_over_a_hundred_are_an_error() -> None:
    found = failure("A(p) : 60% --> F\nA(p) : p % --> f\nA(p) : else --> nil\nstart A(70)\n")
    assert found.code == "over-100-percent"
    assert "130" in found.message


def test_a_factor_must_be_positive() -> None:
    found = failure("A(k) : k > 0 --> *(k - 2) F A(k - 1)\nA(k) : else --> nil\nstart A(5)\n")
    assert found.code == "scale-not-positive"


@pytest.mark.parametrize(
    ("attrs", "code"),
    [
        ({"m": 3}, "unknown-attribute"),
        ({"n": 2.5}, "wrong-attribute-type"),
        ({"n": True}, "wrong-attribute-type"),
        ({"n": 10}, "attribute-out-of-range"),
        ({"s": 4}, "wrong-attribute-type"),
        ({"c": "green"}, "attribute-out-of-range"),
        ({"n": float("nan")}, "wrong-attribute-type"),
    ],
)
def test_attributes_are_checked(attrs: dict[str, object], code: str) -> None:
    text = (
        'attr n : int = 5 in 1..9\nattr s = "x"\nattr c = "red" in { "red", "blue" }\n'
        "start repeat(i < n) { F }\n"
    )
    assert failure(text, **attrs).code == code


def test_all_wrong_attributes_are_reported_at_once() -> None:
    grammar = ipmlang.parse(
        "ipm 1\nattr columns : int = 5 in 1..9\nstart repeat(i < columns) { F }\n"
    )
    with pytest.raises(ipmlang.IpmError) as caught:
        grammar.run(attrs={"colums": 3, "columns": 99})
    assert [each.code for each in caught.value.diagnostics] == [
        "unknown-attribute",
        "attribute-out-of-range",
    ]
    assert caught.value.diagnostics[0].suggestions == ("columns",)


def test_a_default_is_drawn_once_from_the_seed() -> None:
    grammar = ipmlang.parse("ipm 1\nattr n = rand(1, 9)\nstart [F(n)] [F(n)]\n")
    sizes = [grammar.run(seed=seed).instances.size[:, 0].tolist() for seed in (1, 1, 2)]
    assert sizes[0] == sizes[1] != sizes[2]
    assert sizes[0][0] == sizes[0][1]
