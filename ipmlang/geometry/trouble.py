"""What libraries raise where numbers are too far apart, as an error of geometry.

In go blocks that work on geometry, out comes GeometryError where a library gives up: coordinates of
1e300 beside others of 1, slivers that no float can tell from a line. Other errors pass through.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from ipmlang.geometry.solid import GeometryError


@contextmanager
def computing() -> Iterator[None]:
    """A block in which overflow, a division by zero, a topology that a library cannot work out, or
    memory that runs out is a GeometryError.

    >>> with computing():
    ...     1 / 0
    Traceback (most recent call last):
    ...
    ipmlang.geometry.solid.GeometryError: this geometry is beyond what floating point can compute
    """
    try:
        yield
    except MemoryError as error:
        raise GeometryError(
            "this geometry needs more memory than there is",
            "a polygon of many thousands of corners may need fewer",
        ) from error
    except Exception as error:
        if not isinstance(error, _beyond()):
            raise
        raise GeometryError(
            "this geometry is beyond what floating point can compute",
            "is a size or a corner far too large, or far too small, beside the others?",
        ) from error


def _beyond() -> tuple[type[Exception], ...]:
    """What says so; a library that is not loaded has not raised it."""
    known: tuple[type[Exception], ...] = (ArithmeticError, np.linalg.LinAlgError)
    shapely = sys.modules.get("shapely.errors")
    return known if shapely is None else (*known, shapely.GEOSException)
