"""Strange scenes for fuzzing: values from the edges, gaps, one colour, points on one spot.

`GEOHUE_FUZZ_CASES` sets the number of cases (`make fuzz`).
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from geohue import GeohueError, GeohueWarning, Intrinsics, Scene, Segmentation

CASES = os.environ.get("GEOHUE_FUZZ_CASES")


def relaxed(cases: int) -> settings:
    """Return settings for so many cases, where `GEOHUE_FUZZ_CASES` says no other number."""
    return settings(
        max_examples=int(CASES or cases),
        deadline=20_000,  # ms: no hang; the first case compiles
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
    )


EDGES = (0.0, 1.0, -1.0, 1e-30, 1e30, -1e30, 1e-45, 3.4e38, 1e300, np.nan, np.inf, -np.inf, 2.5)


@st.composite
def numbers(draw: st.DrawFn, shape: tuple[int, ...]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Values of one kind: smooth, noise, few of them, from the edges, or a mix with gaps."""
    rng = np.random.default_rng(draw(st.integers(0, 9)))
    kind = draw(st.sampled_from(["ramp", "noise", "few", "edges", "one", "gaps"]))
    scale = draw(st.sampled_from([1.0, 1e-30, 1e-6, 1e6, 1e30]))
    size = int(np.prod(shape))
    if kind == "ramp":
        values = np.linspace(0.5, 2, size)
    elif kind == "few":
        values = rng.integers(1, 4, size).astype(float)
    elif kind == "edges":
        values = rng.choice(EDGES, size)
    elif kind == "one":
        values = np.full(size, draw(st.sampled_from(EDGES)))
    else:
        values = rng.normal(1, 0.3, size)
    if kind == "gaps":
        values[rng.random(size) < 0.95] = np.nan
    with np.errstate(over="ignore"):
        return (values * scale).reshape(shape)


@st.composite
def colors(draw: st.DrawFn, shape: tuple[int, ...]) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Noise, two colours or one."""
    rng = np.random.default_rng(draw(st.integers(0, 9)))
    most = draw(st.sampled_from([1, 2, 256]))
    return (rng.integers(0, most, (*shape, 3)) * (255 // max(most - 1, 1))).astype(np.uint8)


@st.composite
def frames(draw: st.DrawFn) -> Scene:
    """A frame of any small shape, 1 x N too."""
    shape = draw(st.tuples(st.integers(1, 20), st.integers(1, 20)))
    camera = Intrinsics(20, 20, shape[1] / 2, shape[0] / 2)
    return Scene.from_rgbd(draw(colors(shape)), draw(numbers(shape)), camera)


@st.composite
def clouds(draw: st.DrawFn) -> Scene:
    """A cloud of few points, some of them the same."""
    n = draw(st.integers(1, 120))
    points = draw(numbers((n, 3)))
    if draw(st.booleans()):
        points[n // 3 :] = points[0]
    return Scene.from_cloud(points, draw(colors((n,))))


def whole_or_error(make: Callable[[], Segmentation]) -> Segmentation | None:
    """Return a segmentation that is whole; None where it is refused in one line."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", GeohueWarning)
            seg = make()
    except GeohueError as error:
        if len(str(error)) <= 10 or "\n" in str(error):
            raise
        return None
    assert seg.scene is not None
    assert seg.labels.shape == seg.scene.shape
    assert seg.labels.dtype == np.int32
    return seg
