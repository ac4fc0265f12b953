"""From text to the IR: what is reachable, what threads, what moves, and numbers that edits keep."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from ipmlang.compiler import compile_file, ir
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.ir_text import dump
from ipmlang.compiler.verify import verify
from ipmlang.runtime import derive
from tests.engine.grammars import compiled


def program(text: str) -> ir.Program:
    return compiled("ipm 1\n" + text)


def by_name(found: ir.Program) -> dict[str, ir.Symbol]:
    return {symbol.name: symbol for symbol in found.symbols}


@pytest.mark.parametrize(
    ("text", "threaded"),
    [
        ("P(m) : m > 0 --> [F] f P(m - 1)\nP(m) : else --> [F]\nstart P(3)\n", False),
        ("P(m) : m > 0 --> [F] P(m - 1) f F\nP(m) : else --> nil\nstart P(3)\n", True),
        ("P(m) : m > 0 --> [F] P(m - 1) F\nP(m) : else --> nil\nstart P(3)\n", True),
        ("P(m) : m > 0 --> [F] P(m - 1) [F]\nP(m) : else --> nil\nstart P(3)\n", False),
        ("P(m) : m > 0 --> F P(m - 1) F\nP(m) : else --> nil\nstart P(3)\n", True),
        ("P(m) : m > 0 --> F [P(m - 1)] F\nP(m) : else --> nil\nstart P(3)\n", False),
        ("A --> F B\nB --> F\nstart A F\n", True),  # moves at the end of what is followed
        ("A --> [F] B\nB --> [F]\nstart A F\n", False),  # draws, but never moves
        ("A --> F\nstart repeat(i < 3) { A }\n", True),  # the next copy starts where this one ends
        ("A --> F\nstart repeat(i < 3) { [A] f }\n", False),
        ("A --> F\nstart [A f(3)]\n", False),  # nothing reads the move
        ("A --> F\nstart [A f(3) F]\n", True),
        ('A --> color("red")\nstart A F\n', True),  # a pen is state, too
        ("F --> F + F\nstart F steps 2\n", True),
        ("A --> F cut F\nstart [A]\n", True),
        ("A < B --> F\nA --> nil\nstart A B steps 1\n", True),
    ],
)
def test_what_threads(text: str, threaded: bool) -> None:
    assert program(text).threaded is threaded


@pytest.mark.parametrize(
    ("text", "flat"),
    [
        ("start F +(30) f(2) *(2) mirror at(1, 2, 30) turn F\n", True),
        ("start F &(30) F\n", False),
        ("start at(1, 2, 3, 1, 0, 0, 0) F\n", False),
        ("A --> /(3) F\nstart F\n", True),  # what tilts is never reached
        ("tropism (0, -1, 0) 0.2\nstart F\n", True),
        ("tropism (0, 0, -1) 0.2\nstart F\n", False),
    ],
)
def test_what_is_flat(text: str, flat: bool) -> None:
    assert program(text).flat is flat


def test_moves_is_what_can_displace_what_follows() -> None:
    found = by_name(program("A --> [F] B\nB --> f C\nC --> [F]\nD --> [B]\nstart [A] [D]\n"))
    assert [found[name].moves for name in "ABCD"] == [True, True, False, False]


def test_constants_fold_and_functions_are_inlined() -> None:
    found = program(
        "const side = 2 * 3\nfn twice(x) = x + x\nA(n) --> F(twice(n) * side)\n"
        "start A(twice(side) + 1)\n"
    )
    calls = [each.const for each in found.axiom.body if each.op == "call"]
    assert calls == []
    assert [each.const for each in found.axiom.body if each.op == "const"] == [13.0]
    assert [each.const for each in found.productions[0].body if each.op == "call"] == ["add", "mul"]


def test_the_settings_of_the_turtle_are_defaults() -> None:
    found = by_name(program("attr a = 20\nturtle angle a step 7 width 3\nstart F + F\n"))
    assert found["F"].meaning is not None and found["+"].meaning is not None
    assert found["F"].meaning[0].const == 7.0
    assert found["+"].meaning[0].op == "attr"


def test_a_head_may_bear_an_operations_name() -> None:
    found = program("F --> F draw(2)\nstart F steps 1\n")
    plain, measured = found.symbols
    assert (plain.name, plain.arity, plain.productions) == ("F", 0, (0,))
    assert (measured.name, measured.arity, measured.productions) == ("F", 1, ())
    assert plain.meaning is not None and measured.meaning is not None


def test_sites_start_afresh_in_guard_chance_and_body_of_each_production() -> None:
    text = (
        "A : rand() < 0.5 : rand() * 100 % --> F(rand())\nA : else --> F(rand()) F(rand())\n"
        "start A\n"
    )
    before = program(text)
    after = program(text.replace("--> F(rand())\nA", "--> F(rand(1, 2)) F(3) F\nA"))
    assert before.productions[1] == after.productions[1]
    first = before.productions[0]
    assert first.guard is not None and first.chance is not None
    draws = [
        next(each.site for each in code if each.op == "uniform")
        for code in (first.guard[0], first.chance[1], first.body)
    ]
    assert draws == [0x10000000, 0x20000000, 0]


def test_what_is_not_executable_is_named_only_where_it_is_reached() -> None:
    ivy = "Ivy --> march(1, 0) { top: Ivy | extruded: Bark }\nBark --> tube(0.1)\n"
    assert program(ivy + "start F\n").productions == ()
    with pytest.raises(IpmError) as caught:
        program(ivy + "start [Ivy] [Ivy]\n")
    names = [each.message for each in caught.value.diagnostics]
    assert len(names) == 2
    for name in ("march", "tube"):
        assert any(f"`{name}`" in message for message in names)
    assert all(each.code == "not-executable" for each in caught.value.diagnostics)


def test_tables_and_steps_are_rows() -> None:
    found = program(
        'table T(x, c) = (1, "red"), (2, "blue"), (3, "red")\n'
        "start repeat(r in T) { [f(r.x) color(r.c) F] } repeat(i < 3) steps (4, 5) { [F] }\n"
    )
    assert [table.columns for table in found.tables] == [("x", "c"), ("step",)]
    assert found.tables[0].text_columns == {"c"}
    texts = [found.strings[int(row[1])] for row in found.tables[0].rows]
    assert texts == ["red", "blue", "red"]
    assert found.tables[1].rows == ((4.0,), (5.0,), (0.0,))


def test_a_row_says_where_its_copy_stands() -> None:
    """As the steps to its place written out; what the table has no column for moves nothing."""
    table = "table T(x, z, rz, scale, c) = (1, 2, 90, 2, 7), (3, 4, 0, 1, 8)\n"
    steps = "translate(r.x, 0, r.z) rotate(0, 0, r.rz) *(r.scale)"
    short = program(table + "start repeat(at T) { translate(at.c, 0, 0) B }\n")
    long = program(table + f"start repeat(r in T) {{ [{steps} translate(r.c, 0, 0) B] }}\n")
    assert dump(short) == dump(long)
    with pytest.raises(IpmError, match="which is a rule's name"):
        program("table T(x) = 1\ntranslate(a, b, c) --> F(a)\nstart repeat(at T) { F }\n")


def test_rows_name_what_stands_in_their_place() -> None:
    """As a table for each symbol where its rows stand together; numbers may be read besides."""
    rows = "B, 1\n    B, 3\n    A, 2\n"
    rules = "A --> F(1)\nB --> F(2)\n"
    short = program(f"table T(shape, x) =\n    {rows}{rules}start repeat(at T) {{ f at.shape }}\n")
    two = "table T(x) = 1 3\ntable U(x) = 2\n"
    long = program(two + rules + "start repeat(at T) { f B } repeat(at U) { f A }\n")
    assert dump(short) == dump(long).replace(" U x", " T x")
    read = "start repeat(r in T) { [f(r.x) F] }\n"
    assert program(f"table T(shape, x) = {rows}{rules}{read}").tables[0].columns == ("x",)


def test_rows_of_several_symbols_come_in_their_order() -> None:
    """Whatever the row is called, and beside a count: each copy has the symbol of its own row."""
    shapes = "BACABCCBAD"
    rows = " ".join(f"({shape}, {x})" for x, shape in enumerate(shapes))
    rules = "".join(f"{each} --> F({size})\n" for size, each in enumerate("ABCD", start=1))
    sizes = [("ABCD".index(shape) + 1, x) for x, shape in enumerate(shapes)]
    for loop in ("repeat(r in T)", "repeat(i < 10) with r in T"):
        text = f"table T(shape, x) = {rows}\n{rules}start {loop} {{ [f(r.x) r.shape] }}\n"
        made = derive(program(text)).instances
        assert list(zip(made.size[:, 0], made.position[:, 0], strict=True)) == sizes


def test_names_of_an_import_keep_apart(tmp_path: Path) -> None:
    (tmp_path / "roofs.ipm").write_text(
        "ipm 1\nattr pitch = 30\nconst k = 2\nHip(a) --> F(a * k) Ridge\nRidge --> [F(pitch)]\n"
    )
    main = tmp_path / "main.ipm"
    main.write_text(
        'ipm 1\nimport "roofs"\nattr pitch = 7\nRidge --> [F(pitch)]\n'
        "start [roofs.Hip(roofs.pitch)] [Ridge]\n"
    )
    found = compile_file(main)[1]
    assert [attr.name for attr in found.attrs] == ["pitch", "roofs.pitch"]
    ridges = [symbol for symbol in found.symbols if symbol.name == "Ridge"]
    assert len(ridges) == 2
    reads = [
        [each.const for each in found.productions[symbol.productions[0]].body if each.op == "attr"]
        for symbol in ridges
    ]
    assert sorted(reads) == [[0], [1]]


def test_the_dump_of_a_guarded_rule() -> None:
    text = (
        "A(n) : n > 0 : 30% --> [+(n * 2) F] repeat(i < n) { f(i) } A(n - 1)\nA(n) : else --> nil\n"
    )
    lines = dump(program(text + "start A(3)\n")).split("\n")
    begin = lines.index("production 0 A(p0)")
    assert lines[begin : begin + 25] == [
        "production 0 A(p0)",
        "    guard r2",
        "        r0 = param 0",
        "        r1 = const 0.0",
        "        r2 = gt r0 r1",
        "    percent r3",
        "        r3 = const 30.0",
        "    [",
        "        r4 = param 0",
        "        r5 = const 2.0",
        "        r6 = mul r4 r5",
        "        + r6 @0",
        "        F @1",
        "    ]",
        "    repeat r4 0",
        "        r7 = index 0",
        "        f r7 @2",
        "    r8 = const 1.0",
        "    r9 = sub r4 r8",
        "    A r9 @3",
        "production 1 A(p0)",
        "    else",
        "    nil @0",
    ]


GOOD = (
    "A(n) : n > 0 --> [+(n) F] repeat(i < n) { f(i) } A(n - 1)\nA(n) : else --> nil\nstart A(3)\n"
)


def broken(change: str) -> ir.Program:
    """A program with one invariant broken."""
    found = program(GOOD)
    first = found.productions[0]
    body = list(first.body)
    modules = [place for place, each in enumerate(body) if each.op == "module"]
    match change:
        case "unwritten":
            body = [each for each in body if each.op != "param"]
        case "twice":
            body.append(body[1])
        case "site":
            body[modules[0]] = replace(body[modules[0]], site=body[modules[1]].site)
        case "bracket":
            body = [each for each in body if each.op != "close"]
        case "symbol":
            body[modules[0]] = replace(body[modules[0]], const=99)
        case "arity":
            body[modules[0]] = replace(body[modules[0]], args=())
        case "meaning":
            body.append(ir.Instruction("mirror"))
        case _:
            raise AssertionError(change)
    return replace(found, productions=(replace(first, body=tuple(body)), *found.productions[1:]))


def test_what_lowering_makes_is_sound() -> None:
    assert verify(program(GOOD)) == []


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("unwritten", "before it is written"),
        ("twice", "written twice"),
        ("site", "used twice"),
        ("bracket", "stay open"),
        ("symbol", "no symbol 99"),
        ("arity", "arguments, not 0"),
        ("meaning", "not in a meaning"),
    ],
)
def test_the_verifier_sees_what_is_broken(change: str, said: str) -> None:
    assert any(said in problem for problem in verify(broken(change)))
