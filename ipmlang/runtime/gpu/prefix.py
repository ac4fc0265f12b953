"""Prefix sums on the card, of any number of words.

In goes a column of a buffer, out comes a buffer with the sum of all words before each. Blocks are
summed side by side, and their totals in the same way, level above level. Nothing is downloaded.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.resources import files

from ipmlang.runtime.gpu.device import Device
from ipmlang.runtime.gpu.storage import Storage

THREADS = 256  # of a work group
EACH = 16  # words that a thread adds up
BLOCK = THREADS * EACH

Allocate = Callable[[int], Storage]


def prefix_sums(
    device: Device, source: Storage, first: int, count: int,
    allocate: Allocate, free: Callable[[Storage], None],
) -> Storage:  # fmt: skip
    """The sums, modulo 2^32, of all words before each of `count` words from word `first` on:
    (count,), in a buffer that `allocate` made from its size in bytes and the caller frees.
    """
    blocks = max(-(-count // BLOCK), 1)
    sums = allocate(4 * count)
    if not count:
        return sums
    totals = allocate(4 * blocks)
    _run(device, (source, sums, totals), first, count)
    if blocks > 1:
        above = prefix_sums(device, totals, 0, blocks, allocate, free)
        _run(device, (source, sums, above), first, count, adding=True)
        free(above)
    free(totals)
    return sums


def _run(
    device: Device, buffers: tuple[Storage, ...], first: int, count: int, *, adding: bool = False
) -> None:
    shader = device.compile(_source(), "scan")
    for name, value in (("first", first), ("count", count), ("adding", int(adding))):
        shader[name] = value
    for binding, storage in enumerate(buffers):
        storage.bind(binding)
    blocks = -(-count // BLOCK)
    across = min(blocks, device.limits.groups[0])
    device.dispatch(shader, (across, -(-blocks // across)), "scan")


def _source() -> str:
    sizes = {"SCAN_THREADS": THREADS, "SCAN_EACH": EACH, "SCAN_BLOCK": BLOCK}
    head = "".join(f"#define {name} {value}u\n" for name, value in sizes.items())
    return "#version 430\n" + head + (files(__package__) / "scan.glsl").read_text(encoding="utf-8")
