"""Rules that differ in numbers alone become one rule with parameters, and draw what they drew."""

from __future__ import annotations

import re

import numpy as np
import pytest

import ipmlang
from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import Source
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.parse import parse
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.inverse.folding import fold
from ipmlang.inverse.folding.book import Covered, Stretch
from ipmlang.inverse.folding.fold import Known, _fitted
from ipmlang.inverse.folding.known_rows import KnownRows
from ipmlang.inverse.folding.least import least_tokens
from ipmlang.inverse.folding.lengths import row_lengths
from ipmlang.inverse.folding.pivots import about_points
from ipmlang.inverse.folding.printing import printed_tokens
from ipmlang.inverse.folding.progressions import RepeatTokens, with_repeats
from ipmlang.inverse.folding.rows import Row, element_tokens, rows_of, with_numbers
from ipmlang.inverse.folding.templates import best_template, rounding

THINGS = "Box --> [F(2)]\nDot --> [F(1)]\nBar --> [F(3)]\n"
CELL = "[at({}, {}) Box] [at({}, {}) Dot] [at({}, {}) Bar] [at({}, {}) Dot]"


def rules_of(text: str) -> list[ast.Rule]:
    grammar, problems = parse(Source("<text>", text))
    assert not problems
    return [item for item in grammar.items if isinstance(item, ast.Rule)]


def folded(text: str) -> str:
    """The text with its rules folded; what is drawn and what it takes are checked on the way."""
    rules = rules_of(text)
    found = fold(rules, 1e-5, set())
    made = format_grammar(ast.Grammar(found.rules))
    assert printed_tokens(rules) == count_text_tokens(format_grammar(ast.Grammar(tuple(rules))))
    assert printed_tokens(found.rules) == count_text_tokens(made)
    assert found.spared == printed_tokens(rules) - printed_tokens(found.rules)
    np.testing.assert_allclose(drawn(made), drawn(text), atol=1e-4)
    return made


def drawn(text: str) -> np.ndarray:
    """(n, …) what the text draws, in order."""
    head = "ipm 1\ncanvas (0, 0, 100, 100)\n"
    scene = ipmlang.parse(f"{head}{text}\n{THINGS}start Drawing\n").run()
    found = scene.instances
    return np.column_stack([found.position, found.rotation, found.scale, found.size])


def cell(x: float, y: float, lean: float) -> str:
    """A box with a dot, a bar that leans, and a dot twice as far."""
    places = (x, y, x + 3, y + lean, x + 20, y - 4, x + 8, y + 2 * lean)
    return CELL.format(*places)


def test_stretches_that_differ_in_a_number_are_one_rule() -> None:
    cells = [(10, 20, 1), (31, 22, 5), (7, 60, 3), (50, 41, 2)]
    made = folded(f"Drawing --> {' '.join(cell(*each) for each in cells)}\n")
    assert "[at(10, 20) Motif(1)] [at(31, 22) Motif(5)]" in made
    assert "Motif(y) --> Box [at(3, y) Dot] [at(20, -4) Bar] [at(8, 2 * y) Dot]" in made


def test_calls_that_go_on_by_equal_steps_are_a_repeat_of_repeats() -> None:
    cells = [cell(10 + 30 * i, 90 - 20 * j, j + 1) for i in range(3) for j in range(4)]
    made = folded(f"Drawing --> {' '.join(cells)}\n")
    assert "repeat(i < 3) {" in made
    assert "[at(10 + 30 * i, 90 - 20 * j) Motif(1 + j)]" in made


def test_rules_that_differ_in_a_number_are_one() -> None:
    text = "Drawing --> [at(1, 2) A] [at(9, 4) B] [at(5, 7) C] [at(8, 8) A] [at(3, 3) B]\n"
    for name, lean in (("A", 2), ("B", 5), ("C", 8)):
        text += f"{name} --> Box Bar [at(4, {lean}) Dot] Bar [at(7, {lean + 1}) Dot] Bar Dot\n"
    made = folded(text)
    assert "[at(1, 2) A(2)]" in made
    assert "A(y)    -->" in made
    assert "B " not in made


def test_rules_are_written_out_where_that_shows_what_they_share() -> None:
    # The same cells, but every other one was found as a rule with its neighbour.
    pairs = ((1, 2), (4, 3), (2, 5), (6, 1))
    body, rules = "", ""
    for number, (one, two) in enumerate(pairs):
        body += f"[at(10, {20 * number}) Pair{number}] {cell(60, 20 * number, two)} "
        rules += f"Pair{number} --> {cell(0, 0, one)}\n"
    made = folded(f"Drawing --> {body}\n{rules}")
    assert made.count("Box") == 1


