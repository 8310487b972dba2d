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
    from geohue.baselines import register_method
    from geohue.camera import Intrinsics
    from geohue.consensus import register_voter
    from geohue.datasets import register_layout
    from geohue.errors import GeohueError, GeohueWarning
    from geohue.estimator import NystromNormalizedCut as NystromNormalizedCut
    from geohue.features import register_cue
    from geohue.large import segment_file
    from geohue.read.clouds.cloud import register_cloud_format
    from geohue.read.images.depth_units import register_sensor
    from geohue.scene import Scene
    from geohue.segmentation.driver import segment
    from geohue.segmentation.result import Segmentation
    from geohue.settings import PRESETS, Preset, register_preset

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
    "register_cloud_format": "geohue.read.clouds.cloud",
    "register_cue": "geohue.features",
    "register_layout": "geohue.datasets",
    "register_method": "geohue.baselines",
    "register_preset": "geohue.settings",
    "register_sensor": "geohue.read.images.depth_units",
    "register_voter": "geohue.consensus",
    "segment": "geohue.segmentation.driver",
    "segment_file": "geohue.large",
}

__all__ = [
    "PRESETS",
    "GeohueError",
    "GeohueWarning",
    "Intrinsics",
    "Preset",
    "Scene",
    "Segmentation",
    "__version__",
    "register_cloud_format",
    "register_cue",
    "register_layout",
    "register_method",
    "register_preset",
    "register_sensor",
    "register_voter",
    "segment",
    "segment_file",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'geohue' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
