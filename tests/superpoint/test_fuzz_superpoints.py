"""Whatever a scene holds, `superpoints` gives labels or one GeohueError.

`GEOHUE_FUZZ_CASES` sets the number of cases (`make fuzz`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from geohue import Scene, superpoints
from strange import clouds, frames, relaxed, whole_or_error

SIZES: st.SearchStrategy[dict[str, Any]] = st.one_of(
    st.fixed_dictionaries({"count": st.sampled_from([1, 2, 5, 60, 10**12, 0])}),
    st.fixed_dictionaries({"size": st.sampled_from([1, 3.5, 1e30, 0.5, np.nan])}),
    st.fixed_dictionaries({"width": st.sampled_from([1e-300, 1e-30, 0.1, 1e30, 1e300, np.inf])}),
)
OTHERS: st.SearchStrategy[dict[str, Any]] = st.fixed_dictionaries(
    {},
    optional={
        "cues": st.sampled_from(["auto", "fusion", "color", "geometry"]),
        "compactness": st.sampled_from([0.0, 1.0, 1e-30, 1e30, 1e300, -1.0, np.nan]),
    },
)


@relaxed(40)
@given(st.data(), st.sampled_from([frames, clouds]), SIZES, OTHERS)
def test_any_scene(
    data: st.DataObject, scenes: Any, size: dict[str, Any], others: dict[str, Any]
) -> None:
    scene: Scene = data.draw(scenes())
    seg = whole_or_error(lambda: superpoints(scene, **size, **others))
    if seg is None:
        return
    assert set(np.unique(seg.labels)) - {-1} == set(range(seg.k))
    assert seg.levels is not None
    assert seg.neighbours.n_segments == seg.k
    for k in {1, seg.k}:
        coarser = seg.levels.with_segments(k)
        assert ((coarser >= 0) == (seg.labels >= 0)).all()
