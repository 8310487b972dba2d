"""``geohue evaluate``: labels against reference labels, one frame or a folder of them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from geohue.cli.console import print_json, warn
from geohue.errors import GeohueError

if TYPE_CHECKING:
    from geohue.measures.object_report import ObjectProtocol


def evaluate(
    pred: Annotated[
        Path,
        typer.Argument(
            metavar="PRED", help="Labels of a segmentation, its folder, or a folder of them."
        ),
    ],
    gt: Annotated[Path, typer.Argument(metavar="GT", help="Labels of the reference, or a folder.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print a JSON object.")] = False,
    objects: Annotated[
        bool, typer.Option("--objects", help="Measure objects, too, each with one segment.")
    ] = False,
    background: Annotated[
        str | None,
        typer.Option(metavar="LABELS", help="Labels of GT that are no objects, such as 1 or 0,1."),
    ] = None,
    background_from: Annotated[
        str,
        typer.Option(
            metavar="truth|prediction",
            help="Segments are background where the truth says so, or only where PRED is 0.",
        ),
    ] = "truth",
) -> None:
    """Measure a segmentation against reference labels.

    Both are label images (PNG, 0 = no label), arrays (NPY, -1 = no label) or labelled clouds.
    Pixels without a label in the reference are left out (of the objects' measures not if
    --background has 0). In folders, frames of the same name belong together: NAME.png,
    NAME/labels.png or NAME/labels.npy.
    """
    if pred.is_dir() and not gt.is_dir():
        from geohue.read.results import labels_of

        pred = labels_of(pred)
    if pred.is_dir() != gt.is_dir():
        raise GeohueError(f"{pred} and {gt}: give two label images or two folders")
    protocol = _protocol(objects, background, background_from)
    if pred.is_dir():
        _evaluate_folders(pred, gt, as_json, protocol)
        return
    from geohue.measures import evaluate as measure
    from geohue.read.labels import read_segments

    scores = measure(read_segments(pred), read_segments(gt) + 1, objects=protocol)
    if as_json:
        print_json(scores)
    else:
        _print_scores(scores)


def _protocol(objects: bool, background: str | None, background_from: str) -> ObjectProtocol | None:
    """Read the options of the objects; None if they are not to be measured."""
    if not objects:
        if background is not None or background_from != "truth":
            raise GeohueError("--background and --background-from belong to --objects: add it")
        return None
    from geohue.measures.object_report import ObjectProtocol

    if background_from not in ("truth", "prediction"):
        raise GeohueError(f"--background-from {background_from}: choose among truth, prediction")
    try:
        labels = tuple(int(part) for part in background.split(",")) if background else ()
    except ValueError:
        raise GeohueError(
            f"--background {background}: give labels of the reference with commas, such as 0,1"
        ) from None
    return ObjectProtocol(labels, "truth" if background_from == "truth" else "prediction")


def _evaluate_folders(pred: Path, gt: Path, as_json: bool, protocol: ObjectProtocol | None) -> None:
    from geohue.studies.benchmark.folders import evaluate_folders

    found = evaluate_folders(pred, gt, objects=protocol)
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
        typer.echo(f"{name.replace('_', ' '):26} {value:.4g}")