def test_turned_stretches_are_placed_by_their_turn() -> None:
    def turned(x: float, y: float, angle: float) -> str:
        a = np.deg2rad(angle)
        dot = np.round([x + 3 * np.cos(a), y + 3 * np.sin(a)], 6)
        bar = np.round([x - 5 * np.sin(a), y + 5 * np.cos(a)], 6)
        return (
            f"[at({x}, {y}, {angle}) Box] [at({dot[0]}, {dot[1]}, {angle}) Dot]"
            f"[at({bar[0]}, {bar[1]}, {angle}) Bar]"
        )

    cells = [turned(20, 20, 10), turned(50, 31, 55), turned(32, 80, -20)]
    made = folded(f"Drawing --> {' '.join(cells)}\n")
    assert "[at(20, 20, 10) Motif] [at(50, 31, 55) Motif] [at(32, 80, -20) Motif]" in made


def test_what_turns_about_a_point_is_told_its_angle_alone() -> None:
    def gauge(x: float, y: float, angle: float) -> str:
        needle = np.round([x + 4 * np.cos(np.deg2rad(angle)), y + 4 * np.sin(np.deg2rad(angle))], 6)
        return (
            f"[at({x}, {y}) Box] [at({x}, {y + 7}) Dot] [at({needle[0]}, {needle[1]}, {angle}) Bar]"
        )

    gauges = [gauge(10, 20, 15), gauge(50, 26, 80), gauge(31, 70, -130), gauge(83, 77, 48)]
    made = folded(f"Drawing --> {' '.join(gauges)}\n")
    assert "Motif(angle) --> Box [at(0, 7) Dot] [+(angle) at(4, 0) Bar]" in made


@pytest.mark.parametrize(
    "body",
    [
        "[at(1, 2) Box] [at(3, 9) Dot] [at(8, 4) Box] [at(2, 7) Dot]",  # would be no shorter
        "Box Dot Bar",
        "[at(1, 2) Box] [at(2, 2) Box] [at(4, 2) Box]",  # no equal steps
    ],
)
def test_what_a_rule_would_not_shorten_stays(body: str) -> None:
    text = f"Drawing --> {body}"
    assert fold(rules_of(text), 1e-5, set()).rules == tuple(rules_of(text))


def test_what_moves_the_turtle_keeps_its_bracket() -> None:
    steps = [f"[at({x}, {y}) Row] [at({x + 9}, {y}) Box] [at({x}, {y + 2}) Dot]" for x, y in
             ((3, 4), (40, 11), (22, 60), (71, 33))]  # fmt: skip
    made = folded(f"Drawing --> {' '.join(steps)}\nRow --> repeat(i < 3) {{ [Box] f(2) }}\n")
    assert "Motif   --> [Row] [at(9, 0) Box]" in made


@pytest.mark.parametrize("seed", range(12))
def test_whatever_is_folded_draws_the_same(seed: int) -> None:
    """Copies of a few things, turned and mirrored, with parts that go their own way."""
    random = np.random.default_rng(seed)
    things = [
        [(str(random.choice(["Box", "Dot", "Bar"])), *random.integers(-9, 9, 3).tolist())
         for _ in range(random.integers(2, 5))]
        for _ in range(3)
    ]  # fmt: skip
    body = []
    for _ in range(int(random.integers(4, 16))):
        x, y, turn = [*random.integers(0, 90, 2).tolist(), int(random.choice([0, 90, 25]))]
        own = random.integers(-4, 4, 2).tolist()
        mirror = " mirror" * int(random.integers(0, 2))
        rows = "".join(
            f"[at({a + own[k % 2] * (k % 3)}, {b + own[0] * (k == 1)}, {c}) {name}]"
            for k, (name, a, b, c) in enumerate(things[int(random.integers(0, 3))])
        )
        body.append(f"[at({x}, {y}, {turn}){mirror} Copy{len(body)}]")
        body.append(f"Copy{len(body) - 1} --> {rows}")
    folded(f"Drawing --> {' '.join(body[::2])}\n" + "\n".join(body[1::2]) + "\n")


def card(shape: str, y: float) -> str:
    """A box with a symbol at two corners and in the middle."""
    return (
        f"Box [at(2, {y}, 0, 1.25) {shape}] [at(17.5, {30 - y}, 180, 1.25) {shape}] "
        f"[at(9.75, 15) {shape}] Bar"
    )


