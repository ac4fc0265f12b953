"""`residual T`: what no rule explains, terminal by terminal, whichever executor drew."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ipmlang
from ipmlang.compiler import ir
from ipmlang.formats.svg.tables import table_xml
from ipmlang.runtime import derive
from ipmlang.runtime.bind import bind
from ipmlang.runtime.numpy_backend import derive_frontier
from ipmlang.runtime.scene import OUTLINE, Scene
from ipmlang.runtime.strings import derive_string
from tests.engine.grammars import compiled
from tests.engine.random_grammars import Grammar
from tests.oracles import quaternion_matrix

ROW = "P(m) : m > 0 --> [F(1)] f(2) P(m - 1)\nP(m) : else --> nil\nattr n = 3\nstart P(n)\n"


def both(program: ir.Program, seed: int = 0) -> list[Scene]:
    """The scenes of both executors."""
    program, attrs = bind(program, None, seed)
    batched = derive_frontier(program, attrs, seed, program.limits)
    assert batched is not None
    return [batched, derive_string(program, attrs, seed, program.limits)]


def table(columns: str, *rows: str) -> str:
    cells = "\n".join(f"    ({row})" for row in rows)
    return f"ipm 1\ntable T({columns}) =\n{cells}\nresidual T\n"


def test_rows_move_turn_and_scale_terminals_in_the_order_they_are_drawn() -> None:
    text = table("x, y, angle, scale", "0, 0, 0, 1", "0.5, -1, 90, 2", "0, 0, -45, 0.5")
    for scene in both(compiled(text + ROW)):
        found = scene.instances
        assert found.position[:, :2].tolist() == [[0, 0], [2.5, -1], [4, 0]]
        half = np.sqrt(0.5)
        np.testing.assert_allclose(found.rotation[1], (half, 0, 0, half), atol=1e-15)
        assert found.scale.tolist() == [1, 2, 0.5]


def test_rows_of_some_terminals_leave_the_others_as_they_are() -> None:
    text = table("of, x, layer, color", '2, 0.5, 0, ""', '0, 0, 1, "red"')
    for scene in both(compiled(text + ROW.replace("n = 3", "n = 5"))):
        found = scene.instances
        assert found.position[:, 0].tolist() == [0, 2, 4.5, 6, 8]
        assert found.layer.tolist() == [1, 2, 0, 3, 4]
        assert [f"{each:08x}" for each in found.color[:2]] == ["ff0000ff", "00000000"]


@pytest.mark.parametrize("of", ["3", "-1", "0.5", "1"])
def test_a_row_of_no_terminal_or_of_one_that_has_a_row_is_an_error(of: str) -> None:
    grammar = ipmlang.parse(table("of, x", "1, 2", f"{of}, 2") + ROW)
    with pytest.raises(ipmlang.IpmError, match=rf"row 2 .* is of terminal {of}, and 3 terminals"):
        grammar.run()
    (note,) = grammar.run(attrs={"n": 1}).notes
    assert note.endswith("it is left out")


def test_colours_styles_and_paint_order_stand_in_for_those_of_the_pen() -> None:
    text = table("color, css, fill, layer", '"#0f0", "", "", 2', '"", "a:1", "", 0',
                 '"", "", "red", 1')  # fmt: skip
    rules = 'start fill("blue") css("b:2") repeat(i < 3) { layer(5) [F(1)] f(2) }\n'
    for scene in both(compiled(text + rules)):
        found = scene.instances
        assert [f"{each:08x}" for each in found.color] == ["00ff00ff", "00000000", "00000000"]
        assert [scene.styles[each].css for each in found.style] == [
            "b:2", "a:1;fill:blue", "b:2;fill:red",
        ]  # fmt: skip
        assert found.layer.tolist() == [2, 0, 1]


@pytest.mark.parametrize("seed", range(24))
def test_any_drawing_is_adjusted_alike_by_both_executors(seed: int) -> None:
    """Against the frames of the regular drawing, turned by plain matrices."""
    text = Grammar(seed).text()
    regular = both(compiled(text), seed)[0].instances
    random = np.random.default_rng(seed)
    count, flat = len(regular), compiled(text).flat
    numbers = np.round(random.uniform(0.2, 3, (count, 4 if flat else 5)), 3)
    rows = [", ".join(map(str, row)) for row in numbers.tolist()]
    columns = "x, y, angle, scale" if flat else "x, y, angle, scale, z"
    if not count:
        return
    head = table(columns, *rows).removeprefix("ipm 1\n")
    for scene in both(compiled(text + head), seed):
        found = scene.instances
        moved = numbers[:, [0, 1]] if flat else numbers[:, [0, 1, 4]]
        width = moved.shape[1]
        np.testing.assert_allclose(found.position[:, :width], regular.position[:, :width] + moved)
        np.testing.assert_allclose(found.scale, regular.scale * numbers[:, 3])
        for row in range(count):
            hand = np.sign(regular.scale[row])
            angle = np.radians(numbers[row, 2]) * hand
            c, s = np.cos(angle), np.sin(angle)
            turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
            np.testing.assert_allclose(
                quaternion_matrix(*found.rotation[row]),
                quaternion_matrix(*regular.rotation[row]) @ turn,
                atol=1e-9,
            )


def test_each_segment_of_a_line_is_a_terminal_of_its_own() -> None:
    text = table("x, y", "0, 1", "0, 2", "0, 3") + "F --> F F\nstart F F steps 0\n"
    with pytest.raises(ipmlang.IpmError, match="3 rows, and 2 terminals"):
        ipmlang.parse(text).run()
    scene = ipmlang.parse(text.replace("start F F", "start F F F")).run()
    assert scene.instances.position[:, :2].tolist() == [[0, 1], [1, 2], [2, 3]]


def test_a_polygon_turns_and_grows_about_its_first_corner() -> None:
    text = table("x, y, angle, scale", "0, 0, 0, 1", "10, 20, 90, 2")
    text += "turtle angle 90\nstart F f polygon { F(2) + F(1) + F(2) }\n"
    scene = ipmlang.parse(text).run()
    assert scene.instances.asset.tolist()[1] == OUTLINE
    (corners,) = scene.polygons
    wanted = [(12, 20), (12, 24), (10, 24), (10, 20)]
    np.testing.assert_allclose(corners[:, :2], wanted, atol=1e-12)


def test_moves_are_along_the_axes_of_the_file_in_the_books_axes_too() -> None:
    text = table("x, y", "1, 5") + "turtle frame abop\nstart +(90) f(2) [F]\n"
    regular = ipmlang.parse(text.replace("residual T\n", "")).run().instances
    moved = ipmlang.parse(text).run().instances
    np.testing.assert_allclose(moved.position - regular.position, [[1, 5, 0]], atol=1e-12)


def test_rows_are_read_from_a_parts_file(tmp_path: Path) -> None:
    rows = [(0.5, "red"), (0.25, ""), (0.0, "#00f")]
    metadata = f"<metadata>{table_xml('T', ['x', 'color'], rows)}</metadata>"
    svg = f'<svg xmlns="http://www.w3.org/2000/svg">{metadata}</svg>'
    (tmp_path / "row.parts.svg").write_text(svg)
    text = 'ipm 1\ntable T = "row.parts.svg#T"\nresidual T\n' + ROW
    found = derive(compiled(text, tmp_path)).instances
    assert found.position[:, 0].tolist() == [0.5, 2.25, 4]
    assert [f"{each:08x}" for each in found.color] == ["ff0000ff", "00000000", "0000ffff"]


def test_a_table_of_another_length_is_an_error_unless_a_user_changed_what_is_drawn() -> None:
    grammar = ipmlang.parse(table("x", "1", "2") + ROW)
    with pytest.raises(ipmlang.IpmError, match="`T` has 2 rows, and 3 terminals are drawn"):
        grammar.run()
    assert grammar.run(attrs={"n": 2}).instances.position[:, 0].tolist() == [1, 4]
    scene = grammar.run(attrs={"n": 4})
    assert scene.instances.position[:, 0].tolist() == [0, 2, 4, 6]
    assert scene.notes == (
        "the residual `T` has 2 rows, and 4 terminals are drawn: it is left out",
    )


@pytest.mark.parametrize(
    ("columns", "rows", "message"),
    [
        ("x, scale", ("0, 1", "0, 0", "0, -1"), "row 2 of the residual `T` has the scale 0"),
        ("x", ('"a"', '"b"', '"c"'), "the column `x` of a residual holds numbers alone"),
        ("css", ("1", "2", "3"), "the column `css` of a residual holds texts alone"),
        ("z", ("1", "2", "3"), "nothing leaves the plane"),
    ],
)
def test_cells_that_mean_nothing_are_errors(
    columns: str, rows: tuple[str, ...], message: str
) -> None:
    with pytest.raises(ipmlang.IpmError, match=message):
        ipmlang.parse(table(columns, *rows) + ROW).run()
