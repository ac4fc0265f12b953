"""The graphics card of this machine, a program that plays one, or a skip that says why neither."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from ipmlang.compiler.diagnostics import IpmError
from ipmlang.runtime.gpu.device import Device, device, release


@pytest.fixture
def card() -> Iterator[Device]:
    """The open device, with the limits it really has; shared by all tests of the process."""
    try:
        opened = device()
    except IpmError as error:
        pytest.skip(f"nothing can be computed on a card here: {error.diagnostics[0].message}")
    limits = opened.limits
    yield opened
    opened.limits = limits


@pytest.fixture
def no_device() -> Iterator[None]:
    """A process that has not opened its device yet."""
    release()
    yield
    release()
