"""``geohue info``: what is in the files, and how geohue reads them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geohue.cli import options, scenes
from geohue.cli.console import print_json, read_camera, warn
from geohue.cli.groups import with_groups

if TYPE_CHECKING:
    from geohue.datasets import Dataset
    from geohue.scene import Scene
    from geohue.stereo.pair import StereoPair


@with_groups
def info(
    *,
    given: options.SceneOptions,
    layout: Annotated[
        str | None, typer.Option(help="Layout of the data set, if it is not to be guessed.")
    ] = None,
    as_json: options.AsJson = False,
) -> None:
    """Tell what was found in the files of a scene or data set and how it is read."""
    facts, notes = _facts(given, layout)
    warn(notes)
    if as_json:
        print_json(facts | {"warnings": list(notes)})
        return
    for name, value in facts.items():
        typer.echo(f"{name.replace('_', ' '):18} {_text(value)}")


def _facts(
    given: options.SceneOptions, layout: str | None
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return what is known of a data set, a cloud without colours, or a scene."""
    from geohue.read.scenes.scenes import is_cloud

    source, others = given.source, given.beside_source().keys() - {"intrinsics", "depth_scale"}
    if source is not None and others <= {"frame"}:
        data = _dataset(source, given, layout)
        if data is not None:
            scene = scenes.frame_of(data, given.frame).scene()
            facts = data.describe() | {f"frame_{k}": v for k, v in describe(scene).items()}
            return facts, (*data.notes, *scene.warnings)
        if is_cloud(source):
            return describe_cloud(source)
    scene = scenes.load_scene(given)
    return describe(scene), scene.warnings


def _dataset(source: Path, given: options.SceneOptions, layout: str | None) -> Dataset | None:
    """Open the data set that a folder or file is; None for one that is a scene of its own."""
    from geohue.datasets.layouts import guess_layout, open_dataset
    from geohue.read.clouds.cloud import is_colmap

    if layout is None and is_colmap(source):
        return None
    found = layout
    if found is None and source.exists():
        found = guess_layout(source)
    if found is None and not source.is_dir():
        return None
    camera = read_camera(given.intrinsics)
    return open_dataset(source, found, intrinsics=camera, depth_scale=given.depth_scale)


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
    return facts if scene.pair is None else facts | _pair_facts(scene.pair)


def _pair_facts(pair: StereoPair) -> dict[str, Any]:
    """Return what there is to know of the stereo pair that a scene was made of."""
    import numpy as np

    known = pair.disparity[np.isfinite(pair.disparity)]
    return {
        "baseline_m": pair.rig.baseline,
        "doffs_px": float(pair.rig.offset),
        "rectified_here": pair.unrectified is not None,
        "with_disparity": int(known.size),
        "disparity_px": [float(x) for x in np.quantile(known, (0.01, 0.5, 0.99))],
    }


def _kind(scene: Scene) -> str:
    if scene.pair is not None:
        return "stereo pair"
    if scene.depth is not None:
        return "RGB-D frame"
    if not scene.valid.any() and scene.is_grid:
        return "image without depth"
    return "organised cloud" if scene.is_grid else "cloud"


def _text(value: object) -> str:
    if isinstance(value, list):
        return "  ".join(_text(item) for item in value)
    if value is None:
        return "not known"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
