from __future__ import annotations

import pytest

from geohue import GeohueError
from geohue.datasets import SAMPLES, load_sample


@pytest.mark.parametrize("name", list(SAMPLES))
def test_every_sample_is_a_scene_with_colour_and_depth(name: str) -> None:
    scene = load_sample(name)
    assert scene.is_grid
    assert scene.valid.mean() > 0.6
    assert (scene.second_colors is not None) == (
        name in ("motorcycle-stereo", "motorcycle-matched")
    )


def test_unknown_names_list_the_known_ones() -> None:
    with pytest.raises(GeohueError, match="motorcycle, motorcycle-stereo"):
        load_sample("car")
