"""A comparison as files: the plate, the page, the tables and the labels."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geohue.results.folder import COMPARISON, whole_folder
from geohue.results.labels import write_labels
from geohue.results.png import write_png
from geohue.scene import Scene
from geohue.studies.compare.page import page

if TYPE_CHECKING:
    from geohue.studies.compare import Comparison

LABELS = "labels"


def write_comparison(
    folder: str | Path,
    scene: Scene,
    comparison: Comparison,
    truth: NDArray[np.integer] | None = None,
    title: str = "Comparison",
    *,
    overwrite: bool = False,
) -> list[Path]:
    """Write a comparison.

    Parameters
    ----------
    folder : str or Path
        Made if it does not exist; an earlier comparison in it is replaced whole.
    scene : Scene
        What was compared.
    comparison : Comparison
        By `geohue.studies.compare.compare`.
    truth : integer, shape of the scene, optional
        True labels, 0 for none.
    title : str
        Of the page.
    overwrite : bool
        Whether to write into a folder that has other files than an earlier comparison.

    Returns
    -------
    list of Path
        ``labels/METHOD-CUES.png`` for each cell that is done (as ``labels.png`` of a segmentation;
        ``.npy`` for a cloud), ``plate.png``, ``compare.html`` with its pictures inside,
        ``compare.csv`` and, last, ``compare.json``.

    Raises
    ------
    GeohueError
        If the folder cannot be written to, or has other files.
    """
    from geohue.studies.compare.plate import arrange
    from geohue.studies.compare.views import cell_views, input_views, reference_of

    inputs = input_views(scene, truth, reference_of(comparison))
    cells = cell_views(scene, comparison)
    with whole_folder(folder, COMPARISON, overwrite=overwrite) as new:
        names = [file.relative_to(new) for file in _write_labels(new / LABELS, comparison)]
        names.append(Path("plate.png"))
        write_png(new / names[-1], arrange(inputs, cells, comparison))
        for name, text in (
            ("compare.html", page(title, inputs, cells, comparison)),
            ("compare.csv", table(comparison)),
            (COMPARISON.mark, json.dumps(comparison.summary(), indent=2) + "\n"),
        ):
            names.append(Path(name))
            (new / name).write_text(text, encoding="utf-8", newline="")
    return [Path(folder) / name for name in names]


def table(comparison: Comparison) -> str:
    """Return the cells as CSV, a line each; what is not known is empty."""
    text = io.StringIO()
    rows = [result.row() for result in comparison.results]
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(row | {"warnings": "; ".join(row["warnings"])} for row in rows)
    return text.getvalue()


def _write_labels(folder: Path, comparison: Comparison) -> list[Path]:
    return [
        write_labels(folder / result.cell.name, result.labels)
        for result in comparison.results
        if result.labels is not None
    ]
