"""``geohue video``: a sequence or camera, with segments that keep their identity."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geohue.cli import options
from geohue.cli.console import print_json, read_camera, read_detail, warn
from geohue.errors import GeohueError

if TYPE_CHECKING:
    from geohue.datasets.frames import Frame
    from geohue.video.outputs import Earlier, Outputs, Wishes
    from geohue.video.run import Report, Show
    from geohue.video.segmenter import VideoSegmenter
    from geohue.video.sources import Camera

_LIVE = "Live"
_OUTPUT = "Output"
_DEVICE = "realsense"


def video(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="SEQUENCE",
            help="A data set, recording or folder of frames, a colour video, or 'realsense' for "
            "the camera (realsense:SERIAL for one of several).",
        ),
    ],
    depth: Annotated[
        Path | None, typer.Option(help="Folder of the depth maps that belong to a colour video.")
    ] = None,
    layout: Annotated[
        str | None, typer.Option(help="Layout of the data set, if it is not to be guessed.")
    ] = None,
    intrinsics: Annotated[
        str | None, typer.Option(metavar="FILE|fx,fy,cx,cy", help="Camera of the depth maps.")
    ] = None,
    depth_scale: Annotated[
        str | None, typer.Option(metavar="M_PER_UNIT", help="Metres per unit of the depth maps.")
    ] = None,
    preset: Annotated[
        str,
        typer.Option(
            metavar="best|fast|paper",
            help="As of 'geohue segment'; paper carries the first frame's K and lambda on.",
        ),
    ] = "best",
    detail: Annotated[
        str, typer.Option(metavar="WORD|FLOAT", help="coarse, auto, fine or a number.")
    ] = "auto",
    seed: Annotated[int, typer.Option(help="Source of chance.")] = 0,
    threads: Annotated[int | None, typer.Option(help="Threads; by default one a core.")] = None,
    memory: Annotated[
        int, typer.Option(min=0, help="Frames for which a hidden thing keeps its identity.")
    ] = 30,
    poses: Annotated[bool, typer.Option(help="Use the poses of the sequence.")] = True,
    limit: Annotated[int | None, typer.Option(min=1, help="Most frames to segment.")] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o", "--out", metavar="DIR", help="Where results go.", rich_help_panel=_OUTPUT
        ),
    ] = None,
    kind: Annotated[
        str,
        typer.Option(
            "--video", metavar="webm|mp4|none", help="The overlay video.", rich_help_panel=_OUTPUT
        ),
    ] = "webm",
    rate: Annotated[
        float,
        typer.Option(
            help="Frames a second: of the overlay video, and of a file with --live.",
            rich_help_panel=_OUTPUT,
        ),
    ] = 30.0,
    fuse: Annotated[
        float | None,
        typer.Option(
            metavar="METRES",
            help="Also write cloud.ply: all frames fused by their poses, in voxels of this size.",
            rich_help_panel=_OUTPUT,
        ),
    ] = None,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume",
            help="Go on with the run in DIR, with its identities.",
            rich_help_panel=_OUTPUT,
        ),
    ] = False,
    overwrite: options.Overwrite = False,
    live: Annotated[
        bool,
        typer.Option(
            "--live",
            help="Show a window and drop frames rather than fall behind.",
            rich_help_panel=_LIVE,
        ),
    ] = False,
    window: Annotated[
        bool, typer.Option(help="Show the window of --live.", rich_help_panel=_LIVE)
    ] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")] = False,
) -> None:
    """Segment a sequence such that the same thing keeps the same label.

    Writes overlay.webm, labels/, tracks.json, tracks.csv and video.json to the folder of -o.
    Ctrl-C ends a run with all files complete, and --resume goes on with it.
    """
    if out is None and not live and not as_json:
        raise GeohueError("nothing to do with the labels: give -o DIR, --live or --json")
    if kind not in ("webm", "mp4", "none"):
        raise GeohueError(f"--video {kind}: expected webm, mp4 or none")
    if not rate > 0:
        raise GeohueError(f"--rate {rate:g}: expected frames a second above 0")
    sequence = str(source)
    device = sequence.split(":")[0] == _DEVICE and not Path(sequence).exists()
    if resume and (out is None or device or live):
        raise GeohueError("--resume goes on with a recording in -o DIR: not live, no camera")
    if resume and preset == "paper":
        raise GeohueError("--resume goes on with best or fast: paper needs its first frame")
    wanted = read_detail(detail)
    given = {"layout": layout, "intrinsics": intrinsics, "depth_scale": depth_scale}
    frames = [] if device else _frames(sequence, depth, not poses, **given)
    from geohue.video.outputs import Wishes
    from geohue.video.segmenter import VideoSegmenter

    settings = {"sequence": sequence, "preset": preset, "detail": detail, "seed": seed}
    settings |= {"memory": memory, "poses": poses, "rate": rate}
    wishes = Wishes(kind, rate, fuse, labels=True, settings=settings)
    with VideoSegmenter(
        preset, detail=wanted, seed=seed, threads=threads, memory=memory, live=live
    ) as segmenter:
        start, outputs = _begin(out, wishes, resume, overwrite, frames, segmenter)
        camera = _camera(sequence, frames, start, rate if live else None)
        from geohue.video.run import run_video

        show = _window() if live and window else None
        report = run_video(camera, segmenter, outputs, live=live, show=show, limit=limit)
        _tell(report, segmenter, out, as_json)
    if report.interrupted:
        raise typer.Abort
    raise typer.Exit(1 if report.skipped else 0)


def _frames(sequence: str, depth: Path | None, bare: bool, **given: Any) -> list[Frame]:
    """The frames of a recording, without their poses if wished."""
    from dataclasses import replace

    from geohue.datasets.layouts import open_dataset
    from geohue.video.sources import VIDEO_FILES, video_frames

    camera, scale = read_camera(given["intrinsics"]), _scale(given["depth_scale"])
    path = Path(sequence)
    if depth is not None:
        return video_frames(path, depth, camera, scale)
    if path.suffix.lower() in VIDEO_FILES and path.is_file():
        raise GeohueError(f"{path}: a colour video needs its depth maps: give their --depth FOLDER")
    data = open_dataset(path, given["layout"], intrinsics=camera, depth_scale=scale)
    warn(data.notes)
    return [replace(frame, T_world_camera=None) for frame in data] if bare else list(data)


def _begin(
    out: Path | None,
    wishes: Wishes,
    resume: bool,
    overwrite: bool,
    frames: list[Frame],
    segmenter: VideoSegmenter,
) -> tuple[int, Outputs | None]:
    """Prepare the folder; returns the number of the first frame to read."""
    if out is None:
        return 0, None
    from geohue.video.outputs import Outputs, go_on, read_earlier

    earlier = read_earlier(out, wishes.settings) if resume else None
    outputs = Outputs(out, wishes, earlier, overwrite=overwrite)
    if earlier is None:
        return 0, outputs
    _replay(frames, earlier, outputs)
    if earlier.last + 1 < len(frames):
        go_on(segmenter, out, earlier, frames[earlier.last])
    return earlier.last + 1, outputs


def _replay(frames: list[Frame], earlier: Earlier, outputs: Outputs) -> None:
    """Put what a run had done before into the fused cloud."""
    done = set(earlier.frames)
    for frame in frames[: earlier.last + 1]:
        if frame.name in done:
            outputs.fuse(frame)


def _camera(sequence: str, frames: list[Frame], start: int, pace: float | None) -> Camera:
    if not frames:
        from geohue.video.realsense import RealSenseCamera

        return RealSenseCamera(sequence.partition(":")[2] or None)
    from geohue.video.sources import FileCamera, PacedCamera

    camera = FileCamera(frames, start)
    return camera if pace is None else PacedCamera(camera, pace)


def _window() -> Show:
    """What shows each frame in a window until Escape or q is pressed."""
    import cv2

    try:
        cv2.namedWindow("geohue")
    except cv2.error as error:
        raise GeohueError(
            "no window can be shown: there is no display, or OpenCV is the headless one "
            "(pip install opencv-python in its place); --no-window does without"
        ) from error
    from geohue.results.picture import overlay

    def show(shot: Any, labels: Any) -> bool:
        cv2.imshow("geohue", overlay(shot.scene.colors, labels)[..., ::-1])
        return cv2.waitKey(1) & 0xFF not in (27, ord("q"))

    return show


def _tell(report: Report, segmenter: VideoSegmenter, out: Path | None, as_json: bool) -> None:
    facts = report.summary()
    warn(f"{one['frame']}: skipped: {one['error']}" for one in facts["skipped"])
    if as_json:
        print_json(facts | {"models": segmenter.models, "tracks": segmenter.tracker.following})
        return
    if report.n_frames:
        late = facts["latency_s"]
        milliseconds = ", ".join(f"{name} {1000 * late[name]:.0f}" for name in late)
        typer.echo(
            f"{report.n_frames} frame(s), {segmenter.tracker.following} track(s), "
            f"{facts['frames_per_second']:.1f} frames/s all in all, "
            f"{1000 * facts['segmenting_s']:.0f} ms for segmenting one "
            f"(first {1000 * facts['first_frame_s']:.0f}), "
            f"latency {milliseconds} ms, {report.dropped} dropped, {len(report.skipped)} skipped"
        )
    else:
        typer.echo("no further frame")
    if out is not None:
        typer.echo(f"{out}: {', '.join(sorted(file.name for file in out.iterdir()))}")


def _scale(text: str | None) -> float | str | None:
    if text is None:
        return None
    try:
        return float(text)
    except ValueError:
        return text
