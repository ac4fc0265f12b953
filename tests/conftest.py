"""What all tests share: where the real inputs lie, and the flag that rewrites goldens."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
DATA = ROOT.parent / "shared" / "data"


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
