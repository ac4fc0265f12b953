"""Holds Python's collector of cycles while very many small objects are made that all stay.

Without this it looks at all of them again and again: half of the time of checking a large grammar.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def held() -> Iterator[None]:
    """Hold the collector, and let it go on as it was before."""
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()
