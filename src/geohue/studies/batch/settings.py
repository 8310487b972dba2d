"""What is the same for all frames of a batch."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from geohue.results.outputs import FORMATS
from geohue.segmentation.arguments import SegmentArguments
from geohue.settings.checks import check_choice


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings(SegmentArguments):
    """Arguments of `geohue.segment` and of `geohue.results.outputs.write_results`.

    Attributes
    ----------
    formats : tuple of str
        More files for each frame (`FORMATS`).
    lean : bool
        Whether to leave out pictures and levels.

    Raises
    ------
    GeohueError
        For a value that no frame could be segmented with.

    Examples
    --------
    >>> Settings(formats=("docx",))
    Traceback (most recent call last):
    geohue.errors.GeohueError: format 'docx': choose one of ply, pcd, las, laz, coco, segments,
    objects
    """

    formats: tuple[str, ...] = ()
    lean: bool = False

    def __post_init__(self) -> None:
        SegmentArguments.__post_init__(self)
        for name in self.formats:
            check_choice("format", name, FORMATS)

    def for_json(self) -> dict[str, Any]:
        """Return all settings ready for JSON."""
        return asdict(self)
