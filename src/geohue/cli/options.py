"""Options that several commands share, and the groups of them."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geohue.cli.console import read_detail, read_weight, whole_or_auto
from geohue.cli.depth_options import Confidence, Least, Mask, MaxDepth, MinDepth
from geohue.errors import GeohueError
from geohue.settings import PAPER_METHOD

if TYPE_CHECKING:
    from geohue.segmentation.arguments import SegmentArguments

_FRAME = "Depth and camera"
_STEREO = "Stereo"
_RANGE = "Range sensor and cameras"
_DATASET = "Data set"
_LARGE = "Clouds larger than memory (.las .laz .ply .npy)"
_CLUSTER = "Many machines"

Source = Annotated[
    Path | None,
    typer.Argument(
        metavar="[COLOR|CLOUD|DATASET]",
        help="Colour image (the left one), cloud, data set folder or recording.",
    ),
]
Depth = Annotated[
    Path | None, typer.Argument(metavar="[DEPTH]", help="Depth map registered to the image.")
]
Sample = Annotated[
    str | None,
    typer.Option(help="A built-in scene: motorcycle, motorcycle-stereo, boxes, balls, ..."),
]
Intrinsics = Annotated[
    str | None,
    typer.Option(
        metavar="CAMERA",
        help="Camera of the depth map: a file, or fx,fy,cx,cy in pixels.",
        rich_help_panel=_FRAME,
    ),
]
DepthScale = Annotated[
    str | None,
    typer.Option(
        metavar="M_PER_UNIT",
        help="Metres per unit of the depth map, or a name: tum, redwood, ...",
        rich_help_panel=_FRAME,
    ),
]
Right = Annotated[
    Path | None, typer.Option(help="Right image of a stereo pair.", rich_help_panel=_STEREO)
]
Disparity = Annotated[
    Path | None,
    typer.Option(
        help="Disparity of the left image; matched if not given.", rich_help_panel=_STEREO
    ),
]
DisparityScale = Annotated[
    str | None,
    typer.Option(
        metavar="PX_PER_UNIT",
        help="Pixels per unit of the disparity map, such as 1/256.",
        rich_help_panel=_STEREO,
    ),
]
Calib = Annotated[
    str | None,
    typer.Option(
        metavar="FILE|VALUES",
        help="Calibration of the stereo pair (a file, or f,baseline[,doffs]), or of the rig of "
        "--camera.",
        rich_help_panel=_STEREO,
    ),
]
Views = Annotated[
    int,
    typer.Option(
        min=1,
        max=2,
        help="Whether the colours of the left view (1) or of both (2) take part.",
        rich_help_panel=_STEREO,
    ),
]
Cameras = Annotated[
    list[Path] | None,
    typer.Option(
        "--camera",
        help="Picture of a calibrated camera; SOURCE is then a depth map or scan. Repeatable.",
        rich_help_panel=_RANGE,
    ),
]
Frame = Annotated[
    int | None,
    typer.Option(
        min=0, help="Which frame of a data set, from 0 (the default).", rich_help_panel=_DATASET
    ),
]
Memory = Annotated[
    str | None,
    typer.Option(
        metavar="2GB",
        help="Read the cloud in pieces, within so much memory for all processes.",
        rich_help_panel=_LARGE,
    ),
]
Processes = Annotated[
    int | None,
    typer.Option(
        min=1,
        help="Read in pieces with so many processes; by default one a core.",
        rich_help_panel=_LARGE,
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="A dask scheduler, as tcp://HOST:PORT: its workers do it, instead of processes here "
        "(clouds in pieces).",
        rich_help_panel=_CLUSTER,
    ),
]
Resume = Annotated[
    bool,
    typer.Option("--resume", help="Go on with a killed run in DIR.", rich_help_panel=_LARGE),
]
Count = Annotated[
    str,
    typer.Option(
        "-k",
        metavar="auto|N",
        help="Number of segments; under best and fast the level that has so many.",
    ),
]
Detail = Annotated[
    str,
    typer.Option(
        metavar="WORD|NUMBER",
        help="How fine the segments of best and fast are: coarse (-1.5), auto (0), fine (1.5) or "
        "a number; higher is finer.",
    ),
]
Weight = Annotated[
    str,
    typer.Option(
        "--lambda",
        metavar="RULE|NUMBER",
        help="Weight of geometry against colour, or what chooses it: quality, agreement or "
        "consensus; auto leaves it to the preset. Anything else takes the paper's cut.",
    ),
]
Cues = Annotated[
    str, typer.Option(help="What to go by: color, geometry, or fusion, which is both.")
]
Preset = Annotated[
    str,
    typer.Option(
        metavar="best|fast|paper",
        help="best: many cuts vote and regions are merged on all the evidence. fast: the same on "
        "a smaller draft. paper: the method of the paper, with its own number of segments and "
        "weight.",
    ),
]
Method = Annotated[
    str, typer.Option(help="nncsc (the paper's), or a compared system: kmeans, meanshift, ...")
]
Seed = Annotated[int, typer.Option(help="Source of chance.")]
Components = Annotated[
    bool, typer.Option("--components", help="Number connected pieces one by one.")
]
Reunite = Annotated[
    bool,
    typer.Option(
        "--reunite",
        help="Give the parts of a surface that something in front cuts apart one name (frames).",
    ),
]
Fill = Annotated[bool, typer.Option(help="Label pixels without depth too.")]
Formats = Annotated[
    list[str] | None,
    typer.Option(
        "--format",
        "--formats",
        metavar="A,B,..",
        help="Write these too: ply, pcd, las, laz, coco, segments (in pieces: ply, las, laz).",
    ),
]
Lean = Annotated[
    bool,
    typer.Option(
        "--lean",
        help="Write labels and result.json only: no pictures, no levels, and no cloud unless "
        "--format asks for it.",
    ),
]
Overwrite = Annotated[
    bool,
    typer.Option(
        "--overwrite",
        help="Write into DIR though it has other files than an earlier result; those stay.",
    ),
]
Objects = Annotated[
    bool,
    typer.Option(
        "--objects",
        help="Write each segment's place, boxes, planes, colour and neighbours: objects.csv and "
        "objects.json.",
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")]


def names_of(given: list[str] | None) -> tuple[str, ...]:
    """Return the names of an option that takes several, with commas between or given again.

    Examples
    --------
    >>> names_of(["las,ply", "coco"])
    ('las', 'ply', 'coco')
    """
    return tuple(name for text in given or () for part in text.split(",") if (name := part.strip()))


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneOptions:
    """Which scene, and how its files are read."""

    source: Source = None
    depth: Depth = None
    sample: Sample = None
    intrinsics: Intrinsics = None
    depth_scale: DepthScale = None
    confidence: Confidence = None
    least: Least = None
    min_depth: MinDepth = None
    max_depth: MaxDepth = None
    mask: Mask = None
    right: Right = None
    disparity: Disparity = None
    disparity_scale: DisparityScale = None
    calib: Calib = None
    views: Views = 2
    cameras: Cameras = None
    frame: Frame = None

    def trust(self) -> dict[str, Any]:
        """Return which depth is used, as `read_scene` takes it."""
        names = ("confidence", "least", "min_depth", "max_depth", "mask")
        if self.least is not None and self.confidence is None:
            raise GeohueError("--least has nothing to compare with: give --confidence too")
        return {name: getattr(self, name) for name in names}

    def beside_source(self) -> dict[str, Any]:
        """Return what is given but for the source, by what the user calls it."""
        shown = {"depth": "DEPTH", "cameras": "camera"}
        given = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return {
            shown.get(entry.name, entry.name): given[entry.name]
            for entry in fields(self)
            if entry.name != "source" and given[entry.name] != entry.default
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class SegmentOptions:
    """How a scene is segmented."""

    k: Count = "auto"
    weight: Weight = "auto"
    cues: Cues = "fusion"
    preset: Preset = "best"
    detail: Detail = "auto"
    method: Method = PAPER_METHOD
    seed: Seed = 0
    components: Components = False
    reunite: Reunite = False
    fill: Fill = True

    def arguments(self) -> SegmentArguments:
        """Return them as `geohue.segment` takes them; raises `GeohueError` for a mistake."""
        from geohue.segmentation.arguments import SegmentArguments

        return SegmentArguments(**self.values())

    def values(self) -> dict[str, Any]:
        """Return the values by their names, numbers as numbers; the library checks the rest."""
        read = {
            "k": whole_or_auto(self.k, "-k"),
            "weight": read_weight(self.weight),
            "detail": read_detail(self.detail),
        }
        return {entry.name: getattr(self, entry.name) for entry in fields(self)} | read
