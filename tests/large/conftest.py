"""A cloud on disk, and short stretches of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from geohue.large import stages
from large.clouds import N, table, three_blobs
from large.run_slowly import STRETCH


@pytest.fixture
def cloud(tmp_path: Path) -> Path:
    """Three balls, two of whose points have no place."""
    xyz, rgb, _ = three_blobs(N)
    xyz[[5, 7000]] = np.nan
    np.save(tmp_path / "cloud.npy", table(xyz, rgb))
    return tmp_path / "cloud.npy"


@pytest.fixture
def small_stretches(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stages, "JOB", STRETCH)
