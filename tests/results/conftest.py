"""What the tests of archives share."""

from __future__ import annotations

from pathlib import Path

import pytest

from rotor_ida import save
from tests.example_datasets import a_dataset


@pytest.fixture
def archive(tmp_path: Path) -> Path:
    return save(a_dataset(), tmp_path / "run.nc")
