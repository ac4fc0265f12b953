"""What all tests share: where the real inputs lie, the flag that rewrites goldens, and generated
examples that are the same in every run, however slow the machine.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parent.parent
DATA = ROOT.parent / "shared" / "data"

settings.register_profile("steady", derandomize=True, deadline=None)
settings.load_profile("steady")


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--update` rewrites golden files; read the difference before committing it."""
    parser.addoption("--update", action="store_true", help="rewrite golden files")


@pytest.fixture
def update(request: pytest.FixtureRequest) -> bool:
    """Whether goldens are to be rewritten in this run."""
    return bool(request.config.getoption("--update"))


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of real inputs, or a skip that says it is not here."""
    if not DATA.is_dir():
        pytest.skip(f"real inputs are not here: {DATA} is absent")
    return DATA
