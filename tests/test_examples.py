"""Every example and every file of the standard library checks without a warning, is in the
formatter's layout, and draws something; buildings are closed solids, and all their parts have room.
"""

from __future__ import annotations

from collections import Counter
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import ipmlang
from ipmlang.geometry.solid import is_closed
from ipmlang.runtime.scene import SCOPE, SOLID, Scene

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.ipm"))
LIBRARY = sorted((ROOT / "stdlib").glob("*.ipm"))
BUILDINGS = ("flats", "house", "terrace", "tower", "castle", "town", "palace", "city")


def load(name: str) -> ipmlang.Grammar:
    return ipmlang.load(ROOT / "examples" / f"{name}.ipm")


@cache
def derived(name: str, seed: int) -> Scene:
    return load(name).run(seed=seed)


def names(scene: Scene) -> Counter[str]:
    return Counter(scene.labels[label] for label in scene.instances.label.tolist())


@pytest.mark.parametrize(
    "path", EXAMPLES + LIBRARY, ids=lambda path: f"{path.parts[-2]}-{path.stem}"
)
def test_example(path: Path, tmp_path: Path) -> None:
    grammar = ipmlang.load(path)
    assert not grammar.warnings
    assert grammar.format() == path.read_text(encoding="utf-8")
    scene = grammar.run(seed=1)
    assert len(scene.instances) > 10
    assert not scene.notes
    output = tmp_path / ("out.svg" if scene.flat else "out.glb")
    ipmlang.save(scene, output)
    assert output.stat().st_size > 500


@pytest.mark.parametrize("name", BUILDINGS)
def test_buildings_are_closed_solids(name: str) -> None:
    scene = derived(name, 2)
    table = scene.instances
    assert not scene.notes
    assert set(table.asset.tolist()) <= {SCOPE, SOLID}
    assert (table.size > 0).all()
    assert all(is_closed(scene.solids[shape])
               for shape in set(table.shape[table.asset == SOLID].tolist()))  # fmt: skip


@pytest.mark.parametrize("name", BUILDINGS)
def test_buildings_have_their_pictures(name: str) -> None:
    picture = ROOT / "examples" / f"{name}.png"
    assert 10_000 < picture.stat().st_size < 256_000


def test_a_house_has_what_its_attributes_say() -> None:
    one, three = (names(load("house").run(attrs={"floors": floors})) for floors in (1, 3))
    assert one["Board"] == three["Board"] > 1  # one door, as many gutters
    assert three["Glass"] > one["Glass"]
    assert three["Stack"] == one["Stack"]


def test_trees_of_a_house_in_winter_are_bare() -> None:
    grammar = ipmlang.load(ROOT / "examples" / "house.ipm", style="Winter")
    assert not grammar.warnings
    winter, summer = names(grammar.run(seed=2)), names(derived("house", 2))
    assert summer["F"] == 0 < winter["F"]
    assert winter["Leaves"] < summer["Leaves"]
    assert winter["Tiles"] == summer["Tiles"]


def test_a_tower_has_the_storeys_asked_for() -> None:
    heights = [float(load("tower").run(attrs={"floors": n}).instances.position[:, 2].max())
               for n in (20, 60)]  # fmt: skip
    assert heights[1] - heights[0] == pytest.approx(40 * 3.5, abs=2 * 3.5)


@pytest.mark.parametrize("agree", [True, False])
def test_the_wings_of_a_palace_keep_to_its_middle(agree: bool) -> None:
    """The lower mouldings of courses stand as high in a wing as in the middle, if parts agree."""
    scene = load("palace").run(attrs={"agree": agree})
    table = scene.instances
    rows = (table.label == scene.labels.index("Moulding")) & (table.position[:, 2] < 11)
    x, z = table.position[rows, 0], table.position[rows, 2].round(6)
    wing, middle = set(z[x < 5].tolist()), set(z[(x > 14) & (x < 18)].tolist())
    assert len(wing) == len(middle) == 4  # two mouldings a course
    assert (wing == middle) is agree


def test_a_terrace_varies_by_its_seed_and_not_without() -> None:
    grammar = load("terrace")
    first, again, other = (grammar.run(seed=seed) for seed in (4, 4, 5))
    assert first.instances.position.tobytes() == again.instances.position.tobytes()
    assert names(first) != names(other)
    assert names(first)["Lantern"] == names(other)["Lantern"] == 7


def test_a_town_has_its_houses_and_one_church() -> None:
    scene = derived("town", 2)
    count = names(scene)
    assert 100 < count["Base"] < 300  # a plinth for each house
    assert count["Cornice"] == 1
    assert (scene.instances.position[:, 2] > -1).all()


def test_a_city_follows_its_map() -> None:
    """It is high where the map is red, and its houses stand neither in the river nor in parks."""
    scene = derived("city", 2)
    table = scene.instances
    painted = np.asarray(Image.open(ROOT / "examples" / "city.map.png"))[::-1]
    built = np.isin(table.label, [scene.labels.index(name) for name in ("Slab", "Wall")])
    x, y, bottom = table.position[built].T
    red, green, blue = painted[(y // 10).astype(int), (x // 10).astype(int)].T
    assert built.sum() > 2000 and not blue.any()
    assert bottom[red > 200].max() > 100 > 30 > np.median(bottom[red < 100])
    x, y, _ = table.position[table.label == scene.labels.index("Turf")].T
    assert painted[(y // 10).astype(int), (x // 10).astype(int), 1].all() and not green.all()
