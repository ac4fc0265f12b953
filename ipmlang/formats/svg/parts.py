"""A parts file: an SVG whose groups are terminals, effects and tables, each known by its id.

`write_parts` prints one, `read_effect` takes one effect out of it; terminals are read back by
`read_node`, tables by `read_table`. Nothing here decides what becomes a part.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from ipmlang.formats import FormatError
from ipmlang.formats.drawing import Drawing, DrawnElement, Effect
from ipmlang.formats.svg.attributes import Linear
from ipmlang.formats.svg.definitions import Definitions, transform_text, without_namespace
from ipmlang.formats.svg.tags import tags_text
from ipmlang.formats.svg.transforms import IDENTITY, parse_transform
from ipmlang.formats.svg.write import Box, fitted_box, write_groups
from ipmlang.formats.svg.xml import SVG

if TYPE_CHECKING:
    from lxml import etree

_SHARE = 1e-10  # of the box: how far points are moved where nobody says
_NOT_EFFECTS = frozenset({"id", "transform"})


def write_parts(
    terminals: Mapping[str, Sequence[DrawnElement]],
    *,
    element_effects: Mapping[str, Effect] | None = None,
    effects: Mapping[str, tuple[str | None, Effect]] | None = None,
    tables: Sequence[str] = (),
    allowed: Mapping[str, float] | None = None,
    spaces: Mapping[str, Linear] | None = None,
) -> str:
    """The file that holds `terminals` by id, `effects` by id and tables (from `table_xml`).

    An effect comes with the id of the one it stands in, which is given before it.
    `element_effects` are those that elements of terminals name in their styles. allowed: units, how
    far a point of a terminal may be moved so that it is short, 1e-10 of the box if nothing is said;
    spaces: the linear part of the map by which a file drew a terminal, see `tags_text`.
    """
    elements = tuple(element for group in terminals.values() for element in group)
    box = _outward(fitted_box(elements))
    definitions = Definitions(short=True)
    alone = {
        name: group[0]
        for name, group in terminals.items()
        if len(group) == 1 and not group[0].style.effects
    }
    usual = _SHARE * math.hypot(box[2], box[3])
    bounds = {name: (allowed or {}).get(name, usual) for name in alone}
    tags = tags_text(alone, bounds, spaces or {}, definitions)
    groups = {name: group for name, group in terminals.items() if name not in alone}
    several = tuple(element for group in groups.values() for element in group)
    drawing = Drawing(several, box, effects=element_effects or {})
    metadata = "<metadata>\n" + "\n".join(tables) + "\n</metadata>\n" if tables else ""
    wraps = "".join(_effect_texts(effects or {}, None))
    runs = {name: len(group) for name, group in groups.items()}
    return write_groups(drawing, runs, metadata + wraps + tags, definitions)


def _outward(box: Box) -> Box:
    """A box of few digits that holds the given one."""
    size = max(box[2], box[3])
    if not (math.isfinite(size) and size > 0):
        return box
    unit = 10.0 ** (math.floor(math.log10(size)) - 1)
    low = [math.floor(value / unit) for value in box[:2]]
    high = [math.ceil((box[k] + box[k + 2]) / unit) for k in (0, 1)]
    width, height = ((high[k] - low[k]) * unit for k in (0, 1))
    return (low[0] * unit, low[1] * unit, width, height)


def read_effect(path: Path | str, node_id: str) -> tuple[tuple[str, Effect], ...]:
    """The effects that a group of a parts file makes with their ids, its parents' first.

    Raises `FormatError` if the file cannot be read or has no such group.
    """
    from lxml import etree

    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        root = etree.fromstring(Path(path).read_bytes(), parser)
    except (OSError, etree.XMLSyntaxError) as error:
        raise FormatError(f"cannot read {path}: {error}") from error
    node = next((each for each in root.iter("*") if each.get("id") == node_id), None)
    if node is None:
        raise FormatError(f"no element in {path} has the id `{node_id}`")
    chain = [each for each in (node, *node.iterancestors()) if each is not root]
    found = [(str(each.get("id") or ""), _effect(each)) for each in reversed(chain)]
    return tuple(pair for pair in found if pair[1].attributes)


def _effect(node: etree._Element) -> Effect:
    from lxml import etree

    pairs = ((str(name), str(value)) for name, value in node.attrib.items())
    attributes = tuple(pair for pair in pairs if pair[0] not in _NOT_EFFECTS)
    inner = (part for defs in node.findall(f"{{{SVG}}}defs") for part in defs)
    definitions = "".join(
        without_namespace(etree.tostring(part, encoding="unicode", with_tail=False))
        for part in inner
    )
    matrix = parse_transform(node.get("transform") or "")
    return Effect(attributes, definitions, IDENTITY if matrix is None else matrix)


def _effect_texts(
    effects: Mapping[str, tuple[str | None, Effect]], parent: str | None
) -> Iterator[str]:
    """The groups that stand in `parent`, with all inside them."""
    for name, (outer, effect) in effects.items():
        if outer != parent:
            continue
        attributes = "".join(f' {key}="{escape(value)}"' for key, value in effect.attributes)
        plain = effect.matrix == IDENTITY
        transform = "" if plain else f' transform="{transform_text(effect.matrix)}"'
        inner = f"<defs>{effect.definitions}</defs>" if effect.definitions else ""
        yield f'<g id="{escape(name)}"{transform}{attributes}>{inner}'
        yield from _effect_texts(effects, name)
        yield "</g>\n"
