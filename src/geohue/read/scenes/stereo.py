"""From the files of a stereo pair to a scene."""

from __future__ import annotations

from pathlib import Path

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
    return Scene.from_stereo(
        left,
        right,
        calib,
        disparity,
        1 if views == 1 else 2,
        disparity_scale=disparity_scale,
    )
