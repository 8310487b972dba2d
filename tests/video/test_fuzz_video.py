"""Whatever frames follow each other, each is labelled or refused, and the next can be labelled.

`GEOHUE_FUZZ_CASES` sets the number of cases (`make fuzz`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue.video.segmenter import VideoSegmenter
from strange import frames, relaxed, whole_or_error


@st.composite
def poses(draw: st.DrawFn) -> NDArray[np.float64] | None:
    """No pose, one that moves, far away, or none that can be."""
    kind = draw(st.sampled_from(["none", "none", "near", "far", "nan", "flat", "huge"]))
    if kind == "none":
        return None
    pose = np.eye(4)
    pose[:3, 3] = {"near": 0.1, "far": 1e30, "nan": np.nan, "flat": 0.0, "huge": 0.0}[kind]
    pose[:3, :3] *= {"flat": 0.0, "huge": 1e150}.get(kind, 1.0)
    return pose


@relaxed(15)
@given(
    st.lists(st.tuples(frames(), poses()), min_size=1, max_size=4),
    st.sampled_from([("best", "auto"), ("fast", "coarse"), ("fast", "fine"), ("paper", "auto")]),
    st.integers(0, 2),
)
def test_any_frames(shown: list[Any], kind: tuple[str, Any], delay: int) -> None:
    preset, detail = kind
    with VideoSegmenter(preset, detail=detail, delay=delay, memory=1, threads=1) as video:
        for scene, pose in shown:
            seg = whole_or_error(lambda s=scene, p=pose: video.update(s, p))  # type: ignore[misc]
            if seg is not None:
                seen = {one.track for one in video.seen}
                assert seg.k == len(seen)
                assert set(np.unique(seg.labels)) - {-1} <= seen
