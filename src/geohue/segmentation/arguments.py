"""What `geohue.segment` is asked for, checked once and the same wherever it is asked."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Literal

import numpy as np

from geohue.errors import GeohueError
from geohue.merge.levels import Detail, threshold_of
from geohue.scene import Scene
from geohue.segmentation.clusterers import check_method
from geohue.settings import PAPER_METHOD, Preset, preset_named
from geohue.settings.checks import is_whole
from geohue.settings.weight import WEIGHT_RULES, WeightRule

K_LIMIT = 255
"""Most segments that may be asked for."""

Count = int | Literal["auto"]
Weight = float | Literal["auto"] | WeightRule


@dataclass(frozen=True, slots=True, kw_only=True)
class SegmentArguments:
    """The arguments of `geohue.segment` but for the scene, which say what its labels are.

    Commands and studies make one before they read anything, so that a mistake is one error and
    not one a frame.

    Attributes
    ----------
    k, weight, preset, cues, method, seed, detail, components, fill
        As of `geohue.segment`.

    Raises
    ------
    GeohueError
        For a value that no scene could be segmented with.

    Examples
    --------
    >>> SegmentArguments(k=0)
    Traceback (most recent call last):
    geohue.errors.GeohueError: k is 0: expected "auto" or a whole number from 1 to 255
    >>> SegmentArguments(preset="paper", detail="fine")
    Traceback (most recent call last):
    geohue.errors.GeohueError: detail is 'fine', and preset 'paper' has no levels to choose from:
    leave out the detail, or choose preset 'best' or 'fast'
    """

    k: Count = "auto"
    weight: Weight = "auto"
    preset: str | Preset = "best"
    cues: str = "fusion"
    method: str = PAPER_METHOD
    seed: int = 0
    detail: Detail = "auto"
    components: bool = False
    fill: bool = True

    def __post_init__(self) -> None:
        preset_named(self.preset)
        _check_count(self.k)
        _check_weight(self.weight, self.k, self.method)
        if not (is_whole(self.seed) and self.seed >= 0):
            raise GeohueError(f"seed is {self.seed!r}: expected a whole number of at least 0")
        check_method(self.method, self.cues, is_grid=True)
        threshold_of(self.detail)
        if self.detail != "auto":
            self._check_levels()

    @property
    def settings(self) -> Preset:
        """The preset itself."""
        return preset_named(self.preset)

    @property
    def merges(self) -> bool:
        """Whether regions are merged: by the preset unless a weight is given, or on request."""
        rule = self.settings.weight.rule if self.weight == "auto" else self.weight
        return rule == "merge" and self.method == PAPER_METHOD

    def check_scene(self, scene: Scene) -> None:
        """Raise `GeohueError` if the scene is not of the kind that these need."""
        if self.components and not scene.is_grid:
            raise GeohueError("components need a grid of pixels: this scene is a cloud without one")
        check_method(self.method, self.cues, scene.is_grid)

    def as_dict(self) -> dict[str, Any]:
        """Return the arguments by their names, as `geohue.segment` takes them."""
        return {entry.name: getattr(self, entry.name) for entry in fields(SegmentArguments)}

    def _check_levels(self) -> None:
        """Raise an error if a degree of detail is asked for where there are no levels."""
        wish = f"detail is {self.detail!r}"
        if self.k != "auto":
            raise GeohueError(f"{wish} and k is {self.k}: give one of them")
        if self.merges:
            return
        if self.method != PAPER_METHOD:
            reason, mend = f"method {self.method!r}", "or the method"
        elif self.weight != "auto":
            reason, mend = f"a weight of {self.weight!r}", "or the weight"
        else:
            reason, mend = f"preset {self.preset!r}", "or choose preset 'best' or 'fast'"
            if not isinstance(self.preset, str):
                reason = "this preset"
        raise GeohueError(
            f"{wish}, and {reason} has no levels to choose from: leave out the detail, {mend}"
        )


def _check_count(k: Count) -> None:
    if k != "auto" and not (is_whole(k) and 1 <= k <= K_LIMIT):
        raise GeohueError(f'k is {k!r}: expected "auto" or a whole number from 1 to {K_LIMIT}')


def _check_weight(weight: Weight, k: Count, method: str) -> None:
    named = ("auto", *WEIGHT_RULES)
    if weight not in named and not (isinstance(weight, int | float | np.number) and weight >= 0):
        raise GeohueError(f"weight is {weight!r}: expected {', '.join(named)}, or at least 0")
    if weight == "consensus" and k != "auto":
        raise GeohueError(
            'weight="consensus" finds the number of segments itself: leave k="auto", or choose '
            'weight="agreement"'
        )
    if weight == "consensus" and method != PAPER_METHOD:
        raise GeohueError(f'weight="consensus" is for method "{PAPER_METHOD}", not {method!r}')
