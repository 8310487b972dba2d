"""geohue: segmentation of scenes from colour and geometry together.

>>> import numpy as np, geohue
>>> scene = geohue.Scene.from_cloud(np.random.default_rng(0).random((50, 3)), np.zeros((50, 3)))
>>> geohue.segment(scene, k=2, cues="geometry").k
2
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from geohue._version import __version__

if TYPE_CHECKING:
    from geohue import (
        baselines,
        datasets,
        features,
        large,
        measures,
        merge,
        read,
        results,
        sensors,
        simulate,
        spectral,
        stereo,
    )
    from geohue.baselines import register_method
    from geohue.camera import Intrinsics
    from geohue.consensus import register_voter
    from geohue.datasets import load_sample, open_dataset, register_layout
    from geohue.errors import GeohueError, GeohueWarning
    from geohue.estimator import NystromNormalizedCut as NystromNormalizedCut
    from geohue.features import register_cue
    from geohue.interop import as_scene, labelled
    from geohue.large import segment_file, superpoints_file
    from geohue.measures import evaluate
    from geohue.read.clouds.cloud import register_cloud_format
    from geohue.read.images.depth_units import register_sensor
    from geohue.scene import Scene
    from geohue.segmentation.driver import segment
    from geohue.segmentation.result import Segmentation
    from geohue.settings import PRESETS, Preset, register_preset
    from geohue.superpoint import superpoints
    from geohue.video.segmenter import VideoSegmenter

# Loaded on first use: `import geohue` stays as quick as `import numpy`.
_HOMES = {
    "GeohueError": "geohue.errors",
    "GeohueWarning": "geohue.errors",
    "Intrinsics": "geohue.camera",
    "NystromNormalizedCut": "geohue.estimator",  # not in __all__: it needs the extra sklearn
    "PRESETS": "geohue.settings",
    "Preset": "geohue.settings",
    "Scene": "geohue.scene",
    "Segmentation": "geohue.segmentation.result",
    "as_scene": "geohue.interop",
    "labelled": "geohue.interop",
    "VideoSegmenter": "geohue.video.segmenter",
    "register_cloud_format": "geohue.read.clouds.cloud",
    "register_cue": "geohue.features",
    "register_layout": "geohue.datasets",
    "register_method": "geohue.baselines",
    "register_preset": "geohue.settings",
    "register_sensor": "geohue.read.images.depth_units",
    "register_voter": "geohue.consensus",
    "segment": "geohue.segmentation.driver",
    "segment_file": "geohue.large",
    "evaluate": "geohue.measures",
    "load_sample": "geohue.datasets",
    "open_dataset": "geohue.datasets",
    "superpoints": "geohue.superpoint",
    "superpoints_file": "geohue.large",
}
_ROOMS = (
    *("baselines", "camera", "datasets", "errors", "features", "large", "measures", "merge"),
    *("read", "results", "scene", "sensors", "settings", "simulate", "spectral", "stereo"),
)
"""Modules that `import geohue` makes reachable, each loaded on first use."""

__all__ = [
    "PRESETS",
    "GeohueError",
    "GeohueWarning",
    "Intrinsics",
    "Preset",
    "Scene",
    "Segmentation",
    "VideoSegmenter",
    "__version__",
    "as_scene",
    "baselines",
    "datasets",
    "evaluate",
    "features",
    "labelled",
    "large",
    "load_sample",
    "measures",
    "merge",
    "open_dataset",
    "read",
    "register_cloud_format",
    "register_cue",
    "register_layout",
    "register_method",
    "register_preset",
    "register_sensor",
    "register_voter",
    "results",
    "segment",
    "segment_file",
    "sensors",
    "simulate",
    "spectral",
    "stereo",
    "superpoints",
    "superpoints_file",
]


def __getattr__(name: str) -> Any:
    if name in _ROOMS:
        return import_module(f"geohue.{name}")
    if name not in _HOMES:
        raise AttributeError(f"module 'geohue' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*__all__, *_HOMES, *_ROOMS})
