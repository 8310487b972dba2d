"""Colour pictures and depth maps as files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.read.arrays import read_npy, read_npz, read_pfm
from geohue.read.files import broken, read_bytes
from geohue.read.images.depth_units import Decoder, DepthUnit, depth_unit
from geohue.read.images.exr import read_exr
from geohue.read.images.integrity import check_picture
from geohue.read.images.quiet import harmful, listened

_INTEGER_SCALE = 0.001  # metres per unit: millimetres, what most depth cameras write
_SATURATED = 65535  # the 16-bit sensors' second mark for "no measurement"
_PLAUSIBLE = (0.1, 100.0)  # metres
_SCATTERED = 20  # pieces of each value, beyond which an image is none of labels
_SMALL = 100  # pixels of a piece, below which it is so
_FAR = 15.0  # metres, beyond the reach of depth cameras that count in millimetres


@dataclass(frozen=True, slots=True, eq=False)
class DepthImage:
    """A depth map in metres.

    Parameters
    ----------
    depth : (H, W) float32
        Metres along the optical axis; NaN where missing.
    scale : float
        Metres per unit of the file that were used.
    warnings : tuple of str
        What the user should know, such as an implausible scale.
    """

    depth: NDArray[np.float32]
    scale: float
    warnings: tuple[str, ...] = ()


def read_color(path: str | Path) -> NDArray[np.uint8]:
    """Read a colour picture.

    Parameters
    ----------
    path : path-like
        PNG, JPEG, PPM, BMP, TIFF, WebP or whatever else OpenCV decodes. The pixels are taken as
        they are stored: a rotation mark in the file is not applied.

    Returns
    -------
    (H, W, 3) uint8
        sRGB. Grey is repeated, alpha dropped, 16 bits become 8, fractions 0..1 become 0..255.

    Raises
    ------
    GeohueError
        If the file is missing, damaged, cut short or not a picture.

    Examples
    --------
    >>> from geohue.results import write_png
    >>> file = getfixture("tmp_path") / "grey.png"
    >>> write_png(file, np.full((2, 3), 7, np.uint8))
    >>> read_color(file).shape
    (2, 3, 3)
    """
    pixels = decode_picture(path)
    if pixels.ndim == 2:
        pixels = np.repeat(pixels[..., None], 3, axis=2)
    elif pixels.shape[2] in (3, 4):
        pixels = pixels[..., 2::-1]  # OpenCV's order is blue, green, red
    else:
        raise broken(path, f"has {pixels.shape[2]} channels; save it as grey or RGB")
    return np.ascontiguousarray(_to_bytes(pixels, path))


def _to_bytes(pixels: NDArray[Any], path: str | Path) -> NDArray[np.uint8]:
    if pixels.dtype == np.uint8:
        return pixels
    if pixels.dtype == np.uint16:
        return (pixels >> 8).astype(np.uint8)
    if pixels.dtype.kind == "f":
        if not (pixels.min() >= 0 and pixels.max() <= 1):
            raise broken(path, "has float colours outside 0..1; save it as an 8-bit PNG")
        return np.rint(pixels * 255.0).astype(np.uint8)
    raise broken(path, f"has {pixels.dtype} colours; save it as an 8-bit PNG")


def read_depth(path: str | Path, scale: float | str | DepthUnit | None = None) -> DepthImage:
    """Read a depth map.

    Parameters
    ----------
    path : path-like
        Integer PNG, PGM or TIFF; float TIFF, PFM, EXR or NPY; NPZ with one array or one named
        ``depth``.
    scale : float or str, optional
        Metres per unit, or a name of `geohue.read.images.depth_units.DEPTH_UNITS` such as "tum".
        By default 0.001 for integers and 1 for floats.

    Returns
    -------
    DepthImage
        Zero, negative, infinite and NaN values are NaN, and so is 65535 in 16-bit files.

    Raises
    ------
    GeohueError
        If the file is missing, damaged, cut short or has several channels, or the scale is not
        positive.

    Examples
    --------
    >>> from geohue.results import write_png
    >>> file = getfixture("tmp_path") / "depth.png"
    >>> write_png(file, np.array([[0, 1500]], np.uint16))
    >>> read_depth(file).depth
    array([[nan, 1.5]], dtype=float32)
    """
    unit = None if scale is None else depth_unit(scale)
    readers = {".npy": read_npy, ".npz": read_npz, ".pfm": read_pfm, ".exr": read_exr}
    raw = readers.get(Path(path).suffix.lower(), decode_picture)(path)
    if raw.ndim == 3 and raw.shape[2] == 1:
        raw = raw[..., 0]
    if raw.ndim != 2:
        cause = f"has the shape {raw.shape}, which is a colour picture; a depth map has one channel"
        raise broken(path, f"{cause}: give the raw depth (16-bit PNG), not its coloured rendering")
    if raw.dtype.kind not in "iuf" or raw.size == 0:
        raise broken(path, f"has no depth values ({raw.dtype}, {raw.shape}); export it again")
    if unit is not None and unit.decode is not None:
        raw = _decoded(raw, unit.decode, path)
    used = unit.scale if unit is not None else (1.0 if raw.dtype.kind == "f" else _INTEGER_SCALE)
    depth = _to_metres(raw, used)
    doubts = _doubts(depth, used, path)
    if unit is None and raw.dtype.kind in "iu" and not doubts:
        doubts = _unit_doubts(depth, path)
    return DepthImage(depth, used, doubts)


def _decoded(raw: NDArray[Any], decode: Decoder, path: str | Path) -> NDArray[Any]:
    if raw.dtype.kind != "u" or raw.dtype.itemsize > 2:
        cause = f"holds {raw.dtype} values, but this depth scale is for 16-bit pictures"
        raise broken(path, f"{cause}; give the picture as recorded")
    try:
        return decode(raw.astype(np.uint16))
    except GeohueError as error:
        raise broken(path, f"{error}; choose another depth_scale") from error


def _to_metres(raw: NDArray[Any], scale: float) -> NDArray[np.float32]:
    with np.errstate(all="ignore"):
        depth = (raw * np.float64(scale)).astype(np.float32)
        missing = ~(depth > 0) | ~np.isfinite(depth)
    if raw.dtype == np.uint16:
        missing |= raw == _SATURATED
    depth[missing] = np.nan
    return depth


def _doubts(depth: NDArray[np.float32], scale: float, path: str | Path) -> tuple[str, ...]:
    known = depth[np.isfinite(depth)]
    if known.size == 0:
        return (f"{path}: no pixel has a depth",)
    median = float(np.median(known))
    if _PLAUSIBLE[0] <= median <= _PLAUSIBLE[1]:
        return ()
    cause = f"the median depth is {median:.3g} m with {scale:.6g} m per unit, which is implausible"
    return (f"{path}: {cause}; give the right depth_scale",)


def _unit_doubts(depth: NDArray[np.float32], path: str | Path) -> tuple[str, ...]:
    """Return a warning where millimetres were assumed and few cameras see as far as that gives."""
    far = float(np.nanquantile(depth, 0.98))
    if far <= _FAR:
        return ()
    return (
        f"{path}: depths reach {far:.0f} m if a unit is a millimetre; TUM's files need "
        "depth_scale=tum, SUN RGB-D's sun; give the number of metres if this is right",
    )


def decode_picture(path: str | Path) -> NDArray[Any]:
    """Decode a picture with its own number of channels and type."""
    import cv2

    data = read_bytes(path)
    check_picture(data, path)
    with listened() as lines:
        try:
            pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        except (cv2.error, MemoryError, SystemError):
            pixels = None
    if pixels is None or pixels.size == 0:
        cause = "is cut short, damaged or not a picture (PNG, JPEG, PPM, BMP, TIFF, WebP)"
        raise broken(path, f"{cause}; export it again")
    if lost := harmful(lines):
        raise broken(path, f"is cut short or damaged ({lost[0]}); copy or export it again")
    return pixels


def read_labels(path: str | Path) -> NDArray[np.int32]:
    """Read a label image.

    Parameters
    ----------
    path : path-like
        PNG or TIFF with one channel of 8 or 16 bits, 0 = no label.

    Returns
    -------
    (H, W) int32
        The values as they are in the file.

    Raises
    ------
    GeohueError
        If the file is missing or damaged, has colours or fractions instead of labels, or values
        that change from pixel to pixel as those of a depth map or a photograph do.
    """
    raw = decode_picture(path)
    if raw.ndim != 2 or raw.dtype.kind not in "iu":
        cause = f"holds {raw.dtype} {raw.shape}, no label image"
        raise broken(path, f"{cause}; labels are whole numbers in one channel")
    n_values, n_pieces = _scatter(raw)
    if n_pieces > _SCATTERED * n_values and raw.size < _SMALL * n_pieces:
        raise broken(
            path,
            f"is that a label image? Its {n_values} values lie in {n_pieces} pieces, like those of "
            "a depth map or a photograph; give labels.png",
        )
    return raw.astype(np.int32)


def _scatter(raw: NDArray[Any]) -> tuple[int, int]:
    """Return how many values there are but 0, and in how many connected pieces they lie."""
    from skimage.measure import label

    _, pieces = label(raw, background=0, return_num=True, connectivity=1)
    return len(np.unique(raw[raw != 0])), int(pieces)


def read_written_labels(name: str | Path) -> NDArray[np.int32]:
    """Read what `write_labels` wrote under a name; -1 for none."""
    npy = Path(f"{name}.npy")
    if npy.exists():
        return read_npy(npy).astype(np.int32)
    return read_labels(f"{name}.png") - 1
