"""Word of the loops that have to be compiled, without loading the compiler to hear of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

_listeners: list[Callable[[], None]] = []


@contextmanager
def on_compile(tell: Callable[[], None]) -> Iterator[None]:
    """Call `tell` once, from whichever thread, if a loop is compiled meanwhile.

    Compiled loops are kept on disk, so that only the first run after an installation waits for
    them; later runs are silent.

    Examples
    --------
    >>> with on_compile(lambda: print("a moment, please")):
    ...     announce()
    ...     announce()
    a moment, please
    """
    told = False

    def once() -> None:
        nonlocal told
        if not told:
            told = True
            tell()

    _listeners.append(once)
    try:
        yield
    finally:
        _listeners.remove(once)


def announce() -> None:
    """Tell those who listen that a loop is being compiled."""
    for tell in tuple(_listeners):
        tell()


def compile_all() -> None:
    """Compile every loop by running every method on a small scene, so that no user waits for it.

    For images of machines and the like: what is compiled is kept in the folder that
    ``NUMBA_CACHE_DIR`` names, else beside the code, else in the user's cache.
    """
    import numpy as np

    from geohue.baselines import BASELINES
    from geohue.driver import segment
    from geohue.presets import PRESETS
    from geohue.scene import Scene

    part = np.arange(48) // 16
    rgb = np.random.default_rng(0).integers(0, 40, (36, 48, 3), np.uint8)
    rgb[..., 0] += (60 * part).astype(np.uint8)
    depth = np.tile(1.0 + part, (36, 1)).astype(np.float32)
    depth[10:20, 10:20] = np.nan
    depth[0, 0] = 90.0  # points far from all others take a loop of their own
    scene = Scene.from_rgbd(rgb, depth)
    for preset in PRESETS:
        segment(scene, preset=preset)
        segment(scene, k=3, preset=preset)
    for method, baseline in BASELINES.items():
        segment(scene, k=3, method=method, cues=baseline.cues[0])
    points = Scene.from_cloud(scene.points[scene.valid], scene.colors[scene.valid])
    segment(points, k=3)
