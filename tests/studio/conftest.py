"""Whether pictures can be drawn here."""

from __future__ import annotations

import pytest

from ipmlang.compiler.diagnostics import IpmError
from ipmlang.runtime.gpu.device import release
from ipmlang.studio.context import gl_context


@pytest.fixture(scope="session")
def opengl() -> None:
    """OpenGL, or a skip that says why there is none."""
    try:
        with gl_context():
            pass
    except IpmError as error:
        pytest.skip(f"no pictures can be drawn here: {error.diagnostics[0].message}")


@pytest.fixture
def no_device() -> None:
    """No GPU held open by an earlier test, which would keep the context of pictures alive."""
    release()
