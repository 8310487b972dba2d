"""A short film of the moving room, small enough for tests."""

from __future__ import annotations

import pytest

from geohue import Intrinsics
from geohue.simulate.moving import MovingFrame, moving_scene

CAMERA = Intrinsics(105.0, 105.0, 63.5, 47.5, 128, 96)


@pytest.fixture(scope="session")
def film() -> list[MovingFrame]:
    """The frames 26 to 55, in which the blue ball hides and the green cylinder enters."""
    return list(moving_scene(30, CAMERA, start=26))
