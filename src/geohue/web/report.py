"""A segmentation as one HTML page that needs nothing beside it."""

from __future__ import annotations

import base64
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.results.picture import overlay, paint, palette, picture
from geohue.web.taken import Taken

_SIZE = 900  # longer side of a picture, pixels
_QUALITY = 88  # of the JPEG files inside

_STYLE = """
:root { color-scheme: light dark; --line: #8886; }
body { font: 16px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 70rem;
  padding: 0 1rem; }
img { display: block; max-width: 100%; height: auto; }
figure { margin: 0; flex: 1 1 20rem; }
.pictures { display: flex; flex-wrap: wrap; gap: 1rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: 1rem 0; }
th, td { border-bottom: 1px solid var(--line); padding: .25rem .8rem .25rem 0; text-align: left; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
"""


def report(what: Taken) -> str:
    """Return the page: pictures, the table of segments, and how they were found.

    Parameters
    ----------
    what : Taken

    Returns
    -------
    str
        HTML with no script and nothing loaded from elsewhere.
    """
    summary = what.seg.summary()
    notes = "".join(f"<li>{escape(text)}</li>" for text in summary["warnings"])
    rows = what.table
    figures = "".join(_figure(title, image) for title, image in _pictures(what).items())
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{len(rows)} segments</title>\n<style>{_STYLE}{_swatches(rows)}</style>\n"
        f"</head>\n<body>\n<main>\n<h1>{len(rows)} segments</h1>\n"
        f'<div class="pictures">{figures}</div>\n'
        f"{f'<h2>Remarks</h2><ul>{notes}</ul>' if notes else ''}\n"
        f'<h2>Segments</h2><div class="wide">{_segments(rows)}</div>\n'
        f'<h2>How they were found</h2><div class="wide">{_facts(summary)}</div>\n'
        "</main>\n</body>\n</html>\n"
    )


def _pictures(what: Taken) -> dict[str, NDArray[np.uint8]]:
    scene, labels = what.scene, what.labels
    if not scene.is_grid:
        return {"The cloud, and its segments": picture(scene, labels)}
    shown = {"Colour": scene.colors, "Segments": overlay(scene.colors, labels)}
    return shown | {"Labels": paint(labels)}


def _figure(title: str, image: NDArray[np.uint8]) -> str:
    import cv2

    scale = _SIZE / max(image.shape[:2])
    if scale < 1:
        size = (round(image.shape[1] * scale), round(image.shape[0] * scale))
        image = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)
    _, data = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    text = base64.b64encode(data.tobytes()).decode()
    height, width = image.shape[:2]
    return (
        f'<figure><img alt="{escape(title)}" width="{width}" height="{height}" '
        f'src="data:image/jpeg;base64,{text}"><figcaption>{escape(title)}</figcaption></figure>'
    )


def _swatches(rows: list[dict[str, Any]]) -> str:
    colors = palette(max((row["label"] for row in rows), default=0) + 1)
    used = ((row["label"], colors[row["label"]].tobytes().hex()) for row in rows)
    return "".join(f".s{label}::before{{content:'\\25A0 ';color:#{hue}}}" for label, hue in used)


def _segments(rows: list[dict[str, Any]]) -> str:
    head = "".join(f"<th>{name}</th>" for name in ("Segment", "Size", "Mean colour", "Extent"))
    body = "".join(_row(row) for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>"


def _row(row: dict[str, Any]) -> str:
    name = row["name"] or f"segment {row['label'] + 1}"
    color = " ".join(f"{c:.0f}" for c in row["mean_color"])
    return (
        f'<tr><td class="s{row["label"]}">{escape(name)}</td><td class="number">{row["size"]}</td>'
        f"<td>{color}</td><td>{_extent(row)}</td></tr>"
    )


def _extent(row: dict[str, Any]) -> str:
    if "minimum" not in row:
        return "no geometry"
    sides = zip(row["minimum"], row["maximum"], strict=True)
    return " x ".join(f"{high - low:.3g}" for low, high in sides)


def _facts(summary: dict[str, Any]) -> str:
    shown = ("preset", "method", "cues", "seed", "weight", "quality", "n_points", "version")
    named = ((name.replace("_", " "), escape(_value(summary[name]))) for name in shown)
    rows = "".join(f"<tr><th>{name}</th><td>{value}</td></tr>" for name, value in named)
    return f"<table>{rows}</table>"


def _value(value: object) -> str:
    if value is None:
        return "none"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
