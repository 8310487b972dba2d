"""Stereo calibrations: the files in use, as a `StereoRig`, and OpenCV's YAML out."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from geohue.errors import GeohueError
from geohue.read.cameras.text import NUMBER, parse_camera_text
from geohue.read.files import broken, read_bytes
from geohue.stereo.formats import rig_from_content
from geohue.stereo.rig import StereoRig

_READ = (
    "what is read: 'f,baseline[,doffs[,cx,cy]]' as text, OpenCV YAML or XML (K1 D1 K2 D2 R T, or "
    "Q), Middlebury calib.txt or dmin.txt, KITTI calib.txt, ROS camera_info YAML (left and right), "
    "JSON with f, baseline, cx0, cx1"
)
_FILE_LIMIT = 16 << 20


def read_stereo_calibration(path: str | Path, second: str | Path | None = None) -> StereoRig:
    """Read the calibration of a stereo pair.

    Parameters
    ----------
    path : str or Path
        A file, or the text ``"f,baseline[,doffs[,cx,cy]]"`` (pixels, metres, pixels). Files:
        OpenCV YAML or XML with K1 D1 K2 D2 R T (also M1 M2) or with Q or P1 P2; Middlebury
        calib.txt (2014: cam0, cam1, doffs, baseline) or focal, baseline, dmin (2005, 2006), also
        a dmin.txt alone; KITTI calib.txt (P2, P3; P_rect_02, P_rect_03; P0, P1); ROS camera_info
        YAML; JSON with fx or f, baseline, and cx0, cx1, doffs, cy where known.
    second : str or Path, optional
        Where the calibration is in two files (OpenCV's extrinsics.yml, the right camera of ROS).
        Without it, a file beside the first is taken whose name has ``right`` for ``left`` or
        ``extrinsics`` for ``intrinsics``.

    Returns
    -------
    StereoRig
        In metres. Baselines from 10 on are taken as millimetres, with a warning where the format
        leaves the unit open.

    Raises
    ------
    GeohueError
        If there is no such file or no stereo calibration in it.

    Examples
    --------
    >>> rig = read_stereo_calibration("721.5, 0.54")
    >>> rig.left.fx, rig.baseline, rig.centre_known
    (721.5, 0.54, False)
    """
    content = _from_text(path) or _content(path)
    other = second if second is not None else _sibling(path)
    if other is not None:
        content = _joined(content, _content(other))
    try:
        rig = rig_from_content(content)
    except (TypeError, ValueError, IndexError, OverflowError) as error:
        cause = str(error) if isinstance(error, GeohueError) else "its numbers do not fit together"
        raise broken(path, f"{cause}; {_READ}") from error
    if rig is None:
        raise broken(path, f"has no stereo calibration; {_READ}")
    return rig


# --- the text ------------------------------------------------------------------------------------


def _numbers_in(text: str) -> list[float] | None:
    """Return the numbers of a text that has nothing else, None otherwise."""
    words = [word for word in re.split(r"[\s,;]+", text.strip()) if word]
    if not words or not all(re.fullmatch(NUMBER, word) for word in words):
        return None
    return [float(word) for word in words]


def _from_text(path: str | Path) -> dict[str, Any] | None:
    """Return what the argument says itself, None where it names a file."""
    numbers = _numbers_in(path) if isinstance(path, str) else None
    return None if numbers is None or len(numbers) < 2 else _bare(numbers, path)


def _content(path: str | Path) -> dict[str, Any]:
    """Return a file's keys, in lower case; nested mappings (left, right) stay nested."""
    try:
        text = read_bytes(path, _FILE_LIMIT).decode("utf-8-sig", "replace")
    except GeohueError as error:
        if "no such file" not in str(error):
            raise
        cause = "no such file, nor the numbers f,baseline[,doffs[,cx,cy]]"
        raise broken(path, f"{cause}; {_READ}") from error
    numbers = _numbers_in(text)
    if numbers is not None:
        return _bare(numbers, path)
    assigned = re.findall(r"(?m)^[ \t]*(\w+)[ \t]*=[ \t]*([^\r\n]+)", text)
    if assigned:  # Middlebury
        return {key.lower(): _values(value) for key, value in assigned}
    parsed = parse_camera_text(text, path)
    if not isinstance(parsed, dict):
        return {}
    return _lower(parsed)


def _bare(numbers: list[float], path: str | Path) -> dict[str, Any]:
    """Return what a file of numbers alone means: dmin, or the same as on the command line."""
    if len(numbers) == 1:
        return {"dmin": numbers[0]}
    if len(numbers) not in (2, 3, 5):
        cause = f"has {len(numbers)} bare numbers; f,baseline[,doffs[,cx,cy]] are 2, 3 or 5"
        raise broken(path, f"{cause}; {_READ}")
    return dict(zip(("f", "baseline", "doffs", "cx", "cy"), numbers, strict=False))


def _values(text: str) -> Any:
    found = [float(x) for x in re.findall(NUMBER, text)]
    return found[0] if len(found) == 1 else found


def _lower(mapping: Mapping[Any, Any]) -> dict[str, Any]:
    return {
        str(key).lower(): _lower(value) if isinstance(value, dict) else value
        for key, value in mapping.items()
    }


def _sibling(path: str | Path) -> Path | None:
    file = Path(path)
    for one, other in (("left", "right"), ("intrinsics", "extrinsics")):
        if one in file.name:
            beside = file.with_name(file.name.replace(one, other))
            if beside.is_file():
                return beside
    return None


def _joined(first: dict[str, Any], second: dict[str, Any]) -> dict[str, Any]:
    """Join two files: the cameras of ROS side by side, any others key by key."""
    if "projection_matrix" in first and "projection_matrix" in second:
        return {"left": first, "right": second}
    return second | first
