"""``geohue evaluate``: labels against reference labels, one frame or a folder of them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from geohue.cli.console import print_json, warn
from geohue.errors import GeohueError


def evaluate(
    pred: Annotated[
        Path, typer.Argument(metavar="PRED", help="labels.png of a segmentation, or a folder.")
    ],
    gt: Annotated[
        Path, typer.Argument(metavar="GT", help="labels.png of the reference, or a folder.")
    ],
    as_json: Annotated[bool, typer.Option("--json", help="Print a JSON object.")] = False,
) -> None:
    """Measure a segmentation against reference labels.

    Both are label images in which 0 means no label; such pixels of the reference are left out.
    In folders, frames of the same name belong together: NAME.png or NAME/labels.png.
    """
    if pred.is_dir() != gt.is_dir():
        raise GeohueError(f"{pred} and {gt}: give two label images or two folders")
    if pred.is_dir():
        _evaluate_folders(pred, gt, as_json)
        return
    from geohue.measures import evaluate as measure
    from geohue.read.images.pictures import read_labels

    scores = measure(read_labels(pred) - 1, read_labels(gt))
    if as_json:
        print_json(scores)
    else:
        _print_scores(scores)


def _evaluate_folders(pred: Path, gt: Path, as_json: bool) -> None:
    from geohue.studies.benchmark.folders import evaluate_folders

    found = evaluate_folders(pred, gt)
    if found["missing"]:
        missing = found["missing"]
        warn([f"{len(missing)} reference frame(s) without a segmentation, such as {missing[0]}"])
    if as_json:
        print_json(found)
        return
    width = max(len(name) for name in found["frames"])
    typer.echo(f"{'frame':{width}}  VoI (bits)    Rand  covering")
    for name, scores in found["frames"].items():
        values = (scores["voi_bits"], scores["rand"], scores["covering"])
        typer.echo(f"{name:{width}}  {values[0]:10.3f}  {values[1]:6.3f}  {values[2]:8.3f}")
    typer.echo(f"\nmean of {len(found['frames'])} frame(s)")
    _print_scores(found["mean"])


def _print_scores(scores: Mapping[str, float]) -> None:
    for name, value in scores.items():
        typer.echo(f"{name.replace('_', ' '):24} {value:.4g}")
