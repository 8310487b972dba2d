"""A comparison as one HTML page that needs nothing beside it."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geohue.studies.compare.plate import TITLES, caption
from geohue.studies.compare.views import scaled

if TYPE_CHECKING:
    from geohue.studies.compare import Comparison, Result

SIZE = 480
"""Longer side of a picture, pixels."""

_QUALITY = 88  # of the JPEG files inside

_STYLE = """
:root { color-scheme: light dark; --line: #8886; --gap: #8882; --bad: #d553; }
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 110rem;
  padding: 0 1rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: 1rem 0; }
th { text-align: left; vertical-align: top; padding: .3rem .8rem .3rem 0; }
.plate td { padding: .3rem; vertical-align: top; min-width: 11rem; }
.plate td.undefined { background: var(--gap); padding: .8rem; }
.plate td.failed { background: var(--bad); padding: .8rem; }
img { display: block; max-width: 100%; height: auto; }
figure { margin: 0; }
figcaption { font-size: .85em; }
.inputs { display: flex; flex-wrap: wrap; gap: 1rem; }
.numbers td, .numbers th { border-bottom: 1px solid var(--line); padding: .25rem .8rem; }
.numbers td.number { text-align: right; font-variant-numeric: tabular-nums; }
"""

_COLUMNS = {
    "method": "Method",
    "cues": "Cues",
    "regions": "Regions",
    "time_s": "Time (s)",
    "weight": "Weight",
    "quality": "Q",
    "voi_bits": "VoI (bits)",
    "rand": "RI",
    "reason": "Remark",
}


def page(
    title: str,
    inputs: Mapping[str, NDArray[np.uint8]],
    cells: Mapping[str, NDArray[np.uint8]],
    comparison: Comparison,
) -> str:
    """Return the page of a comparison.

    Parameters
    ----------
    title : str
    inputs, cells : dict of str to (H, W, 3) uint8
        `geohue.studies.compare.views.input_views` and `cell_views`; put into the page.
    comparison : Comparison

    Returns
    -------
    str
        HTML, with no script and nothing loaded from elsewhere.
    """
    name = escape(title)
    notes = "".join(f"<li>{escape(text)}</li>" for text in comparison.warnings)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{name}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n<main>\n"
        f"<h1>{name}</h1>\n<p>{escape(_introduction(comparison))}</p>\n"
        f"{f'<ul>{notes}</ul>' if notes else ''}\n"
        f'<div class="inputs">{"".join(_figure(*item, item[0]) for item in inputs.items())}</div>\n'
        f'<div class="wide">{_plate(cells, comparison)}</div>\n'
        f"<h2>Figures</h2>\n<p>{escape(_reading(comparison))}</p>\n"
        f'<div class="wide">{_numbers(comparison)}</div>\n</main>\n</body>\n</html>\n'
    )


def _introduction(comparison: Comparison) -> str:
    origin = "chosen by the proposed method" if comparison.k_chosen else "as given"
    return (
        f"K = {comparison.k}, {origin}, for the methods that are told it; the others find their "
        "own number of regions, and systems with a rule of their own for small regions keep to "
        f'it. Preset "{comparison.preset}", seed {comparison.seed}. A part that '
        "several methods find has one colour, that of the first cell."
    )


def _reading(comparison: Comparison) -> str:
    text = (
        "Q compares segmentations of about as many regions; more regions alone can raise it. Time "
        "is that of the processor, with one thread; what is loaded and compiled is not in it."
    )
    if comparison.scored:
        text += " VoI against the ground truth: lower is better; RI: higher is better."
    return text


def _plate(cells: Mapping[str, NDArray[np.uint8]], comparison: Comparison) -> str:
    head = "".join(f'<th scope="col">{escape(cue)}</th>' for cue in comparison.cues)
    rows = []
    for method in comparison.methods:
        row = "".join(_cell(comparison.at(method, cue), cells) for cue in comparison.cues)
        title = escape(TITLES.get(method, method))
        rows.append(f'<tr><th scope="row">{title}</th>{row}</tr>\n')
    return f'<table class="plate">\n<tr><th></th>{head}</tr>\n{"".join(rows)}</table>'


def _cell(result: Result, cells: Mapping[str, NDArray[np.uint8]]) -> str:
    name = result.cell.name
    if name in cells:
        text = "; ".join(line for line in caption(result) if line)
        return f'<td class="done" id="{name}">{_figure(name, cells[name], text)}</td>'
    text = "not defined" if result.status == "undefined" else "failed"
    return f'<td class="{result.status}" id="{name}">{text}: {escape(result.reason)}</td>'


def _figure(name: str, image: NDArray[np.uint8], text: str) -> str:
    return (
        f'<figure><img alt="{escape(name)}" src="{_inside(image)}">'
        f"<figcaption>{escape(text)}</figcaption></figure>"
    )


def _inside(image: NDArray[np.uint8]) -> str:
    """Return a picture as an address that holds it."""
    import cv2

    pixels = np.ascontiguousarray(scaled(image, SIZE)[..., ::-1])
    _, data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    return "data:image/jpeg;base64," + base64.b64encode(data.tobytes()).decode()


def _numbers(comparison: Comparison) -> str:
    shown = {
        key: title
        for key, title in _COLUMNS.items()
        if comparison.scored or key not in ("voi_bits", "rand")
    }
    head = "".join(f'<th scope="col">{title}</th>' for title in shown.values())
    body = ""
    for result in comparison.results:
        if result.status == "undefined":
            continue
        row = result.row()
        row["reason"] = "; ".join([*([row["reason"]] if row["reason"] else []), *row["warnings"]])
        body += f"<tr>{''.join(_number(row[key]) for key in shown)}</tr>\n"
    return f'<table class="numbers">\n<tr>{head}</tr>\n{body}</table>'


def _number(value: Any) -> str:
    if isinstance(value, str):
        return f"<td>{escape(value)}</td>"
    text = "" if value is None else str(value) if isinstance(value, int) else f"{value:.3f}"
    return f'<td class="number">{text}</td>'
