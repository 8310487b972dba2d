"""The scene that the options of a command name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geohue.cli.console import read_camera
from geohue.cli.options import SceneOptions, SegmentOptions
from geohue.errors import GeohueError
from geohue.settings import PAPER_METHOD

if TYPE_CHECKING:
    from geohue.datasets import Dataset
    from geohue.datasets import Frame as DatasetFrame
    from geohue.scene import Scene


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
        _leave_out("--sample", **given.beside_source() | {"sample": None})
        from geohue.datasets import load_sample

        return load_sample(given.sample)
    if source is None:
        raise GeohueError("no scene: give COLOR DEPTH, a cloud, or --sample motorcycle")
    disparity, disparity_scale, calib = given.disparity, given.disparity_scale, given.calib
    if given.right is not None:
        _leave_out("--right", DEPTH=depth, intrinsics=intrinsics, depth_scale=given.depth_scale)
        _leave_out("--right", camera=given.cameras, **given.trust())
        _leave_out("--right", frame=given.frame is not None)
        from geohue.read.scenes.stereo import read_stereo_scene

        pair = source, given.right
        return read_stereo_scene(*pair, disparity, disparity_scale, calib, given.views)
    _need("--right", "stereo pairs", disparity=disparity, disparity_scale=disparity_scale)
    if given.cameras:
        return _range_scene(source, given)
    _need("--right or --camera", "stereo pairs and rigs", calib=calib)
    _need("--right or --camera", "two views", views=None if given.views == 2 else given.views)
    return _frame_or_cloud(source, given)


def check_pieces(option: str, given: SceneOptions, how: SegmentOptions, **others: Any) -> None:
    """Raise an error if something is given that a cloud in pieces, as of `option`, cannot have."""
    how_wishes = {"no_fill": not how.fill, "reunite": how.reunite}
    _leave_out(option, **given.beside_source(), **others, **how_wishes)
    if how.components or how.method != PAPER_METHOD:
        wish = "--components" if how.components else f"--method {how.method}"
        raise GeohueError(f"{wish} needs the whole cloud in memory: leave out {wish} or {option}")


def _range_scene(source: Path, given: SceneOptions) -> Scene:
    _leave_out("--camera", DEPTH=given.depth, intrinsics=given.intrinsics, **given.trust())
    _leave_out("--camera", frame=given.frame is not None)
    if given.calib is None:
        raise GeohueError("--camera needs the rig of the sensors: give it with --calib")
    from geohue.read.scenes.ranges import read_range_scene

    pictures, scale = given.cameras or [], _scale(given.depth_scale)
    return read_range_scene(source, pictures, [given.calib], scale, 1 if given.views == 1 else 2)


def _frame_or_cloud(source: Path, given: SceneOptions) -> Scene:
    from geohue.datasets.layouts import guess_layout, open_dataset
    from geohue.read.scenes.scenes import is_cloud, read_scene

    depth, scale = given.depth, _scale(given.depth_scale)
    if depth is not None or is_cloud(source) or not source.exists() or not guess_layout(source):
        if given.frame is not None:
            raise GeohueError(
                "--frame chooses a frame of a data set, and this is one: leave it out"
            )
        return read_scene(source, depth, given.intrinsics, scale, **given.trust())
    data = open_dataset(source, intrinsics=read_camera(given.intrinsics), depth_scale=scale)
    scene = frame_of(data, given.frame).scene(**given.trust())
    return replace(scene, warnings=(*data.notes, *scene.warnings))


def frame_of(data: Dataset, frame: int | None) -> DatasetFrame:
    """Return the frame that ``--frame`` names; raises `GeohueError` if there is none."""
    i = frame or 0
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
