"""A run as pictures: box plots, how many regions, the best and the worst frames."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.jobs.ledger import Row
from geohue.measures.crop import Crop
from geohue.read.images.pictures import read_written_labels
from geohue.results.atomic import atomic_write
from geohue.results.picture import overlay
from geohue.results.png import write_png
from geohue.studies.benchmark.frames import load_frame
from geohue.studies.benchmark.run import LABELS
from geohue.studies.benchmark.summary import by_trial, column
from geohue.studies.benchmark.trials import Trial
from geohue.studies.items import Item

PLOTTED = {"voi_bits": "VoI (bits, lower is better)", "rand": "Rand index (higher is better)"}

EXTREMES = 3
"""Best and worst frames shown of each trial."""


def draw_run(
    out: str | Path, rows: Sequence[Row], frames: Sequence[Item], crop: Crop | None
) -> list[Path]:
    """Draw a run into its folder.

    Parameters
    ----------
    out : str or Path
        The folder of the run, with its labels.
    rows : sequence of dict
        Of ``frames.csv``.
    frames : sequence of Item
        For the pictures of the best and the worst.
    crop : (top, bottom, left, right), optional
        As in the run.

    Returns
    -------
    list of Path
        ``boxes.png``, ``regions.png`` and, for each trial, ``best-worst-*.png``: a row a frame,
        image, truth and segments. None if every frame failed.
    """
    target = Path(out)
    groups = {
        " ".join(p for p in trial if p != "-"): [row for row in group if not row["error"]]
        for trial, group in by_trial(rows).items()
    }
    groups = {name: group for name, group in groups.items() if group}
    if not groups:
        return []
    files = [target / "boxes.png", target / "regions.png"]
    _draw_boxes(files[0], groups)
    _draw_regions(files[1], groups)
    named = {frame.name: frame for frame in frames}
    for group in groups.values():
        ordered = sorted(group, key=lambda row: (float(row["voi_bits"]), row["frame"]))
        shown = _ends([row for row in ordered if row["frame"] in named])
        if shown:
            files.append(target / f"best-worst-{_trial(shown[0]).name}.png")
            strips = [_strip(target, row, named[row["frame"]], crop) for row in shown]
            write_png(files[-1], _stacked(strips))
    return files


def _trial(row: Row) -> Trial:
    return Trial(row["method"], row["cues"], row["preset"])


def _ends(rows: list[Row]) -> list[Row]:
    """Return the first and the last few rows, each once."""
    return rows if len(rows) <= 2 * EXTREMES else rows[:EXTREMES] + rows[-EXTREMES:]


def _figure(width: float, height: float, rows: int = 1, columns: int = 1) -> tuple[Any, Any]:
    # The object interface, without pyplot: no display, no global state.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, squeeze=False)


def _draw_boxes(path: Path, groups: dict[str, list[Row]]) -> None:
    figure, axes = _figure(2.4 + 0.55 * len(groups), 9, len(PLOTTED), 1)
    for axis, (measure, title) in zip(axes[:, 0], PLOTTED.items(), strict=True):
        axis.boxplot([column(group, measure) for group in groups.values()], showmeans=True)
        axis.set_xticks(range(1, len(groups) + 1), list(groups), rotation=40, ha="right")
        axis.set_title(title)
        axis.grid(axis="y", alpha=0.3)
    _save(figure, path)


def _draw_regions(path: Path, groups: dict[str, list[Row]]) -> None:
    figure, axes = _figure(6, 1.2 + 1.3 * len(groups), len(groups), 1)
    for axis, (name, group) in zip(axes[:, 0], groups.items(), strict=True):
        found, true = column(group, "n_pred"), column(group, "n_gt")
        edges = np.histogram_bin_edges(np.concatenate([found, true]), 24)
        axis.hist([found, true], edges, label=["found", "true"], color=["#0072B2", "#E69F00"])
        axis.set_title(name, fontsize=9)
        axis.set_ylabel("frames")
    axes[0, 0].legend()
    axes[-1, 0].set_xlabel("regions in the compared pixels")
    _save(figure, path)


def _save(figure: Any, path: Path) -> None:
    with atomic_write(path) as temporary:
        figure.savefig(temporary, format="png")


def _strip(out: Path, row: Row, frame: Item, crop: Crop | None) -> NDArray[np.uint8]:
    """Return image, truth and segments of a frame beside each other, with the score on top."""
    import cv2

    scene, truth = load_frame(frame, crop)
    labels = read_written_labels(out / LABELS / _trial(row).name / frame.name)
    shown = [scene.colors, overlay(scene.colors, truth - 1), overlay(scene.colors, labels)]
    strip = np.ascontiguousarray(np.hstack(shown)[::2, ::2])
    text = f"{frame.name}  VoI {float(row['voi_bits']):.2f}  K {row['n_pred']} of {row['n_gt']}"
    strip[:20] //= 4
    cv2.putText(strip, text, (6, 15), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (255, 255, 255), 1)
    return strip


def _stacked(strips: list[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """Stack pictures of any widths."""
    width = max(strip.shape[1] for strip in strips)
    padded = [np.pad(s, ((0, 4), (0, width - s.shape[1]), (0, 0))) for s in strips]
    return np.vstack(padded)
