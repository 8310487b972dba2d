"""Options that several commands share, the groups of them, and the scene they name."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geohue.cli.console import read_camera, read_detail, read_weight, whole_or_auto
from geohue.errors import GeohueError
from geohue.settings import PAPER_METHOD

if TYPE_CHECKING:
    from geohue.datasets import Dataset
    from geohue.datasets import Frame as DatasetFrame
    from geohue.scene import Scene
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
        metavar="FILE|fx,fy,cx,cy", help="Camera of the depth map.", rich_help_panel=_FRAME
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
        metavar="FILE|f,baseline[,doffs]",
        help="Calibration of the stereo pair, or of the rig of --camera.",
        rich_help_panel=_STEREO,
    ),
]
Views = Annotated[
    int,
    typer.Option(
        min=1, max=2, help="Colours of one view or of both (eq. 19).", rich_help_panel=_STEREO
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
    int, typer.Option(min=0, help="Which frame of a data set.", rich_help_panel=_DATASET)
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
        metavar="tcp://HOST:PORT",
        help="A dask scheduler: its workers do it, instead of processes here (clouds in pieces).",
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
        metavar="auto|INT",
        help="Number of segments; under best and fast the level that has so many.",
    ),
]
Detail = Annotated[
    str,
    typer.Option(
        metavar="WORD|FLOAT",
        help="How fine the segments of best and fast are: coarse (-1.5), auto (0), fine (1.5) or "
        "a number; higher is finer.",
    ),
]
Weight = Annotated[
    str,
    typer.Option(
        "--lambda",
        metavar="auto|quality|agreement|consensus|FLOAT",
        help="Weight of geometry against colour, or the rule that chooses it; auto leaves it to "
        "the preset. Anything else takes the paper's cut.",
    ),
]
Cues = Annotated[str, typer.Option(help="fusion, color or geometry.")]
Preset = Annotated[
    str,
    typer.Option(
        metavar="best|fast|paper",
        help="best: many cuts vote and regions are merged on all the evidence. fast: the same on "
        "a smaller draft. paper: the paper's cut, number of segments and weight. Clouds read in "
        "pieces always take the paper's cut.",
    ),
]
Method = Annotated[
    str, typer.Option(help="nncsc (the paper's), or a compared system: kmeans, meanshift, ...")
]
Seed = Annotated[int, typer.Option(help="Source of chance.")]
Components = Annotated[
    bool, typer.Option("--components", help="Number connected pieces one by one.")
]
Fill = Annotated[bool, typer.Option(help="Label pixels without depth too.")]
Formats = Annotated[
    list[str] | None,
    typer.Option(
        "--format",
        metavar="NAME",
        help="Write this too: ply, pcd, las, laz, coco or segments (in pieces: ply, las, laz). "
        "Repeatable.",
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
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")]


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneOptions:
    """Which scene, and how its files are read."""

    source: Source = None
    depth: Depth = None
    sample: Sample = None
    intrinsics: Intrinsics = None
    depth_scale: DepthScale = None
    right: Right = None
    disparity: Disparity = None
    disparity_scale: DisparityScale = None
    calib: Calib = None
    views: Views = 2
    cameras: Cameras = None
    frame: Frame = 0

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


def load_scene(given: SceneOptions) -> Scene:
    """Read the scene that a command's options name.

    Raises
    ------
    GeohueError
        If nothing or too much is named, or a file cannot be used.
    """
    source, depth, intrinsics = given.source, given.depth, given.intrinsics
    if given.sample is not None:
        if source is not None:
            raise GeohueError(f"both {source} and --sample {given.sample} given: choose one")
        from geohue.datasets import load_sample

        return load_sample(given.sample)
    if source is None:
        raise GeohueError("no scene: give COLOR DEPTH, a cloud, or --sample motorcycle")
    disparity, disparity_scale, calib = given.disparity, given.disparity_scale, given.calib
    if given.right is not None:
        _leave_out("--right", DEPTH=depth, intrinsics=intrinsics, depth_scale=given.depth_scale)
        _leave_out("--right", camera=given.cameras)
        from geohue.read.scenes.stereo import read_stereo_scene

        pair = source, given.right
        return read_stereo_scene(*pair, disparity, disparity_scale, calib, given.views)
    _need("--right", "stereo pairs", disparity=disparity, disparity_scale=disparity_scale)
    if given.cameras:
        return _range_scene(source, given)
    _need("--right or --camera", "stereo pairs and rigs", calib=calib)
    return _frame_or_cloud(source, depth, intrinsics, _scale(given.depth_scale), given.frame)


def check_pieces(option: str, given: SceneOptions, how: SegmentOptions, **others: Any) -> None:
    """Raise an error if something is given that a cloud in pieces, as of `option`, cannot have."""
    detail = how.detail != "auto"
    _leave_out(option, **given.beside_source(), **others, no_fill=not how.fill, detail=detail)
    if how.components or how.method != PAPER_METHOD:
        wish = "--components" if how.components else f"--method {how.method}"
        raise GeohueError(f"{wish} needs the whole cloud in memory: leave out {wish} or {option}")


def _range_scene(source: Path, given: SceneOptions) -> Scene:
    _leave_out("--camera", DEPTH=given.depth, intrinsics=given.intrinsics)
    if given.calib is None:
        raise GeohueError("--camera needs the rig of the sensors: give it with --calib")
    from geohue.read.scenes.ranges import read_range_scene

    pictures, scale = given.cameras or [], _scale(given.depth_scale)
    return read_range_scene(source, pictures, [given.calib], scale, 1 if given.views == 1 else 2)


def _frame_or_cloud(
    source: Path,
    depth: Path | None,
    intrinsics: str | None,
    depth_scale: float | str | None,
    frame: int,
) -> Scene:
    from geohue.datasets.layouts import guess_layout, open_dataset
    from geohue.read.scenes.scenes import is_cloud, read_scene

    if depth is not None or is_cloud(source) or not source.exists() or not guess_layout(source):
        return read_scene(source, depth, intrinsics, depth_scale)
    data = open_dataset(source, intrinsics=read_camera(intrinsics), depth_scale=depth_scale)
    return frame_of(data, frame).scene()


def frame_of(data: Dataset, i: int) -> DatasetFrame:
    """Return the frame that ``--frame`` names; raises `GeohueError` if there is none."""
    if i >= len(data):
        raise GeohueError(f"{data.path}: has {len(data)} frame(s), counted from 0; --frame is {i}")
    return data[i]


def _leave_out(option: str, **others: Any) -> None:
    """Raise an error if an option is given that another one makes pointless."""
    for name, value in others.items():
        if value:
            shown = name if name.isupper() else "--" + name.replace("_", "-")
            raise GeohueError(f"{option} and {shown} do not go together: leave out {shown}")


def _need(option: str, purpose: str, **others: Any) -> None:
    """Raise an error if an option is given without the one that it belongs to."""
    for name, value in others.items():
        if value is not None:
            shown = "--" + name.replace("_", "-")
            raise GeohueError(f"{shown} is for {purpose}: give {option} too")


def _scale(text: str | None) -> float | str | None:
    if text is None:
        return None
    try:
        return float(text)
    except ValueError:
        return text
