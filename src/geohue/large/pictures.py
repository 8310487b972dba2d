"""Pictures of a cloud that is too large for one: of its sample."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.large.fit import Fitted
from geohue.large.result import FileSegmentation
from geohue.results.curve import draw_weight_curve
from geohue.results.picture import picture
from geohue.results.png import write_png
from geohue.scene import Scene
from geohue.segmentation.result import Segmentation
from geohue.settings import PAPER_METHOD


def draw(folder: Path, sample: NDArray[np.void], fitted: Fitted, result: FileSegmentation) -> None:
    """Write ``overlay.png`` and ``weight_curve.png`` as `geohue.results.outputs` does."""
    labels = fitted.labels(sample["xyz"], sample["rgb"])
    scene = Scene.from_cloud(sample["xyz"], sample["rgb"])
    write_png(folder / "overlay.png", picture(scene, labels))
    if len(result.weight_curve) < 2:
        return
    seen = Segmentation(
        labels,
        result.k,
        result.weight,
        result.quality,
        result.weight_curve,
        PAPER_METHOD,
        result.preset,
        result.cues,
        result.seed,
        result.timings,
    )
    draw_weight_curve(folder / "weight_curve.png", seen)
