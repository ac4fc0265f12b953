"""Drawings as SVG: reading takes a file apart, writing prints one.

`read_svg` gives all that a file draws, `read_node` what one element of it draws, `svg_ids` the ids
there are, `read_table` the bulk numbers that a parts file keeps in its metadata. `split_compound`
takes compound paths apart.
"""

from __future__ import annotations

from ipmlang.formats.svg.compound import split_compound
from ipmlang.formats.svg.limits import Limits
from ipmlang.formats.svg.reading import read_node, read_nodes, read_svg, svg_ids
from ipmlang.formats.svg.tables import Table, read_table, table_xml

__all__ = [
    "Limits",
    "Table",
    "read_node",
    "read_nodes",
    "read_svg",
    "read_table",
    "split_compound",
    "svg_ids",
    "table_xml",
]
