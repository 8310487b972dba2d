"""From the files of a stereo pair to a scene."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from geohue.errors import GeohueError
from geohue.read.cameras.stereo_calibration import read_stereo_calibration
from geohue.read.files import broken, with_notes
from geohue.read.images.disparity import parse_disparity_scale, read_disparity
from geohue.read.images.pictures import read_color
from geohue.scene import Scene


def read_stereo_scene(
    left: str | Path,
    right: str | Path,
    disparity: str | Path | None = None,
    disparity_scale: str | float | None = None,
    calib: str | Path | None = None,
    views: int = 2,
) -> Scene:
    """Read a stereo pair as a scene of its left view (Sec. V).

    Parameters
    ----------
    left, right : str or Path
        The images.
    disparity : str or Path, optional
        Of the left image (`read_disparity`); without it the pair is matched.
    disparity_scale : str or float, optional
        Pixels per unit of the disparity map, such as "1/256".
    calib : str or Path, optional
        Calibration file or "f,baseline[,doffs]" (`read_stereo_calibration`).
    views : {1, 2}
        Whether the right view's colours take part.

    Returns
    -------
    Scene
        Its `warnings` tell every guess that was made.

    Raises
    ------
    GeohueError
        If a file cannot be read or the files do not fit together.
    """
    images = read_color(left), read_color(right)
    if images[0].shape != images[1].shape:
        sizes = " and ".join(f"{image.shape[1]} x {image.shape[0]}" for image in images)
        raise broken(right, f"differs in size from {left}: {sizes}; give a pair of one size")
    rig, notes = (None, ()) if calib is None else with_notes(read_stereo_calibration, calib)
    if disparity is None:
        if disparity_scale is not None:
            raise GeohueError("--disparity-scale has no --disparity to scale: give the map too")
        known = None
    else:
        scale = disparity_scale
        if isinstance(scale, str):
            scale = parse_disparity_scale(scale)
        image = read_disparity(disparity, scale)
        known, notes = image.disparity, (*notes, *image.warnings)
    scene = Scene.from_stereo(*images, rig, known, 1 if views == 1 else 2)
    return replace(scene, warnings=(*notes, *scene.warnings))
