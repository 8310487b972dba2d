"""``geohue info``: what is in the files, and how geohue reads them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from geohue.cli.console import print_json, warn

if TYPE_CHECKING:
    from geohue.scene import Scene


def info(
    source: Annotated[
        Path, typer.Argument(metavar="COLOR|CLOUD", help="Colour image, or a cloud (.ply, .pcd).")
    ],
    depth: Annotated[
        Path | None, typer.Argument(metavar="[DEPTH]", help="Depth map registered to the image.")
    ] = None,
    intrinsics: Annotated[
        str | None, typer.Option(metavar="FILE|fx,fy,cx,cy", help="Camera of the depth map.")
    ] = None,
    depth_scale: Annotated[
        float | None,
        typer.Option(metavar="M_PER_UNIT", help="Metres per unit of the depth map."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print a JSON object.")] = False,
) -> None:
    """Tell what was found in the files of a scene and how it is read."""
    from geohue.io.scenes import read_scene

    scene = read_scene(source, depth, intrinsics, depth_scale)
    facts = describe(scene)
    warn(scene.warnings)
    if as_json:
        print_json(facts | {"warnings": list(scene.warnings)})
        return
    for name, value in facts.items():
        typer.echo(f"{name.replace('_', ' '):18} {_text(value)}")


def describe(scene: Scene) -> dict[str, Any]:
    """Return what there is to know of a scene before it is segmented."""
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
