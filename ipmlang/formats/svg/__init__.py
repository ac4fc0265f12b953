"""Drawings as SVG: `read` takes a file apart, `write` prints one."""