def test_rules_that_differ_in_a_symbol_are_one() -> None:
    names = ("Dot", "Bar", "Box")
    text = "Drawing --> [at(1, 2) A] [at(9, 4) B] [at(5, 7) C]\n"
    for name, shape in zip("ABC", names, strict=True):
        text += f"{name} --> {card(shape, 3)}\n"
    made = folded(text)
    assert "[at(1, 2) A(Dot)] [at(9, 4) A(Bar)]" in made
    assert "A(shape) -->" in made
    assert made.count("17.5") == 1


def test_symbols_and_numbers_vary_together() -> None:
    text = "Drawing --> [at(1, 2) A] [at(9, 4) B] [at(5, 7) C] [at(3, 1) A] [at(4, 4) B]\n"
    for name, shape, y in (("A", "Dot", 3), ("B", "Bar", 5.5), ("C", "Dot", 4.25)):
        text += f"{name} --> {card(shape, y)} [at({y}, {y}) Dot] Box\n"
    made = folded(text)
    assert "A(Dot, 3)" in made
    assert "A(Bar, 5.5)" in made
    assert "[at(17.5, 30 - " in made


def test_a_rule_that_is_told_as_much_as_it_draws_is_none() -> None:
    pairs = [("Dot", "Bar", 3, 5), ("Box", "Dot", 6, 1), ("Bar", "Box", 2, 9), ("Dot", "Box", 4, 4)]
    cells = [
        f"[at({7 * k}, {3 * k}, {k}) Box] [at({7 * k + x}, {y}, 180, 1.5) {one}] {other}"
        for k, (one, other, x, y) in enumerate(pairs)
    ]
    assert "shape" not in folded(f"Drawing --> {' '.join(cells)}\n")


def test_what_moves_the_turtle_is_no_symbol_to_give() -> None:
    text = "Drawing --> [at(1, 2) A] [at(9, 4) B] [at(5, 7) A]\nGo --> f(3)\n"
    for name, thing in (("A", "[at(1, 1) Go] Go"), ("B", "[at(1, 1) Dot] Dot")):
        text += f"{name} --> Box [at(4, 2) Dot] [at(7, 8) Bar] [at(12, 9) Box] {thing}\n"
    assert "(Go" not in folded(text)


def test_steps_of_angles_and_sizes_are_exact_however_coarse_places_are() -> None:
    rows = [Row((0.0, 0.0, 360 / 7 * k - 180, 1 + k / 3), name="Box") for k in range(7)]
    (repeat,) = with_repeats(rows, rounding(1e-2), set())
    numbers = [float(each) for each in re.findall(r"value=([-\d.]+)", str(repeat))]
    assert 51.428571428571 in numbers and 0.333333333333 in numbers


def test_rows_with_other_numbers_keep_the_symbols_that_they_are_given() -> None:
    (made,) = with_numbers([Row(name="Card", args=(1.0,), symbols=("Box",))], [2, 3, 0, 1, 5])
    assert (made.frame, made.args, made.symbols) == ((2, 3, 0, 1), (5,), ("Box",))


def test_half_a_turn_either_way_round_is_no_turn_about_a_point() -> None:
    table = np.array([[0.0, 0.0, 180.0, 1.0], [5.0, 0.0, -180.0, 1.0], [9.0, 0.0, 180.0, 1.0]])
    with np.errstate(all="raise"):
        rows, numbers = about_points([Row(name="Box")], table, [0], 1e-3)
    assert not rows[0].inner and (numbers == table).all()


def test_the_same_rows_in_other_stretches_are_fitted_anew() -> None:
    rows = [Row((x, y, 0.0, 1.0), name="Box") for x, y in ((0, 0), (3, 1), (9, 9), (12, 10))] * 3
    given, known = rounding(1e-5), Known()
    for count in (2, 6):
        stretches = [tuple(rows[k : k + count]) for k in range(0, len(rows), count)]
        found = _fitted(stretches, given, known, -100, frozenset())
        assert found is not None and len(found[0].places) == len(stretches)


ROWS = f"""Drawing --> Box {cell(3, -4, 2)} [at(0, 0, 30) Dot] [-(30) *(0.5) mirror Bar]
    [at(2, 1, 0, 3) Go(2, -1)]
    [at(4, -2) css("fill:red") Dot [+(20) Bar] [at(1, 1, 5, 0.25) mirror Box]] [effect("a") Box]
"""  # fmt: skip


def read() -> tuple[Row, ...]:
    return rows_of(rules_of(ROWS)[0].body)


