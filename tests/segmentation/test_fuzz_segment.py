"""Whatever a scene holds, `segment` gives labels or one GeohueError: no warning, no other error.

`GEOHUE_FUZZ_CASES` sets the number of cases (`make fuzz`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from geohue import Scene, segment
from geohue.segmentation.clusterers import known_methods
from strange import clouds, frames, relaxed, whole_or_error

SETTINGS: st.SearchStrategy[dict[str, Any]] = st.fixed_dictionaries(
    {},
    optional={
        "k": st.sampled_from(["auto", 1, 2, 3, 7, 255]),
        "weight": st.sampled_from(["auto", 0.0, 1.0, np.inf, 1e-30, 1e30]),
        "cues": st.sampled_from(["fusion", "color", "geometry"]),
        "preset": st.sampled_from(["best", "fast", "paper"]),
        "detail": st.sampled_from(["auto", "coarse", "fine", 0.3, -1e30, 1e30]),
        "components": st.booleans(),
        "reunite": st.booleans(),
        "method": st.sampled_from(known_methods()),
        "fill": st.booleans(),
    },
)


def survives(draw: st.DataObject, scenes: st.SearchStrategy[Scene]) -> None:
    seg = whole_or_error(lambda: segment(draw.draw(scenes), **draw.draw(SETTINGS)))
    if seg is not None:
        assert set(np.unique(seg.labels)) - {-1} == set(range(seg.k))


@relaxed(60)
@given(st.data())
def test_any_frame(data: st.DataObject) -> None:
    survives(data, frames())


@relaxed(60)
@given(st.data())
def test_any_cloud(data: st.DataObject) -> None:
    survives(data, clouds())
