"""When a carried model no longer fits what is seen, by stated tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from geohue.features import lab_of
from geohue.scene import Scene

NEW = 0.01
"""Share of the draft that may become far from all landmarks: a new thing larger than that asks for
a new model."""

FALL = 0.25
"""Share of the explained votes that may be lost."""

CUT = 0.55
"""Change of the histograms of colour and of depth beyond which a frame begins another shot."""

Reason = Literal["new", "votes", "depth"]


@dataclass(frozen=True, slots=True)
class Fit:
    """How well a model fits a frame.

    Attributes
    ----------
    strangers : float
        Share of points far from all its landmarks.
    explained : float
        Share of the cuts' votes that lie on borders of the segments.
    unused_depth : bool
        Whether the frame has depth that the model does not use.
    """

    strangers: float
    explained: float
    unused_depth: bool = False


def explained_votes(share: NDArray[np.float64], apart: NDArray[np.bool_]) -> float:
    """Return which part of all votes for borders lies where segments meet.

    Parameters
    ----------
    share : (E,) float64
        Share of the cuts that part each pair of neighbours (`count_votes`).
    apart : (E,) bool
        Whether they are in two segments.

    Returns
    -------
    float
        0 to 1; 1 if no cut parts anything.

    Examples
    --------
    >>> explained_votes(np.array([0.5, 0.0, 0.25]), np.array([True, False, False])).__round__(3)
    0.667
    """
    total = float(share.sum())
    return float(share[apart].sum()) / total if total > 0 else 1.0


def why_anew(first: Fit, now: Fit) -> Reason | None:
    """Return why a model should be made anew, None if it still fits.

    Parameters
    ----------
    first : Fit
        In the first frame that the model labelled.
    now : Fit
        In this frame.

    Examples
    --------
    >>> why_anew(Fit(0.0, 0.6), Fit(0.02, 0.6)), why_anew(Fit(0.0, 0.6), Fit(0.005, 0.5))
    ('new', None)
    """
    if now.unused_depth:
        return "depth"
    if now.strangers - first.strangers > NEW:
        return "new"
    if now.explained < (1 - FALL) * first.explained:
        return "votes"
    return None


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """Histograms of a frame, by which a cut is told from a moving camera.

    Attributes
    ----------
    color : (512,) float64
        Shares of 8 x 8 x 8 classes of Lab, the lightness relative to the frame's median.
    depth : (16,) float64 or None
        Shares of octaves' quarters of depth, None without depth.
    """

    color: NDArray[np.float64]
    depth: NDArray[np.float64] | None

    @classmethod
    def of(cls, draft: Scene) -> Look:
        """Return that of a draft."""
        lab = lab_of(draft.colors).reshape(-1, 3)
        light = lab[:, 0] - np.median(lab[:, 0]) + 50
        color = _histogram(light / 12.5) * 64 + _histogram((lab[:, 1] + 64) / 16) * 8
        color += _histogram((lab[:, 2] + 64) / 16)
        depth = None
        z = draft.points[..., 2][draft.valid]
        if len(z) > draft.size // 20:
            quarters = np.clip(np.log2(np.abs(z) + 1e-12) * 4 + 8, 0, 15).astype(np.int64)
            depth = np.bincount(quarters, minlength=16) / len(z)
        return cls(np.bincount(color, minlength=512) / len(color), depth)

    def change(self, other: Look) -> float:
        """Return how much two frames differ, 0..1: the lesser of colour and depth.

        Half the sum of the absolute differences. A change of exposure moves colours alone, and
        depth that is lost says nothing.
        """
        color = float(np.abs(self.color - other.color).sum() / 2)
        if self.depth is None or other.depth is None:
            return color
        return min(color, float(np.abs(self.depth - other.depth).sum() / 2))


def _histogram(classes: NDArray[np.floating]) -> NDArray[np.int64]:
    return np.asarray(np.clip(classes, 0, 7), np.int64)
