"""A segmentation as a notebook shows it."""

from __future__ import annotations

import base64
import html

import numpy as np
from numpy.typing import NDArray

from geohue.compute.checks import check_image
from geohue.errors import GeohueError
from geohue.results.picture import overlay, paint, picture
from geohue.segmentation.result import Segmentation

_WIDEST = 640  # pixels of a picture in a notebook


def show(seg: Segmentation, image: NDArray[np.uint8] | None = None) -> NDArray[np.uint8]:
    """Return a picture of the segments: `Segmentation.overlay`."""
    if seg.labels.ndim == 1:
        if seg.scene is None:
            raise GeohueError(
                "the picture of a cloud needs its points, and a segmentation that was loaded has "
                "none: overlay.png in its folder is that picture"
            )
        return picture(seg.scene, seg.labels)
    if image is None:
        return paint(seg.labels) if seg.scene is None else overlay(seg.scene.colors, seg.labels)
    pixels = check_image(image)
    if pixels.shape[:2] != seg.labels.shape:
        raise GeohueError(
            f"the image has shape {pixels.shape[:2]}, the labels {seg.labels.shape}: "
            "give the image that was segmented"
        )
    return overlay(pixels, seg.labels)


def thumbnail(seg: Segmentation) -> bytes | None:
    """Return the picture as PNG, at most 640 pixels wide; None where there is none."""
    import cv2

    try:
        shown = show(seg)
    except GeohueError:
        return None
    height, width = shown.shape[:2]
    if width > _WIDEST:
        size = (_WIDEST, max(1, round(height * _WIDEST / width)))
        shown = np.asarray(cv2.resize(shown, size, interpolation=cv2.INTER_AREA), np.uint8)
    _, data = cv2.imencode(".png", np.ascontiguousarray(shown[..., ::-1]))
    return bytes(data.tobytes())


def as_html(seg: Segmentation) -> str:
    """Return the picture above a table of what was found."""
    data = thumbnail(seg)
    seen = "" if data is None else base64.b64encode(data).decode()
    facts = {
        "segments": seg.in_words(),
        "preset": f"{seg.preset} ({seg.cues}, seed {seg.seed})",
        "labelled": f"{seg.n_labelled} of {seg.n_points}",
        "quality Q": "" if seg.quality is None else f"{seg.quality:.3f}",
        "time": f"{seg.timings.get('total', 0.0):.2f} s",
        "warnings": "; ".join(seg.warnings),
    }
    rows = "".join(
        f"<tr><th>{name}</th><td>{html.escape(text)}</td></tr>"
        for name, text in facts.items()
        if text
    )
    shown = f'<img alt="segments" src="data:image/png;base64,{seen}">' if seen else ""
    return f"<div>{shown}<table>{rows}</table></div>"