def test_lengths_for_many_numbers_at_once_are_those_of_rows() -> None:
    rows = read()
    random = np.random.default_rng(3)
    numbers = np.array([[value for row in rows for value in row.numbers]] * 40)
    changed = random.random(numbers.shape) < 0.4
    numbers = np.where(changed, random.choice([-2.5, 0.0, 1.0, 7.0], numbers.shape), numbers)
    hands = np.array([[row.hand for row in rows]] * 40, np.int8)
    found = row_lengths(rows).of(1 + (numbers < 0), numbers, hands)
    wanted = [sum(each.tokens for each in with_numbers(rows, own)) for own in numbers.tolist()]
    assert found.tolist() == wanted
    assert len(set(wanted)) > 10


@pytest.mark.parametrize("kind", ["moved", "turned", "about points", "any", "sized", "told"])
def test_no_rule_takes_less_than_is_known_before_its_numbers_are_fitted(kind: str) -> None:
    random, given, fitted = np.random.default_rng(len(kind)), rounding(1e-3), 0

    def place(*, free: bool) -> tuple[float, float, float, float]:
        x, y = random.choice([0.0, 1.0, 1.0004, -7.5, 20.0], 2).tolist()
        angle, scale = float(random.choice([0, 30, 180])), float(random.choice([1, 1, 2]))
        turned = free and kind in ("turned", "any")
        return (x, y, angle if turned else 0.0, scale if free and kind == "sized" else 1.0)

    for _ in range(60):
        count, often = int(random.integers(1, 5)), int(random.integers(2, 6))
        own = [place(free=True) for _ in range(count)]
        stretches = []
        for _ in range(often):
            lead, turn = place(free=True), float(random.integers(0, 90))
            shift = [float(random.choice([0, 0, 0.002, 5])) for _ in own]
            told = (float(random.integers(0, 3)),) if kind == "told" else ()
            name = str(random.choice(["A", "B"])) if kind in ("any", "told") else "A"
            spin = turn if kind == "about points" else 0.0
            rows = [
                Row(
                    (x + lead[0] + more, y + lead[1], angle + lead[2] + spin, size),
                    name=name,
                    args=told,
                )
                for (x, y, angle, size), more in zip(own, shift, strict=True)
            ]
            stretches.append(tuple(rows))
        written = sum(row.tokens for rows in stretches for row in rows)
        found = best_template(stretches, given, -1000)
        if found is not None:
            fitted += 1
            assert written - least_tokens(stretches, given) >= found[1], stretches
    assert fitted > 20


def test_rows_that_say_the_same_are_one() -> None:
    known = KnownRows(rounding(1e-5))
    one, other = known.read(read()), known.read(read())
    assert all(a is b for a, b in zip(one, other, strict=True))
    assert known.rule(one) is known.rule(other)
    call = Row((3.0, 4.0, 90.0, 2.0), name="Motif")
    (written,) = known.written_out([call], known.rule(one[:2]))
    assert [row.frame[:2] for row in written] == [(3.0, 4.0), (11.0, 10.0)]
    assert all(row.origin == "Motif" for row in written)
    assert known.written_out([call], known.rule(other[:2]))[0] is written


def test_repeats_are_counted_as_they_are_printed() -> None:
    rows = [Row((8.0 * k, 3.0, 0.0, 1.0), name="Box") for k in range(5)]
    rows += [*read(), Row(name="Go"), Row(pens=read()[7].pens, inner=tuple(rows))]
    known = KnownRows(rounding(1e-5))
    own, leaving = known.read(rows), {"Go"}
    printed = with_repeats(own, known.given, leaving)
    assert RepeatTokens(known, leaving).of(own) == sum(map(element_tokens, printed))


@pytest.mark.parametrize(
    ("one", "other", "meet"),
    [
        (Stretch("A", (), 2, 3), Stretch("A", (), 4, 2), True),
        (Stretch("A", (), 2, 3), Stretch("A", (), 5, 2), False),
        (Stretch("A", (), 2, 3), Stretch("B", (), 2, 3), False),
        (Stretch("A", (), 2, 3), Stretch("A", (4, 1), 0, 1), True),
        (Stretch("A", (), 2, 3), Stretch("A", (1, 3), 0, 1), False),
        (Stretch("A", (4,), 0, 2), Stretch("A", (4,), 2, 1), False),
        (Stretch("A", (4,), 0, 2), Stretch("A", (4, 1), 5, 1), True),
    ],
)
def test_stretches_meet_where_rows_are_in_both_or_in_one_another(
    one: Stretch, other: Stretch, meet: bool
) -> None:
    for first, second in ((one, other), (other, one)):
        covered = Covered()
        covered.add([first])
        assert covered.meets([second]) is meet
