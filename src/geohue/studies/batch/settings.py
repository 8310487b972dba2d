"""What is the same for all frames of a batch."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

from geohue.errors import GeohueError
from geohue.merge.levels import Detail
from geohue.results.outputs import FORMATS
from geohue.scene import Scene
from geohue.segmentation.choice import Weight, check_arguments, check_detail
from geohue.segmentation.clusterers import check_method
from geohue.segmentation.driver import merges_regions, segment
from geohue.segmentation.result import Segmentation
from geohue.settings import PAPER_METHOD, preset_named


@dataclass(frozen=True, slots=True)
class Settings:
    """Arguments of `geohue.segment` and of `geohue.results.outputs.write_results`.

    Raises
    ------
    GeohueError
        For a value that no frame could be segmented with.

    Examples
    --------
    >>> Settings(k=0)
    Traceback (most recent call last):
    geohue.errors.GeohueError: k is 0: expected "auto" or a whole number from 1 to 255
    """

    k: int | Literal["auto"] = "auto"
    weight: Weight = "auto"
    preset: str = "best"
    cues: str = "fusion"
    method: str = PAPER_METHOD
    seed: int = 0
    components: bool = False
    fill: bool = True
    formats: tuple[str, ...] = ()
    lean: bool = False
    detail: Detail = "auto"

    def __post_init__(self) -> None:
        # Seen here, a mistake is one line; seen by `segment`, it would be one a frame.
        settings = preset_named(self.preset)
        check_method(self.method, self.cues, is_grid=True)
        for name in self.formats:
            _choose("format", name, FORMATS)
        check_arguments(self.k, self.weight, self.seed, self.method)
        merges = merges_regions(settings, self.weight, self.method)
        check_detail(self.detail, self.k, merges)

    def segment(self, scene: Scene) -> Segmentation:
        """Segment a scene with one thread."""
        return segment(
            scene,
            self.k,
            self.weight,
            self.preset,
            self.cues,
            self.method,
            self.seed,
            detail=self.detail,
            components=self.components,
            fill=self.fill,
            threads=1,
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the settings ready for JSON."""
        return asdict(self)


def _choose(what: str, given: str, known: tuple[str, ...]) -> None:
    if given not in known:
        raise GeohueError(f"{what} {given!r}: choose among {', '.join(known)}")
