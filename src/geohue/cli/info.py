"""``geohue info``: what is in the files, and how geohue reads them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geohue.cli.console import print_json, read_camera, warn

if TYPE_CHECKING:
    from geohue.scene import Scene


def info(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="COLOR|CLOUD|DATASET",
            help="Colour image, cloud, or folder or recording of a data set.",
        ),
    ],
    depth: Annotated[
        Path | None, typer.Argument(metavar="[DEPTH]", help="Depth map registered to the image.")
    ] = None,
    intrinsics: Annotated[
        str | None, typer.Option(metavar="FILE|fx,fy,cx,cy", help="Camera of the depth map.")
    ] = None,
    depth_scale: Annotated[
        str | None,
        typer.Option(metavar="M_PER_UNIT|NAME", help="Unit of the depth map: 0.001, tum, sun."),
    ] = None,
    layout: Annotated[
        str | None, typer.Option(help="Layout of the data set, if it is not to be guessed.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print a JSON object.")] = False,
) -> None:
    """Tell what was found in the files of a scene or data set and how it is read."""
    facts, notes = _facts(source, depth, intrinsics, depth_scale, layout)
    warn(notes)
    if as_json:
        print_json(facts | {"warnings": list(notes)})
        return
    for name, value in facts.items():
        typer.echo(f"{name.replace('_', ' '):18} {_text(value)}")


def _facts(
    source: Path, depth: Path | None, intrinsics: str | None, scale: str | None, layout: str | None
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return what is known of a data set, a cloud without colours, or a scene."""
    from geohue.datasets.layouts import guess_layout, open_dataset
    from geohue.read.clouds.cloud import is_colmap
    from geohue.read.scenes.scenes import is_cloud, read_scene

    found = None
    if depth is None and not is_colmap(source) and (source.is_dir() or layout is None):
        found = guess_layout(source) if source.exists() else None
    if layout is not None or found is not None or (source.is_dir() and not is_colmap(source)):
        data = open_dataset(source, layout, intrinsics=read_camera(intrinsics), depth_scale=scale)
        scene = data[0].scene()
        facts = data.describe() | {f"frame_{k}": v for k, v in describe(scene).items()}
        return facts, (*data.notes, *scene.warnings)
    if depth is None and is_cloud(source):
        return describe_cloud(source)
    scene = read_scene(source, depth, intrinsics, scale)
    return describe(scene), scene.warnings


def describe_cloud(path: Path) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return what there is to know of a cloud file, also of one that cannot be segmented."""
    import numpy as np

    from geohue.read.clouds.cloud import format_of, read_cloud
    from geohue.scene import Scene

    cloud = read_cloud(path)
    known = np.isfinite(cloud.points).all(axis=-1)
    scene = Scene.from_cloud(cloud.points, cloud.colors)
    notes = scene.warnings
    facts = describe(scene)
    facts["read_as"] = format_of(path)
    facts |= {
        "colors": cloud.colors is not None,
        "normals": cloud.normals is not None,
        "labels": cloud.labels is not None,
        "points_missing": int(known.size - known.sum()),
    }
    if cloud.offset.any():
        facts["offset"] = cloud.offset.tolist()
    if cloud.colors is None:
        del facts["grey"]
    return facts, notes


def describe(scene: Scene) -> dict[str, Any]:
    """Return what there is to know of a scene before it is segmented."""
    import numpy as np

    valid = scene.valid
    facts: dict[str, Any] = {"kind": _kind(scene), "n_points": scene.size}
    if scene.is_grid:
        facts["size"] = [scene.shape[1], scene.shape[0]]
    facts["with_geometry"] = int(valid.sum())
    facts["grey"] = bool((scene.colors == scene.colors[..., :1]).all())
    if not valid.any():
        return facts
    points = scene.points[valid]
    facts["minimum"] = points.min(axis=0).tolist()
    facts["maximum"] = points.max(axis=0).tolist()
    if scene.depth is not None and scene.intrinsics is not None:
        camera = scene.intrinsics
        facts["median_depth_m"] = float(np.median(scene.depth[valid]))
        facts["fx_fy_cx_cy"] = [camera.fx, camera.fy, camera.cx, camera.cy]
        facts["field_of_view_deg"] = [
            float(np.degrees(2 * np.arctan(n / (2 * f))))
            for n, f in ((scene.shape[1], camera.fx), (scene.shape[0], camera.fy))
        ]
    return facts


def _kind(scene: Scene) -> str:
    if scene.depth is not None:
        return "RGB-D frame"
    if not scene.valid.any() and scene.is_grid:
        return "image without depth"
    return "organised cloud" if scene.is_grid else "cloud"


def _text(value: object) -> str:
    if isinstance(value, list):
        return "  ".join(_text(item) for item in value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
